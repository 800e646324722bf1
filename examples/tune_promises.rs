//! Whether `catoptric tune` keeps what it promises: the table of docs/MEASURING.md.
//!
//! `cargo run --release --example tune_promises -- KEYS SCENE ...`, where KEYS are settings that may be turned, with commas
//! between them. For each scene a quality is asked for that is 0.5 dB less than that of the scene's own settings, and a
//! budget that is 5 % less than their time; then the settings that come out are measured anew, twice a round, by turns with
//! the reference.

use std::path::Path;
use std::time::Instant;

use catoptric::Job;
use catoptric::measure::bench::{Bench, Spread, Traced};
use catoptric::measure::tune::{Goal, TuneTask, Tuned, tune};
use catoptric::renderer::BackendChoice;
use catoptric::scene::Scene;
use catoptric::settings::Settings;

/// Rounds in which settings are measured.
const ROUNDS: usize = 5;

/// By how much a promise may be missed; more only where equal settings differ by more from round to round.
const KEPT: f64 = 0.15;

#[expect(clippy::print_stdout, reason = "it is for people")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let keys = arguments.next().ok_or("name the keys, then the scenes")?;
    let keys: Vec<&str> = keys.split(',').collect();
    println!(
        "| scene | goal | took, s | settings | promised | measured | off, % | spread, % | kept |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for scene in arguments {
        let path = Path::new(&scene);
        let own = Measured::of(path, &Scene::open(path, &[])?.settings)?;
        let own_ms = own.time.median * own.reference_ms;
        for goal in [
            Goal::Quality(((own.quality - 0.5) * 10.0).round() / 10.0),
            Goal::BudgetMs((own_ms * 0.95).round()),
        ] {
            let task = TuneTask {
                path,
                overrides: &[],
                keys: &keys,
                goal,
                candidates: 24,
                backend: &BackendChoice::Cpu,
            };
            let start = Instant::now();
            let tuned = tune(&task, &Job::default())?;
            let took = start.elapsed().as_secs_f64();
            let measured = Measured::of(path, &tuned.best.settings)?;
            println!("{}", row(path, goal, took, &tuned, &measured));
        }
    }
    Ok(())
}

/// Settings, measured.
struct Measured {
    /// Of the albedo in mirrors, dB.
    quality: f64,
    /// Wall time of a frame, x that of the reference in the same round.
    time: Spread,
    /// By how much two frames of a round differ, part of the time; the largest.
    apart: f64,
    reference_ms: f64,
}

impl Measured {
    fn of(path: &Path, settings: &Settings) -> catoptric::Result<Self> {
        let job = Job::default();
        let scene = Scene::open(path, &[])?;
        let mut bench = Bench::open(&scene, &BackendChoice::Cpu, &job)?;
        let traced = Traced::render(&mut bench, &scene.settings, &job)?;
        let products = bench.run(settings, &job)?.products;
        let quality = traced.reference.albedo_psnr(&bench.mirrors(&products))?;
        let (mut ratios, mut references, mut apart) = (Vec::new(), Vec::new(), 0.0f64);
        for _ in 0..ROUNDS {
            let mut wall = |s: &Settings| bench.run(s, &job).map(|run| run.cost.wall_ms);
            let (reference, first, second) =
                (wall(&traced.settings)?, wall(settings)?, wall(settings)?);
            ratios.extend([first / reference, second / reference]);
            references.push(reference);
            apart = apart.max((first - second).abs() / first.min(second));
        }
        Ok(Self {
            quality,
            time: Spread::of(&ratios),
            apart,
            reference_ms: Spread::of(&references).median,
        })
    }
}

/// A row of the table.
fn row(path: &Path, goal: Goal, took: f64, tuned: &Tuned, measured: &Measured) -> String {
    let (promised, reference_ms) = (tuned.best.ratio().median, tuned.reference_ms.median);
    let off = measured.time.median / promised - 1.0;
    let within = off.abs() <= KEPT.max(measured.apart);
    let (wanted, does) = match goal {
        Goal::Quality(quality) => (format!("{quality} dB"), measured.quality >= quality),
        Goal::BudgetMs(budget) => (
            format!("{budget} ms ({:.3} x)", budget / reference_ms),
            measured.time.median * reference_ms <= budget * (1.0 + KEPT.max(measured.apart)),
        ),
    };
    let kept = match (tuned.reached, within && does) {
        (true, true) => "yes",
        (true, false) => "**no**",
        (false, _) if within => "said to be out of reach, and the best that was is as it says",
        (false, _) => "**no**: out of reach, and the best is not as it says",
    };
    let toml = tuned.toml();
    let settings: Vec<&str> = (toml.lines().take_while(|line| !line.starts_with("# Tried")))
        .filter(|line| line.contains(" = "))
        .collect();
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    format!(
        "| {name} | {wanted} | {took:.0} | {} | {promised:.3} x, {:.2} dB | {:.3} x, {:.2} dB | {:+.1} | {:.0} | {kept} |",
        settings.join(", "),
        tuned.best.quality,
        measured.time.median,
        measured.quality,
        off * 100.0,
        measured.apart * 100.0
    )
}
