//! The settings to use: the best picture in a given time, or a given quality in the shortest.
//!
//! Candidates that fill the space of the settings evenly are judged by a frame each. The better ones stay and are measured
//! more often, until few are left [Karnin, Koren, Somekh 2013]; then what is near the best is tried, and the winner is
//! measured anew, so that what is promised is not what happened to be fast once.

use std::path::Path;

use super::bench::Spread;
use super::knobs::Knob;
use super::tuner::Tuner;
use crate::error::Result;
use crate::job::Job;
use crate::renderer::BackendChoice;
use crate::scene::{Override, Scene};
use crate::settings::Settings;

/// Candidates that are measured again after their first frame, and how often in all.
const RUNGS: [(usize, usize); 2] = [(6, 1), (3, 3)];

/// Settings of which whole frames are measured at most, until the best stands.
const CHECKED: usize = 3;

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
    /// All settings.
    pub settings: Settings,
    /// PSNR of the albedo in mirrors, dB.
    pub quality: f64,
    /// Wall time of the first frame, x that of a reference: a first guess.
    pub(super) rough: f64,
    /// Wall time of each frame, x that of the reference beside it; reckoned from frames without light.
    pub(super) reckoned: Vec<f64>,
    /// The same, of whole frames.
    pub(super) whole: Vec<f64>,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuned {
    pub(super) knobs: Vec<Knob>,
    pub(super) goal: Goal,
    /// Whether the best does what was wanted.
    pub reached: bool,
    /// The best, of which whole frames were measured.
    pub best: Tried,
    /// All others, the best first.
    pub tried: Vec<Tried>,
    /// Settings whose first frame was given up as too slow.
    pub given_up: usize,
    /// Wall time of a reference frame, milliseconds.
    pub reference_ms: Spread,
}

impl Tried {
    /// Wall time of a frame, x that of the reference.
    pub fn ratio(&self) -> Spread {
        match (self.whole.as_slice(), self.reckoned.as_slice()) {
            ([], []) => Spread::of(&[self.rough]),
            ([], reckoned) => Spread::of(reckoned),
            (whole, _) => Spread::of(whole),
        }
    }

    /// Whether this one is what is wanted.
    pub(super) fn does(&self, goal: Goal, reference_ms: f64) -> bool {
        match goal {
            Goal::BudgetMs(budget) => self.ratio().median * reference_ms <= budget,
            Goal::Quality(quality) => self.quality >= quality,
        }
    }

    /// Smaller is better.
    pub(super) fn order(&self, goal: Goal, reference_ms: f64) -> [f64; 3] {
        let time = self.ratio().median;
        let misses = !self.does(goal, reference_ms);
        let [first, second] = match (goal, misses) {
            (Goal::BudgetMs(_), false) | (Goal::Quality(_), true) => [-self.quality, time],
            (Goal::BudgetMs(_), true) | (Goal::Quality(_), false) => [time, -self.quality],
        };
        [f64::from(u8::from(misses)), first, second]
    }
}

/// Finds the settings to use.
///
/// # Errors
/// [`crate::Error::Setting`] for keys that cannot be tuned, and what rendering meets.
pub fn tune(task: &TuneTask<'_>, job: &Job) -> Result<Tuned> {
    let mut tuner = Tuner::open(task, job)?;
    let mut tried = tuner.start(job)?;
    for (few, frames) in RUNGS {
        tuner.sort(&mut tried);
        let few = few.min(tried.len());
        tuner.reckon(&mut tried[..few], frames, job)?;
    }
    tuner.sort(&mut tried);
    tuner.near(&mut tried, job)?;

    // The promise is measured anew, since the best of many is often only the luckiest: whoever is best then, stands.
    for _ in 0..CHECKED {
        tuner.sort(&mut tried);
        let unchecked = tried.iter().position(|t| t.whole.is_empty());
        let Some(next) = unchecked.map(|i| tried.remove(i)) else {
            break;
        };
        let mut next = [next];
        tuner.check(&mut next[0], job)?;
        let stands = tuner.stands(&next[0], &tried);
        tried.extend(next);
        if stands {
            break;
        }
    }
    tuner.sort(&mut tried);
    let checked = tried.iter().position(|t| !t.whole.is_empty());
    let best = tried.remove(checked.unwrap_or_default());
    let reference_ms = tuner.reference_ms();
    Ok(Tuned {
        reached: best.does(task.goal, reference_ms.median),
        goal: task.goal,
        best,
        tried,
        reference_ms,
        given_up: tuner.given_up,
        knobs: tuner.knobs,
    })
}
