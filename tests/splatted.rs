//! The interleaved search with the thesis's settings on splatted mirrors of 1.6 million points, against all roots of
//! analytic scenes, and beside traced rays over the same surfels.

use catoptric::reflect::Method;
use catoptric::reflect::sscr::Search;
use catoptric::reflect::sscr::mirror_error::mirror_error;
use catoptric::reflect::sscr::root_find::RootFindParams;
use catoptric::settings::Settings;
use libtest_mimic::Trial;

use crate::analytic::{Oracle, View};
use crate::rendered::{Opened, Way};
use crate::searched::{Known, Mirrors};
use crate::shown::{Figures, Shown};

pub(crate) fn tests() -> Vec<Trial> {
    let trial = |expected: Expected| {
        Trial::test(
            format!(
                "splatted::{}_is_searched_as_well_as_the_thesis_does_and_shows_as_much_as_rays",
                expected.scene
            ),
            move || {
                holds(&expected);
                Ok(())
            },
        )
    };
    EXPECTED.into_iter().map(trial).collect()
}

/// Points of a scene for which all roots are known.
const SAMPLE: usize = 2000;

/// A scene's settings in the thesis, and what another implementation of the corrected algorithm found with them.
#[derive(Debug, Clone, Copy)]
struct Expected {
    scene: &'static str,
    threshold: f32,
    max_splat: f32,
    pull_levels: u32,
    /// Points with a hit, part of all.
    hit_rate: f64,
    /// Points with a correct hit, part of those that have a root; measured on exact mirrors.
    recall: f64,
    /// Least part of the mirrors' pixels that show something before closing.
    coverage: f64,
    /// Most hits that may be false, part of all.
    false_hits: f64,
    /// Metres within which rays find half of what is seen.
    rays_median: f64,
    /// Most that the mirrors' picture may stay behind that of traced rays, dB.
    behind_rays: f64,
}

const EXPECTED: [Expected; 5] = [
    Expected {
        scene: "sphere",
        threshold: 2.0,
        max_splat: 2.0,
        pull_levels: 4,
        hit_rate: 0.38,
        recall: 0.477,
        coverage: 0.97,
        false_hits: 0.06,
        rays_median: 0.01,
        behind_rays: 2.0,
    },
    Expected {
        scene: "parabola",
        threshold: 4.0,
        max_splat: 3.0,
        pull_levels: 4,
        hit_rate: 0.35,
        recall: 0.874,
        coverage: 0.97,
        false_hits: 0.06,
        rays_median: 0.01,
        behind_rays: 2.0,
    },
    Expected {
        scene: "plane",
        threshold: 2.0,
        max_splat: 2.0,
        pull_levels: 4,
        hit_rate: 0.05,
        recall: 0.686,
        coverage: 0.97,
        false_hits: 0.06,
        rays_median: 0.01,
        behind_rays: 2.0,
    },
    Expected {
        scene: "torus",
        threshold: 3.0,
        max_splat: 2.0,
        pull_levels: 3,
        hit_rate: 0.14,
        recall: 0.137,
        coverage: 0.90,
        // 6.5 % of a larger sample. Half of them lie on outlines, which splats move, and without them coverage falls
        // below its bound.
        false_hits: 0.08,
        // Tight bends magnify what is left of the normals' noise.
        rays_median: 0.02,
        behind_rays: 5.0,
    },
    Expected {
        scene: "blob",
        threshold: 4.0,
        max_splat: 3.0,
        pull_levels: 4,
        hit_rate: 0.20,
        recall: 0.255,
        coverage: 0.90,
        false_hits: 0.06,
        rays_median: 0.01,
        behind_rays: 6.0,
    },
];

impl Expected {
    /// The thesis's settings.
    fn settings(&self) -> Settings {
        let mut settings = Settings::default();
        settings.reflect.method = Method::Sscr;
        settings.sscr.search = Search::Interleaved;
        settings.sscr.seed_attempts = 6;
        settings.sscr.step_attempts = 6;
        settings.sscr.max_steps = 50;
        settings.sscr.initial_step = 0.2;
        settings.sscr.threshold = self.threshold;
        settings.sscr.max_splat = self.max_splat;
        settings.sscr.pull_levels = self.pull_levels;
        settings
    }
}

fn holds(expected: &Expected) {
    let scene = expected.scene;
    let view = View::REFERENCE;
    let mut opened = Opened::generated(scene, 1_600_000, &view);
    let settings = expected.settings();

    // Both methods, one after the other, on the same surfels.
    let searched_for = opened.render(&settings);
    let traced = opened.by(Way::RayTrace);
    let truth = Shown::new(&Oracle::named(scene), &view);
    let [sscr, rays] = [&searched_for, &traced].map(|products| {
        let mirror = products.mirror.as_ref().expect("the camera sees a mirror");
        Figures::of(&truth, mirror)
    });
    let bounce = &searched_for.bounces[0];
    let mirrors = Mirrors::splatted(&searched_for.gbuffer, &settings.lhc);
    let known = Known::of(scene, &view, &opened.loaded.surfels.places[..SAMPLE]);
    let q = known.quality(&mirrors, RootFindParams::from(&settings.sscr), mirror_error);
    println!("{scene}: {bounce:?}\n{scene}: {q:?}\n{scene}: {sscr:?}, rays {rays:?}");

    assert!(
        (bounce.hit_rate / expected.hit_rate - 1.0).abs() <= 0.15,
        "{expected:?}: {bounce:?}"
    );
    assert!(
        bounce.coverage >= expected.coverage,
        "{expected:?}: {bounce:?}"
    );
    assert!(
        (q.recall - expected.recall).abs() <= 0.05,
        "{expected:?}: {q:?}"
    );
    assert!(
        q.false_hits <= expected.false_hits && q.median <= 0.5,
        "{expected:?}: {q:?}"
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
    assert!(
        rays.median <= expected.rays_median,
        "{scene}, rays: {rays:?}"
    );
}
