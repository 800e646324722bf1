//! The guided search: against all roots of analytic scenes, and what its mirrors show beside traced rays.

use catoptric::Job;
use catoptric::cloud::along_curve;
use catoptric::cloud::generate::SceneName;
use catoptric::reflect::Surface;
use catoptric::reflect::sscr::curvature::Axes;
use catoptric::reflect::sscr::{Closing, Search};
use glam::Vec3;
use libtest_mimic::Trial;

use crate::analytic::{Oracle, View};
use crate::charted::Charted;
use crate::ideal::{cloud, surface};
use crate::rendered::{Opened, Way};
use crate::searched::Known;
use crate::shown::{Figures, Shown};
use crate::support::claim;

/// Random points of a scene for which all roots are known.
const POINTS: usize = 2000;

/// What the search must reach on a scene.
#[derive(Debug, Clone, Copy)]
struct Expected {
    scene: &'static str,
    /// Points with a correct hit, part of those that have a root; on exact mirrors.
    recall: f64,
    /// Roots with a hit, part of all.
    root_recall: f64,
    /// Distance of correct hits from their root, pixels: half are nearer.
    median: f64,
    /// 95 % are nearer.
    p95: f64,
    /// Hits that may be false, part of all.
    false_hits: f64,
    /// As `recall`, on splatted mirrors.
    splatted_recall: f64,
    /// So many points cover the mirrors to this part, before closing.
    covered_by: (usize, f64),
    /// Most that the mirrors' picture may stay behind that of traced rays, dB.
    behind_rays: f64,
}

#[rustfmt::skip]
const EXPECTED: [Expected; 5] = [
    Expected { scene: "sphere", recall: 0.97, root_recall: 0.97, median: 0.02, p95: 0.15, false_hits: 0.02, splatted_recall: 0.95, covered_by: (200_000, 0.99), behind_rays: 0.5 },
    Expected { scene: "parabola", recall: 0.99, root_recall: 0.99, median: 0.02, p95: 0.1, false_hits: 0.003, splatted_recall: 0.97, covered_by: (400_000, 0.98), behind_rays: 0.5 },
    Expected { scene: "plane", recall: 0.99, root_recall: 0.99, median: 0.02, p95: 0.1, false_hits: 0.01, splatted_recall: 0.98, covered_by: (800_000, 0.95), behind_rays: 0.5 },
    Expected { scene: "torus", recall: 0.97, root_recall: 0.95, median: 0.03, p95: 0.3, false_hits: 0.03, splatted_recall: 0.97, covered_by: (200_000, 0.95), behind_rays: 1.0 },
    Expected { scene: "blob", recall: 0.96, root_recall: 0.92, median: 0.03, p95: 0.4, false_hits: 0.04, splatted_recall: 0.92, covered_by: (200_000, 0.97), behind_rays: 1.0 },
];

/// Axes of the reference camera.
const SCREEN: Axes = Axes::Screen {
    right: Vec3::X,
    down: Vec3::NEG_Y,
};

/// How far the search whose holes are closed by rays may be behind rays alone, dB.
const HYBRID_BEHIND_RAYS: f64 = 1.0;

pub(crate) fn tests() -> Vec<Trial> {
    let mut trials = Vec::new();
    for expected in EXPECTED {
        let mut add = |claim: &str, test: fn(&Expected)| {
            let test = move || {
                test(&expected);
                Ok(())
            };
            trials.push(Trial::test(
                format!("guided::{}_{claim}", expected.scene),
                test,
            ));
        };
        add("has_every_root_found", has_every_root_found);
        add("shows_as_much_as_rays_do", shows_as_much_as_rays_do);
    }
    trials.push(claim(
        "guided::a_chart_that_is_left_out_is_missed",
        a_chart_that_is_left_out_is_missed,
    ));
    trials.push(claim(
        "guided::threads_do_not_change_the_hits",
        threads_do_not_change_the_hits,
    ));
    trials
}

/// The exact mirrors of a scene, with their charts.
fn exact(scene: &str, points: usize) -> Charted {
    let view = View::REFERENCE;
    let hits = Oracle::named(scene).view(&view);
    let name: SceneName = scene.parse().expect("a scene");
    Charted::new(&surface(&view, &hits, 0.0), SCREEN, &cloud(name, points))
}

