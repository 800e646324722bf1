//! Pass `ism`: imperfect shadow maps, one of the half space over every virtual point light [Ritschel et al. 2008]. CPU twin of
//! `shaders/ism.wgsl`.
//!
//! Each map is a paraboloid: the unit direction (x, y, z), z along the normal, falls on (x, y) / (1 + z), which keeps shapes.
//! It shows a slice of the shuffled cloud as oriented discs, each as much larger as the slice is thinner. A texel keeps the
//! distance and the surfel of the nearest disc as one integer. Texels that no disc covers stay empty and count as lit.

use glam::{UVec2, Vec3};
use rayon::prelude::*;

use super::vpl::Vpl;
use crate::backend::Backend;
use crate::backend::cpu::Cpu;
use crate::cloud::{Finish, Place, Surfels};
use crate::error::Result;
use crate::gbuffer::EMPTY;
use crate::gbuffer::disc::{EDGE_ON_COSINE_SQUARED, MIN_HALF_WIDTH};
use crate::grid::Grid;
use crate::job::Job;

/// Half width of a disc over the spacing of the slice. At 0.7 random points fill three quarters of a map; more grows what
/// casts shadows, less leaves more holes, through which light leaks.
pub const DISC: f32 = 0.7;

/// Bounds of a disc in a map, over its half width at its centre: farther out the paraboloid magnifies more.
pub const REACH: f32 = 1.3;

/// A disc belongs to the light's own surface where the cosine between both normals is larger, ...
pub const OWN_COSINE: f32 = 0.7;

/// ... the light is nearer to its plane than this, over its half width, ...
pub const OWN_HEIGHT: f32 = 0.25;

/// ... and nearer to its centre than this, over its half width.
pub const OWN_REACH: f32 = 2.0;

/// Distance by which a receiver may lie behind what a map shows and still be lit, as a share of that distance.
pub const BIAS: f32 = 0.01;

/// The same for a receiver's slope: times its tangent, over the map's side. Half a texel, which is 4 / side wide in the middle; a
/// whole one hides contact shadows, and shadows nothing better.
pub const BIAS_TEXELS: f32 = 2.0;

/// The same, over the spacing of the slice.
pub const BIAS_SPACINGS: f32 = 0.35;

/// Bits of a key that say which surfel of the slice it shows.
pub const SURFEL_BITS: u32 = 14;

/// Bits of a distance that a key leaves out: 4096 steps an octave stay.
pub const DISTANCE_SHIFT: u32 = 11;

/// Bits of the smallest distance that a key holds, 2^-32; the largest is 2^32.
pub const DISTANCE_BASE: u32 = (127 - 32) << 23;

/// Largest distance of a key, in its own steps: one below what [`EMPTY`] would be.
pub const DISTANCE_MAX: u32 = (1 << 18) - 2;

/// Slices come from the first so many surfels, which are a fair sample of all, and fit into one binding.
const POOL: usize = 1 << 22;

/// Maps of this many texels are made and used at a time: 64 MiB.
const BATCH_TEXELS: u32 = 1 << 24;

/// Maps of a batch, at most.
const MAX_BATCH: u32 = 4096;

/// Distance and surfel of a texel as one integer that sorts by distance.
pub fn ism_key(distance: f32, surfel: u32) -> u32 {
    let steps = (distance.to_bits().max(DISTANCE_BASE) - DISTANCE_BASE) >> DISTANCE_SHIFT;
    steps.min(DISTANCE_MAX) << SURFEL_BITS | surfel
}

/// The distance of a key, or a little less.
pub fn ism_distance(key: u32) -> f32 {
    f32::from_bits(((key >> SURFEL_BITS) << DISTANCE_SHIFT) + DISTANCE_BASE)
}

/// Which slices of a cloud the maps show, and how large.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slices {
    /// Side of a map, texels.
    pub side: u32,
    /// Surfels in a slice.
    pub points: u32,
    /// Surfels from which slices are taken; after the last comes the first.
    pub pool: u32,
    /// Spacing of a slice over that of the cloud.
    pub thinning: f32,
}

