//! Pass `receivers`: what the pixels show, as the passes of indirect light take it; the same for the camera's picture and for
//! what the mirrors show, so that both are lit alike. CPU twin of `shaders/receivers.wgsl` and `shaders/mirror_receivers.wgsl`.

use glam::{UVec2, Vec3, Vec4};
use rayon::prelude::*;

use crate::backend::Backend;
use crate::backend::cpu::Cpu;
use crate::gbuffer::average::Pixel;
use crate::gbuffer::{GBuffer, column_row};
use crate::grid::Grid;
use crate::reflect::MirrorGBuffer;

/// What receives light, pixel by pixel.
pub struct Receivers<B: Backend> {
    /// Width and height, pixels.
    pub size: UVec2,
    /// Relative to the scene's origin; w is the local spacing, 0 where nothing is to be lit.
    pub position: B::Grid<Vec4>,
    /// Unit normal towards the eye; w is the specular reflectance.
    pub normal: B::Grid<Vec4>,
    /// Unit vector towards the eye, or the mirror's point; w is the exponent of the specular lobe.
    pub view: B::Grid<Vec4>,
}

/// Values of [`Receivers`] for what is seen along `direction` (any length) at `position`; nothing for perfect mirrors, which
/// have no part of their own.
fn receiver(seen: &Pixel, position: Vec3, direction: Vec3) -> [Vec4; 3] {
    if seen.albedo.w >= 1.0 {
        return [Vec4::ZERO; 3];
    }
    let length =
        (direction.x * direction.x + direction.y * direction.y + direction.z * direction.z).sqrt();
    [
        position.extend(seen.material.z),
        seen.surface.truncate().extend(seen.material.x),
        (-direction / length).extend(seen.material.y),
    ]
}

impl Receivers<Cpu> {
    fn from(size: UVec2, value: impl Fn(usize) -> [Vec4; 3] + Sync) -> Self {
        let grid = || Grid::new(size, Vec4::ZERO);
        let (mut position, mut normal, mut view) = (grid(), grid(), grid());
        position
            .values_mut()
            .par_iter_mut()
            .zip(normal.values_mut())
            .zip(view.values_mut())
            .enumerate()
            .for_each(|(i, ((position, normal), view))| [*position, *normal, *view] = value(i));
        Self {
            size,
            position,
            normal,
            view,
        }
    }

    /// What the camera sees.
    pub fn of(gbuffer: &GBuffer<Cpu>) -> Self {
        let width = gbuffer.surface.width();
        Self::from(gbuffer.size(), |i| {
            let (x, y) = column_row(i, width);
            let Some(seen) = gbuffer.at(x, y) else {
                return [Vec4::ZERO; 3];
            };
            let direction = gbuffer.direction(x, y);
            let position = gbuffer.pinhole.eye + direction * seen.surface.w;
            receiver(&seen, position, direction)
        })
    }

    /// What the mirrors show, seen from their points.
    pub fn of_mirror(mirror: &MirrorGBuffer<Cpu>) -> Self {
        let (origins, directions) = (mirror.origin.values(), mirror.direction.values());
        Self::from(mirror.size(), |i| {
            let Some(seen) = mirror.at(i) else {
                return [Vec4::ZERO; 3];
            };
            let direction = directions[i].truncate();
            let position = origins[i].truncate() + direction * seen.surface.w;
            receiver(&seen, position, direction)
        })
    }
}
