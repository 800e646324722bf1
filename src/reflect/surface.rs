//! The mirrors that a G-buffer shows, as a surface with an eye: what reflection methods work on.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::{Eye, Surface};
use crate::backend::Backend;
use crate::backend::cpu::Cpu;
use crate::error::Result;
use crate::gbuffer::{GBuffer, column_row};
use crate::grid::Grid;

impl<B: Backend> Surface<B> {
    /// The surface in main memory.
    ///
    /// # Errors
    /// What the backend meets.
    pub fn take(self, backend: &mut B) -> Result<Surface<Cpu>> {
        Ok(Surface {
            size: self.size,
            point: backend.take(self.point)?,
            normal: backend.take(self.normal)?,
            eye: match self.eye {
                Eye::Point(eye) => Eye::Point(eye),
                Eye::PerPixel(eyes) => Eye::PerPixel(backend.take(eyes)?),
            },
        })
    }
}

impl Surface<Cpu> {
    /// The mirrors that the camera sees from the front.
    pub fn of(gbuffer: &GBuffer<Cpu>) -> Self {
        let (size, width) = (gbuffer.size(), gbuffer.surface.width());
        let mut point = Grid::new(size, Vec4::ZERO);
        let mut normal = Grid::new(size, Vec4::ZERO);
        let pixels = point
            .values_mut()
            .par_iter_mut()
            .zip(normal.values_mut())
            .enumerate();
        pixels.for_each(|(i, (point, normal))| {
            let (x, y) = column_row(i, width);
            if let Some(seen) = gbuffer.at(x, y).filter(|p| p.albedo.w > 0.0) {
                let at = gbuffer.pinhole.eye + gbuffer.direction(x, y) * seen.surface.w;
                *point = at.extend(1.0);
                *normal = seen.surface.truncate().extend(seen.material.z);
            }
        });
        Self {
            size,
            point,
            normal,
            eye: Eye::Point(gbuffer.pinhole.eye),
        }
    }

    /// The ray that leaves the mirror at the value `index`: its origin, and its unit direction; `None` where there is none.
    pub fn reflected(&self, index: usize) -> Option<(Vec3, Vec3)> {
        let point = self
            .point
            .values()
            .get(index)
            .filter(|p| p.w > 0.0)?
            .truncate();
        let normal = self.normal.values().get(index)?.truncate();
        let eye = match &self.eye {
            Eye::Point(eye) => *eye,
            Eye::PerPixel(eyes) => eyes.values().get(index)?.truncate(),
        };
        let view = point - eye;
        let direction = view - normal * (2.0 * view.dot(normal));
        Some((point, direction.try_normalize()?))
    }

    /// Number of pixels that show a mirror.
    pub fn pixels(&self) -> u64 {
        self.point.values().par_iter().filter(|p| p.w > 0.0).count() as u64
    }
}
