//! Mirrors: what they show, found by searching the screen or by tracing rays.

use bytemuck::{Pod, Zeroable};
use glam::{UVec2, Vec2, Vec3, Vec4};

use crate::backend::Backend;
use crate::backend::cpu::Cpu;
use crate::{setting_choice, settings_group};
use sscr::{LhcMap, Region};

mod blend;
pub mod cost;
mod doubt;
mod mirror_gbuffer;
pub mod ray_trace;
mod reflector;
pub mod sscr;
mod surface;

pub use blend::blend;
pub use mirror_gbuffer::MirrorGBuffer;
pub use reflector::Reflector;

setting_choice! {
    /// How it is found what a mirror shows.
    pub enum Method {
        /// Screen-space curved reflections: for every point the mirror pixel that shows it is searched [Preiner 2010].
        Sscr = "sscr",
        /// The reference: for every mirror pixel the reflected ray is traced through all points.
        RayTrace = "ray_trace",
        /// The guided search (whatever `sscr.search` says) or traced rays, whichever a model of their cost says is cheaper for
        /// the mirrors in the picture.
        Auto = "auto",
    }
}

settings_group! {
    /// What mirrors show.
    pub struct ReflectSettings in "reflect" {
        /// How it is found what a mirror shows. "sscr" costs by the number of points, "ray_trace" by that of the mirror's
        /// pixels, beside a tree over all points.
        method: Method = Method::Sscr;
    }
}

/// From where a surface is seen: the camera, or, mirror bounce by mirror bounce, the mirror point of each pixel.
pub enum Eye<B: Backend> {
    /// One point, relative to the scene's origin.
    Point(Vec3),
    /// A point per pixel, relative to the scene's origin.
    PerPixel(B::Grid<Vec4>),
}

/// The mirrors that a G-buffer shows: what a reflection method works on.
pub struct Surface<B: Backend> {
    /// Width and height, pixels.
    pub size: UVec2,
    /// Point on the mirror relative to the scene's origin; w is 1 on the front of a mirror, else 0.
    pub point: B::Grid<Vec4>,
    /// Unit normal, on the side of the eye; w is the local spacing of the mirror's points.
    pub normal: B::Grid<Vec4>,
    /// From where it is seen.
    pub eye: Eye<B>,
}

/// The mirrors of a picture, labelled: what a search works on.
pub struct LabelledMirrors<'a, B: Backend> {
    /// The mirrors.
    pub surface: &'a Surface<B>,
    /// Region of each pixel, counted from 1; 0 where there is none.
    pub labels: &'a B::Grid<u32>,
    /// The regions, largest first; region k is `regions[k - 1]`.
    pub regions: &'a [Region],
    /// The picture's x axis in the scene, unit length.
    pub right: Vec3,
}

impl<'a> LabelledMirrors<'a, Cpu> {
    /// The mirrors of a picture with the unit x axis `right`, and their regions.
    pub fn new(surface: &'a Surface<Cpu>, lhc: &'a LhcMap, right: Vec3) -> Self {
        Self {
            surface,
            labels: &lhc.labels,
            regions: &lhc.regions,
            right,
        }
    }
}

/// A point of the cloud, and the mirror pixel that shows it.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Hit {
    /// Where it is seen, pixels (centres at + 0.5).
    pub pixel: Vec2,
    /// Half the sides of its splat, along x and y, pixels.
    pub reach: Vec2,
    /// Index of the surfel.
    pub point: u32,
    /// Distance from the mirror point, in the cloud's unit.
    pub distance: f32,
}

/// How many pixels of the mirrors show something.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct MirrorCoverage {
    /// Pixels of mirrors.
    pub pixels: u64,
    /// Those of them that show something.
    pub covered: u64,
    /// Those of them that show a mirror, which is black.
    pub mirrors: u64,
}
