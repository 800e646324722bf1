//! What of the gizmo can be taken, where it is in the window, and which part is under the cursor.

use std::f64::consts::TAU;

use eframe::egui::{Pos2, Vec2};
use glam::DVec3;

use super::Mode;
use crate::viewer::handles::{Arm, Handle};
use crate::viewer::screen::Screen;

/// Lengths in the window, points.
pub(super) const REACH: f64 = 84.0;
const DISC: f32 = 9.0;
const OUTER: f32 = 104.0;
const SQUARE: [f64; 2] = [24.0, 42.0];
/// The least distance of what is pulled from the centre, and of arrows' ends.
const LEAST: f64 = 34.0;
const SHORT: f32 = 18.0;

/// How near the cursor must be, points.
const NEAR: f32 = 8.0;

/// Sines of the least angles between the view and a square or a ring.
const EDGE_ON: f64 = 0.2;

/// Parts of a ring.
const STEPS: usize = 72;

/// A part of the gizmo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::viewer) enum Grip {
    /// Moves along an axis.
    Axis(usize),
    /// Moves across an axis.
    Across(usize),
    /// Moves across the view.
    View,
    /// Turns about an axis.
    Ring(usize),
    /// Turns about the view.
    ViewRing,
    /// Pulls a length; its number among the shape's arms.
    Arm(usize),
    /// Makes everything larger or smaller.
    Grow,
}

/// Where a part is in the window.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::viewer) enum Outline {
    Arrow([Pos2; 2]),
    Square([Pos2; 4]),
    Disc(Pos2, f32),
    Circle(Pos2, f32),
    /// As many lines as are seen.
    Ring(Vec<Vec<Pos2>>),
    /// A knob at the end of a line.
    Knob([Pos2; 2]),
}

/// The axes that it moves and turns along: the shape's own, or the scene's.
pub(super) fn axes(handle: &Handle, own: bool) -> [DVec3; 3] {
    if own { handle.axes() } else { DVec3::AXES }
}

/// All parts that a shape offers in a mode; none where its centre is not in view.
pub(super) fn grips(
    screen: &Screen,
    handle: &Handle,
    mode: Mode,
    own: bool,
) -> Vec<(Grip, Outline)> {
    let centre = handle.centre();
    let (Some(middle), Some(unit)) = (screen.pos(centre), screen.unit(centre)) else {
        return Vec::new();
    };
    let axes = axes(handle, own);
    let mut grips = Vec::new();
    match mode {
        Mode::Move => {
            grips.push((Grip::View, Outline::Disc(middle, DISC)));
            for (i, axis) in axes.into_iter().enumerate() {
                let at = |along: f64| screen.pos(centre + axis * (unit * along));
                if let (Some(from), Some(to)) = (at(REACH * 0.2), at(REACH))
                    && middle.distance(to) > SHORT
                {
                    grips.push((Grip::Axis(i), Outline::Arrow([from, to])));
                }
                if let Some(square) = square(screen, centre, unit, &axes, i) {
                    grips.push((Grip::Across(i), Outline::Square(square)));
                }
            }
        }
        Mode::Turn => {
            let turns = handle.turns();
            for (i, axis) in axes.into_iter().enumerate() {
                if turns[i] || (!own && turns.contains(&true)) {
                    let ring = front_half(screen, centre, axis, unit * REACH);
                    grips.push((Grip::Ring(i), Outline::Ring(ring)));
                }
            }
            if !grips.is_empty() {
                grips.push((Grip::ViewRing, Outline::Circle(middle, OUTER)));
            }
        }
        Mode::Scale => {
            for (i, arm) in handle.arms().iter().enumerate() {
                if let Some(knob) = knob(screen, centre, unit, arm) {
                    grips.push((Grip::Arm(i), Outline::Knob([middle, knob])));
                }
            }
            grips.push((Grip::Grow, Outline::Circle(middle, OUTER)));
        }
    }
    grips
}

/// Where a length is pulled: on the shape, but not so near the centre that it could not be told from others.
fn knob(screen: &Screen, centre: DVec3, unit: f64, arm: &Arm) -> Option<Pos2> {
    let out = arm.at - centre;
    let factor = (LEAST * unit / out.length()).max(1.0);
    let knob = centre
        + if factor.is_finite() {
            out * factor
        } else {
            arm.direction * (LEAST * unit)
        };
    // Towards the eye nothing can be pulled.
    let motion = screen.motion(knob, arm.direction)?.length() * unit;
    (motion > f64::from(SHORT) / REACH).then(|| screen.pos(knob))?
}

