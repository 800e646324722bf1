//! The mirrors' stages, which run on the processor: their grids are read back, and written to the device again.

use glam::Vec4;

use super::{Gpu, GpuGrid, GpuPoints};
use crate::backend::cpu::Cpu;
use crate::backend::{Backend, LightMap, LitBy};
use crate::error::Result;
use crate::gbuffer::GBuffer;
use crate::gi::GiSettings;
use crate::grid::Grid;
use crate::job::Job;
use crate::reflect::sscr::SscrSettings;
use crate::reflect::sscr::curvature::{Axes, LhcSettings};
use crate::reflect::sscr::root_find::SearchCounts;
use crate::reflect::{Eye, Hit, LabelledMirrors, MirrorCoverage, MirrorGBuffer, Surface};

impl Gpu {
    /// A copy of a grid in main memory.
    pub(super) fn copy<T: bytemuck::Pod>(&mut self, grid: &GpuGrid<T>) -> Result<Grid<T>> {
        let values = grid.download()?.into_owned();
        Grid::from_vec(grid.size(), values)
            .ok_or_else(|| crate::Error::Gpu("it returned a picture of another size".into()))
    }

    pub(super) fn copy_gbuffer(&mut self, gbuffer: &GBuffer<Self>) -> Result<GBuffer<Cpu>> {
        Ok(GBuffer {
            pinhole: gbuffer.pinhole,
            surface: self.copy(&gbuffer.surface)?,
            albedo: self.copy(&gbuffer.albedo)?,
            material: self.copy(&gbuffer.material)?,
        })
    }

    fn copy_surface(&mut self, surface: &Surface<Self>) -> Result<Surface<Cpu>> {
        Ok(Surface {
            size: surface.size,
            point: self.copy(&surface.point)?,
            normal: self.copy(&surface.normal)?,
            eye: match &surface.eye {
                Eye::Point(eye) => Eye::Point(*eye),
                Eye::PerPixel(eyes) => Eye::PerPixel(self.copy(eyes)?),
            },
        })
    }

    pub(super) fn copy_mirror(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
    ) -> Result<MirrorGBuffer<Cpu>> {
        Ok(MirrorGBuffer {
            origin: self.copy(&mirror.origin)?,
            direction: self.copy(&mirror.direction)?,
            surface: self.copy(&mirror.surface)?,
            albedo: self.copy(&mirror.albedo)?,
            material: self.copy(&mirror.material)?,
            region: self.copy(&mirror.region)?,
            count: self.copy(&mirror.count)?,
            level: self.copy(&mirror.level)?,
        })
    }

    /// Runs a stage on the processor, with its times in this backend's.
    pub(super) fn on_cpu<R>(&mut self, stage: impl FnOnce(&mut Cpu) -> Result<R>) -> Result<R> {
        let mut cpu = Cpu::default();
        let result = stage(&mut cpu);
        for pass in &cpu.timings().passes {
            let wall = std::time::Duration::from_secs_f64(pass.wall_ms / 1e3);
            self.timings.add(&pass.name, wall);
        }
        result
    }

    pub(super) fn run_surface(
        &mut self,
        gbuffer: &GBuffer<Self>,
        job: &Job,
    ) -> Result<Surface<Self>> {
        let gbuffer = self.copy_gbuffer(gbuffer)?;
        let surface = self.on_cpu(|cpu| cpu.surface(&gbuffer, job))?;
        Ok(Surface {
            size: surface.size,
            point: self.put(surface.point)?,
            normal: self.put(surface.normal)?,
            eye: match surface.eye {
                Eye::Point(eye) => Eye::Point(eye),
                Eye::PerPixel(eyes) => Eye::PerPixel(self.put(eyes)?),
            },
        })
    }

