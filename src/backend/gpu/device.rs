//! The graphics device: which adapter is taken, what it is asked for, and how its failures become errors.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::error::{Error, Result};

/// Which adapter is wanted.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// A real graphics card; never a software adapter.
    #[default]
    Hardware,
    /// A real graphics card, or else a software adapter, with a warning in the log.
    Any,
    /// The best adapter, of any kind, whose name contains this text (upper and lower case are the same).
    Named(String),
}

/// How the device is opened.
#[derive(Debug, Clone, Default)]
pub struct GpuOptions {
    /// Which adapter is wanted.
    pub adapter: AdapterChoice,
    /// Asks for WebGPU's default limits and no features, so that every adapter runs the same path.
    pub portable: bool,
    /// Bytes that buffers may take. Without it a software adapter gets three quarters of the memory that the system
    /// has free, since it reports no shortage itself, and a graphics card what its driver grants.
    pub memory_budget: Option<u64>,
    /// Bytes of one binding, where less than the device offers is to be used: smaller bindings mean more bands.
    pub binding_limit: Option<u64>,
}

/// What the device said went wrong, until the next call asks.
#[derive(Debug, Default)]
struct Failure {
    /// The first error since the last call.
    error: Option<String>,
    /// Why the device was lost; for good.
    lost: Option<String>,
}

/// An open graphics device.
#[derive(Debug)]
pub struct Device {
    pub(super) raw: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) limits: wgpu::Limits,
    info: wgpu::AdapterInfo,
    failure: Arc<Mutex<Failure>>,
    budget: Option<u64>,
    used: AtomicU64,
}

/// Locks, also after a panic elsewhere: what is guarded here is whole at every step.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Device {
    /// Opens the best adapter of that choice.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] where there is none, [`Error::Gpu`] where it cannot be opened.
    pub fn open(options: &GpuOptions) -> Result<Self> {
        let adapters = adapters();
        let names: Vec<_> = adapters.iter().map(|a| a.get_info().name).collect();
        let mut wanted: Vec<_> = adapters
            .into_iter()
            .filter(|a| options.adapter.takes(&a.get_info()))
            .collect();
        wanted.sort_by_key(|a| rank(a.get_info().device_type));
        let mut refusal = options.adapter.refusal(&names);
        for adapter in wanted {
            let info = adapter.get_info();
            match Self::open_adapter(&adapter, options) {
                Ok(gpu) => {
                    if options.adapter == AdapterChoice::Any
                        && info.device_type == wgpu::DeviceType::Cpu
                    {
                        log::warn!(
                            "no graphics card was found; the software adapter {:?} draws instead",
                            info.name
                        );
                    }
                    return Ok(gpu);
                }
                Err(error) => {
                    log::warn!("the adapter {:?} cannot be opened: {error}", info.name);
                    refusal = error;
                }
            }
        }
        Err(refusal)
    }

    fn open_adapter(adapter: &wgpu::Adapter, options: &GpuOptions) -> Result<Self> {
        let info = adapter.get_info();
        let software = info.device_type == wgpu::DeviceType::Cpu;
        let (offered, mut limits) = (adapter.limits(), wgpu::Limits::default());
        let mut features = wgpu::Features::empty();
        if !options.portable {
            // Larger buffers mean fewer bands; everything else runs within the defaults.
            limits.max_buffer_size = offered.max_buffer_size.max(limits.max_buffer_size);
            limits.max_storage_buffer_binding_size = offered
                .max_storage_buffer_binding_size
                .max(limits.max_storage_buffer_binding_size);
            // A software adapter stamps its compute passes when they are queued, not when they run.
            if !software {
                features |= adapter.features() & wgpu::Features::TIMESTAMP_QUERY;
            }
        }
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("catoptric"),
            required_features: features,
            required_limits: limits.clone(),
            ..Default::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|e| {
                Error::Gpu(format!(
                    "the adapter {:?} cannot be opened ({e})",
                    info.name
                ))
            })?;

        // An error that nobody catches would end the program.
        let failure = Arc::<Mutex<Failure>>::default();
        let heard = Arc::clone(&failure);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            lock(&heard)
                .error
                .get_or_insert_with(|| one_line(&error.to_string()));
        }));
        let heard = Arc::clone(&failure);
        device.set_device_lost_callback(move |reason, message| {
            lock(&heard)
                .lost
                .get_or_insert_with(|| format!("the device was lost ({reason:?} {message})"));
        });

        if let Some(limit) = options.binding_limit {
            limits.max_storage_buffer_binding_size = limits
                .max_storage_buffer_binding_size
                .min(limit.max(1 << 12));
        }
        let budget = options.memory_budget.or_else(|| software.then(free_memory));
        Ok(Self {
            raw: device,
            queue,
            limits,
            info,
            failure,
            budget,
            used: AtomicU64::new(0),
        })
    }

    /// The adapter's name.
    pub fn adapter(&self) -> &str {
        &self.info.name
    }

    /// Whether the adapter draws on the CPU.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// The device itself, for programs that share it.
    pub fn raw(&self) -> &wgpu::Device {
        &self.raw
    }

    /// What went wrong since the last call, if anything did.
    ///
    /// # Errors
    /// [`Error::Gpu`] with what the device said.
    pub fn check(&self) -> Result<()> {
        let mut failure = lock(&self.failure);
        match failure.lost.clone().or_else(|| failure.error.take()) {
            Some(problem) => Err(Error::Gpu(problem)),
            None => Ok(()),
        }
    }

    /// Waits until the device has done everything that was submitted.
    ///
    /// # Errors
    /// [`Error::Gpu`] where anything went wrong since the last call.
    pub fn wait(&self) -> Result<()> {
        self.wait_for(None)
    }

    /// Waits until the device has done everything up to `submission`, or everything.
    pub(super) fn wait_for(&self, submission: Option<wgpu::SubmissionIndex>) -> Result<()> {
        // The driver interface panics where a device is lost while it waits; that is an error like any other here.
        let waited = catch_unwind(AssertUnwindSafe(|| {
            self.raw.poll(wgpu::PollType::Wait {
                submission_index: submission,
                timeout: None,
            })
        }));
        self.check()?;
        match waited {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(error)) => Err(Error::Gpu(error.to_string())),
            Err(_) => Err(Error::Gpu("the device was lost".into())),
        }
    }

    /// Reserves `size` bytes of the budget for `what`.
    pub(super) fn reserve(&self, what: &str, size: u64) -> Result<()> {
        let used = self.used.fetch_add(size, Ordering::Relaxed);
        match self.budget {
            Some(budget) if used + size > budget => {
                self.release(size);
                Err(Error::Memory {
                    what: what.to_owned(),
                    needed: used + size,
                    budget,
                })
            }
            Some(_) | None => Ok(()),
        }
    }

    /// Gives `size` bytes back.
    pub(super) fn release(&self, size: u64) {
        self.used.fetch_sub(size, Ordering::Relaxed);
    }

    /// Bytes that buffers take now.
    pub fn memory_used(&self) -> u64 {
        self.used.load(Ordering::Relaxed)
    }
}

