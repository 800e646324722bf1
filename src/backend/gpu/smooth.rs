//! Pass `smooth` on the device. Twin: `src/gbuffer/smooth.rs`.

use glam::{UVec2, Vec4};

use super::Gpu;
use super::buffers::GpuGrid;
use super::kernel::Pass;
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::SMOOTH;
use super::windows::{Need, windows};
use crate::camera::Pinhole;
use crate::error::Result;
use crate::gbuffer::smooth::window;
use crate::gbuffer::{GBuffer, SplatSettings};
use crate::job::Job;

gpu_struct! {
    /// What one dispatch of `smooth` works on.
    pub(super) struct SmoothParams {
        /// How the G-buffer was projected.
        pinhole: Pinhole,
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// Of the window, pixels.
        reach: i32,
    }
}

impl Gpu {
    /// Pass `smooth`.
    pub(super) fn run_smooth(
        &mut self,
        gbuffer: &mut GBuffer<Self>,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<()> {
        let pinhole = gbuffer.pinhole;
        let kernel = self.kernels.get(&self.device, &SMOOTH)?;
        let smoothed = GpuGrid::<Vec4>::new(&self.pool, pinhole.size)?;
        let window = window(settings.smooth);
        let gaussian = GpuGrid::<f32>::new(&self.pool, window.size())?;
        gaussian.upload(window.values())?;
        let reach = window.size().x / 2;
        let side = u64::from(2 * reach + 1);
        let need = Need {
            halo: reach,
            bytes: 16,
            steps: side * side,
        };
        let mut pass = Pass::new("smooth", &self.device, &self.pool, self.stamps.as_ref());
        for window in windows(pinhole.size, need, &self.device.limits) {
            let params = SmoothParams {
                pinhole,
                rows: UVec2::new(window.rows.start, window.rows.end),
                first_pixel: window.pixels.start,
                reach: reach as i32,
            };
            pass.compute(&kernel, &params)
                .read(gbuffer.surface.part(&window.pixels))
                .read(gbuffer.albedo.part(&window.pixels))
                .read(gbuffer.material.part(&window.pixels))
                .read(gaussian.whole())
                .write(smoothed.part(&window.pixels))
                .dispatch(window.threads(pinhole.size))?;
        }
        pass.finish(&mut self.timings, job)?;
        gbuffer.surface = smoothed;
        Ok(())
    }
}
