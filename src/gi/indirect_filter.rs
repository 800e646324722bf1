//! Pass `indirect_filter`: merges the parts of interleaved sampling, across the rows, then down the columns. CPU twin of
//! `shaders/indirect_filter.wgsl`.
//!
//! A window of a multiple of n pixels, whose ends count half where it has to be odd, holds every part equally often, so that
//! on a plane the merged sum is the whole one. What another surface shows is left out: by the distance from the receiver's
//! plane, compared with the distance between the points (which grows with the pixel's footprint) and with the spacing, and by
//! the normal. The residual is merged likewise, then spread in steps of n and 4 n pixels.

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

/// Pixels of a window that spreads the residual.
const SPREAD: u32 = 4;

/// The filter's window in one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Pixels on each side.
    pub reach: i32,
    /// What the outermost pixels count.
    pub end: f32,
    /// From pixel to pixel of the window.
    pub stride: i32,
}

impl Window {
    /// A window of `width` pixels, `stride` apart.
    pub fn of(width: u32, stride: u32) -> Self {
        let reach = (width / 2) as i32;
        let end = if width.is_multiple_of(2) { 0.5 } else { 1.0 };
        Self {
            reach,
            end,
            stride: stride as i32,
        }
    }

    /// Windows through which the residual is spread, one after the other, where pixels are interleaved n x n.
    pub fn spreading(n: u32) -> [Self; 2] {
        [Self::of(SPREAD, n), Self::of(SPREAD, SPREAD * n)]
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
            let (mut sum, mut weights) = (Vec4::ZERO, 0.0);
            for step in -window.reach..=window.reach {
                let far = step * window.stride;
                let (u, v) = if down { (x, y + far) } else { (x + far, y) };
                if u < 0 || v < 0 || u >= size.x || v >= size.y {
                    continue;
                }
                let there = (v * size.x + u) as usize;
                if !(positions[there].w > 0.0) {
                    continue;
                }
                let share = if step.abs() == window.reach {
                    window.end
                } else {
                    1.0
                };
                let weight = share
                    * likeness(
                        position,
                        normal,
                        positions[there],
                        normals[there].truncate(),
                    );
                sum += irradiance.values()[there] * weight;
                weights += weight;
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
    use super::*;

    #[test]
    fn a_window_holds_every_part_equally_often() {
        for width in 1..=16u32 {
            let window = Window::of(width, 1);
            let mut parts = vec![0.0; width as usize];
            for step in -window.reach..=window.reach {
                let share = if step.abs() == window.reach {
                    window.end
                } else {
                    1.0
                };
                parts[step.rem_euclid(width as i32) as usize] += share;
            }
            assert!(
                parts.iter().all(|&p| p == 1.0),
                "of {width} pixels: {parts:?}"
            );
        }
    }
}
