//! Generated scenes: the points lie where they should, evenly, and always the same.

#![expect(clippy::expect_used, reason = "a test fails by panicking")]

use std::f64::consts::PI;

use catoptric::cloud::generate::{
    CloudSource, DEFAULT_POINTS, SceneName, Shape, generate, sample_mirror, scene_toml,
};
use catoptric::cloud::{RawCloud, UpAxis};
use catoptric::{Error, Job};
use glam::{DVec2, DVec3};
use libtest_mimic::Trial;

use crate::analytic::{Kind, Oracle};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim(points_lie_on_the_surfaces_and_have_their_normals),
        claim(a_moved_point_is_noticed),
        claim(walls_and_mirrors_get_their_share),
        claim(threads_do_not_change_the_points_but_the_seed_does),
        claim(a_mirror_put_in_has_the_spacing_of_the_cloud),
        claim(impossible_mirrors_are_refused_with_a_sentence),
        claim(wrong_names_and_numbers_are_refused_with_a_sentence),
        claim(a_cancelled_job_generates_nothing),
        claim(the_scene_files_are_those_that_generate_writes),
    ]
}

/// A test named after its function, which reads as a claim and fails by panicking.
pub(crate) fn claim<F: Fn() + Send + 'static>(test: F) -> Trial {
    let name = std::any::type_name::<F>();
    let name = name.split_once("::").map_or(name, |(_, name)| name);
    Trial::test(name, move || {
        test();
        Ok(())
    })
}

/// The scenes that need no mesh.
const NAMES: [SceneName; 7] = [
    SceneName::Sphere,
    SceneName::Parabola,
    SceneName::Blob,
    SceneName::Torus,
    SceneName::Plane,
    SceneName::Multi,
    SceneName::Bumps,
];

fn make(name: SceneName, points: usize, seed: u64) -> RawCloud {
    generate(name, points, seed, None, &Job::default()).expect("a scene that needs no mesh")
}

/// Largest distance from the surface, and largest differences of normal and albedo, over a cloud's points.
fn residuals(oracle: &Oracle, cloud: &RawCloud) -> (f64, f64, f64) {
    let (normals, albedo) = (cloud.normals.as_ref(), cloud.albedo.as_ref());
    let (normals, albedo) = (normals.expect("normals"), albedo.expect("albedo"));
    let mirror = cloud.mirror.as_ref().expect("a mirror mark");
    let mut worst = (0.0f64, 0.0f64, 0.0f64);
    for i in 0..cloud.len() {
        let (distance, seen) = oracle.nearest(cloud.positions[i]);
        assert_eq!(
            matches!(seen.kind, Kind::Mirror(_)),
            mirror[i] == 1.0,
            "mirror mark of point {i}"
        );
        worst.0 = worst.0.max(distance);
        worst.1 = worst.1.max((normals[i].as_dvec3() - seen.normal).length());
        worst.2 = worst.2.max((albedo[i].as_dvec3() - seen.albedo).length());
    }
    worst
}

fn points_lie_on_the_surfaces_and_have_their_normals() {
    for name in NAMES {
        let cloud = make(name, 50_000, 3);
        assert_eq!(
            (cloud.len(), cloud.up_axis),
            (50_000, Some(UpAxis::Y)),
            "{name}"
        );
        let (distance, normal, albedo) = residuals(&Oracle::named(name.name()), &cloud);
        assert!(
            distance < 1e-6,
            "{name}: a point is {distance} m off its surface"
        );
        // Finite differences and 32-bit normals.
        assert!(normal < 1e-6, "{name}: a normal is {normal} off");
        assert!(albedo < 1e-6, "{name}: an albedo is {albedo} off");
    }
}

fn a_moved_point_is_noticed() {
    let mut cloud = make(SceneName::Blob, 5_000, 3);
    let last = cloud.len() - 1;
    cloud.positions[last] += DVec3::splat(1e-5);
    let (distance, ..) = residuals(&Oracle::named("blob"), &cloud);
    assert!(
        distance > 1e-6,
        "10 micrometres off must be seen, got {distance}"
    );
}

fn walls_and_mirrors_get_their_share() {
    let (points, oracle) = (100_000, Oracle::named("sphere"));
    let cloud = make(SceneName::Sphere, points, 1);
    let area = 40.0 + 4.0 * PI * 0.44f64.powi(2);
    let radii = cloud.radii.as_ref().expect("radii");
    let spacing = (area / points as f64).sqrt();
    assert!(
        radii
            .iter()
            .all(|r| (f64::from(*r) / spacing - 1.0).abs() < 1e-6),
        "expected {spacing}"
    );
    let mut counts = [0usize; 7];
    for p in &cloud.positions {
        match oracle.nearest(*p).1.kind {
            Kind::Wall(number) => counts[usize::from(number)] += 1,
            Kind::Mirror(_) | Kind::Back(_) => counts[0] += 1,
        }
    }
    for (i, wall_area) in [area - 40.0, 8.0, 8.0, 8.0, 8.0, 4.0, 4.0]
        .into_iter()
        .enumerate()
    {
        let expected = wall_area / area * points as f64;
        assert!(
            (counts[i] as f64 - expected).abs() <= 1.0,
            "part {i}: {} points, not {expected}",
            counts[i]
        );
    }
}

fn threads_do_not_change_the_points_but_the_seed_does() {
    let with = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| make(SceneName::Multi, 100_000, seed))
    };
    let one = with(1, 5);
    assert!(
        one == with(3, 5),
        "three threads must give the points of one"
    );
    let other = with(1, 6);
    let same = one
        .positions
        .iter()
        .zip(&other.positions)
        .filter(|(a, b)| a == b)
        .count();
    assert_eq!(same, 0, "another seed must give other points");
}

