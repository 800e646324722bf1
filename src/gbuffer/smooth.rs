//! Pass `smooth`: a joint bilateral Gaussian over the normals and depths of mirrors. CPU twin of `shaders/smooth.wgsl`.
//!
//! What a curved mirror shows depends on its normals; splats leave 0.3 degrees of noise in them. Depths are compared after
//! both pixels' planes carried them over, which is exact to second order on a curved surface, so nothing is flattened
//! before the normals are.

use glam::Vec3;
use rayon::prelude::*;

use super::average::Pixel;
use super::fill::plane_depth;
use super::{GBuffer, SplatSettings, column_row};
use crate::backend::cpu::Cpu;

/// The window reaches this many standard deviations.
pub const REACH: f32 = 2.5;

/// Depths farther apart than this many spacings belong to different surfaces.
pub const DEPTH_SPACINGS: f32 = 4.0;

/// Normals farther apart than this cosine belong to different surfaces (37 degrees).
pub const NORMAL_COSINE: f32 = 0.8;

/// The smoothed surface of the mirror pixel at column `x`, row `y`; `None` where it is none.
fn smooth_pixel(gbuffer: &GBuffer<Cpu>, sigma: f32, x: i32, y: i32) -> Option<Pixel> {
    let here = gbuffer.at(x, y).filter(|p| p.albedo.w > 0.0)?;
    let (normal, depth) = (here.surface.truncate(), here.surface.w);
    let direction = gbuffer.direction(x, y);
    let limit = DEPTH_SPACINGS * here.material.z;
    let reach = (REACH * sigma).ceil() as i32;
    let falloff = -0.5 / (sigma * sigma);
    let (mut normals, mut offsets, mut weights) = (Vec3::ZERO, 0.0, 0.0);
    for dy in -reach..=reach {
        for dx in -reach..=reach {
            let (u, v) = (x + dx, y + dy);
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
            if offset.abs() > limit || normal.dot(other) < NORMAL_COSINE {
                continue;
            }
            let similar = 1.0 - (offset / limit) * (offset / limit);
            let weight = ((dx * dx + dy * dy) as f32 * falloff).exp() * similar * similar;
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

/// Smooths the surface of every mirror pixel.
pub fn smooth(gbuffer: &mut GBuffer<Cpu>, settings: &SplatSettings) {
    let width = gbuffer.albedo.width();
    let smoothed: Vec<(usize, Pixel)> = (gbuffer.albedo.values().par_iter().enumerate())
        .filter(|(_, a)| a.w > 0.0)
        .filter_map(|(i, _)| {
            let (x, y) = column_row(i, width);
            smooth_pixel(gbuffer, settings.smooth, x, y).map(|p| (i, p))
        })
        .collect();
    gbuffer.put(smoothed);
}
