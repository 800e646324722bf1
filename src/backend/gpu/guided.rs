//! The guided search, which runs on the processor: the mirrors are read back, and its hits are written to the device.

use super::{Gpu, GpuGrid, GpuHits, GpuPoints};
use crate::backend::Backend;
use crate::backend::cpu::Cpu;
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::job::Job;
use crate::reflect::sscr::field::MirrorField;
use crate::reflect::sscr::guided::Guide;
use crate::reflect::sscr::prefix::{Budget, Prefix};
use crate::reflect::sscr::root_find::SearchCounts;
use crate::reflect::{Eye, Surface};

impl Gpu {
    /// A copy of a grid in main memory.
    fn copy<T: bytemuck::Pod>(grid: &GpuGrid<T>) -> Result<Grid<T>> {
        Grid::from_vec(grid.size(), grid.download()?.into_owned())
            .ok_or_else(|| Error::Gpu("it returned a picture of another size".into()))
    }

    /// Runs a stage on the processor, with its times in this backend's.
    fn on_cpu<R>(&mut self, stage: impl FnOnce(&mut Cpu) -> Result<R>) -> Result<R> {
        let mut cpu = Cpu::default();
        let result = stage(&mut cpu);
        for pass in &cpu.timings().passes {
            let wall = std::time::Duration::from_secs_f64(pass.wall_ms / 1e3);
            self.timings.add(&pass.name, wall);
        }
        result
    }

    pub(super) fn run_mirror_field(
        &mut self,
        surface: &Surface<Self>,
        curvature: &Grid<u8>,
        job: &Job,
    ) -> Result<(MirrorField, Grid<u8>)> {
        let surface = Surface {
            size: surface.size,
            point: Self::copy(&surface.point)?,
            normal: Self::copy(&surface.normal)?,
            eye: match &surface.eye {
                Eye::Point(eye) => Eye::Point(*eye),
                Eye::PerPixel(eyes) => Eye::PerPixel(Self::copy(eyes)?),
            },
        };
        self.on_cpu(|cpu| cpu.mirror_field(&surface, curvature, job))
    }

    pub(super) fn run_guided(
        &mut self,
        points: &GpuPoints,
        guide: &Guide<'_>,
        prefix: &mut Prefix,
        budget: Budget,
        job: &Job,
    ) -> Result<(GpuHits, SearchCounts, usize)> {
        let (hits, counts, searched) =
            self.on_cpu(|cpu| cpu.guided(&points.surfels, guide, prefix, budget, job))?;
        Ok((self.write_hits(&hits)?, counts, searched))
    }
}
