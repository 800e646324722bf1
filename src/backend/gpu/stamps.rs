//! Time on the device: a stamp at the start of a pass and one at its end.

use super::buffers::read_mapped;
use super::device::Device;
use crate::error::Result;

/// Two stamps of 64 bits.
const BYTES: u64 = 16;

/// Where the stamps of the running pass go.
#[derive(Debug)]
pub(super) struct Stamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
    /// Milliseconds per tick.
    tick: f64,
}

impl Stamps {
    /// `None` where the device takes no stamps.
    pub(super) fn new(device: &Device) -> Option<Self> {
        if !device
            .raw
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY)
        {
            return None;
        }
        let buffer = |usage| {
            device.raw.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: BYTES,
                usage,
                mapped_at_creation: false,
            })
        };
        Some(Self {
            queries: device.raw.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            readable: buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
            tick: f64::from(device.queue.get_timestamp_period()) * 1e-6,
        })
    }

    /// What a dispatch stamps, being the `first` or `last` of its pass.
    pub(super) fn writes(
        &self,
        first: bool,
        last: bool,
    ) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        (first || last).then_some(wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: first.then_some(0),
            end_of_pass_write_index: last.then_some(1),
        })
    }

    /// Makes the stamps readable, after the last dispatch.
    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readable, 0, BYTES);
    }

    /// Milliseconds from the first stamp to the last.
    pub(super) fn elapsed_ms(&self, device: &Device) -> Result<f64> {
        let mut ticks = 0;
        read_mapped(device, &self.readable, BYTES, |bytes| {
            let stamps: Vec<u64> = bytemuck::pod_collect_to_vec(bytes);
            if let [start, end] = stamps[..] {
                ticks = u64::saturating_sub(end, start);
            }
        })?;
        Ok(ticks as f64 * self.tick)
    }
}
