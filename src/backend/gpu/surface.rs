//! Passes `surface` and `reflected_rays` on the device. Twins: `src/reflect/{surface,mirror_gbuffer}.rs`.

use glam::{UVec2, Vec3, Vec4};

use super::Gpu;
use super::buffers::{Binding, GpuGrid};
use super::kernel::Pass;
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::{REFLECTED_RAYS, SURFACE};
use super::windows::{Need, Window, windows};
use crate::camera::Pinhole;
use crate::error::Result;
use crate::gbuffer::GBuffer;
use crate::job::Job;
use crate::reflect::{Eye, MirrorGBuffer, Surface};

gpu_struct! {
    /// What one dispatch of `surface` works on.
    pub(super) struct SurfaceParams {
        /// How the G-buffer was projected.
        pinhole: Pinhole,
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        pad: u32,
    }
}

gpu_struct! {
    /// From where a mirror is seen.
    pub(super) struct EyeParams {
        /// Relative to the scene's origin.
        point: Vec3,
        /// 1 where every pixel has an eye of its own.
        per_pixel: u32,
    }
}

gpu_struct! {
    /// What one dispatch of `reflected_rays` works on.
    pub(super) struct ReflectedRaysParams {
        /// From where the mirrors are seen.
        eye: EyeParams,
        /// Of the picture, pixels.
        size: UVec2,
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// The struct's size is a multiple of 16.
        pad0: u32,
        /// As `pad0`.
        pad1: u32,
        /// As `pad0`.
        pad2: u32,
    }
}

/// What a pixel of passes without neighbours needs.
pub(super) const LOCAL: Need = Need {
    halo: 0,
    bytes: 16,
    steps: 4,
};

impl Surface<Gpu> {
    /// The eye, and its binding of a window: where there is one for all, any grid stands for the eyes that none reads.
    pub(super) fn eye_of(&self, window: &Window) -> (EyeParams, Binding) {
        let (point, per_pixel, eyes) = match &self.eye {
            Eye::Point(point) => (*point, 0, &self.point),
            Eye::PerPixel(eyes) => (Vec3::ZERO, 1, eyes),
        };
        (EyeParams { point, per_pixel }, eyes.part(&window.pixels))
    }
}

impl Gpu {
    /// Pass `surface`.
    pub(super) fn run_surface(
        &mut self,
        gbuffer: &GBuffer<Self>,
        job: &Job,
    ) -> Result<Surface<Self>> {
        let pinhole = gbuffer.pinhole;
        let size = pinhole.size;
        let kernel = self.kernels.get(&self.device, &SURFACE)?;
        let grid = || GpuGrid::<Vec4>::new(&self.pool, size);
        let (point, normal) = (grid()?, grid()?);
        let mut pass = Pass::new(SURFACE.name, &self.device, &self.pool, self.stamps.as_ref());
        for window in windows(size, LOCAL, &self.device.limits) {
            let params = SurfaceParams {
                pinhole,
                rows: UVec2::new(window.rows.start, window.rows.end),
                first_pixel: window.pixels.start,
                pad: 0,
            };
            pass.compute(&kernel, &params)
                .read(gbuffer.surface.part(&window.pixels))
                .read(gbuffer.albedo.part(&window.pixels))
                .read(gbuffer.material.part(&window.pixels))
                .write(point.part(&window.pixels))
                .write(normal.part(&window.pixels))
                .dispatch(window.threads(size))?;
        }
        pass.finish(&mut self.timings, job)?;
        Ok(Surface {
            size,
            point,
            normal,
            eye: Eye::Point(pinhole.eye),
        })
    }

    /// Pass `reflected_rays`.
    pub(super) fn run_reflected_rays(
        &mut self,
        surface: &Surface<Self>,
        job: &Job,
    ) -> Result<MirrorGBuffer<Self>> {
        let size = surface.size;
        let kernel = self.kernels.get(&self.device, &REFLECTED_RAYS)?;
        let vectors = || GpuGrid::<Vec4>::new(&self.pool, size);
        let mirror = MirrorGBuffer::<Self> {
            origin: vectors()?,
            direction: vectors()?,
            surface: vectors()?,
            albedo: vectors()?,
            material: vectors()?,
            region: GpuGrid::new(&self.pool, size)?,
            count: GpuGrid::new(&self.pool, size)?,
            level: GpuGrid::new(&self.pool, size)?,
        };
        let mut pass = Pass::new(
            REFLECTED_RAYS.name,
            &self.device,
            &self.pool,
            self.stamps.as_ref(),
        );
        for grid in [&mirror.surface, &mirror.albedo, &mirror.material] {
            pass.zero(grid.whole());
        }
        for grid in [&mirror.region, &mirror.count] {
            pass.zero(grid.whole());
        }
        pass.zero(mirror.level.whole());
        for window in windows(size, LOCAL, &self.device.limits) {
            let (eye, eyes) = surface.eye_of(&window);
            let params = ReflectedRaysParams {
                eye,
                size,
                rows: UVec2::new(window.rows.start, window.rows.end),
                first_pixel: window.pixels.start,
                pad0: 0,
                pad1: 0,
                pad2: 0,
            };
            pass.compute(&kernel, &params)
                .read(surface.point.part(&window.pixels))
                .read(surface.normal.part(&window.pixels))
                .read(eyes)
                .write(mirror.origin.part(&window.pixels))
                .write(mirror.direction.part(&window.pixels))
                .dispatch(window.threads(size))?;
        }
        pass.finish(&mut self.timings, job)?;
        Ok(mirror)
    }
}
