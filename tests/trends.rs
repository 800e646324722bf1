//! What the settings of the search trade, as the thesis's figures 5.4, 5.5, 5.8 and 5.9 show it [Preiner 2010].

use catoptric::cloud::generate::SceneName;
use catoptric::reflect::sscr::mirror_error::mirror_error;
use catoptric::reflect::sscr::root_find::RootFindParams;
use glam::DVec3;
use libtest_mimic::Trial;

use crate::analytic::{Oracle, View};
use crate::ideal::cloud;
use crate::rendered::Opened;
use crate::searched::{Known, Mirrors, thesis};
use crate::shown::{Figures, Shown};
use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    let attempts = SCENES.map(|(scene, threshold)| {
        let name = format!("trends::the_first_two_attempts_gain_most_on_{scene}");
        Trial::test(name, move || {
            the_first_two_attempts_gain_most(scene, threshold);
            Ok(())
        })
    });
    let mut trials = Vec::from(attempts);
    trials.extend([
        claim(
            "trends::small_first_steps_cost_large_regions_and_hardly_small_ones",
            small_first_steps_cost_large_regions,
        ),
        claim(
            "trends::every_pull_level_closes_more_and_shows_more",
            every_pull_level_closes_more,
        ),
    ]);
    trials
}

/// Points whose search is counted.
const POINTS: usize = 40_000;

/// Points of those whose roots are known as well.
const SAMPLE: usize = 500;

/// The thesis's thresholds; "bumps" takes the place of its bunny.
const SCENES: [(&str, f32); 3] = [("sphere", 2.0), ("torus", 3.0), ("bumps", 2.0)];

const ATTEMPTS: [u32; 5] = [0, 1, 2, 4, 6];

/// Whether each value is at least the one before, and the first two attempts bring so large a share of all that is gained.
fn saturates(values: &[f64], share: f64) -> bool {
    let (first, second, last) = (values[0], values[2], values[values.len() - 1]);
    let rises = values.windows(2).all(|w| w[1] >= w[0] - 1e-3);
    rises && last > first && second - first >= share * (last - first)
}

/// Figures 5.4 and 5.5. The thesis's sphere and torus lose a little from the third step attempt on, ours do not.
fn the_first_two_attempts_gain_most(scene: &str, threshold: f32) {
    let view = View::REFERENCE;
    let mirrors = Mirrors::exact(scene, &view);
    let places = &cloud(scene.parse().expect("a scene"), POINTS).places;
    let known = Known::of(scene, &view, &places[..SAMPLE]);
    let of_seeds = |seed_attempts| RootFindParams {
        seed_attempts,
        ..thesis(threshold)
    };
    let of_steps = |step_attempts| RootFindParams {
        step_attempts,
        ..thesis(threshold)
    };
    let kinds: [(&str, &dyn Fn(u32) -> RootFindParams); 2] =
        [("seed", &of_seeds), ("step", &of_steps)];
    for (kind, params) in kinds {
        let hit_rates = ATTEMPTS.map(|n| mirrors.cost(places, params(n)).hit_rate);
        let recalls = [0, 6].map(|n| known.quality(&mirrors, params(n), mirror_error).recall);
        println!(
            "{scene}, {kind} attempts {ATTEMPTS:?}: {hit_rates:.4?}, recall of 0 and 6 {recalls:.3?}"
        );
        assert!(
            saturates(&hit_rates, 0.75),
            "{scene}, {kind}: {hit_rates:?}"
        );
        let turned = [4, 3, 2, 1, 0].map(|n: usize| hit_rates[n]);
        assert!(!saturates(&turned, 0.0), "the control: {turned:?} falls");
        assert!(recalls[1] > recalls[0], "{scene}, {kind}: {recalls:?}");
    }
}

/// Figure 5.8: the mirror covers half of the picture. Steps are limited to 50, not unlimited as there: points that no
/// pixel shows walk to and fro for ever.
fn small_first_steps_cost_large_regions() {
    const STEPS: [f32; 7] = [0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5];
    let near = View {
        position: DVec3::new(0.0, 0.0, -0.16),
        ..View::REFERENCE
    };
    let costs = |scene: &str| {
        let mirrors = Mirrors::exact(scene, &near);
        let places = &cloud(scene.parse().expect("a scene"), POINTS).places;
        let costs = STEPS.map(|initial_step| {
            let params = RootFindParams {
                initial_step,
                ..thesis(2.0)
            };
            mirrors.cost(places, params)
        });
        println!("{scene}, first steps {STEPS:?}: {costs:.3?}");
        costs
    };
    let even = |values: &[f64]| {
        let most = values.iter().copied().fold(0.0, f64::max);
        most < 1.15 * values.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let sphere = costs("sphere");
    let (all, hits) = (sphere.map(|c| c.steps), sphere.map(|c| c.steps_of_hits));
    assert!(
        all[0] > 1.2 * all[2] && hits[0] > 1.5 * hits[2],
        "one large region, up to 0.1: {sphere:?}"
    );
    assert!(
        even(&all[2..]) && even(&hits[2..]),
        "one large region, from 0.1 on: {sphere:?}"
    );
    let bumps = costs("bumps");
    let (all, hits) = (bumps.map(|c| c.steps), bumps.map(|c| c.steps_of_hits));
    assert!(even(&hits), "many small regions: {bumps:?}");
    assert!(even(&all[2..]), "many small regions, all points: {bumps:?}");
}

/// Figure 5.9, on a mirror of many regions and with few points, in which the search leaves holes.
fn every_pull_level_closes_more() {
    let view = View {
        width: 400,
        height: 300,
        ..View::REFERENCE
    };
    let mut opened = Opened::generated(SceneName::Bumps.name(), 400_000, &view);
    let truth = Shown::new(&Oracle::named("bumps"), &view);
    let mut settings = opened.settings.clone();
    let rows: Vec<(f64, f64)> = (0..=4)
        .map(|levels| {
            settings.sscr.pull_levels = levels;
            let products = opened.render(&settings);
            let mirror = products.mirror.as_ref().expect("the camera sees a mirror");
            let figures = Figures::of(&truth, mirror);
            (products.bounces[0].coverage_closed, figures.psnr)
        })
        .collect();
    println!("bumps, coverage and dB of 0 to 4 pull levels: {rows:.3?}");
    let rises = |w: &[(f64, f64)]| w[1].0 > w[0].0 && w[1].1 > w[0].1;
    assert!(rows.windows(2).all(rises), "{rows:?}");
    assert!(rows[4].0 > 0.99 && rows[0].0 < 0.9, "{rows:?}");
}
