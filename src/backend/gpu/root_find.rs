//! Pass `root_find` on the device. Twin: `src/reflect/sscr/root_find.rs`.

use bytemuck::Zeroable;
use glam::UVec2;

use super::Gpu;
use super::buffers::{Binding, Buffer, GpuPoints, STORAGE};
use super::hits::GpuHits;
use super::kernel::{POINT_GROUP, Pass, Threads};
use super::layout::{gpu_layout, gpu_struct};
use super::mirror_pixels::MirrorPixels;
use super::shaders::ROOT_FIND;
use super::splat::CHUNK;
use super::windows::STEPS;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::reflect::LabelledMirrors;
use crate::reflect::sscr::distribute::PASSES;
use crate::reflect::sscr::root_find::SearchCounts;
use crate::reflect::sscr::{self, Distribution, SscrSettings};

gpu_struct! {
    /// A region, as searches read it.
    pub(super) struct Region {
        /// First pixel of the smallest rectangle around it.
        first: UVec2,
        /// Of that rectangle, pixels.
        size: UVec2,
        /// Of this and all larger regions.
        accumulated_weight: f32,
        pad: u32,
    }
}

gpu_struct! {
    /// How points are shared out among the regions.
    pub(super) struct DistributeParams {
        /// Number of regions.
        region_count: u32,
        /// 1 where by weight, 0 where by turns.
        weighted: u32,
        /// Pass of `sscr.passes`, counted from 0.
        turn: u32,
        /// Of the Halton sequence.
        base: u32,
        /// Digits of the Halton sequence that count.
        digits: u32,
        /// 1 / base ^ digits.
        scale: f32,
        /// The struct's size is a multiple of 16.
        pad0: u32,
        /// As `pad0`.
        pad1: u32,
    }
}

gpu_struct! {
    /// What one dispatch of a search works on.
    pub(super) struct RootFindParams {
        /// How the points are shared out.
        distribute: DistributeParams,
        /// First pixel of the rectangle that the mirrors are laid out in.
        first: UVec2,
        /// Of that rectangle, pixels.
        size: UVec2,
        /// First point of the band.
        first_point: u32,
        /// One past the last point of the band.
        end_point: u32,
        /// Number of the band's first point in the cloud.
        band_start: u32,
        /// More random pixels that are tried for a seed.
        seed_attempts: u32,
        /// How often a step that leaves the region is halved.
        step_attempts: u32,
        /// Steps at most.
        max_steps: u32,
        /// First step over the region's box.
        initial_step: f32,
        /// Distance of the last two steps, pixels.
        threshold: f32,
        /// Over the local spacing.
        self_hit: f32,
        /// Size of a splat at distance 0, pixels.
        max_splat: f32,
        /// Distance from which on splats are one pixel.
        far: f32,
        /// Number of the dispatch: its counts have a place of their own.
        chunk: u32,
    }
}

/// The regions of a picture, on the device.
pub(super) struct RegionTable {
    buffer: Buffer,
    bytes: u64,
}

impl RegionTable {
    pub(super) fn binding(&self) -> Binding {
        self.buffer.first(self.bytes)
    }
}

/// Light steps (of [`STEPS`]) that one step of a search is worth.
const STEP_COST: u32 = 16;

/// Points of a band that one dispatch searches, in one pass of `sscr.passes`.
#[derive(Debug, Clone, Copy)]
pub(super) struct SearchChunk {
    pub(super) band: usize,
    pub(super) params: RootFindParams,
}

impl SearchChunk {
    pub(super) fn points(&self) -> u32 {
        self.params.end_point - self.params.first_point
    }
}

/// All that one search does, chunk by chunk of at most so many points.
pub(super) fn chunks(
    points: &GpuPoints,
    pixels: &MirrorPixels,
    regions: usize,
    settings: &SscrSettings,
    diagonal: f32,
    most: u32,
) -> Vec<SearchChunk> {
    let tries = settings.max_steps + 2 * (settings.seed_attempts + 1);
    let in_time = (STEPS / u64::from(tries * STEP_COST)).min(CHUNK.into()) as u32;
    let chunk = in_time.min(most).max(POINT_GROUP) / POINT_GROUP * POINT_GROUP;
    let mut all = Vec::new();
    for pass in 0..settings.passes {
        let halton = &PASSES[pass as usize % PASSES.len()];
        let distribute = DistributeParams {
            region_count: regions as u32,
            weighted: u32::from(settings.distribution == Distribution::Weighted),
            turn: pass,
            base: halton.base,
            digits: halton.digits,
            scale: halton.scale,
            pad0: 0,
            pad1: 0,
        };
        let mut band_start = 0;
        for (band, held) in points.bands.iter().enumerate() {
            for first_point in (0..held.count).step_by(chunk as usize) {
                let params = RootFindParams {
                    distribute,
                    first: pixels.first,
                    size: pixels.size,
                    first_point,
                    end_point: (first_point + chunk).min(held.count),
                    band_start,
                    seed_attempts: settings.seed_attempts,
                    step_attempts: settings.step_attempts,
                    max_steps: settings.max_steps,
                    initial_step: settings.initial_step,
                    threshold: settings.threshold,
                    self_hit: settings.self_hit,
                    max_splat: settings.max_splat,
                    far: (settings.mirror_far * diagonal).max(f32::MIN_POSITIVE),
                    chunk: 0,
                };
                all.push(SearchChunk { band, params });
            }
            band_start += held.count;
        }
    }
    all
}

