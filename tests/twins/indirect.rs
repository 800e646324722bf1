//! The kernels of indirect light against their CPU twins.

use catoptric::backend::Backend;
use catoptric::backend::cpu::Cpu;
use catoptric::backend::gpu::{Gpu, GpuOptions};
use catoptric::gbuffer::SplatSettings;
use catoptric::gi::gather::Gathered;
use catoptric::gi::indirect_filter::Window;
use catoptric::gi::ism::{IsmMaps, Slices};
use catoptric::gi::photons::{Photon, PhotonMap};
use catoptric::gi::receivers::Receivers;
use catoptric::gi::vpl::{LitMap, Vpl, vpls};
use catoptric::gi::{GiSettings, vpl_pinhole};
use catoptric::grid::Grid;
use catoptric::job::Job;
use catoptric::reflect::{Eye, MirrorGBuffer, Surface};
use glam::{Vec3, Vec4};

use super::support::{
    SIZE, assert_agree, bring, bring_gbuffer, cloud, difference, gpu, options, seen_by_cpu, spot,
};

/// No power of two, so that parts of lights are unequal.
const VPLS: u32 = 50;

const INTERLEAVE: u32 = 3;

/// Lights drawn from what the spot sees, each with its slice of the cloud.
fn lights(slices: &Slices) -> Vec<Vpl> {
    let mut cpu = Cpu::default();
    let points = cpu.upload(&cloud(3000, true)).expect("points");
    let pinhole = vpl_pinhole(&spot(), 10.0);
    let settings = SplatSettings::default();
    let seen = cpu
        .splat(&points, &pinhole, &settings, &Job::default())
        .expect("what the light sees");
    let map = LitMap {
        light: spot(),
        gbuffer: seen,
    };
    let mut lights = vpls(&[map], VPLS);
    assert_eq!(lights.len(), VPLS as usize, "as many as asked for");
    for (number, light) in (0..).zip(&mut lights) {
        light.slice = slices.first(number);
    }
    assert!(lights.iter().any(|l| l.specular > 0.0), "some are glossy");
    lights
}

fn slices() -> Slices {
    // The last slices begin anew.
    Slices::of(3000, 24, 700)
}

fn cpu_maps() -> (Vec<Vpl>, IsmMaps<Cpu>) {
    let lights = lights(&slices());
    let mut cpu = Cpu::default();
    let points = cpu.upload(&cloud(3000, true)).expect("points");
    let maps = cpu
        .ism(&points, &lights, slices(), &Job::default())
        .expect("maps");
    (lights, maps)
}

fn bring_receivers(gpu: &mut Gpu, r: &Receivers<Cpu>) -> Receivers<Gpu> {
    Receivers {
        size: r.size,
        position: bring(gpu, r.size, r.position.values()),
        normal: bring(gpu, r.size, r.normal.values()),
        view: bring(gpu, r.size, r.view.values()),
    }
}

fn read(gpu: &mut Gpu, grid: &<Gpu as Backend>::Grid<Vec4>) -> Vec<Vec4> {
    gpu.read(grid).expect("a grid").into_owned()
}

fn assert_receivers_agree(gpu: &mut Gpu, got: &Receivers<Gpu>, expected: &Receivers<Cpu>) {
    let lit = expected.position.values().iter().filter(|p| p.w > 0.0);
    assert!(lit.count() > 100, "something is to be lit");
    for (what, got, expected) in [
        ("position", &got.position, &expected.position),
        ("normal", &got.normal, &expected.normal),
        ("view", &got.view, &expected.view),
    ] {
        assert_agree(what, &read(gpu, got), expected.values(), 1e-6);
    }
}

pub(super) fn receivers_agree() {
    let gpu = &mut gpu();
    let gbuffer = seen_by_cpu(true);
    let here = bring_gbuffer(gpu, &gbuffer);
    let got = gpu.receivers(&here, &Job::default()).expect("receivers");
    assert_receivers_agree(gpu, &got, &Receivers::of(&gbuffer));
}

/// Mirrors that show what the camera sees.
fn shown_in_mirrors() -> MirrorGBuffer<Cpu> {
    let seen = seen_by_cpu(false);
    let mut mirror = MirrorGBuffer::of(&Surface::<Cpu> {
        size: SIZE,
        point: Grid::new(SIZE, Vec3::new(0.1, 0.2, 1.0).extend(1.0)),
        normal: Grid::new(SIZE, Vec3::new(0.0, 0.6, 0.8).extend(0.01)),
        eye: Eye::Point(Vec3::new(0.5, 0.2, 2.0)),
    });
    mirror.surface = seen.surface;
    mirror.albedo = seen.albedo;
    mirror.material = seen.material;
    mirror
}

