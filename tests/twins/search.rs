//! The search and the splatting of its hits against their CPU twins, on exact mirrors.

use std::collections::HashMap;
use std::sync::Arc;

use catoptric::backend::Backend;
use catoptric::backend::cpu::Cpu;
use catoptric::backend::gpu::{Gpu, GpuOptions};
use catoptric::cloud::Surfels;
use catoptric::cloud::generate::SceneName;
use catoptric::gbuffer::SplatSettings;
use catoptric::grid::Grid;
use catoptric::job::Job;
use catoptric::reflect::sscr::heat::HeatSums;
use catoptric::reflect::sscr::root_find::SearchCounts;
use catoptric::reflect::sscr::{Distribution, LhcMap, Search, Splatting, SscrSettings, Visibility};
use catoptric::reflect::{Hit, LabelledMirrors, MirrorGBuffer, Surface};
use glam::{Vec2, Vec3, Vec4};

use super::mirrors::{assert_mirrors_agree, bring_mirror, bring_surface, from_many_eyes};
use super::support::{bring, difference, gpu, options};
use crate::analytic::{Oracle, View};
use crate::ideal;

/// Points of a cloud.
const POINTS: usize = 100_000;

/// Diagonal of the scenes' room, about.
const DIAGONAL: f32 = 5.0;

/// The search that runs on the device.
fn interleaved() -> SscrSettings {
    SscrSettings {
        search: Search::Interleaved,
        ..SscrSettings::default()
    }
}

/// How its hits become splats.
fn squares(settings: &SscrSettings) -> Splatting {
    settings.splatting(&SplatSettings::default(), POINTS, POINTS)
}

/// The mirrors of a scene, exact but for a turn of all normals by so many degrees, their regions, and its cloud.
pub(super) struct Searched {
    pub(super) surface: Surface<Cpu>,
    pub(super) lhc: LhcMap,
    pub(super) surfels: Arc<Surfels>,
}

pub(super) fn searched(scene: &str, tilt: f64) -> Searched {
    let view = View {
        width: 200,
        height: 150,
        ..View::REFERENCE
    };
    let surface = ideal::surface(&view, &Oracle::named(scene).view(&view), tilt);
    let name: SceneName = scene.parse().expect("a scene");
    Searched {
        lhc: ideal::regions(&view, &surface),
        surface,
        surfels: ideal::cloud(name, POINTS),
    }
}

fn on_cpu(s: &Searched, settings: &SscrSettings) -> (Vec<Hit>, SearchCounts) {
    let mirrors = LabelledMirrors::new(&s.surface, &s.lhc, Vec3::X);
    Cpu::default()
        .root_find(&s.surfels, &mirrors, settings, DIAGONAL, &Job::default())
        .expect("hits")
}

/// In the order of the points.
fn on_gpu(gpu: &mut Gpu, s: &Searched, settings: &SscrSettings) -> (Vec<Hit>, SearchCounts) {
    let surface = bring_surface(gpu, &s.surface);
    let labels = bring(gpu, surface.size, s.lhc.labels.values());
    let points = gpu.upload(&s.surfels).expect("points");
    let mirrors = LabelledMirrors {
        surface: &surface,
        labels: &labels,
        regions: &s.lhc.regions,
        right: Vec3::X,
    };
    let (hits, counts) = gpu
        .root_find(&points, &mirrors, settings, DIAGONAL, &Job::default())
        .expect("hits");
    let mut hits = gpu.read_hits(&hits).expect("hits");
    hits.sort_by_key(|hit| (hit.point, hit.pixel.x.to_bits(), hit.pixel.y.to_bits()));
    (hits, counts)
}

/// How two searches of as many points, each once, agree.
#[derive(Debug)]
struct Agreement {
    /// Points that one of them finds and the other does not.
    otherwise: usize,
    /// Points that both find.
    both: usize,
    /// Those of them whose places are more than 0.01 pixels apart.
    apart: usize,
}

impl Agreement {
    /// Hit or miss of 99.9 % of the points, and 99.9 % of the places.
    fn holds(&self) -> bool {
        self.otherwise * 1000 <= POINTS && self.apart * 1000 <= self.both
    }
}

fn agreement(got: &[Hit], expected: &[Hit]) -> Agreement {
    let places: HashMap<u32, _> = expected.iter().map(|hit| (hit.point, hit.pixel)).collect();
    let both: Vec<_> = got
        .iter()
        .filter_map(|hit| Some(places.get(&hit.point)?.distance(hit.pixel)))
        .collect();
    Agreement {
        otherwise: got.len() + expected.len() - 2 * both.len(),
        apart: both.iter().filter(|&&d| !(d <= 0.01)).count(),
        both: both.len(),
    }
}

