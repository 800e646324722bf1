//! Generated scenes: the points lie where they should, evenly, and always the same.

use std::f64::consts::PI;

use catoptric::cloud::generate::{
    CloudSource, DEFAULT_POINTS, SceneName, Shape, generate, sample_mirror, scene_toml,
};
use catoptric::cloud::{RawCloud, UpAxis};
use catoptric::{Error, Job};
use glam::{DVec2, DVec3};
use libtest_mimic::Trial;
use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::analytic::{C, Kind, Oracle, View};
use crate::evenness::{Cells, chi_square_excess};

pub fn tests() -> Vec<Trial> {
    let claims: [(&str, fn()); 12] = [
        (
            "points_lie_on_the_surfaces_and_have_their_normals",
            points_lie_on_the_surfaces,
        ),
        ("a_moved_point_is_noticed", a_moved_point_is_noticed),
        ("areas_are_those_of_the_books", areas_are_those_of_the_books),
        (
            "every_part_of_a_surface_gets_its_share",
            every_part_gets_its_share,
        ),
        (
            "walls_and_mirrors_get_their_share",
            walls_and_mirrors_get_their_share,
        ),
        (
            "threads_do_not_change_the_points_but_the_seed_does",
            threads_do_not_change_the_points,
        ),
        (
            "a_mirror_put_in_has_the_spacing_of_the_cloud",
            a_mirror_put_in_has_the_spacing,
        ),
        (
            "impossible_mirrors_are_refused_with_a_sentence",
            impossible_mirrors_are_refused,
        ),
        (
            "wrong_names_and_numbers_are_refused_with_a_sentence",
            wrong_names_are_refused,
        ),
        (
            "a_cancelled_job_generates_nothing",
            a_cancelled_job_generates_nothing,
        ),
        (
            "the_scene_files_are_those_that_generate_writes",
            scene_files_are_current,
        ),
        (
            "bumps_show_some_two_hundred_regions",
            bumps_show_some_two_hundred_regions,
        ),
    ];
    let trial = |(name, test): (&str, fn())| {
        Trial::test(format!("generate::{name}"), move || {
            test();
            Ok(())
        })
    };
    claims.into_iter().map(trial).collect()
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

fn points_lie_on_the_surfaces() {
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

/// The mirror of a scene that has one.
fn mirror_of(name: SceneName) -> Shape {
    let mirrors = name.mirrors(None).expect("a scene that needs no mesh");
    mirrors.into_iter().next().expect("a mirror")
}

fn areas_are_those_of_the_books() {
    let bowl = 8.0 * PI / 3.0 * 0.25f64.powi(2) * ((1.0 + 0.88f64.powi(2)).powf(1.5) - 1.0);
    let facets = |name: &str| {
        let oracle = Oracle::named(name);
        Cells::of_radial(|d| oracle.radius(d))
            .shares
            .iter()
            .sum::<f64>()
    };
    for (name, expected, tolerance) in [
        (SceneName::Sphere, 4.0 * PI * 0.44f64.powi(2), 1e-12),
        (SceneName::Parabola, bowl, 1e-12),
        (SceneName::Torus, 4.0 * PI * PI * 0.36 * 0.13, 1e-12),
        (SceneName::Plane, 0.64, 1e-12),
        // Facets between points of the surface: their area is a little small.
        (SceneName::Blob, facets("blob"), 1e-3),
        (SceneName::Bumps, facets("bumps"), 1e-3),
    ] {
        let area = mirror_of(name).area().expect("a sound mirror");
        assert!(
            (area / expected - 1.0).abs() < tolerance,
            "{name}: got {area}, expected {expected}"
        );
    }
}

fn every_part_gets_its_share() {
    for name in [
        SceneName::Sphere,
        SceneName::Parabola,
        SceneName::Blob,
        SceneName::Torus,
        SceneName::Plane,
        SceneName::Bumps,
    ] {
        let surface = mirror_of(name).surface().expect("a sound mirror");
        let mut rng = Pcg64::seed_from_u64(7);
        let points: Vec<DVec3> = (0..200_000)
            .map(|_| surface.sample(&mut rng).position)
            .collect();
        let oracle = Oracle::named(name.name());
        let cells = match name {
            SceneName::Parabola => Cells::of_bowl(DVec3::new(0.0, 0.0, -1.3), 0.25, 0.44),
            SceneName::Torus => Cells::of_ring(C, 35f64.to_radians(), 0.36, 0.13),
            SceneName::Plane => Cells::of_square(C, 20f64.to_radians(), 0.8),
            _ => Cells::of_radial(|d| oracle.radius(d)),
        };
        let excess = chi_square_excess(&cells, &points);
        assert!(
            excess < 5.0,
            "{name}: chi-square is {excess} standard deviations above its mean"
        );
        // Negative control: a tenth of the points repeat 500 others.
        let skewed = points
            .iter()
            .enumerate()
            .map(|(i, &p)| if i % 10 == 0 { points[i / 400] } else { p });
        let excess = chi_square_excess(&cells, &skewed.collect::<Vec<_>>());
        assert!(
            excess > 5.0,
            "{name}: repeated points must be seen, got {excess}"
        );
    }
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

fn threads_do_not_change_the_points() {
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

fn a_mirror_put_in_has_the_spacing() {
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

fn impossible_mirrors_are_refused() {
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

fn wrong_names_are_refused() {
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

fn scene_files_are_current() {
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

/// Counts the regions of 8 pixels or more in which the view normal bends the same way.
fn bumps_show_some_two_hundred_regions() {
    let count = |name: &str| {
        let view = View::REFERENCE;
        crate::evenness::regions(&Oracle::named(name).view(&view), view.width)
    };
    let (bumps, sphere) = (count("bumps"), count("sphere"));
    assert!(
        (150..=300).contains(&bumps),
        "the bumps show {bumps} regions"
    );
    assert_eq!(sphere, 1, "a sphere is one region");
}
