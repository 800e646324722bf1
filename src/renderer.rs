//! A scene on a backend, ready to be looked at: matches once which backend it is, and runs the one [`frame`].

use std::sync::Arc;
use std::time::Instant;

use glam::Vec4;

use crate::backend::cpu::Cpu;
use crate::backend::gpu::{AdapterChoice, Gpu, GpuOptions};
use crate::backend::{Backend, LightMap, LitBy};
use crate::cloud::Surfels;
use crate::error::{Error, Result};
use crate::frame::{Frame, View, frame};
use crate::gbuffer::{Coverage, GBuffer};
use crate::gi::shade::shade_mirror;
use crate::grid::Grid;
use crate::job::Job;
use crate::measure::BounceReport;
use crate::memory::{GridsIn, Rendering};
use crate::output::OutputKind;
use crate::plan::{Plan, Stage};
use crate::reflect::{MirrorGBuffer, Reflector, blend};
use crate::settings::Settings;
use crate::timing::{PassTime, Timings};

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

/// A backend, open but without a scene.
pub struct Machine {
    backend: AnyBackend,
}

enum AnyBackend {
    Cpu(Cpu),
    Gpu(Box<Gpu>),
}

/// A scene on a backend.
pub struct Renderer {
    session: AnySession,
}

enum AnySession {
    Cpu(Box<Session<Cpu>>),
    Gpu(Box<Session<Gpu>>),
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
                || AnyBackend::Cpu(Cpu::default()),
                |gpu| AnyBackend::Gpu(Box::new(gpu)),
            ),
        })
    }

    /// Brings the surfels to the backend.
    ///
    /// # Errors
    /// [`Error::Gpu`] and [`Error::Memory`] where it cannot hold the surfels.
    pub fn upload(self, surfels: &Arc<Surfels>) -> Result<Renderer> {
        let session = match self.backend {
            AnyBackend::Cpu(cpu) => AnySession::Cpu(Box::new(Session::new(cpu, surfels)?)),
            AnyBackend::Gpu(gpu) => AnySession::Gpu(Box::new(Session::new(*gpu, surfels)?)),
        };
        Ok(Renderer { session })
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
        match &self.session {
            AnySession::Cpu(s) => s.backend.name(),
            AnySession::Gpu(s) => s.backend.name(),
        }
    }

    /// The adapter's name, where there is one.
    pub fn adapter(&self) -> Option<String> {
        match &self.session {
            AnySession::Cpu(s) => s.backend.adapter(),
            AnySession::Gpu(s) => s.backend.adapter(),
        }
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
        let grids = match &self.session {
            AnySession::Cpu(_) => GridsIn::MainMemory,
            AnySession::Gpu(s) if s.backend.device().is_software() => GridsIn::SoftwareDevice,
            AnySession::Gpu(_) => GridsIn::Device,
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

    /// Renders one frame and brings it to main memory.
    ///
    /// # Errors
    /// [`Error::Memory`] where it would not fit, what the backend meets, or [`Error::Cancelled`].
    pub fn render(
        &mut self,
        view: &View,
        plan: &Plan,
        settings: &Settings,
        job: &Job,
    ) -> Result<Products> {
        self.require_memory(view, plan, settings, &[])?;
        match &mut self.session {
            AnySession::Cpu(s) => s.render(view, plan, settings, job),
            AnySession::Gpu(s) => s.render(view, plan, settings, job),
        }
    }
}

/// A backend with the surfels it shows.
struct Session<B: Backend> {
    backend: B,
    points: B::Points,
    /// Mirrors run on the processor, whichever backend runs the rest.
    surfels: Arc<Surfels>,
    reflector: Reflector,
}

impl<B: Backend> Session<B> {
    fn new(mut backend: B, surfels: &Arc<Surfels>) -> Result<Self> {
        let points = backend.upload(surfels)?;
        Ok(Self {
            backend,
            points,
            surfels: Arc::clone(surfels),
            reflector: Reflector::default(),
        })
    }

    fn render(
        &mut self,
        view: &View,
        plan: &Plan,
        settings: &Settings,
        job: &Job,
    ) -> Result<Products> {
        self.backend.take_timings();
        let start = Instant::now();
        let Frame {
            gbuffer,
            coverage,
            lights,
            radiance,
        } = frame(&mut self.backend, &self.points, view, plan, settings, job)?;
        let mut timings = self.backend.take_timings();
        let mut products = Products {
            gbuffer: GBuffer {
                pinhole: gbuffer.pinhole,
                surface: self.backend.take(gbuffer.surface)?,
                albedo: self.backend.take(gbuffer.albedo)?,
                material: self.backend.take(gbuffer.material)?,
            },
            coverage,
            radiance: self.backend.take(radiance)?,
            mirror: None,
            bounces: Vec::new(),
            passes: Vec::new(),
            wall_ms: 0.0,
        };
        if plan.runs(Stage::Reflect, coverage.mirror > 0) {
            let lights = lights
                .into_iter()
                .map(|lit_by| self.take_light(lit_by))
                .collect::<Result<Vec<_>>>()?;
            self.reflect(&mut products, &lights, view, settings, &mut timings, job)?;
        }
        products.passes = timings.passes;
        products.wall_ms = start.elapsed().as_secs_f64() * 1e3;
        Ok(products)
    }

    /// Lets the mirrors of a picture show what they reflect.
    fn reflect(
        &mut self,
        products: &mut Products,
        lights: &[LitBy<Cpu>],
        view: &View,
        settings: &Settings,
        timings: &mut Timings,
        job: &Job,
    ) -> Result<()> {
        let (mirror, report) = self.reflector.reflect(
            &products.gbuffer,
            &self.surfels,
            view.diagonal(),
            settings,
            timings,
            job,
        )?;
        timings.time("shade_mirror", || {
            let shown = match lights {
                [] => None,
                lights => Some(shade_mirror(&mirror, lights, &settings.gi, job)?),
            };
            blend(
                &mut products.radiance,
                &products.gbuffer,
                &mirror,
                shown.as_ref(),
            );
            Ok::<_, Error>(())
        })?;
        products.mirror = Some(mirror);
        products.bounces.push(report);
        Ok(())
    }

    /// A light with its map, in main memory.
    fn take_light(&mut self, lit_by: LitBy<B>) -> Result<LitBy<Cpu>> {
        Ok(LitBy {
            light: lit_by.light,
            map: LightMap {
                pinhole: lit_by.map.pinhole,
                keys: self.backend.take(lit_by.map.keys)?,
            },
        })
    }
}
