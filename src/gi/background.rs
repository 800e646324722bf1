//! Pass `background`: the environment where nothing is seen, directly or in a mirror. On the processor for both backends, once the
//! picture is in main memory.

use glam::Vec4;
use rayon::prelude::*;

use super::environment::Environment;
use crate::backend::cpu::Cpu;
use crate::gbuffer::{GBuffer, column_row};
use crate::grid::Grid;
use crate::reflect::MirrorGBuffer;

/// Lets pixels that see nothing show the environment, alpha 1, and mirrors show it where they see nothing, weighted by their
/// reflectance.
pub fn background(
    environment: &Environment,
    gbuffer: &GBuffer<Cpu>,
    mirror: Option<&MirrorGBuffer<Cpu>>,
    radiance: &mut Grid<Vec4>,
) {
    let width = gbuffer.surface.width();
    let pixels = radiance.values_mut().par_iter_mut().enumerate();
    pixels.for_each(|(i, radiance)| {
        if radiance.w <= 0.0 {
            let (x, y) = column_row(i, width);
            let towards = gbuffer.direction(x, y).normalize_or_zero();
            *radiance = environment.radiance(towards).extend(1.0);
            return;
        }
        let Some(mirror) = mirror else { return };
        let reflectance = gbuffer.albedo.values()[i].w;
        if reflectance > 0.0 && mirror.origin.values()[i].w > 0.0 && mirror.at(i).is_none() {
            let towards = mirror.direction.values()[i].truncate();
            *radiance += (environment.radiance(towards) * reflectance).extend(0.0);
        }
    });
}
