//! Single rays, whose answers are known on paper.

use glam::{DVec3, UVec2, Vec3, Vec4};

use super::*;
use crate::cloud::{Finish, Place, Surfel};
use crate::gbuffer::average::Pixel;
use crate::grid::Grid;
use crate::reflect::Eye;

/// A white diffuse disc of radius 0.1.
fn disc(position: Vec3, normal: Vec3) -> Surfel {
    Surfel {
        position,
        radius: 0.1,
        normal,
        albedo: Vec3::ONE,
        mirror: 0.0,
        specular: 0.0,
        shininess: 0.0,
    }
}

fn mirror(position: Vec3, normal: Vec3) -> Surfel {
    Surfel {
        albedo: Vec3::ZERO,
        mirror: 1.0,
        ..disc(position, normal)
    }
}

fn cloud(surfels: &[Surfel]) -> Arc<Surfels> {
    let place = |s: &Surfel| Place {
        position: s.position,
        radius: s.radius,
    };
    Arc::new(Surfels {
        places: surfels.iter().map(place).collect(),
        finishes: surfels.iter().map(Finish::pack).collect(),
        source: (0..surfels.len() as u32).collect(),
        origin: DVec3::ZERO,
    })
}

fn tracer(surfels: &[Surfel]) -> RayTracer {
    RayTracer::new(
        &cloud(surfels),
        &SplatSettings::default(),
        &RayTraceSettings::default(),
        &mut Timings::default(),
        &Job::default(),
    )
    .unwrap()
}

/// A horizontal mirror at `points`, seen from straight above: rays go back up.
fn horizontal_mirror(points: &[Vec3]) -> Surface<Cpu> {
    let size = UVec2::new(points.len() as u32, 1);
    let grid = |values: Vec<Vec4>| Grid::from_vec(size, values).unwrap();
    Surface {
        size,
        point: grid(points.iter().map(|p| p.extend(1.0)).collect()),
        normal: grid(points.iter().map(|_| Vec3::Z.extend(0.1)).collect()),
        eye: Eye::PerPixel(grid(
            points
                .iter()
                .map(|p| (*p + Vec3::Z * 5.0).extend(1.0))
                .collect(),
        )),
    }
}

fn trace(surfels: &[Surfel], points: &[Vec3]) -> Vec<Pixel> {
    let surface = horizontal_mirror(points);
    let mut mirror = MirrorGBuffer::of(&surface);
    tracer(surfels)
        .trace(
            &surface,
            &mut mirror,
            Pixels::All,
            &mut Timings::default(),
            &Job::default(),
        )
        .unwrap();
    (0..points.len())
        .map(|i| mirror.at(i).unwrap_or_default())
        .collect()
}

fn trace_one(surfels: &[Surfel]) -> Pixel {
    trace(surfels, &[Vec3::ZERO])[0]
}

#[test]
fn a_disc_is_seen_where_its_plane_is() {
    let tilted = Vec3::new(0.6, 0.0, -0.8);
    let seen = trace_one(&[disc(Vec3::new(0.04, 0.0, 2.0), tilted)]);
    // The plane rises by 0.75 along x.
    let expected = 2.0 - 0.04 * 0.75;
    assert!(
        (seen.surface.w - expected).abs() < 1e-5,
        "{seen:?}, expected a distance of {expected}"
    );
    assert!(
        (seen.surface.truncate() - tilted).length() < 1e-4,
        "{seen:?}"
    );
    assert_eq!(
        seen.albedo,
        Vec4::new(1.0, 1.0, 1.0, 0.0),
        "white, no mirror"
    );
    assert_eq!(seen.material.w, 1.0, "{seen:?}");
}

#[test]
fn a_ray_beside_a_disc_sees_nothing() {
    // The half width is 0.15.
    let at = |x: f32| trace_one(&[disc(Vec3::new(x, 0.0, 2.0), -Vec3::Z)]);
    assert!(at(0.149).material.w > 0.0, "just inside");
    assert_eq!(at(0.151), Pixel::default(), "just outside");
}