/// The square across an axis; `None` where it is seen from its edge.
fn square(
    screen: &Screen,
    centre: DVec3,
    unit: f64,
    axes: &[DVec3; 3],
    across: usize,
) -> Option<[Pos2; 4]> {
    let view = (centre - screen.eye()).normalize_or(DVec3::Z);
    if view.dot(axes[across]).abs() < EDGE_ON {
        return None;
    }
    let (u, v) = (axes[(across + 1) % 3], axes[(across + 2) % 3]);
    let [near, far] = SQUARE;
    let mut corners = [Pos2::ZERO; 4];
    for (corner, (a, b)) in
        corners
            .iter_mut()
            .zip([(near, near), (far, near), (far, far), (near, far)])
    {
        *corner = screen.pos(centre + (u * a + v * b) * unit)?;
    }
    Some(corners)
}

/// Points of the circle about an axis.
pub(super) fn circle(centre: DVec3, axis: DVec3, radius: f64) -> Vec<DVec3> {
    let (u, v) = axis.any_orthonormal_pair();
    (0..=STEPS)
        .map(|k| {
            let (sin, cos) = (k as f64 / STEPS as f64 * TAU).sin_cos();
            centre + (u * cos + v * sin) * radius
        })
        .collect()
}

/// The half of a ring that is nearer to the eye; all of it where it is seen from its front.
fn front_half(screen: &Screen, centre: DVec3, axis: DVec3, radius: f64) -> Vec<Vec<Pos2>> {
    let to_eye = (screen.eye() - centre).normalize_or(DVec3::Z);
    let points = circle(centre, axis, radius);
    if to_eye.dot(axis).abs() > 0.99 {
        return screen.lines(&points);
    }
    let seen = |p: &DVec3| (*p - centre).dot(to_eye) > -0.02 * radius;
    let parts = points.split(|p| !seen(p));
    parts.flat_map(|part| screen.lines(part)).collect()
}

/// Whether a ring is seen so much from its edge that an angle cannot be told.
pub(super) fn is_edge_on(screen: &Screen, centre: DVec3, axis: DVec3) -> bool {
    let view = (centre - screen.eye()).normalize_or(DVec3::Z);
    view.dot(axis).abs() < EDGE_ON
}

/// The part under the cursor.
pub(super) fn pick(grips: &[(Grip, Outline)], at: Pos2) -> Option<Grip> {
    let mut nearest = None;
    for (grip, outline) in grips {
        let distance = outline.distance(at);
        if distance <= NEAR && nearest.is_none_or(|(least, _)| distance < least) {
            nearest = Some((distance, *grip));
        }
    }
    nearest.map(|(_, grip)| grip)
}

impl Outline {
    /// Distance from a place, points; 0 inside.
    fn distance(&self, at: Pos2) -> f32 {
        match self {
            Self::Arrow(ends) => to_segment(at, *ends),
            Self::Square(corners) => {
                if contains(corners, at) {
                    0.0
                } else {
                    f32::INFINITY
                }
            }
            Self::Disc(middle, radius) => (middle.distance(at) - radius).max(0.0),
            Self::Circle(middle, radius) => (middle.distance(at) - radius).abs(),
            Self::Ring(parts) => parts
                .iter()
                .flat_map(|part| part.windows(2))
                .map(|pair| to_segment(at, [pair[0], pair[1]]))
                .fold(f32::INFINITY, f32::min),
            // The line to it belongs to nobody: many meet in the centre.
            Self::Knob([_, knob]) => (knob.distance(at) - 3.0).max(0.0),
        }
    }
}

fn to_segment(at: Pos2, [from, to]: [Pos2; 2]) -> f32 {
    let along = to - from;
    let t = (at - from).dot(along) / along.length_sq().max(f32::MIN_POSITIVE);
    at.distance(from + along * t.clamp(0.0, 1.0))
}

fn contains(corners: &[Pos2; 4], at: Pos2) -> bool {
    let side = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        let (along, to): (Vec2, Vec2) = (b - a, at - a);
        along.x * to.y - along.y * to.x
    };
    let sides: [f32; 4] = std::array::from_fn(side);
    sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
}
