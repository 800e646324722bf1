//! A surfel as the oriented disc that a pinhole sees, and its fragments: depth on the surfel's own plane at each pixel.
//!
//! Oriented discs with plane depth keep the depth of walls exact to float precision and grow silhouettes by 1 % of
//! their pixels, where screen-aligned squares grow them by 3 to 4 % (EWA splatting without the screen filter,
//! [Zwicker et al. 2001]).

use glam::Vec3;
use wide::f32x4;

use super::{Class, SplatSettings};
use crate::camera::Pinhole;
use crate::cloud::{Finish, Place};

/// Surfels seen at a flatter angle than this are left out: their plane's depth explodes. Squared cosine (1.1 degrees).
pub const EDGE_ON_COSINE_SQUARED: f32 = 4e-4;

/// Largest tangent that widens the depth tolerance.
pub const MAX_TOLERANCE_SLOPE: f32 = 8.0;

/// Squared distance from the centre, over the squared half width, at which a disc's rim begins (0.95 of the half width):
/// what is left covers a surface of random points but for two pixels in a thousand, which pass `leak` finds.
pub const RIM: f32 = 0.9;

/// Half width below which a disc could slip between pixel centres, pixels: half a pixel's diagonal.
pub const MIN_HALF_WIDTH: f32 = 0.71;

/// Slack of a disc's pixel bounds, so that rounding never cuts a fragment off; pixels.
pub const BOUNDS_SLACK: f32 = 0.01;

/// A rectangle of pixels, end exclusive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelRect {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// One past the last column.
    pub x1: u32,
    /// One past the last row.
    pub y1: u32,
}

impl PixelRect {
    /// Whether it holds no pixel.
    pub fn is_empty(&self) -> bool {
        self.x0 >= self.x1 || self.y0 >= self.y1
    }
}

/// A surfel in view space, ready to be cut into fragments. Twin: `disc` in `shaders/shared/disc.wgsl`.
#[derive(Debug, Clone, Copy)]
pub struct Disc {
    /// Centre in view space.
    pub centre: Vec3,
    /// Normal over its product with the centre: 1 / depth is linear in the ray's slopes with these factors.
    pub plane: Vec3,
    /// Squared half width, and its inverse.
    pub half_squared: f32,
    /// 1 / `half_squared`.
    pub inverse_half_squared: f32,
    /// A fragment this far behind the nearest is still blended.
    pub tolerance: f32,
    /// What it may blend with.
    pub class: Class,
    /// Whether the surfel is seen from behind.
    pub behind: bool,
    /// The surfel's radius (local spacing).
    pub radius: f32,
    /// The surfel's material.
    pub finish: Finish,
    /// Pixels that it may cover.
    pub bounds: PixelRect,
}

/// Pixels between two slopes along one axis, cut to the picture.
fn pixels(first: f32, last: f32, size: u32) -> (u32, u32) {
    let size = size as f32;
    // A pixel belongs to the span where its centre does: + 0.5 rounds the first up, the last down.
    let start = (first + 0.5 - BOUNDS_SLACK).clamp(0.0, size);
    let end = (last + 0.5 + BOUNDS_SLACK).clamp(0.0, size);
    (start as u32, end as u32)
}

/// Half width of a splat, at least so wide that it meets a pixel's centre.
fn half_width(radius: f32, depth: f32, pinhole: &Pinhole, settings: &SplatSettings) -> f32 {
    (settings.size * radius).max(MIN_HALF_WIDTH * depth * pinhole.inverse_focal)
}

/// Pixels that a surfel may cover, whatever its normal; `None` where it is out of sight.
pub fn loose_bounds(
    place: &Place,
    pinhole: &Pinhole,
    settings: &SplatSettings,
) -> Option<PixelRect> {
    let centre = pinhole.view_from_world(place.position);
    if !(centre.z >= pinhole.near && centre.z <= pinhole.far) {
        return None;
    }
    let half = half_width(place.radius, centre.z, pinhole, settings);
    let rect = bounds(centre, Vec3::splat(half), pinhole);
    (!rect.is_empty()).then_some(rect)
}

