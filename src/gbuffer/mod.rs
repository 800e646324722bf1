//! Points become a G-buffer: splatting in three passes over a projection, hole filling and smoothing.

pub mod average;
pub mod coverage;
pub mod depth;
pub mod disc;
pub mod edl;
pub mod fill;
pub mod leak;
pub mod pull_push;
pub mod smooth;
pub mod splat;
pub mod tile;
pub(crate) mod tiles;
pub mod visibility;

use glam::{UVec2, Vec2, Vec3, Vec4};

use crate::backend::Backend;
use crate::backend::cpu::Cpu;
use crate::camera::Pinhole;
use crate::cloud::Finish;
use crate::grid::Grid;
use crate::settings_group;
use average::Pixel;

settings_group! {
    /// How points become a G-buffer.
    pub struct SplatSettings in "splat" {
        /// Half width of a splat. Below 1.2 random points leave holes; cost grows with its square.
        /// At 1.5 seven discs cover a point of the surface on average, and one pixel in 1,100 stays empty.
        size: f32 = 1.5, 0.1..=16.0, "x radius";
        /// Depth by which a surfel may lie behind the nearest of its pixel and still be blended.
        depth_tolerance: f32 = 2.0, 0.0..=100.0, "x radius";
        /// How often holes are filled from the plane of their neighbours; each time closes one ring of pixels. Gaps of up
        /// to two spacings through which the background leaks count as holes. 0 leaves both.
        fill: u32 = 3, 0..=16, "rings";
        /// Width of the joint bilateral Gaussian over the normals and depths of mirrors; 0 leaves them as splatted. What a curved mirror shows depends on its normals: 1.5 brings their median error from 0.19 to 0.07 degrees on the
        /// sphere scene; more flattens silhouettes. Cost grows with its square and with the mirrors' pixels.
        smooth: f32 = 1.5, 0.0..=8.0, "pixels";
    }
}

/// What is seen in each pixel: one surfel, blended from those that cover it.
pub struct GBuffer<B: Backend> {
    /// How it was projected; positions follow from the depth.
    pub pinhole: Pinhole,
    /// Unit normal towards the viewer (scene's frame), and depth along the axis; depth 0 where nothing is seen.
    pub surface: B::Grid<Vec4>,
    /// Linear RGB, 0 to 1, and mirror reflectance.
    pub albedo: B::Grid<Vec4>,
    /// Specular reflectance, shininess, radius (local spacing), and validity: 0 where nothing is seen, 1 where splatted,
    /// 1 + k where filled in ring k.
    pub material: B::Grid<Vec4>,
}

impl GBuffer<Cpu> {
    /// A G-buffer in which nothing is seen.
    pub fn empty(pinhole: Pinhole) -> Self {
        let grid = || Grid::new(pinhole.size, Vec4::ZERO);
        Self {
            pinhole,
            surface: grid(),
            albedo: grid(),
            material: grid(),
        }
    }

    /// Width and height, pixels.
    pub fn size(&self) -> UVec2 {
        self.pinhole.size
    }

    /// What column `x`, row `y` shows; `None` outside and where nothing is seen.
    pub fn at(&self, x: i32, y: i32) -> Option<Pixel> {
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        let material = *self.material.get(x, y)?;
        (material.w > 0.0).then_some(Pixel {
            surface: *self.surface.get(x, y)?,
            albedo: *self.albedo.get(x, y)?,
            material,
        })
    }

    /// The ray through the centre of column `x`, row `y`, scaled to 1 along the axis.
    pub fn direction(&self, x: i32, y: i32) -> Vec3 {
        self.pinhole
            .direction(Vec2::new(x as f32 + 0.5, y as f32 + 0.5))
    }

    /// Replaces pixels, by index.
    fn put(&mut self, changed: impl IntoIterator<Item = (usize, Pixel)>) {
        for (i, pixel) in changed {
            self.surface.values_mut()[i] = pixel.surface;
            self.albedo.values_mut()[i] = pixel.albedo;
            self.material.values_mut()[i] = pixel.material;
        }
    }
}

/// Column and row of the value `index` of a picture `width` wide.
pub(crate) fn column_row(index: usize, width: usize) -> (i32, i32) {
    ((index % width) as i32, (index / width) as i32)
}

/// The depth key of a pixel in which nothing is seen.
pub const EMPTY: u32 = u32::MAX;

/// What a surfel may blend with: nothing of another class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Class {
    /// Points that are no mirror, from either side.
    Diffuse = 0,
    /// Mirrors from the front.
    MirrorFront = 1,
    /// Mirrors from behind: opaque and black.
    MirrorBack = 2,
}

impl Class {
    /// The class of a surfel seen from one side.
    pub fn of(finish: Finish, behind: bool) -> Self {
        match (finish.mirror() > 0.0, behind) {
            (false, _) => Self::Diffuse,
            (true, false) => Self::MirrorFront,
            (true, true) => Self::MirrorBack,
        }
    }
}

/// Bits of a depth key that hold the class.
const CLASS_BITS: u32 = 3;

/// A fragment of the nearest surface as one integer that sorts by depth: bit 31 says whether it lies on its disc's rim,
/// bits 30 to 2 are those of the (positive) depth, bits 1 and 0 are its class.
///
/// A rim yields to any surface behind it, so that silhouettes grow less than the discs reach over them. Classes never
/// blend; the nearest decides the pixel's.
pub fn depth_key(depth: f32, class: Class, rim: bool) -> u32 {
    depth.to_bits() & !CLASS_BITS | class as u32 | u32::from(rim) << 31
}

/// The depth of a key; `None` for [`EMPTY`].
pub fn depth_from_key(key: u32) -> Option<f32> {
    (key != EMPTY).then(|| f32::from_bits(key & !CLASS_BITS & !(1 << 31)))
}

/// Whether two keys, neither of them [`EMPTY`], are of one class.
pub fn same_class(a: u32, b: u32) -> bool {
    (a ^ b) & CLASS_BITS == 0
}

/// How many pixels of a G-buffer show something.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Coverage {
    /// Pixels in all.
    pub pixels: u64,
    /// Pixels that show their own splats: filled leaks do not.
    pub splatted: u64,
    /// Pixels that show something after filling.
    pub filled: u64,
    /// Pixels that show a mirror's front, after filling.
    pub mirror: u64,
}
