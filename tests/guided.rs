//! The guided search against all roots of analytic scenes, and its cost beside the interleaved search's.

use std::time::Instant;

use catoptric::Job;
use catoptric::backend::Backend;
use catoptric::backend::cpu::Cpu;
use catoptric::camera::Camera;
use catoptric::cloud::Surfels;
use catoptric::cloud::generate::SceneName;
use catoptric::gbuffer::SplatSettings;
use catoptric::reflect::sscr::chart_class::{CHART_CLASS, chart_class};
use catoptric::reflect::sscr::charts::{Chart, LEAST_PIXELS, Seeds, charts};
use catoptric::reflect::sscr::curvature::{Axes, LhcSettings, curvature};
use catoptric::reflect::sscr::distribute::distribute;
use catoptric::reflect::sscr::field::MirrorField;
use catoptric::reflect::sscr::guided::{Guide, shorten};
use catoptric::reflect::sscr::lhc::Labeller;
use catoptric::reflect::sscr::root_find::{RootFindParams, RootFinder};
use catoptric::reflect::sscr::{Distribution, LhcMap};
use catoptric::reflect::{LabelledMirrors, Surface};
use glam::{DVec2, DVec3, UVec2, Vec3};
use libtest_mimic::Trial;
use rayon::prelude::*;

use crate::analytic::{Oracle, View};
use crate::ideal::{cloud, regions, surface};
use crate::roots::{Quality, Root, Roots, quality};

/// Random points of a scene for which all roots are known.
const POINTS: usize = 2000;

/// Surfels nearer to the mirror than this are its own, x spacing.
const SELF_HIT: f32 = 5.0;

/// What the search must reach on a scene.
#[derive(Debug, Clone, Copy)]
struct Expected {
    scene: &'static str,
    threshold: f32,
    recall: f64,
    root_recall: f64,
    median: f64,
    p95: f64,
    false_hits: f64,
    /// Cost of a correct hit, over that of the interleaved search.
    cost: f64,
    /// Recall on splatted mirrors.
    splatted: f64,
}

#[rustfmt::skip]
const EXPECTED: [Expected; 5] = [
    Expected { scene: "sphere", threshold: 2.0, recall: 0.97, root_recall: 0.97, median: 0.02, p95: 0.15, false_hits: 0.02, cost: 1.0 / 12.0, splatted: 0.95 },
    Expected { scene: "parabola", threshold: 4.0, recall: 0.99, root_recall: 0.99, median: 0.02, p95: 0.1, false_hits: 0.003, cost: 1.0 / 7.0, splatted: 0.97 },
    Expected { scene: "plane", threshold: 2.0, recall: 0.99, root_recall: 0.99, median: 0.02, p95: 0.1, false_hits: 0.01, cost: 1.0 / 20.0, splatted: 0.98 },
    Expected { scene: "torus", threshold: 3.0, recall: 0.97, root_recall: 0.95, median: 0.03, p95: 0.3, false_hits: 0.03, cost: 1.0 / 8.0, splatted: 0.97 },
    Expected { scene: "blob", threshold: 4.0, recall: 0.96, root_recall: 0.92, median: 0.03, p95: 0.4, false_hits: 0.04, cost: 1.0 / 5.0, splatted: 0.92 },
];

pub(crate) fn tests() -> Vec<Trial> {
    let mut trials = Vec::new();
    for expected in EXPECTED {
        trials.push(Trial::test(
            format!("guided::{}", expected.scene),
            move || {
                finds_every_root(&expected);
                Ok(())
            },
        ));
    }
    trials
}

/// The mirrors of a picture, ready to be searched.
struct Mirrors {
    field: MirrorField,
    charts: Vec<Chart>,
    lhc: LhcMap,
}

