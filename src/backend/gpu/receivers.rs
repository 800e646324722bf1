//! Passes `receivers`, `mirror_receivers` and `settle` on the device. Twins: `src/gi/receivers.rs`, `src/gi/settle.rs`.

use glam::{UVec2, Vec4};

use super::Gpu;
use super::buffers::GpuGrid;
use super::kernel::Pass;
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::{MIRROR_RECEIVERS, RECEIVERS, SETTLE};
use super::windows::{Need, windows};
use crate::camera::Pinhole;
use crate::error::Result;
use crate::gbuffer::GBuffer;
use crate::gi::receivers::Receivers;
use crate::gi::settle::REACH;
use crate::job::Job;
use crate::reflect::MirrorGBuffer;

gpu_struct! {
    /// What one dispatch of `receivers` works on.
    pub(super) struct ReceiverParams {
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
    /// What one dispatch of `mirror_receivers` works on.
    pub(super) struct MirrorReceiverParams {
        /// First row, and one past the last.
        rows: UVec2,
        /// Of the picture, pixels.
        width: u32,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
    }
}

gpu_struct! {
    /// What one dispatch of `settle` works on.
    pub(super) struct SettleParams {
        /// Of the picture, pixels.
        size: UVec2,
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// The struct's size is a multiple of 16.
        pad0: u32,
        /// See `pad0`.
        pad1: u32,
        /// See `pad0`.
        pad2: u32,
    }
}

/// What both passes need per pixel.
const NEED: Need = Need {
    halo: 0,
    bytes: 16,
    steps: 4,
};

impl Gpu {
    fn dark_receivers(&self, size: UVec2) -> Result<Receivers<Self>> {
        let grid = || GpuGrid::<Vec4>::new(&self.pool, size);
        Ok(Receivers {
            size,
            position: grid()?,
            normal: grid()?,
            view: grid()?,
        })
    }

    /// Pass `receivers`.
    pub(super) fn run_receivers(
        &mut self,
        gbuffer: &GBuffer<Self>,
        job: &Job,
    ) -> Result<Receivers<Self>> {
        let pinhole = gbuffer.pinhole;
        let kernel = self.kernels.get(&self.device, &RECEIVERS)?;
        let receivers = self.dark_receivers(pinhole.size)?;
        let stamps = self.stamps.as_ref();
        let mut pass = Pass::new(RECEIVERS.name, &self.device, &self.pool, stamps);
        for window in windows(pinhole.size, NEED, &self.device.limits) {
            let params = ReceiverParams {
                pinhole,
                rows: UVec2::new(window.rows.start, window.rows.end),
                first_pixel: window.pixels.start,
                pad: 0,
            };
            pass.compute(&kernel, &params)
                .read(gbuffer.surface.part(&window.pixels))
                .read(gbuffer.albedo.part(&window.pixels))
                .read(gbuffer.material.part(&window.pixels))
                .write(receivers.position.part(&window.pixels))
                .write(receivers.normal.part(&window.pixels))
                .write(receivers.view.part(&window.pixels))
                .dispatch(window.threads(pinhole.size))?;
        }
        pass.finish(&mut self.timings, job)?;
        Ok(receivers)
    }

    /// Pass `mirror_receivers`.
    pub(super) fn run_mirror_receivers(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        job: &Job,
    ) -> Result<Receivers<Self>> {
        let size = mirror.origin.size();
        let kernel = self.kernels.get(&self.device, &MIRROR_RECEIVERS)?;
        let receivers = self.dark_receivers(size)?;
        let stamps = self.stamps.as_ref();
        let mut pass = Pass::new(MIRROR_RECEIVERS.name, &self.device, &self.pool, stamps);
        for window in windows(size, NEED, &self.device.limits) {
            let params = MirrorReceiverParams {
                rows: UVec2::new(window.rows.start, window.rows.end),
                width: size.x,
                first_pixel: window.pixels.start,
            };
            pass.compute(&kernel, &params)
                .read(mirror.origin.part(&window.pixels))
                .read(mirror.direction.part(&window.pixels))
                .read(mirror.surface.part(&window.pixels))
                .read(mirror.albedo.part(&window.pixels))
                .read(mirror.material.part(&window.pixels))
                .write(receivers.position.part(&window.pixels))
                .write(receivers.normal.part(&window.pixels))
                .write(receivers.view.part(&window.pixels))
                .dispatch(window.threads(size))?;
        }
        pass.finish(&mut self.timings, job)?;
        Ok(receivers)
    }

    /// Pass `settle`.
    pub(super) fn run_settle(
        &mut self,
        receivers: &Receivers<Self>,
        level: &GpuGrid<f32>,
        job: &Job,
    ) -> Result<GpuGrid<Vec4>> {
        let size = receivers.size;
        let kernel = self.kernels.get(&self.device, &SETTLE)?;
        let settled = GpuGrid::<Vec4>::new(&self.pool, size)?;
        let stamps = self.stamps.as_ref();
        let mut pass = Pass::new(SETTLE.name, &self.device, &self.pool, stamps);
        let need = Need {
            halo: REACH as u32,
            ..NEED
        };
        for window in windows(size, need, &self.device.limits) {
            let params = SettleParams {
                size,
                rows: UVec2::new(window.rows.start, window.rows.end),
                first_pixel: window.pixels.start,
                pad0: 0,
                pad1: 0,
                pad2: 0,
            };
            pass.compute(&kernel, &params)
                .read(level.part(&window.pixels))
                .read(receivers.position.part(&window.pixels))
                .read(receivers.normal.part(&window.pixels))
                .write(settled.part(&window.pixels))
                .dispatch(window.threads(size))?;
        }
        pass.finish(&mut self.timings, job)?;
        Ok(settled)
    }
}
