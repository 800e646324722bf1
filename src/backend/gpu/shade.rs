//! Passes `shade` and `shade_mirror` on the device, light by light. Twin: `src/gi/shade.rs`.

use bytemuck::Zeroable;
use glam::{UVec2, Vec3, Vec4};

use super::Gpu;
use super::buffers::{Binding, GpuGrid};
use super::kernel::Pass;
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::{SHADE, SHADE_MIRROR};
use super::windows::{Need, windows};
use crate::backend::LitBy;
use crate::camera::Pinhole;
use crate::error::{Error, Result};
use crate::gbuffer::{EMPTY, GBuffer};
use crate::gi::GiSettings;
use crate::job::Job;
use crate::reflect::MirrorGBuffer;

gpu_struct! {
    /// A spot light and its map.
    pub(super) struct LightParams {
        /// Of the light's map.
        pinhole: Pinhole,
        /// Of the light, relative to the scene's origin.
        position: Vec3,
        /// Half angle, radians.
        inner_angle: f32,
        /// Of the light, unit vector.
        axis: Vec3,
        /// Half angle, radians.
        outer_angle: f32,
        /// W/sr per channel.
        intensity: Vec3,
        /// Over the local spacing.
        bias: f32,
        /// Number of the first texel that the second binding of the light map holds.
        split: u32,
        /// 1 where the radiance so far is none.
        first: u32,
        /// 1 where the cone is a square pyramid, full all over.
        pyramid: u32,
        /// What colours are multiplied with to be reflectances.
        albedo_scale: f32,
    }
}

gpu_struct! {
    /// What one dispatch of `shade` works on.
    pub(super) struct ShadeParams {
        /// The eye's.
        pinhole: Pinhole,
        /// The light.
        light: LightParams,
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        pad: u32,
    }
}

gpu_struct! {
    /// What one dispatch of `shade_mirror` works on.
    pub(super) struct ShadeMirrorParams {
        /// The light.
        light: LightParams,
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

/// What a pixel needs of either pass.
const NEED: Need = Need {
    halo: 0,
    bytes: 16,
    steps: 16,
};

/// A light as kernels see it: parameters, and its map in two bindings.
struct Spot {
    params: LightParams,
    low: Binding,
    high: Binding,
}

/// A light map in two bindings, and the first texel of the second: where one binding holds it all, both are the same.
fn split_map(keys: &GpuGrid<u32>, limits: &wgpu::Limits) -> Result<(Binding, Binding, u32)> {
    let texels = keys.size().x * keys.size().y;
    let held =
        (limits.max_storage_buffer_binding_size / 4).min(u64::from(u32::MAX)) as u32 / 256 * 256;
    if texels <= held {
        return Ok((keys.whole(), keys.whole(), u32::MAX));
    }
    if texels - held > held {
        let (needed, budget) = (u64::from(texels) * 4, u64::from(held) * 8);
        return Err(Error::Memory {
            what: "the light's map (gi.light_map_size)".into(),
            needed,
            budget,
        });
    }
    Ok((keys.part(&(0..held)), keys.part(&(held..texels)), held))
}

impl Gpu {
    /// The lights as kernels see them; `dark`, of one texel, is the map of the light that stands for none.
    fn spots(
        &self,
        lights: &[LitBy<Self>],
        dark: &GpuGrid<u32>,
        settings: &GiSettings,
    ) -> Result<Vec<Spot>> {
        let mut spots = Vec::with_capacity(lights.len().max(1));
        for LitBy { light, map } in lights {
            let (low, high, split) = split_map(&map.keys, &self.device.limits)?;
            let params = LightParams {
                pinhole: map.pinhole,
                position: light.position,
                inner_angle: light.inner_angle,
                axis: light.axis,
                outer_angle: light.outer_angle,
                intensity: light.intensity,
                bias: settings.light_bias,
                split,
                first: u32::from(spots.is_empty()),
                pyramid: u32::from(light.pyramid),
                albedo_scale: settings.albedo_scale,
            };
            spots.push(Spot { params, low, high });
        }
        // Without a light everything is black, as under one of no intensity.
        if spots.is_empty() {
            dark.upload(&[EMPTY])?;
            spots.push(Spot {
                params: LightParams {
                    first: 1,
                    ..LightParams::zeroed()
                },
                low: dark.whole(),
                high: dark.whole(),
            });
        }
        Ok(spots)
    }

    /// Pass `shade`.
    pub(super) fn run_shade(
        &mut self,
        gbuffer: &GBuffer<Self>,
        lights: &[LitBy<Self>],
        settings: &GiSettings,
        job: &Job,
    ) -> Result<GpuGrid<Vec4>> {
        let pinhole = gbuffer.pinhole;
        let kernel = self.kernels.get(&self.device, &SHADE)?;
        let radiance = GpuGrid::<Vec4>::new(&self.pool, pinhole.size)?;
        let dark = GpuGrid::<u32>::new(&self.pool, UVec2::ONE)?;
        let spots = self.spots(lights, &dark, settings)?;
        let mut pass = Pass::new(SHADE.name, &self.device, &self.pool, self.stamps.as_ref());
        for window in windows(pinhole.size, NEED, &self.device.limits) {
            for spot in &spots {
                let params = ShadeParams {
                    pinhole,
                    light: spot.params,
                    rows: UVec2::new(window.rows.start, window.rows.end),
                    first_pixel: window.pixels.start,
                    pad: 0,
                };
                pass.compute(&kernel, &params)
                    .read(gbuffer.surface.part(&window.pixels))
                    .read(gbuffer.albedo.part(&window.pixels))
                    .read(gbuffer.material.part(&window.pixels))
                    .read(spot.low.clone())
                    .read(spot.high.clone())
                    .write(radiance.part(&window.pixels))
                    .dispatch(window.threads(pinhole.size))?;
            }
        }
        pass.finish(&mut self.timings, job)?;
        Ok(radiance)
    }

    /// Pass `shade_mirror`.
    pub(super) fn run_shade_mirror(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        lights: &[LitBy<Self>],
        settings: &GiSettings,
        job: &Job,
    ) -> Result<GpuGrid<Vec4>> {
        let size = mirror.origin.size();
        let kernel = self.kernels.get(&self.device, &SHADE_MIRROR)?;
        let radiance = GpuGrid::<Vec4>::new(&self.pool, size)?;
        let dark = GpuGrid::<u32>::new(&self.pool, UVec2::ONE)?;
        let spots = self.spots(lights, &dark, settings)?;
        let mut pass = Pass::new(
            SHADE_MIRROR.name,
            &self.device,
            &self.pool,
            self.stamps.as_ref(),
        );
        for window in windows(size, NEED, &self.device.limits) {
            for spot in &spots {
                let params = ShadeMirrorParams {
                    light: spot.params,
                    size,
                    rows: UVec2::new(window.rows.start, window.rows.end),
                    first_pixel: window.pixels.start,
                    pad0: 0,
                    pad1: 0,
                    pad2: 0,
                };
                pass.compute(&kernel, &params)
                    .read(mirror.origin.part(&window.pixels))
                    .read(mirror.direction.part(&window.pixels))
                    .read(mirror.surface.part(&window.pixels))
                    .read(mirror.albedo.part(&window.pixels))
                    .read(mirror.material.part(&window.pixels))
                    .read(spot.low.clone())
                    .read(spot.high.clone())
                    .write(radiance.part(&window.pixels))
                    .dispatch(window.threads(size))?;
            }
        }
        pass.finish(&mut self.timings, job)?;
        Ok(radiance)
    }
}
