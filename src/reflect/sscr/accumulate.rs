//! Pass `accumulate`: the hits of the search are splatted onto the mirrors, by the same three passes as the camera's:
//! depth, visibility, averaging [Preiner 2010, sections 3.7 and 4.5].
//!
//! Each pixel of a splat looks along its own reflected ray: the depth of a fragment is where that ray meets the surfel's
//! plane. The interleaved search's splats are squares, whose fragments count the less the farther off the surfel their ray
//! passes. The guided search knows how much the mirror magnifies: its splats reach as far as the surfel's disc may appear,
//! and have a fragment where the pixel's ray meets the disc, so that magnified surfels stay as closed as they are.

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use wide::{f32x4, i32x4};

use super::settings::{Splatting, Visibility};
use crate::backend::cpu::Cpu;
use crate::cloud::{Finish, Place, Surfels};
use crate::error::Result;
use crate::gbuffer::average::{Pixel, average};
use crate::gbuffer::disc::{EDGE_ON_COSINE_SQUARED, MAX_TOLERANCE_SLOPE, PixelRect, weight};
use crate::gbuffer::tiles::Tiles;
use crate::gbuffer::visibility::{Sums, attributes, scale};
use crate::gbuffer::{Class, EMPTY, depth_from_key, depth_key, same_class};
use crate::job::Job;
use crate::reflect::{Hit, MirrorGBuffer};

/// A ray that meets a surfel's plane at more than this many times the distance of the hit, or less than its inverse, takes
/// that of the hit: it passes the plane too flatly to tell.
pub const DEPTH_RANGE: f32 = 1.25;

/// Largest half side of a splat, pixels: where a mirror's picture folds, a point is magnified without bound.
pub const LARGEST_REACH: f32 = 64.0;

/// Splats hits. Keeps its working memory between frames.
#[derive(Debug, Default)]
pub struct Accumulator {
    tiles: Tiles,
}

/// What the splats need to know.
struct Context<'a> {
    surfels: &'a Surfels,
    mirror: &'a MirrorGBuffer<Cpu>,
    splatting: &'a Splatting,
}

/// A surfel that a mirror shows.
#[derive(Clone, Copy)]
struct Splat {
    place: Place,
    finish: Finish,
    pixel: Vec2,
    distance: f32,
    half: Vec2,
    /// Of the surfel as it is drawn.
    radius: f32,
    region: u32,
    bounds: PixelRect,
}

/// A splat's part in a pixel.
struct Fragment {
    distance: f32,
    weight: f32,
    behind: bool,
    /// How far behind the nearest it may lie and still be averaged with it.
    tolerance: f32,
}

