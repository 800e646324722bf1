//! The CPU backend: every stage on all cores (rayon).

use std::borrow::Cow;
use std::sync::Arc;

use bytemuck::Pod;
use glam::{UVec2, Vec4};

use super::{Backend, LightMap, LitBy};
use crate::camera::Pinhole;
use crate::cloud::Surfels;
use crate::error::{Error, Result};
use crate::gbuffer::splat::Splatter;
use crate::gbuffer::{Coverage, GBuffer, SplatSettings, coverage, edl, fill, smooth};
use crate::gi::light_close::light_close;
use crate::gi::{GiSettings, shade};
use crate::grid::Grid;
use crate::image::ImageSettings;
use crate::job::Job;
use crate::timing::Timings;

/// Runs the stages on the processor.
#[derive(Debug, Default)]
pub struct Cpu {
    splatter: Splatter,
    timings: Timings,
}

impl Backend for Cpu {
    type Grid<T: Pod> = Grid<T>;
    type Points = Arc<Surfels>;

    fn name(&self) -> &'static str {
        "cpu"
    }

    fn adapter(&self) -> Option<String> {
        None
    }

    fn take_timings(&mut self) -> Timings {
        std::mem::take(&mut self.timings)
    }

    fn upload(&mut self, surfels: &Arc<Surfels>) -> Result<Arc<Surfels>> {
        Ok(Arc::clone(surfels))
    }

    fn splat(
        &mut self,
        points: &Arc<Surfels>,
        pinhole: &Pinhole,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<GBuffer<Self>> {
        self.splatter
            .splat(points, pinhole, settings, &mut self.timings, job)
    }

    fn light_map(
        &mut self,
        points: &Arc<Surfels>,
        pinhole: &Pinhole,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<LightMap<Self>> {
        let keys = self.timings.time("light_depth", || {
            self.splatter.depth_keys(points, pinhole, settings, job)
        })?;
        let keys = self.timings.time("light_close", || light_close(&keys));
        Ok(LightMap {
            pinhole: *pinhole,
            keys,
        })
    }

    fn fill(
        &mut self,
        gbuffer: &mut GBuffer<Self>,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<()> {
        self.timings
            .time("fill", || fill::fill(gbuffer, settings, job))
    }

    fn coverage(&mut self, gbuffer: &GBuffer<Self>, job: &Job) -> Result<Coverage> {
        job.check()?;
        Ok(self
            .timings
            .time("coverage", || coverage::coverage(gbuffer)))
    }

    fn smooth(
        &mut self,
        gbuffer: &mut GBuffer<Self>,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<()> {
        self.timings
            .time("smooth", || smooth::smooth(gbuffer, settings, job))
    }

    fn shade(
        &mut self,
        gbuffer: &GBuffer<Self>,
        lights: &[LitBy<Self>],
        settings: &GiSettings,
        job: &Job,
    ) -> Result<Grid<Vec4>> {
        self.timings
            .time("shade", || shade::shade(gbuffer, lights, settings, job))
    }

    fn edl(
        &mut self,
        gbuffer: &GBuffer<Self>,
        settings: &ImageSettings,
        job: &Job,
    ) -> Result<Grid<Vec4>> {
        self.timings
            .time("edl", || edl::edl(gbuffer, settings, job))
    }

    fn take<T: Pod>(&mut self, grid: Grid<T>) -> Result<Grid<T>> {
        Ok(grid)
    }

    fn read<'a, T: Pod>(&mut self, grid: &'a Grid<T>) -> Result<Cow<'a, [T]>> {
        Ok(Cow::Borrowed(grid.values()))
    }

    fn write<T: Pod>(&mut self, size: UVec2, values: &[T]) -> Result<Grid<T>> {
        Grid::from_vec(size, values.to_vec()).ok_or_else(|| {
            Error::Setting(format!(
                "{} values do not fill a picture of {}x{}",
                values.len(),
                size.x,
                size.y
            ))
        })
    }
}
