//! What the CPU's stages cost: `cargo bench`. Compare by ratio within one run; docs/PERFORMANCE.md keeps the figures.

use catoptric::camera::{Camera, Pinhole};
use catoptric::cloud::generate::{SceneName, generate};
use catoptric::cloud::{Surfels, prepare};
use catoptric::gbuffer::SplatSettings;
use catoptric::gbuffer::splat::Splatter;
use catoptric::job::Job;
use catoptric::timing::Timings;
use divan::Bencher;
use divan::counter::ItemsCount;
use glam::{DVec3, UVec2};

fn main() {
    divan::main();
}

/// Numbers of points over which cost is followed.
const POINTS: [usize; 5] = [100_000, 400_000, 1_600_000, 4_000_000, 10_000_000];

/// The sphere scene.
#[expect(clippy::expect_used, reason = "a bench may fail by panic")]
fn sphere(points: usize) -> Surfels {
    let job = Job::default();
    let raw = generate(SceneName::Sphere, points, 1, None, &job).expect("the sphere scene");
    prepare(vec![raw.into()], DVec3::ZERO, &job)
        .expect("sound points")
        .surfels
}

/// Its camera at 800x600.
#[expect(clippy::expect_used, reason = "a bench may fail by panic")]
fn camera() -> Pinhole {
    let camera = Camera {
        position: DVec3::new(0.0, 0.0, 0.9),
        target: DVec3::ZERO,
        up: DVec3::Y,
        fov_y_degrees: 60.0,
        near: 0.05,
        far: 10.0,
        size: UVec2::new(800, 600),
    };
    camera.pinhole(DVec3::ZERO).expect("a sound camera")
}

/// Passes depth, visibility and average.
#[divan::bench(args = POINTS, sample_count = 9)]
fn camera_gbuffer(bencher: Bencher<'_, '_>, points: usize) {
    let (surfels, pinhole, settings) = (sphere(points), camera(), SplatSettings::default());
    let mut splatter = Splatter::default();
    bencher.counter(ItemsCount::new(points)).bench_local(|| {
        splatter.splat(
            &surfels,
            &pinhole,
            &settings,
            &mut Timings::default(),
            &Job::default(),
        )
    });
}

/// Pass depth alone: what the three passes are compared with.
#[divan::bench(args = POINTS, sample_count = 9)]
fn nearest_only(bencher: Bencher<'_, '_>, points: usize) {
    let (surfels, pinhole, settings) = (sphere(points), camera(), SplatSettings::default());
    let mut splatter = Splatter::default();
    bencher
        .counter(ItemsCount::new(points))
        .bench_local(|| splatter.depth_keys(&surfels, &pinhole, &settings, &Job::default()));
}
