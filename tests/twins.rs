//! Every kernel against its CPU twin, on a small cloud; and the device's manners.
//!
//! Without any graphics adapter these tests are shown as ignored; with CATOPTRIC_GPU=require they fail then.

use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

use bytemuck::Pod;
use catoptric::Error;
use catoptric::backend::cpu::Cpu;
use catoptric::backend::gpu::{AdapterChoice, Gpu, GpuOptions};
use catoptric::backend::{Backend, LitBy};
use catoptric::camera::{Camera, Pinhole};
use catoptric::cloud::{Finish, Place, Surfel, Surfels};
use catoptric::gbuffer::splat::{Accumulated, Splatter};
use catoptric::gbuffer::{GBuffer, SplatSettings};
use catoptric::gi::{GiSettings, SpotLight};
use catoptric::image::ImageSettings;
use catoptric::timing::Timings;
use glam::{DVec3, UVec2, Vec3, Vec4};
use libtest_mimic::Trial;

/// No multiple of a workgroup's side.
const SIZE: UVec2 = UVec2::new(37, 21);

static GPU: LazyLock<Option<Mutex<Gpu>>> =
    LazyLock::new(|| Gpu::new(&options()).ok().map(Mutex::new));

/// The path that every adapter runs: default limits, no features.
fn options() -> GpuOptions {
    GpuOptions {
        adapter: AdapterChoice::Any,
        portable: true,
        ..GpuOptions::default()
    }
}

fn gpu() -> MutexGuard<'static, Gpu> {
    let gpu = GPU
        .as_ref()
        .expect("CATOPTRIC_GPU=require, but there is no graphics adapter");
    gpu.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(crate) fn tests() -> Vec<Trial> {
    let missing = crate::support::gpu_is_missing();
    let test = |name: &str, check: fn()| {
        let run = move || {
            check();
            Ok(())
        };
        Trial::test(format!("twins::{name}"), run).with_ignored_flag(missing)
    };
    vec![
        test(
            "sums_are_equal_to_the_last_bit",
            sums_are_equal_to_the_last_bit,
        ),
        test(
            "one_flipped_bit_of_a_sum_is_noticed",
            one_flipped_bit_of_a_sum_is_noticed,
        ),
        test("averages_agree", averages_agree),
        test(
            "light_maps_are_equal_to_the_last_bit",
            light_maps_are_equal_to_the_last_bit,
        ),
        test(
            "filling_agrees_and_counts_the_same_pixels",
            filling_agrees_and_counts_the_same_pixels,
        ),
        test("smoothing_agrees", smoothing_agrees),
        test("shading_agrees", shading_agrees),
        test(
            "without_a_light_everything_is_black",
            without_a_light_everything_is_black,
        ),
        test("eye_dome_lighting_agrees", eye_dome_lighting_agrees),
        test(
            "one_flipped_value_of_a_picture_is_noticed",
            one_flipped_value_of_a_picture_is_noticed,
        ),
        test("whole_pictures_agree", whole_pictures_agree),
        test("bands_do_not_show", bands_do_not_show),
        test(
            "a_picture_is_the_same_each_time",
            a_picture_is_the_same_each_time,
        ),
        test(
            "a_grid_comes_back_as_it_was_written",
            a_grid_comes_back_as_it_was_written,
        ),
        test(
            "too_little_memory_is_a_sentence",
            too_little_memory_is_a_sentence,
        ),
        test("a_lost_device_is_a_sentence", a_lost_device_is_a_sentence),
        test(
            "an_unknown_adapter_is_answered_with_a_list",
            an_unknown_adapter_is_answered_with_a_list,
        ),
    ]
}

/// Numbers from 0 to 1, the same on every machine.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next()
    }
}

