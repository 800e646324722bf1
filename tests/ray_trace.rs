//! The traced reference against what analytic mirrors show.

use catoptric::Job;
use catoptric::backend::cpu::Cpu;
use catoptric::cloud::generate::SceneName;
use catoptric::gbuffer::SplatSettings;
use catoptric::reflect::MirrorGBuffer;
use catoptric::reflect::ray_trace::{Pixels, RayTraceSettings, RayTracer};
use catoptric::timing::Timings;
use glam::DVec3;
use libtest_mimic::Trial;
use rayon::prelude::*;

use crate::analytic::{Hit, Oracle, View, reflect};
use crate::ideal::{cloud, inside, surface};

pub(crate) fn tests() -> Vec<Trial> {
    let scenes = [
        SceneName::Sphere,
        SceneName::Parabola,
        SceneName::Plane,
        SceneName::Torus,
        SceneName::Blob,
    ];
    let trial = |scene: SceneName| {
        Trial::test(
            format!("ray_trace::{scene}_shows_what_its_mirror_shows"),
            move || {
                shows_what_the_mirror_shows(scene);
                Ok(())
            },
        )
    };
    scenes.into_iter().map(trial).collect()
}

/// How far what is traced lies from what the mirror shows.
#[derive(Debug)]
struct Differences {
    /// Metres: half are nearer.
    median: f64,
    /// 99 % are nearer.
    p99: f64,
    /// Part of the pixels that show something.
    coverage: f64,
    /// Part of the pixels that show another albedo.
    albedo: f64,
}

impl Differences {
    fn small(&self) -> bool {
        // Edges of the checkerboards are blended.
        self.median <= 0.002 && self.p99 <= 0.02 && self.coverage >= 0.99 && self.albedo <= 0.05
    }
}

/// Compares pixels two pixels inside of the mirror's outline.
fn differences(
    oracle: &Oracle,
    view: &View,
    hits: &[Hit],
    traced: &MirrorGBuffer<Cpu>,
) -> Differences {
    let pixels = inside(view, hits, 2);
    let pairs: Vec<(f64, bool, bool)> = pixels
        .par_iter()
        .map(|&i| {
            let ray = hits[i].position - view.position;
            let shown = oracle.cast(hits[i].position, reflect(ray, hits[i].normal));
            let start = traced.origin.values()[i].truncate().as_dvec3();
            let direction = traced.direction.values()[i].truncate().as_dvec3();
            let seen = start + direction * f64::from(traced.surface.values()[i].w);
            let albedo: DVec3 = traced.albedo.values()[i].truncate().as_dvec3();
            (
                seen.distance(shown.position),
                traced.material.values()[i].w > 0.0,
                albedo.distance(shown.albedo) > 0.1,
            )
        })
        .collect();
    let mut distances: Vec<f64> = pairs.iter().filter(|p| p.1).map(|p| p.0).collect();
    distances.sort_by(f64::total_cmp);
    let quantile = |part: f64| distances[((distances.len() - 1) as f64 * part) as usize];
    let part = |n: usize| n as f64 / pairs.len() as f64;
    Differences {
        median: quantile(0.5),
        p99: quantile(0.99),
        coverage: part(distances.len()),
        albedo: part(pairs.iter().filter(|p| p.2).count()),
    }
}

fn shows_what_the_mirror_shows(scene: SceneName) {
    let (view, oracle) = (View::REFERENCE, Oracle::named(scene.name()));
    let hits = oracle.view(&view);
    let surfels = cloud(scene, 1_600_000);
    let mut timings = Timings::default();
    let tracer = RayTracer::new(
        &surfels,
        &SplatSettings::default(),
        &RayTraceSettings::default(),
        &mut timings,
        &Job::default(),
    )
    .expect("a tree that fits");
    let mut trace = |tilt: f64| {
        let surface = surface(&view, &hits, tilt);
        let mut mirror = MirrorGBuffer::of(&surface);
        tracer
            .trace(
                &surface,
                &mut mirror,
                Pixels::All,
                &mut timings,
                &Job::default(),
            )
            .expect("no cancellation");
        differences(&oracle, &view, &hits, &mirror)
    };
    let found = trace(0.0);
    let tilted = trace(1.0);
    println!(
        "{scene}: {found:?}, tilted {tilted:?}, {timings:?}, {} MiB",
        tracer.memory() >> 20
    );
    assert!(found.small(), "{scene}: {found:?}");
    // Negative control.
    assert!(
        !tilted.small() && tilted.median > 0.005,
        "{scene} with normals tilted by 1 degree: {tilted:?}"
    );
}
