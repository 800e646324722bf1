//! Where a camera must stand to see all of a box.

use glam::DVec3;

use crate::cloud::{Bounds, UpAxis};

/// What a fitted view leaves free around the bounds.
const MARGIN: f64 = 1.05;

/// The way a fitted view looks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aim {
    /// Unit vector from what is looked at towards the eye.
    pub(super) to_eye: DVec3,
    /// Roughly up.
    pub(super) up: DVec3,
    /// Half of the picture's width and height at distance 1.
    pub(super) half_extent: (f64, f64),
}

/// From what a fitted view looks at towards its eye: a third of a right angle off the box's longer side, 27 degrees up.
///
/// The front is +z where y is up, and -y where z is up, as modelling programs have it, unless the box is longer
/// towards them.
pub(super) fn direction_to_eye(bounds: Bounds, up_axis: UpAxis) -> DVec3 {
    let (along, up, towards) = (0.5, 0.45, 0.74);
    let size = bounds.size();
    let direction = match up_axis {
        UpAxis::Y if size.z > size.x => DVec3::new(towards, up, along),
        UpAxis::Y => DVec3::new(along, up, towards),
        UpAxis::Z if size.y > size.x => DVec3::new(towards, -along, up),
        UpAxis::Z => DVec3::new(along, -towards, up),
    };
    direction.normalize()
}

/// Eye and target of the nearest view along `aim` that shows all of `bounds`. With a `target`, it is kept in the
/// middle of the picture; else the eye moves to the side so that the box is.
pub(super) fn fitted(bounds: Bounds, target: Option<DVec3>, aim: &Aim) -> (DVec3, DVec3) {
    let back = aim.to_eye;
    let right = aim
        .up
        .cross(back)
        .normalize_or(back.any_orthonormal_vector());
    let up = back.cross(right);
    let middle = target.unwrap_or(bounds.centre());

    let corners = corners(bounds).map(|corner| corner - middle);
    let [across, along] =
        [(right, aim.half_extent.0), (up, aim.half_extent.1)].map(|(axis, half_extent)| Side {
            offsets: corners.map(|c| (c.dot(axis), c.dot(back))),
            slope: half_extent / MARGIN,
        });
    let needed = match target {
        Some(_) => across
            .distance_about_middle()
            .max(along.distance_about_middle()),
        None => across.distance().max(along.distance()),
    };
    // A single point has no extent to fit.
    let distance = if needed > 0.0 { needed } else { 1.0 };
    let target = match target {
        Some(target) => target,
        None => {
            middle + right * across.centring_shift(distance) + up * along.centring_shift(distance)
        }
    };
    (target + back * distance, target)
}

/// The corners along one side of the picture, and its half extent at distance 1.
struct Side {
    /// Offset along the side, and towards the eye, from what is looked at.
    offsets: [(f64, f64); 8],
    slope: f64,
}

impl Side {
    /// The farthest that any corner reaches to the one side and to the other, both measured at the middle's depth.
    fn reach(&self) -> (f64, f64) {
        let low = self
            .offsets
            .iter()
            .map(|(x, towards)| x - self.slope * towards)
            .fold(f64::MAX, f64::min);
        let high = self
            .offsets
            .iter()
            .map(|(x, towards)| x + self.slope * towards)
            .fold(f64::MIN, f64::max);
        (low, high)
    }

    /// The smallest distance at which all corners fit, wherever the eye is shifted to.
    fn distance(&self) -> f64 {
        let (low, high) = self.reach();
        (high - low) / (2.0 * self.slope)
    }

    /// The smallest distance at which all corners fit without a shift.
    fn distance_about_middle(&self) -> f64 {
        let (low, high) = self.reach();
        high.max(-low).max(0.0) / self.slope
    }

    /// The shift of the eye, at `distance`, that leaves as much free on the one side of the picture as on the other.
    fn centring_shift(&self, distance: f64) -> f64 {
        let (low, high) = self.reach();
        let (mut left, mut right) = (high - self.slope * distance, low + self.slope * distance);
        // What is on screen moves one way as the eye moves the other, so halving finds the shift.
        for _ in 0..60 {
            let shift = left.midpoint(right);
            let on_screen = self
                .offsets
                .map(|(x, towards)| (x - shift) / (distance - towards).max(f64::MIN_POSITIVE));
            let (first, last) = (
                on_screen.into_iter().fold(f64::MAX, f64::min),
                on_screen.into_iter().fold(f64::MIN, f64::max),
            );
            if first + last > 0.0 {
                left = shift;
            } else {
                right = shift;
            }
        }
        left.midpoint(right)
    }
}

/// The corners of a box.
pub(super) fn corners(Bounds { min, max }: Bounds) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let side = |bit: usize| f64::from(u8::from(i & bit != 0));
        min + (max - min) * DVec3::new(side(1), side(2), side(4))
    })
}
