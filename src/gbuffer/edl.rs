//! Pass `edl`: eye-dome lighting, shading from depth alone, for scenes without light. CPU twin of `shaders/edl.wgsl`.
//!
//! A pixel darkens by how far its neighbours stand out in front of it [Boucheny 2009, Interactive scientific
//! visualization of large datasets, ch. 5]; here in front of its own plane, so that a tilted surface does not darken, whatever
//! the size of the picture.

use glam::Vec4;
use rayon::prelude::*;

use super::fill::plane_depth;
use super::{GBuffer, column_row};
use crate::backend::cpu::Cpu;
use crate::error::Result;
use crate::grid::Grid;
use crate::image::ImageSettings;
use crate::job::Job;

/// Darkening per unit of mean logarithmic depth difference at strength 1.
pub const EDL_GAIN: f32 = 100.0;

/// The eight directions in which neighbours are compared.
const DIRECTIONS: [(f32, f32); 8] = [
    (1.0, 0.0),
    (0.707_106_77, 0.707_106_77),
    (0.0, 1.0),
    (-0.707_106_77, 0.707_106_77),
    (-1.0, 0.0),
    (-0.707_106_77, -0.707_106_77),
    (0.0, -1.0),
    (0.707_106_77, -0.707_106_77),
];

/// The albedo, darkened where neighbours stand out in front; alpha 1 where valid.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn edl(gbuffer: &GBuffer<Cpu>, settings: &ImageSettings, job: &Job) -> Result<Grid<Vec4>> {
    let mut picture = Grid::new(gbuffer.size(), Vec4::ZERO);
    let width = gbuffer.surface.width();
    picture
        .values_mut()
        .par_iter_mut()
        .enumerate()
        .for_each(|(i, out)| {
            let (x, y) = column_row(i, width);
            let Some(here) = gbuffer.at(x, y).filter(|_| !job.is_cancelled()) else {
                return;
            };
            let (normal, direction) = (here.surface.truncate(), gbuffer.direction(x, y));
            let mut response = 0.0;
            for (dx, dy) in DIRECTIONS {
                let (u, v) = (
                    round(dx * settings.edl_radius),
                    round(dy * settings.edl_radius),
                );
                if let Some(there) = gbuffer.at(x + u, y + v) {
                    let expected = plane_depth(
                        normal,
                        direction,
                        here.surface.w,
                        gbuffer.direction(x + u, y + v),
                    );
                    response += (expected / there.surface.w).log2().max(0.0);
                }
            }
            let shade = (-EDL_GAIN * settings.edl_strength * response / 8.0).exp();
            *out = (here.albedo.truncate() * shade).extend(1.0);
        });
    job.check()?;
    Ok(picture)
}

/// Half away from zero, as the shader does it.
fn round(v: f32) -> i32 {
    (v.abs() + 0.5) as i32 * if v < 0.0 { -1 } else { 1 }
}
