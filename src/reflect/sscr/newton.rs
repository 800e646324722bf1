//! Gauss-Newton steps on screen towards the place where a mirror shows a point.
//!
//! The error is the vector F = r - l between the reflected direction r and the direction l from the mirror's point to the
//! point of the cloud: three components, no poles, zero exactly where the point is seen. Its slope per pixel is
//! J = r' + (P' - l (l . P')) / D, with the mirror's point P and the distance D; a step solves the two normal equations
//! J^T J s = -J^T F. On the reference scenes a root takes three to five steps, which are made for eight searches together.

use glam::{Vec2, Vec3};
use wide::f32x8;

use super::field::{MirrorField, Sample, lanes};
use super::real::{Real, dot};

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
    /// Local spacing of the mirror's points.
    pub spacing: f32,
}

/// What the linear equations at a place say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step<T> {
    /// Pixels to the right and down; not a number where there is none.
    pub step: [T; 2],
    /// What the step leaves of the error's square.
    pub left_squared: T,
    /// Squares of the error's slopes, a pixel.
    pub slopes_squared: T,
    /// From the mirror's point to the point.
    pub distance: T,
    /// See [`NewtonRoot::magnification`].
    pub magnification: [T; 2],
}

/// The step from a place towards the one that shows `point`; `DAMPED` where the mirror's picture folds.
#[inline(always)]
pub fn step<T: Real, const DAMPED: bool>(sample: &Sample<T>, point: [T; 3]) -> Step<T> {
    let to_point: [T; 3] = std::array::from_fn(|k| point[k] - sample.point[k]);
    let distance = dot(to_point, to_point).sqrt();
    let inverse = T::of(1.0) / distance;
    let l = to_point.map(|v| v * inverse);
    let error: [T; 3] = std::array::from_fn(|k| sample.ray[k] - l[k]);
    let slope = |k: usize| -> [T; 3] {
        let (turned, moved) = (sample.ray_slope[k], sample.point_slope[k]);
        let along = dot(l, moved);
        std::array::from_fn(|k| turned[k] + (moved[k] - l[k] * along) * inverse)
    };
    let (right, down) = (slope(0), slope(1));
    let (mut a, b, mut c) = (dot(right, right), dot(right, down), dot(down, down));
    let (gx, gy) = (dot(right, error), dot(down, error));
    let slopes_squared = a + c;
    let mut determinant = a * c - b * b;
    if DAMPED {
        let least = T::of(FOLD) * a * c;
        let stretch = determinant.where_below(least, T::of(1.0 + DAMPING), T::of(1.0));
        a = a * stretch;
        c = c * stretch;
        determinant = a * c - b * b;
    }
    let over = T::of(1.0) / determinant;
    let step = [(gy * b - gx * c) * over, (gx * b - gy * a) * over];
    Step {
        step,
        left_squared: dot(error, error) + step[0] * gx + step[1] * gy,
        slopes_squared,
        distance,
        // Rounding may turn the sign where the mirror's picture folds.
        magnification: [c, a].map(|v| (v * over).abs().sqrt() * inverse),
    }
}

/// The place that a step leads to; a step that leaves the field is halved.
#[inline]
pub fn take_step(field: &MirrorField, at: Vec2, mut step: Vec2) -> Option<Vec2> {
    for _ in 0..=HALVINGS {
        if field.contains(at + step) {
            return Some(at + step);
        }
        step *= 0.5;
    }
    None
}

/// Up to eight searches.
#[derive(Debug, Default, Clone, Copy)]
pub struct Searches {
    count: usize,
    tags: [u32; 8],
    points: [f32x8; 3],
    at: [Vec2; 8],
    centre: [Vec2; 8],
    reach: [f32; 8],
}

impl Searches {
    /// Whether there is no place for another.
    pub fn is_full(&self) -> bool {
        self.count == 8
    }

    /// Adds a search for `point` that starts at a place of the field and goes no farther than `reach` from `centre` along
    /// either axis; not beyond the eighth.
    #[inline]
    pub fn push(&mut self, tag: u32, point: Vec3, at: Vec2, (centre, reach): (Vec2, f32)) {
        let lane = self.count;
        if lane < 8 {
            self.tags[lane] = tag;
            for (lanes, value) in self.points.iter_mut().zip(point.to_array()) {
                lanes.as_mut_array()[lane] = value;
            }
            self.at[lane] = at;
            self.centre[lane] = centre;
            self.reach[lane] = reach;
            self.count += 1;
        }
    }

