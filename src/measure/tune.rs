//! The settings to use: the best picture in a given time, or a given quality in the shortest.
//!
//! Candidates that fill the space of the settings evenly are judged by a frame each. The better half stays and is measured twice
//! as often, until few are left [Karnin, Koren, Somekh 2013]; then what is near the best is tried, and the winner is measured
//! anew, so that what is promised is not what happened to be fast once.

use std::path::Path;

use super::bench::{Bench, Spread, Traced};
use super::knobs::{Knob, halton};
use crate::error::Result;
use crate::job::Job;
use crate::renderer::BackendChoice;
use crate::scene::{Override, Scene};
use crate::settings::Settings;

/// Candidates that are left when halving ends.
const FINALISTS: usize = 4;

/// Frames of which the promise is the median.
const CHECKS: usize = 7;

/// How far numbers of the best are turned, one after the other.
const TURNS: [f64; 2] = [0.6, 1.6];

/// What is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Goal {
    /// The best albedo in mirrors for so many milliseconds a frame.
    BudgetMs(f64),
    /// So many dB in the shortest time.
    Quality(f64),
}

/// What is tuned.
pub struct TuneTask<'a> {
    /// The scene's file.
    pub path: &'a Path,
    /// What is said on top of it.
    pub overrides: &'a [Override],
    /// The settings that may be turned.
    pub keys: &'a [&'a str],
    /// What is wanted.
    pub goal: Goal,
    /// How many candidates begin.
    pub candidates: u32,
    /// Where to render.
    pub backend: &'a BackendChoice,
}

impl TuneTask<'_> {
    /// Whether the scene is sound and every key can be turned, to be asked before long work.
    ///
    /// # Errors
    /// As [`Scene::open`] and of a key that cannot be varied.
    pub fn check(&self) -> Result<()> {
        let scene = Scene::open(self.path, self.overrides)?;
        Knob::of(self.keys, &scene.settings).map(drop)
    }
}

/// Settings that were tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Tried {
    /// The values of the knobs.
    pub values: Vec<toml::Value>,
    settings: Settings,
    /// Wall time of the first frame, x that of a reference: a first guess.
    rough: f64,
    /// Wall time of each frame, x that of the reference beside it.
    pub(super) ratios: Vec<f64>,
    /// PSNR of the albedo in mirrors, dB.
    pub quality: f64,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuned {
    pub(super) knobs: Vec<Knob>,
    pub(super) goal: Goal,
    /// Whether the best does what was wanted.
    pub reached: bool,
    /// The best; its frames are those measured last.
    pub best: Tried,
    /// All others, the best first.
    pub tried: Vec<Tried>,
    /// Wall time of a reference frame, milliseconds.
    pub reference_ms: Spread,
}

impl Tried {
    /// Wall time of a frame, x that of the reference.
    pub fn ratio(&self) -> Spread {
        if self.ratios.is_empty() {
            Spread::of(&[self.rough])
        } else {
            Spread::of(&self.ratios)
        }
    }

    /// Whether this one is what is wanted.
    fn does(&self, goal: Goal, reference_ms: f64) -> bool {
        match goal {
            Goal::BudgetMs(budget) => self.ratio().median * reference_ms <= budget,
            Goal::Quality(quality) => self.quality >= quality,
        }
    }

    /// Smaller is better.
    fn order(&self, goal: Goal, reference_ms: f64) -> (bool, f64, f64) {
        let time = self.ratio().median;
        let misses = !self.does(goal, reference_ms);
        match (goal, misses) {
            (Goal::BudgetMs(_), false) | (Goal::Quality(_), true) => (misses, -self.quality, time),
            (Goal::BudgetMs(_), true) | (Goal::Quality(_), false) => (misses, time, -self.quality),
        }
    }
}

/// A scene while it is tuned.
struct Tuner<'a> {
    task: &'a TuneTask<'a>,
    knobs: Vec<Knob>,
    bench: Bench,
    traced: Traced,
    references: Vec<f64>,
}