pub(super) fn searches_agree_on_hit_miss_and_place() {
    let gpu = &mut gpu();
    for scene in ["sphere", "torus", "blob"] {
        let s = searched(scene, 0.0);
        let settings = interleaved();
        let (expected, expected_counts) = on_cpu(&s, &settings);
        let (got, counts) = on_gpu(gpu, &s, &settings);
        let agreement = agreement(&got, &expected);
        println!("{scene}: {agreement:?}, {counts:?}, on the CPU {expected_counts:?}");
        assert!(agreement.both > POINTS / 20, "{scene}: {agreement:?}");
        assert!(agreement.holds(), "{scene}: {agreement:?}");
        assert_eq!(counts.offered, expected_counts.offered, "{scene}: offered");
        assert_eq!(counts.hits as usize, got.len(), "{scene}: hits");
        let steps = counts.steps as f64 / expected_counts.steps as f64;
        assert!((steps - 1.0).abs() < 1e-3, "{scene}: {steps} of the steps");
        // A splat's reach follows from the distance alone.
        for hit in &got {
            let reach = settings.splat_reach(hit.distance, DIAGONAL);
            assert!((hit.reach - reach).abs().max_element() < 1e-5, "{hit:?}");
        }
    }
}

pub(super) fn a_mirror_turned_by_a_tenth_of_a_degree_is_noticed() {
    let gpu = &mut gpu();
    let settings = interleaved();
    let (expected, _) = on_cpu(&searched("sphere", 0.0), &settings);
    let (got, _) = on_gpu(gpu, &searched("sphere", 0.1), &settings);
    let agreement = agreement(&got, &expected);
    assert!(!agreement.holds(), "{agreement:?}");
}

pub(super) fn searches_agree_in_every_distribution_and_from_many_eyes() {
    let gpu = &mut gpu();
    let several = SscrSettings {
        passes: 3,
        ..interleaved()
    };
    let uniform = SscrSettings {
        distribution: Distribution::Uniform,
        ..several.clone()
    };
    for (settings, many) in [(several, false), (uniform, false), (interleaved(), true)] {
        let mut s = searched("torus", 0.0);
        if many {
            s.surface = from_many_eyes(s.surface);
        }
        let (expected, counts) = on_cpu(&s, &settings);
        let got = on_gpu(gpu, &s, &settings);
        assert_eq!(got.1.offered, counts.offered, "points offered");
        let off = got.1.hit.abs_diff(counts.hit);
        assert!(
            counts.hit > 1000 && off * 1000 <= counts.offered,
            "{off} of {counts:?} for {settings:?}"
        );
        // Every pass by itself finds what it finds on the CPU.
        let mut theirs: HashMap<_, usize> = HashMap::new();
        for hit in &expected {
            *theirs.entry(hit.point).or_default() += 1;
        }
        let mut ours: HashMap<_, usize> = HashMap::new();
        for hit in &got.0 {
            *ours.entry(hit.point).or_default() += 1;
        }
        let other = (0..POINTS as u32).filter(|point| ours.get(point) != theirs.get(point));
        assert!(other.count() * 1000 <= POINTS * 3, "{settings:?}");
    }
}

/// Where searches end, on both backends.
fn heats(gpu: &mut Gpu, s: &Searched, settings: &SscrSettings) -> (Grid<HeatSums>, Grid<HeatSums>) {
    let job = Job::default();
    let mirrors = LabelledMirrors::new(&s.surface, &s.lhc, Vec3::X);
    let expected = Cpu::default()
        .search_heat(&s.surfels, &mirrors, settings, &job)
        .expect("the heat");
    let surface = bring_surface(gpu, &s.surface);
    let labels = bring(gpu, surface.size, s.lhc.labels.values());
    let points = gpu.upload(&s.surfels).expect("points");
    let mirrors = LabelledMirrors {
        surface: &surface,
        labels: &labels,
        regions: &s.lhc.regions,
        right: Vec3::X,
    };
    let got = gpu
        .search_heat(&points, &mirrors, settings, &job)
        .expect("the heat");
    (got, expected)
}

