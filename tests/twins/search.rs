//! The search and the splatting of its hits against their CPU twins, on exact mirrors.

use std::collections::HashMap;
use std::sync::Arc;

use catoptric::backend::Backend;
use catoptric::backend::cpu::Cpu;
use catoptric::backend::gpu::{Gpu, GpuOptions};
use catoptric::cloud::Surfels;
use catoptric::cloud::generate::SceneName;
use catoptric::grid::Grid;
use catoptric::job::Job;
use catoptric::reflect::sscr::heat::HeatSums;
use catoptric::reflect::sscr::root_find::SearchCounts;
use catoptric::reflect::sscr::{Distribution, LhcMap, Search, SscrSettings};
use catoptric::reflect::{Hit, LabelledMirrors, Surface};
use glam::Vec3;

use super::mirrors::{bring_surface, from_many_eyes};
use super::support::{bring, gpu, options};
use crate::analytic::{Oracle, View};
use crate::ideal;

/// Points of a cloud.
pub(super) const POINTS: usize = 100_000;

/// Diagonal of the scenes' room, about.
const DIAGONAL: f32 = 5.0;

/// The search that runs on the device.
pub(super) fn interleaved() -> SscrSettings {
    SscrSettings {
        search: Search::Interleaved,
        ..SscrSettings::default()
    }
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

pub(super) fn on_cpu(s: &Searched, settings: &SscrSettings) -> (Vec<Hit>, SearchCounts) {
    let mirrors = LabelledMirrors::new(&s.surface, &s.lhc, Vec3::X);
    Cpu::default()
        .root_find(&s.surfels, &mirrors, settings, DIAGONAL, &Job::default())
        .expect("hits")
}

/// In the order of the points.
pub(super) fn on_gpu(
    gpu: &mut Gpu,
    s: &Searched,
    settings: &SscrSettings,
) -> (Vec<Hit>, SearchCounts) {
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
        .map(|(_, counts)| counts)
        .expect_err("32 KiB do not hold the mirrors");
    assert!(matches!(error, catoptric::Error::Memory { .. }), "{error}");
    assert!(error.to_string().contains("mirrors of"), "{error}");
}
