//! Three planes of f64: what measures of pictures work on.

use glam::{DVec3, UVec2};
use rayon::prelude::*;

/// Values beyond the picture's edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Beyond {
    /// The picture, mirrored at its edge: the pixel beyond is that at the edge, then the one before.
    Mirrored,
    /// The pixel at the edge, again and again.
    Repeated,
}

/// A picture as three planes, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Planes {
    /// Width and height, pixels.
    pub size: UVec2,
    /// The values of each channel.
    pub channels: [Vec<f64>; 3],
}

impl Planes {
    /// Planes of `size` whose pixel `i` is `pixel(i)`.
    pub fn new(size: UVec2, pixel: impl Fn(usize) -> DVec3 + Sync) -> Self {
        let pixels = size.x as usize * size.y as usize;
        let values: Vec<DVec3> = (0..pixels).into_par_iter().map(&pixel).collect();
        Self {
            size,
            channels: [0, 1, 2].map(|c| values.iter().map(|v| v[c]).collect()),
        }
    }

    /// The value of a pixel.
    pub fn at(&self, pixel: usize) -> DVec3 {
        let [x, y, z] = &self.channels;
        let of = |plane: &[f64]| plane.get(pixel).copied().unwrap_or_default();
        DVec3::new(of(x), of(y), of(z))
    }

    /// Every pixel by a function.
    pub(super) fn map(&self, f: impl Fn(DVec3) -> DVec3 + Sync) -> Self {
        Self::new(self.size, |i| f(self.at(i)))
    }

    /// The part from `low` to below `high`.
    pub(super) fn part(&self, (low, high): (UVec2, UVec2)) -> Self {
        let size = high - low;
        let at = |i: usize| {
            let (x, y) = (i % size.x as usize, i / size.x as usize);
            (y + low.y as usize) * self.size.x as usize + x + low.x as usize
        };
        Self::new(size, |i| self.at(at(i)))
    }
}

/// The convolution of a plane of `width` with a kernel along x and one along y, both of odd length around their middle.
pub(super) fn convolved(
    plane: &[f64],
    width: usize,
    along_x: &[f64],
    along_y: &[f64],
    beyond: Beyond,
) -> Vec<f64> {
    let height = plane.len() / width.max(1);
    let mut rows = vec![0.0; plane.len()];
    rows.par_chunks_mut(width.max(1))
        .zip(plane.par_chunks(width.max(1)))
        .for_each(|(out, row)| {
            for (x, out) in out.iter_mut().enumerate() {
                *out = sum(along_x, x, width, beyond, |x| row[x]);
            }
        });
    let mut both = vec![0.0; plane.len()];
    both.par_chunks_mut(width.max(1))
        .enumerate()
        .for_each(|(y, out)| {
            let reach = along_y.len() / 2;
            for (k, weight) in along_y.iter().enumerate() {
                let from = inside(y as isize + k as isize - reach as isize, height, beyond);
                let row = &rows[from * width..(from + 1) * width];
                for (out, value) in out.iter_mut().zip(row) {
                    *out += weight * value;
                }
            }
        });
    both
}

fn sum(
    kernel: &[f64],
    middle: usize,
    length: usize,
    beyond: Beyond,
    value: impl Fn(usize) -> f64,
) -> f64 {
    let reach = kernel.len() / 2;
    if middle >= reach && middle + reach < length {
        let start = middle - reach;
        return (kernel.iter().enumerate())
            .map(|(k, weight)| weight * value(start + k))
            .sum();
    }
    (kernel.iter().enumerate())
        .map(|(k, weight)| {
            let at = middle as isize + k as isize - reach as isize;
            weight * value(inside(at, length, beyond))
        })
        .sum()
}

/// The index that stands for one beyond the edge of `length` values.
fn inside(at: isize, length: usize, beyond: Beyond) -> usize {
    let length = length as isize;
    let found = match beyond {
        Beyond::Repeated => at.clamp(0, length - 1),
        Beyond::Mirrored => {
            let at = at.rem_euclid(2 * length);
            at.min(2 * length - 1 - at)
        }
    };
    found as usize
}

/// Pixels by which the box around the measured pixels is enlarged: no measure looks farther.
const MARGIN: u32 = 16;

/// The box around the pixels of a mask, and as much around it as a measure looks at; `None` where there is no pixel.
pub(super) fn around(mask: &[bool], size: UVec2) -> Option<(UVec2, UVec2)> {
    let (mut low, mut high) = (size, UVec2::ZERO);
    for (i, _) in mask.iter().enumerate().filter(|(_, of)| **of) {
        let at = UVec2::new(i as u32 % size.x, i as u32 / size.x);
        (low, high) = (low.min(at), high.max(at + 1));
    }
    let margin = UVec2::splat(MARGIN);
    (low.cmplt(high).all()).then(|| (low.saturating_sub(margin), (high + margin).min(size)))
}

/// The mask within a box.
pub(super) fn part_of(mask: &[bool], size: UVec2, (low, high): (UVec2, UVec2)) -> Vec<bool> {
    (low.y..high.y)
        .flat_map(|y| (low.x..high.x).map(move |x| (y as usize) * size.x as usize + x as usize))
        .map(|i| mask.get(i).copied().unwrap_or_default())
        .collect()
}

/// The mean of `values` where the mask is set; NaN where it is nowhere.
pub(super) fn mean(values: &[f64], mask: &[bool]) -> f64 {
    let chosen = values.iter().zip(mask).filter(|(_, of)| **of);
    let (sum, n) = chosen.fold((0.0, 0u64), |(sum, n), (v, _)| (sum + v, n + 1));
    sum / n as f64
}

/// sRGB, 0 to 1, of linear RGB, clipped to 0 to 1 [IEC 61966-2-1].
pub fn srgb(linear: DVec3) -> DVec3 {
    linear.clamp(DVec3::ZERO, DVec3::ONE).map(|c| {
        if c <= 0.003_130_8 {
            12.92 * c
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kernel_weighs_what_lies_around() {
        let plane = [1.0, 2.0, 4.0, 8.0];
        let shifted = convolved(&plane, 4, &[1.0, 0.0, 0.0], &[1.0], Beyond::Repeated);
        assert_eq!(shifted, [1.0, 1.0, 2.0, 4.0]);
        let mirrored = convolved(
            &plane,
            4,
            &[0.0, 0.0, 0.0, 0.0, 1.0],
            &[1.0],
            Beyond::Mirrored,
        );
        assert_eq!(mirrored, [4.0, 8.0, 8.0, 4.0]);
        let down = convolved(&plane, 2, &[1.0], &[1.0, 0.0, 0.0], Beyond::Mirrored);
        assert_eq!(down, [1.0, 2.0, 1.0, 2.0]);
    }

    #[test]
    fn the_box_holds_all_that_is_measured() {
        let size = UVec2::new(100, 50);
        let mut mask = vec![false; 5000];
        assert_eq!(around(&mask, size), None);
        mask[20 * 100 + 40] = true;
        let part = around(&mask, size);
        assert_eq!(part, Some((UVec2::new(24, 4), UVec2::new(57, 37))));
        let inside = part_of(&mask, size, part.unwrap_or_default());
        assert_eq!(inside.iter().filter(|m| **m).count(), 1);
    }
}
