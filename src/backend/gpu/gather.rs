//! Passes `ism`, `gather`, `indirect_filter`, `photons` and `add_indirect` on the device. Twins: the files of these names in
//! `src/gi/`.

use std::ops::Range;

use bytemuck::Pod;
use glam::{UVec2, UVec3, Vec3, Vec4};

use super::Gpu;
use super::buffers::{BINDING_ALIGNMENT, Binding, Buffer, GpuGrid, GpuPoints, STORAGE};
use super::kernel::{Pass, Threads};
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::{ADD_INDIRECT, CLEAR, GATHER, INDIRECT_FILTER, ISM, PHOTONS};
use super::splat::ClearParams;
use super::windows::{Need, Window as Rows, windows};
use crate::error::{Error, Result};
use crate::gbuffer::disc::MIN_HALF_WIDTH;
use crate::gi::GiSettings;
use crate::gi::gather::Gathered;
use crate::gi::indirect_filter::Window;
use crate::gi::ism::{BIAS_SPACINGS, DISC, IsmMaps, Slices};
use crate::gi::photons::{Photon, PhotonMap};
use crate::gi::receivers::Receivers;
use crate::gi::vpl::Vpl;
use crate::job::Job;

/// Surfels of one submission of `ism`, in all maps.
const CHUNK: u32 = 1 << 20;

/// Columns of threads that clear maps.
const CLEAR_WIDTH: u32 = 4096;

gpu_layout!(Vpl {
    position,
    softening,
    normal,
    shininess,
    flux,
    specular,
    incident,
    spacing,
    mirrored,
    slice,
    right,
    pad0,
    up,
    pad1,
});

gpu_layout!(Photon {
    position,
    pad0,
    normal,
    pad1,
    irradiance,
    pad2,
});

gpu_struct! {
    /// What one dispatch of `ism` works on.
    pub(super) struct IsmParams {
        /// Of a map, texels.
        side: u32,
        /// Surfels in a slice.
        points: u32,
        /// Surfels from which slices are taken.
        pool: u32,
        /// Of this dispatch.
        first_map: u32,
        /// Whose keys are bound.
        first_key_map: u32,
        /// Of the bound surfels.
        first_point: u32,
        /// One past the last of them.
        end_point: u32,
        /// Of a disc, over the surfel's radius.
        half_width: f32,
        /// Texels.
        min_half_width: f32,
        /// 2 / side.
        texel: f32,
        /// The struct's size is a multiple of 16.
        pad0: u32,
        /// As `pad0`.
        pad1: u32,
    }
}

gpu_struct! {
    /// What one dispatch of `gather` works on.
    pub(super) struct GatherParams {
        /// Of the picture, pixels.
        size: UVec2,
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// n.
        interleave: u32,
        /// Lights of the batch.
        vpl_count: u32,
        /// Whose maps are bound.
        first_vpl: u32,
        /// One past the last of them.
        end_vpl: u32,
        /// Of a map, texels.
        side: u32,
        /// Over the local spacing.
        bias: f32,
        /// The struct's size is a multiple of 16.
        pad0: u32,
    }
}

gpu_struct! {
    /// What one dispatch of `indirect_filter` works on.
    pub(super) struct FilterParams {
        /// Of the picture, pixels.
        size: UVec2,
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// Pixels of the window on each side.
        reach: i32,
        /// From pixel to pixel of the window.
        stride: i32,
        /// What the outermost pixels count.
        end: f32,
        /// 1: down the columns.
        down: u32,
        /// The struct's size is a multiple of 16.
        pad0: u32,
        /// As `pad0`.
        pad1: u32,
        /// As `pad0`.
        pad2: u32,
    }
}

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

/// Texels of maps, by number.
fn texels_of(maps: &Range<u32>, side: u32) -> Range<u32> {
    maps.start * side * side..maps.end * side * side
}

fn rows_of(rows: &Rows) -> UVec2 {
    UVec2::new(rows.rows.start, rows.rows.end)
}

/// A pixel of the passes that look at one pixel, in so many steps.
fn need(steps: u64) -> Need {
    Need {
        halo: 0,
        bytes: 16,
        steps,
    }
}

impl Gpu {
    /// A list, on the device.
    fn list<T: Pod>(&self, what: &str, values: &[T]) -> Result<(Buffer, Binding)> {
        let bytes = size_of_val(values) as u64;
        let buffer = self.pool.take(what, bytes, STORAGE)?;
        buffer.upload(0, bytemuck::cast_slice(values))?;
        let binding = buffer.first(bytes);
        Ok((buffer, binding))
    }

    /// Maps, in bands that one binding holds.
    fn map_bands(&self, side: u32, count: u32) -> Result<Vec<Range<u32>>> {
        let map = u64::from(side * side) * 4;
        let limit = self.device.limits.max_storage_buffer_binding_size;
        let held = u32::try_from(limit / map).unwrap_or(u32::MAX);
        // Bands start where bindings may.
        let aligned = (1..=64u32).find(|n| (u64::from(*n) * map).is_multiple_of(BINDING_ALIGNMENT));
        let aligned = aligned.unwrap_or(64);
        let band = if held >= count {
            count.max(1)
        } else {
            held / aligned * aligned
        };
        if band == 0 {
            return Err(Error::Memory {
                what: "a virtual light's map (gi.ism_size)".into(),
                needed: map * u64::from(aligned),
                budget: limit,
            });
        }
        let bands = (0..count).step_by(band as usize);
        Ok(bands
            .map(|first| first..(first + band).min(count))
            .collect())
    }

