//! Pass `guided`: for a point of the cloud, every mirror pixel that shows it. Charts that cannot show it are passed over,
//! eight points at a time; in the others Gauss-Newton steps start where the chart reflects in the point's direction, or, on
//! bowls and saddles, in every tile whose beam may show it.

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use wide::f32x8;

use super::beam::{Beam, Points8};
use super::beam_tree::{LEAF, Start, Walk};
use super::charts::{Chart, DirectionMap, Seeds};
use super::field::MirrorField;
use super::newton::{NewtonRoot, Within, first_steps, newton, take_step};
use super::root_find::SearchCounts;
use crate::cloud::{Place, Surfels};
use crate::error::Result;
use crate::job::Job;
use crate::reflect::Hit;

/// Places nearer to each other than this are one, pixels.
pub const SAME_ROOT: f32 = 0.3;

/// Points that are culled together.
const GROUP: usize = 8;

/// Groups a task.
const CHUNK: usize = 16;

/// How much farther splats reach beside the mirror's outline, pixels: its outermost pixels' rays turn away faster than the
/// slopes within it tell. Which pixels a splat covers is decided by their own rays.
pub const END_REACH: f32 = 1.0;

/// How far from where it starts in a tile a search may go, pixels: half the tile, and one beyond.
pub const STAY: f32 = 1.5 * LEAF as f32;

/// The mirrors in which points are searched, and how.
#[derive(Debug, Clone, Copy)]
pub struct Guide<'a> {
    /// The mirrors.
    pub field: &'a MirrorField,
    /// Their charts.
    pub charts: &'a [Chart],
    /// Mirrors leave out mirror points nearer than this: their own; x spacing.
    pub self_hit: f32,
    /// Half width of a surfel's disc over its radius.
    pub splat_size: f32,
}

/// A thread's working memory.
#[derive(Default)]
struct Work {
    walk: Walk,
    roots: [Vec<NewtonRoot>; GROUP],
}

impl Guide<'_> {
    /// Every place where the mirrors show each of up to eight points; the steps that it took.
    fn find_eight(&self, positions: &[Vec3], work: &mut Work) -> u64 {
        let points = Points8::new(positions);
        let all = (1 << positions.len()) - 1;
        let mut taken = 0;
        let Work { walk, roots } = work;
        for roots in roots.iter_mut() {
            roots.clear();
        }
        for chart in self.charts {
            let mask = chart.beam.may_show(&points) & all;
            if mask == 0 {
                continue;
            }
            match &chart.seeds {
                Seeds::Map(map) => {
                    for lane in lanes(mask) {
                        let (root, steps) =
                            by_direction(self.field, &chart.beam, map, positions[lane]);
                        taken += u64::from(steps);
                        if let Some(root) = root {
                            keep(root, &mut roots[lane]);
                        }
                    }
                }
                Seeds::Tree(tree) => tree.visit(&points, mask, walk, |start, mask| {
                    taken += in_tile(self.field, start, &points, positions, mask, |lane, root| {
                        keep(root, &mut roots[lane]);
                    });
                }),
            }
        }
        taken
    }

    /// Every place where the mirrors show a point.
    pub fn find(&self, point: Vec3) -> Vec<NewtonRoot> {
        let mut work = Work::default();
        self.find_eight(&[point], &mut work);
        std::mem::take(&mut work.roots[0])
    }

    /// Searches for the points `order` of a cloud, on all cores. The hits are in that order, the same for any number of
    /// threads.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub fn search(
        &self,
        surfels: &Surfels,
        order: &[u32],
        job: &Job,
    ) -> Result<(Vec<Hit>, SearchCounts)> {
        let chunks: Vec<(Vec<Hit>, SearchCounts)> = order
            .par_chunks(GROUP * CHUNK)
            .map_init(Work::default, |work, chunk| {
                job.check()?;
                let (mut hits, mut counts) = (Vec::new(), SearchCounts::default());
                for group in chunk.chunks(GROUP) {
                    let mut positions = [Vec3::NAN; GROUP];
                    for (position, &index) in positions.iter_mut().zip(group) {
                        *position = surfels
                            .places
                            .get(index as usize)
                            .map_or(Vec3::NAN, |p| p.position);
                    }
                    counts.steps += self.find_eight(&positions[..group.len()], work);
                    counts.offered += group.len() as u64;
                    for (&index, roots) in group.iter().zip(&mut work.roots) {
                        let finish = surfels.finishes.get(index as usize);
                        if finish.is_some_and(|f| f.mirror() > 0.0) {
                            roots.retain(|r| r.distance >= self.self_hit * r.spacing);
                        }
                        counts.hit += u64::from(!roots.is_empty());
                        counts.hits += roots.len() as u64;
                        let radius = surfels.places.get(index as usize).map_or(0.0, |p| p.radius);
                        hits.extend(roots.iter().map(|root| Hit {
                            point: index,
                            pixel: self.field.pixel_of_place(root.at),
                            distance: root.distance,
                            reach: root.magnification * (radius * self.splat_size)
                                + if root.at_end { END_REACH } else { 0.0 },
                        }));
                    }
                }
                Ok((hits, counts))
            })
            .collect::<Result<_>>()?;
        let mut all = Vec::with_capacity(chunks.iter().map(|(hits, _)| hits.len()).sum());
        let mut counts = SearchCounts::default();
        for (hits, part) in chunks {
            all.extend(hits);
            counts += part;
        }
        Ok((all, counts))
    }
}

