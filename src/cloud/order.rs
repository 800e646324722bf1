//! Points along a Morton curve: those next to each other in the order mostly lie next to each other in space, however
//! unevenly the points are spread.
//!
//! A Hilbert curve, which never jumps, would make tracing a tenth faster and ordering twice as slow.

use glam::Vec3;
use rayon::prelude::*;

use super::Place;

/// Bits of a cell's coordinate along an axis: half a millimetre in a kilometre.
const BITS: u32 = 21;

/// Surfels a task.
const CHUNK: usize = 1 << 14;

/// The indices of `places` along the curve. Places without finite coordinates go somewhere.
pub fn along_curve(places: &[Place]) -> Vec<u32> {
    let (min, max) = places
        .par_chunks(CHUNK)
        .map(bounds)
        .reduce(|| EMPTY, |a, b| (a.0.min(b.0), a.1.max(b.1)));
    let side = (max - min).max_element();
    let cells = (1u32 << BITS) as f32;
    let scale = if side > 0.0 && side.is_finite() {
        cells / side
    } else {
        0.0
    };
    // A key and an index each: no two are equal, so that the order is one for any number of threads.
    let mut keyed: Vec<(u64, u32)> = places
        .par_iter()
        .enumerate()
        .map(|(index, place)| {
            let cell = ((place.position - min) * scale).min(Vec3::splat(cells - 1.0));
            let cell = [cell.x as u32, cell.y as u32, cell.z as u32];
            (morton_key(cell), index as u32)
        })
        .collect();
    keyed.par_sort_unstable();
    keyed.into_par_iter().map(|(_, index)| index).collect()
}

const EMPTY: (Vec3, Vec3) = (Vec3::INFINITY, Vec3::NEG_INFINITY);

fn bounds(places: &[Place]) -> (Vec3, Vec3) {
    places
        .iter()
        .map(|place| place.position)
        .filter(|position| position.is_finite())
        .fold(EMPTY, |(min, max), p| (min.min(p), max.max(p)))
}

/// Place along a Morton curve of a cell with coordinates below 2^21: their bits, one of each in turn.
fn morton_key([x, y, z]: [u32; 3]) -> u64 {
    spread(x) << 2 | spread(y) << 1 | spread(z)
}

/// The 21 bits of `value`, two zeros after each.
fn spread(value: u32) -> u64 {
    let mut v = u64::from(value);
    v = (v | v << 32) & 0x001f_0000_0000_ffff;
    v = (v | v << 16) & 0x001f_0000_ff00_00ff;
    v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
    v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
    (v | v << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_interleave_the_bits_of_the_coordinates() {
        assert_eq!(morton_key([1, 0, 0]), 0b100);
        assert_eq!(morton_key([3, 1, 2]), 0b101_110);
        let last = (1 << BITS) - 1;
        assert_eq!(morton_key([last; 3]), (1 << (3 * BITS)) - 1);
    }

    #[test]
    fn every_place_comes_once_even_without_coordinates() {
        let place = |x: f32| Place {
            position: Vec3::new(x, -x, 3.0),
            radius: 1.0,
        };
        let places = [1.0, f32::NAN, f32::INFINITY, 1.0, -2.0, 1e30].map(place);
        let mut order = along_curve(&places);
        order.sort_unstable();
        assert_eq!(order, [0, 1, 2, 3, 4, 5]);
    }
}
