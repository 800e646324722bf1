//! Where the stages run. One frame ([`crate::frame`]) is written once, over the trait [`Backend`].

use std::borrow::Cow;
use std::sync::Arc;

use bytemuck::Pod;
use glam::{UVec2, Vec4};

use crate::camera::Pinhole;
use crate::cloud::Surfels;
use crate::error::Result;
use crate::gbuffer::{Coverage, GBuffer, SplatSettings};
use crate::gi::gather::Gathered;
use crate::gi::indirect_filter::Window;
use crate::gi::ism::{IsmMaps, Slices};
use crate::gi::photons::PhotonMap;
use crate::gi::receivers::Receivers;
use crate::gi::vpl::Vpl;
use crate::gi::{GiSettings, SpotLight};
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

pub mod cpu;
pub mod gpu;

/// What a spot light sees: the nearest surfel of every texel.
pub struct LightMap<B: Backend> {
    /// The light's projection.
    pub pinhole: Pinhole,
    /// Depth keys ([`crate::gbuffer::depth_key`]); [`crate::gbuffer::EMPTY`] where the light sees nothing.
    pub keys: B::Grid<u32>,
}

/// A light with the map of what it sees.
pub struct LitBy<B: Backend> {
    /// The light, relative to the scene's origin.
    pub light: SpotLight,
    /// What it sees.
    pub map: LightMap<B>,
}

/// A cloud, where a backend keeps it and in main memory.
pub struct Cloud<B: Backend> {
    /// The surfels, where the stages read them.
    pub points: B::Points,
    /// The surfels in main memory.
    pub surfels: Arc<Surfels>,
}

/// A machine that runs the stages: one method a stage. Each ends with [`crate::Error::Cancelled`] soon after its job was
/// cancelled.
pub trait Backend: Sized {
    /// A value per pixel, where this backend keeps it.
    type Grid<T: Pod>;
    /// The surfels, where this backend keeps them.
    type Points;
    /// Hits of the search, where this backend keeps them.
    type Hits;

    /// "cpu" or "gpu".
    fn name(&self) -> &'static str;
    /// The adapter's name, where there is one.
    fn adapter(&self) -> Option<String>;
    /// Where passes note their time.
    fn timings(&mut self) -> &mut Timings;

