//! All combinations of the values of some keys, each rendered again and again and judged.

use std::path::Path;

use super::bench::{Bench, Quality, Traced};
use super::journal::{Header, Journal};
use super::row::Row;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::renderer::BackendChoice;
use crate::scene::{Override, Scene};
use crate::settings::Settings;

/// The most combinations that are run; more are a mistake.
pub const MAX_COMBINATIONS: usize = 10_000;

/// A key and the values that it is to have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Vary {
    /// Dotted name, as for [`Override`].
    pub key: String,
    /// At least one.
    pub values: Vec<String>,
}

impl Vary {
    /// Reads `key=a,b,c`, or `key=1,2;3,4` where values hold commas themselves.
    ///
    /// # Errors
    /// [`Error::Override`] where that is not what it says.
    pub fn parse(text: &str) -> Result<Self> {
        let wrong = |problem: &str| Error::Override {
            given: format!("--vary {text}"),
            problem: problem.into(),
        };
        let usage = "write key=a,b,c, as in sscr.seed_attempts=0,1,2, or key=0,0,1;0,0,2 for values with commas";
        let (key, values) = text.split_once('=').ok_or_else(|| wrong(usage))?;
        let split = if values.contains(';') { ';' } else { ',' };
        let values: Vec<String> = values.split(split).map(|v| v.trim().to_owned()).collect();
        if key.trim().is_empty() || values.iter().any(String::is_empty) {
            return Err(wrong(usage));
        }
        if (1..values.len()).any(|i| values[..i].contains(&values[i])) {
            return Err(wrong("gives a value twice; leave one out"));
        }
        Ok(Self {
            key: key.trim().to_owned(),
            values,
        })
    }
}

/// Every combination of one value of each key, the last key changing fastest.
pub fn combinations(vary: &[Vary]) -> Vec<Vec<String>> {
    vary.iter().fold(vec![Vec::new()], |all, key| {
        (all.iter())
            .flat_map(|before| {
                key.values.iter().map(|value| {
                    let mut next = before.clone();
                    next.push(value.clone());
                    next
                })
            })
            .collect()
    })
}

/// What is swept over, and how.
pub struct SweepTask<'a> {
    /// The scene's file.
    pub path: &'a Path,
    /// What is said on top of it, for all combinations.
    pub overrides: &'a [Override],
    /// The keys that vary, each once.
    pub vary: &'a [Vary],
    /// Timed frames of each combination, in turn.
    pub repeats: u32,
    /// Where to render.
    pub backend: &'a BackendChoice,
    /// Where sweep.jsonl and sweep.csv grow.
    pub folder: &'a Path,
}

impl SweepTask<'_> {
    /// Whether every combination is a sound scene, to be asked before long work.
    ///
    /// # Errors
    /// [`Error::Override`] and [`Error::Scene`] for a wrong key or value, [`Error::Setting`] for too many combinations.
    pub fn check(&self) -> Result<()> {
        groups(self).map(drop)
    }
}

/// A combination that is to be run.
struct Combination {
    index: usize,
    values: Vec<String>,
    settings: Settings,
}

/// Runs what has not been run yet, and gives all rows, those of earlier runs among them.
///
/// Combinations of one cloud, light and camera take turns, so that a noisy moment meets all. Every row is written before
/// the next frame begins.
///
/// # Errors
/// What rendering meets; [`Error::Setting`] where the folder holds another sweep; [`Error::Override`] for a wrong key or
/// value, before anything runs.
pub fn sweep(task: &SweepTask<'_>, job: &Job) -> Result<Vec<Row>> {
    let base = Scene::open(task.path, task.overrides)?;
    let groups = groups(task)?;
    let mut journal = Journal::open(task.folder, &Header::new(task, &base)?)?;
    let total: u64 =
        groups.iter().map(|(_, c)| c.len() as u64).sum::<u64>() * u64::from(task.repeats);
    let mut done = 0;
    for (scene, combinations) in &groups {
        let is_missing = |journal: &Journal, c: &Combination| {
            (0..task.repeats).any(|round| !journal.holds(c.index, round))
        };
        let missing: Vec<&Combination> = combinations
            .iter()
            .filter(|c| is_missing(&journal, c))
            .collect();
        done += (combinations.len() - missing.len()) as u64 * u64::from(task.repeats);
        if missing.is_empty() {
            continue;
        }
        job.progress("sweeping", done, total)?;
        let mut bench = Bench::open(scene, task.backend, job)?;
        let traced = Traced::render(&mut bench, &base.settings, job)?;
        // What a combination shows is always the same: it is judged once, in a frame that is not timed.
        let mut judged = Vec::with_capacity(missing.len());
        for combination in &missing {
            job.progress("warming up", done, total)?;
            let run = bench.run(&combination.settings, job)?;
            judged.push((
                traced.quality(&bench, &run.products)?,
                run.products.bounces.clone(),
            ));
        }
        for round in 0..task.repeats {
            let reference_ms = bench.run(&traced.settings, job)?.cost.wall_ms;
            for (combination, (quality, bounces)) in missing.iter().zip(&judged) {
                job.progress("sweeping", done, total)?;
                done += 1;
                if journal.holds(combination.index, round) {
                    continue;
                }
                let cost = bench.run(&combination.settings, job)?.cost;
                let quality: Quality = *quality;
                let mut row = Row::new(cost, reference_ms, quality, bounces.first());
                row.combination = combination.index;
                row.round = round;
                row.values.clone_from(&combination.values);
                row.settings = combination.settings.changed().into_iter().collect();
                row.points = bench.facts().points;
                bench.backend().clone_into(&mut row.backend);
                row.adapter = bench.adapter();
                journal.append(row)?;
            }
        }
    }
    Ok(journal.into_rows())
}

/// The combinations, those together that differ in settings alone; each is checked.
fn groups(task: &SweepTask<'_>) -> Result<Vec<(Scene, Vec<Combination>)>> {
    let number = task
        .vary
        .iter()
        .try_fold(1usize, |n, v| n.checked_mul(v.values.len()))
        .filter(|n| *n <= MAX_COMBINATIONS);
    if number.is_none() {
        return Err(Error::Setting(format!(
            "the values make more than {MAX_COMBINATIONS} combinations; vary fewer keys at a time"
        )));
    }
    let mut groups: Vec<(Scene, Vec<Combination>)> = Vec::new();
    for (index, values) in combinations(task.vary).into_iter().enumerate() {
        let mut overrides = task.overrides.to_vec();
        for (vary, value) in task.vary.iter().zip(&values) {
            let given = format!("--vary {}={value}", vary.key);
            overrides.push(Override::new(&vary.key, value, &given)?);
        }
        let scene = Scene::open(task.path, &overrides)?;
        let combination = Combination {
            index,
            values,
            settings: scene.settings.clone(),
        };
        match groups.iter_mut().find(|(of, _)| of.shows_the_same(&scene)) {
            Some((_, members)) => members.push(combination),
            None => groups.push((scene, vec![combination])),
        }
    }
    Ok(groups)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_key_changes_fastest() {
        let vary = ["a=1,2", "b=x"].map(|text| Vary::parse(text).expect("sound"));
        assert_eq!(combinations(&vary), [["1", "x"], ["2", "x"]]);
        let places = Vary::parse("camera.position=0,0,1; 0,0,2").expect("sound");
        assert_eq!(places.values, ["0,0,1", "0,0,2"]);
    }

    #[test]
    fn what_is_no_list_is_refused() {
        for text in ["", "a", "=1", "a=", "a=1,,2", "a=1,1"] {
            assert!(Vary::parse(text).is_err(), "{text:?}");
        }
    }
}
