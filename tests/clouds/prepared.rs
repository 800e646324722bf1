//! From clouds to surfels: radii, normals, colours, origin, order.

use std::collections::BTreeSet;

use catoptric::cloud::{Look, MirrorRule, PlacedCloud, Prepared, RawCloud, Select, prepare};
use catoptric::{Error, Job};
use glam::{DMat4, DVec3, Vec3};
use libtest_mimic::{Failed, Trial};

use super::demand;

pub(super) fn tests() -> Vec<Trial> {
    vec![
        Trial::test("spacing_of_a_grid_is_its_spacing", grid_spacing),
        Trial::test(
            "normals_of_a_sphere_point_outwards_to_the_viewer",
            sphere_normals,
        ),
        Trial::test(
            "points_in_one_place_and_lone_points_have_radii",
            degenerate_clouds,
        ),
        Trial::test("strays_do_not_cover_the_picture", strays),
        Trial::test("broken_points_are_dropped_and_counted", broken_points),
        Trial::test(
            "surfels_are_the_same_for_any_number_of_threads",
            any_threads,
        ),
        Trial::test("a_transform_moves_points_normals_and_radii", transforms),
        Trial::test(
            "a_transform_that_mirrors_or_flattens_is_refused",
            refused_transforms,
        ),
        Trial::test("far_scenes_have_an_origin_of_their_own", origins),
        Trial::test("a_rule_marks_mirrors_in_the_scenes_frame", rules),
        Trial::test("a_cancelled_job_prepares_nothing", cancelled),
    ]
}

fn placed(raw: RawCloud) -> PlacedCloud {
    raw.into()
}

fn prepared(raw: RawCloud) -> catoptric::Result<Prepared> {
    prepare(vec![placed(raw)], DVec3::Z * 100.0, &Job::default())
}

fn of_positions(positions: Vec<DVec3>) -> RawCloud {
    RawCloud {
        positions,
        ..RawCloud::default()
    }
}

/// A square grid in the plane z = 0.
fn grid(side: u32, spacing: f64) -> Vec<DVec3> {
    let at = |i: u32| f64::from(i) * spacing;
    (0..side * side)
        .map(|i| DVec3::new(at(i % side), at(i / side), 0.0))
        .collect()
}

/// Evenly spread points on the unit sphere, by the golden angle.
fn sphere(count: u32) -> Vec<DVec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let point = |i: u32| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let (sin, cos) = (golden * f64::from(i)).sin_cos();
        DVec3::new(cos * (1.0 - z * z).sqrt(), sin * (1.0 - z * z).sqrt(), z)
    };
    (0..count).map(point).collect()
}

fn grid_spacing() -> Result<(), Failed> {
    // Inside a grid of spacing h the 8th neighbour is h sqrt(2) away: the estimate is h sqrt(2 pi / 8) = 0.886 h.
    let prepared = prepared(of_positions(grid(100, 0.02)))?;
    let expected = 0.02 * (std::f64::consts::PI / 4.0).sqrt();
    let got = prepared.facts.spacing;
    demand(
        (got / expected - 1.0).abs() < 1e-4,
        format!("spacing {got}, expected {expected}"),
    )?;
    demand(
        prepared
            .surfels
            .places
            .iter()
            .all(|place| place.radius > 0.0),
        "radii above 0",
    )?;

    // Even points with 4 pi area in all: their spacing is the root of the area of each.
    let got = self::prepared(of_positions(sphere(10_000)))?.facts.spacing;
    let expected = (4.0 * std::f64::consts::PI / 10_000.0).sqrt();
    demand(
        (got / expected - 1.0).abs() < 0.1,
        format!("spacing {got} on the sphere, expected {expected}"),
    )
}

fn sphere_normals() -> Result<(), Failed> {
    let viewer = DVec3::new(0.0, 0.0, 1000.0);
    let prepared = prepare(
        vec![placed(of_positions(sphere(20_000)))],
        viewer,
        &Job::default(),
    )?;
    for index in 0..prepared.surfels.len() {
        let surfel = prepared.surfels.get(index).ok_or("a surfel")?;
        let radial = surfel.position.normalize();
        let angle = surfel
            .normal
            .angle_between(radial * radial.z.signum())
            .to_degrees();
        demand(
            surfel.normal.z > -0.02,
            format!("normal {} looks away from the viewer", surfel.normal),
        )?;
        demand(
            angle < 1.0 || radial.z.abs() < 0.02,
            format!("normal off by {angle} degrees at {radial}"),
        )?;
    }
    Ok(())
}

