//! Pass `coverage`: counts the pixels that show something. CPU twin of `shaders/coverage.wgsl`.

use glam::Vec4;
use rayon::prelude::*;

use super::{Coverage, GBuffer};
use crate::backend::cpu::Cpu;
use crate::grid::Grid;

/// Counts the pixels of a G-buffer that show something, and what.
pub fn coverage(gbuffer: &GBuffer<Cpu>) -> Coverage {
    let count = |grid: &Grid<Vec4>, holds: fn(f32) -> bool| {
        (grid.values().par_iter()).filter(|v| holds(v.w)).count() as u64
    };
    Coverage {
        pixels: gbuffer.material.values().len() as u64,
        splatted: count(&gbuffer.material, |validity| validity == 1.0),
        filled: count(&gbuffer.material, |validity| validity > 0.0),
        mirror: count(&gbuffer.albedo, |mirror| mirror > 0.0),
    }
}
