//! Named settings side by side with the traced reference of the same surfels.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use super::bench::{Bench, Cost, Quality, Spread, Traced};
use super::planes::Planes;
use super::precision::{Precision, found_by_both};
use super::quality::{AlbedoQuality, MirrorQuality, PictureQuality, displayed, picture_quality};
use super::report::BounceReport;
use super::truth::Truth;
use super::variant::Variant;
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::image::picture;
use crate::job::Job;
use crate::output::search_heat_picture;
use crate::reflect::sscr::heat::require_search;
use crate::renderer::{BackendChoice, Products};
use crate::scene::{Override, Scene};
use crate::settings::Settings;
use crate::timing::PassTime;

/// What is compared, and how often.
pub struct Task<'a> {
    /// The scene's file.
    pub path: &'a Path,
    /// What is said on top of it, for all variants.
    pub overrides: &'a [Override],
    /// The settings.
    pub variants: &'a [Variant],
    /// What others say of the scene, with the names of the files.
    pub truths: &'a [(String, Truth)],
    /// Timed frames of each variant, after one that is not.
    pub repeats: u32,
    /// Whether interleaved searches run in f64, too, to tell where f32 parts from it.
    pub precision: bool,
    /// Where to render.
    pub backend: &'a BackendChoice,
}

/// Variants side by side.
#[derive(Serialize)]
pub struct Comparison {
    /// Of this file: 1.
    pub format: u32,
    /// Of the program.
    pub version: &'static str,
    /// The scene, for people.
    pub scene: String,
    /// "cpu" or "gpu".
    pub backend: String,
    /// The graphics adapter's name, or `null`.
    pub adapter: Option<String>,
    /// Surfels drawn from.
    pub points: u64,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Timed frames of each variant.
    pub repeats: u32,
    /// What the reference moved by one pixel, and black mirrors, come to: whoever is near is bad.
    pub controls: Controls,
    /// The reference first, then the variants as they were given.
    pub variants: Vec<Measured>,
}

/// Bad mirrors on purpose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Controls {
    /// The reference, moved to the right by one pixel.
    pub moved_by_one_pixel: AlbedoQuality,
    /// Nothing.
    pub black: AlbedoQuality,
}

/// A variant, measured.
#[derive(Serialize)]
pub struct Measured {
    /// Its name.
    pub name: String,
    /// Settings that differ from their defaults.
    pub settings: BTreeMap<String, toml::Value>,
    /// Wall time of the first frame, which builds what later ones keep, milliseconds.
    pub first_ms: f64,
    /// Wall time of a frame, milliseconds.
    pub wall_ms: Spread,
    /// Time of all processor cores together, milliseconds.
    pub cpu_ms: Option<Spread>,
    /// Wall time of a frame, x that of the reference in the same round.
    pub ratio: Spread,
    /// Medians of the time of each pass.
    pub passes: Vec<PassTime>,
    /// Most memory held at once in any of its frames, bytes.
    pub peak_memory_bytes: Option<u64>,
    /// The search, where one ran.
    pub search: Vec<BounceReport>,
    /// Against the reference.
    #[serde(flatten)]
    pub quality: Quality,
    /// Against what others say.
    pub truths: Vec<AgainstTruth>,
    /// Where its search would part from one in f64; only of interleaved searches, where asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub precision: Option<Precision>,
    /// The picture, and its difference from the reference, four times as bright; where an interleaved search ran, its steps,
    /// misses and residuals.
    #[serde(skip)]
    pub pictures: Vec<(&'static str, Grid<[u8; 4]>)>,
}

/// How well a variant shows what somebody else says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AgainstTruth {
    /// The file.
    pub file: String,
    /// What the mirrors show.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mirrors: Option<MirrorQuality>,
    /// The picture, over the mirrors' pixels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<PictureQuality>,
}

