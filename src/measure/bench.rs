//! A scene that is rendered again and again, with one setting after the other, and timed.

use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::percentiles::Percentiles;
use super::quality::{
    MirrorPicture, MirrorQuality, PictureQuality, Reference, displayed, picture_quality,
};
use super::report::{peak_memory_bytes, restart_peak_memory};
use crate::cloud::{Facts, Surfels};
use crate::error::Result;
use crate::frame::View;
use crate::job::Job;
use crate::plan::Plan;
use crate::reflect::Method;
use crate::reflect::sscr::heat::require_search;
use crate::renderer::{BackendChoice, Machine, Products, Renderer};
use crate::scene::{LoadedScene, Scene};
use crate::settings::Settings;
use crate::timing::{PassTime, process_ms};

/// A scene on a backend, to be rendered with many settings.
pub struct Bench {
    loaded: LoadedScene,
    view: View,
    renderer: Renderer,
}

/// One frame, timed.
pub struct Run {
    /// What it gave.
    pub products: Products,
    /// What it took.
    pub cost: Cost,
}

/// What a frame took.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Wall time, milliseconds.
    pub wall_ms: f64,
    /// Time of all processor cores together, milliseconds, where the system tells.
    pub cpu_ms: Option<f64>,
    /// Most memory held at once while it ran, bytes, where the system tells.
    pub peak_memory_bytes: Option<u64>,
    /// The time of each pass.
    pub passes: Vec<PassTime>,
}

/// How well a frame shows what the reference does.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// What the mirrors show.
    pub mirrors: MirrorQuality,
    /// The picture, over the mirrors' pixels.
    pub picture: PictureQuality,
}

/// Values measured again and again.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Half are smaller.
    pub median: f64,
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    /// Of these values; all 0 of none.
    pub fn of(values: &[f64]) -> Self {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let Percentiles { median, max, .. } = Percentiles::of(values.to_vec());
        Self {
            median,
            min: if values.is_empty() { 0.0 } else { least },
            max,
        }
    }
}

impl Bench {
    /// Loads a scene and brings it to a backend.
    ///
    /// # Errors
    /// What opening, loading and uploading meet.
    pub fn open(scene: &Scene, backend: &BackendChoice, job: &Job) -> Result<Self> {
        let machine = Machine::open(backend)?;
        let loaded = scene.load(job)?;
        Ok(Self {
            view: loaded.view()?,
            renderer: machine.upload(&Arc::clone(&loaded.surfels))?,
            loaded,
        })
    }

    /// "cpu" or "gpu".
    pub fn backend(&self) -> &'static str {
        self.renderer.backend()
    }

    /// The graphics adapter's name, where there is one.
    pub fn adapter(&self) -> Option<String> {
        self.renderer.adapter()
    }

    /// Counts, bounds, repairs.
    pub fn facts(&self) -> &Facts {
        &self.loaded.facts
    }

    /// Renders one frame.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn run(&mut self, settings: &Settings, job: &Job) -> Result<Run> {
        let plan = self.loaded.plan(settings);
        self.run_plan(&plan, settings, job)
    }

    /// Renders one frame without light: what mirrors show of the albedo, and the time that takes.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn run_unlit(&mut self, settings: &Settings, job: &Job) -> Result<Run> {
        let mut plan = self.loaded.plan(settings);
        plan.leave_out_light();
        self.run_plan(&plan, settings, job)
    }

    fn run_plan(&mut self, plan: &Plan, settings: &Settings, job: &Job) -> Result<Run> {
        let counted = restart_peak_memory();
        let (start, cpu) = (Instant::now(), process_ms());
        let products = self.renderer.render(&self.view, plan, settings, job)?;
        let wall_ms = start.elapsed().as_secs_f64() * 1e3;
        let cpu_ms = process_ms().zip(cpu).map(|(now, then)| now - then);
        let cost = Cost {
            wall_ms,
            cpu_ms,
            peak_memory_bytes: if counted { peak_memory_bytes() } else { None },
            passes: products.passes.clone(),
        };
        Ok(Run { products, cost })
    }

    /// Renders one more frame with where the searches end, if the settings have an interleaved search.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn with_heat(&mut self, settings: &Settings, job: &Job) -> Result<Option<Products>> {
        if require_search(settings).is_err() {
            return Ok(None);
        }
        let mut plan = self.loaded.plan(settings);
        plan.ask_for_search_heat(settings)?;
        self.renderer
            .render(&self.view, &plan, settings, job)
            .map(Some)
    }

    /// The points that are drawn.
    pub fn surfels(&self) -> &Arc<Surfels> {
        &self.loaded.surfels
    }

    /// What the mirrors show, for the measures.
    pub fn mirrors(&self, products: &Products) -> MirrorPicture {
        let size = self.view.pinhole.size;
        match &products.mirror {
            Some(mirror) => MirrorPicture::new(mirror, self.loaded.surfels.origin),
            None => MirrorPicture {
                size,
                pixels: vec![None; size.x as usize * size.y as usize],
            },
        }
    }

    /// What the mirrors of a frame show, taken as what they ought to.
    pub fn reference(&self, products: &Products) -> Reference {
        let size = self.view.pinhole.size;
        let pixels = size.x as usize * size.y as usize;
        match &products.mirror {
            Some(mirror) => Reference::of(mirror, self.loaded.surfels.origin),
            None => Reference::new(size, vec![false; pixels], vec![None; pixels]),
        }
    }
}

/// A traced frame, against which others of the same surfels are measured.
pub struct Traced {
    /// How it was rendered.
    pub settings: Settings,
    /// What it gave.
    pub products: Products,
    /// What its mirrors show.
    pub reference: Reference,
}

impl Traced {
    /// Renders the reference of the given settings: the same, its mirrors by traced rays.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render(bench: &mut Bench, settings: &Settings, job: &Job) -> Result<Self> {
        let mut settings = settings.clone();
        settings.reflect.method = Method::RayTrace;
        let products = bench.run(&settings, job)?.products;
        Ok(Self {
            reference: bench.reference(&products),
            settings,
            products,
        })
    }

    /// How well a frame shows what this one does. Both pictures are shown as the reference's settings say.
    ///
    /// # Errors
    /// [`crate::Error::Setting`] where it has another size.
    pub fn quality(&self, bench: &Bench, products: &Products) -> Result<Quality> {
        let image = &self.settings.image;
        Ok(Quality {
            mirrors: self.reference.quality(&bench.mirrors(products))?,
            picture: picture_quality(
                &displayed(&products.radiance, image),
                &displayed(&self.products.radiance, image),
                self.reference.mirror(),
            )?,
        })
    }
}