/// A back wall, a floor and a ball before them, of `count` surfels; the ball is a mirror where `mirrors`. A few surfels are
/// glossy, look away, are edge-on, behind the camera, or huge.
fn cloud(count: usize, mirrors: bool) -> Arc<Surfels> {
    let mut numbers = Numbers(7);
    let spacing = (12.0 / count as f32).sqrt();
    let (mut places, mut finishes) = (Vec::new(), Vec::new());
    for i in 0..count {
        let (u, v) = (numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0));
        let (mut position, mut normal) = match i % 4 {
            0 | 1 => (Vec3::new(1.5 * u, v, -2.0), Vec3::Z),
            2 => (Vec3::new(1.5 * u, -1.0, v - 1.0), Vec3::Y),
            _ => {
                let (sin, cos) = (u * std::f32::consts::PI).sin_cos();
                let n = Vec3::new((1.0 - v * v).sqrt() * cos, v, (1.0 - v * v).sqrt() * sin);
                (Vec3::new(0.2, -0.3, -1.0) + n * 0.45, n)
            }
        };
        match i % 97 {
            0 => normal = -normal,
            1 => normal = Vec3::X,
            2 => position.z = 5.0,
            _ => {}
        }
        let surfel = Surfel {
            position,
            radius: if i % 101 == 0 { spacing * 6.0 } else { spacing },
            normal,
            albedo: Vec3::new(numbers.next(), 0.6 + 0.2 * u, 0.5 + 0.3 * v),
            mirror: if mirrors && i % 4 == 3 { 0.8 } else { 0.0 },
            specular: if i % 3 == 0 { 0.3 } else { 0.0 },
            shininess: 1.0 + 60.0 * numbers.next(),
        };
        places.push(Place {
            position,
            radius: surfel.radius,
        });
        finishes.push(Finish::pack(&surfel));
    }
    Arc::new(Surfels {
        places,
        finishes,
        source: (0..count as u32).collect(),
        origin: DVec3::ZERO,
    })
}

fn pinhole(size: UVec2) -> Pinhole {
    let camera = Camera {
        position: DVec3::new(0.1, 0.2, 1.2),
        target: DVec3::new(0.05, -0.1, -1.0),
        up: DVec3::Y,
        fov_y_degrees: 55.0,
        near: 0.01,
        far: 100.0,
        size,
    };
    camera.pinhole(DVec3::ZERO).expect("a sound camera")
}

fn spot() -> SpotLight {
    SpotLight {
        position: Vec3::new(-0.6, 0.9, 0.6),
        axis: Vec3::new(0.5, -0.8, -1.2).normalize(),
        intensity: Vec3::new(6.0, 5.0, 4.0),
        inner_angle: 25f32.to_radians(),
        outer_angle: 35f32.to_radians(),
    }
}

/// What differs between two lists by more than `tolerance` (of the larger, or 1); `None` where nothing does.
fn difference(got: &[Vec4], expected: &[Vec4], tolerance: f32) -> Option<String> {
    assert_eq!(got.len(), expected.len(), "as many values");
    // What is no number is off, too.
    let off = |a: Vec4, b: Vec4| {
        let limit = tolerance * b.abs().max_element().max(1.0);
        !(a - b).abs().cmple(Vec4::splat(limit)).all()
    };
    let wrong: Vec<_> = (0..got.len())
        .filter(|&i| off(got[i], expected[i]))
        .collect();
    let first = *wrong.first()?;
    let (x, y) = (first % SIZE.x as usize, first / SIZE.x as usize);
    Some(format!(
        "{} values differ, the first at {x}, {y}: got {}, expected {}",
        wrong.len(),
        got[first],
        expected[first]
    ))
}

/// Asserts that all but `allowed` values agree, where an edge may fall on either side of a pixel.
fn assert_agree(what: &str, got: &[Vec4], expected: &[Vec4], tolerance: f32) {
    if let Some(text) = difference(got, expected, tolerance) {
        panic!("{what}: {text}");
    }
}

fn bring<T: Pod>(gpu: &mut Gpu, size: UVec2, values: &[T]) -> <Gpu as Backend>::Grid<T> {
    gpu.write(size, values).expect("a small grid")
}

/// A CPU's G-buffer on the device.
fn bring_gbuffer(gpu: &mut Gpu, g: &GBuffer<Cpu>) -> GBuffer<Gpu> {
    let size = g.size();
    GBuffer {
        pinhole: g.pinhole,
        surface: bring(gpu, size, g.surface.values()),
        albedo: bring(gpu, size, g.albedo.values()),
        material: bring(gpu, size, g.material.values()),
    }
}