    /// Pass `ism`.
    pub(super) fn run_ism(
        &mut self,
        points: &GpuPoints,
        vpls: &[Vpl],
        slices: Slices,
        job: &Job,
    ) -> Result<IsmMaps<Self>> {
        let (clear, kernel) = (
            self.kernels.get(&self.device, &CLEAR)?,
            self.kernels.get(&self.device, &ISM)?,
        );
        let side = slices.side;
        let count = vpls.len() as u32;
        let keys = GpuGrid::<u32>::new(&self.pool, UVec2::new(side, side * count))?;
        let (_held, lights) = self.list("virtual lights", vpls)?;
        let stamps = self.stamps.as_ref();
        let mut pass = Pass::new(ISM.name, &self.device, &self.pool, stamps);
        for bound in self.map_bands(side, count)? {
            let texels = texels_of(&bound, side);
            let (width, pixels) = (CLEAR_WIDTH, texels.end - texels.start);
            pass.compute(&clear, &ClearParams { width, pixels })
                .write(keys.part(&texels))
                .dispatch(Threads::Pixels(UVec2::new(width, pixels.div_ceil(width))))?;
        }
        let chunk = (CHUNK / slices.points.max(1)).max(1);
        let mut first_point = 0;
        for band in &points.bands {
            let end_point = first_point + band.count;
            if slices.points == 0 || first_point >= slices.pool {
                break;
            }
            for bound in self.map_bands(side, count)? {
                for first_map in bound.clone().step_by(chunk as usize) {
                    let params = IsmParams {
                        side,
                        points: slices.points,
                        pool: slices.pool,
                        first_map,
                        first_key_map: bound.start,
                        first_point,
                        end_point,
                        half_width: DISC * slices.thinning,
                        min_half_width: MIN_HALF_WIDTH,
                        texel: 2.0 / side as f32,
                        pad0: 0,
                        pad1: 0,
                    };
                    pass.compute(&kernel, &params)
                        .read(lights.clone())
                        .read(band.places())
                        .read(band.finishes())
                        .write(keys.part(&texels_of(&bound, side)))
                        .dispatch(Threads::Sets {
                            points: slices.points,
                            sets: chunk.min(bound.end - first_map),
                        })?;
                }
            }
            first_point = end_point;
        }
        pass.finish(&mut self.timings, job)?;
        Ok(IsmMaps { slices, keys })
    }

    /// Pass `gather`.
    pub(super) fn run_gather(
        &mut self,
        receivers: &Receivers<Self>,
        vpls: &[Vpl],
        maps: &IsmMaps<Self>,
        interleave: u32,
        gathered: &mut Gathered<Self>,
        job: &Job,
    ) -> Result<()> {
        let kernel = self.kernels.get(&self.device, &GATHER)?;
        let size = receivers.size;
        let (_held, lights) = self.list("virtual lights", vpls)?;
        let interleave = interleave.max(1);
        let each = vpls.len() as u64 / u64::from(interleave * interleave) + 1;
        let stamps = self.stamps.as_ref();
        let mut pass = Pass::new(GATHER.name, &self.device, &self.pool, stamps);
        for window in windows(size, need(8 * each), &self.device.limits) {
            for bound in self.map_bands(maps.slices.side, vpls.len() as u32)? {
                let params = GatherParams {
                    size,
                    rows: rows_of(&window),
                    first_pixel: window.pixels.start,
                    interleave,
                    vpl_count: vpls.len() as u32,
                    first_vpl: bound.start,
                    end_vpl: bound.end,
                    side: maps.slices.side,
                    bias: BIAS_SPACINGS * maps.slices.thinning,
                    pad0: 0,
                };
                pass.compute(&kernel, &params)
                    .read(receivers.position.part(&window.pixels))
                    .read(receivers.normal.part(&window.pixels))
                    .read(receivers.view.part(&window.pixels))
                    .read(lights.clone())
                    .read(maps.keys.part(&texels_of(&bound, maps.slices.side)))
                    .write(gathered.irradiance.part(&window.pixels))
                    .write(gathered.residual.part(&window.pixels))
                    .dispatch(window.threads(size))?;
            }
        }
        pass.finish(&mut self.timings, job)
    }

    /// Pass `indirect_filter`.
    pub(super) fn run_indirect_filter(
        &mut self,
        receivers: &Receivers<Self>,
        irradiance: &GpuGrid<Vec4>,
        window: Window,
        job: &Job,
    ) -> Result<GpuGrid<Vec4>> {
        let kernel = self.kernels.get(&self.device, &INDIRECT_FILTER)?;
        let size = receivers.size;
        let across = GpuGrid::<Vec4>::new(&self.pool, size)?;
        let merged = GpuGrid::<Vec4>::new(&self.pool, size)?;
        let stamps = self.stamps.as_ref();
        let mut pass = Pass::new(INDIRECT_FILTER.name, &self.device, &self.pool, stamps);
        for (down, from, to) in [(0, irradiance, &across), (1, &across, &merged)] {
            let need = Need {
                halo: down * (window.reach * window.stride) as u32,
                ..need(2 * window.reach as u64 + 1)
            };
            for rows in windows(size, need, &self.device.limits) {
                let params = FilterParams {
                    size,
                    rows: rows_of(&rows),
                    first_pixel: rows.pixels.start,
                    reach: window.reach,
                    stride: window.stride,
                    end: window.end,
                    down,
                    pad0: 0,
                    pad1: 0,
                    pad2: 0,
                };
                pass.compute(&kernel, &params)
                    .read(receivers.position.part(&rows.pixels))
                    .read(receivers.normal.part(&rows.pixels))
                    .read(from.part(&rows.pixels))
                    .write(to.part(&rows.pixels))
                    .dispatch(rows.threads(size))?;
            }
        }
        pass.finish(&mut self.timings, job)?;
        Ok(merged)
    }

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

/// Photons that a pixel looks at, roughly.
const PHOTON_STEPS: u64 = 128;
