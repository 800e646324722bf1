//! What splats show, answers known on paper.

use std::sync::Arc;

use catoptric::camera::{Camera, Pinhole};
use catoptric::cloud::{Finish, Place, Surfel, Surfels};
use catoptric::gbuffer::splat::Splatter;
use catoptric::gbuffer::{GBuffer, SplatSettings, edl};
use catoptric::image::ImageSettings;
use catoptric::job::Job;
use catoptric::timing::Timings;
use glam::{DVec3, UVec2, Vec3};
use libtest_mimic::Trial;

use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "splats::the_back_of_a_mirror_is_black_however_near_the_wall_behind",
            the_back_of_a_mirror_is_black_however_near_the_wall_behind,
        ),
        claim(
            "splats::a_tilted_wall_is_as_bright_in_every_size_of_picture",
            a_tilted_wall_is_as_bright_in_every_size_of_picture,
        ),
    ]
}

/// The camera at 3 on the z axis, looking at the origin.
fn camera(size: UVec2) -> Pinhole {
    let camera = Camera {
        position: DVec3::new(0.0, 0.0, 3.0),
        target: DVec3::ZERO,
        up: DVec3::Y,
        fov_y_degrees: 25.0,
        near: 0.1,
        far: 10.0,
        size,
    };
    camera.pinhole(DVec3::ZERO).expect("a sound camera")
}

/// A square of 2 x 2 through `centre`, spanned by x and `up`, of points 0.02 apart.
fn square(centre: Vec3, up: Vec3, normal: Vec3, albedo: f32, mirror: f32) -> Vec<Surfel> {
    let at = |i: i32| i as f32 * 0.02 - 1.0;
    let point = |i: i32| Surfel {
        position: centre + Vec3::X * at(i % 101) + up * at(i / 101),
        radius: 0.02,
        normal,
        albedo: Vec3::splat(albedo),
        mirror,
        specular: 0.0,
        shininess: 0.0,
    };
    (0..101 * 101).map(point).collect()
}

fn splatted(points: &[Surfel], size: UVec2) -> GBuffer<catoptric::backend::cpu::Cpu> {
    let place = |s: &Surfel| Place {
        position: s.position,
        radius: s.radius,
    };
    let surfels = Arc::new(Surfels {
        places: points.iter().map(place).collect(),
        finishes: points.iter().map(Finish::pack).collect(),
        source: (0..points.len() as u32).collect(),
        origin: DVec3::ZERO,
    });
    let (settings, mut timings) = (SplatSettings::default(), Timings::default());
    Splatter::default()
        .splat(
            &surfels,
            &camera(size),
            &settings,
            &mut timings,
            &Job::default(),
        )
        .expect("a G-buffer")
}

fn the_back_of_a_mirror_is_black_however_near_the_wall_behind() {
    let size = UVec2::new(80, 60);
    let brightest = |mirror: f32| {
        let mut points = square(Vec3::ZERO, Vec3::Y, Vec3::NEG_Z, 0.0, mirror);
        points.extend(square(
            Vec3::new(0.0, 0.0, -0.01),
            Vec3::Y,
            Vec3::Z,
            1.0,
            0.0,
        ));
        let seen = splatted(&points, size);
        assert!(
            seen.material.values().iter().all(|m| m.w > 0.0),
            "the square fills the picture"
        );
        seen.albedo.values().iter().map(|a| a.x).fold(0.0, f32::max)
    };
    let back = brightest(1.0);
    assert!(back < 1e-6, "the wall shines through with {back}");
    // The negative control: a black wall there blends with the white one behind it.
    let wall = brightest(0.0);
    assert!(
        wall > 0.2,
        "two diffuse walls as near as that blend: {wall}"
    );
}

fn a_tilted_wall_is_as_bright_in_every_size_of_picture() {
    let up = Vec3::new(0.0, 0.5, -0.866);
    let normal = Vec3::X.cross(up).normalize();
    let wall = square(Vec3::ZERO, up, normal, 0.5, 0.0);
    let mean = |size: UVec2, gain: f32| {
        let settings = ImageSettings {
            edl_strength: gain,
            ..ImageSettings::default()
        };
        let shaded =
            edl::edl(&splatted(&wall, size), &settings, &Job::default()).expect("a picture");
        // The middle, where no edge of the wall is near.
        let (w, h) = (size.x as usize, size.y as usize);
        let inside = |i: &usize| (i % w).abs_diff(w / 2) < w / 8 && (i / w).abs_diff(h / 2) < h / 8;
        let seen: Vec<f32> = (0..w * h)
            .filter(inside)
            .map(|i| shaded.values()[i].x)
            .collect();
        seen.iter().sum::<f32>() / seen.len() as f32
    };
    let (small, large) = (
        mean(UVec2::new(80, 60), 1.0),
        mean(UVec2::new(320, 240), 1.0),
    );
    assert!(
        (small - 0.5).abs() < 0.005,
        "80 x 60: {small}, expected 0.5"
    );
    assert!(
        (large - 0.5).abs() < 0.005,
        "320 x 240: {large}, expected 0.5"
    );
}
