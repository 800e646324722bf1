//! Lengths of a shape that are pulled one by one: a radius, a side.

use catoptric::cloud::Bounds;
use catoptric::cloud::generate::Shape;
use glam::DVec3;

use super::{Handle, in_reach, length};

/// How much longer the major radius of a torus is than the minor one, at least.
const RING: f64 = 1.001;

/// A length of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::viewer) enum Part {
    /// Of a ball, a blob, bumps.
    Radius,
    /// Of a paraboloid.
    RimRadius,
    FocalLength,
    /// Of a torus.
    MajorRadius,
    MinorRadius,
    /// One side of a plane or a box: the other stays where it is.
    Side {
        /// 0 to 2; of a plane, 0 is its width and 1 its height.
        axis: usize,
        /// Whether it is the one in the direction of the axis.
        upper: bool,
    },
}

/// Where a length is pulled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::viewer) struct Arm {
    pub(in crate::viewer) part: Part,
    /// On the shape.
    pub(in crate::viewer) at: DVec3,
    /// Unit vector that the length grows along.
    pub(in crate::viewer) direction: DVec3,
    /// Which of the shape's own axes that is.
    pub(in crate::viewer) axis: usize,
}

/// A length as it is, and what it is called.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::viewer) struct Measure {
    pub(in crate::viewer) name: &'static str,
    pub(in crate::viewer) length: f64,
    /// What is said of it: the length, or the coordinate of a box's side.
    pub(in crate::viewer) value: f64,
}

impl Measure {
    const fn new(name: &'static str, length: f64) -> Self {
        Self {
            name,
            length,
            value: length,
        }
    }
}

impl Handle {
    /// All that can be pulled, and where.
    pub(in crate::viewer) fn arms(&self) -> Vec<Arm> {
        let (centre, axes) = (self.centre(), self.axes());
        let arm = |part, axis: usize, sign: f64, at: DVec3| Arm {
            part,
            at,
            direction: axes[axis] * sign,
            axis,
        };
        let around = |part, over: std::ops::Range<usize>, reach: f64, ahead: DVec3| -> Vec<Arm> {
            over.flat_map(|axis| [(axis, 1.0), (axis, -1.0)])
                .map(|(axis, sign)| {
                    let out = axes[axis] * (sign * reach);
                    arm(part, axis, sign, centre + ahead + out)
                })
                .collect()
        };
        match *self {
            Self::Mirror(
                Shape::Sphere { radius, .. }
                | Shape::Blob { radius, .. }
                | Shape::Bumps { radius, .. },
            ) => around(Part::Radius, 0..3, radius, DVec3::ZERO),
            Self::Mirror(Shape::Paraboloid {
                axis: _,
                focal_length,
                rim_radius,
                ..
            }) => {
                let depth = axes[2] * (rim_radius * rim_radius / (4.0 * focal_length));
                let mut arms = around(Part::RimRadius, 0..2, rim_radius, depth);
                let focus = centre + axes[2] * focal_length;
                arms.push(arm(Part::FocalLength, 2, 1.0, focus));
                arms
            }
            Self::Mirror(Shape::Torus {
                major_radius,
                minor_radius,
                ..
            }) => {
                let mut arms = around(Part::MajorRadius, 0..2, major_radius, DVec3::ZERO);
                arms.extend(around(Part::MinorRadius, 2..3, minor_radius, DVec3::ZERO));
                arms
            }
            Self::Mirror(Shape::Plane { size, .. }) => {
                sides(2, DVec3::new(size.x, size.y, 0.0), &axes, centre)
            }
            Self::Box(bounds) => sides(3, bounds.size(), &axes, centre),
            Self::Mirror(Shape::Mesh(_)) => Vec::new(),
        }
    }

