//! Kernels, made once; and passes, which run them chunk by chunk and take the time.

use std::collections::{HashMap, VecDeque};
use std::sync::Arc;
use std::time::Instant;

use bytemuck::Pod;
use glam::UVec2;

use super::buffers::{BINDING_ALIGNMENT, Binding, Pool, UNIFORM};
use super::device::Device;
use super::link::link;
use super::shaders::{SHARED, Shader};
use super::stamps::Stamps;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::timing::Timings;

/// Threads per workgroup of a kernel with a thread per point.
pub(super) const POINT_GROUP: u32 = 64;

/// Side of the workgroup of a kernel with a thread per pixel.
pub(super) const PIXEL_GROUP: u32 = 8;

/// Submissions that the device has at a time: enough to keep it busy, few enough to stop soon.
const IN_FLIGHT: usize = 4;

/// A compute pipeline. Its bind group layout comes from the shader.
#[derive(Debug)]
pub(super) struct Kernel {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

impl Kernel {
    fn new(device: &Device, shader: &Shader) -> Result<Self> {
        let source = link(shader.source, SHARED)?;
        let module = device
            .raw
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(shader.name),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            });
        device.check()?;
        let pipeline = device
            .raw
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(shader.name),
                layout: None,
                module: &module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: shader.constants,
                    zero_initialize_workgroup_memory: true,
                },
                cache: None,
            });
        device.check()?;
        let layout = pipeline.get_bind_group_layout(0);
        device.check()?;
        Ok(Self { pipeline, layout })
    }
}

/// The kernels in use so far. What no stage runs is not built.
#[derive(Debug, Default)]
pub(super) struct Kernels {
    built: HashMap<&'static str, Arc<Kernel>>,
}

impl Kernels {
    pub(super) fn get(&mut self, device: &Device, shader: &Shader) -> Result<Arc<Kernel>> {
        if let Some(kernel) = self.built.get(shader.name) {
            return Ok(Arc::clone(kernel));
        }
        let kernel = Arc::new(Kernel::new(device, shader)?);
        self.built.insert(shader.name, Arc::clone(&kernel));
        Ok(kernel)
    }
}

/// Threads of a dispatch.
#[derive(Debug, Clone, Copy)]
pub(super) enum Threads {
    /// One per point.
    Points(u32),
    /// One per point of so many sets of so many points.
    Sets {
        /// Points of each set.
        points: u32,
        /// Sets, a row of workgroups each.
        sets: u32,
    },
    /// One per pixel of so many columns and rows.
    Pixels(UVec2),
}

impl Threads {
    fn groups(self) -> UVec2 {
        match self {
            Self::Points(count) => UVec2::new(count.div_ceil(POINT_GROUP), 1),
            Self::Sets { points, sets } => UVec2::new(points.div_ceil(POINT_GROUP), sets),
            Self::Pixels(size) => {
                UVec2::new(size.x.div_ceil(PIXEL_GROUP), size.y.div_ceil(PIXEL_GROUP))
            }
        }
    }
}

/// One run of a kernel.
#[derive(Debug)]
struct Dispatch {
    kernel: Arc<Kernel>,
    uniform: u64,
    bindings: Vec<Binding>,
    groups: UVec2,
    /// Cleared to zero before it runs.
    zeroed: Vec<Binding>,
}

/// A pass: dispatches that run one after the other under one name. Each is a submission of its own, so that none keeps
/// the device so long that the system takes it for hung.
pub(super) struct Pass<'a> {
    name: &'a str,
    device: &'a Device,
    pool: &'a Arc<Pool>,
    stamps: Option<&'a Stamps>,
    uniforms: Vec<u8>,
    dispatches: Vec<Dispatch>,
    zeroed: Vec<Binding>,
}

/// A dispatch while its bindings are listed, in the order of the shader's.
pub(super) struct Compute<'p, 'a> {
    pass: &'p mut Pass<'a>,
    dispatch: Dispatch,
}

impl<'a> Pass<'a> {
    pub(super) fn new(
        name: &'a str,
        device: &'a Device,
        pool: &'a Arc<Pool>,
        stamps: Option<&'a Stamps>,
    ) -> Self {
        Self {
            name,
            device,
            pool,
            stamps,
            uniforms: Vec::new(),
            dispatches: Vec::new(),
            zeroed: Vec::new(),
        }
    }

    /// Clears part of a buffer to zero before the next dispatch.
    pub(super) fn zero(&mut self, part: Binding) {
        self.zeroed.push(part);
    }