impl Mirrors {
    fn new(surface: &Surface<Cpu>, surfels: &Surfels) -> Self {
        let axes = Axes::Screen {
            right: Vec3::X,
            down: Vec3::NEG_Y,
        };
        let t = Instant::now();
        let cells = curvature(surface, axes, &LhcSettings::default());
        let classes = chart_class(surface, &cells);
        let t1 = t.elapsed();
        let lhc = Labeller::default()
            .label_merged(&classes, |c| c & CHART_CLASS, LEAST_PIXELS)
            .clone();
        let t2 = t.elapsed();
        let field = MirrorField::new(surface, &cells).expect("a small picture");
        let t3 = t.elapsed();
        let mut charts = charts(&field, &lhc, &Job::default()).expect("no cancellation");
        let t4 = t.elapsed();
        let sample: Vec<u32> = (0..surfels.len() as u32).collect();
        shorten(&mut charts, &field, &surfels.places, &sample);
        println!(
            "class {t1:?} label {t2:?} field {t3:?} charts {t4:?} shorten {:?}",
            t.elapsed()
        );
        Self { field, charts, lhc }
    }

    fn guide(&self) -> Guide<'_> {
        Guide {
            field: &self.field,
            charts: &self.charts,
            self_hit: SELF_HIT,
            splat_size: 1.5,
        }
    }
}

fn splatted(scene: SceneName) -> Surface<Cpu> {
    let camera = Camera {
        position: View::REFERENCE.position,
        target: View::REFERENCE.target,
        up: View::REFERENCE.up,
        fov_y_degrees: View::REFERENCE.fov_y_degrees,
        near: 0.05,
        far: 10.0,
        size: UVec2::new(800, 600),
    };
    let (pinhole, settings, job) = (
        camera.pinhole(DVec3::ZERO).unwrap(),
        SplatSettings::default(),
        Job::default(),
    );
    let mut cpu = Cpu::default();
    let points = cpu.upload(&cloud(scene, 1_600_000)).unwrap();
    let mut gbuffer = cpu.splat(&points, &pinhole, &settings, &job).unwrap();
    cpu.fill(&mut gbuffer, &settings, &job).unwrap();
    cpu.smooth(&mut gbuffer, &settings, &job).unwrap();
    Surface::of(&gbuffer)
}

fn measured(mirrors: &Mirrors, roots: &Roots, surfels: &Surfels) -> Quality {
    let guide = mirrors.guide();
    let found: Vec<(Vec<Root>, Vec<DVec2>)> = surfels
        .places
        .par_iter()
        .map(|place| {
            let hits = guide.find(place.position);
            let hits = (hits.iter())
                .map(|r| mirrors.field.pixel_of_place(r.at).as_dvec2())
                .collect();
            (roots.of(place.position.as_dvec3()), hits)
        })
        .collect();
    quality(&found)
}

fn diagnose(mirrors: &Mirrors, roots: &Roots, surfels: &Surfels) {
    let guide = mirrors.guide();
    let rows: Vec<(bool, bool, f32, f32, f32)> = surfels
        .places
        .par_iter()
        .flat_map_iter(|place| {
            let truth = roots.of(place.position.as_dvec3());
            guide
                .find(place.position)
                .into_iter()
                .map(|r| {
                    let px = mirrors.field.pixel_of_place(r.at).as_dvec2();
                    let ok = truth.iter().any(|t| t.pixel.distance(px) <= 4.0);
                    let s = mirrors.field.sample(r.at).unwrap();
                    let (x, y) = (r.at.x as u32, r.at.y as u32);
                    let edge = (0..9u32).any(|k| {
                        let (dx, dy) = (k % 3, k / 3);
                        (x + dx == 0)
                            || (y + dy == 0)
                            || !mirrors.field.is_whole(x + dx - 1, y + dy - 1)
                    });
                    let w = |dx: i32, dy: i32| {
                        let (x, y) = (x as i32 + dx, y as i32 + dy);
                        x >= 0 && y >= 0 && mirrors.field.is_whole(x as u32, y as u32)
                    };
                    let (u, v) = (r.at.x.fract(), r.at.y.fract());
                    let mut d = 2f32;
                    for (dx, dy, e) in [
                        (-1, 0, u),
                        (1, 0, 1.0 - u),
                        (0, -1, v),
                        (0, 1, 1.0 - v),
                        (-1, -1, u.max(v)),
                        (1, -1, (1.0 - u).max(v)),
                        (-1, 1, u.max(1.0 - v)),
                        (1, 1, (1.0 - u).max(1.0 - v)),
                    ] {
                        if !w(dx, dy) {
                            d = d.min(e)
                        }
                    }
                    (
                        ok,
                        edge,
                        s.ray_slope[0].length().max(s.ray_slope[1].length()),
                        d,
                        r.distance,
                    )
                })
                .collect::<Vec<_>>()
        })
        .collect();
    for ok in [true, false] {
        for edge in [true, false] {
            let mut s: Vec<_> = rows.iter().filter(|r| r.0 == ok && r.1 == edge).collect();
            s.sort_by(|a, b| a.2.total_cmp(&b.2));
            let n = s.len();
            if n > 0 {
                println!(
                    "  ok {ok} edge {edge}: {n}, slope median {} p10 {} p90 {} p99 {}",
                    s[n / 2].2,
                    s[n / 10].2,
                    s[n * 9 / 10].2,
                    s[n * 99 / 100].2
                );
                s.sort_by(|a, b| a.3.total_cmp(&b.3));
                println!(
                    "     residual median {} p90 {} p99 {} ",
                    s[n / 2].3,
                    s[n * 9 / 10].3,
                    s[n * 99 / 100].3
                );
                s.sort_by(|a, b| a.4.total_cmp(&b.4));
                println!(
                    "     distance p1 {} p10 {} median {} ",
                    s[n / 100].4,
                    s[n / 10].4,
                    s[n / 2].4
                );
            }
        }
    }
}

