//! The furnace: the inside of a ball with albedo 1/2 and a point light of pi W/sr in its centre shines evenly, 1/2 by direct
//! light, and each bounce adds half of the one before.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use catoptric::backend::Backend;
use catoptric::backend::cpu::Cpu;
use catoptric::cloud::{Finish, Place, Surfel, Surfels};
use catoptric::frame::View;
use catoptric::gi::vpl::{LitMap, vpls};
use catoptric::gi::{SpotLight, vpl_pinhole};
use catoptric::job::Job;
use catoptric::plan::{Plan, SceneFacts};
use catoptric::renderer::{BackendChoice, Renderer};
use catoptric::settings::Settings;
use glam::{DVec3, UVec2, Vec3};
use libtest_mimic::Trial;

use crate::support::{claim, gpu_is_missing};

/// Points of the ball.
const POINTS: usize = 200_000;

const SIZE: UVec2 = UVec2::new(96, 72);

/// Side of the blocks in which pictures are compared, pixels.
const BLOCK: usize = 8;

pub(super) fn tests() -> Vec<Trial> {
    let on_gpu = Trial::test("indirect::the_furnace_shines_on_gpu", || {
        furnace(&BackendChoice::Gpu(None));
        Ok(())
    });
    vec![
        claim("indirect::the_furnace_shines_on_cpu", || {
            furnace(&BackendChoice::Cpu);
        }),
        on_gpu.with_ignored_flag(gpu_is_missing()),
        claim(
            "indirect::a_plate_in_the_furnace_shadows_as_a_monte_carlo_says",
            a_plate_in_the_furnace_shadows_as_a_monte_carlo_says,
        ),
        claim("indirect::extremes_stay_numbers", extremes_stay_numbers),
        claim(
            "indirect::the_light_of_two_lamps_is_the_sum_of_both",
            the_light_of_two_lamps_is_the_sum_of_both,
        ),
    ]
}

/// A plate across the ball: a disc, black.
#[derive(Clone, Copy)]
pub(super) struct Plate {
    z: f64,
    radius: f64,
}

const PLATE: Plate = Plate {
    z: -0.3,
    radius: 0.5,
};

impl Plate {
    /// Whether it lies between two points.
    fn blocks(self, a: DVec3, b: DVec3) -> bool {
        let t = (self.z - a.z) / (b.z - a.z);
        let at = a + (b - a) * t;
        t > 0.0 && t < 1.0 && at.x * at.x + at.y * at.y < self.radius * self.radius
    }
}

/// The inside of the unit ball with this albedo, and a plate.
pub(super) fn ball(points: usize, albedo: f32, plate: Option<Plate>) -> Arc<Surfels> {
    let spacing = (4.0 * PI / points as f64).sqrt() as f32;
    let golden = PI * (3.0 - 5f64.sqrt());
    let place = |i: usize, count: usize| (i as f64 + 0.5) / count as f64;
    let mut all: Vec<(DVec3, DVec3, f32)> = (0..points)
        .map(|i| {
            let z = 1.0 - 2.0 * place(i, points);
            let (sin, cos) = (golden * i as f64).sin_cos();
            let out = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
            (out, -out, albedo)
        })
        .collect();
    if let Some(plate) = plate {
        let count = (plate.radius * plate.radius * points as f64 / 4.0) as usize;
        all.extend((0..count).map(|i| {
            let (sin, cos) = (golden * i as f64).sin_cos();
            let r = plate.radius * place(i, count).sqrt();
            (DVec3::new(r * cos, r * sin, plate.z), DVec3::Z, 0.0)
        }));
    }
    // Shuffled, as clouds are: slices are samples.
    let mut numbers = Numbers(3);
    for i in (1..all.len()).rev() {
        all.swap(i, (numbers.next() * (i + 1) as f64) as usize);
    }
    let points =
        (all.into_iter()).map(|(position, normal, albedo)| Point::new(position, normal, albedo));
    surfels(points.collect(), spacing)
}

