//! What the methods cost, by a model: constants that were measured, no clock, so that the choice is the same every time.

use super::sscr::prefix::{Budget, ENOUGH, FIRST};
use super::sscr::root_find::SearchCounts;

/// Nanoseconds of two cores for what a method does: measured on an AMD EPYC, 2026-11, on the reference scenes
/// (`docs/METHOD.md`). Only their ratios matter.
mod price {
    /// A mirror pixel made ready for the guided search, and closed.
    pub(super) const PIXEL: f64 = 1350.0;
    /// A point put in order, fetched and compared with its first chart.
    pub(super) const POINT: f64 = 80.0;
    /// A chart's beam compared with a point, eight at a time.
    pub(super) const CULL: f64 = 2.0;
    /// A step of the guided search, with its share of the walk to where it starts.
    pub(super) const STEP: f64 = 30.0;
    /// A hit splatted onto the mirrors.
    pub(super) const HIT: f64 = 220.0;
    /// A point built into the tree of rays.
    pub(super) const TREE: f64 = 69.0;
    /// A ray traced.
    pub(super) const RAY: f64 = 1300.0;
}

/// What a picture's mirrors are, as far as cost goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Work {
    /// Points of the cloud.
    pub points: usize,
    /// How many points the search takes.
    pub budget: Budget,
    /// Pixels of mirrors.
    pub mirror_pixels: u64,
    /// Charts of the mirrors.
    pub charts: usize,
    /// What the search of a sample came to.
    pub sample: SearchCounts,
    /// Whether the search needs the tree of rays, too, to close holes.
    pub needs_tree: bool,
}

/// Time of two cores by the model, milliseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Of the guided search.
    pub guided_ms: f64,
    /// Of traced rays, with their tree.
    pub ray_trace_ms: f64,
}

/// A way to find what mirrors show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Chosen {
    /// The guided search.
    Guided,
    /// The interleaved search.
    Interleaved,
    /// Traced rays.
    RayTrace,
}

impl Chosen {
    /// Its name in the report.
    pub fn name(self) -> &'static str {
        match self {
            Self::Guided => "guided",
            Self::Interleaved => "interleaved",
            Self::RayTrace => "ray_trace",
        }
    }
}

/// A method, and why it was chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// The method.
    pub method: Chosen,
    /// Why, for people.
    pub reason: String,
}

impl Work {
    /// The cheaper of the guided search and traced rays.
    pub fn choose(&self) -> Choice {
        let Estimate {
            guided_ms,
            ray_trace_ms,
        } = self.estimate();
        let method = if guided_ms <= ray_trace_ms {
            Chosen::Guided
        } else {
            Chosen::RayTrace
        };
        let reason = format!(
            "estimated at {guided_ms:.0} ms of two cores for the guided search, {ray_trace_ms:.0} ms for traced rays with \
             their tree"
        );
        Choice { method, reason }
    }

    /// Points that the guided search will take: the first part of the cloud that gives enough hits.
    fn points_needed(&self, hits_a_point: f64) -> usize {
        if let Budget::Points(points) = self.budget {
            return points.min(self.points);
        }
        let wanted = ENOUGH * self.mirror_pixels as f64;
        let mut points = FIRST;
        while points < self.points && (points as f64 * hits_a_point) < wanted {
            points *= 2;
        }
        points.min(self.points)
    }

    /// What both methods take.
    pub fn estimate(&self) -> Estimate {
        let sampled = self.sample.offered.max(1) as f64;
        let (steps, hits) = (
            self.sample.steps as f64 / sampled,
            self.sample.hits as f64 / sampled,
        );
        let point = price::POINT
            + price::CULL * self.charts as f64
            + price::STEP * steps
            + price::HIT * hits;
        let tree = price::TREE * self.points as f64;
        let pixels = self.mirror_pixels as f64;
        let guided = point * self.points_needed(hits) as f64 + price::PIXEL * pixels;
        let rays = tree + price::RAY * pixels;
        Estimate {
            guided_ms: (guided + if self.needs_tree { tree } else { 0.0 }) * 1e-6,
            ray_trace_ms: rays * 1e-6,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn work(charts: usize, steps: u64, mirror_pixels: u64) -> Work {
        Work {
            points: 1_600_000,
            budget: Budget::Enough { mirror_pixels },
            mirror_pixels,
            charts,
            sample: SearchCounts {
                offered: 1000,
                hit: 700,
                hits: 800,
                steps: 1000 * steps,
            },
            needs_tree: false,
        }
    }

    #[test]
    fn a_ball_is_searched_and_a_crumpled_sheet_traced() {
        let ball = work(1, 3, 43_000).estimate();
        assert!(ball.guided_ms < ball.ray_trace_ms, "{ball:?}");
        let sheet = work(1000, 300, 43_000).estimate();
        assert!(sheet.guided_ms > sheet.ray_trace_ms, "{sheet:?}");
    }

    #[test]
    fn a_number_of_points_that_is_asked_for_is_priced() {
        let few = work(1, 3, 43_000);
        let all = Work {
            budget: Budget::Points(1_600_000),
            ..few
        };
        let [few, all] = [few, all].map(|w| w.estimate().guided_ms);
        assert!(all > 3.0 * few, "{all} ms for all, {few} ms for enough");
    }

    #[test]
    fn a_tree_that_is_needed_anyway_counts_for_both() {
        let without = work(1, 3, 43_000);
        let with = Work {
            needs_tree: true,
            ..without
        };
        let [a, b] = [without, with].map(|w| w.estimate());
        assert!(b.guided_ms > a.guided_ms, "{a:?} {b:?}");
        assert_eq!(a.ray_trace_ms, b.ray_trace_ms);
    }
}
