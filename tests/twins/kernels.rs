//! Every kernel against its CPU twin.

use catoptric::backend::cpu::Cpu;
use catoptric::backend::gpu::Gpu;
use catoptric::backend::{Backend, LightMap, LitBy};
use catoptric::gbuffer::average::average;
use catoptric::gbuffer::splat::{Accumulated, Splatter};
use catoptric::gbuffer::{SplatSettings, depth_from_key};
use catoptric::gi::GiSettings;
use catoptric::image::ImageSettings;
use catoptric::job::Job;
use glam::UVec2;

use super::mirror_splats;
use super::mirrors::bring_mirror;
use super::support::{
    SIZE, assert_agree, assert_gbuffers_agree, bring, bring_gbuffer, cloud, difference, gpu,
    pinhole, seen_by_cpu, spot,
};

fn accumulated(gpu: &mut Gpu) -> (Accumulated, Accumulated) {
    let surfels = cloud(3000, true);
    let settings = SplatSettings::default();
    let points = gpu.upload(&surfels).expect("points");
    let got = gpu.sums(&points, &pinhole(SIZE), &settings).expect("sums");
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

/// Pixels that show something else: a graphics card may contract a product and a sum into one rounding, after which bits
/// differ, and a fragment on the very edge of a disc may come or go, but hardly any pixel changes what it shows.
fn apart_pixels(got: &Accumulated, expected: &Accumulated) -> usize {
    let shown = |a: &Accumulated, i: usize| average(a.keys.values()[i], &a.sums.values()[i]);
    let near = |i: usize| {
        let (a, b) = (shown(got, i), shown(expected, i));
        (a.surface - b.surface).abs().max_element() < 1e-3
            && (a.albedo - b.albedo).abs().max_element() < 1e-3
    };
    (0..expected.keys.values().len())
        .filter(|&i| !near(i))
        .count()
}

pub(super) fn a_pixel_that_shows_something_else_is_noticed() {
    let (_, expected) = accumulated(&mut gpu());
    assert_eq!(
        apart_pixels(&expected, &expected),
        0,
        "a picture is near itself"
    );
    let mut brighter = expected.clone();
    let lit = (0..expected.counts.values().len()).find(|&i| expected.counts.values()[i] > 0);
    let lit = lit.expect("a pixel that shows something");
    brighter.sums.values_mut()[lit].albedo[1] += expected.sums.values()[lit].depth[0] / 100;
    assert_eq!(
        apart_pixels(&brighter, &expected),
        1,
        "one pixel is a hundredth brighter"
    );
}

pub(super) fn sums_are_equal_to_the_last_bit() {
    let gpu = &mut gpu();
    let (got, expected) = accumulated(gpu);
    let seen = expected.counts.values().iter().filter(|&&n| n > 0).count();
    assert!(seen > 400, "the picture shows something: {seen} pixels");
    if !gpu.device().is_software() {
        let apart = apart_pixels(&got, &expected);
        assert!(
            apart <= seen / 50,
            "{apart} of {seen} pixels show something else"
        );
        return;
    }
    let (wrong, allowed) = (wrong_pixels(&got, &expected), 0);
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

pub(super) fn one_flipped_bit_of_a_sum_is_noticed() {
    let (_, expected) = accumulated(&mut gpu());
    let mut flipped = expected.clone();
    flipped.sums.values_mut()[400].albedo[2] ^= 1;
    assert_eq!(
        wrong_pixels(&flipped, &expected),
        1,
        "one flipped bit is one wrong pixel"
    );
}

pub(super) fn averages_agree() {
    let gpu = &mut gpu();
    let points = gpu.upload(&cloud(3000, true)).expect("points");
    let got = gpu
        .splat(
            &points,
            &pinhole(SIZE),
            &SplatSettings::default(),
            &Job::default(),
        )
        .expect("a G-buffer");
    // Shininess passes through an exponential, of which the device promises no more.
    assert_gbuffers_agree(gpu, &got, &seen_by_cpu(true), 2e-5);
}

pub(super) fn light_maps_are_equal_to_the_last_bit() {
    let gpu = &mut gpu();
    let mut cpu = Cpu::default();
    let surfels = cloud(3000, true);
    let eye = spot().pinhole(45, 10.0);
    let settings = SplatSettings::default();
    let (here, there) = (
        cpu.upload(&surfels).expect("points"),
        gpu.upload(&surfels).expect("points"),
    );
    let expected = cpu
        .light_map(&here, &eye, &settings, &Job::default())
        .expect("a map");
    let map = gpu
        .light_map(&there, &eye, &settings, &Job::default())
        .expect("a map");
    let got = gpu.read(&map.keys).expect("keys").into_owned();
    // A graphics card may round depths otherwise, and lose or gain texels at the edges of discs.
    let software = gpu.device().is_software();
    let same = |a: u32, b: u32| {
        let near = depth_from_key(a)
            .zip(depth_from_key(b))
            .is_some_and(|(a, b)| (a / b - 1.0).abs() < 1e-5);
        a == b || (!software && near)
    };
    let wrong = got
        .iter()
        .zip(expected.keys.values())
        .filter(|(a, b)| !same(**a, **b))
        .count();
    let allowed = if software { 0 } else { got.len() / 50 };
    let first = (got.iter().zip(expected.keys.values())).find(|(a, b)| a != b);
    assert!(
        wrong <= allowed,
        "{wrong} of {} texels differ, such as {first:x?}",
        got.len()
    );
}

pub(super) fn filling_agrees_and_counts_the_same_pixels() {
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
        .splat(
            &points,
            &pinhole(UVec2::new(74, 42)),
            &settings,
            &Job::default(),
        )
        .expect("a G-buffer");
    // What lies far behind its neighbours is a leak, also two pixels by two; six by six are a hole.
    let width = expected.size().x as usize;
    let square = |x: usize, y: usize, side: usize| {
        (0..side * side).map(move |i| (y + i / side) * width + x + i % side)
    };
    let alone = [(10, 8), (11, 30), (40, 8), (0, 0)].map(|(x, y)| y * width + x);
    for index in (alone.into_iter())
        .chain(square(25, 8, 2))
        .chain(square(45, 4, 6))
    {
        expected.surface.values_mut()[index].w *= 4.0;
    }
    let mut got = bring_gbuffer(gpu, &expected);
    let before: Vec<f32> = (expected.material.values().iter()).map(|m| m.w).collect();
    let job = Job::default();
    cpu.fill(&mut expected, &settings, &job).expect("filled");
    let counted = cpu.coverage(&expected, &job).expect("counted");
    assert!(
        counted.filled > counted.splatted,
        "there are holes to fill: {counted:?}"
    );
    let leaks = (before.iter().zip(expected.material.values()))
        .filter(|(before, after)| **before == 1.0 && after.w != 1.0)
        .count();
    assert!(leaks > 0, "there are leaks to close");
    let shown = |index: usize| (before[index], expected.material.values()[index].w);
    assert!(
        square(25, 8, 2).all(|i| shown(i).0 != 1.0 || shown(i).1 > 1.0),
        "a leak of two by two closes"
    );
    assert!(
        square(47, 6, 2).all(|i| shown(i).0 != 1.0 || shown(i).1 == 1.0),
        "the middle of a hole stays"
    );
    gpu.fill(&mut got, &settings, &job).expect("filled");
    assert_eq!(
        gpu.coverage(&got, &job).expect("counted"),
        counted,
        "coverage"
    );
    assert_gbuffers_agree(gpu, &got, &expected, 1e-5);
}

pub(super) fn smoothing_agrees() {
    let gpu = &mut gpu();
    let settings = SplatSettings {
        smooth: 1.5,
        ..SplatSettings::default()
    };
    let mut expected = seen_by_cpu(true);
    let before = expected.surface.clone();
    let mut got = bring_gbuffer(gpu, &expected);
    Cpu::default()
        .smooth(&mut expected, &settings, &Job::default())
        .expect("smoothed");
    assert!(
        difference(before.values(), expected.surface.values(), 1e-3).is_some(),
        "there is something to smooth"
    );
    gpu.smooth(&mut got, &settings, &Job::default())
        .expect("smoothed");
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
            &Job::default(),
        )
        .expect("a map");
    let keys = bring(gpu, UVec2::splat(side), map.keys.values());
    let there = LightMap {
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

pub(super) fn shading_agrees() {
    let gpu = &mut gpu();
    let (here, there) = lights(gpu, 64);
    let (second_here, second_there) = lights(gpu, 40);
    let seen = seen_by_cpu(true);
    let settings = GiSettings::default();
    let expected = Cpu::default()
        .shade(&seen, &[here, second_here], &settings, &Job::default())
        .expect("radiance");
    let lit = expected.values().iter().filter(|v| v.x > 0.1).count();
    assert!(lit > 50, "the light falls on something: {lit} pixels");
    let seen = bring_gbuffer(gpu, &seen);
    let got = gpu
        .shade(&seen, &[there, second_there], &settings, &Job::default())
        .expect("radiance");
    let got = gpu.read(&got).expect("radiance").into_owned();
    // The penumbra is linear in an angle, whose arc cosine the device gives to about 1e-4.
    assert_agree("radiance", &got, expected.values(), 2e-3);
}

pub(super) fn shading_of_mirrors_agrees() {
    let gpu = &mut gpu();
    let shown = mirror_splats::shown();
    let there = bring_mirror(gpu, &shown);
    let (settings, job) = (GiSettings::default(), Job::default());
    let (here, lit) = lights(gpu, 64);
    let (second_here, second_lit) = lights(gpu, 40);
    for (here, lit) in [
        (vec![here, second_here], vec![lit, second_lit]),
        (Vec::new(), Vec::new()),
    ] {
        let expected = Cpu::default()
            .shade_mirror(&shown, &here, &settings, &job)
            .expect("radiance");
        let bright = expected.values().iter().filter(|v| v.x > 0.1).count();
        assert!(here.is_empty() || bright > 100, "{bright} pixels are lit");
        let got = gpu
            .shade_mirror(&there, &lit, &settings, &job)
            .expect("radiance");
        let got = gpu.read(&got).expect("radiance").into_owned();
        // As for `shading_agrees`.
        assert_agree("radiance", &got, expected.values(), 2e-3);
    }
}

pub(super) fn without_a_light_everything_is_black() {
    let gpu = &mut gpu();
    let seen = seen_by_cpu(false);
    let expected = Cpu::default()
        .shade(&seen, &[], &GiSettings::default(), &Job::default())
        .expect("radiance");
    let seen = bring_gbuffer(gpu, &seen);
    let got = gpu
        .shade(&seen, &[], &GiSettings::default(), &Job::default())
        .expect("radiance");
    assert_agree(
        "radiance",
        &gpu.read(&got).expect("radiance"),
        expected.values(),
        0.0,
    );
}

pub(super) fn eye_dome_lighting_agrees() {
    let gpu = &mut gpu();
    let seen = seen_by_cpu(false);
    let there = bring_gbuffer(gpu, &seen);
    for edl_radius in [1.4, 3.0] {
        let settings = ImageSettings {
            edl_radius,
            edl_strength: 0.1,
            ..ImageSettings::default()
        };
        let expected = Cpu::default()
            .edl(&seen, &settings, &Job::default())
            .expect("a picture");
        let got = gpu
            .edl(&there, &settings, &Job::default())
            .expect("a picture");
        assert_agree(
            "picture",
            &gpu.read(&got).expect("a picture"),
            expected.values(),
            1e-4,
        );
    }
}

pub(super) fn one_flipped_value_of_a_picture_is_noticed() {
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