#[test]
fn a_disc_seen_edge_on_is_not_seen() {
    assert_eq!(trace_one(&[disc(Vec3::Z, Vec3::X)]), Pixel::default());
}

#[test]
fn nothing_is_seen_without_surfels() {
    assert_eq!(trace_one(&[]), Pixel::default());
}

#[test]
fn what_lies_below_the_mirror_is_not_seen() {
    assert_eq!(trace_one(&[disc(-Vec3::Z, Vec3::Z)]), Pixel::default());
}

#[test]
fn identical_points_look_like_one() {
    let one = disc(Vec3::Z * 2.0, -Vec3::Z);
    let (single, many) = (trace_one(&[one]), trace_one(&[one; 1000]));
    assert!(
        (single.surface - many.surface).abs().max_element() < 1e-4,
        "{many:?} is not {single:?}"
    );
}

#[test]
fn discs_within_the_tolerance_are_blended_and_those_behind_are_not() {
    let red = Surfel {
        albedo: Vec3::X,
        ..disc(Vec3::Z, -Vec3::Z)
    };
    let behind = |depth: f32| trace_one(&[red, disc(Vec3::Z * (1.0 + depth), -Vec3::Z)]);
    // The tolerance is twice the radius.
    let seen = behind(0.19);
    assert!((seen.surface.w - 1.095).abs() < 1e-5, "{seen:?}");
    assert!((seen.albedo.y - 0.5).abs() < 1e-4, "{seen:?}");
    let seen = behind(0.21);
    assert!((seen.surface.w - 1.0).abs() < 1e-5, "{seen:?}");
    assert!(seen.albedo.y.abs() < 1e-4, "{seen:?}");
}

#[test]
fn mirrors_and_other_points_never_blend() {
    let near_mirror = [mirror(Vec3::Z, -Vec3::Z), disc(Vec3::Z * 1.01, -Vec3::Z)];
    let seen = trace_one(&near_mirror);
    assert_eq!((seen.albedo.x, seen.albedo.w), (0.0, 1.0), "{seen:?}");
    let near_wall = [mirror(Vec3::Z * 1.01, -Vec3::Z), disc(Vec3::Z, -Vec3::Z)];
    let seen = trace_one(&near_wall);
    assert_eq!((seen.albedo.x, seen.albedo.w), (1.0, 0.0), "{seen:?}");
}

#[test]
fn seen_from_behind_a_wall_turns_and_a_mirror_is_black() {
    let seen = trace_one(&[disc(Vec3::Z, Vec3::Z)]);
    assert!((seen.surface.z + 1.0).abs() < 1e-4, "{seen:?}");
    assert_eq!(seen.albedo, Vec4::new(1.0, 1.0, 1.0, 0.0), "{seen:?}");
    let seen = trace_one(&[mirror(Vec3::Z, Vec3::Z)]);
    assert_eq!(seen.albedo, Vec4::ZERO, "black, and no mirror");
    assert_eq!(seen.material.w, 1.0, "opaque");
}

#[test]
fn the_mirrors_own_layer_does_not_hide_what_it_shows() {
    let wall = disc(Vec3::Z, -Vec3::Z);
    for height in [-0.05, 0.0, 0.05, 0.15] {
        let own = mirror(Vec3::new(0.02, 0.0, height), Vec3::Z);
        let seen = trace_one(&[own, wall]);
        assert!(
            (seen.surface.w - 1.0).abs() < 1e-5,
            "own point at {height}: {seen:?}"
        );
    }
    // Negative control: what faces the mirror that near, or lies higher, is seen.
    for own in [
        mirror(Vec3::Z * 0.05, -Vec3::Z),
        mirror(Vec3::Z * 0.25, Vec3::Z),
    ] {
        let seen = trace_one(&[own, wall]);
        assert!(seen.surface.w < 0.3, "{own:?} must be seen: {seen:?}");
    }
}

