//! Passes `photons` and `add_indirect` on the device. Twins: the files of these names in `src/gi/`.

use glam::{UVec2, UVec3, Vec3, Vec4};

use super::Gpu;
use super::buffers::GpuGrid;
use super::gather::{need, rows_of};
use super::kernel::Pass;
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::{ADD_INDIRECT, PHOTONS};
use super::windows::windows;
use crate::error::Result;
use crate::gi::GiSettings;
use crate::gi::gather::Gathered;
use crate::gi::photons::{Photon, PhotonMap};
use crate::gi::receivers::Receivers;
use crate::job::Job;

/// Photons that a pixel looks at, roughly.
const PHOTON_STEPS: u64 = 128;

gpu_layout!(Photon {
    position,
    pad0,
    normal,
    pad1,
    irradiance,
    pad2,
});

gpu_struct! {
    /// What one dispatch of `photons` works on.
    pub(super) struct PhotonParams {
        /// Smallest, of the cubes.
        corner: Vec3,
        /// Side of a cube.
        cell: f32,
        /// Along each axis.
        cells: UVec3,
        /// 1 over the squared distance that a photon reaches.
        inverse_square: f32,
        /// First row, and one past the last.
        rows: UVec2,
        /// Of the picture, pixels.
        width: u32,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// That is bound.
        first_photon: u32,
        /// One past the last of them.
        end_photon: u32,
        /// The struct's size is a multiple of 16.
        pad0: u32,
        /// As `pad0`.
        pad1: u32,
    }
}

gpu_struct! {
    /// What one dispatch of `add_indirect` works on.
    pub(super) struct AddParams {
        /// First row, and one past the last.
        rows: UVec2,
        /// Of the picture, pixels.
        width: u32,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// What colours are multiplied with to be reflectances.
        albedo_scale: f32,
        /// The struct's size is a multiple of 16.
        pad0: u32,
        /// As `pad0`.
        pad1: u32,
        /// As `pad0`.
        pad2: u32,
    }
}

impl Gpu {
    /// Pass `photons`.
    pub(super) fn run_photons(
        &mut self,
        receivers: &Receivers<Self>,
        map: &PhotonMap,
        irradiance: &mut GpuGrid<Vec4>,
        job: &Job,
    ) -> Result<()> {
        let kernel = self.kernels.get(&self.device, &PHOTONS)?;
        let size = receivers.size;
        let (_starts, starts) = self.list("photons", &map.starts)?;
        let photon = size_of::<Photon>();
        let held = (self.device.limits.max_storage_buffer_binding_size as usize / photon).max(1);
        let mut bands = Vec::new();
        for band in map.photons.chunks(held) {
            bands.push((band.len() as u32, self.list("photons", band)?));
        }
        let stamps = self.stamps.as_ref();
        let mut pass = Pass::new(PHOTONS.name, &self.device, &self.pool, stamps);
        for window in windows(size, need(PHOTON_STEPS), &self.device.limits) {
            let mut first_photon = 0;
            for (count, (_held, photons)) in &bands {
                let params = PhotonParams {
                    corner: map.corner,
                    cell: map.cell,
                    cells: map.cells,
                    inverse_square: 1.0 / (map.radius * map.radius),
                    rows: rows_of(&window),
                    width: size.x,
                    first_pixel: window.pixels.start,
                    first_photon,
                    end_photon: first_photon + count,
                    pad0: 0,
                    pad1: 0,
                };
                pass.compute(&kernel, &params)
                    .read(receivers.position.part(&window.pixels))
                    .read(receivers.normal.part(&window.pixels))
                    .read(starts.clone())
                    .read(photons.clone())
                    .write(irradiance.part(&window.pixels))
                    .dispatch(window.threads(size))?;
                first_photon += count;
            }
        }
        pass.finish(&mut self.timings, job)
    }

    /// Pass `add_indirect`.
    pub(super) fn run_add_indirect(
        &mut self,
        albedo: &GpuGrid<Vec4>,
        light: &Gathered<Self>,
        settings: &GiSettings,
        radiance: &mut GpuGrid<Vec4>,
        job: &Job,
    ) -> Result<()> {
        let kernel = self.kernels.get(&self.device, &ADD_INDIRECT)?;
        let size = radiance.size();
        let stamps = self.stamps.as_ref();
        let mut pass = Pass::new(ADD_INDIRECT.name, &self.device, &self.pool, stamps);
        for window in windows(size, need(1), &self.device.limits) {
            let params = AddParams {
                rows: rows_of(&window),
                width: size.x,
                first_pixel: window.pixels.start,
                albedo_scale: settings.albedo_scale,
                pad0: 0,
                pad1: 0,
                pad2: 0,
            };
            pass.compute(&kernel, &params)
                .read(albedo.part(&window.pixels))
                .read(light.irradiance.part(&window.pixels))
                .read(light.residual.part(&window.pixels))
                .write(radiance.part(&window.pixels))
                .dispatch(window.threads(size))?;
        }
        pass.finish(&mut self.timings, job)
    }
}
