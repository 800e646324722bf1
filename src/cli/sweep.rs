//! `catoptric sweep`: speed against accuracy over all combinations of some keys.

use std::io::Write as _;

use catoptric::Error;
use catoptric::measure::SweepReport;
use catoptric::measure::sweep::{SweepTask, Vary, sweep as measure};
use catoptric::output::Outputs;
use catoptric::scene::Override;

use super::args::{SweepArgs, ViewArgs};
use super::experiment::Experiment;
use super::folder::{check_folder, make_folder};
use super::{Usage, terminal};

/// Timed frames of each combination unless told otherwise.
const REPEATS: u32 = 5;

/// Runs what is missing, and writes the report of all.
pub(super) fn sweep(args: &SweepArgs) -> anyhow::Result<()> {
    let backend = args.place.choice()?;
    let experiment = Experiment::open(&args.scene.path)?;
    let (mut overrides, mut vary) = (Vec::new(), Vec::new());
    let mut path = args.scene.path.as_path();
    if let Some(experiment) = &experiment {
        path = &experiment.scene;
        for set in &experiment.set {
            overrides.push(Override::parse(set, &format!("set {set}"))?);
        }
        for text in &experiment.vary {
            vary.push(Vary::parse(text)?);
        }
    }
    overrides.extend(args.scene.overrides(&ViewArgs::default())?);
    for text in &args.vary {
        // What is said here takes the place of what the file says.
        let given = Vary::parse(text)?;
        vary.retain(|v: &Vary| v.key != given.key);
        vary.push(given);
    }
    if vary.is_empty() {
        return Err(Usage(
            "nothing varies; add --vary key=a,b,c, as in --vary sscr.seed_attempts=0,1,2".into(),
        )
        .into());
    }
    let repeats = args
        .repeats
        .or(experiment.as_ref().and_then(|e| e.repeats))
        .unwrap_or(REPEATS);
    let folder = args.output.as_path();
    let files = ["sweep.csv", "report.html"].map(|name| folder.join(name));

    // A wrong key is refused before the folder is made.
    let task = SweepTask {
        path,
        overrides: &overrides,
        vary: &vary,
        repeats: repeats.max(1),
        backend: &backend,
        folder,
    };
    task.check()?;
    check_folder(folder, &[&files[0], &files[1]])?;
    make_folder(folder)?;
    let (job, progress) = terminal::job()?;
    let rows = measure(&task, &job).map_err(|e| match e {
        Error::Cancelled => anyhow::anyhow!(
            "cancelled; what was measured is in {}, and the same command goes on from there",
            files[0].display()
        ),
        other => other.into(),
    })?;
    drop(progress);
    let title = experiment.as_ref().and_then(|e| e.title.clone());
    let title = title.unwrap_or_else(|| format!("{}: speed against accuracy", path.display()));
    let report = SweepReport::new(&title, &vary, &rows);
    let page = report.page()?.html();
    let mut outputs = Outputs::default();
    outputs.stage(&files[1], |file| file.write_all(page.as_bytes()))?;
    for named in report.plots() {
        let svg = named.plot.svg()?;
        outputs.stage(&folder.join(format!("{}.svg", named.name)), |file| {
            file.write_all(svg.as_bytes())
        })?;
    }
    outputs.commit(&job)?;
    std::io::stdout().write_all(report.text().as_bytes())?;
    Ok(())
}
