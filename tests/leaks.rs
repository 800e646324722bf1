//! Which gaps between the points of a near surface close, and which stay.

use std::sync::Arc;

use catoptric::backend::Backend;
use catoptric::backend::cpu::Cpu;
use catoptric::camera::{Camera, Pinhole};
use catoptric::cloud::{Finish, Place, Surfel, Surfels};
use catoptric::gbuffer::{GBuffer, SplatSettings};
use catoptric::job::Job;
use glam::{DVec3, UVec2, Vec2, Vec3};
use libtest_mimic::Trial;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "leaks::a_plate_of_random_points_lets_one_leak_in_twenty_through_at_most",
            a_plate_of_random_points_lets_one_leak_in_twenty_through_at_most,
        ),
        claim(
            "leaks::holes_of_two_spacings_close_and_holes_of_five_stay",
            holes_of_two_spacings_close_and_holes_of_five_stay,
        ),
        claim(
            "leaks::a_gap_as_wide_stays_where_points_are_dense",
            a_gap_as_wide_stays_where_points_are_dense,
        ),
    ]
}

/// Between the plate's points, metres.
const SPACING: f32 = 0.02;

/// Pixels of a side: the plate's points are 2.1 pixels apart, so that a gap of two spacings is within the pass's reach.
const SIDE: u32 = 140;

/// The camera at 3 on the z axis, looking at the origin.
fn camera() -> Pinhole {
    let camera = Camera {
        position: DVec3::new(0.0, 0.0, 3.0),
        target: DVec3::ZERO,
        up: DVec3::Y,
        fov_y_degrees: 25.0,
        near: 0.1,
        far: 10.0,
        size: UVec2::splat(SIDE),
    };
    camera.pinhole(DVec3::ZERO).expect("a sound camera")
}

/// Random points of a square at height `z`, so many spacings wide.
fn square(rng: &mut Pcg64, z: f32, spacing: f32, wide: u32, albedo: f32) -> Vec<Surfel> {
    let half = 0.5 * spacing * wide as f32;
    (0..wide * wide)
        .map(|_| Surfel {
            position: Vec3::new(
                rng.random_range(-half..half),
                rng.random_range(-half..half),
                z,
            ),
            radius: spacing,
            normal: Vec3::Z,
            albedo: Vec3::splat(albedo),
            mirror: 0.0,
            specular: 0.0,
            shininess: 0.0,
        })
        .collect()
}

/// Centres of the holes, in the plate's plane.
fn centres() -> impl Iterator<Item = Vec2> {
    (0..25).map(|i| Vec2::new((i % 5) as f32 - 2.0, (i / 5) as f32 - 2.0) * 0.25)
}

/// A black plate in front of a white wall, with 25 round holes of such a diameter (metres), and points of such a spacing.
fn plate(seed: u64, spacing: f32, diameter: f32) -> Arc<Surfels> {
    let mut rng = Pcg64::seed_from_u64(seed);
    let wide = (1.6 / spacing) as u32;
    let mut points = square(&mut rng, 0.0, spacing, wide, 0.0);
    points.retain(|p| centres().all(|c| 2.0 * c.distance(p.position.truncate()) >= diameter));
    // Denser than it needs to be, so that the wall has no gaps of its own.
    points.extend(
        square(&mut rng, -3.0, 0.03, 120, 1.0)
            .into_iter()
            .map(|p| Surfel { radius: 0.05, ..p }),
    );
    Arc::new(Surfels {
        places: (points.iter())
            .map(|s| Place {
                position: s.position,
                radius: s.radius,
            })
            .collect(),
        finishes: points.iter().map(Finish::pack).collect(),
        source: (0..points.len() as u32).collect(),
        origin: DVec3::ZERO,
    })
}

