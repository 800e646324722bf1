//! Smoothing of the curvature, and suppression of contour pixels [Preiner 2010, section 3.5.2, steps 1 and 2].

use super::SUPPRESSED;
use crate::grid::Grid;
use crate::reflect::sscr::curvature::{PLANAR, X_CLASS, X_STEP, Y_CLASS, Y_SHIFT, Y_STEP};

/// The class of the first pixel of a row or column of the mirror, which has nothing to compare with.
const UNKNOWN: u8 = 0;

/// The class of a pixel along one axis after smoothing, and whether it is on the border of a region. `before` is the
/// smoothed class of the pixel before, if the mirror continues from there.
fn continued(class: u8, before: Option<u8>) -> (u8, bool) {
    match before {
        None => (UNKNOWN, true),
        Some(UNKNOWN) => (class, false),
        Some(before) if class == PLANAR => (before, false),
        Some(before) => (class, class != before),
    }
}

/// Smooths the classes of `curvature` and marks the pixels on borders of regions, into `cells` of equal size.
///
/// A planar pixel takes the class of the one before, along the row in x and down the column in y. A pixel is suppressed
/// where the class in x differs from the left pixel's, or that in y from the upper one's, and where it is the first of a
/// row or column, or behind a depth step: those would else chain up along the mirror's edge.
pub(super) fn suppress(curvature: &Grid<u8>, cells: &mut Grid<u8>) {
    let width = curvature.width();
    if width == 0 {
        return;
    }
    let mut upper_row: &[u8] = &[];
    let rows = curvature.values().chunks_exact(width);
    for (input, row) in rows.zip(cells.values_mut().chunks_exact_mut(width)) {
        suppress_row(input, upper_row, row);
        upper_row = row;
    }
}

/// Smooths and suppresses one row.
fn suppress_row(input: &[u8], upper_row: &[u8], row: &mut [u8]) {
    let mut left = 0;
    for (x, (&byte, cell)) in input.iter().zip(row).enumerate() {
        *cell = if byte == 0 {
            0
        } else {
            let upper = upper_row.get(x).copied().unwrap_or(0);
            let x_before = (left != 0 && byte & X_STEP == 0).then_some(left & X_CLASS);
            let y_before =
                (upper != 0 && byte & Y_STEP == 0).then_some((upper & Y_CLASS) >> Y_SHIFT);
            let (x_class, x_border) = continued(byte & X_CLASS, x_before);
            let (y_class, y_border) = continued((byte & Y_CLASS) >> Y_SHIFT, y_before);
            let suppressed = if x_border || y_border { SUPPRESSED } else { 0 };
            byte & (X_STEP | Y_STEP) | x_class | y_class << Y_SHIFT | suppressed
        };
        left = *cell;
    }
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::super::super::curvature::{CONCAVE, CONVEX};
    use super::*;

    /// A row of the thesis's signs as bytes, below a row of the mirror, so that only x can suppress.
    fn suppressed(row: &str, steps: &str) -> String {
        let byte = |(sign, step): (char, char)| {
            let class = match sign {
                '+' => CONVEX,
                '-' => CONCAVE,
                '0' => PLANAR,
                _ => return 0,
            };
            let step = if step == '|' { X_STEP } else { 0 };
            class | PLANAR << Y_SHIFT | step
        };
        let line = row.chars().zip(steps.chars()).map(byte);
        let upper = vec![PLANAR | PLANAR << Y_SHIFT; row.len()];
        let both = upper.into_iter().chain(line).collect();
        let map = Grid::from_vec(UVec2::new(row.len() as u32, 2), both).unwrap();
        let mut cells = Grid::new(map.size(), 0);
        suppress(&map, &mut cells);
        let show = |&c: &u8| match c & X_CLASS {
            _ if c & SUPPRESSED != 0 => 'S',
            CONVEX => '+',
            CONCAVE => '-',
            PLANAR => '0',
            _ => '.',
        };
        cells.values()[row.len()..].iter().map(show).collect()
    }

    #[test]
    fn planar_pixels_continue_what_is_before_them() {
        assert_eq!(suppressed("0++0+00++", "         "), "S++++++++");
    }

    #[test]
    fn a_change_of_sign_is_suppressed_where_it_begins() {
        assert_eq!(suppressed("0++--0++", "        "), "S++S--S+");
    }

    #[test]
    fn a_flat_mirror_stays_flat() {
        assert_eq!(suppressed("0000", "    "), "S000");
    }

    #[test]
    fn behind_a_step_and_beside_the_mirror_a_row_begins_anew() {
        assert_eq!(suppressed("0+++0--.0++", "    |      "), "S+++S--.S++");
    }
}
