//! The CPU backend: every stage on all cores (rayon).

use std::borrow::Cow;
use std::sync::Arc;

use bytemuck::Pod;
use glam::{UVec2, Vec4};

use super::{Backend, LightMap, LitBy};
use crate::camera::Pinhole;
use crate::cloud::Surfels;
use crate::error::{Error, Result};
use crate::gbuffer::pull_push::pull_push;
use crate::gbuffer::splat::Splatter;
use crate::gbuffer::{Coverage, GBuffer, SplatSettings, coverage, edl, fill, smooth};
use crate::gi::add_indirect::add_indirect;
use crate::gi::gather::Gathered;
use crate::gi::indirect_filter::{Window, indirect_filter};
use crate::gi::ism::{IsmMaps, Slices};
use crate::gi::light_close::light_close;
use crate::gi::photons::PhotonMap;
use crate::gi::receivers::Receivers;
use crate::gi::vpl::Vpl;
use crate::gi::{GiSettings, gather, ism, photons, settle, shade};
use crate::grid::Grid;
use crate::image::ImageSettings;
use crate::job::Job;
use crate::reflect::sscr::accumulate::Accumulator;
use crate::reflect::sscr::chart_class::chart_class;
use crate::reflect::sscr::curvature::{Axes, LhcSettings, curvature};
use crate::reflect::sscr::field::MirrorField;
use crate::reflect::sscr::guided::Guide;
use crate::reflect::sscr::heat::{HeatSums, search_heat};
use crate::reflect::sscr::prefix::{Budget, Prefix};
use crate::reflect::sscr::root_find::{SearchCounts, root_find};
use crate::reflect::sscr::{Splatting, SscrSettings};
use crate::reflect::{Hit, LabelledMirrors, MirrorCoverage, MirrorGBuffer, Surface, blend};
use crate::timing::Timings;

/// Runs the stages on the processor.
#[derive(Debug, Default)]
pub struct Cpu {
    splatter: Splatter,
    accumulator: Accumulator,
    timings: Timings,
}

impl Backend for Cpu {
    type Grid<T: Pod> = Grid<T>;
    type Points = Arc<Surfels>;
    type Hits = Vec<Hit>;