/// Finds the settings to use.
///
/// # Errors
/// [`crate::Error::Setting`] for keys that cannot be tuned, and what rendering meets.
pub fn tune(task: &TuneTask<'_>, job: &Job) -> Result<Tuned> {
    let scene = Scene::open(task.path, task.overrides)?;
    let knobs = Knob::of(task.keys, &scene.settings)?;
    let mut bench = Bench::open(&scene, task.backend, job)?;
    let traced = Traced::render(&mut bench, &scene.settings, job)?;
    let mut tuner = Tuner {
        task,
        knobs,
        bench,
        traced,
        references: Vec::new(),
    };

    // Once the rays' tree is there.
    tuner.measure(&mut [], 1, job)?;
    let mut tried = Vec::new();
    for (done, values) in tuner.start().into_iter().enumerate() {
        job.progress("trying", done as u64, u64::from(task.candidates))?;
        tried.extend(tuner.first(values, &tried, job)?);
    }
    // The first frames tell enough of the worse half, which may be slow.
    tuner.sort(&mut tried);
    let mut frames = 1;
    let mut left = tried.len().div_ceil(2).max(FINALISTS.min(tried.len()));
    while left > FINALISTS {
        tuner.measure(&mut tried[..left], frames, job)?;
        tuner.sort(&mut tried[..left]);
        left = left.div_ceil(2).max(FINALISTS);
        frames *= 2;
    }
    tuner.near(&mut tried, job)?;
    let few = tried.len().min(FINALISTS);
    tuner.measure(&mut tried[..few], CHECKS, job)?;
    tuner.sort(&mut tried[..few]);

    // The promise is measured anew: the best of many is often only the luckiest.
    let mut best = tried.remove(0);
    best.ratios.clear();
    tuner.references.clear();
    tuner.measure(std::slice::from_mut(&mut best), CHECKS, job)?;
    let reference_ms = Spread::of(&tuner.references);
    tuner.sort(&mut tried);
    Ok(Tuned {
        reached: best.does(task.goal, reference_ms.median),
        knobs: tuner.knobs,
        goal: task.goal,
        best,
        tried,
        reference_ms,
    })
}

impl Tuner<'_> {
    /// The first candidates: the scene's own settings, those with one other name, then an even sequence.
    fn start(&self) -> Vec<Vec<toml::Value>> {
        let own: Vec<toml::Value> = self.knobs.iter().map(|k| k.default.clone()).collect();
        let mut start = vec![own.clone()];
        for (index, knob) in self.knobs.iter().enumerate() {
            for name in knob.names().iter().filter(|name| **name != knob.default) {
                let mut other = own.clone();
                other[index] = name.clone();
                start.push(other);
            }
        }
        let more = self.task.candidates.saturating_sub(start.len() as u32);
        start.extend((0..more).map(|i| halton(&self.knobs, i)));
        start
    }

    /// Judges a candidate in one frame that is not timed; `None` where it was there before.
    fn first(
        &mut self,
        values: Vec<toml::Value>,
        before: &[Tried],
        job: &Job,
    ) -> Result<Option<Tried>> {
        let mut overrides = self.task.overrides.to_vec();
        for (knob, value) in self.knobs.iter().zip(&values) {
            let text = value.to_string();
            overrides.push(Override::new(
                &knob.key,
                &text,
                &format!("--keys {}", knob.key),
            )?);
        }
        let settings = Scene::open(self.task.path, &overrides)?.settings;
        if before.iter().any(|t| t.settings == settings) {
            return Ok(None);
        }
        let run = self.bench.run(&settings, job)?;
        let quality = self
            .traced
            .quality(&self.bench, &run.products)?
            .mirrors
            .albedo_psnr;
        Ok(Some(Tried {
            values,
            settings,
            rough: run.cost.wall_ms / self.reference_ms().max(1e-9),
            ratios: Vec::new(),
            quality,
        }))
    }

    /// Times each so many frames more, by turns, with the reference in each turn.
    fn measure(&mut self, tried: &mut [Tried], frames: usize, job: &Job) -> Result<()> {
        for turn in 0..frames {
            let reference = self.bench.run(&self.traced.settings, job)?.cost.wall_ms;
            self.references.push(reference);
            for candidate in &mut *tried {
                job.progress("measuring", turn as u64, frames as u64)?;
                let wall = self.bench.run(&candidate.settings, job)?.cost.wall_ms;
                candidate.ratios.push(wall / reference.max(1e-9));
            }
        }
        Ok(())
    }

    fn reference_ms(&self) -> f64 {
        super::median(&self.references)
    }

    fn sort(&self, tried: &mut [Tried]) {
        let (goal, reference) = (self.task.goal, self.reference_ms());
        tried.sort_by(|a, b| {
            let (a, b) = (a.order(goal, reference), b.order(goal, reference));
            a.0.cmp(&b.0)
                .then(a.1.total_cmp(&b.1))
                .then(a.2.total_cmp(&b.2))
        });
    }

    /// Turns the numbers of the best, one after the other, and keeps what is better.
    fn near(&mut self, tried: &mut Vec<Tried>, job: &Job) -> Result<()> {
        for index in 0..self.knobs.len() {
            for factor in TURNS {
                let Some(best) = tried.first() else {
                    return Ok(());
                };
                let Some(turned) = self.knobs[index].scaled(&best.values[index], factor) else {
                    continue;
                };
                let mut values = best.values.clone();
                values[index] = turned;
                if let Some(candidate) = self.first(values, tried, job)? {
                    let mut pair = [candidate];
                    self.measure(&mut pair, 2, job)?;
                    tried.extend(pair);
                    self.sort(tried);
                }
            }
        }
        Ok(())
    }
}
