//! The GPU backend: every stage as compute kernels on a graphics device (Vulkan, Metal or DirectX 12).
//!
//! Everything runs within WebGPU's default limits and without optional features; a device that offers larger buffers
//! only needs fewer bands. Waits for each pass, so that its time is known and its failure is an error of its call.

use std::borrow::Cow;
use std::sync::Arc;

use bytemuck::Pod;
use glam::{UVec2, Vec4};

use super::{Backend, LightMap, LitBy};
use crate::camera::Pinhole;
use crate::cloud::Surfels;
use crate::error::{Error, Result};
use crate::gbuffer::{Coverage, GBuffer, SplatSettings};
use crate::gi::GiSettings;
use crate::gi::gather::Gathered;
use crate::gi::indirect_filter::Window;
use crate::gi::ism::{IsmMaps, Slices};
use crate::gi::photons::PhotonMap;
use crate::gi::receivers::Receivers;
use crate::gi::vpl::Vpl;
use crate::grid::Grid;
use crate::image::ImageSettings;
use crate::job::Job;
use crate::reflect::sscr::curvature::{Axes, LhcSettings};
use crate::reflect::sscr::field::MirrorField;
use crate::reflect::sscr::guided::Guide;
use crate::reflect::sscr::heat::HeatSums;
use crate::reflect::sscr::prefix::{Budget, Prefix};
use crate::reflect::sscr::root_find::SearchCounts;
use crate::reflect::sscr::{Splatting, SscrSettings};
use crate::reflect::{LabelledMirrors, MirrorCoverage, MirrorGBuffer, Surface};
use crate::timing::Timings;

mod accumulate;
mod blend;
mod buffers;
mod curvature;
mod device;
mod edl;
mod fill;
mod gather;
mod guided;
mod hits;
mod ism;
mod kernel;
mod layout;
mod link;
mod mirror_pixels;
mod photons;
mod pull_push;
mod receivers;
mod root_find;
mod search_heat;
mod shade;
mod shaders;
mod smooth;
mod splat;
mod stamps;
mod surface;
mod windows;

pub use buffers::{GpuGrid, GpuPoints};
pub use device::{AdapterChoice, Device, GpuOptions, adapter_names};
pub use hits::GpuHits;
pub use layout::{GpuStruct, Layout};
pub use link::link;
pub use shaders::{LAYOUTS, SHADERS, SHARED, Shader};

use buffers::Pool;
use kernel::Kernels;
use stamps::Stamps;

/// Runs the stages on a graphics device.
#[derive(Debug)]
pub struct Gpu {
    device: Arc<Device>,
    pool: Arc<Pool>,
    kernels: Kernels,
    stamps: Option<Stamps>,
    timings: Timings,
}

impl Gpu {
    /// Opens the best adapter of the choice.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] where there is none, [`Error::Gpu`] where it cannot be opened.
    pub fn new(options: &GpuOptions) -> Result<Self> {
        let device = Arc::new(Device::open(options)?);
        let stamps = Stamps::new(&device);
        device.check()?;
        Ok(Self {
            pool: Pool::new(Arc::clone(&device)),
            device,
            kernels: Kernels::default(),
            stamps,
            timings: Timings::default(),
        })
    }

    /// The device that the stages run on.
    pub fn device(&self) -> &Arc<Device> {
        &self.device
    }
}

impl Backend for Gpu {
    type Grid<T: Pod> = GpuGrid<T>;
    type Points = GpuPoints;
    type Hits = GpuHits;

