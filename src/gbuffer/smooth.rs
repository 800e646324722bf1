//! Pass `smooth`: a joint bilateral Gaussian over the normals and depths of mirrors. CPU twin of `shaders/smooth.wgsl`.
//!
//! What a curved mirror shows depends on its normals; splats leave 0.3 degrees of noise in them. Depths are compared after
//! both pixels' planes carried them over, which is exact to second order on a curved surface, so nothing is flattened
//! before the normals are.

use glam::{UVec2, Vec3};
use rayon::prelude::*;

use super::average::Pixel;
use super::fill::plane_depth;
use super::{GBuffer, SplatSettings, column_row};
use crate::backend::cpu::Cpu;
use crate::error::Result;
use crate::grid::Grid;
use crate::job::Job;

/// The window reaches this many standard deviations.
pub const REACH: f32 = 2.5;

/// Depths farther apart than this many spacings belong to different surfaces.
pub const DEPTH_SPACINGS: f32 = 4.0;

/// Normals farther apart than this do not smooth each other (6 degrees, as the length of their difference): splats leave
/// a tenth of that in noise, and towards a silhouette normals turn faster than a window may average.
pub const NORMAL_DIFFERENCE: f32 = 0.1;

/// The smoothed surface of the mirror pixel at column `x`, row `y`; `None` where it is none.
fn smooth_pixel(gbuffer: &GBuffer<Cpu>, window: &Grid<f32>, x: i32, y: i32) -> Option<Pixel> {
    let here = gbuffer.at(x, y).filter(|p| p.albedo.w > 0.0)?;
    let (normal, depth) = (here.surface.truncate(), here.surface.w);
    let direction = gbuffer.direction(x, y);
    let limit = DEPTH_SPACINGS * here.material.z;
    let reach = (window.width() / 2) as i32;
    let mut weights_here = window.values().iter();
    let (mut normals, mut offsets, mut weights) = (Vec3::ZERO, 0.0, 0.0);
    for dy in -reach..=reach {
        for dx in -reach..=reach {
            let (u, v) = (x + dx, y + dy);
            let Some(near) = weights_here.next() else {
                continue;
            };
            let Some(there) = gbuffer.at(u, v).filter(|p| p.albedo.w > 0.0) else {
                continue;
            };
            let (other, other_depth) = (there.surface.truncate(), there.surface.w);
            let other_direction = gbuffer.direction(u, v);
            // By the other's plane to here, and by this plane to there: their mean is free of curvature.
            let carried_here = plane_depth(other, other_direction, other_depth, direction) - depth;
            let carried_there =
                other_depth - plane_depth(normal, direction, depth, other_direction);
            let offset = 0.5 * (carried_here + carried_there);
            let turn = (other - normal).length_squared() / (NORMAL_DIFFERENCE * NORMAL_DIFFERENCE);
            let apart = (offset / limit) * (offset / limit);
            let similar = (1.0 - turn).max(0.0) * (1.0 - apart).max(0.0);
            let weight = near * similar * similar;
            normals += other * weight;
            offsets += offset * weight;
            weights += weight;
        }
    }
    let depth = depth + offsets / weights.max(f32::MIN_POSITIVE);
    Some(Pixel {
        surface: normals.normalize_or(normal).extend(depth),
        ..here
    })
}

/// The Gaussian over a pixel's neighbours, row by row.
pub fn window(sigma: f32) -> Grid<f32> {
    let reach = (REACH * sigma).ceil();
    let side = 2 * reach as u32 + 1;
    let mut window = Grid::new(UVec2::splat(side), 0.0);
    for (i, weight) in window.values_mut().iter_mut().enumerate() {
        let (x, y) = column_row(i, side as usize);
        let (dx, dy) = (x as f32 - reach, y as f32 - reach);
        *weight = (-0.5 * (dx * dx + dy * dy) / (sigma * sigma)).exp();
    }
    window
}

/// Smooths the surface of every mirror pixel.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn smooth(gbuffer: &mut GBuffer<Cpu>, settings: &SplatSettings, job: &Job) -> Result<()> {
    let window = window(settings.smooth);
    let width = gbuffer.albedo.width();
    let smoothed: Vec<(usize, Pixel)> = (gbuffer.albedo.values().par_iter().enumerate())
        .filter(|(_, a)| a.w > 0.0 && !job.is_cancelled())
        .filter_map(|(i, _)| {
            let (x, y) = column_row(i, width);
            smooth_pixel(gbuffer, &window, x, y).map(|p| (i, p))
        })
        .collect();
    job.check()?;
    gbuffer.put(smoothed);
    Ok(())
}