/// Points on which shortcuts are tried.
pub const TRIED: usize = 2048;

/// Places of the tried points that must be known before a shortcut is judged.
const LEAST_TRIED: u32 = 24;

/// Share of a tree's places that a map must find.
const FOUND_BY_MAP: f32 = 0.985;

/// Lets charts go without their trees where the direction maps alone find what the trees do, as the points `sample` tell.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn shorten(
    charts: &mut [Chart],
    field: &MirrorField,
    places: &[Place],
    sample: &[u32],
    job: &Job,
) -> Result<()> {
    let positions: Vec<Vec3> = (sample.iter().take(TRIED))
        .filter_map(|&index| places.get(index as usize).map(|p| p.position))
        .collect();
    charts.par_iter_mut().try_for_each(|chart| {
        job.check()?;
        let (Some(map), Seeds::Tree(tree)) = (&chart.shortcut, &chart.seeds) else {
            return Ok(());
        };
        let (mut by_tree, mut by_map) = (0u32, 0u32);
        let mut walk = Walk::default();
        for group in positions.chunks(GROUP) {
            let points = Points8::new(group);
            let mut roots: [Vec<NewtonRoot>; GROUP] = Default::default();
            let all = (1 << group.len()) - 1;
            tree.visit(&points, all, &mut walk, |start, mask| {
                in_tile(field, start, &points, group, mask, |lane, root| {
                    keep(root, &mut roots[lane]);
                });
            });
            for (lane, roots) in roots.iter().enumerate().filter(|(_, r)| !r.is_empty()) {
                by_tree += roots.len() as u32;
                let (root, _) = by_direction(field, &chart.beam, map, group[lane]);
                let same = |r: &NewtonRoot| {
                    root.is_some_and(|root| root.at.distance_squared(r.at) < SAME_ROOT * SAME_ROOT)
                };
                by_map += u32::from(roots.iter().any(same));
            }
        }
        let enough = by_map as f32 >= FOUND_BY_MAP * by_tree as f32;
        match chart.shortcut.take() {
            Some(map) if by_tree >= LEAST_TRIED && enough => chart.seeds = Seeds::Map(map),
            Some(_) | None => {}
        }
        Ok(())
    })
}

/// A search from where a chart reflects in the direction of the point.
#[inline]
fn by_direction(
    field: &MirrorField,
    beam: &Beam,
    map: &DirectionMap,
    point: Vec3,
) -> (Option<NewtonRoot>, u32) {
    // The chart is not one point: a second look, from where the first says that the ray leaves.
    let first = map.place(point - beam.centre);
    let near = field.sample(first).map_or(beam.centre, |s| s.point);
    let start = map.place(point - near);
    match field.sample(start) {
        Some(sample) => newton(field, (start, sample), point, Within::ANYWHERE),
        None => (None, 0),
    }
}

/// Searches a tile for those of eight points whose bits are set: calls `found(lane, root)`, and returns the steps taken.
#[inline]
fn in_tile(
    field: &MirrorField,
    start: &Start,
    points: &Points8,
    positions: &[Vec3],
    mask: u32,
    mut found: impl FnMut(usize, NewtonRoot),
) -> u64 {
    let within = Within {
        centre: start.at,
        reach: STAY,
    };
    // Most first steps lead out of the tile: they are made together.
    let [x, y] = first_steps(&start.sample, points);
    let reach = f32x8::splat(STAY);
    let stays = (x.abs().simd_le(reach) & y.abs().simd_le(reach)).to_bitmask();
    let (x, y) = (x.to_array(), y.to_array());
    let mut taken = u64::from(mask.count_ones());
    for lane in lanes(mask & stays) {
        let step = Vec2::new(x[lane], y[lane]);
        if let Some(next) = take_step(field, start.at, step) {
            let (root, steps) = newton(field, next, positions[lane], within);
            taken += u64::from(steps);
            if let Some(root) = root {
                found(lane, root);
            }
        }
    }
    taken
}

/// Keeps a root that is not yet known.
#[inline]
fn keep(root: NewtonRoot, roots: &mut Vec<NewtonRoot>) {
    let known = |r: &NewtonRoot| r.at.distance_squared(root.at) < SAME_ROOT * SAME_ROOT;
    if !roots.iter().any(known) {
        roots.push(root);
    }
}

/// The numbers of the bits that are set.
fn lanes(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros() as usize;
        (mask != 0).then(|| {
            mask &= mask - 1;
            lane
        })
    })
}
