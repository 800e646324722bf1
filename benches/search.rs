//! What a hit costs: `cargo bench --bench search`. Both searches on the exact mirrors of the reference scenes, one thread, the
//! same points; the rate is hits a second. Compare by ratio within one run.

#[allow(dead_code, reason = "the oracle knows more than this needs")]
#[path = "../tests/analytic.rs"]
mod analytic;
#[allow(
    dead_code,
    clippy::expect_used,
    reason = "serves the tests, too; a bench may fail by panic"
)]
#[path = "../tests/charted.rs"]
mod charted;
#[allow(dead_code, reason = "the oracle knows more than this needs")]
#[path = "../tests/forms.rs"]
mod forms;
#[allow(
    dead_code,
    clippy::expect_used,
    reason = "serves the tests, too; a bench may fail by panic"
)]
#[path = "../tests/ideal.rs"]
mod ideal;

use catoptric::Job;
use catoptric::cloud::along_curve;
use catoptric::cloud::generate::SceneName;
use catoptric::reflect::LabelledMirrors;
use catoptric::reflect::sscr::Distribution;
use catoptric::reflect::sscr::curvature::Axes;
use catoptric::reflect::sscr::distribute::distribute;
use catoptric::reflect::sscr::root_find::{RootFindParams, RootFinder};
use divan::Bencher;
use divan::counter::ItemsCount;
use glam::Vec3;
use rayon::ThreadPool;

use analytic::{Oracle, View};
use charted::Charted;

const POINTS: usize = 100_000;

/// Scenes, each with the thesis's threshold.
const SCENES: [(SceneName, f32); 5] = [
    (SceneName::Sphere, 2.0),
    (SceneName::Parabola, 4.0),
    (SceneName::Plane, 2.0),
    (SceneName::Torus, 3.0),
    (SceneName::Blob, 4.0),
];

fn main() {
    divan::main();
}

#[expect(clippy::expect_used, reason = "a bench may fail by panic")]
fn one_thread() -> ThreadPool {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.expect("a thread")
}

/// The search of the thesis, with its settings: every point in one region.
#[divan::bench(args = SCENES, sample_count = 5, sample_size = 1)]
#[expect(clippy::expect_used, reason = "a bench may fail by panic")]
fn interleaved(bencher: Bencher<'_, '_>, (scene, threshold): (SceneName, f32)) {
    let view = View::REFERENCE;
    let surface = ideal::surface(&view, &Oracle::named(scene.name()).view(&view), 0.0);
    let lhc = ideal::regions(&view, &surface);
    let params = RootFindParams {
        seed_attempts: 6,
        step_attempts: 6,
        max_steps: 50,
        initial_step: 0.2,
        threshold,
        self_hit: 5.0,
    };
    let mirrors = LabelledMirrors::new(&surface, &lhc, Vec3::X);
    let finder = RootFinder::new(&mirrors, params).expect("a small picture");
    let (cloud, pool) = (ideal::cloud(scene, POINTS), one_thread());
    let region = |point| distribute(&lhc.regions, Distribution::Weighted, point, 0);
    let search = || {
        pool.install(|| finder.search(&cloud.places, region, |_| 1.0, &Job::default()))
            .expect("no cancellation")
    };
    let hits = search().0.len();
    bencher.counter(ItemsCount::new(hits)).bench(search);
}

/// Every place where the mirrors show each point.
#[divan::bench(args = SCENES, sample_count = 5, sample_size = 1)]
#[expect(clippy::expect_used, reason = "a bench may fail by panic")]
fn guided(bencher: Bencher<'_, '_>, (scene, _): (SceneName, f32)) {
    let view = View::REFERENCE;
    let surface = ideal::surface(&view, &Oracle::named(scene.name()).view(&view), 0.0);
    let axes = Axes::Screen {
        right: Vec3::X,
        down: Vec3::NEG_Y,
    };
    let charted = Charted::new(&surface, axes, &ideal::cloud(scene, 2000));
    let (cloud, pool) = (ideal::cloud(scene, POINTS), one_thread());
    let order = along_curve(&cloud.places);
    let search = || {
        pool.install(|| charted.guide().search(&cloud, &order, &Job::default()))
            .expect("no cancellation")
    };
    let hits = search().0.len();
    bencher.counter(ItemsCount::new(hits)).bench(search);
}
