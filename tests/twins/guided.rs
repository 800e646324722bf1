//! The guided search against its CPU twin, on exact mirrors.

use std::collections::HashMap;

use catoptric::Job;
use catoptric::backend::Backend;
use catoptric::backend::cpu::Cpu;
use catoptric::backend::gpu::{Gpu, GpuOptions};
use catoptric::reflect::Hit;
use catoptric::reflect::sscr::curvature::Axes;
use catoptric::reflect::sscr::guided::Guide;
use catoptric::reflect::sscr::prefix::{Budget, Prefix};
use catoptric::reflect::sscr::root_find::SearchCounts;
use glam::{Vec2, Vec3};

use super::search::{Searched, searched};
use super::support::{gpu, options};
use crate::charted::Charted;

/// Points that are searched.
const SEARCHED: usize = 40_000;

fn charted(s: &Searched) -> Charted {
    let axes = Axes::Screen {
        right: Vec3::X,
        down: Vec3::NEG_Y,
    };
    Charted::new(&s.surface, axes, &s.surfels)
}

fn search<B: Backend>(
    backend: &mut B,
    s: &Searched,
    guide: &Guide<'_>,
) -> (B::Hits, SearchCounts, usize) {
    let points = backend.upload(&s.surfels).expect("points");
    let (mut prefix, budget) = (Prefix::default(), Budget::Points(SEARCHED));
    backend
        .guided(&points, guide, &mut prefix, budget, &Job::default())
        .expect("hits")
}

/// Hits of one list without one of the other within 0.01 pixels, and the most that reach and distance of the others differ,
/// in parts.
fn alone(these: &[Hit], those: &[Hit]) -> (usize, f32) {
    let mut places: HashMap<u32, Vec<&Hit>> = HashMap::new();
    for hit in those {
        places.entry(hit.point).or_default().push(hit);
    }
    let (mut alone, mut reach) = (0, 0f32);
    for hit in these {
        let near = |other: &&&Hit| other.pixel.distance(hit.pixel) <= 0.01;
        match places
            .get(&hit.point)
            .and_then(|hits| hits.iter().find(near))
        {
            Some(other) => {
                let wide = Vec2::splat(64.0);
                let (a, b) = (hit.reach.min(wide), other.reach.min(wide));
                reach = reach.max(((a - b) / b).abs().max_element());
                reach = reach.max((hit.distance / other.distance - 1.0).abs());
            }
            None => alone += 1,
        }
    }
    (alone, reach)
}

fn agree(gpu: &mut Gpu, scene: &str) {
    let s = searched(scene, 0.0);
    let charted = charted(&s);
    let guide = charted.guide();
    let (expected, expected_counts, _) = search(&mut Cpu::default(), &s, &guide);
    let (hits, counts, taken) = search(gpu, &s, &guide);
    let got = gpu.read_hits(&hits).expect("hits");
    let (missing, _) = alone(&expected, &got);
    let (added, reach) = alone(&got, &expected);
    println!(
        "{scene}: {} hits, {missing} missing, {added} added, reach {reach}, {counts:?}, on the CPU {expected_counts:?}",
        got.len()
    );
    assert_eq!((taken, counts.offered), (SEARCHED, SEARCHED as u64));
    assert_eq!(
        counts.hits as usize,
        got.len(),
        "{scene}: every hit is in the list"
    );
    assert!(got.len() > SEARCHED / 4, "{scene}: {} hits", got.len());
    assert!(
        (missing + added) * 1000 <= got.len(),
        "{scene}: {missing} hits are missing and {added} added of {}",
        got.len()
    );
    assert!(
        got.len().abs_diff(expected.len()) * 1000 <= got.len(),
        "{scene}: {} hits, on the CPU {}",
        got.len(),
        expected.len()
    );
    assert!(reach < 1e-2, "{scene}: reach or distance differ by {reach}");
    let steps = counts.steps as f64 / expected_counts.steps as f64;
    assert!((steps - 1.0).abs() < 2e-3, "{scene}: {steps} of the steps");
}

pub(super) fn guided_searches_agree_on_every_place() {
    let gpu = &mut gpu();
    for scene in ["sphere", "torus", "blob"] {
        agree(gpu, scene);
    }
}

pub(super) fn a_list_that_is_too_short_is_searched_again() {
    // Bindings so small that points and hits need several bands, and that the hits of a part do not fit into one: the blob
    // shows its points more often than the list has room for at first.
    let gpu = &mut Gpu::new(&GpuOptions {
        binding_limit: Some(3 << 17),
        ..options()
    })
    .expect("a device");
    agree(gpu, "torus");
}

pub(super) fn a_mirror_turned_a_little_is_noticed_by_guided_searches() {
    let (straight, turned) = (searched("sphere", 0.0), searched("sphere", 0.1));
    let [a, b] = [&straight, &turned].map(|s| {
        let charted = charted(s);
        search(&mut Cpu::default(), s, &charted.guide()).0
    });
    let (missing, _) = alone(&a, &b);
    assert!(missing * 10 > a.len(), "{missing} of {} hits", a.len());
}
