//! Whole pictures on both backends, and the device's manners.

use std::sync::Arc;

use catoptric::Error;
use catoptric::backend::cpu::Cpu;
use catoptric::backend::gpu::{AdapterChoice, Gpu, GpuOptions};
use catoptric::backend::{Backend, LitBy};
use catoptric::cloud::Surfels;
use catoptric::gbuffer::SplatSettings;
use catoptric::gi::GiSettings;
use catoptric::job::Job;
use glam::{UVec2, Vec4};

use super::support::{SIZE, bring, cloud, gpu, options, pinhole, spot};

/// Splatted, filled, lit: radiance.
fn picture<B: Backend>(backend: &mut B, surfels: &Arc<Surfels>, size: UVec2) -> Vec<Vec4> {
    let points = backend.upload(surfels).expect("points");
    let (settings, job) = (SplatSettings::default(), Job::default());
    let mut seen = backend
        .splat(&points, &pinhole(size), &settings, &job)
        .expect("a G-buffer");
    backend.fill(&mut seen, &settings, &job).expect("filled");
    let map = backend
        .light_map(&points, &spot().pinhole(170, 10.0), &settings, &job)
        .expect("a map");
    let lit = backend
        .shade(
            &seen,
            &[LitBy { light: spot(), map }],
            &GiSettings::default(),
            &job,
        )
        .expect("radiance");
    backend.read(&lit).expect("radiance").into_owned()
}

fn srgb(v: f32) -> f32 {
    let v = v.clamp(0.0, 1.0);
    if v <= 0.003_130_8 {
        12.92 * v
    } else {
        1.055 * v.powf(1.0 / 2.4) - 0.055
    }
}

pub(super) fn whole_pictures_agree() {
    let surfels = cloud(60_000, false);
    let size = UVec2::new(320, 240);
    let expected = picture(&mut Cpu::default(), &surfels, size);
    let got = picture(&mut *gpu(), &surfels, size);
    let shown = |v: Vec4| Vec4::new(srgb(v.x), srgb(v.y), srgb(v.z), v.w);
    let off = |(a, b): (&Vec4, &Vec4)| {
        let difference = (shown(*a) - shown(*b)).abs();
        !difference.cmple(Vec4::splat(1.0 / 255.0)).all()
    };
    let wrong = got.iter().zip(&expected).filter(|p| off(*p)).count();
    assert!(
        wrong * 10_000 <= expected.len(),
        "{wrong} of {} pixels are off by more than 1/255",
        expected.len()
    );
}

pub(super) fn bands_do_not_show() {
    // 64 KiB a binding: 4096 points, 1365 pixels of sums.
    let mut banded = Gpu::new(&GpuOptions {
        binding_limit: Some(1 << 16),
        ..options()
    })
    .expect("a device");
    let surfels = cloud(20_000, true);
    let size = UVec2::new(150, 90);
    let expected = picture(&mut *gpu(), &surfels, size);
    assert_eq!(
        picture(&mut banded, &surfels, size),
        expected,
        "the banded picture is the same"
    );
}

pub(super) fn a_picture_is_the_same_each_time() {
    let surfels = cloud(20_000, true);
    let gpu = &mut gpu();
    let first = picture(&mut **gpu, &surfels, SIZE);
    assert_eq!(
        picture(&mut **gpu, &surfels, SIZE),
        first,
        "the second picture is the first"
    );
    let passes: Vec<_> = std::mem::take(gpu.timings())
        .passes
        .into_iter()
        .map(|p| p.name)
        .collect();
    for name in [
        "upload",
        "depth",
        "visibility",
        "average",
        "fill",
        "light_depth",
        "shade",
    ] {
        assert!(
            passes.iter().any(|p| p == name),
            "{name} is timed: {passes:?}"
        );
    }
    assert!(gpu.timings().passes.is_empty(), "times are taken once");
}

pub(super) fn a_grid_comes_back_as_it_was_written() {
    let gpu = &mut gpu();
    let values: Vec<u32> = (0..SIZE.x * SIZE.y)
        .map(|i| i.wrapping_mul(2_654_435_761))
        .collect();
    let grid = bring(gpu, SIZE, &values);
    assert_eq!(
        gpu.read(&grid).expect("a grid").into_owned(),
        values,
        "values"
    );
    let error = gpu
        .write(SIZE, &values[1..])
        .expect_err("one value is missing")
        .to_string();
    assert!(error.contains("37x21"), "{error}");
}

pub(super) fn too_little_memory_is_a_sentence() {
    let mut small = Gpu::new(&GpuOptions {
        memory_budget: Some(1 << 20),
        ..options()
    })
    .expect("a device");
    let error = small
        .upload(&cloud(50_000, false))
        .expect_err("1.6 MB do not fit into 1 MiB");
    assert!(matches!(error, Error::Memory { .. }), "{error}");
    assert!(error.to_string().contains("50000 points"), "{error}");
    small
        .upload(&cloud(5_000, false))
        .expect("160 kB fit, after the failure too");
}

pub(super) fn a_lost_device_is_a_sentence() {
    let mut lost = Gpu::new(&options()).expect("a device");
    let points = lost.upload(&cloud(1000, false)).expect("points");
    lost.device().raw().destroy();
    for _ in 0..2 {
        let error = lost
            .splat(
                &points,
                &pinhole(SIZE),
                &SplatSettings::default(),
                &Job::default(),
            )
            .err()
            .expect("the device is lost");
        assert!(matches!(error, Error::Gpu(_)), "{error}");
        assert!(error.to_string().contains("--backend cpu"), "{error}");
    }
    assert!(
        lost.upload(&cloud(10, false)).is_err(),
        "nothing can be brought to a lost device"
    );
}

pub(super) fn an_unknown_adapter_is_answered_with_a_list() {
    let options = GpuOptions {
        adapter: AdapterChoice::Named("no such card".into()),
        ..options()
    };
    let error = Gpu::new(&options).expect_err("no such card");
    assert!(matches!(error, Error::NoAdapter(_)), "{error}");
    let name = gpu().device().adapter().to_owned();
    assert!(
        error.to_string().contains(&name),
        "{error} must name {name}"
    );
}
