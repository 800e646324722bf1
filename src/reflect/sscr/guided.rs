//! Pass `guided`: for a point of the cloud, every mirror pixel that shows it. Charts that cannot show it are passed over,
//! eight points at a time; in the others Gauss-Newton steps start where the chart reflects in the point's direction, or, on
//! bowls and saddles, in every tile whose beam may show it.

use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use wide::f32x8;

use super::beam::{Beam, Points8};
use super::beam_tree::{LEAF, Start, Walk};
use super::charts::{Chart, DirectionMap, Seeds};
use super::field::{MirrorField, lanes};
use super::newton::{NewtonRoot, Searches, step, take_step};
use super::root_find::SearchCounts;
use crate::cloud::{Surfels, require_memory};
use crate::error::Result;
use crate::job::Job;
use crate::reflect::Hit;

/// Places nearer to each other than this are one, pixels.
pub const SAME_ROOT: f32 = 0.3;

/// Points that are culled together.
const GROUP: usize = 8;

/// Points a task: a multiple of the above.
pub(super) const CHUNK: usize = 128;

/// Hits after which the memory for more is reckoned.
const RECKONED: u64 = 1 << 22;

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
pub(super) struct Work {
    walk: Walk,
    searches: Searches,
    /// The places of each point.
    pub(super) roots: Vec<Vec<NewtonRoot>>,
}

impl Work {
    /// Every place where charts show each of these points, in `roots`; the steps that it took.
    pub(super) fn find<'a>(
        &mut self,
        field: &MirrorField,
        charts: impl Iterator<Item = (&'a Beam, &'a Seeds)> + Clone,
        positions: &[Vec3],
    ) -> u64 {
        let Self {
            walk,
            searches,
            roots,
        } = self;
        roots.iter_mut().for_each(Vec::clear);
        roots.resize_with(positions.len().max(roots.len()), Vec::new);
        let (mut tried, mut taken) = (0, 0);
        for (first, group) in (0..).step_by(GROUP).zip(positions.chunks(GROUP)) {
            let points = Points8::new(group);
            let all = (1 << group.len()) - 1;
            let mut search = |lane: usize, at: Vec2, within: (Vec2, f32)| {
                searches.push((first + lane) as u32, group[lane], at, within);
                if searches.is_full() {
                    taken += searches.run(field, |point, root| keep(root, point, roots));
                }
            };
            for (beam, seeds) in charts.clone() {
                let mask = beam.may_show(&points) & all;
                if mask == 0 {
                    continue;
                }
                match seeds {
                    Seeds::Map(map) => by_direction(field, beam, map, &points, mask, &mut search),
                    Seeds::Tree(tree) => tree.visit(&points, mask, walk, |start, mask| {
                        tried += u64::from(mask.count_ones());
                        in_tile(field, start, &points, mask, &mut search);
                    }),
                }
            }
        }
        taken += searches.run(field, |point, root| keep(root, point, roots));
        tried + taken
    }
}

impl Guide<'_> {
    fn find_all(&self, positions: &[Vec3], work: &mut Work) -> u64 {
        let charts = self.charts.iter().map(|c| (&c.beam, &c.seeds));
        work.find(self.field, charts, positions)
    }

    /// Every place where the mirrors show a point.
    pub fn find(&self, point: Vec3) -> Vec<NewtonRoot> {
        let mut work = Work::default();
        self.find_all(&[point], &mut work);
        work.roots.pop().unwrap_or_default()
    }

    /// Searches for the points `order` of a cloud, on all cores. The hits are in that order, the same for any number of
    /// threads.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] where there are more hits than fit, [`crate::Error::Cancelled`].
    pub fn search(
        &self,
        surfels: &Surfels,
        order: &[u32],
        job: &Job,
    ) -> Result<(Vec<Hit>, SearchCounts)> {
        let listed = AtomicU64::new(0);
        let chunks: Vec<(Vec<Hit>, SearchCounts)> = order
            .par_chunks(CHUNK)
            .map_init(Work::default, |work, chunk| {
                job.check()?;
                let mut positions = [Vec3::NAN; CHUNK];
                for (position, &index) in positions.iter_mut().zip(chunk) {
                    if let Some(place) = surfels.places.get(index as usize) {
                        *position = place.position;
                    }
                }
                let mut counts = SearchCounts {
                    offered: chunk.len() as u64,
                    steps: self.find_all(&positions[..chunk.len()], work),
                    ..SearchCounts::default()
                };
                let mut hits = Vec::with_capacity(work.roots.iter().map(Vec::len).sum());
                let found = chunk.iter().zip(&mut work.roots);
                for (&index, roots) in found.filter(|(_, roots)| !roots.is_empty()) {
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
                let (before, more) = (listed.fetch_add(counts.hits, Relaxed), counts.hits);
                if before / RECKONED != (before + more) / RECKONED {
                    // What is listed already is no longer free; it is listed once more in the end.
                    let bytes = (before + more + RECKONED) * size_of::<Hit>() as u64;
                    require_memory("the hits of the search", bytes)?;
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

/// Calls `search(lane, start, bounds)` for those of eight points whose bits are set: from where a chart reflects in the
/// point's direction.
#[inline(always)]
fn by_direction(
    field: &MirrorField,
    beam: &Beam,
    map: &DirectionMap,
    points: &Points8,
    mask: u32,
    search: &mut impl FnMut(usize, Vec2, (Vec2, f32)),
) {
    // The chart is not one point: a second look, from where the first says that the ray leaves.
    let first = map.places_towards(points.seen_from(&[beam.centre; 8]));
    let mut near = [beam.centre; 8];
    for lane in lanes(mask) {
        near[lane] = field.point_near(first(lane)).unwrap_or(beam.centre);
    }
    let second = map.places_towards(points.seen_from(&near));
    for lane in lanes(mask) {
        let start = second(lane);
        if field.contains(start) {
            search(lane, start, (Vec2::ZERO, f32::INFINITY));
        }
    }
}

/// Calls `search(lane, start, bounds)` for those of eight points whose bits are set and whose first step from a tile's start
/// stays about the tile.
#[inline(always)]
fn in_tile(
    field: &MirrorField,
    start: &Start,
    points: &Points8,
    mask: u32,
    search: &mut impl FnMut(usize, Vec2, (Vec2, f32)),
) {
    // Most first steps lead out of the tile.
    let [x, y] = step::<f32x8, false>(&start.sample.splat(), points.xyz).step;
    let reach = f32x8::splat(STAY);
    let stays = (x.abs().simd_le(reach) & y.abs().simd_le(reach)).to_bitmask();
    for lane in lanes(mask & stays) {
        let step = Vec2::new(x.as_array()[lane], y.as_array()[lane]);
        if let Some(next) = take_step(field, start.at, step) {
            search(lane, next, (start.at, STAY));
        }
    }
}

/// Keeps a root of a point that is not yet known.
#[inline]
fn keep(root: NewtonRoot, point: u32, roots: &mut [Vec<NewtonRoot>]) {
    let known = |r: &NewtonRoot| r.at.distance_squared(root.at) < SAME_ROOT * SAME_ROOT;
    if let Some(roots) = roots.get_mut(point as usize)
        && !roots.iter().any(known)
    {
        roots.push(root);
    }
}