    /// Searches: calls `found(tag, root)` for each that ends at one, in their order, and returns the steps that they took
    /// together. Then there are none.
    #[inline]
    pub fn run(&mut self, field: &MirrorField, mut found: impl FnMut(u32, NewtonRoot)) -> u64 {
        let mut roots = [None; 8];
        let mut active = (1u32 << self.count) - 1;
        let mut taken = 0;
        for _ in 0..MAX_STEPS {
            if active == 0 {
                break;
            }
            taken += u64::from(active.count_ones());
            let sample = field.sample_eight(&self.at, active);
            let s = step::<f32x8, true>(&sample, self.points);
            let length = (s.step[0] * s.step[0] + s.step[1] * s.step[1]).sqrt();
            // A step that is not a number ends the search, too.
            let finite = length.simd_lt(f32x8::splat(f32::INFINITY)).to_bitmask();
            let last = length.simd_lt(f32x8::splat(LAST_STEP)).to_bitmask();
            let most = f32x8::splat(RESIDUAL_FLOOR) + f32x8::splat(RESIDUAL) * s.slopes_squared;
            let near = s.left_squared.simd_lt(most).to_bitmask();
            let longest = f32x8::splat(LONGEST_STEP) / length;
            let part = longest.where_below(f32x8::ONE, longest, f32x8::ONE);
            let [x, y] = s.step.map(|v| (v * part).to_array());
            active &= finite & (near | !last);
            for lane in lanes(active) {
                let (at, step) = (self.at[lane], Vec2::new(x[lane], y[lane]));
                let off = (at + step - self.centre[lane]).abs().max_element();
                let next = (off <= self.reach[lane])
                    .then(|| take_step(field, at, step))
                    .flatten();
                let is_last = last >> lane & 1 == 1;
                match next {
                    Some(next) if !is_last => {
                        self.at[lane] = next;
                        continue;
                    }
                    Some(at) if field.is_inside(at) => {
                        let pick = |v: f32x8| v.as_array()[lane];
                        roots[lane] = Some(NewtonRoot {
                            at,
                            distance: pick(s.distance),
                            magnification: Vec2::from(s.magnification.map(pick)),
                            at_end: field.is_at_end(at),
                            spacing: pick(sample.spacing),
                        });
                    }
                    Some(_) | None => {}
                }
                active &= !(1 << lane);
            }
        }
        for (tag, root) in self.tags.iter().zip(roots) {
            if let Some(root) = root {
                found(*tag, root);
            }
        }
        self.count = 0;
        taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reflect::sscr::random::Random;

    fn samples() -> Vec<(Sample, [f32; 3])> {
        let mut random = Random::new(7);
        let mut number = || 2.0 * random.next() - 1.0;
        let mut vector = |scale: f32| [(); 3].map(|()| number() * scale);
        (0..256)
            .map(|_| {
                let sample = Sample {
                    point: vector(1.0),
                    ray: vector(1.0),
                    point_slope: [vector(1e-2), vector(1e-2)],
                    ray_slope: [vector(1e-2), vector(1e-2)],
                    spacing: 0.01,
                };
                (sample, vector(3.0))
            })
            .collect()
    }

    #[test]
    fn eight_steps_together_are_those_of_each_to_the_last_bit() {
        for eight in samples().chunks(8) {
            // Every other one is a fold: both slopes the same.
            let eight: Vec<(Sample, [f32; 3])> = (eight.iter().enumerate())
                .map(|(k, &(mut sample, point))| {
                    if k % 2 == 0 {
                        sample.ray_slope[1] = sample.ray_slope[0];
                        sample.point_slope[1] = sample.point_slope[0];
                    }
                    (sample, point)
                })
                .collect();
            let of = |pick: &dyn Fn(usize) -> f32| f32x8::from(std::array::from_fn(pick));
            let vector = |pick: &dyn Fn(usize) -> [f32; 3]| -> [f32x8; 3] {
                std::array::from_fn(|k| of(&|lane| pick(lane)[k]))
            };
            let together = Sample {
                point: vector(&|lane| eight[lane].0.point),
                ray: vector(&|lane| eight[lane].0.ray),
                point_slope: [0, 1].map(|k| vector(&|lane| eight[lane].0.point_slope[k])),
                ray_slope: [0, 1].map(|k| vector(&|lane| eight[lane].0.ray_slope[k])),
                spacing: f32x8::splat(0.01),
            };
            let points = vector(&|lane| eight[lane].1);
            let steps = step::<f32x8, true>(&together, points);
            for (lane, (sample, point)) in eight.iter().enumerate() {
                let alone = step::<f32, true>(sample, *point);
                let bits = |v: [f32; 2]| v.map(f32::to_bits);
                let pick = |v: [f32x8; 2]| bits(v.map(|v| v.to_array()[lane]));
                assert_eq!(pick(steps.step), bits(alone.step), "lane {lane}");
                assert_eq!(pick(steps.magnification), bits(alone.magnification));
                assert_eq!(
                    pick([steps.left_squared, steps.distance]),
                    bits([alone.left_squared, alone.distance])
                );
                let undamped = step::<f32, false>(sample, *point);
                assert_eq!(
                    undamped.step == alone.step,
                    lane % 2 == 1,
                    "only folds are damped"
                );
            }
        }
    }
}
