//! Pixels of a mirror that show something far behind what surrounds them: most likely a hole in a nearer surface.

use rayon::prelude::*;

use super::MirrorGBuffer;
use crate::backend::cpu::Cpu;
use crate::gbuffer::average::Pixel;

/// A neighbour nearer than this part of the pixel's own distance lies in front of it.
const IN_FRONT: f32 = 0.9;

/// Neighbours in front, of eight, that make a pixel doubtful.
const LEAST_NEIGHBOURS: usize = 5;

/// Empties the pixels that are doubtful.
pub(super) fn empty_doubtful(mirror: &mut MirrorGBuffer<Cpu>) {
    let width = mirror.origin.width();
    let distance = |x: usize, y: usize| {
        let shown = mirror.material.get(x, y).is_some_and(|m| m.w > 0.0);
        mirror.surface.get(x, y).filter(|_| shown).map(|s| s.w)
    };
    let doubtful: Vec<usize> = (0..mirror.material.values().len())
        .into_par_iter()
        .filter(|&i| {
            let (x, y) = (i % width, i / width);
            let Some(own) = distance(x, y) else {
                return false;
            };
            let around = (0..9).filter(|k| *k != 4).filter_map(|k| {
                let (x, y) = ((x + k % 3).checked_sub(1)?, (y + k / 3).checked_sub(1)?);
                distance(x, y)
            });
            around.filter(|&d| d < IN_FRONT * own).count() >= LEAST_NEIGHBOURS
        })
        .collect();
    for i in doubtful {
        mirror.show(i, Pixel::default());
        mirror.count.values_mut()[i] = 0;
    }
}

#[cfg(test)]
mod tests {
    use glam::{UVec2, Vec4};

    use super::*;

    #[test]
    fn a_pixel_far_behind_its_neighbours_is_emptied_and_an_edge_is_not() {
        let mut mirror = MirrorGBuffer::empty(UVec2::new(6, 5));
        for i in 0..30 {
            // Near on the left, far on the right, and one hole in the near part.
            let distance = if i % 6 < 3 && i != 13 { 1.0 } else { 3.0 };
            let pixel = Pixel {
                surface: Vec4::new(0.0, 0.0, 1.0, distance),
                material: Vec4::ONE,
                ..Pixel::default()
            };
            mirror.show(i, pixel);
        }
        empty_doubtful(&mut mirror);
        let empty: Vec<usize> = (0..30).filter(|&i| mirror.at(i).is_none()).collect();
        assert_eq!(empty, [13]);
    }
}
