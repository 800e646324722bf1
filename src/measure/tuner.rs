//! A scene while it is tuned: which settings are tried, and how they are timed.
//!
//! Where only settings of mirrors are turned, light costs the same whatever they are: it is timed once, and candidates are
//! timed without it.

use std::time::{Duration, Instant};

use super::bench::{Bench, Run, Spread, Traced};
use super::idle::{is_idle, is_of_mirrors};
use super::knobs::{Knob, halton};
use super::tune::{Goal, Tried, TuneTask};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::scene::{Override, Scene};
use crate::settings::Settings;

/// Whole frames of which the promise is the median: the first number where they differ by less than [`STEADY`] of it.
const CHECKS: [usize; 2] = [3, 5];

/// Spread of times that are steady, of their median.
const STEADY: f64 = 0.1;

/// Who is slower by less than this part of the time is no worse.
const TIE: f64 = 0.03;

/// Frames by which the share of light is told.
const CALIBRATIONS: usize = 2;

/// How far numbers of the best are turned, one after the other.
const TURNS: [[f64; 2]; 2] = [[0.6, 1.6], [0.8, 1.25]];

/// Settings near the best that are tried at most.
const NEAR: usize = 24;

/// A frame is given up that takes so many times what would be of use: a first frame is slower than those after it.
const PATIENCE: f64 = 1.5;

/// Numbers of the sequence that are looked at for each candidate: many differ in nothing that counts.
const DRAWS: u32 = 8;

/// A scene while it is tuned.
pub(super) struct Tuner<'a> {
    task: &'a TuneTask<'a>,
    pub(super) knobs: Vec<Knob>,
    bench: Bench,
    traced: Traced,
    /// Whether candidates are timed without light.
    unlit: bool,
    /// Share of a reference's wall time that candidates are timed without.
    light: f64,
    /// Wall time of whole references, and as candidates are timed; milliseconds.
    references: Vec<f64>,
    partial: Vec<f64>,
    /// Settings whose first frame was too slow.
    pub(super) given_up: usize,
}

impl<'a> Tuner<'a> {
    /// Opens the scene and times its reference.
    pub(super) fn open(task: &'a TuneTask<'a>, job: &Job) -> Result<Self> {
        let scene = Scene::open(task.path, task.overrides)?;
        let knobs = Knob::of(task.keys, &scene.settings)?;
        let mut bench = Bench::open(&scene, task.backend, job)?;
        // This first frame builds the rays' tree.
        let traced = Traced::render(&mut bench, &scene.settings, job)?;
        let mut tuner = Self {
            unlit: task.keys.iter().all(|key| is_of_mirrors(key)),
            task,
            knobs,
            bench,
            traced,
            light: 0.0,
            references: Vec::new(),
            partial: Vec::new(),
            given_up: 0,
        };
        for _ in 0..CALIBRATIONS {
            tuner.reference(job)?;
            tuner.partial_reference(job)?;
        }
        let part = super::median(&tuner.partial) / super::median(&tuner.references).max(1e-9);
        tuner.light = (1.0 - part).clamp(0.0, 1.0);
        Ok(tuner)
    }

    /// The first candidates, each judged by a frame: the scene's own settings, those with one other name, then an even
    /// sequence.
    pub(super) fn start(&mut self, job: &Job) -> Result<Vec<Tried>> {
        let own: Vec<toml::Value> = self.knobs.iter().map(|k| k.default.clone()).collect();
        let mut start = vec![own.clone()];
        for (index, knob) in self.knobs.iter().enumerate() {
            for name in knob.names().iter().filter(|name| **name != knob.default) {
                let mut other = own.clone();
                other[index] = name.clone();
                start.push(other);
            }
        }
        let wanted = self.task.candidates as usize;
        let even = (0..self.task.candidates * DRAWS).map(|i| halton(&self.knobs, i));
        let all: Vec<Vec<toml::Value>> = start.into_iter().chain(even).collect();
        let mut tried = Vec::new();
        for values in all {
            if tried.len() + self.given_up >= wanted {
                break;
            }
            job.progress("trying", tried.len() as u64, wanted as u64)?;
            let limit = self.useful(&tried);
            tried.extend(self.first(values, &tried, limit, job)?);
        }
        Ok(tried)
    }