    pub(super) fn run_reflected_rays(
        &mut self,
        surface: &Surface<Self>,
        job: &Job,
    ) -> Result<MirrorGBuffer<Self>> {
        let surface = self.copy_surface(surface)?;
        self.on_cpu(|cpu| cpu.reflected_rays(&surface, job))?
            .put(self)
    }

    pub(super) fn run_curvature(
        &mut self,
        surface: &Surface<Self>,
        axes: Axes,
        settings: &LhcSettings,
        job: &Job,
    ) -> Result<GpuGrid<u8>> {
        let surface = self.copy_surface(surface)?;
        let cells = self.on_cpu(|cpu| cpu.curvature(&surface, axes, settings, job))?;
        self.put(cells)
    }

    pub(super) fn run_root_find(
        &mut self,
        points: &GpuPoints,
        mirrors: &LabelledMirrors<'_, Self>,
        settings: &SscrSettings,
        diagonal: f32,
        job: &Job,
    ) -> Result<(Vec<Hit>, SearchCounts)> {
        let surface = self.copy_surface(mirrors.surface)?;
        let labels = self.copy(mirrors.labels)?;
        let mirrors = LabelledMirrors {
            surface: &surface,
            labels: &labels,
            regions: mirrors.regions,
            right: mirrors.right,
        };
        self.on_cpu(|cpu| cpu.root_find(&points.surfels, &mirrors, settings, diagonal, job))
    }

    pub(super) fn run_accumulate(
        &mut self,
        hits: &Vec<Hit>,
        points: &GpuPoints,
        mirror: &mut MirrorGBuffer<Self>,
        settings: &SscrSettings,
        job: &Job,
    ) -> Result<()> {
        let mut seen = self.copy_mirror(mirror)?;
        self.on_cpu(|cpu| cpu.accumulate(hits, &points.surfels, &mut seen, settings, job))?;
        *mirror = seen.put(self)?;
        Ok(())
    }

    pub(super) fn run_mirror_coverage(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        job: &Job,
    ) -> Result<MirrorCoverage> {
        let mirror = self.copy_mirror(mirror)?;
        self.on_cpu(|cpu| cpu.mirror_coverage(&mirror, job))
    }

    pub(super) fn run_pull_push(
        &mut self,
        mirror: &mut MirrorGBuffer<Self>,
        levels: u32,
        job: &Job,
    ) -> Result<()> {
        let mut seen = self.copy_mirror(mirror)?;
        self.on_cpu(|cpu| cpu.pull_push(&mut seen, levels, job))?;
        *mirror = seen.put(self)?;
        Ok(())
    }

    pub(super) fn run_shade_mirror(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        lights: &[LitBy<Self>],
        settings: &GiSettings,
        job: &Job,
    ) -> Result<GpuGrid<Vec4>> {
        let mirror = self.copy_mirror(mirror)?;
        let mut near = Vec::with_capacity(lights.len());
        for LitBy { light, map } in lights {
            near.push(LitBy {
                light: *light,
                map: LightMap {
                    pinhole: map.pinhole,
                    keys: self.copy(&map.keys)?,
                },
            });
        }
        let shown = self.on_cpu(|cpu| cpu.shade_mirror(&mirror, &near, settings, job))?;
        self.put(shown)
    }

    pub(super) fn run_blend(
        &mut self,
        radiance: &mut GpuGrid<Vec4>,
        gbuffer: &GBuffer<Self>,
        mirror: &MirrorGBuffer<Self>,
        shown: Option<&GpuGrid<Vec4>>,
        job: &Job,
    ) -> Result<()> {
        let (gbuffer, mirror) = (self.copy_gbuffer(gbuffer)?, self.copy_mirror(mirror)?);
        let shown = shown.map(|shown| self.copy(shown)).transpose()?;
        let mut blended = self.copy(radiance)?;
        self.on_cpu(|cpu| cpu.blend(&mut blended, &gbuffer, &mirror, shown.as_ref(), job))?;
        *radiance = self.put(blended)?;
        Ok(())
    }
}
