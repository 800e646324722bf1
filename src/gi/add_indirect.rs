//! Pass `add_indirect`: radiance of the indirect light. CPU twin of `shaders/add_indirect.wgsl`.
//!
//! albedo / pi times the irradiance, and the specular lobe's luminance in the irradiance's own colour: highlights of indirect
//! light are too faint to tell their colours apart, and one value less passes through all passes.

use std::f32::consts::PI;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::gather::Gathered;
use super::vpl::luminance;
use crate::backend::cpu::Cpu;
use crate::error::Result;
use crate::grid::Grid;
use crate::job::Job;

/// Luminance below which an irradiance has no colour, W/m2.
pub const MIN_LUMINANCE: f32 = 1e-20;

/// Adds to `radiance` what the pixels of `albedo` (linear RGB, mirror reflectance) send on of `light`.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn add_indirect(
    albedo: &Grid<Vec4>,
    light: &Gathered<Cpu>,
    albedo_scale: f32,
    radiance: &mut Grid<Vec4>,
    job: &Job,
) -> Result<()> {
    job.check()?;
    radiance
        .values_mut()
        .par_iter_mut()
        .zip(albedo.values())
        .zip(light.irradiance.values())
        .zip(light.residual.values())
        .for_each(|(((radiance, albedo), light), residual)| {
            let arrived = light.truncate() + residual.truncate();
            let glossy = arrived * (light.w / luminance(arrived).max(MIN_LUMINANCE));
            let sent: Vec3 = albedo.truncate() * albedo_scale / PI * arrived + glossy;
            *radiance += (sent * (1.0 - albedo.w)).extend(0.0);
        });
    job.check()
}
