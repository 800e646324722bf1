//! Labelling by contour tracing [Chang, Chen, Lu 2004], as adapted in [Preiner 2010, section 4.4.1].
//!
//! Three things differ from the original. Regions are 4-connected. A border lies between two pixels, not on background
//! pixels: neighbours of different regions need none. A contour that was traced is remembered at the lower sides that it
//! passed; the thesis's flag per pixel misses a hole's contour where the pixel above the hole lies on the outer one too.

use super::Tally;
use crate::grid::Grid;
use crate::reflect::sscr::curvature::{X_STEP, Y_STEP};

/// A pixel's sides, clockwise: its links to its neighbours are bits 0 to 3.
const UP: u32 = 0;
const RIGHT: u32 = 1;
const DOWN: u32 = 2;
const LEFT: u32 = 3;

/// The contour along the lower side was traced.
const TRACED: u8 = 1 << 4;
/// The pixel belongs to some region.
const INSIDE: u8 = 1 << 5;

const fn link_to(side: u32) -> u8 {
    1 << side
}

/// Says of each pixel which neighbours are of its region: those of one class, if no step lies between.
pub(super) fn link(cells: &Grid<u8>, class: impl Fn(u8) -> u8, links: &mut [u8]) {
    let width = cells.width();
    let cells = cells.values();
    for (i, &cell) in cells.iter().enumerate() {
        links[i] = 0;
        let here = class(cell);
        if here == 0 {
            continue;
        }
        links[i] = INSIDE;
        if i % width > 0 && cell & X_STEP == 0 && class(cells[i - 1]) == here {
            links[i] |= link_to(LEFT);
            links[i - 1] |= link_to(RIGHT);
        }
        if i >= width && cell & Y_STEP == 0 && class(cells[i - width]) == here {
            links[i] |= link_to(UP);
            links[i - width] |= link_to(DOWN);
        }
    }
}

/// Labels the linked pixels, from 1 on in the order of the regions' first pixels, and counts them.
pub(super) fn trace(links: &mut [u8], labels: &mut Grid<u32>, tallies: &mut Vec<Tally>) {
    let (width, height) = (labels.width(), labels.height());
    for y in 0..height {
        let (mut run_start, mut run_label) = (0, 0);
        for x in 0..width {
            let label = label_pixel(links, labels, tallies, y * width + x);
            if label != run_label {
                count(tallies, run_label, run_start, x, y);
                (run_start, run_label) = (x, label);
            }
        }
        count(tallies, run_label, run_start, width, y);
    }
}

/// Adds the pixels `x0` to `x1` of row `y` to a region.
fn count(tallies: &mut [Tally], label: u32, x0: usize, x1: usize, y: usize) {
    if label > 0 {
        tallies[label as usize - 1].add(x0, x1, y);
    }
}

/// The label of the pixel `i`, 0 for none; all before it are labelled.
fn label_pixel(
    links: &mut [u8],
    labels: &mut Grid<u32>,
    tallies: &mut Vec<Tally>,
    i: usize,
) -> u32 {
    let link = links[i];
    if link & INSIDE == 0 {
        return 0;
    }
    let width = labels.width();
    let labels = labels.values_mut();
    if labels[i] == 0 {
        if link & link_to(LEFT) != 0 {
            labels[i] = labels[i - 1];
        } else if link & link_to(UP) != 0 {
            labels[i] = labels[i - width];
        } else {
            // On no contour, and nothing above or to the left: a new region.
            tallies.push(Tally::EMPTY);
            follow(links, labels, width, (i, UP), tallies.len() as u32);
        }
    }
    let label = labels[i];
    // Tracing may have passed the lower side: read again.
    if links[i] & (link_to(DOWN) | TRACED) == 0 {
        // A hole begins below.
        follow(links, labels, width, (i, DOWN), label);
    }
    label
}

/// Labels the pixels along a contour, clockwise around the region from a side of a pixel back to it.
fn follow(links: &mut [u8], labels: &mut [u32], width: usize, start: (usize, u32), label: u32) {
    let steps = [-(width as isize), 1, width as isize, -1];
    let (mut pixel, mut side) = start;
    loop {
        labels[pixel] = label;
        if side == DOWN {
            links[pixel] |= TRACED;
        }
        // Turn around the corner at the side's end: the first side without a link continues the contour.
        side = (side + 1) % 4;
        while links[pixel] & link_to(side) != 0 {
            pixel = pixel.wrapping_add_signed(steps[side as usize]);
            side = (side + 3) % 4;
        }
        if (pixel, side) == start {
            return;
        }
    }
}
