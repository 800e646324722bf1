//! Pass `ism` on the device, and the bands in which its maps are bound. Twin: `src/gi/ism.rs`.

use std::ops::Range;

use bytemuck::Pod;
use glam::UVec2;

use super::Gpu;
use super::buffers::{BINDING_ALIGNMENT, Binding, Buffer, GpuGrid, GpuPoints, STORAGE};
use super::kernel::{Pass, Threads};
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::{CLEAR, ISM};
use super::splat::ClearParams;
use crate::error::{Error, Result};
use crate::gbuffer::disc::MIN_HALF_WIDTH;
use crate::gi::ism::{DISC, IsmMaps, Slices};
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

/// Texels of maps, by number.
pub(super) fn texels_of(maps: &Range<u32>, side: u32) -> Range<u32> {
    maps.start * side * side..maps.end * side * side
}

impl Gpu {
    /// A list, on the device.
    pub(super) fn list<T: Pod>(&self, what: &str, values: &[T]) -> Result<(Buffer, Binding)> {
        let bytes = size_of_val(values) as u64;
        let buffer = self.pool.take(what, bytes, STORAGE)?;
        buffer.upload(0, bytemuck::cast_slice(values))?;
        let binding = buffer.first(bytes);
        Ok((buffer, binding))
    }

    /// Maps, in bands that one binding holds.
    pub(super) fn map_bands(&self, side: u32, count: u32) -> Result<Vec<Range<u32>>> {
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
}