/// Runs all variants of a task, round by round, so that a noisy moment meets all.
///
/// # Errors
/// What rendering meets; [`Error::Setting`] for a variant that changes more than settings, or a truth of another size.
pub fn compare(task: &Task<'_>, job: &Job) -> Result<Comparison> {
    let scene = Scene::open(task.path, task.overrides)?;
    let mut settings = Vec::with_capacity(task.variants.len());
    for variant in task.variants {
        settings.push(variant.settings(task, &scene)?);
    }
    if task.precision && settings.iter().all(|s| require_search(s).is_err()) {
        return Err(Error::Override {
            given: "--precision".into(),
            problem: "it is of the interleaved search, and no variant runs that; give one sscr.search=interleaved".into(),
        });
    }
    let mut bench = Bench::open(&scene, task.backend, job)?;
    let traced = Traced::render(&mut bench, &scene.settings, job)?;
    let size = traced.reference.size();
    if let Some((file, truth)) = task.truths.iter().find(|(_, truth)| truth.size() != size) {
        let of = truth.size();
        return Err(Error::Setting(format!(
            "{file} is {}x{} pixels and the picture {}x{}; add --set camera.size={}x{}",
            of.x, of.y, size.x, size.y, of.x, of.y
        )));
    }
    let mut measured = vec![Variants::new("reference", traced.settings.clone())];
    measured.extend((task.variants.iter().zip(settings)).map(|(v, s)| Variants::new(&v.name, s)));

    // The first round is not timed: it makes what later frames keep, and what is judged.
    let total = u64::from(task.repeats + 1) * measured.len() as u64;
    let mut done = 0;
    let mut step = |job: &Job| {
        done += 1;
        job.progress("comparing", done, total)
    };
    let mut judged = Vec::with_capacity(measured.len());
    for variant in &mut measured {
        step(job)?;
        let run = bench.run(&variant.settings, job)?;
        variant.first_ms = run.cost.wall_ms;
        let heat = bench.with_heat(&variant.settings, job)?;
        judged.push(judge(
            task,
            &bench,
            &traced,
            variant,
            &run.products,
            heat.as_ref(),
            job,
        )?);
    }
    for _ in 0..task.repeats {
        for variant in &mut measured {
            step(job)?;
            variant.costs.push(bench.run(&variant.settings, job)?.cost);
        }
    }
    let references: Vec<f64> = (measured.first())
        .map(|reference| reference.costs.iter().map(|c| c.wall_ms).collect())
        .unwrap_or_default();
    let variants = (measured.into_iter().zip(judged))
        .map(|(variant, judged)| variant.summary(&references, judged))
        .collect();
    Ok(Comparison {
        format: 1,
        version: env!("CARGO_PKG_VERSION"),
        scene: task.path.display().to_string(),
        backend: bench.backend().to_owned(),
        adapter: bench.adapter(),
        points: bench.facts().points,
        size: size.to_array(),
        repeats: task.repeats,
        controls: Controls {
            moved_by_one_pixel: traced.reference.moved(),
            black: traced.reference.black(),
        },
        variants,
    })
}

/// A variant while it is measured.
struct Variants {
    name: String,
    settings: Settings,
    first_ms: f64,
    costs: Vec<Cost>,
}

/// What was found of a variant's picture.
struct Judged {
    search: Vec<BounceReport>,
    quality: Quality,
    truths: Vec<AgainstTruth>,
    precision: Option<Precision>,
    pictures: Vec<(&'static str, Grid<[u8; 4]>)>,
}

impl Variants {
    fn new(name: &str, settings: Settings) -> Self {
        Self {
            name: name.to_owned(),
            settings,
            first_ms: 0.0,
            costs: Vec::new(),
        }
    }

