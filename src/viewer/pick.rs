//! The surface around a pixel of the picture, as a rule that chooses its points.

use std::collections::VecDeque;

use catoptric::cloud::{Bounds, Select};
use catoptric::renderer::Products;
use glam::{DVec3, UVec2, Vec2, Vec3};

/// A flat surface has normals that are no farther from the first one's than this, and half of them nearer than that; cosines
/// of 30 and 10 degrees. On a ball, half of those within 30 degrees are more than 21 off.
const FLAT: f32 = 0.866;
const HALF: f32 = 0.985;

/// A flat surface is no farther from its plane than so many spacings.
const THICK: f32 = 3.0;

/// Where normals turn by more than this (its cosine) over so many spacings, a curved surface has an edge. Neighbouring pixels
/// would not tell: splats that overlap turn slowly from one side to the other.
const SMOOTH: f32 = 0.9;
const REACH: f32 = 2.0;

/// Neighbours that are farther off each other's planes than this are another surface, spacings.
const STEP: f32 = 2.0;

/// The surface around a pixel, as what chooses its points: those near its plane, in its box, where it is flat; else those in the
/// box of all that is joined to it without a step or an edge. `None` where the pixel shows no point.
pub(super) fn region(
    products: &Products,
    origin: DVec3,
    pixel: UVec2,
    spacing: f64,
) -> Option<Select> {
    let picture = Picture(products);
    let size = products.gbuffer.surface.size();
    if pixel.cmpge(size).any() {
        return None;
    }
    let start = (pixel.y * size.x + pixel.x) as usize;
    let step = spacing as f32;
    if let Some((joined, normal)) = picture.flat(start, step) {
        let count = joined.positions.len() as f64;
        let centre = joined.positions.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / count;
        return Some(Select::NearPlane {
            point: origin + centre,
            normal: normal.as_dvec3().normalize_or(DVec3::Z),
            distance: f64::from(THICK) * spacing,
            within: Some(joined.bounds(origin, spacing)),
        });
    }
    let Bounds { min, max } = picture.smooth(start, step)?.bounds(origin, spacing);
    Some(Select::Box { min, max })
}

/// Pixels of one surface.
struct Joined {
    /// Relative to the scene's origin.
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

impl Joined {
    /// The box around them, in the scene's frame, with a little room.
    fn bounds(&self, origin: DVec3, spacing: f64) -> Bounds {
        let bounds = Bounds::of(self.positions.iter().map(|p| origin + p.as_dvec3()));
        let room = DVec3::splat(2.0 * spacing);
        Bounds {
            min: bounds.min - room,
            max: bounds.max + room,
        }
    }

    fn mean_normal(&self) -> Option<Vec3> {
        self.normals.iter().sum::<Vec3>().try_normalize()
    }
}

struct Picture<'a>(&'a Products);

impl Picture<'_> {
    /// Where what a pixel shows is, and which way it faces.
    fn at(&self, i: usize) -> Option<(Vec3, Vec3)> {
        let gbuffer = &self.0.gbuffer;
        let valid = gbuffer.material.values().get(i)?.w > 0.0;
        let surface = gbuffer.surface.values().get(i)?;
        let width = gbuffer.surface.width();
        let centre = Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
        let position = gbuffer.pinhole.world_from_pixel(centre, surface.w);
        valid.then(|| (position, surface.truncate().normalize_or_zero()))
    }

    /// The flat surface around a pixel, and its normal.
    fn flat(&self, start: usize, spacing: f32) -> Option<(Joined, Vec3)> {
        let (point, mut normal) = self.at(start)?;
        let grow = |normal: Vec3| {
            let flat = |position: Vec3, its: Vec3| {
                its.dot(normal) >= FLAT && (position - point).dot(normal).abs() <= THICK * spacing
            };
            self.grow(start, |_, (position, its)| {
                flat(position, its).then_some(())
            })
        };
        // The first pixel's normal may be off by some degrees; that of all around it is less.
        for _ in 0..2 {
            normal = grow(normal)?.mean_normal()?;
        }
        let joined = grow(normal)?;
        let near = joined.normals.iter().filter(|its| its.dot(normal) >= HALF);
        (near.count() * 2 >= joined.normals.len()).then_some((joined, normal))
    }

    /// All that is joined to a pixel without a step or an edge.
    fn smooth(&self, start: usize, spacing: f32) -> Option<Joined> {
        let first = self.at(start)?;
        // With each pixel goes the last one on the way to it that was a reach away from the one before.
        let mut anchors = vec![first; self.0.gbuffer.surface.values().len()];
        self.grow(start, |(from, i), (position, normal)| {
            let (before, its) = self.at(from)?;
            let anchor = *anchors.get(from)?;
            let joined = (position - before).dot(its).abs() <= STEP * spacing
                && normal.dot(anchor.1) >= SMOOTH;
            let far = position.distance(anchor.0) >= REACH * spacing;
            *anchors.get_mut(i)? = if far { (position, normal) } else { anchor };
            joined.then_some(())
        })
    }

    /// Pixels joined to the first one. `accepts` is given two neighbours, the first of which is joined, and what the second
    /// shows.
    fn grow(
        &self,
        start: usize,
        mut accepts: impl FnMut((usize, usize), (Vec3, Vec3)) -> Option<()>,
    ) -> Option<Joined> {
        let surface = &self.0.gbuffer.surface;
        let (width, height) = (surface.width(), surface.height());
        let (position, normal) = self.at(start)?;
        let mut joined = Joined {
            positions: vec![position],
            normals: vec![normal],
        };
        let mut seen = vec![false; width * height];
        *seen.get_mut(start)? = true;
        let mut waiting = VecDeque::from([start]);
        while let Some(i) = waiting.pop_front() {
            let (x, y) = (i % width, i / width);
            let neighbours = [
                (x > 0).then(|| i - 1),
                (x + 1 < width).then(|| i + 1),
                (y > 0).then(|| i - width),
                (y + 1 < height).then(|| i + width),
            ];
            for next in neighbours.into_iter().flatten() {
                let Some((position, normal)) = self.at(next).filter(|_| !seen[next]) else {
                    continue;
                };
                if accepts((i, next), (position, normal)).is_some() {
                    seen[next] = true;
                    joined.positions.push(position);
                    joined.normals.push(normal);
                    waiting.push_back(next);
                }
            }
        }
        Some(joined)
    }
}