    /// Judges a candidate in one frame; `None` where it was there before, or takes more than `limit` x the reference.
    fn first(
        &mut self,
        mut values: Vec<toml::Value>,
        before: &[Tried],
        limit: Option<f64>,
        job: &Job,
    ) -> Result<Option<Tried>> {
        let mut settings = self.settings(&values)?;
        // What does nothing stays as it is, so that settings that come to the same are one.
        for (knob, value) in self.knobs.iter().zip(&mut values) {
            if is_idle(&knob.key, &settings) {
                *value = knob.default.clone();
            }
        }
        settings = self.settings(&values)?;
        if before.iter().any(|t| t.settings == settings) {
            return Ok(None);
        }
        let run = match self.within(limit, job) {
            None => self.frame(&settings, job),
            Some(short) => match self.frame(&settings, &short) {
                Err(Error::Cancelled) if !job.is_cancelled() => {
                    self.given_up += 1;
                    return Ok(None);
                }
                run => run,
            },
        }?;
        let picture = self.bench.mirrors(&run.products);
        let rough = self.whole_of(run.cost.wall_ms / super::median(&self.partial).max(1e-9));
        Ok(Some(Tried {
            quality: self.traced.reference.albedo_psnr(&picture)?,
            values,
            settings,
            rough,
            reckoned: Vec::new(),
            whole: Vec::new(),
        }))
    }

    /// The settings with these values of the knobs.
    fn settings(&self, values: &[toml::Value]) -> Result<Settings> {
        let mut overrides = self.task.overrides.to_vec();
        for (Knob { key, .. }, value) in self.knobs.iter().zip(values) {
            let given = format!("--keys {key}");
            overrides.push(Override::new(key, &value.to_string(), &given)?);
        }
        Ok(Scene::open(self.task.path, &overrides)?.settings)
    }

    /// The time, x the reference, above which a candidate is of no use beside those tried; `None` where any may be.
    fn useful(&self, tried: &[Tried]) -> Option<f64> {
        let reference_ms = self.reference_ms().median;
        let fastest = |of: &dyn Fn(&&Tried) -> bool| {
            let times = tried.iter().filter(of).map(|t| t.ratio().median);
            times.min_by(f64::total_cmp)
        };
        match self.task.goal {
            Goal::BudgetMs(budget) => Some((budget / reference_ms).max(fastest(&|_| true)?)),
            goal @ Goal::Quality(_) => fastest(&|t| t.does(goal, reference_ms)),
        }
    }

    /// The job, ended when a frame takes longer than is of use.
    fn within(&self, limit: Option<f64>, job: &Job) -> Option<Job> {
        let partial = (limit? - self.light) / (1.0 - self.light).max(1e-9);
        let ms = partial.max(0.0) * super::median(&self.partial) * PATIENCE;
        let deadline = Instant::now().checked_add(Duration::try_from_secs_f64(ms / 1e3).ok()?)?;
        Some(job.until(deadline))
    }

    /// Times each so many frames more, by turns, with the reference in each turn.
    pub(super) fn reckon(&mut self, tried: &mut [Tried], frames: usize, job: &Job) -> Result<()> {
        for turn in 0..frames {
            let reference = self.partial_reference(job)?;
            for candidate in &mut *tried {
                job.progress("measuring", turn as u64, frames as u64)?;
                let wall = self.frame(&candidate.settings, job)?.cost.wall_ms;
                let ratio = self.whole_of(wall / reference.max(1e-9));
                candidate.reckoned.push(ratio);
            }
        }
        Ok(())
    }

