//! Pass `shade` on the device, light by light. Twin: `src/gi/shade.rs`.

use bytemuck::Zeroable;
use glam::{UVec2, Vec3, Vec4};

use super::Gpu;
use super::buffers::{Binding, GpuGrid};
use super::kernel::Pass;
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::SHADE;
use super::windows::{Need, windows};
use crate::backend::LitBy;
use crate::camera::Pinhole;
use crate::error::{Error, Result};
use crate::gbuffer::{EMPTY, GBuffer};
use crate::gi::GiSettings;
use crate::job::Job;

gpu_struct! {
    /// What one dispatch of `shade` works on.
    pub(super) struct ShadeParams {
        /// The eye's.
        pinhole: Pinhole,
        /// The light map's.
        light_pinhole: Pinhole,
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
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// Number of the first texel that the second binding of the light map holds.
        split: u32,
        /// 1 where the radiance so far is none.
        first_light: u32,
        /// 1 where the cone is a square pyramid, full all over.
        pyramid: u32,
        /// What colours are multiplied with to be reflectances.
        albedo_scale: f32,
        /// The struct's size is a multiple of 16.
        pad2: u32,
    }
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

        // Without a light everything is black, as under one of no intensity.
        let dark = GpuGrid::<u32>::new(&self.pool, UVec2::ONE)?;
        let mut spots = Vec::new();
        for LitBy { light, map } in lights {
            let (low, high, split) = split_map(&map.keys, &self.device.limits)?;
            let params = ShadeParams {
                light_pinhole: map.pinhole,
                position: light.position,
                inner_angle: light.inner_angle,
                axis: light.axis,
                outer_angle: light.outer_angle,
                intensity: light.intensity,
                bias: settings.light_bias,
                split,
                pyramid: u32::from(light.pyramid),
                albedo_scale: settings.albedo_scale,
                ..ShadeParams::zeroed()
            };
            spots.push((params, low, high));
        }
        if spots.is_empty() {
            dark.upload(&[EMPTY])?;
            spots.push((ShadeParams::zeroed(), dark.whole(), dark.whole()));
        }

        let mut pass = Pass::new("shade", &self.device, &self.pool, self.stamps.as_ref());
        for window in windows(
            pinhole.size,
            Need {
                halo: 0,
                bytes: 16,
                steps: 16,
            },
            &self.device.limits,
        ) {
            for (i, (params, low, high)) in spots.iter().enumerate() {
                let params = ShadeParams {
                    pinhole,
                    rows: UVec2::new(window.rows.start, window.rows.end),
                    first_pixel: window.pixels.start,
                    first_light: u32::from(i == 0),
                    ..*params
                };
                pass.compute(&kernel, &params)
                    .read(gbuffer.surface.part(&window.pixels))
                    .read(gbuffer.albedo.part(&window.pixels))
                    .read(gbuffer.material.part(&window.pixels))
                    .read(low.clone())
                    .read(high.clone())
                    .write(radiance.part(&window.pixels))
                    .dispatch(window.threads(pinhole.size))?;
            }
        }
        pass.finish(&mut self.timings, job)?;
        Ok(radiance)
    }
}
