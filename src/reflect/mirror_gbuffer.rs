//! What the mirrors show, pixel by pixel: every reflection method fills the same buffer.

use glam::{UVec2, Vec4};

use super::Surface;
use crate::backend::Backend;
use crate::backend::cpu::Cpu;
use crate::gbuffer::average::Pixel;
use crate::grid::Grid;

/// What each mirror pixel shows: one surfel, seen along the reflected ray.
pub struct MirrorGBuffer<B: Backend + ?Sized> {
    /// Where each ray starts, the mirror's point relative to the scene's origin; w is 1 on a mirror, else 0.
    pub origin: B::Grid<Vec4>,
    /// Unit direction of each ray. What is seen is at origin + direction x distance.
    pub direction: B::Grid<Vec4>,
    /// Unit normal of what is seen, towards the mirror, and distance along the ray; 0 where nothing is seen.
    pub surface: B::Grid<Vec4>,
    /// Linear RGB, 0 to 1, and mirror reflectance.
    pub albedo: B::Grid<Vec4>,
    /// Specular reflectance, shininess, radius (local spacing), and validity: 1 where something is seen, else 0.
    pub material: B::Grid<Vec4>,
    /// Region of the mirror, counted from 1; 0 where there is none.
    pub region: B::Grid<u32>,
    /// Points accumulated.
    pub count: B::Grid<u32>,
    /// How the pixel was found: 0 by the search, n filled from pull level n, -1 by a ray.
    pub level: B::Grid<f32>,
}

impl MirrorGBuffer<Cpu> {
    /// A picture without mirrors.
    pub fn empty(size: UVec2) -> Self {
        let grid = || Grid::new(size, Vec4::ZERO);
        Self {
            origin: grid(),
            direction: grid(),
            surface: grid(),
            albedo: grid(),
            material: grid(),
            region: Grid::new(size, 0),
            count: Grid::new(size, 0),
            level: Grid::new(size, 0.0),
        }
    }

    /// The rays of a surface, which show nothing yet.
    pub fn of(surface: &Surface<Cpu>) -> Self {
        let mut mirror = Self::empty(surface.size);
        for i in 0..mirror.origin.values().len() {
            if let Some((from, towards)) = surface.reflected(i) {
                mirror.origin.values_mut()[i] = from.extend(1.0);
                mirror.direction.values_mut()[i] = towards.extend(0.0);
            }
        }
        mirror
    }

    /// Width and height, pixels.
    pub fn size(&self) -> UVec2 {
        self.origin.size()
    }

    /// What the value `index` shows; `None` where that is nothing.
    pub fn at(&self, index: usize) -> Option<Pixel> {
        let material = *self.material.values().get(index)?;
        (material.w > 0.0).then_some(Pixel {
            surface: *self.surface.values().get(index)?,
            albedo: *self.albedo.values().get(index)?,
            material,
        })
    }

    /// Lets the value `index` show `pixel`.
    pub(crate) fn put(&mut self, index: usize, pixel: Pixel) {
        self.surface.values_mut()[index] = pixel.surface;
        self.albedo.values_mut()[index] = pixel.albedo;
        self.material.values_mut()[index] = pixel.material;
    }

    /// Number of pixels that show something.
    pub fn covered(&self) -> u64 {
        self.material.values().iter().filter(|m| m.w > 0.0).count() as u64
    }
}
