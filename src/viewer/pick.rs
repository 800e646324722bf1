//! The surface around a pixel of the picture, as a rule that chooses its points.

use std::collections::VecDeque;

use catoptric::cloud::{Bounds, Select};
use catoptric::renderer::Products;
use glam::{DVec3, UVec2, Vec2, Vec3};

/// Neighbours whose normals differ by more than this are another surface; its cosine.
const SAME_SURFACE: f32 = 0.966;

/// Neighbours that are farther off each other's planes than this are another surface, spacings.
const STEP: f32 = 2.0;

/// Points are of a plane that are not farther from it, spacings.
const FLAT: f64 = 3.0;

/// Part of the pixels that must lie that near for the surface to be flat.
const MOST: f64 = 0.98;

/// What is joined to a pixel without a step or an edge: the points near its plane, in its box, where it is flat, else those in
/// its box. `None` where the pixel shows no point.
pub(super) fn region(
    products: &Products,
    origin: DVec3,
    pixel: UVec2,
    spacing: f64,
) -> Option<Select> {
    let surface = Joined::around(products, pixel, spacing as f32)?;
    let count = surface.positions.len() as f64;
    let centre = surface
        .positions
        .iter()
        .map(|p| p.as_dvec3())
        .sum::<DVec3>()
        / count;
    let normal = surface.normals.iter().map(|n| n.as_dvec3()).sum::<DVec3>();
    let normal = normal.try_normalize()?;
    let positions = surface.positions.iter().map(|p| origin + p.as_dvec3());
    let bounds = Bounds::of(positions);
    let margin = DVec3::splat(2.0 * spacing);
    let within = Bounds {
        min: bounds.min - margin,
        max: bounds.max + margin,
    };
    let off = |p: &&Vec3| (p.as_dvec3() - centre).dot(normal).abs() <= FLAT * spacing;
    let near = surface.positions.iter().filter(off).count() as f64;
    Some(if near >= MOST * count {
        Select::NearPlane {
            point: origin + centre,
            normal,
            distance: FLAT * spacing,
            within: Some(within),
        }
    } else {
        Select::Box {
            min: within.min,
            max: within.max,
        }
    })
}

/// Pixels of one surface.
struct Joined {
    /// Relative to the scene's origin.
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

impl Joined {
    fn around(products: &Products, pixel: UVec2, spacing: f32) -> Option<Self> {
        let gbuffer = &products.gbuffer;
        let (width, height) = (gbuffer.surface.width(), gbuffer.surface.height());
        let at = |i: usize| -> Option<(Vec3, Vec3)> {
            let valid = gbuffer.material.values().get(i)?.w > 0.0;
            let surface = gbuffer.surface.values().get(i)?;
            let centre = Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
            let position = gbuffer.pinhole.world_from_pixel(centre, surface.w);
            valid.then(|| (position, surface.truncate().normalize_or_zero()))
        };
        let (x, y) = (pixel.x as usize, pixel.y as usize);
        if x >= width || y >= height {
            return None;
        }
        let start = y * width + x;
        at(start)?;
        let mut seen = vec![false; width * height];
        seen[start] = true;
        let mut waiting = VecDeque::from([start]);
        let mut joined = Self {
            positions: Vec::new(),
            normals: Vec::new(),
        };
        while let Some(i) = waiting.pop_front() {
            let Some((position, normal)) = at(i) else {
                continue;
            };
            joined.positions.push(position);
            joined.normals.push(normal);
            let (x, y) = (i % width, i / width);
            let neighbours = [
                (x > 0).then(|| i - 1),
                (x + 1 < width).then(|| i + 1),
                (y > 0).then(|| i - width),
                (y + 1 < height).then(|| i + width),
            ];
            for next in neighbours.into_iter().flatten() {
                let Some((other, its)) = at(next).filter(|_| !seen[next]) else {
                    continue;
                };
                let off = (other - position).dot(normal).abs();
                if its.dot(normal) >= SAME_SURFACE && off <= STEP * spacing {
                    seen[next] = true;
                    waiting.push_back(next);
                }
            }
        }
        Some(joined)
    }
}
