//! `catoptric tune`: the settings to use.

use std::io::Write as _;

use catoptric::measure::USUAL_KEYS;
use catoptric::measure::tune::{Goal, TuneTask, tune as measure};

use super::args::{TuneArgs, ViewArgs};
use super::{Usage, terminal};

/// Tunes, and writes TOML to stdout.
pub(super) fn tune(args: &TuneArgs) -> anyhow::Result<()> {
    let backend = args.place.choice()?;
    let overrides = args.scene.overrides(&ViewArgs::default())?;
    let (goal, number) = match (args.budget_ms, args.quality) {
        (Some(budget), _) => (Goal::BudgetMs(budget), budget),
        (None, Some(quality)) => (Goal::Quality(quality), quality),
        (None, None) => {
            return Err(Usage("name what is wanted: --budget-ms or --quality".into()).into());
        }
    };
    if !(number > 0.0 && number.is_finite()) {
        return Err(Usage(format!(
            "what is wanted is {number}; it must be a number above 0"
        ))
        .into());
    }
    let keys: Vec<&str> = match &args.keys {
        Some(keys) => keys.split(',').map(str::trim).collect(),
        None => USUAL_KEYS.to_vec(),
    };
    let task = TuneTask {
        path: &args.scene.path,
        overrides: &overrides,
        keys: &keys,
        goal,
        candidates: args.candidates,
        backend: &backend,
    };
    task.check().map_err(|e| match e {
        catoptric::Error::Setting(problem) => Usage(problem).into(),
        other => anyhow::Error::from(other),
    })?;
    let (job, progress) = terminal::job()?;
    let tuned = measure(&task, &job)?;
    drop(progress);
    std::io::stdout().write_all(tuned.toml().as_bytes())?;
    match tuned.missed() {
        Some(missed) => Err(anyhow::anyhow!(missed)),
        None => Ok(()),
    }
}