impl Context<'_> {
    /// Half the sides of a hit's splat, pixels.
    fn half(&self, hit: &Hit) -> Vec2 {
        match self.splatting.disc {
            // What is not a number, where the mirror's picture folds, is as large as can be.
            Some(_) => (hit.reach * self.splatting.enlarged).min(Vec2::splat(LARGEST_REACH)),
            None => hit.reach,
        }
    }

    /// Pixels whose centres a hit's splat covers, at least the one it lies in.
    fn bounds(&self, hit: &Hit) -> Option<PixelRect> {
        let (half, size) = (self.half(hit), self.mirror.size().as_vec2());
        let cut = |v: f32, limit: f32| v.clamp(0.0, limit) as u32;
        let rect = PixelRect {
            x0: cut(hit.pixel.x - half.x + 0.5, size.x).min(cut(hit.pixel.x, size.x)),
            y0: cut(hit.pixel.y - half.y + 0.5, size.y).min(cut(hit.pixel.y, size.y)),
            x1: cut(hit.pixel.x + half.x + 0.5, size.x).max(cut(hit.pixel.x + 1.0, size.x)),
            y1: cut(hit.pixel.y + half.y + 0.5, size.y).max(cut(hit.pixel.y + 1.0, size.y)),
        };
        (!rect.is_empty()).then_some(rect)
    }

    fn splat(&self, hit: &Hit) -> Option<Splat> {
        let index = hit.point as usize;
        let size = self.mirror.size();
        let at = hit.pixel.y as usize * size.x as usize + hit.pixel.x as usize;
        let place = *self.surfels.places.get(index)?;
        Some(Splat {
            place,
            finish: *self.surfels.finishes.get(index)?,
            pixel: hit.pixel,
            distance: hit.distance,
            half: self.half(hit),
            radius: place.radius * self.splatting.enlarged,
            region: *self.mirror.region.values().get(at)?,
            bounds: self.bounds(hit)?,
        })
    }

    /// A splat's part in the pixel at column `x`, row `y`; `None` where it has none.
    fn fragment(&self, splat: &Splat, x: u32, y: u32) -> Option<Fragment> {
        let index = y as usize * self.mirror.size().x as usize + x as usize;
        let origin = self.mirror.origin.values().get(index)?;
        let direction = self.mirror.direction.values().get(index)?.truncate();
        if origin.w <= 0.0 {
            return None;
        }
        let to_surfel = splat.place.position - origin.truncate();
        match self.splatting.disc {
            Some(size) => self.disc_fragment(splat, to_surfel, direction, size),
            None => {
                let region = *self.mirror.region.values().get(index)?;
                let centre = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                (region == splat.region && region != 0)
                    .then(|| self.square_fragment(splat, to_surfel, direction, centre))
            }
        }
    }

    /// Where the pixel's ray meets the surfel's disc, of `size` times its radius.
    fn disc_fragment(
        &self,
        splat: &Splat,
        to_surfel: Vec3,
        direction: Vec3,
        size: f32,
    ) -> Option<Fragment> {
        let normal = splat.finish.normal();
        let cosine = normal.dot(direction);
        let distance = normal.dot(to_surfel) / cosine;
        let half = size * splat.radius;
        let off = (direction * distance - to_surfel).length_squared() / (half * half);
        // What is not a number fails.
        let met = off <= 1.0 && distance > 0.0 && cosine * cosine >= EDGE_ON_COSINE_SQUARED;
        // A ray leaves the mirror's own layer of points from their backs.
        let layer = self.splatting.own_layer * splat.radius;
        let own = splat.finish.mirror() > 0.0 && cosine > 0.0 && distance * cosine <= layer;
        if !met || own {
            return None;
        }
        let slope = (1.0 / (cosine * cosine) - 1.0).max(0.0).sqrt();
        let tolerance = self.splatting.depth_offset + slope.min(MAX_TOLERANCE_SLOPE);
        Some(Fragment {
            distance,
            weight: weight(off),
            behind: cosine > 0.0,
            tolerance: splat.radius * tolerance,
        })
    }

    /// A part of the hit's square: it counts the less the farther off the surfel the pixel's ray passes.
    fn square_fragment(
        &self,
        splat: &Splat,
        to_surfel: Vec3,
        direction: Vec3,
        centre: Vec2,
    ) -> Fragment {
        let normal = splat.finish.normal();
        let met = normal.dot(to_surfel) / normal.dot(direction);
        let near = met > splat.distance / DEPTH_RANGE && met < splat.distance * DEPTH_RANGE;
        let distance = if near { met } else { splat.distance };
        let aside = (direction * distance - to_surfel).length() / splat.radius;
        let t = 0.5 * ((centre - splat.pixel) / splat.half).length_squared();
        Fragment {
            distance,
            weight: weight(t.min(1.0)) / (1.0 + aside * aside),
            behind: normal.dot(to_surfel) > 0.0,
            tolerance: self.splatting.depth_offset * splat.radius,
        }
    }

    /// Calls `each(value, splat, its part)` for every pixel of a tile that a splat covers; `value` counts the tile's pixels.
    #[inline(always)]
    fn visit(
        &self,
        tile: PixelRect,
        splats: &[Splat],
        mut each: impl FnMut(usize, &Splat, &Fragment),
    ) {
        let width = (tile.x1 - tile.x0) as usize;
        for splat in splats {
            let b = splat.bounds;
            for y in b.y0.max(tile.y0)..b.y1.min(tile.y1) {
                for x in b.x0.max(tile.x0)..b.x1.min(tile.x1) {
                    if let Some(fragment) = self.fragment(splat, x, y) {
                        each(
                            (y - tile.y0) as usize * width + (x - tile.x0) as usize,
                            splat,
                            &fragment,
                        );
                    }
                }
            }
        }
    }

    /// The three passes over the pixels of a tile. `put` takes what each pixel shows, and the number of its points.
    fn passes(&self, tile: PixelRect, splats: &[Splat], mut put: impl FnMut(u32, u32, Pixel, u32)) {
        let width = (tile.x1 - tile.x0) as usize;
        let pixels = width * (tile.y1 - tile.y0) as usize;
        let mut keys = vec![EMPTY; pixels];
        let mut counts = vec![0u32; pixels];
        let mut shown = vec![0u32; pixels];
        let mut sums = vec![Sums::default(); pixels];
        let key = |splat: &Splat, f: &Fragment| {
            depth_key(f.distance, Class::of(splat.finish, f.behind), false)
        };

        // Depth.
        self.visit(tile, splats, |value, splat, f| {
            keys[value] = keys[value].min(key(splat, f));
            counts[value] += 1;
        });

        // Visibility.
        self.visit(tile, splats, |value, splat, f| {
            let Some(front) = depth_from_key(keys[value]) else {
                return;
            };
            let own = key(splat, f);
            let visible = match self.splatting.visibility {
                Visibility::Accumulate => {
                    same_class(own, keys[value]) && f.distance - front <= f.tolerance
                }
                Visibility::Nearest => own == keys[value],
            };
            if !visible {
                return;
            }
            let s = f32x4::splat(f.weight * scale(counts[value]));
            let (depth, albedo, normal) = attributes(splat.finish, f.behind);
            let aside = [
                f32x4::from([0.0, ((f.distance - front) / front).min(1.0), 0.0, 0.0]),
                f32x4::ZERO,
                f32x4::from([0.0, 0.0, 0.0, (splat.radius / front).min(1.0)]),
            ];
            let add = |sum: &mut [i32; 4], lanes: f32x4| {
                *sum = (i32x4::from(*sum) + (lanes * s).fast_trunc_int()).into();
            };
            add(&mut sums[value].depth, depth + aside[0]);
            add(&mut sums[value].albedo, albedo + aside[1]);
            add(&mut sums[value].normal, normal + aside[2]);
            shown[value] += 1;
        });

        // Averaging.
        for value in 0..pixels {
            let pixel = average(keys[value], &sums[value]);
            if pixel.material.w > 0.0 {
                let (x, y) = ((value % width) as u32, (value / width) as u32);
                put(tile.x0 + x, tile.y0 + y, pixel, shown[value]);
            }
        }
    }
}