fn assert_gbuffers_agree(
    gpu: &mut Gpu,
    got: &GBuffer<Gpu>,
    expected: &GBuffer<Cpu>,
    tolerance: f32,
) {
    let read = |gpu: &mut Gpu, grid| gpu.read::<Vec4>(grid).expect("a grid").into_owned();
    assert_agree(
        "surface",
        &read(gpu, &got.surface),
        expected.surface.values(),
        tolerance,
    );
    assert_agree(
        "albedo",
        &read(gpu, &got.albedo),
        expected.albedo.values(),
        tolerance,
    );
    assert_agree(
        "material",
        &read(gpu, &got.material),
        expected.material.values(),
        tolerance,
    );
}

fn seen_by_cpu(mirrors: bool) -> GBuffer<Cpu> {
    let mut cpu = Cpu::default();
    let points = cpu.upload(&cloud(3000, mirrors)).expect("points");
    cpu.splat(&points, &pinhole(SIZE), &SplatSettings::default())
        .expect("a G-buffer")
}

fn accumulated(gpu: &mut Gpu) -> (Accumulated, Accumulated) {
    let surfels = cloud(3000, true);
    let settings = SplatSettings::default();
    let points = gpu.upload(&surfels).expect("points");
    let got = gpu
        .accumulate(&points, &pinhole(SIZE), &settings)
        .expect("sums");
    (
        got,
        Splatter::default().accumulate(&surfels, &pinhole(SIZE), &settings),
    )
}

/// Pixels whose integers differ.
fn wrong_pixels(got: &Accumulated, expected: &Accumulated) -> usize {
    let same = |i: usize| {
        got.keys.values()[i] == expected.keys.values()[i]
            && got.counts.values()[i] == expected.counts.values()[i]
            && got.sums.values()[i] == expected.sums.values()[i]
    };
    (0..expected.keys.values().len())
        .filter(|&i| !same(i))
        .count()
}

fn sums_are_equal_to_the_last_bit() {
    let gpu = &mut gpu();
    let (got, expected) = accumulated(gpu);
    let seen = expected.counts.values().iter().filter(|&&n| n > 0).count();
    assert!(seen > 400, "the picture shows something: {seen} pixels");
    let wrong = wrong_pixels(&got, &expected);
    // A graphics card may contract a product and a sum into one rounding; a software adapter does not.
    let allowed = if gpu.device().is_software() {
        0
    } else {
        expected.keys.values().len() / 2
    };
    for i in 0..expected.keys.values().len() {
        if wrong > allowed && got.sums.values()[i] != expected.sums.values()[i] {
            panic!(
                "{wrong} pixels differ, such as {i}: keys {:x} and {:x}, counts {} and {}, sums {:?} and {:?}",
                got.keys.values()[i],
                expected.keys.values()[i],
                got.counts.values()[i],
                expected.counts.values()[i],
                got.sums.values()[i],
                expected.sums.values()[i],
            );
        }
    }
    assert!(wrong <= allowed, "{wrong} pixels have other keys or counts");
}

fn one_flipped_bit_of_a_sum_is_noticed() {
    let (_, expected) = accumulated(&mut gpu());
    let mut flipped = expected.clone();
    flipped.sums.values_mut()[400].albedo[2] ^= 1;
    assert_eq!(
        wrong_pixels(&flipped, &expected),
        1,
        "one flipped bit is one wrong pixel"
    );
}

fn averages_agree() {
    let gpu = &mut gpu();
    let points = gpu.upload(&cloud(3000, true)).expect("points");
    let got = gpu
        .splat(&points, &pinhole(SIZE), &SplatSettings::default())
        .expect("a G-buffer");
    // Shininess passes through an exponential, of which the device promises no more.
    assert_gbuffers_agree(gpu, &got, &seen_by_cpu(true), 2e-5);
}

