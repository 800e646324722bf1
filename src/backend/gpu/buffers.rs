//! Buffers on the device, pooled between frames; grids and surfels made of them; the way there and back.

use std::borrow::Cow;
use std::marker::PhantomData;
use std::ops::Range;
use std::sync::{Arc, Mutex};

use bytemuck::Pod;
use glam::UVec2;

use super::device::{Device, lock};
use crate::cloud::{Finish, Place, Surfels};
use crate::error::{Error, Result};

/// Offsets of bindings are multiples of this, bytes: WebGPU's default limit.
pub(super) const BINDING_ALIGNMENT: u64 = 256;

/// Bytes are bound and copied by words.
const WORD: u64 = 4;

/// Bytes that go to or come from the device in one piece.
const TRANSFER: u64 = 32 << 20;

/// What kernels read and write.
pub(super) const STORAGE: wgpu::BufferUsages = wgpu::BufferUsages::STORAGE
    .union(wgpu::BufferUsages::COPY_DST)
    .union(wgpu::BufferUsages::COPY_SRC);

/// The parameters of kernels.
pub(super) const UNIFORM: wgpu::BufferUsages =
    wgpu::BufferUsages::UNIFORM.union(wgpu::BufferUsages::COPY_DST);

const READ_BACK: wgpu::BufferUsages =
    wgpu::BufferUsages::MAP_READ.union(wgpu::BufferUsages::COPY_DST);

/// Buffers that no one uses at the moment, kept for the next frame.
#[derive(Debug)]
pub(super) struct Pool {
    device: Arc<Device>,
    free: Mutex<Vec<wgpu::Buffer>>,
}

/// A buffer that goes back to its pool when it is dropped.
#[derive(Debug)]
pub(super) struct Buffer {
    buffer: Option<wgpu::Buffer>,
    pool: Arc<Pool>,
}

impl Pool {
    pub(super) fn new(device: Arc<Device>) -> Arc<Self> {
        Arc::new(Self {
            device,
            free: Mutex::default(),
        })
    }

    /// A buffer of at least `size` bytes for `what`; its content is left from its last use.
    pub(super) fn take(
        self: &Arc<Self>,
        what: &str,
        size: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<Buffer> {
        let size = size.max(4).next_multiple_of(BINDING_ALIGNMENT);
        if let Some(buffer) = self.reuse(size, usage) {
            return Ok(self.lend(buffer));
        }
        if size > self.device.limits.max_buffer_size {
            return Err(Error::Memory {
                what: what.to_owned(),
                needed: size,
                budget: self.device.limits.max_buffer_size,
            });
        }
        if self.device.reserve(what, size).is_err() {
            self.clear();
            self.device.reserve(what, size)?;
        }
        let scope = self
            .device
            .raw
            .push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let descriptor = wgpu::BufferDescriptor {
            label: Some(what),
            size,
            usage,
            mapped_at_creation: false,
        };
        let buffer = self.device.raw.create_buffer(&descriptor);
        if pollster::block_on(scope.pop()).is_some() {
            self.device.release(size);
            return Err(Error::Memory {
                what: what.to_owned(),
                needed: self.device.memory_used() + size,
                budget: self.device.memory_used(),
            });
        }
        self.device
            .check()
            .inspect_err(|_| self.device.release(size))?;
        Ok(self.lend(buffer))
    }

    /// A free buffer that fits without wasting more than half of it.
    fn reuse(&self, size: u64, usage: wgpu::BufferUsages) -> Option<wgpu::Buffer> {
        let mut free = lock(&self.free);
        let fits =
            |b: &wgpu::Buffer| b.usage() == usage && b.size() >= size && b.size() / 2 <= size;
        let best = (0..free.len())
            .filter(|&i| fits(&free[i]))
            .min_by_key(|&i| free[i].size())?;
        Some(free.swap_remove(best))
    }

    fn lend(self: &Arc<Self>, buffer: wgpu::Buffer) -> Buffer {
        Buffer {
            buffer: Some(buffer),
            pool: Arc::clone(self),
        }
    }

    /// Frees every buffer that no one uses.
    pub(super) fn clear(&self) {
        for buffer in lock(&self.free).drain(..) {
            self.device.release(buffer.size());
            buffer.destroy();
        }
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        if let Some(buffer) = self.buffer.take() {
            lock(&self.pool.free).push(buffer);
        }
    }
}

impl Buffer {
    /// The buffer itself.
    pub(super) fn raw(&self) -> &wgpu::Buffer {
        match &self.buffer {
            Some(buffer) => buffer,
            None => unreachable!("a buffer is only given up when it is dropped"),
        }
    }