fn finds_every_root(expected: &Expected) {
    let view = View::REFERENCE;
    let name: SceneName = expected.scene.parse().expect("a scene");
    let oracle = Oracle::named(expected.scene);
    let hits = oracle.view(&view);
    let exact = surface(&view, &hits, 0.0);
    let roots = Roots::new(oracle, view, &hits);
    let surfels = cloud(name, POINTS);
    let mirrors = Mirrors::new(&exact, &surfels);
    let trees = mirrors
        .charts
        .iter()
        .filter(|c| matches!(c.seeds, Seeds::Tree(_)))
        .count();
    let q = measured(&mirrors, &roots, &surfels);
    println!(
        "{}: {} charts, {trees} trees, {} regions {q:?}",
        expected.scene,
        mirrors.charts.len(),
        mirrors.lhc.regions.len()
    );
    diagnose(&mirrors, &roots, &surfels);
    let noisy = Mirrors::new(&splatted(name), &surfels);
    let trees = noisy
        .charts
        .iter()
        .filter(|c| matches!(c.seeds, Seeds::Tree(_)))
        .count();
    let s = measured(&noisy, &roots, &surfels);
    println!(
        "{} splatted: {} charts, {trees} trees {s:?}",
        expected.scene,
        noisy.charts.len()
    );

    // Cost, one thread, the same points in the same order.
    let many = cloud(name, 100_000);
    let order = catoptric::cloud::along_curve(&many.places);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a thread");
    let lhc = regions(&view, &exact);
    let params = RootFindParams {
        seed_attempts: 6,
        step_attempts: 6,
        max_steps: 50,
        initial_step: 0.2,
        threshold: expected.threshold,
        self_hit: SELF_HIT,
    };
    let finder = RootFinder::new(&LabelledMirrors::new(&exact, &lhc, Vec3::X), params)
        .expect("a small picture");
    let job = Job::default();
    let time = |work: &(dyn Fn() -> u64 + Sync)| {
        let mut times: Vec<f64> = (0..5)
            .map(|_| {
                let t = Instant::now();
                let n = pool.install(work);
                t.elapsed().as_secs_f64() * 1e9 / n as f64
            })
            .collect();
        times.sort_by(f64::total_cmp);
        times[2]
    };
    let a = time(&|| {
        finder
            .search(
                &many.places,
                |i| distribute(&lhc.regions, Distribution::Weighted, i, 0),
                |_| 1.0,
                &job,
            )
            .expect("hits")
            .1
            .hit
    });
    let b = time(&|| {
        mirrors
            .guide()
            .search(&many, &order, &job)
            .expect("hits")
            .1
            .hits
    });
    let counts = mirrors.guide().search(&many, &order, &job).expect("hits").1;
    println!(
        "{}: interleaved {a:.0} ns a hit, guided {b:.0}, ratio 1/{:.1}; {:.0} ns a point; steps/pt {:.2}",
        expected.scene,
        a / b,
        b * counts.hits as f64 / 1e5,
        counts.steps as f64 / 1e5
    );
}