    /// A length as it is; 0 where the shape has none such.
    pub(in crate::viewer) fn measure(&self, part: Part) -> Measure {
        match (self, part) {
            (
                Self::Mirror(
                    Shape::Sphere { radius, .. }
                    | Shape::Blob { radius, .. }
                    | Shape::Bumps { radius, .. },
                ),
                Part::Radius,
            ) => Measure::new("radius", *radius),
            (Self::Mirror(Shape::Paraboloid { rim_radius, .. }), Part::RimRadius) => {
                Measure::new("rim radius", *rim_radius)
            }
            (Self::Mirror(Shape::Paraboloid { focal_length, .. }), Part::FocalLength) => {
                Measure::new("focal length", *focal_length)
            }
            (Self::Mirror(Shape::Torus { major_radius, .. }), Part::MajorRadius) => {
                Measure::new("major radius", *major_radius)
            }
            (Self::Mirror(Shape::Torus { minor_radius, .. }), Part::MinorRadius) => {
                Measure::new("minor radius", *minor_radius)
            }
            (Self::Mirror(Shape::Plane { size, .. }), Part::Side { axis, .. }) => match axis {
                0 => Measure::new("width", size.x),
                _ => Measure::new("height", size.y),
            },
            (Self::Box(bounds), Part::Side { axis, upper }) => {
                let axis = axis.min(2);
                let names = [["min x", "max x"], ["min y", "max y"], ["min z", "max z"]];
                let corner = if upper { bounds.max } else { bounds.min };
                Measure {
                    name: names[axis][usize::from(upper)],
                    length: bounds.size()[axis],
                    value: corner[axis],
                }
            }
            _ => Measure::new("", 0.0),
        }
    }

    /// One length is larger by `by`; what belongs to another shape changes nothing.
    pub(super) fn pulled(&self, part: Part, by: f64) -> Self {
        let axes = self.axes();
        let mut pulled = self.clone();
        match (&mut pulled, part) {
            (
                Self::Mirror(
                    Shape::Sphere { radius, .. }
                    | Shape::Blob { radius, .. }
                    | Shape::Bumps { radius, .. },
                ),
                Part::Radius,
            ) => *radius = length(*radius, *radius + by),
            (Self::Mirror(Shape::Paraboloid { rim_radius, .. }), Part::RimRadius) => {
                *rim_radius = length(*rim_radius, *rim_radius + by);
            }
            (Self::Mirror(Shape::Paraboloid { focal_length, .. }), Part::FocalLength) => {
                *focal_length = length(*focal_length, *focal_length + by);
            }
            (
                Self::Mirror(Shape::Torus {
                    major_radius,
                    minor_radius,
                    ..
                }),
                Part::MajorRadius,
            ) => {
                let least = (*minor_radius * RING).min(*major_radius);
                *major_radius = length(*major_radius, *major_radius + by).max(least);
            }
            (
                Self::Mirror(Shape::Torus {
                    major_radius,
                    minor_radius,
                    ..
                }),
                Part::MinorRadius,
            ) => {
                let most = (*major_radius / RING).max(*minor_radius);
                *minor_radius = length(*minor_radius, *minor_radius + by).min(most);
            }
            (Self::Mirror(Shape::Plane { centre, size, .. }), Part::Side { axis, upper }) => {
                let axis = axis.min(1);
                let side = length(size[axis], size[axis] + by);
                let out = if upper { axes[axis] } else { -axes[axis] };
                *centre = in_reach(*centre + out * ((side - size[axis]) / 2.0));
                size[axis] = side;
            }
            (Self::Box(bounds), Part::Side { axis, upper }) => {
                let axis = axis.min(2);
                pull_side(bounds, axis, upper, by);
            }
            _ => {}
        }
        pulled
    }
}

fn sides(count: usize, size: DVec3, axes: &[DVec3; 3], centre: DVec3) -> Vec<Arm> {
    (0..count)
        .flat_map(|axis| [(axis, true), (axis, false)])
        .map(|(axis, upper)| {
            let direction = if upper { axes[axis] } else { -axes[axis] };
            Arm {
                part: Part::Side { axis, upper },
                at: centre + direction * (size[axis] / 2.0),
                direction,
                axis,
            }
        })
        .collect()
}

/// The other side stays where it is, to the bit.
fn pull_side(bounds: &mut Bounds, axis: usize, upper: bool, by: f64) {
    let side = bounds.size()[axis];
    // A flat box has no thickness of which a part would have to stay.
    let side = if side > 0.0 {
        length(side, side + by)
    } else {
        by.max(0.0)
    };
    if upper {
        let max = in_reach(bounds.min + side)[axis];
        bounds.max[axis] = max.max(bounds.min[axis]);
    } else {
        let min = in_reach(bounds.max - side)[axis];
        bounds.min[axis] = min.min(bounds.max[axis]);
    }
}
