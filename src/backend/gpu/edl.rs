//! Pass `edl` on the device. Twin: `src/gbuffer/edl.rs`.

use glam::{UVec2, Vec4};

use super::Gpu;
use super::buffers::GpuGrid;
use super::kernel::Pass;
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::EDL;
use super::windows::{Need, windows};
use crate::camera::Pinhole;
use crate::error::Result;
use crate::gbuffer::GBuffer;
use crate::gbuffer::edl::EDL_GAIN;
use crate::image::ImageSettings;
use crate::job::Job;

gpu_struct! {
    /// What one dispatch of `edl` works on.
    pub(super) struct EdlParams {
        /// The camera.
        pinhole: Pinhole,
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// Distance of the neighbours beside, above and below, pixels.
        straight: i32,
        /// Distance of the other neighbours along each axis, pixels.
        diagonal: i32,
        /// Darkening per summed logarithmic depth difference.
        gain: f32,
        pad: UVec2,
    }
}

impl Gpu {
    /// Pass `edl`.
    pub(super) fn run_edl(
        &mut self,
        gbuffer: &GBuffer<Self>,
        settings: &ImageSettings,
        job: &Job,
    ) -> Result<GpuGrid<Vec4>> {
        let size = gbuffer.pinhole.size;
        let kernel = self.kernels.get(&self.device, &EDL)?;
        let picture = GpuGrid::<Vec4>::new(&self.pool, size)?;
        let straight = (settings.edl_radius + 0.5) as i32;
        let diagonal = (std::f32::consts::FRAC_1_SQRT_2 * settings.edl_radius + 0.5) as i32;
        let need = Need {
            halo: straight.unsigned_abs(),
            bytes: 16,
            steps: 9,
        };
        let mut pass = Pass::new("edl", &self.device, &self.pool, self.stamps.as_ref());
        for window in windows(size, need, &self.device.limits) {
            let params = EdlParams {
                pinhole: gbuffer.pinhole,
                rows: UVec2::new(window.rows.start, window.rows.end),
                first_pixel: window.pixels.start,
                straight,
                diagonal,
                gain: EDL_GAIN * settings.edl_strength / 8.0,
                pad: UVec2::ZERO,
            };
            pass.compute(&kernel, &params)
                .read(gbuffer.surface.part(&window.pixels))
                .read(gbuffer.albedo.part(&window.pixels))
                .read(gbuffer.material.part(&window.pixels))
                .write(picture.part(&window.pixels))
                .dispatch(window.threads(size))?;
        }
        pass.finish(&mut self.timings, job)?;
        Ok(picture)
    }
}
