//! Gauss-Newton steps on screen towards the place where a mirror shows a point.
//!
//! The error is the vector F = r - l between the reflected direction r and the direction l from the mirror's point to the
//! point of the cloud: three components, no poles, zero exactly where the point is seen. Its slope per pixel is
//! J = r' + (P' - l (l . P')) / D, with the mirror's point P and the distance D; a step solves the two normal equations
//! J^T J s = -J^T F. On the reference scenes a root takes three to five steps.

use glam::{Vec2, Vec3};
use wide::f32x8;

use super::beam::Points8;
use super::field::{MirrorField, Sample};

/// Steps at most.
pub const MAX_STEPS: u32 = 10;

/// Longest step, pixels: the field is smooth, but not for longer.
pub const LONGEST_STEP: f32 = 32.0;

/// How often a step that leaves the mirror is halved.
pub const HALVINGS: u32 = 4;

/// A step shorter than this is the last, pixels. It is measured before it is shortened: a short one that was damped proves
/// nothing.
pub const LAST_STEP: f32 = 0.25;

/// What the last step leaves of the error's square may be this part of its slopes' squares: a tenth of a pixel. Where the
/// mirror comes near to showing a point but does not, steps vanish and the error stays.
pub const RESIDUAL: f32 = 0.01;

/// The error's square that is accepted however flat the field: a milliradian.
pub const RESIDUAL_FLOOR: f32 = 1e-6;

/// A determinant smaller than this part of the product of both slopes is damped: there the mirror's picture folds.
pub const FOLD: f32 = 1e-6;

/// Part of the slopes that is added where they are damped.
pub const DAMPING: f32 = 1e-3;

/// Where the mirror shows a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewtonRoot {
    /// Place in the field.
    pub at: Vec2,
    /// Distance from the mirror's point, in the cloud's unit.
    pub distance: f32,
    /// Pixels to the right and down by which a point moves in the mirror, at most, when it moves sideways by one unit.
    pub magnification: Vec2,
    /// Whether the field ends beside it.
    pub at_end: bool,
    /// Length of the error that is left.
    pub residual: f32,
    /// Unit direction from the mirror's point to the point.
    pub direction: Vec3,
    /// Local spacing of the mirror's points.
    pub spacing: f32,
}

/// The linear equations at a place.
struct Step {
    step: Vec2,
    /// What the step leaves of the error's square.
    left_squared: f32,
    slopes_squared: f32,
    distance: f32,
    magnification: Vec2,
    direction: Vec3,
}

#[inline]
fn step(sample: &Sample, point: Vec3) -> Step {
    let to_point = point - sample.point;
    let distance = to_point.length();
    let inverse = 1.0 / distance;
    let l = to_point * inverse;
    let error = sample.ray - l;
    let slope = |k: usize| {
        let moved = sample.point_slope[k];
        sample.ray_slope[k] + (moved - l * l.dot(moved)) * inverse
    };
    let (right, down) = (slope(0), slope(1));
    let (mut a, b, mut c) = (right.dot(right), right.dot(down), down.dot(down));
    let (gx, gy) = (right.dot(error), down.dot(error));
    let slopes_squared = a + c;
    let mut determinant = a * c - b * b;
    if determinant < FOLD * a * c {
        a *= 1.0 + DAMPING;
        c *= 1.0 + DAMPING;
        determinant = a * c - b * b;
    }
    let over = 1.0 / determinant;
    let step = Vec2::new(gy * b - gx * c, gx * b - gy * a) * over;
    Step {
        step,
        left_squared: error.length_squared() + step.dot(Vec2::new(gx, gy)),
        slopes_squared,
        distance,
        // Rounding may turn the sign where the mirror's picture folds.
        magnification: Vec2::new((c * over).abs().sqrt(), (a * over).abs().sqrt()) * inverse,
        direction: l,
    }
}

/// The first steps from one place towards each of eight points, to the right and down; not a number where there is none.
#[inline(always)]
pub fn first_steps(sample: &Sample, points: &Points8) -> [f32x8; 2] {
    let splat = |v: Vec3| v.to_array().map(f32x8::splat);
    let dot = |a: [f32x8; 3], b: [f32x8; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let position = splat(sample.point);
    let to_point: [f32x8; 3] = std::array::from_fn(|k| points.xyz[k] - position[k]);
    let inverse = f32x8::ONE / dot(to_point, to_point).sqrt();
    let l = to_point.map(|v| v * inverse);
    let ray = splat(sample.ray);
    let error: [f32x8; 3] = std::array::from_fn(|k| ray[k] - l[k]);
    let slope = |k: usize| -> [f32x8; 3] {
        let (turned, moved) = (splat(sample.ray_slope[k]), splat(sample.point_slope[k]));
        let along = dot(l, moved);
        std::array::from_fn(|k| turned[k] + (moved[k] - l[k] * along) * inverse)
    };
    let (right, down) = (slope(0), slope(1));
    let (a, b, c) = (dot(right, right), dot(right, down), dot(down, down));
    let (gx, gy) = (dot(right, error), dot(down, error));
    let over = f32x8::ONE / (a * c - b * b);
    [(gy * b - gx * c) * over, (gx * b - gy * a) * over]
}

/// The part of the field in which a search stays: a square.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Within {
    /// Its middle.
    pub centre: Vec2,
    /// Half its side, pixels.
    pub reach: f32,
}

impl Within {
    /// All of the field.
    pub const ANYWHERE: Self = Self {
        centre: Vec2::ZERO,
        reach: f32::INFINITY,
    };

    #[inline]
    fn holds(&self, at: Vec2) -> bool {
        (at - self.centre).abs().max_element() <= self.reach
    }
}

/// The place that a step leads to, and the field there; a step that leaves the mirror is halved.
#[inline]
pub fn take_step(field: &MirrorField, at: Vec2, mut step: Vec2) -> Option<(Vec2, Sample)> {
    for _ in 0..=HALVINGS {
        if let Some(sample) = field.sample(at + step) {
            return Some((at + step, sample));
        }
        step *= 0.5;
    }
    None
}

/// Searches from a place, where the field is `sample`, for the one where it shows `point`.
///
/// Returns the root, if there is one, and the number of steps.
#[inline]
pub fn newton(
    field: &MirrorField,
    (mut at, mut sample): (Vec2, Sample),
    point: Vec3,
    within: Within,
) -> (Option<NewtonRoot>, u32) {
    for steps in 1..=MAX_STEPS {
        let s = step(&sample, point);
        let length = s.step.length();
        // A step that is not a number ends the search, too.
        if !(length < f32::INFINITY) {
            return (None, steps);
        }
        let last = length < LAST_STEP;
        if last && s.left_squared >= RESIDUAL_FLOOR + RESIDUAL * s.slopes_squared {
            return (None, steps);
        }
        let taken = s.step * (LONGEST_STEP / length).min(1.0);
        if !within.holds(at + taken) {
            return (None, steps);
        }
        let Some((next, there)) = take_step(field, at, taken) else {
            return (None, steps);
        };
        at = next;
        if last {
            if !field.is_inside(at) {
                return (None, steps);
            }
            let root = NewtonRoot {
                at,
                distance: s.distance,
                magnification: s.magnification,
                at_end: field.is_at_end(at),
                residual: s.left_squared.max(0.0).sqrt(),
                direction: s.direction,
                spacing: sample.spacing,
            };
            return (Some(root), steps);
        }
        sample = there;
    }
    (None, MAX_STEPS)
}
