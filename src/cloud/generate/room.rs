//! The room of the generated scenes: a closed box with coloured walls, seen from inside.

use glam::{DVec2, DVec3, Vec3};

use super::shape::Shape;

/// A wall of the room, named after the place where it stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wall {
    Left,
    Right,
    Ceiling,
    Back,
    Floor,
    Front,
}

/// Side of a square of the checkerboards, metres.
const SQUARE: f64 = 0.25;

const RED: Vec3 = Vec3::new(0.63, 0.065, 0.05);
const GREEN: Vec3 = Vec3::new(0.14, 0.45, 0.091);
const WHITE: Vec3 = Vec3::new(0.725, 0.71, 0.68);
const GREY: Vec3 = Vec3::splat(0.25);
const ORANGE: Vec3 = Vec3::new(0.75, 0.45, 0.10);
const BLUE: Vec3 = Vec3::new(0.10, 0.25, 0.65);

impl Wall {
    /// Every wall.
    pub(super) const ALL: [Self; 6] = [
        Self::Left,
        Self::Right,
        Self::Ceiling,
        Self::Back,
        Self::Floor,
        Self::Front,
    ];

    /// The rectangle that the wall is; its normal looks into the room, x and y -1 to 1, z -3 to 1 (metres).
    pub(super) fn shape(self) -> Shape {
        let (centre, normal, up, size) = match self {
            Self::Left => (
                DVec3::new(-1.0, 0.0, -1.0),
                DVec3::X,
                DVec3::Y,
                DVec2::new(4.0, 2.0),
            ),
            Self::Right => (
                DVec3::new(1.0, 0.0, -1.0),
                DVec3::NEG_X,
                DVec3::Y,
                DVec2::new(4.0, 2.0),
            ),
            Self::Ceiling => (
                DVec3::new(0.0, 1.0, -1.0),
                DVec3::NEG_Y,
                DVec3::Z,
                DVec2::new(2.0, 4.0),
            ),
            Self::Floor => (
                DVec3::new(0.0, -1.0, -1.0),
                DVec3::Y,
                DVec3::Z,
                DVec2::new(2.0, 4.0),
            ),
            Self::Back => (
                DVec3::new(0.0, 0.0, -3.0),
                DVec3::Z,
                DVec3::Y,
                DVec2::splat(2.0),
            ),
            Self::Front => (
                DVec3::new(0.0, 0.0, 1.0),
                DVec3::NEG_Z,
                DVec3::Y,
                DVec2::splat(2.0),
            ),
        };
        Shape::Plane {
            centre,
            normal,
            up,
            size,
        }
    }

    /// Linear RGB at a point of the wall.
    pub(super) fn albedo(self, p: DVec3) -> Vec3 {
        match self {
            Self::Left => RED,
            Self::Right => GREEN,
            Self::Ceiling | Self::Back => WHITE,
            Self::Floor => checkered(p.x, p.z, WHITE, GREY),
            Self::Front => checkered(p.x, p.y, ORANGE, BLUE),
        }
    }
}

fn checkered(a: f64, b: f64, even: Vec3, odd: Vec3) -> Vec3 {
    let index = (a / SQUARE).floor() + (b / SQUARE).floor();
    if index.rem_euclid(2.0) < 0.5 {
        even
    } else {
        odd
    }
}