/// A point of a scene.
#[derive(Clone, Copy)]
pub(super) struct Point {
    pub(super) position: DVec3,
    pub(super) normal: DVec3,
    pub(super) albedo: f32,
    pub(super) mirror: f32,
}

impl Point {
    pub(super) fn new(position: DVec3, normal: DVec3, albedo: f32) -> Self {
        Self {
            position,
            normal,
            albedo,
            mirror: 0.0,
        }
    }
}

/// Points as a cloud; their order makes slices samples.
pub(super) fn surfels(points: Vec<Point>, spacing: f32) -> Arc<Surfels> {
    let place = |point: &Point| Place {
        position: point.position.as_vec3(),
        radius: spacing,
    };
    let finish = |point: &Point| {
        Finish::pack(&Surfel {
            position: point.position.as_vec3(),
            radius: spacing,
            normal: point.normal.as_vec3(),
            albedo: Vec3::splat(point.albedo),
            mirror: point.mirror,
            specular: 0.0,
            shininess: 0.0,
        })
    };
    Arc::new(Surfels {
        places: points.iter().map(place).collect(),
        finishes: points.iter().map(finish).collect(),
        source: (0..points.len() as u32).collect(),
        origin: DVec3::ZERO,
    })
}

pub(super) fn view(lights: Vec<SpotLight>) -> View {
    let (eye, target) = (DVec3::new(0.3, 0.1, 0.55), DVec3::new(-0.2, 0.0, -0.6));
    View {
        pinhole: super::camera(eye, target, SIZE),
        lights,
        environment: None,
        bounds: (Vec3::NEG_ONE, Vec3::ONE),
    }
}

pub(super) fn in_the_centre() -> Vec<SpotLight> {
    SpotLight::all_around(Vec3::ZERO, Vec3::splat(std::f32::consts::PI)).to_vec()
}

/// Radiance of every pixel.
pub(super) fn render(
    surfels: &Arc<Surfels>,
    view: &View,
    settings: &Settings,
    choice: &BackendChoice,
) -> Vec<f32> {
    let facts = SceneFacts {
        points: surfels.len() as u64,
        mirror_points: surfels.finishes.iter().filter(|f| f.mirror() > 0.0).count() as u64,
        lights: view.lights.len(),
        environment: view.environment.is_some(),
    };
    let plan = Plan::new(&facts, settings);
    let mut renderer = Renderer::new(choice, surfels).expect("a backend");
    let products = renderer
        .render(view, &plan, settings, &Job::default())
        .expect("a picture");
    products.radiance.values().iter().map(|v| v.x).collect()
}

pub(super) fn lit_by(vpls: u32, bounces: u32) -> Settings {
    let mut settings = Settings::default();
    settings.gi.vpl_count = vpls;
    settings.gi.bounces = bounces;
    settings
}

