//! The mirrors of a picture as one smooth field: where each place on screen lies in the scene, and where its reflected ray
//! goes, with their slopes.
//!
//! Between the centres of four pixels of one mirror both are bilinear. Such a square is a *cell*; cells over which the
//! mirror breaks off are no part of the field.

use bytemuck::{Pod, Zeroable};
use glam::{UVec2, Vec2, Vec3};
use rayon::prelude::*;
use wide::f32x8;

use super::curvature::{X_STEP, Y_STEP};
use super::real::Real;
use crate::backend::cpu::Cpu;
use crate::cloud::require_memory;
use crate::error::Result;
use crate::gbuffer::disc::PixelRect;
use crate::grid::Grid;
use crate::reflect::Surface;

/// One pixel: the mirror's point (0 to 2) and the spacing of its points (3), the reflected ray's unit direction (4 to 6),
/// and 0 where the cell to its lower right is no part of the field, else 1 and a bit for each side on which the field ends
/// (7), see [`SIDES`].
///
/// Point and direction side by side are interpolated as one vector of eight.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(32))]
struct Texel([f32; 8]);

const SPACING: usize = 3;
const WHOLE: usize = 7;

/// The eight cells around a cell, in the order of their bits, from 2 on.
const SIDES: [(isize, isize); 8] = [
    (-1, -1),
    (0, -1),
    (1, -1),
    (-1, 0),
    (1, 0),
    (-1, 1),
    (0, 1),
    (1, 1),
];

/// The outermost part of the field, pixels. At a silhouette the mirror turns away within a pixel, and what lies between two
/// pixels is no longer known: most places that are found there show nothing of the kind, and hardly any elsewhere.
pub const OUTLINE: f32 = 0.06;

/// The mirrors of a picture, in the rectangle around them. Places are counted in pixels from the centre of its upper left
/// pixel.
#[derive(Debug)]
pub struct MirrorField {
    bounds: PixelRect,
    width: usize,
    texels: Vec<Texel>,
}

/// The field at a place, or at several.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<T = f32> {
    /// The mirror's point, relative to the scene's origin.
    pub point: [T; 3],
    /// The reflected ray's direction, of about unit length.
    pub ray: [T; 3],
    /// Slopes of `point`, per pixel to the right and down.
    pub point_slope: [[T; 3]; 2],
    /// Slopes of `ray`.
    pub ray_slope: [[T; 3]; 2],
    /// Local spacing of the mirror's points.
    pub spacing: T,
}

impl<T: Real> Sample<T> {
    /// From point, spacing and ray, and their slopes, as texels have them.
    #[inline(always)]
    fn new(value: [T; 8], right: [T; 8], down: [T; 8]) -> Self {
        let point = |v: [T; 8]| [v[0], v[1], v[2]];
        let ray = |v: [T; 8]| [v[4], v[5], v[6]];
        Self {
            point: point(value),
            ray: ray(value),
            point_slope: [point(right), point(down)],
            ray_slope: [ray(right), ray(down)],
            spacing: value[SPACING],
        }
    }
}

impl Sample {
    /// The same field for eight.
    #[inline(always)]
    pub fn splat(&self) -> Sample<f32x8> {
        let splat = |v: [f32; 3]| v.map(f32x8::splat);
        Sample {
            point: splat(self.point),
            ray: splat(self.ray),
            point_slope: self.point_slope.map(splat),
            ray_slope: self.ray_slope.map(splat),
            spacing: f32x8::splat(self.spacing),
        }
    }
}

fn point(v: [f32; 8]) -> Vec3 {
    Vec3::new(v[0], v[1], v[2])
}

fn ray(v: [f32; 8]) -> Vec3 {
    Vec3::new(v[4], v[5], v[6])
}

