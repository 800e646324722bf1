//! What the mirrors show, pixel by pixel: every reflection method fills the same buffer.

use glam::{UVec2, Vec4};

use super::{MirrorCoverage, Surface};
use crate::backend::Backend;
use crate::backend::cpu::Cpu;
use crate::error::Result;
use crate::gbuffer::average::Pixel;
use crate::grid::Grid;

/// What each mirror pixel shows: one surfel, seen along the reflected ray.
pub struct MirrorGBuffer<B: Backend> {
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

impl<B: Backend> MirrorGBuffer<B> {
    /// The buffer in main memory.
    ///
    /// # Errors
    /// What the backend meets.
    pub fn take(self, backend: &mut B) -> Result<MirrorGBuffer<Cpu>> {
        Ok(MirrorGBuffer {
            origin: backend.take(self.origin)?,
            direction: backend.take(self.direction)?,
            surface: backend.take(self.surface)?,
            albedo: backend.take(self.albedo)?,
            material: backend.take(self.material)?,
            region: backend.take(self.region)?,
            count: backend.take(self.count)?,
            level: backend.take(self.level)?,
        })
    }
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
    pub(crate) fn show(&mut self, index: usize, pixel: Pixel) {
        self.surface.values_mut()[index] = pixel.surface;
        self.albedo.values_mut()[index] = pixel.albedo;
        self.material.values_mut()[index] = pixel.material;
    }

    /// The buffer on a backend.
    ///
    /// # Errors
    /// What the backend meets.
    pub fn put<B: Backend>(self, backend: &mut B) -> Result<MirrorGBuffer<B>> {
        Ok(MirrorGBuffer {
            origin: backend.put(self.origin)?,
            direction: backend.put(self.direction)?,
            surface: backend.put(self.surface)?,
            albedo: backend.put(self.albedo)?,
            material: backend.put(self.material)?,
            region: backend.put(self.region)?,
            count: backend.put(self.count)?,
            level: backend.put(self.level)?,
        })
    }

    /// How many pixels show something.
    pub fn coverage(&self) -> MirrorCoverage {
        let mut coverage = MirrorCoverage::default();
        let pixels = self.origin.values().iter().zip(self.material.values());
        for ((origin, material), albedo) in pixels.zip(self.albedo.values()) {
            coverage.pixels += u64::from(origin.w > 0.0);
            coverage.covered += u64::from(material.w > 0.0);
            coverage.mirrors += u64::from(material.w > 0.0 && albedo.w > 0.0);
        }
        coverage
    }
}