    fn summary(self, references: &[f64], judged: Judged) -> Measured {
        let of = |value: &dyn Fn(&Cost) -> Option<f64>| -> Vec<f64> {
            self.costs.iter().filter_map(value).collect()
        };
        let wall = of(&|c| Some(c.wall_ms));
        let ratios: Vec<f64> = wall
            .iter()
            .zip(references)
            .map(|(w, r)| w / r.max(1e-9))
            .collect();
        let cpu = of(&|c| c.cpu_ms);
        Measured {
            settings: self.settings.changed().into_iter().collect(),
            first_ms: self.first_ms,
            wall_ms: Spread::of(&wall),
            cpu_ms: (!cpu.is_empty()).then(|| Spread::of(&cpu)),
            ratio: Spread::of(&ratios),
            passes: median_passes(&self.costs),
            peak_memory_bytes: self.costs.iter().filter_map(|c| c.peak_memory_bytes).max(),
            search: judged.search,
            quality: judged.quality,
            truths: judged.truths,
            precision: judged.precision,
            pictures: judged.pictures,
            name: self.name,
        }
    }
}

/// The median time of each pass over frames.
pub fn median_passes(costs: &[Cost]) -> Vec<PassTime> {
    let first = costs
        .first()
        .map(|c| c.passes.as_slice())
        .unwrap_or_default();
    let of = |name: &str, value: &dyn Fn(&PassTime) -> Option<f64>| {
        let all = costs
            .iter()
            .flat_map(|c| &c.passes)
            .filter(|p| p.name == name);
        let values: Vec<f64> = all.filter_map(value).collect();
        (!values.is_empty()).then(|| super::median(&values))
    };
    (first.iter())
        .map(|pass| PassTime {
            name: pass.name.clone(),
            wall_ms: of(&pass.name, &|p| Some(p.wall_ms)).unwrap_or_default(),
            gpu_ms: of(&pass.name, &|p| p.gpu_ms),
            cpu_ms: of(&pass.name, &|p| p.cpu_ms),
        })
        .collect()
}

fn judge(
    task: &Task<'_>,
    bench: &Bench,
    traced: &Traced,
    variant: &Variants,
    products: &Products,
    heat: Option<&Products>,
    job: &Job,
) -> Result<Judged> {
    let image = &traced.settings.image;
    let shown = displayed(&products.radiance, image);
    let mut truths = Vec::with_capacity(task.truths.len());
    for (file, truth) in task.truths {
        let (mut mirrors, mut of_picture) = (None, None);
        match truth {
            Truth::Mirrors(reference) => {
                mirrors = Some(reference.quality(&bench.mirrors(products))?);
            }
            Truth::Picture(radiance) => {
                let wanted = displayed(radiance, image);
                let mask = traced.reference.mirror();
                of_picture = Some(picture_quality(&shown, &wanted, mask)?);
            }
        }
        truths.push(AgainstTruth {
            file: file.clone(),
            mirrors,
            picture: of_picture,
        });
    }
    let reference = displayed(&traced.products.radiance, image);
    let mut pictures = vec![
        (
            "picture",
            picture(&products.radiance, &variant.settings.image),
        ),
        ("difference", difference(&shown, &reference)),
    ];
    if let Some(heat) = heat.and_then(|products| products.search_heat.as_ref()) {
        pictures.push(("steps, misses, residual", search_heat_picture(heat)));
    }
    Ok(Judged {
        search: products.bounces.clone(),
        quality: traced.quality(bench, products)?,
        truths,
        precision: precision(task, bench, products, &variant.settings, job)?,
        pictures,
    })
}

/// Where the search of a frame would part from one in f64, if it is asked for and there is one.
fn precision(
    task: &Task<'_>,
    bench: &Bench,
    products: &Products,
    settings: &Settings,
    job: &Job,
) -> Result<Option<Precision>> {
    if !task.precision || require_search(settings).is_err() {
        return Ok(None);
    }
    let (gbuffer, places) = (&products.gbuffer, &bench.surfels().places);
    let (offered, found) = found_by_both(gbuffer, places, settings, job)?;
    Ok(Some(Precision::of(offered, &found)))
}

/// How far two pictures are apart, four times as bright.
fn difference(a: &Planes, b: &Planes) -> Grid<[u8; 4]> {
    let mut apart = Grid::new(a.size, [0, 0, 0, 255]);
    for (i, pixel) in apart.values_mut().iter_mut().enumerate() {
        let [r, g, b] = ((a.at(i) - b.at(i)).abs() * (4.0 * 255.0)).to_array();
        *pixel = [r as u8, g as u8, b as u8, 255];
    }
    apart
}
