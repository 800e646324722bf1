//! Indirect light: answers known on paper, and what an independent renderer says of the scenes as they are delivered.

#[path = "indirect/caustics.rs"]
mod caustics;
#[path = "indirect/furnace.rs"]
mod furnace;
#[path = "indirect/told.rs"]
mod told;
#[path = "indirect/truth.rs"]
mod truth;

use catoptric::camera::Camera;
use catoptric::gbuffer::GBuffer;
use catoptric::gi::SpotLight;
use catoptric::gi::vpl::LitMap;
use glam::{DVec3, UVec2, Vec3};
use libtest_mimic::Trial;

use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    let mut trials = vec![
        claim(
            "indirect::the_flux_of_the_spot_is_that_of_paper",
            the_flux_of_the_spot_is_that_of_paper,
        ),
        claim(
            "indirect::a_point_light_shines_evenly_in_all_directions",
            a_point_light_shines_evenly_in_all_directions,
        ),
    ];
    trials.extend(caustics::tests());
    trials.extend(furnace::tests());
    trials.extend(told::tests());
    trials.extend(truth::tests());
    trials
}

/// What leaves a light, by its map, W.
fn power(light: SpotLight) -> f32 {
    let map = LitMap {
        light,
        gbuffer: GBuffer::empty(light.pinhole(512, 10.0)),
    };
    map.power().x
}

fn the_flux_of_the_spot_is_that_of_paper() {
    // 2 pi I (integral of sin over the inner cone, and of sin times the linear falloff to the outer): 5.0921 W.
    let light = SpotLight {
        position: Vec3::new(-0.6, 0.9, 0.2),
        axis: Vec3::new(1.6, -1.9, -3.2).normalize(),
        intensity: Vec3::splat(6.0),
        inner_angle: 25f32.to_radians(),
        outer_angle: 35f32.to_radians(),
        pyramid: false,
    };
    let (inner, outer) = (25f64.to_radians(), 35f64.to_radians());
    let falloff = |t: f64| ((outer - t) / (outer - inner)).min(1.0);
    let steps = 100_000;
    let paper: f64 = (0..steps)
        .map(|i| (i as f64 + 0.5) / f64::from(steps) * outer)
        .map(|t| std::f64::consts::TAU * 6.0 * t.sin() * falloff(t) * outer / f64::from(steps))
        .sum();
    assert!((paper - 5.0921).abs() < 1e-3, "on paper {paper} W");
    let got = f64::from(power(light));
    assert!(
        (got - paper).abs() < 0.005,
        "got {got} W, on paper {paper} W"
    );
}

fn a_point_light_shines_evenly_in_all_directions() {
    let six = SpotLight::all_around(Vec3::ZERO, Vec3::splat(2.0));
    let sum: f32 = six.map(power).iter().sum();
    let paper = 8.0 * std::f32::consts::PI;
    assert!(
        (sum / paper - 1.0).abs() < 1e-3,
        "got {sum} W, on paper {paper} W"
    );
}

/// A camera that looks from `position` at `target`.
fn camera(position: DVec3, target: DVec3, size: UVec2) -> catoptric::camera::Pinhole {
    let camera = Camera {
        position,
        target,
        up: DVec3::Y,
        fov_y_degrees: 75.0,
        near: 0.01,
        far: 100.0,
        size,
    };
    camera.pinhole(DVec3::ZERO).expect("a sound camera")
}
