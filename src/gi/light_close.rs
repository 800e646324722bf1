//! Pass `light_close`: closes single texels of a light's map through which light leaks between the points of a surface.
//! CPU twin of `shaders/light_close.wgsl`.
//!
//! A texel deeper than at least seven of its eight neighbours takes the depth of the seventh: a rank filter, which leaves
//! planes and edges as they are, and speckles of light nowhere.

use rayon::prelude::*;

use crate::gbuffer::fill::NEIGHBOURS;
use crate::gbuffer::{EMPTY, column_row};
use crate::grid::Grid;

/// A light's map without leaks.
pub fn light_close(keys: &Grid<u32>) -> Grid<u32> {
    let width = keys.width();
    let mut closed = Grid::new(keys.size(), EMPTY);
    closed
        .values_mut()
        .par_iter_mut()
        .enumerate()
        .for_each(|(i, out)| {
            let (x, y) = column_row(i, width);
            let at = |x: i32, y: i32| keys.get(x as usize, y as usize).copied().unwrap_or(EMPTY);
            // The two deepest neighbours.
            let (mut deepest, mut second) = (0, 0);
            for (dx, dy) in NEIGHBOURS {
                let key = at(x + dx, y + dy);
                second = second.max(key.min(deepest));
                deepest = deepest.max(key);
            }
            *out = at(x, y).min(second);
        });
    closed
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    #[test]
    fn a_hole_is_closed_and_edges_stay() {
        let size = UVec2::new(6, 5);
        // Left half near, right half far, one leak in the near, one deep point at the edge.
        let mut keys = Grid::new(size, 100);
        for i in 0..30 {
            if i % 6 >= 3 {
                keys.values_mut()[i] = 900;
            }
        }
        let plain = keys.clone();
        assert_eq!(light_close(&plain).get(3, 2), Some(&900), "an edge stays");
        keys.values_mut()[2 * 6 + 1] = 900;
        assert_eq!(light_close(&keys).get(1, 2), Some(&100), "a leak is closed");
    }

    #[test]
    fn what_the_light_does_not_see_stays_unseen() {
        let keys = Grid::new(UVec2::new(4, 4), EMPTY);
        assert_eq!(light_close(&keys), keys);
    }
}
