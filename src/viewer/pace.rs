//! How much of a picture is made while the camera moves, so that it keeps up.

use std::sync::Arc;

use catoptric::cloud::{Place, Surfels};
use catoptric::settings::Settings;
use glam::UVec2;

/// Fewer points than this are not worth leaving out, and more levels than this are not there.
const FEWEST: usize = 1 << 14;
const COARSEST: u32 = 12;

/// Shadow maps are not made smaller than this, pixels.
const SMALLEST_MAP: u32 = 128;

/// A level of detail: every second one has half the points, every other half the width and height as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct Detail(u32);

impl Detail {
    /// Everything.
    pub(super) const FULL: Self = Self(0);

    /// Points of a cloud that are drawn.
    pub(super) fn points(self, all: usize) -> usize {
        (all >> self.0).max(FEWEST).min(all)
    }

    /// How often width and height are halved.
    fn halvings(self) -> u32 {
        (self.0 / 2).min(2)
    }

    /// These settings for a frame that is soon done: no indirect light, and shadows as coarse as the picture.
    pub(super) fn settings(self, settings: &Settings) -> Settings {
        let mut quick = settings.clone();
        quick.gi.vpl_count = 0;
        let map = (quick.gi.light_map_size >> self.halvings()).max(SMALLEST_MAP);
        quick.gi.light_map_size = map.min(settings.gi.light_map_size);
        quick
    }

    /// Size of the picture that is drawn for one of `size`.
    pub(super) fn size(self, size: UVec2) -> UVec2 {
        (size >> self.halvings()).max(UVec2::splat(32)).min(size)
    }

    /// The first points of a cloud, which is shuffled, enlarged so that they stay as closed.
    pub(super) fn of(self, surfels: &Arc<Surfels>) -> Arc<Surfels> {
        let (all, count) = (surfels.len(), self.points(surfels.len()));
        if count == all {
            return Arc::clone(surfels);
        }
        let larger = (all as f32 / count as f32).sqrt();
        let places = surfels.places.iter().take(count);
        Arc::new(Surfels {
            places: places
                .map(|place| Place {
                    radius: place.radius * larger,
                    ..*place
                })
                .collect(),
            finishes: surfels.finishes.iter().take(count).copied().collect(),
            source: surfels.source.iter().take(count).copied().collect(),
            origin: surfels.origin,
        })
    }
}

/// Chooses the detail by what frames took. Only the viewer looks at a clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pace {
    /// What a frame may take, milliseconds.
    pub(super) budget_ms: f64,
    detail: Detail,
}

impl Pace {
    pub(super) fn new(budget_ms: f64) -> Self {
        Self {
            budget_ms,
            detail: Detail(6),
        }
    }

    pub(super) fn detail(&self) -> Detail {
        self.detail
    }

    /// Learns what a frame of this detail took.
    pub(super) fn took(&mut self, detail: Detail, ms: f64) {
        if detail != self.detail {
            return;
        }
        // A level is worth about a factor of two; between the bounds it stays, so that it does not swing.
        if ms > self.budget_ms * 1.2 {
            let levels = (ms / self.budget_ms).log2().ceil().clamp(1.0, 4.0) as u32;
            self.detail = Detail((detail.0 + levels).min(COARSEST));
        } else if ms < self.budget_ms * 0.4 {
            self.detail = Detail(detail.0.saturating_sub(1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The time of a frame on a machine that draws so many points a millisecond.
    fn settle(points: usize, speed: f64, budget_ms: f64) -> (Pace, f64) {
        let mut pace = Pace::new(budget_ms);
        let mut ms = 0.0;
        for _ in 0..40 {
            let detail = pace.detail();
            ms = detail.points(points) as f64 / speed;
            pace.took(detail, ms);
        }
        (pace, ms)
    }

    #[test]
    fn frames_take_what_they_may_on_fast_and_slow_machines() {
        for speed in [2e3, 1e4, 1e5] {
            let (pace, ms) = settle(10_000_000, speed, 50.0);
            assert!(ms <= 60.0, "{speed} points a ms: {ms} ms at {pace:?}");
            assert!(
                ms >= 20.0,
                "{speed} points a ms: {ms} ms at {pace:?} are too few points"
            );
        }
    }

    #[test]
    fn a_fast_machine_leaves_nothing_out() {
        assert_eq!(settle(1_000_000, 1e7, 50.0).0.detail(), Detail::FULL);
    }

    #[test]
    fn frames_of_another_detail_teach_nothing() {
        let mut pace = Pace::new(50.0);
        let before = pace;
        pace.took(Detail::FULL, 5000.0);
        assert_eq!(pace, before);
    }
}