    fn name(&self) -> &'static str {
        "cpu"
    }

    fn adapter(&self) -> Option<String> {
        None
    }

    fn timings(&mut self) -> &mut Timings {
        &mut self.timings
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

    fn surface(&mut self, gbuffer: &GBuffer<Self>, job: &Job) -> Result<Surface<Self>> {
        job.check()?;
        Ok(self.timings.time("surface", || Surface::of(gbuffer)))
    }

    fn reflected_rays(
        &mut self,
        surface: &Surface<Self>,
        job: &Job,
    ) -> Result<MirrorGBuffer<Self>> {
        job.check()?;
        Ok(self
            .timings
            .time("reflected_rays", || MirrorGBuffer::of(surface)))
    }

    fn curvature(
        &mut self,
        surface: &Surface<Self>,
        axes: Axes,
        settings: &LhcSettings,
        job: &Job,
    ) -> Result<Grid<u8>> {
        job.check()?;
        Ok(self
            .timings
            .time("curvature", || curvature(surface, axes, settings)))
    }

    fn root_find(
        &mut self,
        points: &Arc<Surfels>,
        mirrors: &LabelledMirrors<'_, Self>,
        settings: &SscrSettings,
        diagonal: f32,
        job: &Job,
    ) -> Result<(Vec<Hit>, SearchCounts)> {
        self.timings.time("root_find", || {
            root_find(points, mirrors, settings, diagonal, job)
        })
    }

    fn search_heat(
        &mut self,
        points: &Arc<Surfels>,
        mirrors: &LabelledMirrors<'_, Self>,
        settings: &SscrSettings,
        job: &Job,
    ) -> Result<Grid<HeatSums>> {
        self.timings.time("search_heat", || {
            search_heat(points, mirrors, settings, job)
        })
    }

    fn mirror_field(
        &mut self,
        surface: &Surface<Self>,
        curvature: &Grid<u8>,
        job: &Job,
    ) -> Result<(MirrorField, Grid<u8>)> {
        job.check()?;
        let field = self
            .timings
            .time("mirror_field", || MirrorField::new(surface, curvature))?;
        let classes = self
            .timings
            .time("chart_class", || chart_class(surface, curvature));
        Ok((field, classes))
    }

    fn guided(
        &mut self,
        points: &Arc<Surfels>,
        guide: &Guide<'_>,
        prefix: &mut Prefix,
        budget: Budget,
        job: &Job,
    ) -> Result<(Vec<Hit>, SearchCounts, usize)> {
        let mut hits = Vec::new();
        let search = |order: &[u32], timings: &mut Timings| {
            let (found, counts) = timings.time("guided", || guide.search(points, order, job))?;
            hits.extend(found);
            Ok(counts)
        };
        let (counts, searched) = prefix.grow(&points.places, budget, &mut self.timings, search)?;
        Ok((hits, counts, searched))
    }

    fn accumulate(
        &mut self,
        hits: &Vec<Hit>,
        points: &Arc<Surfels>,
        mirror: &mut MirrorGBuffer<Self>,
        splatting: &Splatting,
        job: &Job,
    ) -> Result<()> {
        self.timings.time("accumulate", || {
            self.accumulator
                .accumulate(hits, points, mirror, splatting, job)
        })
    }

    fn mirror_coverage(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        job: &Job,
    ) -> Result<MirrorCoverage> {
        job.check()?;
        Ok(self.timings.time("mirror_coverage", || mirror.coverage()))
    }

    fn pull_push(
        &mut self,
        mirror: &mut MirrorGBuffer<Self>,
        levels: u32,
        job: &Job,
    ) -> Result<()> {
        self.timings
            .time("pull_push", || pull_push(mirror, levels, job))
    }

    fn shade_mirror(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        lights: &[LitBy<Self>],
        settings: &GiSettings,
        job: &Job,
    ) -> Result<Grid<Vec4>> {
        self.timings.time("shade_mirror", || {
            shade::shade_mirror(mirror, lights, settings, job)
        })
    }

    fn receivers(&mut self, gbuffer: &GBuffer<Self>, job: &Job) -> Result<Receivers<Self>> {
        job.check()?;
        Ok(self.timings.time("receivers", || Receivers::of(gbuffer)))
    }

    fn mirror_receivers(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        job: &Job,
    ) -> Result<Receivers<Self>> {
        job.check()?;
        Ok(self
            .timings
            .time("mirror_receivers", || Receivers::of_mirror(mirror)))
    }

    fn settle(
        &mut self,
        receivers: &Receivers<Self>,
        level: &Grid<f32>,
        job: &Job,
    ) -> Result<Grid<Vec4>> {
        self.timings
            .time("settle", || settle::settle(receivers, level, job))
    }

    fn ism(
        &mut self,
        points: &Arc<Surfels>,
        vpls: &[Vpl],
        slices: Slices,
        job: &Job,
    ) -> Result<IsmMaps<Self>> {
        self.timings
            .time("ism", || ism::ism(points, vpls, slices, job))
    }

    fn gather(
        &mut self,
        receivers: &Receivers<Self>,
        vpls: &[Vpl],
        maps: &IsmMaps<Self>,
        interleave: u32,
        gathered: &mut Gathered<Self>,
        job: &Job,
    ) -> Result<()> {
        self.timings.time("gather", || {
            gather::gather(receivers, vpls, maps, interleave, gathered, job)
        })
    }

    fn indirect_filter(
        &mut self,
        receivers: &Receivers<Self>,
        irradiance: &Grid<Vec4>,
        window: Window,
        job: &Job,
    ) -> Result<Grid<Vec4>> {
        self.timings.time("indirect_filter", || {
            let across = indirect_filter(receivers, irradiance, window, false, job)?;
            indirect_filter(receivers, &across, window, true, job)
        })
    }

    fn photons(
        &mut self,
        receivers: &Receivers<Self>,
        map: &PhotonMap,
        irradiance: &mut Grid<Vec4>,
        job: &Job,
    ) -> Result<()> {
        self.timings.time("photons", || {
            photons::photons(receivers, map, irradiance, job)
        })
    }

    fn add_indirect(
        &mut self,
        albedo: &Grid<Vec4>,
        light: &Gathered<Self>,
        settings: &GiSettings,
        radiance: &mut Grid<Vec4>,
        job: &Job,
    ) -> Result<()> {
        self.timings.time("add_indirect", || {
            add_indirect(albedo, light, settings.albedo_scale, radiance, job)
        })
    }

    fn blend(
        &mut self,
        radiance: &mut Grid<Vec4>,
        gbuffer: &GBuffer<Self>,
        mirror: &MirrorGBuffer<Self>,
        shown: Option<&Grid<Vec4>>,
        job: &Job,
    ) -> Result<()> {
        self.timings
            .time("blend", || blend(radiance, gbuffer, mirror, shown, job))
    }

    fn take<T: Pod>(&mut self, grid: Grid<T>) -> Result<Grid<T>> {
        Ok(grid)
    }

    fn read<'a, T: Pod>(&mut self, grid: &'a Grid<T>) -> Result<Cow<'a, [T]>> {
        Ok(Cow::Borrowed(grid.values()))
    }

    fn put<T: Pod>(&mut self, grid: Grid<T>) -> Result<Grid<T>> {
        Ok(grid)
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