impl Slices {
    /// Slices of `points` surfels of a cloud of `len`.
    pub fn of(len: usize, side: u32, points: u32) -> Self {
        let pool = len.min(POOL) as u32;
        let points = points.min(pool).min(1 << SURFEL_BITS);
        Self {
            side,
            points,
            pool,
            thinning: (len as f32 / points.max(1) as f32).sqrt().max(1.0),
        }
    }

    /// First surfel of slice `number`.
    pub fn first(&self, number: u64) -> u32 {
        (number * u64::from(self.points) % u64::from(self.pool.max(1))) as u32
    }

    /// The surfel number `k` of the slice that starts at `first`.
    pub fn surfel(&self, first: u32, k: u32) -> u32 {
        let index = first + k;
        if index >= self.pool {
            index - self.pool
        } else {
            index
        }
    }

    /// Maps that are made and used at a time.
    pub fn batch(&self) -> usize {
        (BATCH_TEXELS / (self.side * self.side)).clamp(1, MAX_BATCH) as usize
    }
}

/// The maps of a batch of lights: one under the other.
pub struct IsmMaps<B: Backend> {
    /// What they show.
    pub slices: Slices,
    /// Keys of all texels; [`EMPTY`] where a map shows nothing.
    pub keys: B::Grid<u32>,
}

/// A surfel as one map sees it: coordinates across the map, up it, and along the light's normal.
#[derive(Debug, Clone, Copy)]
struct Disc {
    centre: Vec3,
    normal: Vec3,
    /// Normal times centre.
    along: f32,
    half_squared: f32,
    /// Texels that it may cover: first and one past the last column and row.
    columns: (u32, u32),
    rows: (u32, u32),
}

fn dot(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Texels whose centres lie within `reach` of `middle`.
fn texels(middle: f32, reach: f32, side: u32) -> (u32, u32) {
    let side = side as f32;
    let first = (middle - reach + 0.5).clamp(0.0, side);
    let end = (middle + reach + 0.5).clamp(0.0, side);
    (first as u32, end as u32)
}

impl Disc {
    fn new(vpl: &Vpl, place: &Place, finish: &Finish, slices: &Slices) -> Option<Self> {
        let to = place.position - vpl.position;
        let centre = Vec3::new(dot(to, vpl.right), dot(to, vpl.up), dot(to, vpl.normal));
        if !(centre.z > 0.0) {
            return None;
        }
        let n = finish.normal();
        let normal = Vec3::new(dot(n, vpl.right), dot(n, vpl.up), dot(n, vpl.normal));
        let along = dot(normal, centre);
        let distance_squared = dot(centre, centre);
        let cosine_squared = along * along / distance_squared;
        if !(cosine_squared >= EDGE_ON_COSINE_SQUARED) {
            return None;
        }
        // Texels per unit of length across the ray: the projection keeps shapes.
        let scale = 0.5 * slices.side as f32 / (distance_squared.sqrt() + centre.z);
        let half = (DISC * slices.thinning * place.radius).max(MIN_HALF_WIDTH / scale);
        // Curved and noisy surfaces lie a little before their own lights.
        let own = normal.z.abs() > OWN_COSINE
            && along.abs() < OWN_HEIGHT * half
            && distance_squared < OWN_REACH * OWN_REACH * half * half;
        if own {
            return None;
        }
        let middle = 0.5 * slices.side as f32;
        let reach = half * scale * REACH;
        Some(Self {
            centre,
            normal,
            along,
            half_squared: half * half,
            columns: texels(centre.x * scale + middle, reach, slices.side),
            rows: texels(centre.y * scale + middle, reach, slices.side),
        })
    }

    /// Distance at which the ray through a texel meets the disc.
    fn distance(&self, column: u32, row: u32, texel: f32) -> Option<f32> {
        let u = (column as f32 + 0.5) * texel - 1.0;
        let v = (row as f32 + 0.5) * texel - 1.0;
        let square = u * u + v * v;
        let towards = Vec3::new(2.0 * u, 2.0 * v, 1.0 - square);
        let t = self.along / dot(self.normal, towards);
        let from_centre = Vec3::new(
            towards.x * t - self.centre.x,
            towards.y * t - self.centre.y,
            towards.z * t - self.centre.z,
        );
        let met = t > 0.0 && dot(from_centre, from_centre) <= self.half_squared;
        met.then_some(t * (1.0 + square))
    }
}

/// The maps of `vpls`.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn ism(surfels: &Surfels, vpls: &[Vpl], slices: Slices, job: &Job) -> Result<IsmMaps<Cpu>> {
    let side = slices.side;
    let mut keys = Grid::new(UVec2::new(side, side * vpls.len() as u32), EMPTY);
    let texel = 2.0 / side as f32;
    keys.values_mut()
        .par_chunks_mut((side * side) as usize)
        .zip(vpls)
        .for_each(|(map, vpl)| {
            if job.is_cancelled() {
                return;
            }
            for k in 0..slices.points {
                let i = slices.surfel(vpl.slice, k) as usize;
                let (place, finish) = (&surfels.places[i], &surfels.finishes[i]);
                let Some(disc) = Disc::new(vpl, place, finish, &slices) else {
                    continue;
                };
                for row in disc.rows.0..disc.rows.1 {
                    for column in disc.columns.0..disc.columns.1 {
                        if let Some(distance) = disc.distance(column, row, texel) {
                            let slot = &mut map[(row * side + column) as usize];
                            *slot = (*slot).min(ism_key(distance, k));
                        }
                    }
                }
            }
        });
    job.check()?;
    Ok(IsmMaps { slices, keys })
}

