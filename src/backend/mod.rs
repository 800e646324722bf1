//! Where the stages run. One frame ([`crate::frame`]) is written once, over the trait [`Backend`].

use std::borrow::Cow;
use std::sync::Arc;

use bytemuck::Pod;
use glam::{UVec2, Vec4};

use crate::camera::Pinhole;
use crate::cloud::Surfels;
use crate::error::Result;
use crate::gbuffer::{Coverage, GBuffer, SplatSettings};
use crate::gi::{GiSettings, SpotLight};
use crate::grid::Grid;
use crate::image::ImageSettings;
use crate::job::Job;
use crate::timing::Timings;

pub mod cpu;
pub mod gpu;

/// What a spot light sees: the nearest surfel of every texel.
pub struct LightMap<B: Backend + ?Sized> {
    /// The light's projection.
    pub pinhole: Pinhole,
    /// Depth keys ([`crate::gbuffer::depth_key`]); [`crate::gbuffer::EMPTY`] where the light sees nothing.
    pub keys: B::Grid<u32>,
}

/// A light with the map of what it sees.
pub struct LitBy<B: Backend + ?Sized> {
    /// The light, relative to the scene's origin.
    pub light: SpotLight,
    /// What it sees.
    pub map: LightMap<B>,
}

/// A machine that runs the stages: one method a stage. Each ends with [`crate::Error::Cancelled`] soon after its job was
/// cancelled.
pub trait Backend {
    /// A value per pixel, where this backend keeps it.
    type Grid<T: Pod>;
    /// The surfels, where this backend keeps them.
    type Points;

    /// "cpu" or "gpu".
    fn name(&self) -> &'static str;
    /// The adapter's name, where there is one.
    fn adapter(&self) -> Option<String>;
    /// Wall time of every pass since the last call.
    fn take_timings(&mut self) -> Timings;

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

    /// A grid in main memory; nothing is copied that is there already.
    fn take<T: Pod>(&mut self, grid: Self::Grid<T>) -> Result<Grid<T>>;
    /// A grid's values, row by row.
    fn read<'a, T: Pod>(&mut self, grid: &'a Self::Grid<T>) -> Result<Cow<'a, [T]>>;
    /// A grid from its values, row by row.
    fn write<T: Pod>(&mut self, size: UVec2, values: &[T]) -> Result<Self::Grid<T>>;
}
