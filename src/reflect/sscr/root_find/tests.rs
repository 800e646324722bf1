//! Axes and flat mirrors, whose answers are known on paper.

use glam::{Vec3, Vec4};

use super::*;
use crate::gbuffer::disc::PixelRect;
use crate::grid::Grid;
use crate::reflect::sscr::LhcMap;
use crate::reflect::{Eye, Surface};

#[test]
fn the_root_divides_the_step_as_the_errors_do() {
    assert_eq!(between(2.0, 6.0, 1.0, -3.0), 3.0);
    assert_eq!(between(2.0, 6.0, 0.0, 0.0), 4.0);
}

#[test]
fn a_change_of_sign_turns_round_and_halves_the_step() {
    let axis = Axis {
        direction: 1.0,
        step: 8.0,
    };
    let turned = |before: f32, after: f32| {
        let mut axis = axis;
        axis.turn(before, after);
        (axis.direction, axis.step)
    };
    assert_eq!(turned(2.0, 1.0), (1.0, 8.0), "nearer");
    assert_eq!(turned(1.0, 2.0), (-1.0, 8.0), "farther");
    assert_eq!(turned(1.0, -0.5), (-1.0, 4.0), "passed");
}

/// A flat mirror of `size` pixels in the plane z = 0, a unit a pixel, seen from far above its first corner.
fn flat(size: UVec2) -> (Surface<Cpu>, LhcMap) {
    let pixels = size.x * size.y;
    let point = |i: u32| {
        let (x, y) = ((i % size.x) as f32 + 0.5, (i / size.x) as f32 + 0.5);
        Vec4::new(x, -y, 0.0, 1.0)
    };
    let grid = |value: &dyn Fn(u32) -> Vec4| {
        Grid::from_vec(size, (0..pixels).map(value).collect()).unwrap()
    };
    let surface = Surface {
        size,
        point: grid(&point),
        normal: grid(&|_| Vec3::Z.extend(1.0)),
        eye: Eye::Point(Vec3::Z * 1000.0),
    };
    let region = Region {
        bounds: PixelRect {
            x0: 0,
            y0: 0,
            x1: size.x,
            y1: size.y,
        },
        pixels,
        weight: 1.0,
        accumulated_weight: 1.0,
    };
    let lhc = LhcMap {
        labels: Grid::new(size, 1),
        regions: vec![region],
    };
    (surface, lhc)
}

const PARAMS: RootFindParams = RootFindParams {
    seed_attempts: 6,
    step_attempts: 6,
    max_steps: 50,
    initial_step: 0.2,
    threshold: 4.0,
    self_hit: 4.0,
};

#[test]
fn a_flat_mirror_shows_a_point_halfway_to_its_mirror_image() {
    let (surface, lhc) = flat(UVec2::splat(100));
    let finder = RootFinder::new(&LabelledMirrors::new(&surface, &lhc, Vec3::X), PARAMS).unwrap();
    // As far away as the eye: seen in the middle between both.
    let point = Vec3::new(80.0, -60.0, 1000.0);
    let mut found = 0;
    for index in 0..100 {
        if let Outcome::Found(root) = finder.find(index, point, 1) {
            found += 1;
            let off = root.pixel.distance(Vec2::new(40.0, 30.0));
            assert!(off < 0.1, "{root:?} is {off} pixels off");
            assert!((root.distance - 1001.2).abs() < 0.1, "{root:?}");
        }
    }
    assert!(found >= 50, "found from {found} of 100 seeds");
}

#[test]
fn what_the_mirror_cannot_show_is_lost() {
    let (surface, lhc) = flat(UVec2::splat(100));
    let finder = RootFinder::new(&LabelledMirrors::new(&surface, &lhc, Vec3::X), PARAMS).unwrap();
    let lost = |point: Vec3, region: u32| {
        (0..100).all(|i| matches!(finder.find(i, point, region), Outcome::Lost(_)))
    };
    let shown = Vec3::new(80.0, -60.0, 1000.0);
    assert!(!lost(shown, 1), "negative control");
    assert!(lost(shown, 0) && lost(shown, 2), "in no region");
    assert!(
        lost(Vec3::new(500.0, -60.0, 1000.0), 1),
        "beside the mirror"
    );
    assert!(
        lost(Vec3::new(80.0, -60.0, -1000.0), 1),
        "behind the mirror"
    );
    assert!(lost(Vec3::new(40.0, -30.0, 3.9), 1), "a point of its own");
    assert!(lost(Vec3::NAN, 1) && lost(Vec3::INFINITY, 1), "nowhere");
}

#[test]
fn mirrors_of_a_few_pixels_are_searched_without_harm() {
    for size in [UVec2::ONE, UVec2::splat(2), UVec2::new(1, 100)] {
        let (surface, lhc) = flat(size);
        let finder =
            RootFinder::new(&LabelledMirrors::new(&surface, &lhc, Vec3::X), PARAMS).unwrap();
        for index in 0..100 {
            let point = Vec3::new(1.0, -1.0, 1000.0);
            if let Outcome::Found(root) = finder.find(index, point, 1) {
                let inside =
                    root.pixel.cmpgt(Vec2::ZERO).all() && root.pixel.cmplt(size.as_vec2()).all();
                assert!(inside, "{root:?} in a mirror of {size} pixels");
            }
        }
    }
    let (surface, _) = flat(UVec2::ONE);
    let none = LhcMap {
        labels: Grid::new(UVec2::ONE, 0),
        regions: Vec::new(),
    };
    let finder = RootFinder::new(&LabelledMirrors::new(&surface, &none, Vec3::X), PARAMS).unwrap();
    assert_eq!(
        finder.find(0, Vec3::Z, 1),
        Outcome::Lost(End::default()),
        "no region"
    );
}