    /// Brings the surfels to where the stages read them.
    fn upload(&mut self, surfels: &Arc<Surfels>) -> Result<Self::Points>;
    /// Passes `depth`, `visibility`, `average`: the surfels as seen through a pinhole.
    fn splat(
        &mut self,
        points: &Self::Points,
        pinhole: &Pinhole,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<GBuffer<Self>>;
    /// Pass `depth` alone, for shadows.
    fn light_map(
        &mut self,
        points: &Self::Points,
        pinhole: &Pinhole,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<LightMap<Self>>;
    /// Pass `fill`: closes small holes.
    fn fill(
        &mut self,
        gbuffer: &mut GBuffer<Self>,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<()>;
    /// Pass `coverage`: counts the pixels that show something.
    fn coverage(&mut self, gbuffer: &GBuffer<Self>, job: &Job) -> Result<Coverage>;
    /// Pass `smooth`: joint bilateral smoothing of the normals and depths of mirrors.
    fn smooth(
        &mut self,
        gbuffer: &mut GBuffer<Self>,
        settings: &SplatSettings,
        job: &Job,
    ) -> Result<()>;
    /// Pass `shade`: radiance (W/sr/m2) towards the eye, alpha 1 where valid.
    fn shade(
        &mut self,
        gbuffer: &GBuffer<Self>,
        lights: &[LitBy<Self>],
        settings: &GiSettings,
        job: &Job,
    ) -> Result<Self::Grid<Vec4>>;
    /// Pass `edl`: the albedo, shaded by eye-dome lighting, for scenes without light; alpha 1 where valid.
    fn edl(
        &mut self,
        gbuffer: &GBuffer<Self>,
        settings: &ImageSettings,
        job: &Job,
    ) -> Result<Self::Grid<Vec4>>;

    /// Pass `surface`: the mirrors that the camera sees from the front.
    fn surface(&mut self, gbuffer: &GBuffer<Self>, job: &Job) -> Result<Surface<Self>>;
    /// Pass `reflected_rays`: the ray of every mirror pixel, which shows nothing yet.
    fn reflected_rays(&mut self, surface: &Surface<Self>, job: &Job)
    -> Result<MirrorGBuffer<Self>>;
    /// Pass `curvature`: how the mirrors bend, a byte a pixel.
    fn curvature(
        &mut self,
        surface: &Surface<Self>,
        axes: Axes,
        settings: &LhcSettings,
        job: &Job,
    ) -> Result<Self::Grid<u8>>;
    /// Pass `root_find`: for the points, each in the regions that it is given, the pixels that show them. `diagonal` is
    /// that of the scene's box.
    fn root_find(
        &mut self,
        points: &Self::Points,
        mirrors: &LabelledMirrors<'_, Self>,
        settings: &SscrSettings,
        diagonal: f32,
        job: &Job,
    ) -> Result<(Self::Hits, SearchCounts)>;
    /// Pass `search_heat`: where those searches end, in main memory. Runs them once more; only where asked for.
    fn search_heat(
        &mut self,
        points: &Self::Points,
        mirrors: &LabelledMirrors<'_, Self>,
        settings: &SscrSettings,
        job: &Job,
    ) -> Result<Grid<HeatSums>>;
    /// The mirrors as a smooth field and the class of their curvature, in main memory; `curvature` is that of the pass.
    fn mirror_field(
        &mut self,
        surface: &Surface<Self>,
        curvature: &Grid<u8>,
        job: &Job,
    ) -> Result<(MirrorField, Grid<u8>)>;
    /// Pass `guided`: for the first points of `prefix`, as many as the budget says, all mirror pixels that show them; also
    /// the number of points searched.
    fn guided(
        &mut self,
        points: &Self::Points,
        guide: &Guide<'_>,
        prefix: &mut Prefix,
        budget: Budget,
        job: &Job,
    ) -> Result<(Self::Hits, SearchCounts, usize)>;
    /// Pass `accumulate`: hits are splatted onto the mirrors, by depth, visibility and averaging.
    fn accumulate(
        &mut self,
        hits: &Self::Hits,
        points: &Self::Points,
        mirror: &mut MirrorGBuffer<Self>,
        splatting: &Splatting,
        job: &Job,
    ) -> Result<()>;
    /// Pass `mirror_coverage`: counts the mirrors' pixels that show something.
    fn mirror_coverage(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        job: &Job,
    ) -> Result<MirrorCoverage>;
    /// Pass `pull_push`: closes holes in the mirrors from so many halvings.
    fn pull_push(&mut self, mirror: &mut MirrorGBuffer<Self>, levels: u32, job: &Job)
    -> Result<()>;
    /// Pass `shade_mirror`: radiance (W/sr/m2) that every mirror pixel shows.
    fn shade_mirror(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        lights: &[LitBy<Self>],
        settings: &GiSettings,
        job: &Job,
    ) -> Result<Self::Grid<Vec4>>;
    /// Pass `receivers`: what the camera sees, as indirect light takes it.
    fn receivers(&mut self, gbuffer: &GBuffer<Self>, job: &Job) -> Result<Receivers<Self>>;
    /// Pass `mirror_receivers`: the same for what the mirrors show.
    fn mirror_receivers(
        &mut self,
        mirror: &MirrorGBuffer<Self>,
        job: &Job,
    ) -> Result<Receivers<Self>>;
    /// Pass `settle`: positions of receivers in mirrors, moved to the nearest found where `level` says that a hole was closed.
    fn settle(
        &mut self,
        receivers: &Receivers<Self>,
        level: &Self::Grid<f32>,
        job: &Job,
    ) -> Result<Self::Grid<Vec4>>;
    /// Pass `ism`: the shadow maps of virtual point lights.
    fn ism(
        &mut self,
        points: &Self::Points,
        vpls: &[Vpl],
        slices: Slices,
        job: &Job,
    ) -> Result<IsmMaps<Self>>;
    /// Pass `gather`: adds to `gathered` what virtual point lights send, interleaved n x n.
    fn gather(
        &mut self,
        receivers: &Receivers<Self>,
        vpls: &[Vpl],
        maps: &IsmMaps<Self>,
        interleave: u32,
        gathered: &mut Gathered<Self>,
        job: &Job,
    ) -> Result<()>;
    /// Pass `indirect_filter`: merges interleaved pixels, across and down.
    fn indirect_filter(
        &mut self,
        receivers: &Receivers<Self>,
        irradiance: &Self::Grid<Vec4>,
        window: Window,
        job: &Job,
    ) -> Result<Self::Grid<Vec4>>;
    /// Pass `photons`: adds to `irradiance` what came by way of mirrors.
    fn photons(
        &mut self,
        receivers: &Receivers<Self>,
        map: &PhotonMap,
        irradiance: &mut Self::Grid<Vec4>,
        job: &Job,
    ) -> Result<()>;
    /// Pass `add_indirect`: adds to `radiance` what surfaces of this albedo send on of `light`.
    fn add_indirect(
        &mut self,
        albedo: &Self::Grid<Vec4>,
        light: &Gathered<Self>,
        settings: &GiSettings,
        radiance: &mut Self::Grid<Vec4>,
        job: &Job,
    ) -> Result<()>;
    /// Pass `blend`: what the mirrors show over the points' own part; their albedo where there is no light.
    fn blend(
        &mut self,
        radiance: &mut Self::Grid<Vec4>,
        gbuffer: &GBuffer<Self>,
        mirror: &MirrorGBuffer<Self>,
        shown: Option<&Self::Grid<Vec4>>,
        job: &Job,
    ) -> Result<()>;

    /// A grid in main memory; nothing is copied that is there already.
    fn take<T: Pod>(&mut self, grid: Self::Grid<T>) -> Result<Grid<T>>;
    /// A grid's values, row by row.
    fn read<'a, T: Pod>(&mut self, grid: &'a Self::Grid<T>) -> Result<Cow<'a, [T]>>;
    /// A grid from main memory; nothing is copied that stays there.
    fn put<T: Pod>(&mut self, grid: Grid<T>) -> Result<Self::Grid<T>>;
    /// A grid from its values, row by row.
    fn write<T: Pod>(&mut self, size: UVec2, values: &[T]) -> Result<Self::Grid<T>>;
}
