//! A scene on a backend, ready to be looked at: matches once which backend it is, and runs the one [`frame`].

use std::sync::Arc;
use std::time::Instant;

use glam::Vec4;

use crate::backend::cpu::Cpu;
use crate::backend::gpu::{AdapterChoice, Device, Gpu, GpuOptions};
use crate::backend::{Backend, Cloud};
use crate::cloud::Surfels;
use crate::error::{Error, Result};
use crate::frame::{Frame, Stages, View, frame};
use crate::gbuffer::{Coverage, GBuffer};
use crate::gi::background::background;
use crate::gi::virtual_lights::VirtualLights;
use crate::grid::Grid;
use crate::image::Background;
use crate::job::Job;
use crate::measure::BounceReport;
use crate::memory::{GridsIn, Rendering};
use crate::output::OutputKind;
use crate::parts::{Whole, parts};
use crate::plan::Plan;
use crate::reflect::MirrorGBuffer;
use crate::reflect::sscr::heat::HeatSums;
use crate::settings::Settings;
use crate::timing::PassTime;

/// What a rendering gives, in main memory.
pub struct Products {
    /// What the camera sees.
    pub gbuffer: GBuffer<Cpu>,
    /// How much of the picture shows something.
    pub coverage: Coverage,
    /// Radiance towards the eye, W/sr/m2 (albedo where the scene has no light); alpha 1 where valid.
    pub radiance: Grid<Vec4>,
    /// What the mirrors show, where the camera sees one.
    pub mirror: Option<MirrorGBuffer<Cpu>>,
    /// What the search came to, one for each mirror bounce.
    pub bounces: Vec<BounceReport>,
    /// Where the searches of the first mirror bounce end, where the plan asks for it and the camera sees a mirror.
    pub search_heat: Option<Grid<HeatSums>>,
    /// The virtual lights and their shadow maps, where the plan asks for them and there is indirect light. They are the same
    /// for every camera, so frames may share them.
    pub virtual_lights: Option<Arc<VirtualLights>>,
    /// Time per pass.
    pub passes: Vec<PassTime>,
    /// Wall time of the frame, milliseconds.
    pub wall_ms: f64,
}

/// Where a scene is to be rendered.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum BackendChoice {
    /// A hardware GPU; without one, the processor.
    #[default]
    Auto,
    /// A GPU, of this name where one is given; a software adapter where there is no other.
    Gpu(Option<String>),
    /// The processor.
    Cpu,
}

/// A backend that is open: it renders the clouds that were brought to it.
pub struct Machine {
    backend: AnyBackend,
}

enum AnyBackend {
    Cpu(Box<Cpu>),
    Gpu(Box<Gpu>),
}

/// A cloud on a [`Machine`], with what its stages keep between frames.
pub struct Resident {
    cloud: AnyCloud,
}

enum AnyCloud {
    Cpu(Box<Held<Cpu>>),
    Gpu(Box<Held<Gpu>>),
}

/// A scene on a backend.
pub struct Renderer {
    machine: Machine,
    resident: Resident,
}

impl Machine {
    /// Opens the backend of the choice.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] where a GPU is asked for and there is none, [`Error::Gpu`] where it cannot be opened.
    pub fn open(choice: &BackendChoice) -> Result<Self> {
        let open = |adapter| {
            Gpu::new(&GpuOptions {
                adapter,
                ..GpuOptions::default()
            })
        };
        let gpu = match choice {
            BackendChoice::Cpu => None,
            BackendChoice::Gpu(None) => Some(open(AdapterChoice::Any)?),
            BackendChoice::Gpu(Some(name)) => Some(open(AdapterChoice::Named(name.clone()))?),
            BackendChoice::Auto => match open(AdapterChoice::Hardware) {
                Ok(gpu) => Some(gpu),
                Err(Error::NoAdapter(_)) => {
                    log::info!("no graphics card was found; the processor renders");
                    None
                }
                Err(Error::Gpu(problem)) => {
                    log::warn!(
                        "the graphics card cannot be used, so the processor renders: {problem}"
                    );
                    None
                }
                Err(other) => return Err(other),
            },
        };
        Ok(Self {
            backend: gpu.map_or_else(
                || AnyBackend::Cpu(Box::default()),
                |gpu| AnyBackend::Gpu(Box::new(gpu)),
            ),
        })
    }

