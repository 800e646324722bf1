//! The three passes over a picture on the CPU: surfels sorted into tiles, then tile by tile on all cores.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use glam::UVec2;
use rayon::prelude::*;

use super::average::average;
use super::depth::depth;
use super::disc::{Disc, PixelRect, loose_bounds};
use super::tile::Tile;
use super::tiles::Tiles;
use super::visibility::{Sums, visibility};
use super::{EMPTY, GBuffer, SplatSettings};
use crate::backend::cpu::Cpu;
use crate::camera::Pinhole;
use crate::cloud::{Finish, Place, Surfels};
use crate::error::Result;
use crate::grid::Grid;
use crate::job::Job;
use crate::timing::Timings;

/// Splats on the CPU. Keeps its working memory between frames.
#[derive(Debug, Default)]
pub struct Splatter {
    tiles: Tiles,
}

/// What passes `depth` and `visibility` leave, for comparing backends.
#[derive(Debug, Clone, PartialEq)]
pub struct Accumulated {
    /// Depth keys.
    pub keys: Grid<u32>,
    /// Fragments per pixel.
    pub counts: Grid<u32>,
    /// Sums per pixel.
    pub sums: Grid<Sums>,
}

/// Thread time spent in each pass of the tiles, nanoseconds.
#[derive(Default)]
struct Spent {
    depth: AtomicU64,
    visibility: AtomicU64,
    average: AtomicU64,
}

fn spend<R>(spent: &AtomicU64, work: impl FnOnce() -> R) -> R {
    let start = Instant::now();
    let result = work();
    spent.fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
    result
}

/// What is splatted, and how it is seen.
#[derive(Clone, Copy)]
struct View<'a> {
    surfels: &'a Surfels,
    pinhole: &'a Pinhole,
    settings: &'a SplatSettings,
    job: &'a Job,
}

/// A thread's working memory.
#[derive(Default)]
struct Work {
    tile: Tile,
    fetched: Vec<(Place, Finish)>,
    discs: Vec<Disc>,
}

