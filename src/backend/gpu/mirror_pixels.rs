//! The mirrors of a picture, laid out for searches on the device. Twin: `src/reflect/sscr/mirror_pixels.rs`.

use glam::{UVec2, Vec3, Vec4};

use super::Gpu;
use super::buffers::{Binding, GpuGrid};
use super::kernel::Pass;
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::MIRROR_PIXELS;
use super::surface::{EyeParams, LOCAL};
use super::windows::windows;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::reflect::LabelledMirrors;
use crate::reflect::sscr::around;

gpu_struct! {
    /// What one dispatch of `mirror_pixels` works on.
    pub(super) struct MirrorPixelsParams {
        /// From where the mirrors are seen.
        eye: EyeParams,
        /// The picture's x axis in the scene, unit vector.
        right: Vec3,
        /// Of the picture, pixels.
        width: u32,
        /// First pixel of the rectangle around all regions.
        first: UVec2,
        /// Of the rectangle, pixels.
        size: UVec2,
        /// First row, and one past the last, of the picture.
        rows: UVec2,
        /// Number of the first pixel of the picture's bindings, row by row.
        first_pixel: u32,
        pad: u32,
    }
}

/// The mirrors in the rectangle around all regions: four vectors a pixel, as `shared/root_find.wgsl` reads them.
#[derive(Debug)]
pub(super) struct MirrorPixels {
    /// First pixel of the rectangle.
    pub(super) first: UVec2,
    /// Of the rectangle, pixels.
    pub(super) size: UVec2,
    position: GpuGrid<[u32; 4]>,
    normal: GpuGrid<Vec4>,
    to_eye: GpuGrid<Vec4>,
    right: GpuGrid<Vec4>,
}

impl MirrorPixels {
    /// Position and region; normal and spacing; direction to the eye; mirror space's x axis.
    pub(super) fn bindings(&self) -> [Binding; 4] {
        [
            self.position.whole(),
            self.normal.whole(),
            self.to_eye.whole(),
            self.right.whole(),
        ]
    }
}

impl Gpu {
    /// Lays out the mirrors of a picture that has regions.
    pub(super) fn mirror_pixels(
        &mut self,
        mirrors: &LabelledMirrors<'_, Self>,
        job: &Job,
    ) -> Result<MirrorPixels> {
        let bounds = around(mirrors.regions);
        let first = UVec2::new(bounds.x0, bounds.y0);
        let size = UVec2::new(bounds.x1, bounds.y1).saturating_sub(first);
        let bytes = u64::from(size.x) * u64::from(size.y) * size_of::<Vec4>() as u64;
        if bytes > self.device.limits.max_storage_buffer_binding_size {
            return Err(Error::Memory {
                what: format!("searching mirrors of {} x {} pixels", size.x, size.y),
                needed: bytes,
                budget: self.device.limits.max_storage_buffer_binding_size,
            });
        }
        let kernel = self.kernels.get(&self.device, &MIRROR_PIXELS)?;
        let laid_out = MirrorPixels {
            first,
            size,
            position: GpuGrid::new(&self.pool, size)?,
            normal: GpuGrid::new(&self.pool, size)?,
            to_eye: GpuGrid::new(&self.pool, size)?,
            right: GpuGrid::new(&self.pool, size)?,
        };
        let surface = mirrors.surface;
        let mut pass = Pass::new(
            MIRROR_PIXELS.name,
            &self.device,
            &self.pool,
            self.stamps.as_ref(),
        );
        for window in windows(surface.size, LOCAL, &self.device.limits) {
            let rows = window.rows.start.max(bounds.y0)..window.rows.end.min(bounds.y1);
            if rows.is_empty() {
                continue;
            }
            let (eye, eyes) = surface.eye_of(&window);
            let params = MirrorPixelsParams {
                eye,
                right: mirrors.right,
                width: surface.size.x,
                first,
                size,
                rows: UVec2::new(rows.start, rows.end),
                first_pixel: window.pixels.start,
                pad: 0,
            };
            let [position, normal, to_eye, right] = laid_out.bindings();
            pass.compute(&kernel, &params)
                .read(surface.point.part(&window.pixels))
                .read(surface.normal.part(&window.pixels))
                .read(eyes)
                .read(mirrors.labels.part(&window.pixels))
                .write(position)
                .write(normal)
                .write(to_eye)
                .write(right)
                .dispatch(super::kernel::Threads::Pixels(UVec2::new(
                    size.x,
                    rows.end - rows.start,
                )))?;
        }
        pass.finish(&mut self.timings, job)?;
        Ok(laid_out)
    }
}
