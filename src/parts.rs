//! Pictures that are made in parts, since the whole would fit neither into memory nor into a device's buffers.
//!
//! A part is the same camera cut to a window (its principal point is elsewhere), with a margin that is thrown away: what looks at
//! neighbouring pixels (closing holes, eye-dome lighting, merging of indirect light) finds them there. Parts begin at
//! multiples of the margin, so that patterns that repeat over pixels go on from one to the next.

use std::collections::BTreeMap;

use glam::{UVec2, Vec4};

use crate::camera::Pinhole;
use crate::gbuffer::GBuffer;
use crate::gbuffer::coverage::coverage;
use crate::grid::Grid;
use crate::measure::BounceReport;
use crate::reflect::MirrorGBuffer;
use crate::renderer::Products;

/// Pixels around a part that are made and thrown away.
const MARGIN: u32 = 64;

/// A window of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Part {
    /// The pixels that it gives.
    from: UVec2,
    to: UVec2,
    /// The pixels that are made: as many and a margin, where the picture has one.
    outer_from: UVec2,
    outer_to: UVec2,
}

impl Part {
    /// Width and height of what is made.
    pub(crate) fn size(&self) -> UVec2 {
        self.outer_to - self.outer_from
    }

    /// The camera of this part.
    pub(crate) fn pinhole(&self, whole: &Pinhole) -> Pinhole {
        Pinhole {
            centre: whole.centre - self.outer_from.as_vec2(),
            size: self.size(),
            ..*whole
        }
    }

    /// Puts what this part gives into the whole.
    fn put<T: Copy>(&self, whole: &mut Grid<T>, part: &Grid<T>) {
        let (width, of_part) = (whole.width(), part.width());
        let columns = (self.to.x - self.from.x) as usize;
        let shift = self.from - self.outer_from;
        for row in 0..self.to.y - self.from.y {
            let at = (self.from.y + row) as usize * width + self.from.x as usize;
            let from = (shift.y + row) as usize * of_part + shift.x as usize;
            let source = part.values().get(from..from + columns);
            let target = whole.values_mut().get_mut(at..at + columns);
            if let (Some(source), Some(target)) = (source, target) {
                target.copy_from_slice(source);
            }
        }
    }
}

/// Cuts a picture into parts whose sides are at most `largest` pixels, and not much smaller than each other; one part where
/// that is enough.
pub(crate) fn parts(size: UVec2, largest: u32) -> Vec<Part> {
    let cuts = |side: u32| -> Vec<u32> {
        let largest = (largest / MARGIN).max(1) * MARGIN;
        let count = side.div_ceil(largest).max(1);
        let step = side.div_ceil(count).next_multiple_of(MARGIN);
        let cuts = (0..count).map(|k| (k * step).min(side));
        cuts.chain([side]).collect()
    };
    let (columns, rows) = (cuts(size.x), cuts(size.y));
    let mut parts = Vec::new();
    for row in rows.windows(2) {
        for column in columns.windows(2) {
            let (from, to) = (UVec2::new(column[0], row[0]), UVec2::new(column[1], row[1]));
            if from.cmplt(to).all() {
                parts.push(Part {
                    from,
                    to,
                    outer_from: UVec2::new(
                        from.x.saturating_sub(MARGIN),
                        from.y.saturating_sub(MARGIN),
                    ),
                    outer_to: (to + MARGIN).min(size),
                });
            }
        }
    }
    parts
}

/// A picture, as far as its parts are there.
pub(crate) struct Whole {
    products: Products,
    /// Regions of the parts so far.
    regions: u32,
    /// Pixels of mirrors that a bounce of the parts so far had.
    mirror_pixels: Vec<u64>,
}

impl Whole {
    /// An empty picture.
    pub(crate) fn new(pinhole: Pinhole) -> Self {
        Self {
            products: Products {
                radiance: Grid::new(pinhole.size, Vec4::ZERO),
                gbuffer: GBuffer::empty(pinhole),
                coverage: crate::gbuffer::Coverage::default(),
                mirror: None,
                bounces: Vec::new(),
                search_heat: None,
                virtual_lights: None,
                passes: Vec::new(),
                wall_ms: 0.0,
            },
            regions: 0,
            mirror_pixels: Vec::new(),
        }
    }

    /// Takes what a part gives.
    pub(crate) fn add(&mut self, part: &Part, mut made: Products) {
        let whole = &mut self.products;
        part.put(&mut whole.radiance, &made.radiance);
        part.put(&mut whole.gbuffer.surface, &made.gbuffer.surface);
        part.put(&mut whole.gbuffer.albedo, &made.gbuffer.albedo);
        part.put(&mut whole.gbuffer.material, &made.gbuffer.material);
        let size = whole.radiance.size();
        if let Some(mirror) = &mut made.mirror {
            // The regions of a part are its own: they go on counting where those of the last one ended.
            let mut last = self.regions;
            for region in mirror.region.values_mut().iter_mut().filter(|r| **r > 0) {
                *region += self.regions;
                last = last.max(*region);
            }
            self.regions = last;
            let all = (whole.mirror).get_or_insert_with(|| MirrorGBuffer::empty(size));
            part.put(&mut all.origin, &mirror.origin);
            part.put(&mut all.direction, &mirror.direction);
            part.put(&mut all.surface, &mirror.surface);
            part.put(&mut all.albedo, &mirror.albedo);
            part.put(&mut all.material, &mirror.material);
            part.put(&mut all.region, &mirror.region);
            part.put(&mut all.count, &mirror.count);
            part.put(&mut all.level, &mirror.level);
        }
        if let Some(heat) = &made.search_heat {
            let all =
                (whole.search_heat).get_or_insert_with(|| Grid::new(size, Default::default()));
            part.put(all, heat);
        }
        // They are the same for every part.
        whole.virtual_lights = whole.virtual_lights.take().or(made.virtual_lights);
        for pass in made.passes {
            match whole.passes.iter_mut().find(|p| p.name == pass.name) {
                Some(sum) => {
                    sum.wall_ms += pass.wall_ms;
                    sum.gpu_ms = sum.gpu_ms.zip(pass.gpu_ms).map(|(a, b)| a + b);
                    sum.cpu_ms = sum.cpu_ms.zip(pass.cpu_ms).map(|(a, b)| a + b);
                }
                None => whole.passes.push(pass),
            }
        }
        whole.wall_ms += made.wall_ms;
        for (index, bounce) in made.bounces.into_iter().enumerate() {
            let pixels = made.coverage.mirror;
            match (
                whole.bounces.get_mut(index),
                self.mirror_pixels.get_mut(index),
            ) {
                (Some(sum), Some(so_far)) => {
                    *sum = together(sum, *so_far, &bounce, pixels);
                    *so_far += pixels;
                }
                _ => {
                    whole.bounces.push(bounce);
                    self.mirror_pixels.push(pixels);
                }
            }
        }
    }

