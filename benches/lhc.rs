//! What the regions of mirrors cost: `cargo bench --bench lhc`. The scene `bumps` at 800 x 600, seen by the tests' oracle.

#[allow(dead_code, reason = "the oracle knows more than this needs")]
#[path = "../tests/analytic.rs"]
mod analytic;
#[allow(dead_code, reason = "the oracle knows more than this needs")]
#[path = "../tests/forms.rs"]
mod forms;

use catoptric::backend::cpu::Cpu;
use catoptric::grid::Grid;
use catoptric::reflect::sscr::Distribution;
use catoptric::reflect::sscr::curvature::{Axes, LhcSettings, curvature};
use catoptric::reflect::sscr::distribute::distribute;
use catoptric::reflect::sscr::lhc::Labeller;
use catoptric::reflect::{Eye, Surface};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::{UVec2, Vec3, Vec4};

use analytic::{Kind, Oracle, View};

const SIZE: UVec2 = UVec2::new(800, 600);
const SCREEN: Axes = Axes::Screen {
    right: Vec3::X,
    down: Vec3::NEG_Y,
};
const POINTS: u32 = 1_600_000;

fn main() {
    divan::main();
}

/// The mirror as the reference camera sees it.
fn bumps() -> Surface<Cpu> {
    let hits = Oracle::named("bumps").view(&View::REFERENCE);
    let (mut point, mut normal) = (Grid::new(SIZE, Vec4::ZERO), Grid::new(SIZE, Vec4::ZERO));
    for (i, hit) in hits.iter().enumerate() {
        if matches!(hit.kind, Kind::Mirror(_)) {
            point.values_mut()[i] = hit.position.as_vec3().extend(1.0);
            normal.values_mut()[i] = hit.normal.as_vec3().extend(0.0043);
        }
    }
    let eye = Eye::Point(View::REFERENCE.position.as_vec3());
    Surface {
        size: SIZE,
        point,
        normal,
        eye,
    }
}

/// All cores.
#[divan::bench]
fn curvature_map(bencher: Bencher<'_, '_>) {
    let surface = bumps();
    bencher.bench_local(|| curvature(black_box(&surface), SCREEN, &LhcSettings::default()));
}

/// Smoothing, suppression, labelling, filling, order; one core.
#[divan::bench]
fn lhc_map(bencher: Bencher<'_, '_>) {
    let map = curvature(&bumps(), SCREEN, &LhcSettings::default());
    let mut labeller = Labeller::default();
    bencher.bench_local(|| labeller.lhc(black_box(&map)).regions.len());
}

/// Labelling by class and order alone; one core.
#[divan::bench]
fn labels(bencher: Bencher<'_, '_>) {
    let map = curvature(&bumps(), SCREEN, &LhcSettings::default());
    let mut labeller = Labeller::default();
    bencher.bench_local(|| labeller.label(black_box(&map), |c| c & 0xf).regions.len());
}

/// 10,000 regions of 48 pixels on the whole screen; one core.
#[divan::bench]
fn labels_of_ten_thousand_squares(bencher: Bencher<'_, '_>) {
    let mut cells = Grid::new(SIZE, 1);
    for (i, cell) in cells.values_mut().iter_mut().enumerate() {
        *cell = 1 + ((i % 800 / 8 + i / 800 / 6) % 2) as u8;
    }
    let mut labeller = Labeller::default();
    bencher.bench_local(|| labeller.label(black_box(&cells), |c| c).regions.len());
}

/// One region for each of 1.6 million points; one core.
#[divan::bench]
fn distribution(bencher: Bencher<'_, '_>) {
    let map = curvature(&bumps(), SCREEN, &LhcSettings::default());
    let mut labeller = Labeller::default();
    let regions = &labeller.lhc(&map).regions;
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        let label = |i| distribute(regions, Distribution::Weighted, i, 0).unwrap_or(0);
        (0..POINTS).map(label).fold(0, u32::wrapping_add)
    });
}
