//! Pass `root_find`: for a point of the cloud, the pixel of a mirror region that shows it. Algorithm 3.1 of
//! [Preiner 2010, section 3.4], interleaved bracketing and bisection, with the termination rule of its text and an error
//! function that is zero where the point is seen.
//!
//! Arithmetic is plain f32 in a fixed order, and random numbers are integers, so that a GPU can do the same; f64 in its
//! place ([`RootFinder::with`]) tells what that costs.

use glam::{UVec2, Vec2};
use rayon::prelude::*;

use super::distribute::distribute;
use super::mirror_error::{MirrorPoint, mirror_error};
use super::mirror_pixels::MirrorPixels;
use super::random::Random;
use super::scalar::{Scalar, Vector};
use super::{Region, SscrSettings};
use crate::backend::cpu::Cpu;
use crate::cloud::{Place, Surfels};
use crate::error::Result;
use crate::job::Job;
use crate::reflect::{Hit, LabelledMirrors};

pub use super::outcome::{End, Outcome, Root, SearchCounts};

/// Smallest step that is still taken, pixels. The mirror is known at pixel centres, so that shorter steps seldom lead
/// anywhere; already at 1 the sphere loses four hits in ten, since the last bracket of two often forms below it.
pub const SMALLEST_STEP: f32 = 0.5;

/// Points a task.
const CHUNK: usize = 1 << 12;

/// What the search for one point may do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RootFindParams {
    /// How many more random pixels of the region's box are tried for each of the two seeds, where the first lies outside
    /// the region.
    pub seed_attempts: u32,
    /// How often a step that leaves the region is halved before the point is given up. The steps after it start from the
    /// halved one: short detours along an outline would find four false hits in a hundred more on the torus.
    pub step_attempts: u32,
    /// Steps at most.
    pub max_steps: u32,
    /// First step, along x and y, as a fraction of the region's box; above 0, at most 0.5.
    pub initial_step: f32,
    /// The point is seen between two places of opposite errors nearer to each other than this; pixels.
    pub threshold: f32,
    /// Points nearer to the mirror than this are its own; x spacing.
    pub self_hit: f32,
}

impl From<&SscrSettings> for RootFindParams {
    fn from(settings: &SscrSettings) -> Self {
        Self {
            seed_attempts: settings.seed_attempts,
            step_attempts: settings.step_attempts,
            max_steps: settings.max_steps,
            initial_step: settings.initial_step,
            threshold: settings.threshold,
            self_hit: settings.self_hit,
        }
    }
}

/// The mirrors in which points are searched.
#[derive(Debug)]
pub struct RootFinder<'a, R: Scalar = f32> {
    regions: &'a [Region],
    mirrors: MirrorPixels<R>,
    params: RootFindParams,
}

/// A place in the region, and the error there.
#[derive(Clone, Copy)]
struct Probe<R: Scalar> {
    at: R::Vec2,
    error: R::Vec2,
}

impl<R: Scalar> Probe<R> {
    /// The end of a search that got no further.
    fn lost(&self, steps: u32) -> Outcome<R> {
        Outcome::Lost(End {
            steps,
            pixel: Some(self.at),
        })
    }
}

/// The search along one axis.
#[derive(Clone, Copy)]
struct Axis<R> {
    direction: R,
    step: R,
}

impl<R: Scalar> Axis<R> {
    /// Turns round, and halves the step, as the errors before and after a step say.
    #[inline]
    fn turn(&mut self, before: R, after: R) {
        // Without branches: which way it goes is as good as random.
        let passed = opposite(before, after);
        let farther = after.abs() >= before.abs();
        let one = |when: bool| f32::from(u8::from(when));
        self.direction = self.direction * R::of(1.0 - 2.0 * one(passed | farther));
        self.step = self.step * R::of(1.0 - 0.5 * one(passed));
    }
}

/// The step that both axes make together.
#[inline]
fn step_of<R: Scalar>(x: Axis<R>, y: Axis<R>) -> R::Vec2 {
    R::vec2(x.direction * x.step, y.direction * y.step)
}

#[inline]
fn opposite<R: Scalar>(a: R, b: R) -> bool {
    let zero = R::default();
    (a < zero) != (b < zero)
}

/// Where between two places the error vanishes, if it runs straight.
#[inline]
fn between<R: Scalar>(first: R, last: R, first_error: R, last_error: R) -> R {
    let (a, b) = (first_error.abs(), last_error.abs());
    let sum = a + b;
    let part = if sum > R::default() {
        a / sum
    } else {
        R::of(0.5)
    };
    first + (last - first) * part
}