fn a_mirror_put_in_has_the_spacing_of_the_cloud() {
    let shape = Shape::Sphere {
        centre: DVec3::new(5e5, 4e6, 100.0),
        radius: 2.0,
    };
    let cloud = sample_mirror(&shape, 0.05, 1, &Job::default()).expect("a sound mirror");
    let expected = (4.0 * PI * 4.0 / 0.05f64.powi(2)).ceil() as usize;
    assert_eq!(cloud.len(), expected, "points at a spacing of 0.05");
    let radius = f64::from(cloud.radii.as_ref().expect("radii")[0]);
    assert!((radius / 0.05 - 1.0).abs() < 1e-3, "radius {radius}");
    assert!(
        cloud.mirror.is_some_and(|m| m.iter().all(|&m| m == 1.0)),
        "every point is a mirror"
    );
    for spacing in [0.0, -1.0, f64::NAN, 1e-9] {
        let error =
            sample_mirror(&shape, spacing, 1, &Job::default()).expect_err("an absurd spacing");
        assert!(
            matches!(error, Error::Setting(_)),
            "spacing {spacing}: {error}"
        );
    }
}

fn impossible_mirrors_are_refused_with_a_sentence() {
    let (p, x) = (DVec3::ZERO, DVec3::X);
    let size = DVec2::ONE;
    let broken = [
        (
            Shape::Sphere {
                centre: p,
                radius: 0.0,
            },
            "radius",
        ),
        (
            Shape::Sphere {
                centre: p,
                radius: f64::NAN,
            },
            "radius",
        ),
        (
            Shape::Sphere {
                centre: DVec3::INFINITY,
                radius: 1.0,
            },
            "centre",
        ),
        (
            Shape::Plane {
                centre: p,
                normal: p,
                up: x,
                size,
            },
            "normal",
        ),
        (
            Shape::Plane {
                centre: p,
                normal: x,
                up: p,
                size,
            },
            "up",
        ),
        (
            Shape::Plane {
                centre: p,
                normal: x,
                up: -x,
                size,
            },
            "up",
        ),
        (
            Shape::Plane {
                centre: p,
                normal: x,
                up: DVec3::Y,
                size: DVec2::new(1.0, 0.0),
            },
            "size",
        ),
        (
            Shape::Paraboloid {
                vertex: p,
                axis: x,
                focal_length: 0.0,
                rim_radius: 1.0,
            },
            "focal_length",
        ),
        (
            Shape::Paraboloid {
                vertex: p,
                axis: x,
                focal_length: 1.0,
                rim_radius: -1.0,
            },
            "rim_radius",
        ),
        (
            Shape::Torus {
                centre: p,
                axis: p,
                major_radius: 2.0,
                minor_radius: 1.0,
            },
            "axis",
        ),
        (
            Shape::Torus {
                centre: p,
                axis: x,
                major_radius: 1.0,
                minor_radius: 1.0,
            },
            "minor_radius",
        ),
        (
            Shape::Blob {
                centre: p,
                radius: 1.0,
                amplitude: 1.0,
            },
            "amplitude",
        ),
        (
            Shape::Blob {
                centre: p,
                radius: 1.0,
                amplitude: f64::NAN,
            },
            "amplitude",
        ),
        (
            Shape::Bumps {
                centre: p,
                radius: -2.0,
            },
            "radius",
        ),
    ];
    for (shape, named) in broken {
        let error = shape.area().expect_err("an impossible mirror").to_string();
        assert!(
            error.contains(named),
            "{shape:?}: {error:?} must name {named}"
        );
    }
}

fn wrong_names_and_numbers_are_refused_with_a_sentence() {
    let error = "shpere"
        .parse::<SceneName>()
        .expect_err("no such scene")
        .to_string();
    assert!(
        error.contains("did you mean sphere?") && error.contains("torus"),
        "{error}"
    );
    for name in SceneName::ALL {
        assert_eq!(
            name.name().parse::<SceneName>().ok(),
            Some(name),
            "{name} by its own name"
        );
    }
    let error = generate(SceneName::Bunny, 10, 1, None, &Job::default())
        .expect_err("no mesh")
        .to_string();
    assert!(error.contains("--mesh"), "{error}");
    let error = generate(SceneName::Sphere, 0, 1, None, &Job::default())
        .expect_err("no points")
        .to_string();
    assert!(error.contains("points is 0"), "{error}");
    assert!(
        generate(SceneName::Sphere, usize::MAX, 1, None, &Job::default()).is_err(),
        "too many points"
    );
}

fn a_cancelled_job_generates_nothing() {
    let job = Job::default();
    job.cancel();
    let result = generate(SceneName::Sphere, 100_000, 1, None, &job);
    assert!(
        matches!(result, Err(Error::Cancelled)),
        "got {:?}",
        result.map(|c| c.len())
    );
}

fn the_scene_files_are_those_that_generate_writes() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("pointclouds");
    for name in NAMES {
        let path = folder.join(format!("{name}.toml"));
        let found = std::fs::read_to_string(&path).expect("a scene file");
        let source = CloudSource::Generated {
            points: DEFAULT_POINTS,
            seed: 1,
            mesh: None,
        };
        assert_eq!(found, scene_toml(name, source), "{}", path.display());
    }
    let text = scene_toml(SceneName::Sphere, CloudSource::File("a \"b\".ply"));
    let parsed: toml::Table = text.parse().expect("valid TOML");
    assert_eq!(
        parsed["cloud"][0]["path"].as_str(),
        Some("a \"b\".ply"),
        "{text}"
    );
}