impl MirrorField {
    /// The field of a picture's mirrors; `curvature` ([`super::curvature::curvature`]) says where they break off.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] where the picture is too large.
    pub fn new(surface: &Surface<Cpu>, curvature: &Grid<u8>) -> Result<Self> {
        let bounds = around(surface);
        let (width, height) = (
            (bounds.x1 - bounds.x0) as usize,
            (bounds.y1 - bounds.y0) as usize,
        );
        require_memory(
            "searching the mirrors",
            (width * height * size_of::<Texel>()) as u64,
        )?;
        let cell = |x: usize, y: usize| curvature.get(x, y).copied().unwrap_or(0);
        let whole = |x: usize, y: usize| {
            let (right, below, across) = (cell(x + 1, y), cell(x, y + 1), cell(x + 1, y + 1));
            let mirror = cell(x, y) != 0 && right != 0 && below != 0 && across != 0;
            let torn = (right | across) & X_STEP | (below | across) & Y_STEP;
            mirror && torn == 0
        };
        let texel = |i: usize| {
            let (x, y) = (
                bounds.x0 as usize + i % width,
                bounds.y0 as usize + i / width,
            );
            let index = y * surface.size.x as usize + x;
            let Some((p, r)) = surface.reflected(index) else {
                return Texel([0.0; 8]);
            };
            let spacing = surface.normal.values()[index].w;
            let ends = |(bit, (dx, dy)): (usize, &(isize, isize))| {
                let (x, y) = (x.checked_add_signed(*dx), y.checked_add_signed(*dy));
                let goes_on = x.zip(y).is_some_and(|(x, y)| whole(x, y));
                if goes_on { 0 } else { 2 << bit }
            };
            let sides: u16 = if whole(x, y) {
                1 + SIDES.iter().enumerate().map(ends).sum::<u16>()
            } else {
                0
            };
            Texel([p.x, p.y, p.z, spacing, r.x, r.y, r.z, f32::from(sides)])
        };
        Ok(Self {
            bounds,
            width,
            texels: (0..width * height).into_par_iter().map(texel).collect(),
        })
    }

    /// All pixels, row by row, as the device reads them: eight numbers each.
    pub(crate) fn texels(&self) -> &[[f32; 8]] {
        bytemuck::cast_slice(&self.texels)
    }

    /// Width and height, pixels.
    pub fn size(&self) -> UVec2 {
        UVec2::new(
            self.bounds.x1 - self.bounds.x0,
            self.bounds.y1 - self.bounds.y0,
        )
    }

    /// Place of the pixel in column `x`, row `y` of the picture, which lies in the rectangle.
    pub fn place_of_pixel(&self, x: u32, y: u32) -> Vec2 {
        Vec2::new(
            x as f32 - self.bounds.x0 as f32,
            y as f32 - self.bounds.y0 as f32,
        )
    }

    /// A place as pixels of the picture (centres at + 0.5).
    pub fn pixel_of_place(&self, at: Vec2) -> Vec2 {
        at + Vec2::new(self.bounds.x0 as f32 + 0.5, self.bounds.y0 as f32 + 0.5)
    }

    /// The mirror's point and reflected direction at a pixel, by column and row of the rectangle.
    pub fn texel(&self, x: u32, y: u32) -> Option<(Vec3, Vec3)> {
        let texel = self.texels.get(y as usize * self.width + x as usize)?;
        let ray = ray(texel.0);
        (x < self.width as u32 && ray != Vec3::ZERO).then(|| (point(texel.0), ray))
    }

    /// Whether the cell to the lower right of a pixel of the rectangle is part of the field.
    pub fn is_whole(&self, x: u32, y: u32) -> bool {
        let texel = self.texels.get(y as usize * self.width + x as usize);
        x < self.width as u32 && texel.is_some_and(|t| t.0[WHOLE] > 0.0)
    }

    /// Whether the field ends beside the cell of a place.
    pub fn is_at_end(&self, at: Vec2) -> bool {
        let index = at.y as usize * self.width + at.x as usize;
        self.texels.get(index).is_some_and(|t| t.0[WHOLE] > 1.0)
    }

    /// Whether a place lies in the field, and not on its outline ([`OUTLINE`]).
    pub fn is_inside(&self, at: Vec2) -> bool {
        if !(at.x >= 0.0 && at.y >= 0.0 && at.x < self.width as f32) {
            return false;
        }
        let index = at.y as usize * self.width + at.x as usize;
        let sides = self.texels.get(index).map_or(0, |t| t.0[WHOLE] as u32);
        let (u, v) = (at.x.fract(), at.y.fract());
        let near = |offset: isize, part: f32| match offset {
            -1 => part < OUTLINE,
            1 => part > 1.0 - OUTLINE,
            _ => true,
        };
        let on_outline = (SIDES.iter().enumerate())
            .any(|(bit, &(dx, dy))| sides & 2 << bit != 0 && near(dx, u) && near(dy, v));
        sides != 0 && !on_outline
    }