pub(super) fn receivers_in_mirrors_agree() {
    let gpu = &mut gpu();
    let mirror = shown_in_mirrors();
    let expected = Receivers::of_mirror(&mirror);
    let here = mirror.put(&mut **gpu).expect("a mirror");
    let got = gpu
        .mirror_receivers(&here, &Job::default())
        .expect("receivers");
    assert_receivers_agree(gpu, &got, &expected);
}

/// Texels that differ.
fn wrong_texels(got: &[u32], expected: &[u32]) -> usize {
    got.iter().zip(expected).filter(|(a, b)| a != b).count()
}

fn maps_on(gpu: &mut Gpu, lights: &[Vpl]) -> IsmMaps<Gpu> {
    let points = gpu.upload(&cloud(3000, true)).expect("points");
    gpu.ism(&points, lights, slices(), &Job::default())
        .expect("maps")
}

pub(super) fn imperfect_shadow_maps_are_equal_to_the_last_bit() {
    let gpu = &mut gpu();
    let (lights, expected) = cpu_maps();
    let filled = (expected.keys.values().iter())
        .filter(|&&key| key != u32::MAX)
        .count();
    assert!(
        filled * 5 > expected.keys.values().len(),
        "maps show something: {filled} texels"
    );
    let got = maps_on(gpu, &lights);
    let got = gpu.read(&got.keys).expect("keys").into_owned();
    let wrong = wrong_texels(&got, expected.keys.values());
    // A graphics card may round otherwise, and gain or lose texels at the edges of discs.
    let allowed = if gpu.device().is_software() {
        0
    } else {
        got.len() / 50
    };
    assert!(wrong <= allowed, "{wrong} of {} texels differ", got.len());
    let mut flipped = got.clone();
    flipped[700] ^= 1;
    assert_eq!(
        wrong_texels(&flipped, &got),
        1,
        "one flipped bit is noticed"
    );
}

fn cpu_gathered(receivers: &Receivers<Cpu>, lights: &[Vpl], maps: &IsmMaps<Cpu>) -> Gathered<Cpu> {
    let mut gathered = Gathered {
        irradiance: Grid::new(SIZE, Vec4::splat(0.25)),
        residual: Grid::new(SIZE, Vec4::ZERO),
    };
    Cpu::default()
        .gather(
            receivers,
            lights,
            maps,
            INTERLEAVE,
            &mut gathered,
            &Job::default(),
        )
        .expect("light");
    gathered
}

fn gathered_on(gpu: &mut Gpu, receivers: &Receivers<Cpu>, lights: &[Vpl]) -> Gathered<Gpu> {
    let here = bring_receivers(gpu, receivers);
    let maps = maps_on(gpu, lights);
    let mut gathered = Gathered {
        irradiance: bring(gpu, SIZE, Grid::new(SIZE, Vec4::splat(0.25)).values()),
        residual: bring(gpu, SIZE, Grid::new(SIZE, Vec4::ZERO).values()),
    };
    gpu.gather(
        &here,
        lights,
        &maps,
        INTERLEAVE,
        &mut gathered,
        &Job::default(),
    )
    .expect("light");
    gathered
}

pub(super) fn gathering_agrees() {
    let gpu = &mut gpu();
    let (lights, maps) = cpu_maps();
    let receivers = Receivers::of(&seen_by_cpu(true));
    let expected = cpu_gathered(&receivers, &lights, &maps);
    assert!(
        expected.irradiance.values().iter().any(|v| v.x > 0.3),
        "something is lit"
    );
    let got = gathered_on(gpu, &receivers, &lights);
    let (irradiance, residual) = (read(gpu, &got.irradiance), read(gpu, &got.residual));
    assert_agree(
        "irradiance",
        &irradiance,
        expected.irradiance.values(),
        1e-4,
    );
    assert_agree("residual", &residual, expected.residual.values(), 1e-4);
    let mut brighter = irradiance.clone();
    brighter[300].x += 1e-3;
    assert!(
        difference(&brighter, &irradiance, 1e-4).is_some(),
        "a thousandth is noticed"
    );
}

pub(super) fn bands_of_maps_do_not_show() {
    let (lights, _) = cpu_maps();
    let receivers = Receivers::of(&seen_by_cpu(true));
    // 16 KiB a binding: 7 maps, 1024 surfels.
    let mut banded = Gpu::new(&GpuOptions {
        binding_limit: Some(1 << 14),
        ..options()
    })
    .expect("a device");
    let expected = {
        let gpu = &mut gpu();
        let light = gathered_on(gpu, &receivers, &lights);
        read(gpu, &light.irradiance)
    };
    let light = gathered_on(&mut banded, &receivers, &lights);
    assert_eq!(
        read(&mut banded, &light.irradiance),
        expected,
        "the banded light is the same"
    );
}

