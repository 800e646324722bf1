//! A scene on a backend, ready to be looked at: matches once which backend it is, and runs the one [`frame`].

use std::sync::Arc;
use std::time::Instant;

use bytemuck::Pod;
use glam::{UVec2, Vec4};

use crate::backend::Backend;
use crate::backend::cpu::Cpu;
use crate::backend::gpu::{AdapterChoice, Gpu, GpuOptions};
use crate::cloud::Surfels;
use crate::error::{Error, Result};
use crate::frame::{Frame, View, frame};
use crate::gbuffer::{Coverage, GBuffer};
use crate::grid::Grid;
use crate::job::Job;
use crate::plan::Plan;
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

/// A scene on a backend.
pub struct Renderer {
    session: AnySession,
}

enum AnySession {
    Cpu(Session<Cpu>),
    Gpu(Box<Session<Gpu>>),
}

impl Renderer {
    /// Brings the surfels to the backend of the choice.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] where a GPU is asked for and there is none; [`Error::Gpu`] and [`Error::Memory`] where it
    /// cannot hold the surfels.
    pub fn new(choice: &BackendChoice, surfels: &Arc<Surfels>) -> Result<Self> {
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
                Err(other) => return Err(other),
            },
        };
        let session = match gpu {
            Some(gpu) => AnySession::Gpu(Box::new(Session::new(gpu, surfels)?)),
            None => AnySession::Cpu(Session::new(Cpu::default(), surfels)?),
        };
        Ok(Self { session })
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

    /// Renders one frame and brings it to main memory.
    ///
    /// # Errors
    /// What the backend meets, or [`Error::Cancelled`].
    pub fn render(
        &mut self,
        view: &View,
        plan: &Plan,
        settings: &Settings,
        job: &Job,
    ) -> Result<Products> {
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
}

impl<B: Backend> Session<B> {
    fn new(mut backend: B, surfels: &Arc<Surfels>) -> Result<Self> {
        let points = backend.upload(surfels)?;
        Ok(Self { backend, points })
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
            radiance,
        } = frame(&mut self.backend, &self.points, view, plan, settings, job)?;
        let wall_ms = start.elapsed().as_secs_f64() * 1e3;
        let passes = self.backend.take_timings().passes;
        let size = view.pinhole.size;
        Ok(Products {
            gbuffer: GBuffer {
                pinhole: gbuffer.pinhole,
                surface: self.fetch(size, &gbuffer.surface)?,
                albedo: self.fetch(size, &gbuffer.albedo)?,
                material: self.fetch(size, &gbuffer.material)?,
            },
            coverage,
            radiance: self.fetch(size, &radiance)?,
            passes,
            wall_ms,
        })
    }

    /// A grid in main memory.
    fn fetch<T: Pod>(&mut self, size: UVec2, grid: &B::Grid<T>) -> Result<Grid<T>> {
        let values = self.backend.read(grid)?.into_owned();
        Grid::from_vec(size, values)
            .ok_or_else(|| Error::Gpu("it returned a picture of another size".into()))
    }
}
