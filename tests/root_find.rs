//! The search against all roots of analytic scenes.

use catoptric::cloud::generate::SceneName;
use catoptric::reflect::LabelledMirrors;
use catoptric::reflect::sscr::mirror_error::{MirrorPoint, mirror_error};
use catoptric::reflect::sscr::root_find::RootFinder;
use glam::{Vec2, Vec3};
use libtest_mimic::Trial;

use crate::analytic::{Oracle, View};
use crate::ideal::{SPACING, cloud, regions, surface};
use crate::roots::Quality;
use crate::searched::{ErrorFunction, Known, Mirrors, thesis};
use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    let mut trials = Vec::new();
    for expected in EXPECTED {
        trials.push(Trial::test(
            format!("root_find::{}_is_found_as_in_the_prototype", expected.scene),
            move || {
                is_found_as_expected(&expected);
                Ok(())
            },
        ));
    }
    trials.push(claim(
        "root_find::the_error_function_as_printed_finds_nothing_right",
        the_printed_error_function_fails,
    ));
    trials.push(claim(
        "root_find::threads_do_not_change_the_hits",
        threads_do_not_change_the_hits,
    ));
    trials
}

/// Random points of a scene for which all roots are known.
const POINTS: usize = 2000;

/// A scene's settings in the thesis, and what another implementation of the corrected algorithm found with them.
#[derive(Debug, Clone, Copy)]
struct Expected {
    scene: &'static str,
    threshold: f32,
    /// Points with a hit, part of all.
    hit_rate: f64,
    /// Points with a correct hit, part of those that have a root.
    recall: f64,
}

const EXPECTED: [Expected; 5] = [
    Expected {
        scene: "sphere",
        threshold: 2.0,
        hit_rate: 0.380,
        recall: 0.477,
    },
    Expected {
        scene: "parabola",
        threshold: 4.0,
        hit_rate: 0.353,
        recall: 0.874,
    },
    Expected {
        scene: "plane",
        threshold: 2.0,
        hit_rate: 0.050,
        recall: 0.686,
    },
    Expected {
        scene: "torus",
        threshold: 3.0,
        hit_rate: 0.139,
        recall: 0.137,
    },
    Expected {
        scene: "blob",
        threshold: 4.0,
        hit_rate: 0.202,
        recall: 0.255,
    },
];

/// Searches for random points of a scene in its exact mirrors, and compares with all roots.
fn measured(scene: &str, threshold: f32, error: ErrorFunction) -> Quality {
    let view = View::REFERENCE;
    let mirrors = Mirrors::exact(scene, &view);
    Known::new(scene, &view, POINTS).quality(&mirrors, thesis(threshold), error)
}

fn is_found_as_expected(expected: &Expected) {
    let q = measured(expected.scene, expected.threshold, mirror_error);
    println!("{}: {q:?}", expected.scene);
    assert!(
        (q.hit_rate / expected.hit_rate - 1.0).abs() < 0.15,
        "{expected:?}: {q:?}"
    );
    assert!(
        (q.recall - expected.recall).abs() < 0.05,
        "{expected:?}: {q:?}"
    );
    assert!(
        q.false_hits < 0.06 && q.median < 0.5 && q.p95 < 2.5,
        "{expected:?}: {q:?}"
    );
}

/// The error function as printed in the thesis (equation 3.3), all vectors unit, in mirror space: the reflection takes
/// the eye for the point, and the eye is subtracted before the angle is taken.
fn printed(mirror: &MirrorPoint, point: Vec3) -> Vec2 {
    let space = |d: Vec3| mirror.mirror_space(d);
    let (n, eye) = (space(mirror.normal), space(mirror.to_eye));
    let from_point = space((mirror.position - point).normalize());
    let delta = from_point - n * (2.0 * n.dot(eye)) - eye;
    Vec2::new((delta.x / delta.z).atan(), (delta.y / delta.z).atan())
}

fn the_printed_error_function_fails() {
    for (scene, threshold) in [("sphere", 2.0), ("parabola", 4.0), ("plane", 2.0)] {
        let q = measured(scene, threshold, printed);
        println!("{scene}, as printed: {q:?}");
        assert!(
            q.recall < 0.05,
            "{scene}: the printed formula must find next to nothing, {q:?}"
        );
    }
}

fn threads_do_not_change_the_hits() {
    let view = View {
        width: 200,
        height: 150,
        ..View::REFERENCE
    };
    let hits = Oracle::named("torus").view(&view);
    let surface = surface(&view, &hits, 0.0);
    let lhc = regions(&view, &surface);
    let finder = RootFinder::new(&LabelledMirrors::new(&surface, &lhc, Vec3::X), thesis(4.0))
        .expect("a small picture");
    let surfels = cloud(SceneName::Torus, 30_000);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        let search = || {
            finder.search(
                &surfels.places,
                |i| (i % 2 == 0).then_some(1),
                |_| 1.0,
                &catoptric::Job::default(),
            )
        };
        pool.install(search).expect("no cancellation")
    };
    let (hits, counts) = with(1);
    assert_eq!((&hits, counts), (&with(3).0, with(3).1), "three threads");
    assert_eq!(counts.offered, 15_000, "every other point");
    assert_eq!(counts.hit as usize, hits.len(), "a hit a point");
    assert!(hits.len() > 500, "{} hits are too few to tell", hits.len());
    assert!(
        hits.windows(2).all(|w| w[0].point < w[1].point),
        "in the order of the points"
    );
    for hit in &hits {
        let point = surfels.places[hit.point as usize].position;
        assert!(hit.pixel.is_finite(), "{hit:?} of {point}");
        assert!(hit.distance >= 4.0 * SPACING, "{hit:?} is a self-hit");
    }
}
