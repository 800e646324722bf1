//! How many points are searched. The surfels are shuffled at load, so that any first part of them is an even sample of the
//! cloud; it grows in doublings until the mirrors have enough. Each doubling's points are searched along a Morton curve, so
//! that those searched together lie together.

use std::ops::Range;

use super::root_find::SearchCounts;
use crate::cloud::{Place, along_curve};
use crate::error::Result;
use crate::timing::Timings;

/// Points of the first part.
pub const FIRST: usize = 1 << 11;

/// Hits a mirror pixel that are enough: more points sharpen nothing that the pixels could show.
///
/// On the reference scenes the reflected albedo is then within 0.5 dB of that of traced rays, or better; twice as many gain
/// 0.3 to 0.6 dB (`docs/METHOD.md`).
pub const ENOUGH: f64 = 4.0;

/// The points of a cloud in the order in which they are searched; parts are put in order when they are first needed.
#[derive(Debug, Default)]
pub struct Prefix {
    /// Indices of surfels, part by part.
    order: Vec<u32>,
    /// Where each part that is in order ends.
    ends: Vec<usize>,
    /// Points of the first part, along a curve: samples are of these, whatever the limit.
    first: Option<Vec<u32>>,
    /// Points that are searched at most: the last part is a sample of its own, no piece of a curve.
    limit: Option<usize>,
}

/// How many points are searched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Budget {
    /// Until so many mirror pixels have enough.
    Enough {
        /// Pixels of mirrors.
        mirror_pixels: u64,
    },
    /// So many.
    Points(usize),
}

impl Prefix {
    /// The part `k` of the points, if there is one.
    fn part(&mut self, k: usize, places: &[Place]) -> Range<usize> {
        while self.ends.len() <= k {
            let start = self.order.len();
            let end = (FIRST << self.ends.len().min(40)).min(places.len());
            let end = self.limit.map_or(end, |limit| end.min(limit.max(start)));
            let part = along_curve(places.get(start..end).unwrap_or_default());
            self.order
                .extend(part.into_iter().map(|i| i + start as u32));
            self.ends.push(self.order.len());
        }
        let start = k.checked_sub(1).map_or(0, |k| self.ends[k]);
        start..self.ends[k]
    }

    /// A sample of the first part, evenly spread.
    pub fn sample(&mut self, count: usize, places: &[Place]) -> Vec<u32> {
        let part = self.first.get_or_insert_with(|| {
            along_curve(places.get(..FIRST.min(places.len())).unwrap_or_default())
        });
        let step = (part.len() / count.max(1)).max(1);
        part.iter().step_by(step).copied().collect()
    }

    /// Searches part after part by `search(order)` until the budget says that it is enough (row `guided`; putting points in
    /// order is row `order`); returns the counts and the number of points searched.
    ///
    /// # Errors
    /// Those of `search`.
    pub fn grow(
        &mut self,
        places: &[Place],
        budget: Budget,
        timings: &mut Timings,
        mut search: impl FnMut(&[u32], &mut Timings) -> Result<SearchCounts>,
    ) -> Result<(SearchCounts, usize)> {
        let limit = match budget {
            Budget::Points(points) => Some(points),
            Budget::Enough { .. } => None,
        };
        if limit != self.limit {
            *self = Self {
                limit,
                first: self.first.take(),
                ..Self::default()
            };
        }
        let (mut counts, mut searched) = (SearchCounts::default(), 0);
        for k in 0.. {
            let part = timings.time("order", || self.part(k, places));
            let enough = match budget {
                Budget::Points(_) => false,
                Budget::Enough { mirror_pixels } => {
                    counts.hits as f64 >= ENOUGH * mirror_pixels as f64
                }
            };
            if enough || part.is_empty() {
                break;
            }
            searched += part.len();
            counts += search(&self.order[part], timings)?;
        }
        Ok((counts, searched))
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn places(count: usize) -> Vec<Place> {
        let place = |i: usize| Place {
            position: Vec3::new((i * 7919 % 1009) as f32, (i * 104_729 % 997) as f32, 0.0),
            radius: 1.0,
        };
        (0..count).map(place).collect()
    }

    fn searched(count: usize, budget: Budget, hits_a_point: f64) -> Vec<u32> {
        let places = places(count);
        let mut all = Vec::new();
        let counted =
            Prefix::default().grow(&places, budget, &mut Timings::default(), |order, _| {
                all.extend_from_slice(order);
                Ok(SearchCounts {
                    hits: (order.len() as f64 * hits_a_point) as u64,
                    ..SearchCounts::default()
                })
            });
        assert_eq!(counted.map(|c| c.1).ok(), Some(all.len()));
        all
    }

    #[test]
    fn a_prefix_is_the_first_points_each_once() {
        let count = 100_000;
        // One hit a point: enough after two parts.
        let budget = Budget::Enough {
            mirror_pixels: (1.5 * FIRST as f64 / ENOUGH) as u64,
        };
        let mut some = searched(count, budget, 1.0);
        some.sort_unstable();
        assert!(some.iter().copied().eq(0..2 * FIRST as u32), "two parts");
        let mut all = searched(count, budget, 0.0);
        all.sort_unstable();
        assert!(
            all.iter().copied().eq(0..count as u32),
            "all, where nothing is found"
        );
    }

    #[test]
    fn a_sample_does_not_depend_on_what_was_searched_before() {
        let places = places(10_000);
        let mut prefix = Prefix::default();
        let before = prefix.sample(100, &places);
        let (nothing, timings) = (Budget::Points(0), &mut Timings::default());
        let counted = prefix.grow(
            &places,
            nothing,
            timings,
            |_, _| Ok(SearchCounts::default()),
        );
        assert_eq!(counted.map(|c| c.1).ok(), Some(0));
        assert!(
            (100..=110).contains(&before.len()),
            "{} points",
            before.len()
        );
        assert_eq!(prefix.sample(100, &places), before);
    }

    #[test]
    fn a_number_of_points_is_an_even_sample() {
        // The cloud is its own order: the first points, not the first of a curve.
        let mut some = searched(100_000, Budget::Points(FIRST + 1000), 1.0);
        some.sort_unstable();
        assert!(some.iter().copied().eq(0..FIRST as u32 + 1000));
    }

    #[test]
    fn a_number_of_points_is_kept() {
        for points in [0, 1, FIRST, FIRST + 1, 100_000, 1_000_000] {
            let all = searched(100_000, Budget::Points(points), 1.0);
            assert_eq!(all.len(), points.min(100_000));
        }
    }
}