impl Splatter {
    /// All three passes: the surfels as seen through a pinhole.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub fn splat(
        &mut self,
        surfels: &Surfels,
        pinhole: &Pinhole,
        settings: &SplatSettings,
        timings: &mut Timings,
        job: &Job,
    ) -> Result<GBuffer<Cpu>> {
        let mut gbuffer = GBuffer::empty(*pinhole);
        let view = View {
            surfels,
            pinhole,
            settings,
            job,
        };
        timings.time("sort", || self.sort(view));
        let (spent, start) = (Spent::default(), Instant::now());
        let (strip, width) = self.strip(pinhole.size);
        let strips = (
            gbuffer.surface.values_mut().par_chunks_mut(strip),
            gbuffer.albedo.values_mut().par_chunks_mut(strip),
            gbuffer.material.values_mut().par_chunks_mut(strip),
        );
        self.for_each_tile(
            view,
            strips.into_par_iter(),
            |tile, discs, (surface, albedo, material)| {
                tile.expect_sums();
                spend(&spent.depth, || depth::<true>(tile, discs, pinhole));
                spend(&spent.visibility, || visibility(tile, discs, pinhole));
                spend(&spent.average, || {
                    for (first, values) in tile.rows(width) {
                        for (pixel, value) in (first..).zip(values) {
                            let seen = average(tile.keys[value], &tile.sums[value]);
                            surface[pixel] = seen.surface;
                            albedo[pixel] = seen.albedo;
                            material[pixel] = seen.material;
                        }
                    }
                });
            },
        );
        share(timings, start.elapsed(), &spent);
        job.check()?;
        Ok(gbuffer)
    }

    /// Pass `depth` alone: the key of every pixel.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub fn depth_keys(
        &mut self,
        surfels: &Surfels,
        pinhole: &Pinhole,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<Grid<u32>> {
        let view = View {
            surfels,
            pinhole,
            settings,
            job,
        };
        let mut keys = Grid::new(pinhole.size, EMPTY);
        self.sort(view);
        let (strip, width) = self.strip(pinhole.size);
        self.for_each_tile(
            view,
            keys.values_mut().par_chunks_mut(strip),
            |tile, discs, keys| {
                depth::<false>(tile, discs, pinhole);
                for (first, values) in tile.rows(width) {
                    keys[first..first + values.len()].copy_from_slice(&tile.keys[values]);
                }
            },
        );
        job.check()?;
        Ok(keys)
    }

    /// Passes `depth` and `visibility`, without averaging: for comparing backends.
    pub fn accumulate(
        &mut self,
        surfels: &Surfels,
        pinhole: &Pinhole,
        settings: &SplatSettings,
    ) -> Accumulated {
        let view = View {
            surfels,
            pinhole,
            settings,
            job: &Job::default(),
        };
        let mut all = Accumulated {
            keys: Grid::new(pinhole.size, EMPTY),
            counts: Grid::new(pinhole.size, 0),
            sums: Grid::new(pinhole.size, Sums::default()),
        };
        self.sort(view);
        let (strip, width) = self.strip(pinhole.size);
        let strips = (
            all.keys.values_mut().par_chunks_mut(strip),
            all.counts.values_mut().par_chunks_mut(strip),
            all.sums.values_mut().par_chunks_mut(strip),
        );
        self.for_each_tile(
            view,
            strips.into_par_iter(),
            |tile, discs, (keys, counts, sums)| {
                tile.expect_sums();
                depth::<true>(tile, discs, pinhole);
                visibility(tile, discs, pinhole);
                for (first, values) in tile.rows(width) {
                    let row = first..first + values.len();
                    keys[row.clone()].copy_from_slice(&tile.keys[values.clone()]);
                    counts[row.clone()].copy_from_slice(&tile.counts[values.clone()]);
                    sums[row].copy_from_slice(&tile.sums[values]);
                }
            },
        );
        all
    }

    fn sort(&mut self, view: View<'_>) {
        let View {
            surfels,
            pinhole,
            settings,
            job,
        } = view;
        self.tiles.sort(pinhole.size, surfels.len(), |i| {
            let wanted = !job.is_cancelled();
            wanted
                .then(|| loose_bounds(&surfels.places[i], pinhole, settings))
                .flatten()
        });
    }

    /// Pixels in a strip (one row of tiles), and in a row.
    fn strip(&self, size: UVec2) -> (usize, usize) {
        (size.x as usize * self.tiles.side as usize, size.x as usize)
    }

    /// Runs `passes(tile, its discs, its strip of the outputs)` for every tile, on all cores; once the job is cancelled, for
    /// no further one.
    fn for_each_tile<O: Send>(
        &self,
        view: View<'_>,
        strips: impl IndexedParallelIterator<Item = O>,
        passes: impl Fn(&mut Tile, &[Disc], &mut O) + Sync,
    ) {
        let View {
            surfels,
            pinhole,
            settings,
            job,
        } = view;
        let (tiles, side) = (&self.tiles, self.tiles.side);
        strips
            .enumerate()
            .for_each_init(Work::default, |work, (row, mut outputs)| {
                for column in 0..tiles.count.x {
                    if job.is_cancelled() {
                        return;
                    }
                    let (x0, y0) = (column * side, row as u32 * side);
                    let (x1, y1) = (
                        (x0 + side).min(pinhole.size.x),
                        (y0 + side).min(pinhole.size.y),
                    );
                    // Fetched in a loop of its own, the scattered surfels come in many at a time.
                    let entries = tiles.entries(row * tiles.count.x as usize + column as usize);
                    work.fetched.clear();
                    work.fetched.extend(
                        entries.map(|i| (surfels.places[i as usize], surfels.finishes[i as usize])),
                    );
                    work.discs.clear();
                    work.discs.extend(
                        work.fetched.iter().filter_map(|(place, finish)| {
                            Disc::new(place, finish, pinhole, settings)
                        }),
                    );
                    work.tile.reset(PixelRect { x0, y0, x1, y1 });
                    passes(&mut work.tile, &work.discs, &mut outputs);
                }
            });
    }
}

/// Attributes the wall time of the tiles to the passes, by the thread time that each took.
fn share(timings: &mut Timings, wall: Duration, spent: &Spent) {
    let spent = [
        ("depth", &spent.depth),
        ("visibility", &spent.visibility),
        ("average", &spent.average),
    ]
    .map(|(name, ns)| (name, ns.load(Ordering::Relaxed) as f64));
    let total: f64 = spent.iter().map(|(_, ns)| ns).sum();
    for (name, ns) in spent {
        timings.add(
            name,
            wall.mul_f64(if total > 0.0 { ns / total } else { 0.0 }),
        );
    }
}