#[test]
fn broken_surfels_are_passed() {
    let broken = [
        disc(Vec3::new(f32::NAN, 0.0, 1.0), -Vec3::Z),
        disc(Vec3::new(0.0, f32::INFINITY, 1.0), -Vec3::Z),
        Surfel {
            radius: f32::NAN,
            ..disc(Vec3::Z, -Vec3::Z)
        },
        Surfel {
            radius: f32::INFINITY,
            ..disc(Vec3::Z, -Vec3::Z)
        },
        Surfel {
            normal: Vec3::ZERO,
            ..disc(Vec3::Z, -Vec3::Z)
        },
        disc(Vec3::Z * 2.0, -Vec3::Z),
    ];
    let seen = trace_one(&broken);
    assert!((seen.surface.w - 2.0).abs() < 1e-5, "{seen:?}");
    let wild = [
        Vec3::NAN,
        Vec3::INFINITY,
        Vec3::splat(1e30),
        Vec3::splat(f32::MAX),
    ];
    for pixel in trace(&broken, &wild) {
        assert!(
            pixel.surface.is_finite() && pixel.material.is_finite(),
            "{pixel:?}"
        );
    }
}

/// Discs over a kilometre: a dense patch of millimetres, a sparse plain, and what every ray must meet.
fn uneven() -> (Vec<Surfel>, Vec<Vec3>, Vec<f32>) {
    let mut surfels = Vec::new();
    for i in 0..200 * 200 {
        let (x, y) = ((i % 200) as f32 * 1e-3, (i / 200) as f32 * 1e-3);
        surfels.push(Surfel {
            radius: 1e-3,
            ..disc(
                Vec3::new(x, y, 1.0 + x),
                Vec3::new(1.0, 0.0, -1.0).normalize(),
            )
        });
    }
    for i in 0..100 * 100 {
        let (x, y) = ((i % 100) as f32 * 10.0, (i / 100) as f32 * 10.0);
        surfels.push(Surfel {
            radius: 10.0,
            ..disc(Vec3::new(x, y, 300.0), -Vec3::Z)
        });
    }
    let mut points = Vec::new();
    let mut distances = Vec::new();
    for i in 0..1000 {
        let t = i as f32 / 1000.0;
        points.push(Vec3::new(0.01 + 0.18 * t, 0.19 - 0.18 * t, 0.0));
        distances.push(1.01 + 0.18 * t);
        points.push(Vec3::new(5.0 + 980.0 * t, 985.0 * (1.0 - t), 0.0));
        distances.push(300.0);
    }
    (surfels, points, distances)
}

#[test]
fn dense_and_sparse_parts_of_a_kilometre_are_met_alike() {
    let (surfels, points, distances) = uneven();
    let tracer = tracer(&surfels);
    assert!(
        tracer.memory() <= tree::memory(surfels.len()),
        "{} bytes are more than expected",
        tracer.memory()
    );
    for (pixel, expected) in trace(&surfels, &points).iter().zip(distances) {
        assert!(
            (pixel.surface.w - expected).abs() < 1e-5 * expected + 1e-3,
            "got {pixel:?}, expected a distance of {expected}"
        );
    }
}

#[test]
fn threads_do_not_change_what_is_seen() {
    let (surfels, points, _) = uneven();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| trace(&surfels, &points))
    };
    assert!(with(1) == with(3), "three threads must see what one sees");
}

#[test]
fn a_cancelled_job_traces_nothing() {
    let job = Job::default();
    let tracer = tracer(&[disc(Vec3::Z, -Vec3::Z)]);
    job.cancel();
    let surface = horizontal_mirror(&[Vec3::ZERO]);
    let mut mirror = MirrorGBuffer::of(&surface);
    let result = tracer.trace(
        &surface,
        &mut mirror,
        Pixels::All,
        &mut Timings::default(),
        &job,
    );
    assert!(result.is_err(), "a cancelled job must stop");
}
