//! `catoptric compare`: named settings side by side.

use std::io::Write as _;
use std::path::Path;

use catoptric::Job;
use catoptric::image::Background;
use catoptric::measure::Variant;
use catoptric::measure::compare::{Comparison, Task, compare as measure};
use catoptric::measure::truth::Truth;
use catoptric::output::{Outputs, encode_png};
use catoptric::scene::Scene;

use super::args::{CompareArgs, ViewArgs};
use super::folder::{check_folder, make_folder};
use super::{Usage, terminal};

/// Measures, says it, and writes the report where a folder is named.
pub(super) fn compare(args: &CompareArgs) -> anyhow::Result<()> {
    let backend = args.place.choice()?;
    let overrides = args.scene.overrides(&ViewArgs::default())?;
    let variants = if args.variants.is_empty() {
        Variant::usual()?
    } else {
        let parse = |text: &String| Variant::parse(text);
        args.variants.iter().map(parse).collect::<Result<_, _>>()?
    };
    for (i, variant) in variants.iter().enumerate() {
        if variant.name == "reference" || variants[..i].iter().any(|v| v.name == variant.name) {
            let problem = format!(
                "two variants are called {:?}; \"reference\" is taken, too",
                variant.name
            );
            return Err(Usage(problem).into());
        }
    }
    // What is wrong with the scene is said before others' files are read.
    Scene::open(&args.scene.path, &overrides)?;
    if let Some(folder) = &args.output {
        let files = ["report.html", "compare.json"].map(|name| folder.join(name));
        check_folder(folder, &[&files[0], &files[1]])?;
    }
    let mut truths = Vec::with_capacity(args.truths.len());
    for path in &args.truths {
        let name = path.file_name().unwrap_or(path.as_os_str());
        truths.push((name.to_string_lossy().into_owned(), Truth::read(path)?));
    }
    let (job, progress) = terminal::job()?;
    let task = Task {
        path: &args.scene.path,
        overrides: &overrides,
        variants: &variants,
        truths: &truths,
        repeats: args.repeats,
        precision: args.precision,
        backend: &backend,
    };
    let comparison = measure(&task, &job)?;
    drop(progress);
    if let Some(folder) = &args.output {
        write(folder, &comparison, &job)?;
    }
    std::io::stdout().write_all(comparison.text().as_bytes())?;
    Ok(())
}

fn write(folder: &Path, comparison: &Comparison, job: &Job) -> catoptric::Result<()> {
    let page = comparison.page(job)?.html();
    make_folder(folder)?;
    let mut outputs = Outputs::default();
    outputs.stage(&folder.join("report.html"), |file| {
        file.write_all(page.as_bytes())
    })?;
    outputs.stage_json(&folder.join("compare.json"), comparison)?;
    for (index, variant) in comparison.variants.iter().enumerate() {
        for (what, picture) in &variant.pictures {
            let name = format!(
                "{index}-{}-{}.png",
                file_name(&variant.name),
                file_name(what)
            );
            outputs.stage(&folder.join(name), |file| {
                encode_png(file, picture, Background::Transparent, job)
            })?;
        }
    }
    outputs.commit(job)
}

/// A part of a file's name for a name of any letters.
fn file_name(name: &str) -> String {
    let letters = name
        .chars()
        .take(40)
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' });
    letters.collect()
}
