//! Passes `blend` and `mirror_coverage` on the device. Twins: `src/reflect/{blend,mirror_gbuffer}.rs`.

use glam::{UVec2, Vec4};

use super::Gpu;
use super::buffers::{GpuGrid, STORAGE};
use super::fill::CoverageParams;
use super::kernel::Pass;
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::{BLEND, MIRROR_COVERAGE};
use super::surface::LOCAL;
use super::windows::windows;
use crate::error::{Error, Result};
use crate::gbuffer::GBuffer;
use crate::job::Job;
use crate::reflect::{MirrorCoverage, MirrorGBuffer};

gpu_struct! {
    /// What one dispatch of `blend` works on.
    pub(super) struct BlendParams {
        /// Of the picture, pixels.
        size: UVec2,
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// 1 where mirrors show radiance, 0 where there is no light and they show albedo.
        lit: u32,
        pad: UVec2,
    }
}

impl Gpu {
    /// Pass `blend`.
    pub(super) fn run_blend(
        &mut self,
        radiance: &mut GpuGrid<Vec4>,
        gbuffer: &GBuffer<Self>,
        mirror: &MirrorGBuffer<Self>,
        shown: Option<&GpuGrid<Vec4>>,
        job: &Job,
    ) -> Result<()> {
        let size = radiance.size();
        let kernel = self.kernels.get(&self.device, &BLEND)?;
        // Any grid stands for the radiance that no thread reads.
        let (lit, shown) = (shown.is_some(), shown.unwrap_or(&mirror.albedo));
        let mut pass = Pass::new(BLEND.name, &self.device, &self.pool, self.stamps.as_ref());
        for window in windows(size, LOCAL, &self.device.limits) {
            let params = BlendParams {
                size,
                rows: UVec2::new(window.rows.start, window.rows.end),
                first_pixel: window.pixels.start,
                lit: u32::from(lit),
                pad: UVec2::ZERO,
            };
            pass.compute(&kernel, &params)
                .read(gbuffer.albedo.part(&window.pixels))
                .read(mirror.albedo.part(&window.pixels))
                .read(mirror.material.part(&window.pixels))
                .read(shown.part(&window.pixels))
                .write(radiance.part(&window.pixels))
                .dispatch(window.threads(size))?;
        }
        pass.finish(&mut self.timings, job)
    }

    /// Pass `mirror_coverage`.
    pub(super) fn run_mirror_coverage(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        job: &Job,
    ) -> Result<MirrorCoverage> {
        let size = mirror.origin.size();
        let kernel = self.kernels.get(&self.device, &MIRROR_COVERAGE)?;
        let counts = self.pool.take("counting pixels", 12, STORAGE)?;
        let mut pass = Pass::new(
            MIRROR_COVERAGE.name,
            &self.device,
            &self.pool,
            self.stamps.as_ref(),
        );
        pass.zero(counts.first(12));
        for window in windows(size, LOCAL, &self.device.limits) {
            let params = CoverageParams {
                width: size.x,
                first_row: window.rows.start,
                end_row: window.rows.end,
                first_pixel: window.pixels.start,
            };
            pass.compute(&kernel, &params)
                .read(mirror.origin.part(&window.pixels))
                .read(mirror.albedo.part(&window.pixels))
                .read(mirror.material.part(&window.pixels))
                .write(counts.first(12))
                .dispatch(window.threads(size))?;
        }
        pass.finish(&mut self.timings, job)?;
        let [pixels, covered, mirrors] = counts.download::<u32>(3)?[..] else {
            return Err(Error::Gpu("the counts of pixels are missing".into()));
        };
        Ok(MirrorCoverage {
            pixels: pixels.into(),
            covered: covered.into(),
            mirrors: mirrors.into(),
        })
    }
}