/// Means of the blocks of a picture in which all of `counts` count.
fn blocks(values: &[f64], counts: &[bool]) -> Vec<f64> {
    let (columns, rows) = (SIZE.x as usize / BLOCK, SIZE.y as usize / BLOCK);
    let pixels = |b: usize| {
        let (x, y) = (b % columns * BLOCK, b / columns * BLOCK);
        (0..BLOCK * BLOCK).map(move |i| (y + i / BLOCK) * SIZE.x as usize + x + i % BLOCK)
    };
    (0..columns * rows)
        .filter(|&b| pixels(b).all(|i| counts[i]))
        .map(|b| pixels(b).map(|i| values[i]).sum::<f64>() / (BLOCK * BLOCK) as f64)
        .collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn furnace(choice: &BackendChoice) {
    let surfels = ball(POINTS, 0.5, None);
    for (vpls, bounces, expected) in [
        (0, 1, 0.5),
        (1024, 1, 0.75),
        (1024, 2, 0.875),
        (1024, 12, 1.0),
    ] {
        let got = render(
            &surfels,
            &view(in_the_centre()),
            &lit_by(vpls, bounces),
            choice,
        );
        let got: Vec<f64> = got.into_iter().map(f64::from).collect();
        let all = mean(&got);
        let what = format!("{vpls} lights, {bounces} bounces");
        assert!(
            (all / expected - 1.0).abs() < 0.03,
            "{what}: got {all}, expected {expected}"
        );
        let blocks = blocks(&got, &vec![true; got.len()]);
        let worst = blocks
            .iter()
            .fold(0.0f64, |w, b| w.max((b / expected - 1.0).abs()));
        println!(
            "{what}: {all:.4}, worst block off by {:.1} %",
            worst * 100.0
        );
        assert!(worst < 0.1, "{what}: a block is off by {worst}");
    }
}

/// Random numbers, 0 to 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = (self.0)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// What every pixel sees after one bounce, W/sr/m2, by following rays; and whether it sees the ball.
fn monte_carlo(view: &View) -> (Vec<f64>, Vec<bool>) {
    let mut numbers = Numbers(7);
    let direct = |y: DVec3| {
        if PLATE.blocks(DVec3::ZERO, y) {
            0.0
        } else {
            0.5
        }
    };
    let mut pixel = |i: u32| {
        let centre = glam::Vec2::new((i % SIZE.x) as f32 + 0.5, (i / SIZE.x) as f32 + 0.5);
        let eye = view.pinhole.eye.as_dvec3();
        let towards = view.pinhole.direction(centre).as_dvec3().normalize();
        let along = eye.dot(towards);
        let seen = eye + towards * ((along * along + 1.0 - eye.length_squared()).sqrt() - along);
        if PLATE.blocks(eye, seen) {
            return (0.0, false);
        }
        // From a point inside of a ball, rays by the cosine fall evenly on all of it.
        let rays = 400;
        let arrived: f64 = (0..rays)
            .map(|_| {
                let z = 2.0 * numbers.next() - 1.0;
                let (sin, cos) = (TAU * numbers.next()).sin_cos();
                let y = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
                if PLATE.blocks(seen, y) {
                    0.0
                } else {
                    direct(y)
                }
            })
            .sum();
        (direct(seen) + 0.5 * arrived / f64::from(rays), true)
    };
    (0..SIZE.x * SIZE.y).map(&mut pixel).unzip()
}

/// Mean error of blocks over the mean.
fn block_error(got: &[f32], expected: &[f64], counts: &[bool]) -> f64 {
    let got: Vec<f64> = got.iter().copied().map(f64::from).collect();
    let (a, b) = (blocks(&got, counts), blocks(expected, counts));
    let off: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).collect();
    mean(&off) / mean(&b)
}

fn a_plate_in_the_furnace_shadows_as_a_monte_carlo_says() {
    let surfels = ball(POINTS, 0.5, Some(PLATE));
    let view = view(in_the_centre());
    let (expected, counts) = monte_carlo(&view);
    let got = render(&surfels, &view, &lit_by(1024, 1), &BackendChoice::Cpu);
    let error = block_error(&got, &expected, &counts);
    // Maps that show one point shadow nothing.
    let mut blind = lit_by(1024, 1);
    blind.gi.ism_points = 1;
    let blind = block_error(
        &render(&surfels, &view, &blind, &BackendChoice::Cpu),
        &expected,
        &counts,
    );
    println!("blocks are off by {error:.4}; {blind:.4} without visibility");
    assert!(error < 0.03, "blocks are off by {error}");
    assert!(blind > 2.0 * error, "without visibility: {blind}");
}

/// A lamp near the ball's middle that shines along x.
fn along_x(direction: f32, intensity: f32) -> SpotLight {
    SpotLight {
        position: Vec3::ZERO,
        axis: Vec3::X * direction,
        intensity: Vec3::splat(intensity),
        inner_angle: 0.4,
        outer_angle: 0.6,
        pyramid: false,
    }
}