/// The texel of a map that shows the direction `to` (across, up, along; any length, `along` above 0).
pub(super) fn texel_of(to: Vec3, distance: f32, side: u32) -> (u32, u32) {
    let scale = 0.5 * side as f32 / (distance + to.z);
    let middle = 0.5 * side as f32;
    let last = side - 1;
    (
        ((to.x * scale + middle) as u32).min(last),
        ((to.y * scale + middle) as u32).min(last),
    )
}

/// The unit direction (across, up, along) that a texel shows.
pub(super) fn direction_of(column: u32, row: u32, side: u32) -> Vec3 {
    let texel = 2.0 / side as f32;
    let u = (column as f32 + 0.5) * texel - 1.0;
    let v = (row as f32 + 0.5) * texel - 1.0;
    let square = u * u + v * v;
    Vec3::new(2.0 * u, 2.0 * v, 1.0 - square) / (1.0 + square)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_sort_by_distance_and_keep_it() {
        let mut last = 0;
        for i in 1..2000u32 {
            let distance = 1e-4 * 1.01f32.powi(i as i32);
            let key = ism_key(distance, i % (1 << SURFEL_BITS));
            assert!(key > last && key != EMPTY, "{distance} gave {key:x}");
            last = key;
            let kept = ism_distance(key);
            assert!(
                kept <= distance && kept > distance * 0.9995,
                "{distance} became {kept}"
            );
            assert_eq!(key & ((1 << SURFEL_BITS) - 1), i, "the surfel stays");
        }
        assert!(
            ism_key(f32::INFINITY, (1 << SURFEL_BITS) - 1) < EMPTY,
            "no key is empty"
        );
        assert!(ism_key(0.0, 0) < ism_key(1e-6, 0), "0 is nearest");
    }

    #[test]
    fn texels_and_directions_are_each_others_inverse() {
        for (column, row) in [(16, 16), (3, 16), (20, 28), (31, 15)] {
            let d = direction_of(column, row, 32);
            assert!((d.length() - 1.0).abs() < 1e-6, "a unit vector: {d}");
            assert_eq!(texel_of(d, 1.0, 32), (column, row), "of {d}");
        }
    }
}