fn degenerate_clouds() -> Result<(), Failed> {
    let line = (0..50).map(|i| DVec3::X * f64::from(i)).collect();
    let doubled = grid(10, 1.0).into_iter().flat_map(|p| [p; 12]).collect();
    for positions in [
        vec![DVec3::ONE],
        vec![DVec3::ONE; 100],
        vec![DVec3::ZERO, DVec3::X],
        line,
        doubled,
    ] {
        let count = positions.len();
        let prepared = prepared(of_positions(positions))?;
        demand(
            prepared.surfels.len() == count,
            format!("{} of {count} points", prepared.surfels.len()),
        )?;
        for index in 0..count {
            let surfel = prepared.surfels.get(index).ok_or("a surfel")?;
            let sound = surfel.radius > 0.0 && surfel.radius.is_finite();
            demand(sound, format!("radius {} of {count} points", surfel.radius))?;
            let length = surfel.normal.length();
            demand(
                (length - 1.0).abs() < 1e-3,
                format!("normal {} of {count} points", surfel.normal),
            )?;
        }
    }
    Ok(())
}

fn strays() -> Result<(), Failed> {
    let mut positions = grid(50, 1.0);
    positions.push(DVec3::new(0.0, 0.0, 5000.0));
    let prepared = prepared(of_positions(positions))?;
    let largest = prepared
        .surfels
        .places
        .iter()
        .map(|place| place.radius)
        .fold(0.0, f32::max);
    demand(largest < 10.0, format!("the stray's radius is {largest}"))
}

fn broken_points() -> Result<(), Failed> {
    let mut raw = of_positions(grid(10, 1.0));
    raw.positions[3].y = f64::NAN;
    raw.positions[50].x = f64::INFINITY;
    let mut normals = vec![Vec3::Z * 2.0; 100];
    normals[10] = Vec3::ZERO;
    normals[11] = Vec3::NAN;
    normals[3] = Vec3::ZERO;
    raw.normals = Some(normals);
    let mut radii = vec![0.5; 100];
    radii[20] = -1.0;
    radii[21] = f32::NAN;
    raw.radii = Some(radii);
    let mut albedo = vec![Vec3::splat(0.5); 100];
    albedo[30] = Vec3::new(f32::NAN, 0.0, 0.0);
    albedo[31] = Vec3::new(2.0, 0.0, 0.0);
    raw.albedo = Some(albedo);
    raw.mirror = Some((0..100).map(|i| f32::from(i >= 90)).collect());
    let prepared = prepared(raw)?;
    let repairs = prepared.facts.repairs;
    demand(repairs.not_finite == 2, format!("{repairs:?}"))?;
    demand(
        repairs.normals == 2,
        format!("{repairs:?}: the third was dropped"),
    )?;
    demand(
        repairs.radii == 2 && repairs.values == 2,
        format!("{repairs:?}"),
    )?;
    demand(
        prepared.facts.mirror_points == 10,
        format!("{} mirrors", prepared.facts.mirror_points),
    )?;
    let expected: BTreeSet<u32> = (0..100).filter(|i| ![3, 50].contains(i)).collect();
    let sources: BTreeSet<u32> = prepared.surfels.source.iter().copied().collect();
    demand(sources == expected, "sources count dropped points too")?;
    let every = (0..98).all(|i| prepared.surfels.get(i).is_some_and(|s| s.normal.z > 0.999));
    demand(every, "all normals are those of the plane")?;

    let nothing = self::prepared(of_positions(vec![DVec3::NAN; 5]));
    demand(
        matches!(nothing, Err(Error::NoPoints(_))),
        format!("{nothing:?}"),
    )
}

fn any_threads() -> Result<(), Failed> {
    let cloud = || of_positions(sphere(40_000));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        Ok::<_, Failed>(pool.install(|| prepared(cloud()))?)
    };
    let one = with(1)?;
    demand(one == with(2)? && one == with(7)?, "surfels differ")?;
    let mut fewer = cloud();
    fewer.positions.pop();
    demand(prepared(fewer)? != one, "one point fewer must differ")
}