    /// Writes `bytes` from `offset` on.
    pub(super) fn upload(&self, offset: u64, bytes: &[u8]) -> Result<()> {
        let device = &self.pool.device;
        let (words, rest) = bytes.split_at(bytes.len() / WORD as usize * WORD as usize);
        if !rest.is_empty() {
            let mut last = [0; WORD as usize];
            last[..rest.len()].copy_from_slice(rest);
            let end = offset + words.len() as u64;
            device.queue.write_buffer(self.raw(), end, &last);
        }
        for (i, piece) in words.chunks(TRANSFER as usize).enumerate() {
            device
                .queue
                .write_buffer(self.raw(), offset + i as u64 * TRANSFER, piece);
            // Without a submission every piece would wait in a staging buffer of its own.
            if piece.len() as u64 == TRANSFER {
                device.queue.submit([]);
                device.wait()?;
            }
        }
        device.check()
    }

    /// The first `size` bytes.
    pub(super) fn first(&self, size: u64) -> Binding {
        Binding {
            buffer: self.raw().clone(),
            offset: 0,
            size,
        }
    }

    /// Reads the first `count` values.
    pub(super) fn download<T: Pod>(&self, count: u64) -> Result<Vec<T>> {
        Ok(bytemuck::pod_collect_to_vec(
            &self.read_back(count * size_of::<T>() as u64)?,
        ))
    }

    fn read_back(&self, size: u64) -> Result<Vec<u8>> {
        let (pool, device) = (&self.pool, &self.pool.device);
        let (wanted, size) = (size as usize, size.next_multiple_of(WORD));
        let mut bytes = Vec::with_capacity(size as usize);
        let staging = pool.take("reading back", size.min(TRANSFER), READ_BACK)?;
        while (bytes.len() as u64) < size {
            let piece = (size - bytes.len() as u64).min(TRANSFER);
            let mut encoder = device
                .raw
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(self.raw(), bytes.len() as u64, staging.raw(), 0, piece);
            device.queue.submit([encoder.finish()]);
            read_mapped(device, staging.raw(), piece, |mapped| {
                bytes.extend_from_slice(mapped);
            })?;
        }
        bytes.truncate(wanted);
        Ok(bytes)
    }
}

/// Maps the first `size` bytes of a buffer, once everything submitted is done.
pub(super) fn read_mapped(
    device: &Device,
    buffer: &wgpu::Buffer,
    size: u64,
    read: impl FnOnce(&[u8]),
) -> Result<()> {
    let slice = buffer.slice(..size);
    let mapped = Arc::new(Mutex::new(None));
    let heard = Arc::clone(&mapped);
    slice.map_async(wgpu::MapMode::Read, move |result| {
        *lock(&heard) = Some(result);
    });
    device.wait()?;
    let failed = |why: String| Error::Gpu(format!("what it drew cannot be read ({why})"));
    match lock(&mapped).take() {
        Some(Ok(())) => {}
        Some(Err(error)) => return Err(failed(error.to_string())),
        None => return Err(failed("no answer".into())),
    }
    let view = slice
        .get_mapped_range()
        .map_err(|e| failed(e.to_string()))?;
    read(&view);
    drop(view);
    buffer.unmap();
    Ok(())
}

/// Part of a buffer, as a kernel binds it.
#[derive(Debug, Clone)]
pub(super) struct Binding {
    pub(super) buffer: wgpu::Buffer,
    pub(super) offset: u64,
    pub(super) size: u64,
}

/// A value per pixel, on the device.
#[derive(Debug)]
pub struct GpuGrid<T> {
    size: UVec2,
    buffer: Buffer,
    element: PhantomData<T>,
}

impl<T: Pod> GpuGrid<T> {
    /// A grid whose values are whatever is there.
    pub(super) fn new(pool: &Arc<Pool>, size: UVec2) -> Result<Self> {
        let pixels = u64::from(size.x) * u64::from(size.y);
        let what = format!("a picture of {} x {} pixels", size.x, size.y);
        let buffer = pool.take(&what, pixels * size_of::<T>() as u64, STORAGE)?;
        Ok(Self {
            size,
            buffer,
            element: PhantomData,
        })
    }