pub(super) fn settled_positions_are_equal_to_the_last_bit() {
    let gpu = &mut gpu();
    let receivers = Receivers::of(&seen_by_cpu(true));
    // A band of closed pixels, wider than the reach, and single ones.
    let mut level = Grid::new(SIZE, 0.0);
    for (i, value) in level.values_mut().iter_mut().enumerate() {
        let row = i / SIZE.x as usize;
        *value = if row < 10 || i % 5 == 0 { 2.0 } else { -1.0 };
    }
    let expected = Cpu::default()
        .settle(&receivers, &level, &Job::default())
        .expect("positions");
    let moved = wrong_places(expected.values(), receivers.position.values());
    assert!(moved > 30, "some are moved: {moved}");
    let here = bring_receivers(gpu, &receivers);
    let there = bring(gpu, SIZE, level.values());
    let got = gpu
        .settle(&here, &there, &Job::default())
        .expect("positions");
    assert_eq!(wrong_places(&read(gpu, &got), expected.values()), 0);
}

/// Places that differ.
fn wrong_places(got: &[Vec4], expected: &[Vec4]) -> usize {
    got.iter().zip(expected).filter(|(a, b)| a != b).count()
}

pub(super) fn merging_agrees() {
    let gpu = &mut gpu();
    let (lights, maps) = cpu_maps();
    let receivers = Receivers::of(&seen_by_cpu(true));
    let light = cpu_gathered(&receivers, &lights, &maps).irradiance;
    let here = bring_receivers(gpu, &receivers);
    let there = bring(gpu, SIZE, light.values());
    for window in [Window::of(4, 1), Window::of(3, 2)] {
        let expected = Cpu::default()
            .indirect_filter(&receivers, &light, window, &Job::default())
            .expect("merged");
        let got = gpu
            .indirect_filter(&here, &there, window, &Job::default())
            .expect("merged");
        let got = read(gpu, &got);
        assert_agree("merged", &got, expected.values(), 1e-5);
        assert!(
            difference(&got, light.values(), 1e-3).is_some(),
            "merging changes something"
        );
    }
}

/// Photons all over the scene.
fn photons() -> PhotonMap {
    let photon = |i: u32| {
        let part = |k: u32| (i * k % 101) as f32 / 101.0;
        Photon {
            position: Vec3::new(part(7) * 3.0 - 1.5, part(13) * 2.0 - 1.0, -2.0 * part(29)),
            normal: Vec3::new(0.0, part(3), 1.0).normalize(),
            irradiance: Vec3::new(0.1, part(5), part(11)),
            pad0: 0.0,
            pad1: 0.0,
            pad2: 0.0,
        }
    };
    PhotonMap::sorted(0.3, (0..400).map(photon).collect())
}

pub(super) fn photons_agree() {
    let gpu = &mut gpu();
    let receivers = Receivers::of(&seen_by_cpu(true));
    let map = photons();
    assert!(
        map.cells.element_product() > 50,
        "many cubes: {}",
        map.cells
    );
    let mut expected = Grid::new(SIZE, Vec4::splat(0.25));
    Cpu::default()
        .photons(&receivers, &map, &mut expected, &Job::default())
        .expect("light");
    assert!(
        expected.values().iter().any(|v| v.y > 0.5),
        "photons reach something"
    );
    let here = bring_receivers(gpu, &receivers);
    let mut got = bring(gpu, SIZE, Grid::new(SIZE, Vec4::splat(0.25)).values());
    gpu.photons(&here, &map, &mut got, &Job::default())
        .expect("light");
    assert_agree("photons", &read(gpu, &got), expected.values(), 1e-5);
}

pub(super) fn indirect_radiance_agrees() {
    let gpu = &mut gpu();
    let seen = seen_by_cpu(true);
    let (lights, maps) = cpu_maps();
    let light = cpu_gathered(&Receivers::of(&seen), &lights, &maps);
    let settings = GiSettings {
        albedo_scale: 0.7,
        ..GiSettings::default()
    };
    let mut expected = Grid::new(SIZE, Vec4::splat(0.1));
    Cpu::default()
        .add_indirect(
            &seen.albedo,
            &light,
            &settings,
            &mut expected,
            &Job::default(),
        )
        .expect("radiance");
    let here = Gathered {
        irradiance: bring(gpu, SIZE, light.irradiance.values()),
        residual: bring(gpu, SIZE, light.residual.values()),
    };
    let albedo = bring(gpu, SIZE, seen.albedo.values());
    let mut got = bring(gpu, SIZE, Grid::new(SIZE, Vec4::splat(0.1)).values());
    gpu.add_indirect(&albedo, &here, &settings, &mut got, &Job::default())
        .expect("radiance");
    assert_agree("radiance", &read(gpu, &got), expected.values(), 1e-5);
}