fn light_maps_are_equal_to_the_last_bit() {
    let gpu = &mut gpu();
    let mut cpu = Cpu::default();
    let surfels = cloud(3000, true);
    let eye = spot().pinhole(45, 10.0);
    let settings = SplatSettings::default();
    let (here, there) = (
        cpu.upload(&surfels).expect("points"),
        gpu.upload(&surfels).expect("points"),
    );
    let expected = cpu.light_map(&here, &eye, &settings).expect("a map");
    let map = gpu.light_map(&there, &eye, &settings).expect("a map");
    let got = gpu.read(&map.keys).expect("keys").into_owned();
    let wrong = got
        .iter()
        .zip(expected.keys.values())
        .filter(|(a, b)| a != b)
        .count();
    let allowed = if gpu.device().is_software() {
        0
    } else {
        got.len() / 2
    };
    let first = (got.iter().zip(expected.keys.values())).find(|(a, b)| a != b);
    assert!(
        wrong <= allowed,
        "{wrong} of {} texels differ, such as {first:x?}",
        got.len()
    );
}

fn filling_agrees_and_counts_the_same_pixels() {
    let gpu = &mut gpu();
    // Smaller splats leave holes to fill.
    let settings = SplatSettings {
        size: 0.8,
        fill: 3,
        ..SplatSettings::default()
    };
    let mut cpu = Cpu::default();
    let points = cpu.upload(&cloud(3000, true)).expect("points");
    let mut expected = cpu
        .splat(&points, &pinhole(UVec2::new(74, 42)), &settings)
        .expect("a G-buffer");
    // What lies far behind its neighbours is a leak; of two side by side none is.
    let size = expected.size();
    for pixel in [(10, 8), (11, 30), (40, 8), (41, 8), (0, 0)] {
        let index = pixel.1 * size.x as usize + pixel.0;
        expected.surface.values_mut()[index].w *= 4.0;
    }
    let mut got = bring_gbuffer(gpu, &expected);
    let before = expected.material.clone();
    let counted = cpu.fill(&mut expected, &settings).expect("filled");
    assert!(
        counted.filled > counted.splatted,
        "there are holes to fill: {counted:?}"
    );
    let leaks = (before.values().iter().zip(expected.material.values()))
        .filter(|(before, after)| before.w == 1.0 && after.w != 1.0)
        .count();
    assert!(leaks > 0, "there are leaks to close");
    assert_eq!(
        gpu.fill(&mut got, &settings).expect("filled"),
        counted,
        "coverage"
    );
    assert_gbuffers_agree(gpu, &got, &expected, 1e-5);
}

fn smoothing_agrees() {
    let gpu = &mut gpu();
    let settings = SplatSettings {
        smooth: 1.5,
        ..SplatSettings::default()
    };
    let mut expected = seen_by_cpu(true);
    let before = expected.surface.clone();
    let mut got = bring_gbuffer(gpu, &expected);
    Cpu::default()
        .smooth(&mut expected, &settings)
        .expect("smoothed");
    assert!(
        difference(before.values(), expected.surface.values(), 1e-3).is_some(),
        "there is something to smooth"
    );
    gpu.smooth(&mut got, &settings).expect("smoothed");
    assert_gbuffers_agree(gpu, &got, &expected, 1e-4);
}

/// A CPU's light map and the same on the device.
fn lights(gpu: &mut Gpu, side: u32) -> (LitBy<Cpu>, LitBy<Gpu>) {
    let mut cpu = Cpu::default();
    let points = cpu.upload(&cloud(3000, false)).expect("points");
    let map = cpu
        .light_map(
            &points,
            &spot().pinhole(side, 10.0),
            &SplatSettings::default(),
        )
        .expect("a map");
    let keys = bring(gpu, UVec2::splat(side), map.keys.values());
    let there = catoptric::backend::LightMap {
        pinhole: map.pinhole,
        keys,
    };
    (
        LitBy { light: spot(), map },
        LitBy {
            light: spot(),
            map: there,
        },
    )
}