impl AdapterChoice {
    fn takes(&self, info: &wgpu::AdapterInfo) -> bool {
        match self {
            Self::Hardware => info.device_type != wgpu::DeviceType::Cpu,
            Self::Any => true,
            Self::Named(name) => info.name.to_lowercase().contains(&name.to_lowercase()),
        }
    }

    fn refusal(&self, names: &[String]) -> Error {
        let list = names
            .iter()
            .map(|n| format!("{n:?}"))
            .collect::<Vec<_>>()
            .join(", ");
        Error::NoAdapter(match self {
            Self::Named(name) if !names.is_empty() => {
                format!("no graphics adapter's name contains {name:?}; there are {list}")
            }
            Self::Hardware if !names.is_empty() => {
                format!("no graphics card was found, only the software adapter {list}; ask for it with --backend gpu, or use --backend cpu")
            }
            Self::Hardware | Self::Any | Self::Named(_) => {
                "no graphics adapter was found; install the graphics driver (on Debian also mesa-vulkan-drivers), or use --backend cpu".into()
            }
        })
    }
}

/// The names of all adapters that could be used, the best first, and whether each is software.
pub fn adapter_names() -> Vec<(String, bool)> {
    let mut infos: Vec<wgpu::AdapterInfo> =
        adapters().iter().map(wgpu::Adapter::get_info).collect();
    infos.sort_by_key(|info| rank(info.device_type));
    let fact = |info: wgpu::AdapterInfo| (info.name, info.device_type == wgpu::DeviceType::Cpu);
    infos.into_iter().map(fact).collect()
}

/// Every adapter of the backends that are supported; OpenGL is none of them.
fn adapters() -> Vec<wgpu::Adapter> {
    let backends = wgpu::Backends::VULKAN | wgpu::Backends::DX12 | wgpu::Backends::METAL;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        memory_budget_thresholds: wgpu::MemoryBudgetThresholds {
            for_resource_creation: Some(90),
            for_device_loss: None,
        },
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    pollster::block_on(instance.enumerate_adapters(backends))
}

/// Best first.
fn rank(kind: wgpu::DeviceType) -> u8 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

/// Three quarters of the memory that the system has free, bytes; 2 GiB where it does not say.
fn free_memory() -> u64 {
    let free = std::fs::read_to_string("/proc/meminfo")
        .ok()
        .and_then(|text| {
            let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
            line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()
        });
    free.map_or(2 << 30, |kib| kib * 1024 / 4 * 3)
}

/// A message of several lines as one.
fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_adapter_name_is_answered_with_the_right_ones() {
        let names = ["llvmpipe".to_owned(), "Radeon".to_owned()];
        let message = AdapterChoice::Named("GeForce".into())
            .refusal(&names)
            .to_string();
        assert!(
            message.contains("GeForce")
                && message.contains("llvmpipe")
                && message.contains("Radeon"),
            "{message}"
        );
    }

    #[test]
    fn without_a_graphics_card_the_refusal_says_what_to_do() {
        let message = AdapterChoice::Hardware
            .refusal(&["llvmpipe".to_owned()])
            .to_string();
        assert!(
            message.contains("--backend gpu") && message.contains("--backend cpu"),
            "{message}"
        );
        let message = AdapterChoice::Any.refusal(&[]).to_string();
        assert!(message.contains("install"), "{message}");
    }
}