/// Pixels under the box `centre` +- `half`, both in view space.
fn bounds(centre: Vec3, half: Vec3, pinhole: &Pinhole) -> PixelRect {
    let nearest = 1.0 / (centre.z - half.z).max(pinhole.near);
    let farthest = 1.0 / (centre.z + half.z);
    let low = |v: f32| v * if v < 0.0 { nearest } else { farthest };
    let high = |v: f32| v * if v > 0.0 { nearest } else { farthest };
    let column = |slope: f32| pinhole.centre.x + pinhole.focal * slope;
    let row = |slope: f32| pinhole.centre.y - pinhole.focal * slope;
    let (x0, x1) = pixels(
        column(low(centre.x - half.x)),
        column(high(centre.x + half.x)),
        pinhole.size.x,
    );
    let (y0, y1) = pixels(
        row(high(centre.y + half.y)),
        row(low(centre.y - half.y)),
        pinhole.size.y,
    );
    PixelRect { x0, y0, x1, y1 }
}

impl Disc {
    /// The disc of a surfel, or `None` where it is out of sight or seen edge-on.
    pub fn new(
        place: &Place,
        finish: &Finish,
        pinhole: &Pinhole,
        settings: &SplatSettings,
    ) -> Option<Self> {
        let centre = pinhole.view_from_world(place.position);
        if !(centre.z >= pinhole.near && centre.z <= pinhole.far) {
            return None;
        }
        let normal = pinhole.view_from_world_direction(finish.normal());
        let along = normal.x * centre.x + normal.y * centre.y + normal.z * centre.z;
        let distance_squared = centre.x * centre.x + centre.y * centre.y + centre.z * centre.z;
        let cosine_squared = along * along / distance_squared;
        if cosine_squared < EDGE_ON_COSINE_SQUARED || cosine_squared.is_nan() {
            return None;
        }
        let half = half_width(place.radius, centre.z, pinhole, settings);
        let extent = |n: f32| half * (1.0 - n * n).max(0.0).sqrt();
        let rect = bounds(
            centre,
            Vec3::new(extent(normal.x), extent(normal.y), extent(normal.z)),
            pinhole,
        );
        if rect.is_empty() {
            return None;
        }
        let slope = (1.0 / cosine_squared - 1.0)
            .max(0.0)
            .sqrt()
            .min(MAX_TOLERANCE_SLOPE);
        let inverse = 1.0 / along;
        let half_squared = half * half;
        let behind = along > 0.0;
        Some(Self {
            centre,
            plane: Vec3::new(normal.x * inverse, normal.y * inverse, normal.z * inverse),
            half_squared,
            inverse_half_squared: 1.0 / half_squared,
            tolerance: place.radius * (settings.depth_tolerance + slope),
            class: Class::of(*finish, behind),
            behind,
            radius: place.radius,
            finish: *finish,
            bounds: rect,
        })
    }

    /// Fragments of four pixels of a row: depth, squared distance from the disc's centre, and which of them it covers
    /// (one bit each). `columns` and `row` are pixel centres.
    pub fn fragments(&self, columns: f32x4, row: f32, pinhole: &Pinhole) -> (f32x4, f32x4, u32) {
        let x = (columns - f32x4::splat(pinhole.centre.x)) * f32x4::splat(pinhole.inverse_focal);
        let y = (pinhole.centre.y - row) * pinhole.inverse_focal;
        let inverse_depth =
            f32x4::splat(self.plane.x) * x + f32x4::splat(self.plane.y * y + self.plane.z);
        let depth = f32x4::splat(1.0) / inverse_depth;
        let dx = x * depth - f32x4::splat(self.centre.x);
        let dy = f32x4::splat(y) * depth - f32x4::splat(self.centre.y);
        let dz = depth - f32x4::splat(self.centre.z);
        let distance = dx * dx + dy * dy + dz * dz;
        let covered = distance.simd_le(f32x4::splat(self.half_squared))
            & depth.simd_ge(f32x4::splat(pinhole.near))
            & depth.simd_le(f32x4::splat(pinhole.far));
        (depth, distance, covered.to_bitmask())
    }
}

/// Weight of a fragment at `t` = squared distance over squared half width, 0 to 1.
///
/// A Gaussian of half the half width, exp(-2 t), as (1 - t/4)^8: the same to 0.04, and made of products alone, so that
/// both backends round alike.
pub fn weight(t: f32) -> f32 {
    let u = 1.0 - 0.25 * t;
    let u2 = u * u;
    let u4 = u2 * u2;
    u4 * u4
}
