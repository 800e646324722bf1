//! Passes `gather` and `indirect_filter` on the device. Twins: the files of these names in `src/gi/`.

use glam::{UVec2, Vec4};

use super::Gpu;
use super::buffers::GpuGrid;
use super::ism::texels_of;
use super::kernel::Pass;
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::{GATHER, INDIRECT_FILTER};
use super::windows::{Need, Window as Rows, windows};
use crate::error::Result;
use crate::gi::gather::Gathered;
use crate::gi::indirect_filter::Window;
use crate::gi::ism::{BIAS_SPACINGS, IsmMaps};
use crate::gi::receivers::Receivers;
use crate::gi::vpl::Vpl;
use crate::job::Job;

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
        width: i32,
        /// From pixel to pixel of the window.
        stride: i32,
        /// 1: down the columns.
        down: u32,
    }
}

pub(super) fn rows_of(rows: &Rows) -> UVec2 {
    UVec2::new(rows.rows.start, rows.rows.end)
}

/// A pixel of the passes that look at one pixel, in so many steps.
pub(super) fn need(steps: u64) -> Need {
    Need {
        halo: 0,
        bytes: 16,
        steps,
    }
}

impl Gpu {
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
                halo: down * (window.width * window.stride) as u32,
                ..need(2 * window.width as u64 + 1)
            };
            for rows in windows(size, need, &self.device.limits) {
                let params = FilterParams {
                    size,
                    rows: rows_of(&rows),
                    first_pixel: rows.pixels.start,
                    width: window.width,
                    stride: window.stride,
                    down,
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
}
