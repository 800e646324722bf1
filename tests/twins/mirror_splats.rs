//! The splatting of hits, and what is made of it, against the CPU twins.

use catoptric::backend::Backend;
use catoptric::backend::cpu::Cpu;
use catoptric::backend::gpu::{Gpu, GpuOptions};
use catoptric::gbuffer::SplatSettings;
use catoptric::job::Job;
use catoptric::reflect::sscr::{Splatting, SscrSettings, Visibility};
use catoptric::reflect::{Hit, MirrorGBuffer};
use glam::{Vec2, Vec4};

use super::mirrors::{assert_mirrors_agree, bring_mirror};
use super::search::{POINTS, Searched, interleaved, on_cpu, on_gpu, searched};
use super::support::{difference, gpu, options};

/// How its hits become splats.
fn squares(settings: &SscrSettings) -> Splatting {
    settings.splatting(false, &SplatSettings::default(), POINTS, POINTS)
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