    /// Begins a dispatch; binding 0 is its `params`.
    pub(super) fn compute<P: Pod>(&mut self, kernel: &Arc<Kernel>, params: &P) -> Compute<'_, 'a> {
        let uniform = self.uniforms.len() as u64;
        self.uniforms.extend_from_slice(bytemuck::bytes_of(params));
        let padded = self
            .uniforms
            .len()
            .next_multiple_of(BINDING_ALIGNMENT as usize);
        self.uniforms.resize(padded, 0);
        let dispatch = Dispatch {
            kernel: Arc::clone(kernel),
            uniform,
            bindings: Vec::new(),
            groups: UVec2::ZERO,
            zeroed: std::mem::take(&mut self.zeroed),
        };
        Compute {
            pass: self,
            dispatch,
        }
    }

    /// Runs what was listed, waits for it, and adds the time to `timings`.
    ///
    /// Once the job is cancelled nothing more is submitted.
    pub(super) fn finish(self, timings: &mut Timings, job: &Job) -> Result<()> {
        let start = Instant::now();
        if self.dispatches.is_empty() {
            return self.device.check();
        }
        let uniforms = self
            .pool
            .take(self.name, self.uniforms.len() as u64, UNIFORM)?;
        uniforms.upload(0, &self.uniforms)?;
        let last = self.dispatches.len() - 1;
        let mut in_flight = VecDeque::with_capacity(IN_FLIGHT);
        for (i, dispatch) in self.dispatches.iter().enumerate() {
            if in_flight.len() == IN_FLIGHT {
                self.device.wait_for(in_flight.pop_front())?;
            }
            job.check()?;
            let end = if i == last {
                self.uniforms.len() as u64
            } else {
                self.dispatches[i + 1].uniform
            };
            let bind_group = self.bind(dispatch, uniforms.raw(), end - dispatch.uniform);
            let descriptor = wgpu::CommandEncoderDescriptor {
                label: Some(self.name),
            };
            let mut encoder = self.device.raw.create_command_encoder(&descriptor);
            for part in &dispatch.zeroed {
                encoder.clear_buffer(&part.buffer, part.offset, Some(part.size));
            }
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(self.name),
                timestamp_writes: self.stamps.and_then(|s| s.writes(i == 0, i == last)),
            });
            pass.set_pipeline(&dispatch.kernel.pipeline);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.dispatch_workgroups(dispatch.groups.x, dispatch.groups.y, 1);
            drop(pass);
            if let (Some(stamps), true) = (self.stamps, i == last) {
                stamps.resolve(&mut encoder);
            }
            in_flight.push_back(self.device.queue.submit([encoder.finish()]));
        }
        self.device.wait()?;
        timings.add(self.name, start.elapsed());
        if let Some(stamps) = self.stamps {
            timings.add_gpu(self.name, stamps.elapsed_ms(self.device)?);
        }
        Ok(())
    }

    fn bind(&self, dispatch: &Dispatch, uniforms: &wgpu::Buffer, size: u64) -> wgpu::BindGroup {
        let part = |buffer, offset, size| {
            wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset,
                size: wgpu::BufferSize::new(size),
            })
        };
        let params = part(uniforms, dispatch.uniform, size);
        let rest = dispatch
            .bindings
            .iter()
            .map(|b| part(&b.buffer, b.offset, b.size));
        let entries: Vec<_> = std::iter::once(params)
            .chain(rest)
            .enumerate()
            .map(|(i, resource)| wgpu::BindGroupEntry {
                binding: i as u32,
                resource,
            })
            .collect();
        self.device
            .raw
            .create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(self.name),
                layout: &dispatch.kernel.layout,
                entries: &entries,
            })
    }
}

impl Compute<'_, '_> {
    /// The next binding, which the kernel reads.
    pub(super) fn read(mut self, binding: Binding) -> Self {
        self.dispatch.bindings.push(binding);
        self
    }

    /// The next binding, which the kernel writes.
    pub(super) fn write(self, binding: Binding) -> Self {
        self.read(binding)
    }

    /// Lists the dispatch.
    pub(super) fn dispatch(mut self, threads: Threads) -> Result<()> {
        let groups = threads.groups();
        if groups.max_element() > self.pass.device.limits.max_compute_workgroups_per_dimension {
            return Err(Error::Gpu(format!(
                "the pass {:?} is too large",
                self.pass.name
            )));
        }
        if groups.min_element() > 0 {
            self.dispatch.groups = groups;
            self.pass.dispatches.push(self.dispatch);
        }
        Ok(())
    }
}