    /// Times whole frames of a candidate, by turns with the reference.
    pub(super) fn check(&mut self, candidate: &mut Tried, job: &Job) -> Result<()> {
        let [few, most] = CHECKS;
        for turn in 0..most {
            let Spread { median, min, max } = Spread::of(&candidate.whole);
            if turn >= few && max - min < STEADY * median {
                break;
            }
            job.progress("checking", turn as u64, most as u64)?;
            let reference = self.reference(job)?;
            let wall = self.bench.run(&candidate.settings, job)?.cost.wall_ms;
            candidate.whole.push(wall / reference.max(1e-9));
        }
        Ok(())
    }

    /// Turns the numbers of the best, one after the other, and keeps what is better.
    pub(super) fn near(&mut self, tried: &mut Vec<Tried>, job: &Job) -> Result<()> {
        let (mut left, knobs) = (NEAR, self.knobs.len());
        for (factors, index) in TURNS.iter().flat_map(|f| (0..knobs).map(move |i| (f, i))) {
            for &factor in factors {
                let Some(best) = tried.first().filter(|_| left > 0) else {
                    return Ok(());
                };
                let knob = &self.knobs[index];
                let turned = knob.scaled(&best.values[index], factor);
                let Some(turned) = turned.filter(|_| !is_idle(&knob.key, &best.settings)) else {
                    continue;
                };
                let mut values = best.values.clone();
                values[index] = turned;
                left -= 1;
                job.progress("trying what is near", (NEAR - left) as u64, NEAR as u64)?;
                let limit = self.useful(tried);
                let Some(candidate) = self.first(values, tried, limit, job)? else {
                    continue;
                };
                // What a first frame shows to be worse is not timed again.
                let mut pair = [candidate];
                if self.better(&pair[0], best) {
                    self.reckon(&mut pair, 2, job)?;
                }
                tried.extend(pair);
                self.sort(tried);
            }
        }
        Ok(())
    }

    /// Whether settings whose whole frames were measured are no worse than all others.
    pub(super) fn stands(&self, checked: &Tried, others: &[Tried]) -> bool {
        let mut lenient = checked.clone();
        for ratio in &mut lenient.whole {
            *ratio *= 1.0 - TIE;
        }
        !others.iter().any(|other| self.better(other, &lenient))
    }

    /// Whether `a` is better.
    fn better(&self, a: &Tried, b: &Tried) -> bool {
        let (goal, reference_ms) = (self.task.goal, self.reference_ms().median);
        let [a, b] = [a, b].map(|t| t.order(goal, reference_ms));
        a < b
    }

    /// The best first.
    pub(super) fn sort(&self, tried: &mut [Tried]) {
        let (goal, reference_ms) = (self.task.goal, self.reference_ms().median);
        tried.sort_by(|a, b| {
            let [a, b] = [a, b].map(|t| t.order(goal, reference_ms));
            a.iter()
                .zip(&b)
                .map(|(a, b)| a.total_cmp(b))
                .find(|o| o.is_ne())
                .unwrap_or(std::cmp::Ordering::Equal)
        });
    }

    /// Wall time of a whole reference frame, milliseconds.
    pub(super) fn reference_ms(&self) -> Spread {
        Spread::of(&self.references)
    }

    /// What a frame takes whole, x a whole reference, that took `partial` x the reference as candidates are timed.
    fn whole_of(&self, partial: f64) -> f64 {
        self.light + (1.0 - self.light) * partial
    }

    /// A frame as candidates are timed.
    fn frame(&mut self, settings: &Settings, job: &Job) -> Result<Run> {
        if self.unlit {
            self.bench.run_unlit(settings, job)
        } else {
            self.bench.run(settings, job)
        }
    }

    /// Wall time of one more whole reference, milliseconds.
    fn reference(&mut self, job: &Job) -> Result<f64> {
        let wall = self.bench.run(&self.traced.settings, job)?.cost.wall_ms;
        self.references.push(wall);
        Ok(wall)
    }

    /// Wall time of one more reference as candidates are timed, milliseconds.
    fn partial_reference(&mut self, job: &Job) -> Result<f64> {
        let settings = self.traced.settings.clone();
        let wall = self.frame(&settings, job)?.cost.wall_ms;
        self.partial.push(wall);
        Ok(wall)
    }
}