fn has_every_root_found(expected: &Expected) {
    let scene = expected.scene;
    let known = Known::new(scene, &View::REFERENCE, POINTS);
    let charted = exact(scene, POINTS);
    let q = known.quality_by(|point| charted.find(point));
    println!("{scene}, {} charts: {q:?}", charted.charts.len());
    assert!(
        q.recall >= expected.recall && q.root_recall >= expected.root_recall,
        "{expected:?}: {q:?}"
    );
    assert!(
        q.median <= expected.median && q.p95 <= expected.p95,
        "{expected:?}: {q:?}"
    );
    assert!(q.false_hits <= expected.false_hits, "{expected:?}: {q:?}");
}

fn shows_as_much_as_rays_do(expected: &Expected) {
    let (scene, view) = (expected.scene, View::REFERENCE);
    let mut opened = Opened::generated(scene, 1_600_000, &view);
    let mut settings = opened.settings.clone();
    settings.sscr.search = Search::Guided;
    let guided = opened.render(&settings);
    let traced = opened.by(Way::RayTrace);
    let truth = Shown::new(&Oracle::named(scene), &view);
    let [sscr, rays] = [&guided, &traced].map(|products| {
        let mirror = products.mirror.as_ref().expect("the camera sees a mirror");
        Figures::of(&truth, mirror)
    });
    println!(
        "{scene}: {:?}\n{scene}: {sscr:?}, rays {rays:?}",
        guided.bounces[0]
    );
    assert!(
        sscr.psnr >= rays.psnr - expected.behind_rays,
        "{scene}: {:.2} dB, rays {:.2} dB",
        sscr.psnr,
        rays.psnr
    );
    assert!(
        sscr.psnr > sscr.moved,
        "{scene}: the truth one pixel off is as good, {sscr:?}"
    );

    // With holes and doubtful pixels closed by rays.
    settings.sscr.closing = Closing::Rays;
    let hybrid = opened.render(&settings).mirror;
    let hybrid = Figures::of(&truth, &hybrid.expect("the camera sees a mirror"));
    println!("{scene}, closed by rays: {hybrid:?}");
    assert!(
        hybrid.psnr >= rays.psnr - HYBRID_BEHIND_RAYS,
        "{scene}: {:.2} dB closed by rays, rays alone {:.2} dB",
        hybrid.psnr,
        rays.psnr
    );
    settings.sscr.closing = Closing::PullPush;

    // Fewer points cover the mirrors, too.
    let (points, covered) = expected.covered_by;
    let surface = Surface::of(&guided.gbuffer);
    settings.sscr.points_per_pixel = points as f32 / surface.pixels() as f32;
    let few = &opened.render(&settings).bounces[0];
    println!("{scene}: {few:?}");
    assert!(few.coverage >= covered, "{expected:?}: {few:?}");

    // Splatted mirrors are noisy.
    let surfels = &opened.loaded.surfels;
    let charted = Charted::new(
        &surface,
        Axes::from(&guided.gbuffer.pinhole),
        &cloud_of(surfels),
    );
    let known = Known::of(scene, &view, &surfels.places[..POINTS]);
    let q = known.quality_by(|point| charted.find(point));
    println!("{scene}, splatted, {} charts: {q:?}", charted.charts.len());
    assert!(q.recall >= expected.splatted_recall, "{expected:?}: {q:?}");
}

/// The first few thousand points of a cloud.
fn cloud_of(surfels: &catoptric::cloud::Surfels) -> catoptric::cloud::Surfels {
    let mut few = surfels.clone();
    few.places.truncate(POINTS);
    few.finishes.truncate(POINTS);
    few
}

/// Negative control of the recall.
fn a_chart_that_is_left_out_is_missed() {
    let known = Known::new("torus", &View::REFERENCE, 500);
    let mut charted = exact("torus", POINTS);
    assert!(charted.charts.len() >= 2, "bowl and saddle");
    let whole = known.quality_by(|point| charted.find(point));
    charted.charts.truncate(1);
    let half = known.quality_by(|point| charted.find(point));
    assert!(
        whole.root_recall > 0.95 && half.root_recall < 0.8,
        "{whole:?}, without one chart {half:?}"
    );
}

fn threads_do_not_change_the_hits() {
    let charted = exact("blob", POINTS);
    let surfels = cloud(SceneName::Blob, 20_000);
    let order = along_curve(&surfels.places);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        let search = || charted.guide().search(&surfels, &order, &Job::default());
        pool.install(search).expect("no cancellation")
    };
    let (hits, counts) = with(1);
    assert_eq!((&hits, counts), (&with(3).0, with(3).1), "three threads");
    assert_eq!(counts.hits as usize, hits.len(), "every hit is counted");
    assert!(
        hits.len() > 10_000,
        "{} hits are too few to tell",
        hits.len()
    );
}