    /// Whether a place lies in the field.
    #[inline]
    pub fn contains(&self, at: Vec2) -> bool {
        self.cell(at).is_some()
    }

    /// The mirror's point at the upper left pixel of a place's cell; `None` outside of the field.
    #[inline]
    pub fn point_near(&self, at: Vec2) -> Option<Vec3> {
        Some(point(self.texels.get(self.cell(at)?)?.0))
    }

    /// The upper left texel of the cell in which a place lies; `None` outside of the field.
    #[inline]
    fn cell(&self, at: Vec2) -> Option<usize> {
        // What is not a number passes neither comparison.
        if !(at.x >= 0.0 && at.y >= 0.0 && at.x < self.width as f32) {
            return None;
        }
        let index = at.y as usize * self.width + at.x as usize;
        let whole = self.texels.get(index)?.0[WHOLE] > 0.0;
        whole.then_some(index)
    }

    /// The values at a place, and their slopes to the right and down; `None` outside of the field.
    #[inline]
    fn bilinear(&self, at: Vec2) -> Option<[f32x8; 3]> {
        let first = self.cell(at)?;
        let below = first + self.width;
        let upper = self.texels.get(first..first + 2)?;
        let lower = self.texels.get(below..below + 2)?;
        let part = |v: f32| f32x8::splat(v - v as usize as f32);
        let (u, v) = (part(at.x), part(at.y));
        let [a, b] = [upper[0].0, upper[1].0].map(f32x8::from);
        let [c, d] = [lower[0].0, lower[1].0].map(f32x8::from);
        let (top, bottom) = (b - a, d - c);
        let (left, other) = (c - a, d - b);
        let down = left + u * (other - left);
        Some([a + u * top + v * down, top + v * (bottom - top), down])
    }

    /// The field at a place; `None` outside of it.
    #[inline]
    pub fn sample(&self, at: Vec2) -> Option<Sample> {
        let [value, right, down] = self.bilinear(at)?.map(|v| v.to_array());
        Some(Sample::new(value, right, down))
    }

    /// The field at those of eight places whose bits are set; what the others get means nothing.
    #[inline]
    pub fn sample_eight(&self, at: &[Vec2; 8], mask: u32) -> Sample<f32x8> {
        let mut rows = [[f32x8::ZERO; 8]; 3];
        for lane in lanes(mask) {
            if let Some(values) = self.bilinear(at[lane]) {
                for (rows, value) in rows.iter_mut().zip(values) {
                    rows[lane] = value;
                }
            }
        }
        let [value, right, down] = rows.map(f32x8::transpose);
        Sample::new(value, right, down)
    }
}

/// The numbers of the bits that are set.
pub(super) fn lanes(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros() as usize;
        (mask != 0).then(|| {
            mask &= mask - 1;
            lane
        })
    })
}

/// The smallest rectangle around all mirrors.
fn around(surface: &Surface<Cpu>) -> PixelRect {
    let width = surface.size.x.max(1) as usize;
    let rows = surface.point.values().par_chunks(width).enumerate();
    let none = (u32::MAX, u32::MAX, 0, 0);
    let (x0, y0, x1, y1) = rows
        .map(|(y, row)| {
            let first = row.iter().position(|p| p.w > 0.0);
            let last = row.iter().rposition(|p| p.w > 0.0);
            match (first, last) {
                (Some(first), Some(last)) => {
                    (first as u32, y as u32, last as u32 + 1, y as u32 + 1)
                }
                _ => none,
            }
        })
        .reduce(
            || none,
            |a, b| (a.0.min(b.0), a.1.min(b.1), a.2.max(b.2), a.3.max(b.3)),
        );
    if x1 == 0 {
        return PixelRect {
            x0: 0,
            y0: 0,
            x1: 0,
            y1: 0,
        };
    }
    PixelRect { x0, y0, x1, y1 }
}
