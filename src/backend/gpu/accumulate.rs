//! Passes `hit_depth`, `hit_visibility` and `hit_average` on the device. Twin: `src/reflect/sscr/accumulate.rs`.

use glam::UVec2;

use super::Gpu;
use super::buffers::{Binding, GpuPoints, STORAGE};
use super::hits::GpuHits;
use super::kernel::{Kernel, POINT_GROUP, Pass, Threads};
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::{HIT_AVERAGE, HIT_DEPTH, HIT_VISIBILITY, Shader};
use super::splat::CHUNK;
use super::windows::{Need, STEPS, Window, windows};
use crate::error::Result;
use crate::gbuffer::visibility::Sums;
use crate::job::Job;
use crate::reflect::MirrorGBuffer;
use crate::reflect::sscr::accumulate::LARGEST_REACH;
use crate::reflect::sscr::{Splatting, Visibility};

gpu_struct! {
    /// What one dispatch over hits works on.
    pub(super) struct HitParams {
        /// Of the picture, pixels.
        size: UVec2,
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// First hit of the band.
        first_hit: u32,
        /// One past the last hit of the band.
        end_hit: u32,
        /// Number of the point band's first point in the cloud.
        band_start: u32,
        /// Points of the band.
        band_points: u32,
        /// 1 where only the nearest is visible, 0 where also what lies a little behind.
        nearest: u32,
        /// How little, over the local spacing.
        depth_offset: f32,
        /// Half width of a splat's disc over its radius; 0 where splats are squares of the hit's reach.
        disc: f32,
        /// Points of mirrors nearer before a mirror are its own; over the local spacing.
        own_layer: f32,
        /// How much larger surfels are drawn.
        enlarged: f32,
        /// The struct's size is a multiple of 8.
        pad0: u32,
        /// As `pad0`.
        pad1: u32,
    }
}

/// A pixel's nearest, its fragments, and those of them that are visible: a word each.
const FRONT: u64 = 12;

/// Light steps (of [`STEPS`]) that one fragment is worth.
const FRAGMENT_COST: u64 = 4;

/// What the first two passes leave of a window.
struct Sinks<'a> {
    window: &'a Window,
    fronts: Binding,
    sums: Binding,
}

/// What hits are splatted from and onto.
struct Splats<'a> {
    hits: &'a GpuHits,
    points: &'a GpuPoints,
    mirror: &'a MirrorGBuffer<Gpu>,
    /// For any hit of any window.
    params: HitParams,
    /// Hits of one submission.
    chunk: u32,
}

impl Splats<'_> {
    /// Lists a kernel over all hits, in every band of the points, with the sinks that it writes.
    fn list(
        &self,
        pass: &mut Pass<'_>,
        kernel: &std::sync::Arc<Kernel>,
        sinks: &Sinks<'_>,
        written: &[&Binding],
    ) -> Result<()> {
        let Window { rows, pixels } = sinks.window;
        for band in &self.hits.bands {
            let mut band_start = 0;
            for held in &self.points.bands {
                for first_hit in (0..band.count).step_by(self.chunk as usize) {
                    let end_hit = (first_hit + self.chunk).min(band.count);
                    let params = HitParams {
                        rows: UVec2::new(rows.start, rows.end),
                        first_pixel: pixels.start,
                        first_hit,
                        end_hit,
                        band_start,
                        band_points: held.count,
                        ..self.params
                    };
                    let mut compute = pass
                        .compute(kernel, &params)
                        .read(band.filled())
                        .read(held.places())
                        .read(held.finishes())
                        .read(self.mirror.region.part(pixels))
                        .read(self.mirror.origin.part(pixels))
                        .read(self.mirror.direction.part(pixels));
                    for binding in written {
                        compute = compute.write((*binding).clone());
                    }
                    compute.dispatch(Threads::Points(end_hit - first_hit))?;
                }
                band_start += held.count;
            }
        }
        Ok(())
    }
}

/// Pixels of the largest splat.
const LARGEST_AREA: f32 = (2.0 * LARGEST_REACH + 1.0) * (2.0 * LARGEST_REACH + 1.0);