fn shading_agrees() {
    let gpu = &mut gpu();
    let (here, there) = lights(gpu, 64);
    let (second_here, second_there) = lights(gpu, 40);
    let seen = seen_by_cpu(true);
    let settings = GiSettings::default();
    let expected = Cpu::default()
        .shade(&seen, &[here, second_here], &settings)
        .expect("radiance");
    let lit = expected.values().iter().filter(|v| v.x > 0.1).count();
    assert!(lit > 50, "the light falls on something: {lit} pixels");
    let seen = bring_gbuffer(gpu, &seen);
    let got = gpu
        .shade(&seen, &[there, second_there], &settings)
        .expect("radiance");
    let got = gpu.read(&got).expect("radiance").into_owned();
    // The penumbra is linear in an angle, whose arc cosine the device gives to about 1e-4.
    assert_agree("radiance", &got, expected.values(), 2e-3);
}

fn without_a_light_everything_is_black() {
    let gpu = &mut gpu();
    let seen = seen_by_cpu(false);
    let expected = Cpu::default()
        .shade(&seen, &[], &GiSettings::default())
        .expect("radiance");
    let seen = bring_gbuffer(gpu, &seen);
    let got = gpu
        .shade(&seen, &[], &GiSettings::default())
        .expect("radiance");
    assert_agree(
        "radiance",
        &gpu.read(&got).expect("radiance"),
        expected.values(),
        0.0,
    );
}

fn eye_dome_lighting_agrees() {
    let gpu = &mut gpu();
    let seen = seen_by_cpu(false);
    let there = bring_gbuffer(gpu, &seen);
    for edl_radius in [1.4, 3.0] {
        let settings = ImageSettings {
            edl_radius,
            edl_strength: 0.1,
            ..ImageSettings::default()
        };
        let expected = Cpu::default().edl(&seen, &settings).expect("a picture");
        let got = gpu.edl(&there, &settings).expect("a picture");
        assert_agree(
            "picture",
            &gpu.read(&got).expect("a picture"),
            expected.values(),
            1e-4,
        );
    }
}

fn one_flipped_value_of_a_picture_is_noticed() {
    let expected = seen_by_cpu(false).albedo.into_vec();
    assert!(
        difference(&expected, &expected, 0.0).is_none(),
        "a picture agrees with itself"
    );
    let mut flipped = expected.clone();
    flipped[300].y += 1e-3;
    assert!(
        difference(&flipped, &expected, 2e-5).is_some(),
        "one changed value is noticed"
    );
    flipped[300].y = f32::NAN;
    assert!(
        difference(&flipped, &expected, 2e-5).is_some(),
        "a value that is no number is noticed"
    );
}

/// Splatted, filled, lit: radiance.
fn picture<B: Backend>(backend: &mut B, surfels: &Arc<Surfels>, size: UVec2) -> Vec<Vec4> {
    let points = backend.upload(surfels).expect("points");
    let settings = SplatSettings::default();
    let mut seen = backend
        .splat(&points, &pinhole(size), &settings)
        .expect("a G-buffer");
    backend.fill(&mut seen, &settings).expect("filled");
    let map = backend
        .light_map(&points, &spot().pinhole(170, 10.0), &settings)
        .expect("a map");
    let lit = backend
        .shade(
            &seen,
            &[LitBy { light: spot(), map }],
            &GiSettings::default(),
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

fn whole_pictures_agree() {
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

fn bands_do_not_show() {
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

fn a_picture_is_the_same_each_time() {
    let surfels = cloud(20_000, true);
    let gpu = &mut gpu();
    let first = picture(&mut **gpu, &surfels, SIZE);
    assert_eq!(
        picture(&mut **gpu, &surfels, SIZE),
        first,
        "the second picture is the first"
    );
    let passes: Vec<_> = gpu
        .take_timings()
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
    assert!(
        Timings::default().passes.is_empty() && gpu.take_timings().passes.is_empty(),
        "times are taken once"
    );
}

fn a_grid_comes_back_as_it_was_written() {
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

fn too_little_memory_is_a_sentence() {
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

fn a_lost_device_is_a_sentence() {
    let mut lost = Gpu::new(&options()).expect("a device");
    let points = lost.upload(&cloud(1000, false)).expect("points");
    lost.device().raw().destroy();
    for _ in 0..2 {
        let error = lost
            .splat(&points, &pinhole(SIZE), &SplatSettings::default())
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

fn an_unknown_adapter_is_answered_with_a_list() {
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
