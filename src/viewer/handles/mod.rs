//! What can be moved by hand: mirrors that have a place, and boxes along the axes.
//!
//! Pure functions: a drag of a shape gives the shape that comes of it. A shape offers what it can do alone (a ball is
//! not turned, a box stays along the axes), and whatever comes of it a scene file may hold.

mod pull;

#[cfg(test)]
pub(super) mod tests;

use catoptric::cloud::Bounds;
use catoptric::cloud::generate::Shape;
use catoptric::scene::MirrorShape;
use glam::{DQuat, DVec3};

pub(super) use pull::{Arm, Part};

/// Nothing is dragged farther from 0 than this; scene files go to 1e15.
const FAR: f64 = 9e14;

/// Lengths that a drag can give, but for those that are shorter or longer before it; scene files go to 1e12.
const SHORTEST: f64 = 1e-9;
const LONGEST: f64 = 9e11;

/// What one drag leaves of a length, at least.
const LEAST_PART: f64 = 1e-3;

/// A shape that can be moved by hand.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Handle {
    /// Any but a mesh, which has no place of its own.
    Mirror(Shape),
    /// A box along the scene's axes.
    Box(Bounds),
}

/// What a drag does to a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Drag {
    /// Moves it.
    Shift(DVec3),
    /// Turns it about its centre.
    Turn {
        /// Of any length but 0, in the scene's frame.
        axis: DVec3,
        /// Radians.
        angle: f64,
    },
    /// Makes one of its lengths larger by this, or smaller.
    Pull(Part, f64),
    /// Multiplies all its lengths.
    Grow(f64),
}

impl Handle {
    /// `None` for a mesh.
    pub(super) fn of_mirror(mirror: &MirrorShape) -> Option<Self> {
        match mirror {
            MirrorShape::Mesh { .. } | MirrorShape::Shape(Shape::Mesh(_)) => None,
            MirrorShape::Shape(shape) => Some(Self::Mirror(shape.clone())),
        }
    }

    /// As the scene has it; `None` for a box.
    pub(super) fn mirror(&self) -> Option<MirrorShape> {
        match self {
            Self::Mirror(shape) => Some(MirrorShape::Shape(shape.clone())),
            Self::Box(_) => None,
        }
    }

    /// What it is moved by and turned about.
    pub(super) fn centre(&self) -> DVec3 {
        match self {
            Self::Box(bounds) => bounds.min / 2.0 + bounds.max / 2.0,
            Self::Mirror(shape) => match *shape {
                Shape::Plane { centre, .. }
                | Shape::Sphere { centre, .. }
                | Shape::Torus { centre, .. }
                | Shape::Blob { centre, .. }
                | Shape::Bumps { centre, .. } => centre,
                Shape::Paraboloid { vertex, .. } => vertex,
                Shape::Mesh(_) => DVec3::ZERO,
            },
        }
    }

    /// Its own axes, a right-handed system of unit vectors: a plane's width, height and normal, the axis of what turns
    /// about one last, else the scene's.
    pub(super) fn axes(&self) -> [DVec3; 3] {
        match *self {
            Self::Mirror(Shape::Plane { normal, up, .. }) => {
                let normal = normal.normalize_or(DVec3::Z);
                let across = normal.any_orthonormal_vector();
                let up = up.reject_from_normalized(normal).normalize_or(across);
                [up.cross(normal), up, normal]
            }
            Self::Mirror(Shape::Paraboloid { axis, .. } | Shape::Torus { axis, .. }) => {
                let axis = axis.normalize_or(DVec3::Z);
                let (u, v) = axis.any_orthonormal_pair();
                [u, v, axis]
            }
            Self::Mirror(
                Shape::Sphere { .. } | Shape::Blob { .. } | Shape::Bumps { .. } | Shape::Mesh(_),
            )
            | Self::Box(_) => DVec3::AXES,
        }
    }

    /// Which turns about its own axes change it.
    pub(super) fn turns(&self) -> [bool; 3] {
        match self {
            Self::Mirror(Shape::Plane { .. }) => [true; 3],
            Self::Mirror(Shape::Paraboloid { .. } | Shape::Torus { .. }) => [true, true, false],
            Self::Mirror(
                Shape::Sphere { .. } | Shape::Blob { .. } | Shape::Bumps { .. } | Shape::Mesh(_),
            )
            | Self::Box(_) => [false; 3],
        }
    }

