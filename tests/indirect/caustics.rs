//! Light that a mirror throws on a surface: a flat mirror shines as the lamp would from behind it.

use std::sync::Arc;

use catoptric::cloud::Surfels;
use catoptric::frame::View;
use catoptric::gi::SpotLight;
use catoptric::renderer::BackendChoice;
use catoptric::settings::Settings;
use glam::{DVec3, UVec2, Vec2, Vec3};
use libtest_mimic::Trial;

use super::furnace::{Point, render, surfels};
use crate::support::{claim, gpu_is_missing};

const SIZE: UVec2 = UVec2::new(96, 72);

/// Side of the blocks in which pictures are compared, pixels.
const BLOCK: usize = 8;

const ALBEDO: f32 = 0.5;

pub(super) fn tests() -> Vec<Trial> {
    let on_gpu = Trial::test(
        "indirect::a_flat_mirror_shines_as_the_lamp_behind_it_on_gpu",
        || {
            a_flat_mirror_shines_as_the_lamp_behind_it(&BackendChoice::Gpu(None));
            Ok(())
        },
    );
    vec![
        claim(
            "indirect::a_flat_mirror_shines_as_the_lamp_behind_it_on_cpu",
            || a_flat_mirror_shines_as_the_lamp_behind_it(&BackendChoice::Cpu),
        ),
        on_gpu.with_ignored_flag(gpu_is_missing()),
    ]
}

/// A lamp 1 m over the floor that shines along `towards` x.
fn lamp(x: f32, towards: f32) -> SpotLight {
    SpotLight {
        position: Vec3::new(x, 0.0, 1.0),
        axis: Vec3::X * towards,
        intensity: Vec3::splat(6.0),
        inner_angle: 25f32.to_radians(),
        outer_angle: 30f32.to_radians(),
        pyramid: false,
    }
}

/// A floor from x = -3 to 1, and a mirror that stands at x = 1 and holds all of the lamp's cone.
fn floor_and_mirror() -> Arc<Surfels> {
    let count = 200_000;
    let spacing = (20.0 / f64::from(count)).sqrt();
    let place = |i: u32, step: f64| (f64::from(i) * step).fract();
    let point = |i: u32| {
        let (u, v) = (place(i, 0.754_877_666), place(i, 0.569_840_291));
        if i.is_multiple_of(5) {
            let at = DVec3::new(1.0, 2.0 * v - 1.0, 2.0 * u);
            Point {
                mirror: 1.0,
                ..Point::new(at, DVec3::NEG_X, 0.0)
            }
        } else {
            let at = DVec3::new(4.0 * u - 3.0, 4.0 * v - 2.0, 0.0);
            Point::new(at, DVec3::Z, ALBEDO)
        }
    };
    surfels((0..count).map(point).collect(), spacing as f32)
}

fn a_flat_mirror_shines_as_the_lamp_behind_it(choice: &BackendChoice) {
    let scene = floor_and_mirror();
    let view = View {
        pinhole: super::camera(DVec3::new(-1.2, 0.0, 0.8), DVec3::new(-1.2, 0.0, 0.0), SIZE),
        lights: vec![lamp(0.0, 1.0)],
        environment: None,
        bounds: (Vec3::new(-3.0, -2.0, 0.0), Vec3::new(1.0, 2.0, 2.0)),
    };
    let lit = |caustics: bool| {
        let mut settings = Settings::default();
        settings.gi.caustics = caustics;
        settings.gi.mirror_light = false;
        render(&scene, &view, &settings, choice)
    };
    let behind = lamp(2.0, -1.0);
    // Nothing within a cone of 27 degrees is compared at its soft edge.
    let expected: Vec<Option<f32>> = (0..SIZE.x * SIZE.y)
        .map(|i| {
            let centre = Vec2::new((i % SIZE.x) as f32 + 0.5, (i / SIZE.x) as f32 + 0.5);
            let towards = view.pinhole.direction(centre);
            let floor = view.pinhole.eye - towards * (view.pinhole.eye.z / towards.z);
            let from = floor - behind.position;
            let cosine = from.normalize().dot(behind.axis);
            let inside = cosine > 22f32.to_radians().cos() && floor.x > -2.2;
            let arrives = 6.0 * -from.normalize().z / from.length_squared();
            inside.then_some(ALBEDO / std::f32::consts::PI * arrives)
        })
        .collect();
    let got = lit(true);
    let (columns, rows) = (SIZE.x as usize / BLOCK, SIZE.y as usize / BLOCK);
    let (mut all, mut paper, mut worst, mut compared) = (0.0, 0.0, 0f32, 0);
    for b in 0..columns * rows {
        let (x, y) = (b % columns * BLOCK, b / columns * BLOCK);
        let pixels = (0..BLOCK * BLOCK).map(|k| (y + k / BLOCK) * SIZE.x as usize + x + k % BLOCK);
        let pairs: Vec<_> = pixels
            .filter_map(|i| Some((got[i], expected[i]?)))
            .collect();
        if pairs.len() < BLOCK * BLOCK {
            continue;
        }
        let got: f32 = pairs.iter().map(|(got, _)| got).sum();
        let on_paper: f32 = pairs.iter().map(|(_, paper)| paper).sum();
        worst = worst.max((got / on_paper - 1.0).abs());
        all += got;
        paper += on_paper;
        compared += 1;
    }
    println!(
        "{compared} blocks: {:.3} of the light on paper, worst off by {worst:.3}",
        all / paper
    );
    assert!(compared > 10, "{compared} blocks are compared");
    assert!(
        (all / paper - 1.0).abs() < 0.05,
        "got {} of the light",
        all / paper
    );
    assert!(worst < 0.15, "a block is off by {worst}");
    let without: f32 = lit(false).iter().sum();
    assert!(
        without < 0.01 * got.iter().sum::<f32>(),
        "without caustics the floor is dark: {without}"
    );
}
