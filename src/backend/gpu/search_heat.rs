//! Pass `search_heat` on the device. Twin: `src/reflect/sscr/heat.rs`.

use super::buffers::{GpuGrid, GpuPoints};
use super::kernel::{Pass, Threads};
use super::root_find::{SearchChunk, chunks};
use super::shaders::SEARCH_HEAT;
use super::{Gpu, windows::rows_of};
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::job::Job;
use crate::reflect::LabelledMirrors;
use crate::reflect::sscr::SscrSettings;
use crate::reflect::sscr::heat::HeatSums;

impl Gpu {
    /// Pass `search_heat`.
    pub(super) fn run_search_heat(
        &mut self,
        points: &GpuPoints,
        mirrors: &LabelledMirrors<'_, Self>,
        settings: &SscrSettings,
        job: &Job,
    ) -> Result<Grid<HeatSums>> {
        let size = mirrors.surface.size;
        let mut heat = Grid::new(size, HeatSums::default());
        if mirrors.regions.is_empty() {
            return Ok(heat);
        }
        let pixels = self.mirror_pixels(mirrors, job)?;
        let budget = self.device.limits.max_storage_buffer_binding_size;
        let needed =
            rows_of(pixels.size, &(0..pixels.size.y)).len() as u64 * size_of::<HeatSums>() as u64;
        if needed > budget {
            return Err(Error::Memory {
                what: format!(
                    "the heat of the search in mirrors of {} x {} pixels",
                    pixels.size.x, pixels.size.y
                ),
                needed,
                budget,
            });
        }
        let regions = self.region_table(mirrors.regions)?;
        let kernel = self.kernels.get(&self.device, &SEARCH_HEAT)?;
        let sums = GpuGrid::<HeatSums>::new(&self.pool, pixels.size)?;
        let mut pass = Pass::new(
            SEARCH_HEAT.name,
            &self.device,
            &self.pool,
            self.stamps.as_ref(),
        );
        pass.zero(sums.whole());
        // Splats have no part in it, so neither has the scene's size.
        let regions_held = mirrors.regions.len();
        for chunk in chunks(points, &pixels, regions_held, settings, 1.0, u32::MAX) {
            let SearchChunk { band, params } = chunk;
            let mut compute = pass
                .compute(&kernel, &params)
                .read(points.bands[band].places())
                .read(regions.binding());
            for binding in pixels.bindings() {
                compute = compute.read(binding);
            }
            compute
                .write(sums.whole())
                .dispatch(Threads::Points(chunk.points()))?;
        }
        pass.finish(&mut self.timings, job)?;
        let ends = sums.download()?;
        let (width, left) = (heat.width(), pixels.first.x as usize);
        let rows = ends.chunks_exact(pixels.size.x.max(1) as usize);
        for (y, row) in (pixels.first.y as usize..).zip(rows) {
            let start = y * width + left;
            if let Some(out) = heat.values_mut().get_mut(start..start + row.len()) {
                out.copy_from_slice(row);
            }
        }
        Ok(heat)
    }
}
