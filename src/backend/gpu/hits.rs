//! The list of hits on the device, which every search appends to: bands of one binding each.
//!
//! The order of hits is that in which threads come; whatever is made of them are sums of integers.

use std::sync::Arc;

use glam::Vec2;

use super::Gpu;
use super::buffers::{Binding, Buffer, Pool, STORAGE};
use super::layout::gpu_layout;
use crate::error::Result;
use crate::reflect::Hit;
use crate::reflect::sscr::accumulate::LARGEST_REACH;

gpu_layout!(Hit {
    pixel,
    reach,
    point,
    distance
});

/// Hits whose splats are averaged.
const SAMPLE: usize = 1 << 12;

/// Pixels that a splat covers, about; what is not a number is as large as can be.
fn area(reach: Vec2) -> f32 {
    let side = reach.min(Vec2::splat(LARGEST_REACH)) * 2.0 + 1.0;
    side.x * side.y
}

const HIT: u64 = size_of::<Hit>() as u64;

/// Hits of one binding.
#[derive(Debug)]
pub(super) struct HitBand {
    buffer: Buffer,
    /// Hits that it can hold.
    capacity: u32,
    /// Hits in it.
    pub(super) count: u32,
}

/// Hits of a search, on the device.
#[derive(Debug)]
pub struct GpuHits {
    pub(super) bands: Vec<HitBand>,
    /// Half the side of the largest splat, at most; pixels.
    pub(super) reach: f32,
    /// Pixels of a splat, on average over any few thousand hits, at most.
    pub(super) area: f32,
}

impl HitBand {
    /// As many hits as it can hold: what searches append to.
    pub(super) fn whole(&self) -> Binding {
        self.buffer.first(u64::from(self.capacity) * HIT)
    }

    /// The hits in it.
    pub(super) fn filled(&self) -> Binding {
        self.buffer.first(u64::from(self.count) * HIT)
    }

    /// Hits that it still takes.
    pub(super) fn room(&self) -> u32 {
        self.capacity - self.count
    }
}

impl GpuHits {
    /// No hits yet, of splats up to `reach`.
    pub(super) fn new(reach: f32) -> Self {
        Self {
            bands: Vec::new(),
            reach,
            area: area(Vec2::splat(reach)),
        }
    }

    /// Hits of one band at most.
    pub(super) fn band_limit(limits: &wgpu::Limits) -> u32 {
        let bytes = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size)
            .min(1 << 30);
        (bytes / HIT) as u32
    }

    /// A band that takes `least` more hits: the last one, or a new one for as many as `wanted`, where one binding holds
    /// them.
    pub(super) fn band(
        &mut self,
        pool: &Arc<Pool>,
        limits: &wgpu::Limits,
        least: u32,
        wanted: u64,
    ) -> Result<&mut HitBand> {
        if self.bands.last().is_none_or(|band| band.room() < least) {
            let most = u64::from(Self::band_limit(limits));
            let capacity = wanted.max(u64::from(least)).min(most) as u32;
            let buffer = pool.take("the hits of the search", u64::from(capacity) * HIT, STORAGE)?;
            self.bands.push(HitBand {
                buffer,
                capacity,
                count: 0,
            });
        }
        let last = self.bands.len() - 1;
        Ok(&mut self.bands[last])
    }
}

impl Gpu {
    /// The hits, in no order, for comparing backends.
    ///
    /// # Errors
    /// As every stage.
    pub fn read_hits(&mut self, hits: &GpuHits) -> Result<Vec<Hit>> {
        let mut all = Vec::new();
        for band in &hits.bands {
            all.extend(band.buffer.download::<Hit>(band.count.into())?);
        }
        Ok(all)
    }

    /// Hits from main memory, for comparing backends.
    ///
    /// # Errors
    /// As every stage.
    pub fn write_hits(&mut self, hits: &[Hit]) -> Result<GpuHits> {
        let reach = hits.iter().map(|hit| hit.reach.max_element());
        let areas = hits
            .chunks(SAMPLE)
            .map(|part| part.iter().map(|hit| area(hit.reach)).sum::<f32>() / part.len() as f32);
        let mut list = GpuHits {
            area: areas.fold(1.0, f32::max),
            ..GpuHits::new(reach.fold(0.0, f32::max))
        };
        let limits = self.device.limits.clone();
        for part in hits.chunks(GpuHits::band_limit(&limits) as usize) {
            let count = part.len() as u32;
            let band = list.band(&self.pool, &limits, count, count.into())?;
            band.buffer.upload(0, bytemuck::cast_slice(part))?;
            band.count = count;
        }
        Ok(list)
    }
}
