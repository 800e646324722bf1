//! The regions in descending order of their pixels, and their weights [Preiner 2010, section 4.4.2].

use std::cmp::Reverse;

use super::Tally;
use crate::reflect::sscr::{LhcMap, Region};

/// Working memory.
#[derive(Debug, Default)]
pub(super) struct Order {
    /// Index of each region's tally, largest region first.
    by_size: Vec<u32>,
    /// New label by old label.
    labels: Vec<u32>,
}

/// Numbers the regions by size, equal ones by their first pixel that was not suppressed, in the map's list and in its labels.
pub(super) fn put_in_order(tallies: &[Tally], order: &mut Order, map: &mut LhcMap) {
    let Order { by_size, labels } = order;
    by_size.clear();
    by_size.extend(0..tallies.len() as u32);
    by_size.sort_unstable_by_key(|&old| (Reverse(tallies[old as usize].pixels), old));

    let total: f64 = tallies.iter().map(|t| f64::from(t.pixels)).sum();
    let mut accumulated = 0.0;
    map.regions.clear();
    map.regions.extend(by_size.iter().map(|&old| {
        let tally = tallies[old as usize];
        accumulated += f64::from(tally.pixels);
        Region {
            bounds: tally.bounds,
            pixels: tally.pixels,
            weight: (f64::from(tally.pixels) / total) as f32,
            accumulated_weight: (accumulated / total) as f32,
        }
    }));

    if by_size.is_sorted() {
        return;
    }
    labels.clear();
    labels.resize(by_size.len() + 1, 0);
    for (new, &old) in by_size.iter().enumerate() {
        labels[old as usize + 1] = new as u32 + 1;
    }
    for label in map.labels.values_mut() {
        *label = labels[*label as usize];
    }
}
