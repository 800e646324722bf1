//! Eight surfels as discs that rays are cut with, together.

use glam::Vec3;
use wide::f32x8;

use crate::cloud::Surfels;
use crate::gbuffer::SplatSettings;
use crate::gbuffer::disc::{EDGE_ON_COSINE_SQUARED, MAX_TOLERANCE_SLOPE};

/// Discs of a leaf, and children of a node: what one comparison handles.
pub(super) const WIDTH: usize = 8;

/// Three coordinates of eight things.
pub(super) type Vec3x8 = [f32x8; 3];

/// A ray to be traced.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray {
    pub(super) origin: Vec3,
    /// Unit length.
    pub(super) direction: Vec3,
}

/// Eight discs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leaf {
    centre: [[f32; WIDTH]; 3],
    normal: [[f32; WIDTH]; 3],
    radius: [f32; WIDTH],
    /// Indices of the surfels.
    surfels: [u32; WIDTH],
    /// Which of them are mirrors, one bit each.
    mirrors: u32,
}

/// Where a ray meets a disc.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meeting {
    /// Index of the surfel.
    pub(super) surfel: u32,
    /// Along the ray, above 0.
    pub(super) distance: f32,
    /// Squared distance from the disc's centre over its squared half width, 0 to 1.
    pub(super) off_centre: f32,
    /// The disc's normal times the ray's direction: above 0 where it is met from behind.
    pub(super) cosine: f32,
    /// The disc's normal, unit length.
    pub(super) normal: Vec3,
    /// The surfel's radius.
    pub(super) radius: f32,
    /// Whether the surfel is a mirror.
    pub(super) mirror: bool,
}

/// A box around discs, and their largest reach.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    pub(super) min: Vec3,
    pub(super) max: Vec3,
    pub(super) reach: f32,
}

impl Bounds {
    pub(super) const EMPTY: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
        reach: 0.0,
    };

    pub(super) fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            reach: self.reach.max(other.reach),
        }
    }
}

impl Leaf {
    /// Calls `meet` with each disc that the ray meets.
    #[inline(always)]
    pub(super) fn meet(&self, ray: &Ray, size_squared: f32, mut meet: impl FnMut(Meeting)) {
        let direction = ray.direction.to_array().map(f32x8::splat);
        let origin = ray.origin.to_array().map(f32x8::splat);
        let normal = self.normal.map(f32x8::from);
        let radius = f32x8::from(self.radius);
        let to_centre: Vec3x8 = std::array::from_fn(|k| f32x8::from(self.centre[k]) - origin[k]);
        let cosine = dot(normal, direction);
        let distance = dot(normal, to_centre) / cosine;
        let off: Vec3x8 = std::array::from_fn(|k| direction[k] * distance - to_centre[k]);
        let off_centre = dot(off, off) / (radius * radius * f32x8::splat(size_squared));
        // Neither an empty lane nor a disc without finite place or size passes these comparisons.
        let met = off_centre.simd_le(f32x8::ONE)
            & distance.simd_gt(f32x8::ZERO)
            & (cosine * cosine).simd_ge(f32x8::splat(EDGE_ON_COSINE_SQUARED));
        let mut met = met.to_bitmask();
        if met == 0 {
            return;
        }
        let (distance, off_centre) = (distance.to_array(), off_centre.to_array());
        let cosine = cosine.to_array();
        while met != 0 {
            let lane = met.trailing_zeros() as usize & (WIDTH - 1);
            met &= met - 1;
            meet(Meeting {
                surfel: self.surfels[lane],
                distance: distance[lane],
                off_centre: off_centre[lane],
                cosine: cosine[lane],
                normal: Vec3::from(self.normal.map(|n| n[lane])),
                radius: self.radius[lane],
                mirror: self.mirrors >> lane & 1 == 1,
            });
        }
    }
}

/// How far behind the nearest hit a disc may be blended, met at the angle of `cosine` (absolute) with its normal.
pub(super) fn tolerance(radius: f32, cosine: f32, settings: &SplatSettings) -> f32 {
    let slope = (1.0 / (cosine * cosine) - 1.0).max(0.0).sqrt();
    radius * (settings.depth_tolerance + slope.min(MAX_TOLERANCE_SLOPE))
}

/// A leaf of up to eight surfels, and the box around them.
pub(super) fn leaf(surfels: &Surfels, indices: &[u32], settings: &SplatSettings) -> (Leaf, Bounds) {
    // Fetched in a loop of its own, the scattered surfels come in many at a time.
    let mut fetched = [None; WIDTH];
    for (slot, &index) in fetched.iter_mut().zip(indices) {
        let place = surfels.places.get(index as usize);
        let finish = surfels.finishes.get(index as usize);
        *slot = place.copied().zip(finish.copied()).map(|s| (index, s));
    }
    // Discs of no size are met by no ray.
    let mut leaf = Leaf {
        centre: [[0.0; WIDTH]; 3],
        normal: [[0.0; WIDTH]; 3],
        radius: [f32::NAN; WIDTH],
        surfels: [0; WIDTH],
        mirrors: 0,
    };
    let mut bounds = Bounds::EMPTY;
    for (lane, (index, (place, finish))) in fetched.into_iter().enumerate().flat_map(in_lane) {
        let (centre, radius) = (place.position, place.radius);
        if !(centre.is_finite() && radius.is_finite()) {
            continue;
        }
        let normal = finish.normal();
        for axis in 0..3 {
            leaf.centre[axis][lane] = centre[axis];
            leaf.normal[axis][lane] = normal[axis];
        }
        leaf.radius[lane] = radius;
        leaf.surfels[lane] = index;
        leaf.mirrors |= u32::from(finish.mirror() > 0.0) << lane;
        // A little more, so that rounding never cuts a disc off.
        let tilt = |n: f32| (1.0 - n * n).max(0.0).sqrt() + 1e-3;
        let extent = Vec3::new(tilt(normal.x), tilt(normal.y), tilt(normal.z))
            * (radius * settings.size)
            + centre.abs() * 1e-6;
        bounds = bounds.union(Bounds {
            min: centre - extent,
            max: centre + extent,
            reach: radius * (settings.depth_tolerance + MAX_TOLERANCE_SLOPE),
        });
    }
    (leaf, bounds)
}

/// What a lane holds, where it holds something.
fn in_lane<T>((lane, content): (usize, Option<T>)) -> Option<(usize, T)> {
    content.map(|content| (lane, content))
}

fn dot(a: Vec3x8, b: Vec3x8) -> f32x8 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