fn transforms() -> Result<(), Failed> {
    let raw = RawCloud {
        positions: grid(3, 1.0),
        normals: Some(vec![Vec3::new(0.0, 0.6, 0.8); 9]),
        radii: Some(vec![1.0; 9]),
        ..RawCloud::default()
    };
    let stretch = DMat4::from_translation(DVec3::new(5.0, 0.0, 0.0))
        * DMat4::from_scale(DVec3::new(8.0, 1.0, 1.0));
    let cloud = PlacedCloud {
        transform: Some(stretch),
        ..placed(raw)
    };
    let prepared = prepare(vec![cloud], DVec3::Z, &Job::default())?;
    let bounds = prepared.facts.bounds;
    demand(
        (bounds.min.x, bounds.max.x) == (5.0, 21.0),
        format!("{bounds:?}"),
    )?;
    let surfel = prepared.surfels.get(0).ok_or("a surfel")?;
    demand(
        surfel.normal.abs_diff_eq(Vec3::new(0.0, 0.6, 0.8), 1e-3),
        format!("normal {}", surfel.normal),
    )?;
    demand(
        (surfel.radius - 2.0).abs() < 1e-6,
        format!("radius {}, the mean scale is 2", surfel.radius),
    )
}

fn refused_transforms() -> Result<(), Failed> {
    let mut projective = DMat4::IDENTITY;
    projective.x_axis.w = 0.5;
    for (transform, word) in [
        (DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)), "mirrors"),
        (DMat4::from_scale(DVec3::new(1.0, 0.0, 1.0)), "flatten"),
        (DMat4::from_scale(DVec3::new(1.0, f64::NAN, 1.0)), "finite"),
        (projective, "last row"),
    ] {
        let cloud = PlacedCloud {
            transform: Some(transform),
            ..placed(of_positions(grid(3, 1.0)))
        };
        let said = prepare(vec![cloud], DVec3::Z, &Job::default())
            .err()
            .map_or(String::new(), |e| e.to_string());
        demand(said.contains(word), format!("{word}: {said}"))?;
    }
    Ok(())
}

fn origins() -> Result<(), Failed> {
    demand(
        prepared(of_positions(grid(5, 2000.0)))?.facts.origin == DVec3::ZERO,
        "8 km from 0 keep it",
    )?;
    let offset = DVec3::new(636_001.76, 848_935.2, 406.26);
    let far: Vec<DVec3> = grid(5, 10.01).into_iter().map(|p| p + offset).collect();
    let raw = RawCloud {
        scale: Some(DVec3::splat(0.01)),
        ..of_positions(far.clone())
    };
    let prepared = prepared(raw)?;
    let origin = prepared.facts.origin;
    let multiple = origin / 0.01;
    demand(
        (multiple - multiple.round()).abs().max_element() < 1e-6,
        format!("origin {origin}"),
    )?;
    for (place, &source) in prepared.surfels.places.iter().zip(&prepared.surfels.source) {
        let moved = (place.position.as_dvec3() + origin - far[source as usize]).length();
        demand(moved < 1e-5, format!("point {source} moved by {moved}"))?;
    }
    Ok(())
}

/// The look of a cloud, some of whose points are mirrors.
fn marked(select: Select, reflectance: f32) -> Look {
    Look {
        name: "cloud".to_owned(),
        mirrors: vec![MirrorRule {
            select,
            reflectance,
        }],
        ..Look::default()
    }
}

fn rules() -> Result<(), Failed> {
    let select = Select::Box {
        min: DVec3::new(10.0, 0.0, -1.0),
        max: DVec3::new(11.0, 0.0, 1.0),
    };
    let cloud = PlacedCloud {
        transform: Some(DMat4::from_translation(DVec3::X * 10.0)),
        look: marked(select, 0.5),
        ..placed(of_positions(grid(4, 1.0)))
    };
    let prepared = prepare(vec![cloud.clone()], DVec3::Z, &Job::default())?;
    demand(
        prepared.facts.mirror_points == 2,
        format!("{} mirrors", prepared.facts.mirror_points),
    )?;
    let select = Select::Property("mirror".to_owned());
    let cloud = PlacedCloud {
        look: marked(select, 1.0),
        ..cloud
    };
    let said = prepare(vec![cloud], DVec3::Z, &Job::default())
        .err()
        .map_or(String::new(), |e| e.to_string());
    demand(said.contains("`mirror`"), said)
}

fn cancelled() -> Result<(), Failed> {
    let job = Job::default();
    job.cancel();
    let outcome = prepare(vec![placed(of_positions(grid(10, 1.0)))], DVec3::Z, &job);
    demand(matches!(outcome, Err(Error::Cancelled)), "cancelled")
}