impl Accumulator {
    /// Splats `hits` onto `mirror`, whose rays and regions say where.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub fn accumulate(
        &mut self,
        hits: &[Hit],
        surfels: &Surfels,
        mirror: &mut MirrorGBuffer<Cpu>,
        splatting: &Splatting,
        job: &Job,
    ) -> Result<()> {
        let size = mirror.size();
        let context = Context {
            surfels,
            mirror,
            splatting,
        };
        self.tiles
            .sort(size, hits.len(), |i| context.bounds(&hits[i]));
        job.check()?;
        let (tiles, side) = (&self.tiles, self.tiles.side);
        let seen: Vec<Vec<(usize, Pixel, u32)>> = (0..(tiles.count.x * tiles.count.y) as usize)
            .into_par_iter()
            .map(|tile| {
                if job.is_cancelled() {
                    return Vec::new();
                }
                let splats: Vec<Splat> = tiles
                    .entries(tile)
                    .filter_map(|i| context.splat(&hits[i as usize]))
                    .collect();
                let (x0, y0) = (
                    tile as u32 % tiles.count.x * side,
                    tile as u32 / tiles.count.x * side,
                );
                let rect = PixelRect {
                    x0,
                    y0,
                    x1: (x0 + side).min(size.x),
                    y1: (y0 + side).min(size.y),
                };
                let mut pixels = Vec::new();
                context.passes(rect, &splats, |x, y, pixel, count| {
                    pixels.push((y as usize * size.x as usize + x as usize, pixel, count));
                });
                pixels
            })
            .collect();
        job.check()?;
        for (index, pixel, count) in seen.into_iter().flatten() {
            mirror.show(index, pixel);
            mirror.count.values_mut()[index] = count;
        }
        Ok(())
    }
}