pub(super) fn heats_are_equal_and_add_up_to_the_search() {
    let gpu = &mut gpu();
    let s = searched("torus", 0.0);
    let settings = SscrSettings {
        passes: 2,
        ..interleaved()
    };
    let (got, expected) = heats(gpu, &s, &settings);
    let apart = |a: &Grid<HeatSums>, b: &Grid<HeatSums>| {
        let pairs = a.values().iter().zip(b.values());
        pairs.filter(|(a, b)| a != b).count()
    };
    // A graphics card may round a step to the other side of a pixel's edge.
    let software = gpu.device().is_software();
    let allowed = if software { 0 } else { got.values().len() / 20 };
    let wrong = apart(&got, &expected);
    assert!(wrong <= allowed, "{wrong} pixels differ");

    let (_, counts) = on_cpu(&s, &settings);
    let sum = |of: fn(&HeatSums) -> u64| expected.values().iter().map(of).sum::<u64>();
    let (found, lost) = (sum(|h| h.found.into()), sum(|h| h.lost.into()));
    assert_eq!(found, counts.hit, "every point found ends in a pixel");
    assert!(
        lost > 0 && found + lost <= counts.offered,
        "{lost} lost of {counts:?}"
    );
    assert!(sum(|h| h.steps) <= counts.steps, "steps of those found");
    assert!(sum(|h| h.residual) > 0, "residuals");

    let hasty = SscrSettings {
        max_steps: 23,
        ..settings
    };
    let (_, other) = heats(gpu, &s, &hasty);
    assert!(apart(&other, &expected) > 50, "a step less is noticed");
}

/// A device whose bindings are so small that points, hits and sums need several bands.
fn banded() -> Gpu {
    Gpu::new(&GpuOptions {
        binding_limit: Some(1 << 20),
        ..options()
    })
    .expect("a device")
}

/// Splats hits on the device, onto the mirrors of `s`.
fn splatted(
    gpu: &mut Gpu,
    s: &Searched,
    mirror: &MirrorGBuffer<Cpu>,
    hits: &[Hit],
    splatting: &Splatting,
) -> MirrorGBuffer<Gpu> {
    let points = gpu.upload(&s.surfels).expect("points");
    let hits = gpu.write_hits(hits).expect("hits");
    let mut there = bring_mirror(gpu, mirror);
    gpu.accumulate(&hits, &points, &mut there, splatting, &Job::default())
        .expect("splatted");
    there
}

/// Rays and regions, and nothing shown yet.
pub(super) fn unseen(s: &Searched) -> MirrorGBuffer<Cpu> {
    let mut mirror = MirrorGBuffer::of(&s.surface);
    mirror.region = s.lhc.labels.clone();
    mirror
}

/// Asserts that both backends splat hits alike, and returns what the mirrors show.
fn assert_splats_agree(
    gpu: &mut Gpu,
    s: &Searched,
    hits: &[Hit],
    splatting: &Splatting,
) -> MirrorGBuffer<Cpu> {
    let mut expected = unseen(s);
    let got = splatted(gpu, s, &expected, hits, splatting);
    Cpu::default()
        .accumulate(
            &hits.to_vec(),
            &s.surfels,
            &mut expected,
            splatting,
            &Job::default(),
        )
        .expect("splatted");
    let shown = expected.coverage();
    assert!(shown.covered * 2 > shown.pixels, "{shown:?}");
    assert_mirrors_agree(gpu, got, &expected, 2e-5);
    expected
}

pub(super) fn splatted_hits_agree() {
    let gpu = &mut gpu();
    let s = searched("sphere", 0.0);
    for (visibility, max_splat) in [
        (Visibility::Accumulate, 2.0),
        (Visibility::Nearest, 3.5),
        (Visibility::Accumulate, 7.0),
    ] {
        let settings = SscrSettings {
            visibility,
            max_splat,
            ..interleaved()
        };
        let (hits, _) = on_cpu(&s, &settings);
        assert_splats_agree(gpu, &s, &hits, &squares(&settings));
    }
}

pub(super) fn splatted_discs_agree() {
    let gpu = &mut gpu();
    let s = searched("sphere", 0.0);
    let (mut hits, _) = on_cpu(&s, &interleaved());
    // Where a mirror's picture folds a reach may be infinite, or no number.
    for (i, hit) in hits.iter_mut().enumerate() {
        hit.reach = match i % 1000 {
            0 => Vec2::splat(f32::INFINITY),
            1 => Vec2::new(f32::NAN, 3.0),
            _ => hit.reach * 2.5,
        };
    }
    let discs = |enlarged| Splatting {
        visibility: Visibility::Accumulate,
        depth_offset: 2.0,
        disc: Some(1.5),
        own_layer: 5.0,
        enlarged,
    };
    let small = assert_splats_agree(gpu, &s, &hits, &discs(1.2));
    let large = assert_splats_agree(gpu, &s, &hits, &discs(2.5));
    assert_differs(small.albedo.values(), large.albedo.values());
}