fn the_light_of_two_lamps_is_the_sum_of_both() {
    let surfels = ball(POINTS, 0.5, Some(PLATE));
    let settings = lit_by(1024, 2);
    let of =
        |lights: Vec<SpotLight>| render(&surfels, &view(lights), &settings, &BackendChoice::Cpu);
    let (weak, strong) = (along_x(-1.0, 2.0), along_x(1.0, 6.0));
    let (one, other) = (of(vec![weak]), of(vec![strong]));
    let sum: Vec<f64> = (one.iter().zip(&other))
        .map(|(a, b)| f64::from(*a) + f64::from(*b))
        .collect();
    let counts = vec![true; sum.len()];
    let error = block_error(&of(vec![weak, strong]), &sum, &counts);
    let control = block_error(&of(vec![strong, strong]), &sum, &counts);
    println!("blocks are off by {error:.4}; {control:.4} with the wrong lamps");
    assert!(error < 0.02, "blocks are off by {error}");
    assert!(control > 0.1, "other lamps are noticed: {control}");
    // Of the virtual lights each lamp has a share by what it lights.
    let mut cpu = Cpu::default();
    let points = cpu.upload(&surfels).expect("points");
    let maps = [weak, strong].map(|light| LitMap {
        light,
        gbuffer: cpu
            .splat(
                &points,
                &vpl_pinhole(&light, 10.0),
                &settings.splat,
                &Job::default(),
            )
            .expect("what the lamp sees"),
    });
    let lights = vpls(&maps, 400);
    let of_strong = lights.iter().filter(|v| v.position.x > 0.0).count();
    assert!(
        of_strong.abs_diff(300) <= 4,
        "{of_strong} of {} lights are the stronger lamp's",
        lights.len()
    );
}

fn extremes_stay_numbers() {
    let sound = ball(2000, 0.5, None);
    let black = ball(2000, 0.0, None);
    let one = {
        let mut one = (*sound).clone();
        one.places.truncate(1);
        one.finishes.truncate(1);
        one.source.truncate(1);
        Arc::new(one)
    };
    let mirrors = {
        let mut all = (*sound).clone();
        for finish in &mut all.finishes {
            finish.0[3] |= 0xff;
        }
        Arc::new(all)
    };
    let spot = |position: Vec3, axis: Vec3| {
        vec![SpotLight {
            position,
            axis,
            intensity: Vec3::splat(6.0),
            inner_angle: 0.4,
            outer_angle: 0.6,
            pyramid: false,
        }]
    };
    let cases = [
        ("no virtual light", &sound, in_the_centre(), 0),
        ("one virtual light", &sound, in_the_centre(), 1),
        ("many virtual lights", &sound, in_the_centre(), 65_536),
        ("black walls", &black, in_the_centre(), 64),
        ("one point", &one, in_the_centre(), 64),
        ("mirrors alone", &mirrors, in_the_centre(), 64),
        (
            "a light in the wall",
            &sound,
            spot(Vec3::X, Vec3::NEG_X),
            64,
        ),
        (
            "a light outside",
            &sound,
            spot(Vec3::X * 3.0, Vec3::NEG_X),
            64,
        ),
        (
            "a light that looks away",
            &sound,
            spot(Vec3::X * 3.0, Vec3::X),
            64,
        ),
    ];
    for (what, surfels, lights, vpls) in cases {
        let mut settings = lit_by(vpls, 2);
        if vpls > 1000 {
            settings.gi.ism_size = 16;
            settings.gi.ism_points = 50;
        }
        let got = render(surfels, &view(lights), &settings, &BackendChoice::Cpu);
        let sound = got.iter().all(|v| v.is_finite() && *v >= 0.0);
        assert!(sound, "{what}: every pixel is a number, not below 0");
    }
}