/// As splatted, and as filled.
fn seen(surfels: &Arc<Surfels>) -> [GBuffer<Cpu>; 2] {
    let (settings, job, mut cpu) = (SplatSettings::default(), Job::default(), Cpu::default());
    let points = cpu.upload(surfels).expect("points");
    [false, true].map(|filled| {
        let mut seen = (cpu.splat(&points, &camera(), &settings, &job)).expect("a G-buffer");
        if filled {
            cpu.fill(&mut seen, &settings, &job).expect("filled");
        }
        seen
    })
}

/// Whether each pixel shows the wall.
fn through(seen: &GBuffer<Cpu>) -> Vec<bool> {
    (seen.surface.values().iter().zip(seen.albedo.values()))
        .map(|(s, a)| s.w > 4.0 && a.x > 0.5)
        .collect()
}

/// Pixels that show the wall at the holes' places, and elsewhere but for the picture's border, where nothing encloses a gap.
fn at_holes_and_elsewhere(seen: &GBuffer<Cpu>, diameter: f32) -> [usize; 2] {
    let mut counts = [0; 2];
    for (i, _) in through(seen).iter().enumerate().filter(|(_, open)| **open) {
        let (x, y) = (i as u32 % SIDE, i as u32 / SIDE);
        let at = seen.direction(x as i32, y as i32).truncate() * 3.0;
        let hole = centres().any(|c| c.distance(at) < 0.5 * diameter);
        let border = x.min(y) < 4 || x.max(y) >= SIDE - 4;
        if hole || !border {
            counts[usize::from(!hole)] += 1;
        }
    }
    counts
}

const SEEDS: std::ops::Range<u64> = 0..4;

fn a_plate_of_random_points_lets_one_leak_in_twenty_through_at_most() {
    let (mut before, mut after) = (0, 0);
    for seed in SEEDS {
        let [splatted, filled] = seen(&plate(seed, SPACING, 0.0));
        before += at_holes_and_elsewhere(&splatted, 0.0)[1];
        after += at_holes_and_elsewhere(&filled, 0.0)[1];
    }
    println!("leaks: {before} pixels before, {after} after");
    // The negative control: it does leak before.
    assert!(before > 100, "only {before} pixels leak as splatted");
    assert!(
        after * 20 <= before,
        "{after} of {before} pixels still leak"
    );
}

/// Pixels that show the wall through holes of so many spacings, as splatted and as filled.
fn open(spacings: f32) -> [usize; 2] {
    let mut sums = [0; 2];
    for seed in SEEDS {
        let diameter = spacings * SPACING;
        let both = seen(&plate(seed, SPACING, diameter));
        for (sum, seen) in sums.iter_mut().zip(&both) {
            *sum += at_holes_and_elsewhere(seen, diameter)[0];
        }
    }
    println!("holes of {spacings} spacings: {sums:?} pixels open as splatted, as filled");
    sums
}

fn holes_of_two_spacings_close_and_holes_of_five_stay() {
    // Discs of 1.5 spacings reach into a hole from all sides: 2 are covered, 3 all but, of 5 two stay.
    let [_, two] = open(2.0);
    let [three_before, three] = open(3.0);
    let [splatted, five] = open(5.0);
    assert!(splatted > 500, "the discs cover holes of 5: {splatted}");
    assert!(
        five * 100 >= splatted * 95,
        "{five} of {splatted} pixels of holes of 5 spacings stay"
    );
    assert!(
        two * 50 <= splatted && three * 4 <= three_before,
        "{two} pixels of holes of 2 spacings are open, {three} of {three_before} of 3"
    );
}

fn a_gap_as_wide_stays_where_points_are_dense() {
    // 2.5 spacings of the plate above, but 10 of this one's.
    let diameter = 2.5 * SPACING;
    let [splatted, filled] = seen(&plate(1, 0.25 * SPACING, diameter))
        .map(|seen| at_holes_and_elsewhere(&seen, diameter)[0]);
    assert!(splatted > 100, "the discs cover the holes: {splatted}");
    assert!(
        filled * 100 >= splatted * 95,
        "{filled} of {splatted} pixels stay"
    );
}