    /// "cpu" or "gpu".
    pub fn backend(&self) -> &'static str {
        match &self.backend {
            AnyBackend::Cpu(backend) => backend.name(),
            AnyBackend::Gpu(backend) => backend.name(),
        }
    }

    /// The adapter's name, where there is one.
    pub fn adapter(&self) -> Option<String> {
        match &self.backend {
            AnyBackend::Cpu(backend) => backend.adapter(),
            AnyBackend::Gpu(backend) => backend.adapter(),
        }
    }

    /// The graphics device, where there is one: for programs that share it.
    pub fn device(&self) -> Option<&Device> {
        match &self.backend {
            AnyBackend::Cpu(_) => None,
            AnyBackend::Gpu(backend) => Some(backend.device()),
        }
    }

    /// Brings surfels here, beside those that are here already.
    ///
    /// # Errors
    /// [`Error::Gpu`] and [`Error::Memory`] where the backend cannot hold them.
    pub fn bring(&mut self, surfels: &Arc<Surfels>) -> Result<Resident> {
        let cloud = match &mut self.backend {
            AnyBackend::Cpu(backend) => {
                AnyCloud::Cpu(Box::new(Held::new(&mut **backend, surfels)?))
            }
            AnyBackend::Gpu(backend) => {
                AnyCloud::Gpu(Box::new(Held::new(&mut **backend, surfels)?))
            }
        };
        Ok(Resident { cloud })
    }

    /// Brings the surfels of the one scene that is to be rendered here.
    ///
    /// # Errors
    /// As [`Machine::bring`].
    pub fn upload(mut self, surfels: &Arc<Surfels>) -> Result<Renderer> {
        let resident = self.bring(surfels)?;
        Ok(Renderer {
            machine: self,
            resident,
        })
    }

    /// Whether a frame and, one after the other, the files made of it fit into main memory, to be asked before long work.
    ///
    /// # Errors
    /// [`Error::Memory`] where they would not.
    pub fn require_memory(
        &self,
        view: &View,
        plan: &Plan,
        settings: &Settings,
        outputs: &[OutputKind],
    ) -> Result<()> {
        let grids = match &self.backend {
            AnyBackend::Cpu(_) => GridsIn::MainMemory,
            AnyBackend::Gpu(gpu) if gpu.device().is_software() => GridsIn::SoftwareDevice,
            AnyBackend::Gpu(_) => GridsIn::Device,
        };
        let rendering = Rendering {
            size: view.pinhole.size,
            lights: view.lights.len(),
            plan,
            settings,
            outputs,
        };
        rendering.require_memory(grids)
    }

    /// Renders one frame of a cloud that was brought here, and brings it to main memory: in parts, where a side is longer
    /// than `image.part_size`.
    ///
    /// # Errors
    /// [`Error::Memory`] where it would not fit, [`Error::Setting`] where the cloud is on another machine, what the
    /// backend meets, or [`Error::Cancelled`].
    pub fn render(
        &mut self,
        resident: &mut Resident,
        view: &View,
        plan: &Plan,
        settings: &Settings,
        job: &Job,
    ) -> Result<Products> {
        self.require_memory(view, plan, settings, &[])?;
        let cut = parts(view.pinhole.size, settings.image.part_size);
        if cut.len() <= 1 {
            return self.render_whole(resident, view, plan, settings, job);
        }
        let mut whole = Whole::new(view.pinhole);
        for part in &cut {
            let window = View {
                pinhole: part.pinhole(&view.pinhole),
                ..view.clone()
            };
            let made = self.render_whole(resident, &window, plan, settings, job)?;
            whole.add(part, made);
        }
        Ok(whole.finish())
    }

    fn render_whole(
        &mut self,
        resident: &mut Resident,
        view: &View,
        plan: &Plan,
        settings: &Settings,
        job: &Job,
    ) -> Result<Products> {
        match (&mut self.backend, &mut resident.cloud) {
            (AnyBackend::Cpu(cpu), AnyCloud::Cpu(held)) => {
                held.render(&mut **cpu, view, plan, settings, job)
            }
            (AnyBackend::Gpu(gpu), AnyCloud::Gpu(held)) => {
                held.render(&mut **gpu, view, plan, settings, job)
            }
            _ => Err(Error::Setting(
                "the points are on another machine; bring them to this one".to_owned(),
            )),
        }
    }
}

