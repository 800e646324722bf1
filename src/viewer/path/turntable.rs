//! Once about a pivot.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::{Pose, sound};

/// A full circle about an axis through the pivot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::viewer) struct Turntable {
    /// The view that it begins with; the axis is its `up`.
    pub(in crate::viewer) from: Pose,
    pub(in crate::viewer) pivot: DVec3,
    /// Of the circle, above 0.
    pub(in crate::viewer) seconds: f64,
    /// Which way the camera goes, seen from above.
    pub(in crate::viewer) clockwise: bool,
}

impl Turntable {
    /// Shortest and longest circle, seconds.
    pub(in crate::viewer) const SECONDS: std::ops::RangeInclusive<f64> = 0.1..=3600.0;

    /// With good defaults.
    pub(in crate::viewer) fn new(from: Pose, pivot: DVec3) -> Self {
        Self {
            from,
            pivot,
            seconds: 10.0,
            clockwise: false,
        }
    }

    /// The view at a time; the circle goes on and on.
    pub(super) fn pose(&self, time: f64) -> Pose {
        let part = (time / self.seconds).rem_euclid(1.0);
        if part == 0.0 {
            // To the last digit.
            return self.from;
        }
        let angle = if self.clockwise { -part } else { part } * TAU;
        let axis = self.from.up.normalize_or(DVec3::Y);
        let turn = DQuat::from_axis_angle(axis, angle);
        let place = |point: DVec3| self.pivot + turn * (point - self.pivot);
        let pose = Pose {
            position: place(self.from.position),
            target: place(self.from.target),
            ..self.from
        };
        sound(pose, self.from)
    }
}