impl Gpu {
    /// Passes `hit_depth`, `hit_visibility` and `hit_average`.
    pub(super) fn run_accumulate(
        &mut self,
        hits: &GpuHits,
        points: &GpuPoints,
        mirror: &mut MirrorGBuffer<Self>,
        splatting: &Splatting,
        job: &Job,
    ) -> Result<()> {
        let size = mirror.origin.size();
        // A square's region is that of the hit's own pixel, which lies up to a reach beyond the rows; discs have none.
        let halo = match splatting.disc {
            Some(_) => 0,
            None => hits.reach.max(0.0) as u32 + 2,
        };
        let need = Need {
            halo,
            bytes: size_of::<Sums>() as u64,
            steps: 1,
        };
        let fragments = (hits.area * splatting.enlarged.max(1.0).powi(2)).min(LARGEST_AREA);
        let in_time = STEPS / (fragments as u64 * FRAGMENT_COST).max(1);
        let splats = Splats {
            hits,
            points,
            mirror,
            params: HitParams {
                size,
                rows: UVec2::ZERO,
                first_pixel: 0,
                first_hit: 0,
                end_hit: 0,
                band_start: 0,
                band_points: 0,
                nearest: u32::from(splatting.visibility == Visibility::Nearest),
                depth_offset: splatting.depth_offset,
                disc: splatting.disc.unwrap_or(0.0),
                own_layer: splatting.own_layer,
                enlarged: splatting.enlarged,
                pad0: 0,
                pad1: 0,
            },
            chunk: (in_time.min(CHUNK.into()) as u32).max(POINT_GROUP),
        };
        for window in windows(size, need, &self.device.limits) {
            let pixels = u64::from(window.pixels.end - window.pixels.start);
            let take = |bytes: u64| self.pool.take("what mirrors show", pixels * bytes, STORAGE);
            let (fronts, sums) = (take(FRONT)?, take(need.bytes)?);
            let sinks = Sinks {
                window: &window,
                fronts: fronts.first(pixels * FRONT),
                sums: sums.first(pixels * need.bytes),
            };
            self.splat_hits(&HIT_DEPTH, &splats, &sinks, &[&sinks.fronts], job)?;
            let both = [&sinks.fronts, &sinks.sums];
            self.splat_hits(&HIT_VISIBILITY, &splats, &sinks, &both, job)?;
            self.average_hits(&splats, &sinks, job)?;
        }
        Ok(())
    }

    /// One pass over all hits; the last of what it writes is cleared first.
    fn splat_hits(
        &mut self,
        shader: &Shader,
        splats: &Splats<'_>,
        sinks: &Sinks<'_>,
        written: &[&Binding],
        job: &Job,
    ) -> Result<()> {
        let kernel = self.kernels.get(&self.device, shader)?;
        let mut pass = Pass::new(shader.name, &self.device, &self.pool, self.stamps.as_ref());
        if let Some(last) = written.last() {
            pass.zero((*last).clone());
        }
        splats.list(&mut pass, &kernel, sinks, written)?;
        pass.finish(&mut self.timings, job)
    }

    fn average_hits(&mut self, splats: &Splats<'_>, sinks: &Sinks<'_>, job: &Job) -> Result<()> {
        if splats.hits.bands.iter().all(|band| band.count == 0) {
            return Ok(());
        }
        let (window, mirror) = (sinks.window, splats.mirror);
        let kernel = self.kernels.get(&self.device, &HIT_AVERAGE)?;
        let mut pass = Pass::new(
            HIT_AVERAGE.name,
            &self.device,
            &self.pool,
            self.stamps.as_ref(),
        );
        let params = HitParams {
            rows: UVec2::new(window.rows.start, window.rows.end),
            first_pixel: window.pixels.start,
            ..splats.params
        };
        pass.compute(&kernel, &params)
            .read(sinks.fronts.clone())
            .read(sinks.sums.clone())
            .write(mirror.surface.part(&window.pixels))
            .write(mirror.albedo.part(&window.pixels))
            .write(mirror.material.part(&window.pixels))
            .write(mirror.count.part(&window.pixels))
            .dispatch(window.threads(splats.params.size))?;
        pass.finish(&mut self.timings, job)
    }
}