    fn name(&self) -> &'static str {
        "gpu"
    }

    fn adapter(&self) -> Option<String> {
        Some(self.device.adapter().to_owned())
    }

    fn timings(&mut self) -> &mut Timings {
        &mut self.timings
    }

    fn upload(&mut self, surfels: &Arc<Surfels>) -> Result<GpuPoints> {
        let start = std::time::Instant::now();
        let points = GpuPoints::upload(&self.pool, &self.device.limits, surfels)?;
        self.timings.add("upload", start.elapsed());
        Ok(points)
    }

    fn splat(
        &mut self,
        points: &GpuPoints,
        pinhole: &Pinhole,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<GBuffer<Self>> {
        self.run_splat(points, pinhole, settings, job)
    }

    fn light_map(
        &mut self,
        points: &GpuPoints,
        pinhole: &Pinhole,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<LightMap<Self>> {
        self.run_light_map(points, pinhole, settings, job)
    }

    fn fill(
        &mut self,
        gbuffer: &mut GBuffer<Self>,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<()> {
        self.run_fill(gbuffer, settings, job)
    }

    fn coverage(&mut self, gbuffer: &GBuffer<Self>, job: &Job) -> Result<Coverage> {
        self.run_coverage(gbuffer, job)
    }

    fn smooth(
        &mut self,
        gbuffer: &mut GBuffer<Self>,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<()> {
        self.run_smooth(gbuffer, settings, job)
    }

    fn shade(
        &mut self,
        gbuffer: &GBuffer<Self>,
        lights: &[LitBy<Self>],
        settings: &GiSettings,
        job: &Job,
    ) -> Result<GpuGrid<Vec4>> {
        self.run_shade(gbuffer, lights, settings, job)
    }

    fn edl(
        &mut self,
        gbuffer: &GBuffer<Self>,
        settings: &ImageSettings,
        job: &Job,
    ) -> Result<GpuGrid<Vec4>> {
        self.run_edl(gbuffer, settings, job)
    }

    fn surface(&mut self, gbuffer: &GBuffer<Self>, job: &Job) -> Result<Surface<Self>> {
        self.run_surface(gbuffer, job)
    }

    fn reflected_rays(
        &mut self,
        surface: &Surface<Self>,
        job: &Job,
    ) -> Result<MirrorGBuffer<Self>> {
        self.run_reflected_rays(surface, job)
    }

    fn curvature(
        &mut self,
        surface: &Surface<Self>,
        axes: Axes,
        settings: &LhcSettings,
        job: &Job,
    ) -> Result<GpuGrid<u8>> {
        self.run_curvature(surface, axes, settings, job)
    }

    fn root_find(
        &mut self,
        points: &GpuPoints,
        mirrors: &LabelledMirrors<'_, Self>,
        settings: &SscrSettings,
        diagonal: f32,
        job: &Job,
    ) -> Result<(GpuHits, SearchCounts)> {
        self.run_root_find(points, mirrors, settings, diagonal, job)
    }

    fn search_heat(
        &mut self,
        points: &GpuPoints,
        mirrors: &LabelledMirrors<'_, Self>,
        settings: &SscrSettings,
        job: &Job,
    ) -> Result<Grid<HeatSums>> {
        self.run_search_heat(points, mirrors, settings, job)
    }

    fn mirror_field(
        &mut self,
        surface: &Surface<Self>,
        curvature: &Grid<u8>,
        job: &Job,
    ) -> Result<(MirrorField, Grid<u8>)> {
        self.run_mirror_field(surface, curvature, job)
    }

    fn guided(
        &mut self,
        points: &GpuPoints,
        guide: &Guide<'_>,
        prefix: &mut Prefix,
        budget: Budget,
        job: &Job,
    ) -> Result<(GpuHits, SearchCounts, usize)> {
        self.run_guided(points, guide, prefix, budget, job)
    }

    fn accumulate(
        &mut self,
        hits: &GpuHits,
        points: &GpuPoints,
        mirror: &mut MirrorGBuffer<Self>,
        splatting: &Splatting,
        job: &Job,
    ) -> Result<()> {
        self.run_accumulate(hits, points, mirror, splatting, job)
    }

    fn mirror_coverage(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        job: &Job,
    ) -> Result<MirrorCoverage> {
        self.run_mirror_coverage(mirror, job)
    }

    fn pull_push(
        &mut self,
        mirror: &mut MirrorGBuffer<Self>,
        levels: u32,
        job: &Job,
    ) -> Result<()> {
        self.run_pull_push(mirror, levels, job)
    }

    fn shade_mirror(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        lights: &[LitBy<Self>],
        settings: &GiSettings,
        job: &Job,
    ) -> Result<GpuGrid<Vec4>> {
        self.run_shade_mirror(mirror, lights, settings, job)
    }

    fn receivers(&mut self, gbuffer: &GBuffer<Self>, job: &Job) -> Result<Receivers<Self>> {
        self.run_receivers(gbuffer, job)
    }

    fn mirror_receivers(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        job: &Job,
    ) -> Result<Receivers<Self>> {
        self.run_mirror_receivers(mirror, job)
    }

    fn settle(
        &mut self,
        receivers: &Receivers<Self>,
        level: &GpuGrid<f32>,
        job: &Job,
    ) -> Result<GpuGrid<Vec4>> {
        self.run_settle(receivers, level, job)
    }

    fn ism(
        &mut self,
        points: &GpuPoints,
        vpls: &[Vpl],
        slices: Slices,
        job: &Job,
    ) -> Result<IsmMaps<Self>> {
        self.run_ism(points, vpls, slices, job)
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
        self.run_gather(receivers, vpls, maps, interleave, gathered, job)
    }

    fn indirect_filter(
        &mut self,
        receivers: &Receivers<Self>,
        irradiance: &GpuGrid<Vec4>,
        window: Window,
        job: &Job,
    ) -> Result<GpuGrid<Vec4>> {
        self.run_indirect_filter(receivers, irradiance, window, job)
    }

    fn photons(
        &mut self,
        receivers: &Receivers<Self>,
        map: &PhotonMap,
        irradiance: &mut GpuGrid<Vec4>,
        job: &Job,
    ) -> Result<()> {
        self.run_photons(receivers, map, irradiance, job)
    }

    fn add_indirect(
        &mut self,
        albedo: &GpuGrid<Vec4>,
        light: &Gathered<Self>,
        settings: &GiSettings,
        radiance: &mut GpuGrid<Vec4>,
        job: &Job,
    ) -> Result<()> {
        self.run_add_indirect(albedo, light, settings, radiance, job)
    }

    fn blend(
        &mut self,
        radiance: &mut GpuGrid<Vec4>,
        gbuffer: &GBuffer<Self>,
        mirror: &MirrorGBuffer<Self>,
        shown: Option<&GpuGrid<Vec4>>,
        job: &Job,
    ) -> Result<()> {
        self.run_blend(radiance, gbuffer, mirror, shown, job)
    }

    fn take<T: Pod>(&mut self, grid: GpuGrid<T>) -> Result<Grid<T>> {
        let values = grid.download()?.into_owned();
        Grid::from_vec(grid.size(), values)
            .ok_or_else(|| Error::Gpu("it returned a picture of another size".into()))
    }

    fn read<'a, T: Pod>(&mut self, grid: &'a GpuGrid<T>) -> Result<Cow<'a, [T]>> {
        grid.download()
    }

    fn put<T: Pod>(&mut self, grid: Grid<T>) -> Result<GpuGrid<T>> {
        self.write(grid.size(), grid.values())
    }

    fn write<T: Pod>(&mut self, size: UVec2, values: &[T]) -> Result<GpuGrid<T>> {
        if values.len() as u64 != u64::from(size.x) * u64::from(size.y) {
            let count = values.len();
            return Err(Error::Setting(format!(
                "{count} values do not fill a picture of {}x{}",
                size.x, size.y
            )));
        }
        let grid = GpuGrid::new(&self.pool, size)?;
        grid.upload(values)?;
        Ok(grid)
    }
}