impl Renderer {
    /// Opens the backend of the choice and brings the surfels there. Whoever loads them for long opens a [`Machine`]
    /// first.
    ///
    /// # Errors
    /// As [`Machine::open`] and [`Machine::upload`].
    pub fn new(choice: &BackendChoice, surfels: &Arc<Surfels>) -> Result<Self> {
        Machine::open(choice)?.upload(surfels)
    }

    /// "cpu" or "gpu".
    pub fn backend(&self) -> &'static str {
        self.machine.backend()
    }

    /// The adapter's name, where there is one.
    pub fn adapter(&self) -> Option<String> {
        self.machine.adapter()
    }

    /// As [`Machine::require_memory`].
    ///
    /// # Errors
    /// [`Error::Memory`] where they would not fit.
    pub fn require_memory(
        &self,
        view: &View,
        plan: &Plan,
        settings: &Settings,
        outputs: &[OutputKind],
    ) -> Result<()> {
        self.machine.require_memory(view, plan, settings, outputs)
    }

    /// Renders one frame and brings it to main memory.
    ///
    /// # Errors
    /// As [`Machine::render`].
    pub fn render(
        &mut self,
        view: &View,
        plan: &Plan,
        settings: &Settings,
        job: &Job,
    ) -> Result<Products> {
        (self.machine).render(&mut self.resident, view, plan, settings, job)
    }
}

/// Surfels on a backend, and the stages that look at them.
struct Held<B: Backend> {
    cloud: Cloud<B>,
    stages: Stages,
}

impl<B: Backend> Held<B> {
    fn new(backend: &mut B, surfels: &Arc<Surfels>) -> Result<Self> {
        let cloud = Cloud {
            points: backend.upload(surfels)?,
            surfels: Arc::clone(surfels),
        };
        Ok(Self {
            cloud,
            stages: Stages::default(),
        })
    }

    fn render(
        &mut self,
        backend: &mut B,
        view: &View,
        plan: &Plan,
        settings: &Settings,
        job: &Job,
    ) -> Result<Products> {
        std::mem::take(backend.timings());
        let start = Instant::now();
        let Frame {
            gbuffer,
            coverage,
            radiance,
            mirror,
            bounces,
            search_heat,
            virtual_lights,
            ..
        } = frame(
            backend,
            &mut self.stages,
            &self.cloud,
            view,
            plan,
            settings,
            job,
        )?;
        let gbuffer = GBuffer {
            pinhole: gbuffer.pinhole,
            surface: backend.take(gbuffer.surface)?,
            albedo: backend.take(gbuffer.albedo)?,
            material: backend.take(gbuffer.material)?,
        };
        let mut radiance = backend.take(radiance)?;
        let mirror = mirror.map(|mirror| mirror.take(backend)).transpose()?;
        let shows_sky = settings.image.background == Background::Auto;
        if let Some(environment) = view.environment.as_deref().filter(|_| shows_sky) {
            backend.timings().time("background", || {
                background(environment, &gbuffer, mirror.as_ref(), &mut radiance);
            });
        }
        Ok(Products {
            gbuffer,
            coverage,
            radiance,
            mirror,
            bounces,
            search_heat,
            virtual_lights: virtual_lights.map(Arc::new),
            passes: std::mem::take(backend.timings()).passes,
            wall_ms: start.elapsed().as_secs_f64() * 1e3,
        })
    }
}