impl Gpu {
    /// The regions, as searches read them.
    pub(super) fn region_table(&mut self, regions: &[sscr::Region]) -> Result<RegionTable> {
        let rows: Vec<Region> = regions
            .iter()
            .map(|region| {
                let b = region.bounds;
                let first = UVec2::new(b.x0, b.y0);
                Region {
                    first,
                    size: UVec2::new(b.x1, b.y1).saturating_sub(first),
                    accumulated_weight: region.accumulated_weight,
                    ..Region::zeroed()
                }
            })
            .collect();
        let bytes: &[u8] = bytemuck::cast_slice(&rows);
        let needed = bytes.len() as u64;
        let budget = self.device.limits.max_storage_buffer_binding_size;
        if needed > budget {
            return Err(Error::Memory {
                what: format!("searching mirrors of {} regions", rows.len()),
                needed,
                budget,
            });
        }
        let buffer = self.pool.take("the mirrors' regions", needed, STORAGE)?;
        buffer.upload(0, bytes)?;
        Ok(RegionTable {
            buffer,
            bytes: needed,
        })
    }

    /// Pass `root_find`.
    pub(super) fn run_root_find(
        &mut self,
        points: &GpuPoints,
        mirrors: &LabelledMirrors<'_, Self>,
        settings: &SscrSettings,
        diagonal: f32,
        job: &Job,
    ) -> Result<(GpuHits, SearchCounts)> {
        let mut hits = GpuHits::new(0.5 * settings.max_splat);
        let mut counts = SearchCounts::default();
        if mirrors.regions.is_empty() {
            return Ok((hits, counts));
        }
        let pixels = self.mirror_pixels(mirrors, job)?;
        let regions = self.region_table(mirrors.regions)?;
        let kernel = self.kernels.get(&self.device, &ROOT_FIND)?;
        let limits = self.device.limits.clone();
        let most = GpuHits::band_limit(&limits);
        let all = chunks(
            points,
            &pixels,
            mirrors.regions.len(),
            settings,
            diagonal,
            most,
        );
        let mut left: u64 = all.iter().map(|chunk| u64::from(chunk.points())).sum();
        let mut rest = &all[..];
        while let Some(next) = rest.first() {
            // As many chunks as the band holds even if every point has a hit.
            let band = hits.band(&self.pool, &limits, next.points(), left)?;
            let mut room = band.room();
            let fits = |chunk: &&SearchChunk| {
                let fits = chunk.points() <= room;
                room = room.saturating_sub(chunk.points());
                fits
            };
            let batch = rest.iter().take_while(fits).count();
            let (now, later) = rest.split_at(batch);
            rest = later;
            left -= now
                .iter()
                .map(|chunk| u64::from(chunk.points()))
                .sum::<u64>();

            let bytes = 4 * (1 + now.len() as u64);
            let counters = self.pool.take("counting hits", bytes, STORAGE)?;
            let mut values = vec![0u32; 1 + now.len()];
            values[0] = band.count;
            counters.upload(0, bytemuck::cast_slice(&values))?;
            let mut pass = Pass::new(
                ROOT_FIND.name,
                &self.device,
                &self.pool,
                self.stamps.as_ref(),
            );
            for (chunk, SearchChunk { band: held, params }) in now.iter().enumerate() {
                let params = RootFindParams {
                    chunk: chunk as u32,
                    ..*params
                };
                let mut compute = pass
                    .compute(&kernel, &params)
                    .read(points.bands[*held].places())
                    .read(regions.binding());
                for binding in pixels.bindings() {
                    compute = compute.read(binding);
                }
                compute
                    .write(band.whole())
                    .write(counters.first(bytes))
                    .dispatch(Threads::Points(params.end_point - params.first_point))?;
            }
            pass.finish(&mut self.timings, job)?;
            let values = counters.download::<u32>(values.len() as u64)?;
            let (found, steps) = values.split_at(1);
            let found = found.first().copied().unwrap_or(band.count);
            counts.hit += u64::from(found - band.count);
            counts.steps += steps.iter().map(|&s| u64::from(s)).sum::<u64>();
            band.count = found;
        }
        counts.hits = counts.hit;
        counts.offered = all.iter().map(|chunk| u64::from(chunk.points())).sum();
        Ok((hits, counts))
    }
}