    /// The picture.
    pub(crate) fn finish(mut self) -> Products {
        self.products.coverage = coverage(&self.products.gbuffer);
        if let Some(mirror) = &mut self.products.mirror {
            largest_first(mirror.region.values_mut());
        }
        self.products
    }
}

/// Numbers regions anew from 1, the largest first.
fn largest_first(regions: &mut [u32]) {
    let mut sizes: BTreeMap<u32, u64> = BTreeMap::new();
    for region in regions.iter().filter(|region| **region > 0) {
        *sizes.entry(*region).or_default() += 1;
    }
    let mut order: Vec<(u32, u64)> = sizes.into_iter().collect();
    order.sort_by_key(|(region, size)| (std::cmp::Reverse(*size), *region));
    let number = (1..)
        .zip(order)
        .map(|(number, (region, _))| (region, number));
    let number: BTreeMap<u32, u32> = number.collect();
    for region in regions {
        *region = number.get(region).copied().unwrap_or(0);
    }
}

/// What two searches came to together; shares weigh by the mirrors' pixels of each.
fn together(a: &BounceReport, of_a: u64, b: &BounceReport, of_b: u64) -> BounceReport {
    let weighed = |a: f64, b: f64, of_a: u64, of_b: u64| {
        let all = (of_a + of_b).max(1) as f64;
        (a * of_a as f64 + b * of_b as f64) / all
    };
    let share = |a: f64, b: f64| weighed(a, b, of_a, of_b);
    let (offered, hit) = (
        a.points_offered + b.points_offered,
        a.points_hit + b.points_hit,
    );
    BounceReport {
        bounce: a.bounce,
        method: a.method,
        reason: a.reason.clone(),
        regions: a.regions + b.regions,
        points_offered: offered,
        points_hit: hit,
        hit_rate: hit as f64 / offered.max(1) as f64,
        hits: a.hits + b.hits,
        mean_steps: weighed(
            a.mean_steps,
            b.mean_steps,
            a.points_offered,
            b.points_offered,
        ),
        coverage: share(a.coverage, b.coverage),
        coverage_closed: share(a.coverage_closed, b.coverage_closed),
        mirrors_seen: share(a.mirrors_seen, b.mirrors_seen),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_a_picture_once_and_begin_where_patterns_do() {
        for (size, largest) in [
            (UVec2::new(640, 480), 256),
            (UVec2::new(1000, 70), 300),
            (UVec2::new(4097, 1), 4096),
            (UVec2::new(129, 129), 64),
            (UVec2::new(1, 1), 1),
        ] {
            let mut times = Grid::new(size, 0_u32);
            for part in parts(size, largest) {
                assert!(
                    (part.to - part.from).max_element() <= largest.max(MARGIN),
                    "{part:?}"
                );
                assert_eq!(part.outer_from % MARGIN, UVec2::ZERO, "{part:?}");
                let pixel = |p: u32| (part.from.x + p) as usize;
                for y in part.from.y..part.to.y {
                    for x in 0..part.to.x - part.from.x {
                        times.values_mut()[y as usize * size.x as usize + pixel(x)] += 1;
                    }
                }
            }
            assert!(
                times.values().iter().all(|n| *n == 1),
                "{size} by {largest}"
            );
        }
        let whole = parts(UVec2::new(800, 600), 4096);
        assert_eq!(whole.len(), 1);
        assert_eq!(
            whole[0].size(),
            UVec2::new(800, 600),
            "no margin where there is no neighbour"
        );
    }

    #[test]
    fn regions_are_numbered_by_their_size() {
        let mut regions = [0, 7, 7, 3, 9, 9, 9, 3];
        largest_first(&mut regions);
        assert_eq!(regions, [0, 3, 3, 2, 1, 1, 1, 2]);
    }

    #[test]
    fn what_parts_give_lies_where_it_belongs() {
        let size = UVec2::new(300, 200);
        let mut whole = Grid::new(size, UVec2::MAX);
        for part in parts(size, 128) {
            let inner = part.size();
            let values = (0..inner.y).flat_map(|y| (0..inner.x).map(move |x| UVec2::new(x, y)));
            let made = values.map(|p| p + part.outer_from).collect();
            part.put(&mut whole, &Grid::from_vec(inner, made).expect("a grid"));
        }
        for (i, value) in whole.values().iter().enumerate() {
            let i = i as u32;
            assert_eq!(*value, UVec2::new(i % size.x, i / size.x));
        }
    }
}