pub(super) fn a_hit_that_is_missing_is_noticed() {
    let gpu = &mut gpu();
    let s = searched("sphere", 0.0);
    let settings = interleaved();
    let (hits, _) = on_cpu(&s, &settings);
    let mut expected = unseen(&s);
    let got = splatted(gpu, &s, &expected, &hits[1..], &squares(&settings));
    Cpu::default()
        .accumulate(
            &hits,
            &s.surfels,
            &mut expected,
            &squares(&settings),
            &Job::default(),
        )
        .expect("splatted");
    let got = got.take(&mut **gpu).expect("a mirror G-buffer");
    assert_ne!(got.count, expected.count, "one hit less");
}

pub(super) fn bands_of_hits_do_not_show() {
    let (whole, banded) = (&mut gpu(), &mut banded());
    let s = searched("sphere", 0.0);
    let settings = interleaved();
    let one = on_gpu(whole, &s, &settings);
    let many = on_gpu(banded, &s, &settings);
    assert_eq!(one, many, "the hits");
    let mirror = unseen(&s);
    let got = splatted(whole, &s, &mirror, &one.0, &squares(&settings));
    let one = got.take(&mut **whole).expect("a mirror G-buffer");
    let got = splatted(banded, &s, &mirror, &many.0, &squares(&settings));
    let many = got.take(banded).expect("a mirror G-buffer");
    assert_eq!(one.surface, many.surface, "surfaces");
    assert_eq!(one.albedo, many.albedo, "albedos");
    assert_eq!(one.count, many.count, "counts");
}

/// The sphere's mirrors with what the search finds, and the holes that it leaves.
fn with_holes() -> MirrorGBuffer<Cpu> {
    let s = searched("sphere", 0.0);
    let settings = SscrSettings {
        max_splat: 1.0,
        ..interleaved()
    };
    let (hits, _) = on_cpu(&s, &settings);
    let mut mirror = unseen(&s);
    Cpu::default()
        .accumulate(
            &hits,
            &s.surfels,
            &mut mirror,
            &squares(&settings),
            &Job::default(),
        )
        .expect("splatted");
    mirror
}

pub(super) fn closing_agrees_at_every_level() {
    let (gpu, banded) = (&mut gpu(), &mut banded());
    for levels in [0, 1, 4, 9] {
        let mut expected = with_holes();
        for gpu in [&mut **gpu, banded] {
            let mut there = bring_mirror(gpu, &with_holes());
            let job = Job::default();
            gpu.pull_push(&mut there, levels, &job).expect("closed");
            if expected.coverage() == with_holes().coverage() {
                Cpu::default()
                    .pull_push(&mut expected, levels, &job)
                    .expect("closed");
            }
            let counted = gpu.mirror_coverage(&there, &job).expect("counted");
            assert_eq!(counted, expected.coverage(), "{levels} levels");
            assert_mirrors_agree(gpu, there, &expected, 1e-4);
        }
    }
    let filled = |level: f32| {
        let mut mirror = with_holes();
        Cpu::default()
            .pull_push(&mut mirror, 4, &Job::default())
            .expect("closed");
        mirror
            .level
            .values()
            .iter()
            .filter(|&&l| l == level)
            .count()
    };
    assert!(
        filled(1.0) > 50 && filled(2.0) > 5,
        "there are holes to fill"
    );
}

pub(super) fn mirrors_that_cannot_be_searched_are_a_sentence() {
    let mut small = Gpu::new(&GpuOptions {
        binding_limit: Some(1 << 15),
        ..options()
    })
    .expect("a device");
    let s = searched("sphere", 0.0);
    let surface = bring_surface(&mut small, &s.surface);
    let labels = bring(&mut small, surface.size, s.lhc.labels.values());
    let points = small.upload(&s.surfels).expect("points");
    let mirrors = LabelledMirrors {
        surface: &surface,
        labels: &labels,
        regions: &s.lhc.regions,
        right: Vec3::X,
    };
    let settings = interleaved();
    let error = small
        .root_find(&points, &mirrors, &settings, DIAGONAL, &Job::default())
        .err()
        .expect("32 KiB do not hold the mirrors");
    assert!(matches!(error, catoptric::Error::Memory { .. }), "{error}");
    assert!(error.to_string().contains("mirrors of"), "{error}");
}

/// What the mirrors of a small picture show, closed.
pub(super) fn shown() -> MirrorGBuffer<Cpu> {
    let mut mirror = with_holes();
    Cpu::default()
        .pull_push(&mut mirror, 4, &Job::default())
        .expect("closed");
    mirror
}

pub(super) fn assert_differs(a: &[Vec4], b: &[Vec4]) {
    assert!(difference(a, b, 1e-2).is_some(), "nothing differs");
}