impl<'a, R: Scalar> RootFinder<'a, R> {
    /// Readies the mirrors of a picture for searching with these numbers; the first component of errors follows the
    /// picture's x axis.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] where the picture is too large.
    pub fn with(mirrors: &LabelledMirrors<'a, Cpu>, params: RootFindParams) -> Result<Self> {
        Ok(Self {
            regions: mirrors.regions,
            mirrors: MirrorPixels::new(mirrors)?,
            params,
        })
    }

    /// Searches region `region` (counted from 1) for the pixel that shows the point.
    ///
    /// `index` is the point's own number, which its random sequence follows from. Whichever way the point's surface
    /// faces: diffuse points are two-sided, and a mirror seen from behind is opaque.
    pub fn find(&self, index: u32, point: R::Vec3, region: u32) -> Outcome<R> {
        self.find_by(mirror_error, index, point, region)
    }

    /// Like [`RootFinder::find`], with another error function.
    pub fn find_by(
        &self,
        error: impl Fn(&MirrorPoint<R>, R::Vec3) -> R::Vec2,
        index: u32,
        point: R::Vec3,
        region: u32,
    ) -> Outcome<R> {
        let Some(bounds) = region
            .checked_sub(1)
            .and_then(|k| self.regions.get(k as usize))
        else {
            return Outcome::Lost(End::default());
        };
        let probe = |at: R::Vec2| {
            let mirror = self.mirrors.at(at, region)?;
            Some(Probe {
                at,
                error: error(mirror, point),
            })
        };

        // Seeds.
        let mut random = Random::new(index);
        let mut seed = || {
            (0..=self.params.seed_attempts).find_map(|_| {
                let at = random_pixel(bounds, &mut random);
                probe(R::vec2(R::of(at.x), R::of(at.y)))
            })
        };
        let (Some(mut first), Some(mut second)) = (seed(), seed()) else {
            return Outcome::Lost(End::default());
        };
        let extent = region_size(bounds).as_vec2() * self.params.initial_step;
        let along = |from: R, to: R, step: f32| Axis {
            direction: R::of(if to < from { -1.0 } else { 1.0 }),
            step: R::of(step),
        };
        let ([first_x, first_y], [second_x, second_y]) =
            (R::parts2(first.at), R::parts2(second.at));
        let mut x = along(first_x, second_x, extent.x);
        let mut y = along(first_y, second_y, extent.y);
        let threshold = R::of(self.params.threshold) * R::of(self.params.threshold);

        for steps in 0..=self.params.max_steps {
            let ([before_x, before_y], [after_x, after_y]) =
                (R::parts2(first.error), R::parts2(second.error));
            // The root lies between two near places of opposite errors.
            let apart: R::Vec2 = first.at - second.at;
            if opposite(before_x, after_x) & opposite(before_y, after_y)
                && apart.dot(apart) < threshold
            {
                return self.accept(&error, &first, &second, point, region, steps);
            }
            x.turn(before_x, after_x);
            y.turn(before_y, after_y);
            if steps == self.params.max_steps || x.step.max(y.step) < R::of(SMALLEST_STEP) {
                return second.lost(steps);
            }
            // A step that leaves the region is halved.
            let mut next = probe(second.at + step_of(x, y));
            for _ in 0..self.params.step_attempts {
                if next.is_some() {
                    break;
                }
                x.step = x.step * R::of(0.5);
                y.step = y.step * R::of(0.5);
                next = probe(second.at + step_of(x, y));
            }
            let Some(next) = next else {
                return second.lost(steps);
            };
            first = second;
            second = next;
        }
        second.lost(self.params.max_steps)
    }

    /// The root between two places, unless the point lies behind the mirror there, or belongs to it.
    fn accept(
        &self,
        error: impl Fn(&MirrorPoint<R>, R::Vec3) -> R::Vec2,
        first: &Probe<R>,
        second: &Probe<R>,
        point: R::Vec3,
        region: u32,
        steps: u32,
    ) -> Outcome<R> {
        // The errors are those of the pixels' centres.
        let centre = |at: R::Vec2| R::parts2(at).map(|c| c.floor() + R::of(0.5));
        let ([first_x, first_y], [last_x, last_y]) = (centre(first.at), centre(second.at));
        let ([before_x, before_y], [after_x, after_y]) =
            (R::parts2(first.error), R::parts2(second.error));
        let pixel = R::vec2(
            between(first_x, last_x, before_x, after_x),
            between(first_y, last_y, before_y, after_y),
        );
        // Between two pixels of the region there may be one of another.
        let mirror = self
            .mirrors
            .at(pixel, region)
            .or_else(|| self.mirrors.at(R::vec2(last_x, last_y), region));
        let Some(mirror) = mirror else {
            return second.lost(steps);
        };
        let to_point = point - mirror.position;
        let distance = to_point.length();
        let own = R::of(self.params.self_hit) * mirror.spacing;
        if mirror.normal.dot(to_point) <= R::default() || distance < own {
            return second.lost(steps);
        }
        Outcome::Found(Root {
            pixel,
            distance,
            steps,
            residual: error(mirror, point).length(),
        })
    }
}

