//! Pass `curvature` on the device. Twin: `src/reflect/sscr/curvature.rs`.

use glam::{UVec2, Vec3};

use super::Gpu;
use super::buffers::GpuGrid;
use super::kernel::{Pass, Threads};
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::CURVATURE;
use super::windows::{Need, windows};
use crate::error::Result;
use crate::job::Job;
use crate::reflect::Surface;
use crate::reflect::sscr::curvature::{Axes, LhcSettings};

gpu_struct! {
    /// What one dispatch of `curvature` works on.
    pub(super) struct CurvatureParams {
        /// Along what the normal's change is measured, unit vector.
        right: Vec3,
        /// Change of the unit normal per pixel.
        planar_threshold: f32,
        /// As `right`, down.
        down: Vec3,
        /// Over the local spacing.
        depth_step: f32,
        /// Of the picture, pixels.
        size: UVec2,
        /// Words of four pixels: first, and one past the last.
        words: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// In a row of the dispatch.
        threads: u32,
        /// 1 where the change is measured along `right` and `down`, 0 along the way from the previous pixel.
        screen: u32,
        pad: u32,
    }
}

/// Pixels of a word.
const PER_WORD: u32 = 4;

/// A word at a window's edge holds pixels beyond it, three at most, and each is compared with the one above it.
const NEED: Need = Need {
    halo: PER_WORD,
    bytes: 16,
    steps: 16,
};

impl Gpu {
    /// Pass `curvature`.
    pub(super) fn run_curvature(
        &mut self,
        surface: &Surface<Self>,
        axes: Axes,
        settings: &LhcSettings,
        job: &Job,
    ) -> Result<GpuGrid<u8>> {
        let size = surface.size;
        let kernel = self.kernels.get(&self.device, &CURVATURE)?;
        let cells = GpuGrid::<u8>::new(&self.pool, size)?;
        let (right, down, screen) = match axes {
            Axes::Screen { right, down } => (right, down, 1),
            Axes::Way => (Vec3::ZERO, Vec3::ZERO, 0),
        };
        let mut pass = Pass::new(
            CURVATURE.name,
            &self.device,
            &self.pool,
            self.stamps.as_ref(),
        );
        for window in windows(size, NEED, &self.device.limits) {
            let words = UVec2::new(
                window.rows.start * size.x / PER_WORD,
                (window.rows.end * size.x).div_ceil(PER_WORD),
            );
            let params = CurvatureParams {
                right,
                planar_threshold: settings.planar_threshold,
                down,
                depth_step: settings.depth_step,
                size,
                words,
                first_pixel: window.pixels.start,
                threads: size.x,
                screen,
                pad: 0,
            };
            let rows = (words.y - words.x).div_ceil(size.x);
            pass.compute(&kernel, &params)
                .read(surface.point.part(&window.pixels))
                .read(surface.normal.part(&window.pixels))
                .write(cells.part(&window.pixels))
                .dispatch(Threads::Pixels(UVec2::new(size.x, rows)))?;
        }
        pass.finish(&mut self.timings, job)?;
        Ok(cells)
    }
}
