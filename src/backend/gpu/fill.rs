//! Passes `fill` (leaks, then ring by ring) and `coverage` on the device. Twins: `src/gbuffer/{leak,fill,coverage}.rs`.

use glam::UVec2;

use super::Gpu;
use super::buffers::STORAGE;
use super::kernel::Pass;
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::{COVERAGE, FILL, LEAK};
use super::windows::{Need, Window, windows};
use crate::camera::Pinhole;
use crate::error::{Error, Result};
use crate::gbuffer::leak::LEAK_REACH;
use crate::gbuffer::{Coverage, GBuffer, SplatSettings};
use crate::job::Job;

gpu_struct! {
    /// What one dispatch of `leak` or `fill` works on.
    pub(super) struct RingParams {
        /// How the G-buffer was projected.
        pinhole: Pinhole,
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// Ring that `fill` closes, counted from 1.
        ring: u32,
    }
}

gpu_struct! {
    /// What one dispatch of `coverage` works on.
    pub(super) struct CoverageParams {
        /// Of the picture, pixels.
        width: u32,
        /// First row.
        first_row: u32,
        /// One past the last row.
        end_row: u32,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
    }
}

/// What one pixel of either pass needs.
const NEED: Need = Need {
    halo: LEAK_REACH as u32,
    bytes: 16,
    steps: 64,
};

impl Gpu {
    /// Pass `fill`.
    pub(super) fn run_fill(
        &mut self,
        gbuffer: &mut GBuffer<Self>,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<()> {
        let pinhole = gbuffer.pinhole;
        let fill = self.kernels.get(&self.device, &FILL)?;
        let leak = self.kernels.get(&self.device, &LEAK)?;
        let all = windows(pinhole.size, NEED, &self.device.limits);
        let mut pass = Pass::new("fill", &self.device, &self.pool, self.stamps.as_ref());
        let ring_params = |window: &Window, ring| RingParams {
            pinhole,
            rows: UVec2::new(window.rows.start, window.rows.end),
            first_pixel: window.pixels.start,
            ring,
        };
        for ring in 1..=settings.fill {
            for window in &all {
                pass.compute(&leak, &ring_params(window, ring))
                    .read(gbuffer.surface.part(&window.pixels))
                    .read(gbuffer.albedo.part(&window.pixels))
                    .write(gbuffer.material.part(&window.pixels))
                    .dispatch(window.threads(pinhole.size))?;
            }
            for window in &all {
                pass.compute(&fill, &ring_params(window, ring))
                    .write(gbuffer.surface.part(&window.pixels))
                    .write(gbuffer.albedo.part(&window.pixels))
                    .write(gbuffer.material.part(&window.pixels))
                    .dispatch(window.threads(pinhole.size))?;
            }
        }
        pass.finish(&mut self.timings, job)
    }

    /// Pass `coverage`.
    pub(super) fn run_coverage(&mut self, gbuffer: &GBuffer<Self>, job: &Job) -> Result<Coverage> {
        let size = gbuffer.pinhole.size;
        let coverage = self.kernels.get(&self.device, &COVERAGE)?;
        let counts = self.pool.take("counting pixels", 12, STORAGE)?;
        let mut pass = Pass::new("coverage", &self.device, &self.pool, self.stamps.as_ref());
        pass.zero(counts.first(12));
        for window in windows(size, NEED, &self.device.limits) {
            let params = CoverageParams {
                width: size.x,
                first_row: window.rows.start,
                end_row: window.rows.end,
                first_pixel: window.pixels.start,
            };
            pass.compute(&coverage, &params)
                .read(gbuffer.albedo.part(&window.pixels))
                .read(gbuffer.material.part(&window.pixels))
                .write(counts.first(12))
                .dispatch(window.threads(size))?;
        }
        pass.finish(&mut self.timings, job)?;
        let [splatted, filled, mirror] = counts.download::<u32>(3)?[..] else {
            return Err(Error::Gpu("the counts of pixels are missing".into()));
        };
        Ok(Coverage {
            pixels: u64::from(size.x) * u64::from(size.y),
            splatted: splatted.into(),
            filled: filled.into(),
            mirror: mirror.into(),
        })
    }
}