    /// What comes of a drag; itself where that is nothing that a scene can hold.
    pub(super) fn dragged(&self, drag: &Drag) -> Self {
        match *drag {
            Drag::Shift(by) if by.is_finite() && by != DVec3::ZERO => self.shifted(by),
            Drag::Turn { axis, angle } if angle.is_finite() && angle != 0.0 => {
                match axis.try_normalize() {
                    Some(axis) => self.turned(DQuat::from_axis_angle(axis, angle)),
                    None => self.clone(),
                }
            }
            Drag::Pull(part, by) if by.is_finite() && by != 0.0 => self.pulled(part, by),
            Drag::Grow(factor) if factor.is_finite() && factor != 1.0 => self.grown(factor),
            Drag::Shift(_) | Drag::Turn { .. } | Drag::Pull(..) | Drag::Grow(_) => self.clone(),
        }
    }

    fn shifted(&self, by: DVec3) -> Self {
        match self {
            Self::Mirror(shape) => {
                let centre = self.centre();
                let by = in_reach(centre + by) - centre;
                Self::Mirror(shape.scaled_and_shifted(1.0, centre, by))
            }
            Self::Box(bounds) => {
                let by = in_reach(bounds.min + by) - bounds.min;
                let by = in_reach(bounds.max + by) - bounds.max;
                Self::Box(Bounds {
                    min: bounds.min + by,
                    max: bounds.max + by,
                })
            }
        }
    }

    fn turned(&self, turn: DQuat) -> Self {
        let direction = |d: DVec3| (turn * d).normalize_or(d);
        let mut turned = self.clone();
        match &mut turned {
            Self::Mirror(Shape::Plane { normal, up, .. }) => {
                *normal = direction(*normal);
                // After many turns they are still perpendicular.
                let level = direction(*up).reject_from_normalized(*normal);
                *up = level.normalize_or(*up);
            }
            Self::Mirror(Shape::Paraboloid { axis, .. } | Shape::Torus { axis, .. }) => {
                *axis = direction(*axis);
            }
            Self::Mirror(
                Shape::Sphere { .. } | Shape::Blob { .. } | Shape::Bumps { .. } | Shape::Mesh(_),
            )
            | Self::Box(_) => {}
        }
        turned
    }

    fn grown(&self, factor: f64) -> Self {
        let lengths = self.arms();
        let lengths = lengths.iter().map(|arm| self.measure(arm.part).length);
        let (shortest, longest) = lengths
            .filter(|length| *length > 0.0)
            .fold((f64::INFINITY, 0.0f64), |(s, l), length| {
                (s.min(length), l.max(length))
            });
        if !(shortest <= longest) {
            return self.clone();
        }
        let least = (SHORTEST / shortest).clamp(LEAST_PART, 1.0);
        let factor = factor.clamp(least, (LONGEST / longest).max(1.0));
        let centre = self.centre();
        match self {
            Self::Mirror(shape) => {
                match shape.scaled_and_shifted(factor, centre, DVec3::ZERO) {
                    // Nearly as thick as wide, they may round to the same.
                    Shape::Torus {
                        major_radius,
                        minor_radius,
                        ..
                    } if minor_radius >= major_radius => self.clone(),
                    grown => Self::Mirror(grown),
                }
            }
            Self::Box(bounds) => {
                let half = bounds.size() / 2.0 * factor;
                Self::Box(Bounds {
                    min: in_reach(centre - half),
                    max: in_reach(centre + half),
                })
            }
        }
    }
}

/// The nearest point that a scene can hold.
fn in_reach(point: DVec3) -> DVec3 {
    point.clamp(DVec3::splat(-FAR), DVec3::splat(FAR))
}

/// A length that is to be another: at least a thousandth of what it was, and one that a scene can hold.
fn length(from: f64, to: f64) -> f64 {
    let least = (from * LEAST_PART).max(SHORTEST).min(from);
    to.clamp(least, LONGEST.max(from))
}
