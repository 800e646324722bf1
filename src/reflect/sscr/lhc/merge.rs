//! Small regions join a neighbour: what noise has cut off is searched together with what it belongs to.

use std::collections::BTreeMap;

use super::Tally;
use crate::gbuffer::disc::PixelRect;
use crate::grid::Grid;
use crate::reflect::sscr::curvature::{X_STEP, Y_STEP};

/// Rounds at most: chains of small regions shrink by half in each.
const ROUNDS: u32 = 16;

/// Gives the pixels of every region of fewer than `least` pixels to the neighbour, within the mirror and over no step, with
/// which it shares the longest border; where several do, to the first. A region without neighbours stays.
pub(super) fn merge(
    cells: &Grid<u8>,
    labels: &mut Grid<u32>,
    tallies: &mut Vec<Tally>,
    least: u32,
) {
    for _ in 0..ROUNDS {
        let borders = borders(cells, labels, |label| {
            tallies[label as usize - 1].pixels < least
        });
        if borders.is_empty() {
            return;
        }
        // The longest border of each small region.
        let mut best: BTreeMap<u32, (u32, u32)> = BTreeMap::new();
        for ((small, other), length) in borders {
            let longest = best.entry(small).or_insert((other, length));
            if length > longest.1 {
                *longest = (other, length);
            }
        }
        let into = absorb(&best, tallies);
        for label in labels.values_mut() {
            *label = into[*label as usize];
        }
    }
}

/// Lengths of the borders of small regions: by small region and neighbour, pixels.
fn borders(
    cells: &Grid<u8>,
    labels: &Grid<u32>,
    is_small: impl Fn(u32) -> bool,
) -> BTreeMap<(u32, u32), u32> {
    let width = labels.width();
    let (cells, labels) = (cells.values(), labels.values());
    let mut borders = BTreeMap::new();
    let mut meet = |a: u32, b: u32| {
        if a == b || a == 0 || b == 0 {
            return;
        }
        for (small, other) in [(a, b), (b, a)] {
            if is_small(small) {
                *borders.entry((small, other)).or_insert(0) += 1;
            }
        }
    };
    for (i, (&cell, &label)) in cells.iter().zip(labels).enumerate() {
        if i % width > 0 && cell & X_STEP == 0 {
            meet(labels[i - 1], label);
        }
        if i >= width && cell & Y_STEP == 0 {
            meet(labels[i - width], label);
        }
    }
    borders
}

/// Adds each small region's tally to that of its choice, smallest labels first, and numbers the rest anew: returns the new
/// label by old label.
fn absorb(best: &BTreeMap<u32, (u32, u32)>, tallies: &mut Vec<Tally>) -> Vec<u32> {
    let mut into: Vec<u32> = (0..=tallies.len() as u32).collect();
    let root = |into: &[u32], mut label: u32| {
        while into[label as usize] != label {
            label = into[label as usize];
        }
        label
    };
    for (&small, &(other, _)) in best {
        let (from, to) = (root(&into, small), root(&into, other));
        if from == to {
            continue;
        }
        into[from as usize] = to;
        let added = tallies[from as usize - 1];
        let tally = &mut tallies[to as usize - 1];
        tally.pixels += added.pixels;
        tally.bounds = PixelRect {
            x0: tally.bounds.x0.min(added.bounds.x0),
            y0: tally.bounds.y0.min(added.bounds.y0),
            x1: tally.bounds.x1.max(added.bounds.x1),
            y1: tally.bounds.y1.max(added.bounds.y1),
        };
    }
    let mut numbers = vec![0; into.len()];
    let mut kept = Vec::new();
    for label in 1..into.len() as u32 {
        if into[label as usize] == label {
            kept.push(tallies[label as usize - 1]);
            numbers[label as usize] = kept.len() as u32;
        }
    }
    *tallies = kept;
    (0..into.len() as u32)
        .map(|label| numbers[root(&into, label) as usize])
        .collect()
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    /// Labels from digits, with their tallies.
    fn labelled(rows: &[&str]) -> (Grid<u32>, Vec<Tally>) {
        let digits = rows.iter().flat_map(|row| row.bytes());
        let values: Vec<u32> = digits.map(|d| u32::from(d - b'0')).collect();
        let size = UVec2::new(rows[0].len() as u32, rows.len() as u32);
        let count = *values.iter().max().unwrap() as usize;
        let mut tallies = vec![Tally::EMPTY; count];
        for (i, &label) in values.iter().enumerate().filter(|(_, l)| **l > 0) {
            let (x, y) = (i % rows[0].len(), i / rows[0].len());
            tallies[label as usize - 1].add(x, x + 1, y);
        }
        (Grid::from_vec(size, values).unwrap(), tallies)
    }

    fn merged(rows: &[&str], cells: &Grid<u8>, least: u32) -> (Vec<u32>, Vec<u32>) {
        let (mut labels, mut tallies) = labelled(rows);
        merge(cells, &mut labels, &mut tallies, least);
        let pixels = tallies.iter().map(|t| t.pixels).collect();
        (labels.values().to_vec(), pixels)
    }

    #[test]
    fn a_small_region_joins_the_neighbour_with_the_longest_border() {
        let rows = ["11122", "11322", "11322", "11122"];
        let cells = Grid::new(UVec2::new(5, 4), 1);
        let (labels, pixels) = merged(&rows, &cells, 5);
        assert_eq!(pixels, [12, 8], "{labels:?}");
        assert!(labels.iter().all(|&l| l == 1 || l == 2), "{labels:?}");
    }

    #[test]
    fn a_region_beyond_a_step_stays_however_small() {
        let rows = ["1112"];
        let mut cells = Grid::new(UVec2::new(4, 1), 1);
        assert_eq!(merged(&rows, &cells, 5).1, [4]);
        cells.values_mut()[3] |= X_STEP;
        assert_eq!(merged(&rows, &cells, 5).1, [3, 1]);
    }

    #[test]
    fn chains_of_small_regions_join() {
        let rows = ["123456789"];
        let cells = Grid::new(UVec2::new(9, 1), 1);
        let (labels, pixels) = merged(&rows, &cells, 100);
        assert_eq!((labels, pixels), (vec![1; 9], vec![9]));
    }
}