    /// Width and height, pixels.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// Every pixel.
    pub(super) fn whole(&self) -> Binding {
        self.part(&(0..self.size.x * self.size.y))
    }

    /// The pixels `pixels` (their numbers row by row; the first a multiple of 64).
    pub(super) fn part(&self, pixels: &Range<u32>) -> Binding {
        let element = size_of::<T>() as u64;
        Binding {
            buffer: self.buffer.raw().clone(),
            offset: u64::from(pixels.start) * element,
            size: (u64::from(pixels.end - pixels.start) * element).next_multiple_of(WORD),
        }
    }

    pub(super) fn upload(&self, values: &[T]) -> Result<()> {
        self.buffer.upload(0, bytemuck::cast_slice(values))
    }

    pub(super) fn download(&self) -> Result<Cow<'static, [T]>> {
        Ok(Cow::Owned(self.buffer.download(
            u64::from(self.size.x) * u64::from(self.size.y),
        )?))
    }
}

/// Surfels in one binding's worth of buffers.
#[derive(Debug)]
pub(super) struct PointBand {
    pub(super) count: u32,
    places: Buffer,
    finishes: Buffer,
}

/// The surfels, on the device.
#[derive(Debug)]
pub struct GpuPoints {
    pub(super) bands: Vec<PointBand>,
    /// The same in main memory, for the search that runs there.
    pub(super) surfels: Arc<Surfels>,
}

impl PointBand {
    pub(super) fn places(&self) -> Binding {
        self.places
            .first(u64::from(self.count) * size_of::<Place>() as u64)
    }

    pub(super) fn finishes(&self) -> Binding {
        self.finishes
            .first(u64::from(self.count) * size_of::<Finish>() as u64)
    }
}

impl GpuPoints {
    /// Brings surfels to the device, in bands that one binding holds.
    pub(super) fn upload(
        pool: &Arc<Pool>,
        limits: &wgpu::Limits,
        surfels: &Arc<Surfels>,
    ) -> Result<Self> {
        let (places, finishes) = (&surfels.places, &surfels.finishes);
        let band = (limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size)
            .min(1 << 30)
            / 16) as usize;
        let what = format!("a cloud of {} points", places.len());
        let mut bands = Vec::new();
        for (places, finishes) in places.chunks(band).zip(finishes.chunks(band)) {
            let buffers = PointBand {
                count: places.len() as u32,
                places: pool.take(&what, size_of_val(places) as u64, STORAGE)?,
                finishes: pool.take(&what, size_of_val(finishes) as u64, STORAGE)?,
            };
            buffers.places.upload(0, bytemuck::cast_slice(places))?;
            buffers.finishes.upload(0, bytemuck::cast_slice(finishes))?;
            bands.push(buffers);
        }
        Ok(Self {
            bands,
            surfels: Arc::clone(surfels),
        })
    }
}
