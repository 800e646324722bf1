//! Pass `indirect_filter`: merges the parts of interleaved sampling, across the rows, then down the columns. CPU twin of
//! `shaders/indirect_filter.wgsl`.
//!
//! A pixel and its neighbours to one side, a multiple of n of them, hold every part equally often. Each is paired with the next of
//! its part to the other side, and between both is interpolated: on a plane the merged sum is the whole one. What another
//! surface shows is left out: by the distance from the receiver's plane, compared with the distance between the points (which
//! grows with the pixel's footprint) and with the spacing, and by the normal. At an edge one of each pair is left, so that no
//! part is missing. The residual is merged likewise, then spread in steps of 4 and 16 pixels, whatever n is.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::receivers::Receivers;
use crate::backend::cpu::Cpu;
use crate::error::Result;
use crate::gbuffer::column_row;
use crate::grid::Grid;
use crate::job::Job;

/// Distance from the receiver's plane at which a point counts nothing, over the distance between both.
pub const PLANE_SLOPE: f32 = 0.2;

/// The same, over the local spacing.
pub const PLANE_SPACINGS: f32 = 2.0;

/// Cosine between normals at which a pixel counts nothing.
pub const NORMAL_COSINE: f32 = 0.5;

/// Likeness from which a pair counts whole: what is hardly alike counts little, and at edges no part is missing.
pub const ALIKE: f32 = 0.125;

/// Pixels of a window that spreads the residual, on each side.
const SPREAD: u32 = 3;

/// The filter's window in one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Pixels on each side, where the last counts nothing: at least 1, which leaves the pixel alone.
    pub width: i32,
    /// From pixel to pixel of the window.
    pub stride: i32,
}

impl Window {
    /// A window of `width` pixels on each side, `stride` apart.
    pub fn of(width: u32, stride: u32) -> Self {
        Self {
            width: width.max(1) as i32,
            stride: stride as i32,
        }
    }

    /// Windows through which the residual is spread, one after the other, where pixels are merged over `merged`.
    pub fn spreading(merged: u32) -> impl Iterator<Item = Self> {
        let finest = (merged < SPREAD + 1).then(|| Self::of(SPREAD, 1));
        let wider = [Self::of(SPREAD, 4), Self::of(SPREAD, 16)];
        finest.into_iter().chain(wider)
    }
}

fn dot(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// How much alike two receivers are, 0 to 1.
fn likeness(position: Vec4, normal: Vec3, other: Vec4, other_normal: Vec3) -> f32 {
    let between = other.truncate() - position.truncate();
    // On an edge a blended normal is neither side's: either plane may be the one.
    let off = dot(normal, between)
        .abs()
        .min(dot(other_normal, between).abs());
    let spacing = PLANE_SPACINGS * position.w;
    let limit_squared = PLANE_SLOPE * PLANE_SLOPE * dot(between, between) + spacing * spacing;
    let plane = (1.0 - off * off / limit_squared).max(0.0);
    let turned = (dot(normal, other_normal) - NORMAL_COSINE) / (1.0 - NORMAL_COSINE);
    plane * turned.max(0.0)
}

/// Filters in one direction: across the rows, or down the columns.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn indirect_filter(
    receivers: &Receivers<Cpu>,
    irradiance: &Grid<Vec4>,
    window: Window,
    down: bool,
    job: &Job,
) -> Result<Grid<Vec4>> {
    let size = receivers.size.as_ivec2();
    let (positions, normals) = (receivers.position.values(), receivers.normal.values());
    let mut filtered = Grid::new(receivers.size, Vec4::ZERO);
    filtered
        .values_mut()
        .par_iter_mut()
        .enumerate()
        .for_each(|(i, out)| {
            let position = positions[i];
            if !(position.w > 0.0) || job.is_cancelled() {
                return;
            }
            let normal = normals[i].truncate();
            let (x, y) = column_row(i, size.x as usize);
            let tap = |step: i32, share: f32| {
                let far = step * window.stride;
                let (u, v) = if down { (x, y + far) } else { (x + far, y) };
                if u < 0 || v < 0 || u >= size.x || v >= size.y {
                    return (Vec4::ZERO, 0.0);
                }
                let there = (v * size.x + u) as usize;
                if !(positions[there].w > 0.0) {
                    return (Vec4::ZERO, 0.0);
                }
                let other = normals[there].truncate();
                let weight = share * likeness(position, normal, positions[there], other);
                (irradiance.values()[there] * weight, weight)
            };
            let (mut sum, mut weights) = (Vec4::ZERO, 0.0);
            for step in 0..window.width {
                let share = step as f32 / window.width as f32;
                let (value, weight) = tap(step, 1.0 - share);
                let (other_value, other_weight) = tap(step - window.width, share);
                let pair = weight + other_weight;
                if pair > 0.0 {
                    let counts = (pair / ALIKE).min(1.0);
                    sum += (value + other_value) * (counts / pair);
                    weights += counts;
                }
            }
            // A pixel is always like itself, but for a normal that is none.
            *out = if weights > 0.0 {
                sum / weights
            } else {
                irradiance.values()[i]
            };
        });
    job.check()?;
    Ok(filtered)
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    /// A room's edge: the left 13 pixels of a row show one wall, the others another.
    fn edge() -> Receivers<Cpu> {
        let size = UVec2::new(32, 1);
        let grid = |value: &dyn Fn(usize) -> Vec4| {
            let mut grid = Grid::new(size, Vec4::ZERO);
            for (i, v) in grid.values_mut().iter_mut().enumerate() {
                *v = value(i);
            }
            grid
        };
        let along = |i: usize| i as f32 - 12.5;
        Receivers {
            size,
            position: grid(&|i| Vec3::new(along(i).min(0.0), 0.0, along(i).max(0.0)).extend(0.5)),
            normal: grid(&|i| if along(i) < 0.0 { Vec4::Z } else { Vec4::X }),
            view: grid(&|_| Vec4::ZERO),
        }
    }

    #[test]
    fn merging_holds_every_part_equally_often_at_edges_too() {
        let receivers = edge();
        for n in 1..=6u32 {
            let mut parts = Grid::new(receivers.size, Vec4::ZERO);
            for (i, part) in parts.values_mut().iter_mut().enumerate() {
                // Each part sees another light; the left wall sees half.
                let half = if i < 13 { 0.5 } else { 1.0 };
                *part = Vec4::splat((i as u32 % n) as f32 * half);
            }
            let window = Window::of(n, 1);
            let merged = indirect_filter(&receivers, &parts, window, false, &Job::default())
                .expect("merged");
            let whole = (n - 1) as f32 * 0.5;
            for (i, got) in merged.values().iter().enumerate() {
                let expected = if i < 13 { 0.5 * whole } else { whole };
                assert!(
                    (got.x - expected).abs() < 1e-5,
                    "{n} parts, pixel {i}: got {}, expected {expected}",
                    got.x
                );
            }
        }
    }
}
