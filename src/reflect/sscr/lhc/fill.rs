//! Suppressed pixels join a neighbour's region [Preiner 2010, section 3.5.2, step 4].

use super::Tally;
use crate::grid::Grid;
use crate::reflect::sscr::curvature::{X_CLASS, X_STEP, Y_CLASS, Y_STEP};

/// A map whose suppressed pixels are to be filled.
pub(super) struct Filling<'a> {
    /// Smoothed classes and steps; 0 where there is no mirror.
    pub(super) cells: &'a Grid<u8>,
    /// Labels so far.
    pub(super) labels: &'a mut Grid<u32>,
    /// The regions' pixels so far.
    pub(super) tallies: &'a mut [Tally],
    /// Working memory: pixels to look at.
    pub(super) queue: &'a mut Vec<usize>,
}

impl Filling<'_> {
    /// Gives each mirror pixel without a label that of its right or else its lower neighbour.
    ///
    /// Right to left and bottom up, so that a chain of suppressed pixels is filled from its end. A neighbour that begins
    /// another region itself is passed over: the border of a whole row of regions would else go to the last of them.
    pub(super) fn fill(&mut self) {
        let (width, height) = (self.cells.width(), self.cells.height());
        self.queue.clear();
        for y in (0..height).rev() {
            for x in (0..width).rev() {
                let i = y * width + x;
                if !self.is_open(i) {
                    continue;
                }
                let right = (x + 1 < width).then_some(i + 1);
                let right = right.filter(|&n| self.continues(i, n, X_CLASS, X_STEP));
                let lower = (y + 1 < height).then_some(i + width);
                let lower = lower.filter(|&n| self.continues(i, n, Y_CLASS, Y_STEP));
                if !self.join(i, [right, lower]) {
                    self.queue.push(i);
                }
            }
        }
        self.spread();
    }

    /// Fills what is left from any neighbour, ring by ring.
    fn spread(&mut self) {
        let mut next = 0;
        while let Some(&i) = self.queue.get(next) {
            next += 1;
            let neighbours = self.neighbours(i);
            if self.is_open(i) && self.join(i, neighbours) {
                self.queue.extend(neighbours.into_iter().flatten());
            }
        }
    }

    /// Whether a mirror pixel has no label.
    fn is_open(&self, i: usize) -> bool {
        self.cells.values()[i] != 0 && self.labels.values()[i] == 0
    }

    /// Whether the mirror goes on from a pixel to the right or lower one without a border.
    fn continues(&self, here: usize, next: usize, class: u8, step: u8) -> bool {
        let (here, next) = (self.cells.values()[here], self.cells.values()[next]);
        // A first pixel has no class of its own.
        next & step == 0 && (here & class == 0 || here & class == next & class)
    }

    /// The neighbours to which no step lies.
    fn neighbours(&self, i: usize) -> [Option<usize>; 4] {
        let (width, cells) = (self.cells.width(), self.cells.values());
        let (x, last) = (i % width, width - 1);
        let no_step = |later: usize, step: u8| cells[later] & step == 0;
        [
            (x > 0 && no_step(i, X_STEP)).then(|| i - 1),
            (i >= width && no_step(i, Y_STEP)).then(|| i - width),
            (x < last && no_step(i + 1, X_STEP)).then_some(i + 1),
            (i + width < cells.len() && no_step(i + width, Y_STEP)).then_some(i + width),
        ]
    }

    /// Gives a pixel the label of the first of its neighbours that has one; whether one had.
    fn join<const N: usize>(&mut self, i: usize, neighbours: [Option<usize>; N]) -> bool {
        let labels = self.labels.values_mut();
        let mut known = neighbours.into_iter().flatten().map(|n| labels[n]);
        let Some(label) = known.find(|&label| label != 0) else {
            return false;
        };
        labels[i] = label;
        let (x, y) = (i % self.cells.width(), i / self.cells.width());
        self.tallies[label as usize - 1].add(x, x + 1, y);
        true
    }
}