impl<'a> RootFinder<'a> {
    /// Readies the mirrors of a picture for searching, with f32.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] where the picture is too large.
    pub fn new(mirrors: &LabelledMirrors<'a, Cpu>, params: RootFindParams) -> Result<Self> {
        Self::with(mirrors, params)
    }

    /// Searches for all points, each in the region that `region_of` gives it (none for some), on all cores; `reach_at`
    /// tells half the side of a splat, pixels, at a distance from the mirror.
    ///
    /// The hits are in the order of the points, the same for any number of threads.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub fn search(
        &self,
        places: &[Place],
        region_of: impl Fn(u32) -> Option<u32> + Sync,
        reach_at: impl Fn(f32) -> f32 + Sync,
        job: &Job,
    ) -> Result<(Vec<Hit>, SearchCounts)> {
        let chunks: Vec<(Vec<Hit>, SearchCounts)> = places
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk, places)| {
                job.check()?;
                let first = (chunk * CHUNK) as u32;
                let mut counts = SearchCounts::default();
                let mut hits = Vec::new();
                for (index, place) in (first..).zip(places) {
                    let Some(region) = region_of(index) else {
                        continue;
                    };
                    counts.offered += 1;
                    match self.find(index, place.position, region) {
                        Outcome::Found(root) => {
                            counts.hit += 1;
                            counts.hits += 1;
                            counts.steps += u64::from(root.steps);
                            hits.push(Hit {
                                point: index,
                                pixel: root.pixel,
                                distance: root.distance,
                                reach: Vec2::splat(reach_at(root.distance)),
                            });
                        }
                        Outcome::Lost(end) => counts.steps += u64::from(end.steps),
                    }
                }
                Ok((hits, counts))
            })
            .collect::<Result<_>>()?;
        let mut all = Vec::with_capacity(chunks.iter().map(|(hits, _)| hits.len()).sum());
        let mut counts = SearchCounts::default();
        for (hits, part) in chunks {
            all.extend(hits);
            counts += part;
        }
        Ok((all, counts))
    }
}

/// Searches every point in the region that it is given, once a pass of `sscr.passes`. `diagonal` is that of the scene's box.
///
/// # Errors
/// [`crate::Error::Memory`] where the picture is too large, [`crate::Error::Cancelled`].
pub fn root_find(
    surfels: &Surfels,
    mirrors: &LabelledMirrors<'_, Cpu>,
    settings: &SscrSettings,
    diagonal: f32,
    job: &Job,
) -> Result<(Vec<Hit>, SearchCounts)> {
    let finder = RootFinder::new(mirrors, RootFindParams::from(settings))?;
    let (mut hits, mut counts) = (Vec::new(), SearchCounts::default());
    for pass in 0..settings.passes {
        let (found, counted) = finder.search(
            &surfels.places,
            |point| distribute(mirrors.regions, settings.distribution, point, pass),
            |distance| settings.splat_reach(distance, diagonal),
            job,
        )?;
        hits.extend(found);
        counts += counted;
    }
    Ok((hits, counts))
}

/// Width and height of a region's box, pixels.
fn region_size(region: &Region) -> UVec2 {
    let b = region.bounds;
    UVec2::new(b.x1.saturating_sub(b.x0), b.y1.saturating_sub(b.y0))
}

/// The centre of a random pixel of a region's box.
fn random_pixel(region: &Region, random: &mut Random) -> Vec2 {
    let size = region_size(region).as_vec2();
    let first = Vec2::new(region.bounds.x0 as f32, region.bounds.y0 as f32);
    let (u, v) = (random.next(), random.next());
    first + Vec2::new((u * size.x).floor() + 0.5, (v * size.y).floor() + 0.5)
}

#[cfg(test)]
mod tests;
