//! What it means that the pointer has gone from here to there with a part of the gizmo.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::grips::{self, Grip};
use crate::viewer::handles::{Arm, Drag, Handle};
use crate::viewer::screen::Screen;

/// Steps of a drag with Ctrl: of a turn, radians; of a factor; of a length at least, points of the window.
const TURN_STEP: f64 = PI / 12.0;
const GROW_STEP: f64 = 0.1;
const LEAST_STEP: f64 = 8.0;

/// Nothing is dragged farther than this, in distances from the eye.
const HORIZON: f64 = 1e3;

/// A part of the gizmo that is held.
#[derive(Debug, Clone)]
pub(super) struct Grasp {
    pub(super) grip: Grip,
    /// The shape as it was taken.
    pub(super) start: Handle,
    centre: DVec3,
    way: Way,
    /// A length that is round, to go by.
    step: f64,
    /// Length of a point of the window at the centre.
    unit: f64,
}

/// How places in the window become what is done.
#[derive(Debug, Clone, Copy)]
enum Way {
    /// Along a line.
    Line {
        through: DVec3,
        along: DVec3,
        from: f64,
        arm: Option<Arm>,
    },
    /// In the plane of two unit vectors.
    Plane { along: [DVec3; 2], from: DVec3 },
    /// About an axis, by the angle in its plane.
    About { axis: DVec3, from: f64 },
    /// About an axis that is seen from its side: radians per point of the window.
    Roll {
        axis: DVec3,
        rate: DVec2,
        from: DVec2,
    },
    /// By the distance from a place in the window.
    Distance { from: f64 },
}

impl Grasp {
    /// Takes a part at a place in the window; `None` where that says nothing.
    pub(super) fn new(
        grip: Grip,
        handle: &Handle,
        own_axes: bool,
        screen: &Screen,
        at: DVec2,
    ) -> Option<Self> {
        let (centre, axes) = (handle.centre(), grips::axes(handle, own_axes));
        let unit = screen.unit(centre)?;
        let line = |through: DVec3, along: DVec3, arm| {
            let from = along_line(screen, through, along, at)?;
            Some(Way::Line {
                through,
                along,
                from,
                arm,
            })
        };
        let plane = |along: [DVec3; 2]| {
            let from = on_plane(screen, centre, along[0].cross(along[1]), at)?;
            Some(Way::Plane { along, from })
        };
        let [right, up, forward] = screen.axes();
        let way = match grip {
            Grip::Axis(i) => line(centre, axes[i], None)?,
            Grip::Across(i) => plane([axes[(i + 1) % 3], axes[(i + 2) % 3]])?,
            Grip::View => plane([right, up])?,
            Grip::Ring(i) if grips::is_edge_on(screen, centre, axes[i]) => {
                roll(screen, centre, axes[i], unit * grips::REACH, at)?
            }
            Grip::Ring(i) => about(screen, centre, axes[i], at)?,
            Grip::ViewRing => about(screen, centre, -forward, at)?,
            Grip::Arm(i) => {
                let arm = *handle.arms().get(i)?;
                line(arm.at, arm.direction, Some(arm))?
            }
            Grip::Grow => {
                let from = screen.place(centre)?.distance(at);
                (from > 1.0).then_some(Way::Distance { from })?
            }
        };
        Some(Self {
            grip,
            start: handle.clone(),
            centre,
            way,
            step: round_up(unit * LEAST_STEP),
            unit,
        })
    }

    /// What is done when the pointer is at a place; `None` where that says nothing.
    pub(super) fn drag(&self, screen: &Screen, at: DVec2, in_steps: bool) -> Option<Drag> {
        let snap = |value: f64, step: f64| {
            if in_steps {
                (value / step).round() * step
            } else {
                value
            }
        };
        Some(match self.way {
            Way::Line {
                through,
                along,
                from,
                arm,
            } => {
                let by = snap(along_line(screen, through, along, at)? - from, self.step);
                match arm {
                    Some(arm) => Drag::Pull(arm.part, by),
                    None => Drag::Shift(along * by),
                }
            }
            Way::Plane {
                along: [u, v],
                from,
            } => {
                let by = on_plane(screen, self.centre, u.cross(v), at)? - from;
                Drag::Shift(u * snap(by.dot(u), self.step) + v * snap(by.dot(v), self.step))
            }
            Way::About { axis, from } => {
                let turned = angle(screen, self.centre, axis, at)? - from;
                let angle = snap(nearest_turn(turned), TURN_STEP);
                Drag::Turn { axis, angle }
            }
            Way::Roll { axis, rate, from } => {
                let angle = snap((at - from).dot(rate), TURN_STEP);
                Drag::Turn { axis, angle }
            }
            Way::Distance { from } => {
                let factor = screen.place(self.centre)?.distance(at) / from;
                Drag::Grow(snap(factor, GROW_STEP).max(if in_steps { GROW_STEP } else { 0.0 }))
            }
        })
    }

    /// The line that is moved along, or turned about.
    pub(super) fn line(&self) -> Option<[DVec3; 2]> {
        match self.way {
            Way::Line { through, along, .. } => Some([through, along]),
            Way::About { axis, .. } | Way::Roll { axis, .. } => Some([self.centre, axis]),
            Way::Plane { .. } | Way::Distance { .. } => None,
        }
    }

    /// What is said of a drag: how much, in as many digits as the window tells.
    pub(super) fn says(&self, drag: &Drag, now: &Handle) -> String {
        let digits = digits(self.unit);
        match *drag {
            Drag::Shift(by) => {
                if let (Grip::Axis(_), Some([_, along])) = (self.grip, self.line()) {
                    return format!("{:+.digits$}", by.dot(along));
                }
                format!("{:+.digits$} {:+.digits$} {:+.digits$}", by.x, by.y, by.z)
            }
            Drag::Turn { angle, .. } => format!("{:+.1}°", angle.to_degrees()),
            Drag::Pull(part, _) => {
                let measure = now.measure(part);
                format!("{} {:.digits$}", measure.name, measure.value)
            }
            Drag::Grow(factor) => format!("× {factor:.3}"),
        }
    }
}

/// How far along a line the pointer is: at the point of the line that is seen nearest to it.
fn along_line(screen: &Screen, through: DVec3, along: DVec3, at: DVec2) -> Option<f64> {
    let (start, motion) = (screen.place(through)?, screen.motion(through, along)?);
    let direction = motion.try_normalize()?;
    let foot = start + direction * (at - start).dot(direction);
    // The ray through there meets the line.
    let ray = screen.ray(foot);
    let to = screen.eye() - through;
    let cos = ray.dot(along);
    let sin_squared = 1.0 - cos * cos;
    let t = (to.dot(along) - cos * to.dot(ray)) / sin_squared;
    let depth = (cos * to.dot(along) - to.dot(ray)) / sin_squared;
    let is_seen = sin_squared > 1e-9 && depth > 0.0 && t.abs() < HORIZON * to.length();
    is_seen.then_some(t)
}

/// The point of a plane under the pointer.
fn on_plane(screen: &Screen, centre: DVec3, normal: DVec3, at: DVec2) -> Option<DVec3> {
    let ray = screen.ray(at);
    let to = centre - screen.eye();
    let t = to.dot(normal) / ray.dot(normal);
    (t > 0.0 && t < HORIZON * to.length()).then(|| screen.eye() + ray * t)
}

/// The angle of the pointer about an axis, radians.
fn angle(screen: &Screen, centre: DVec3, axis: DVec3, at: DVec2) -> Option<f64> {
    let (u, v) = axis.any_orthonormal_pair();
    let out = on_plane(screen, centre, axis, at)? - centre;
    Some(out.dot(v).atan2(out.dot(u)))
}

fn about(screen: &Screen, centre: DVec3, axis: DVec3, at: DVec2) -> Option<Way> {
    let from = angle(screen, centre, axis, at)?;
    Some(Way::About { axis, from })
}

/// A ring from its edge is rolled: where it was taken, it follows the pointer.
fn roll(screen: &Screen, centre: DVec3, axis: DVec3, radius: f64, at: DVec2) -> Option<Way> {
    let to_eye = screen.eye() - centre;
    let front = grips::circle(centre, axis, radius).into_iter();
    let taken = front
        .filter(|p| (*p - centre).dot(to_eye) > 0.0)
        .filter_map(|p| Some((screen.place(p)?.distance(at), p)))
        .min_by(|a, b| a.0.total_cmp(&b.0))?
        .1;
    let motion = screen.motion(taken, axis.cross(taken - centre))?;
    let rate = motion / motion.length_squared();
    rate.is_finite().then_some(Way::Roll {
        axis,
        rate,
        from: at,
    })
}

/// The same turn, within half a turn.
fn nearest_turn(angle: f64) -> f64 {
    angle - (angle / TAU).round() * TAU
}

/// The least of 1, 2, 5, 10 ... that is not below a length.
fn round_up(length: f64) -> f64 {
    let power = 10f64.powf(length.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * power >= length);
    factor.unwrap_or(10.0) * power
}

/// Digits behind the point that tell one point of the window from the next.
fn digits(unit: f64) -> usize {
    (-unit.log10().floor()).clamp(0.0, 9.0) as usize
}
