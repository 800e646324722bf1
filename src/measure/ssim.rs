//! Structural similarity: Z. Wang, A. Bovik, H. Sheikh, E. Simoncelli, "Image quality assessment: from error visibility to
//! structural similarity", 2004, with the window and constants of that paper.

use glam::DVec3;

use super::planes::{Beyond, Planes, convolved};

/// Luma of sRGB [ITU-R BT.709].
const LUMA: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// Standard deviation of the window, pixels; it ends after `REACH`.
const SIGMA: f64 = 1.5;
const REACH: i32 = 5;

/// (0.01 x 1)^2 and (0.03 x 1)^2, for values 0 to 1.
const C1: f64 = 1e-4;
const C2: f64 = 9e-4;

/// The similarity of two pictures of one size (sRGB, 0 to 1) at each pixel: -1 to 1, and 1 where they are the same.
pub(super) fn ssim(a: &Planes, b: &Planes) -> Vec<f64> {
    let width = a.size.x as usize;
    let luma = |planes: &Planes| -> Vec<f64> {
        (0..planes.channels[0].len())
            .map(|i| planes.at(i).dot(LUMA))
            .collect()
    };
    let mut window: Vec<f64> = (-REACH..=REACH)
        .map(|x| (-0.5 * (f64::from(x) / SIGMA).powi(2)).exp())
        .collect();
    let sum: f64 = window.iter().sum();
    window.iter_mut().for_each(|w| *w /= sum);
    let blurred = |plane: &[f64]| convolved(plane, width, &window, &window, Beyond::Mirrored);
    let product =
        |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a * b).collect() };
    let (a, b) = (luma(a), luma(b));
    let [mean_a, mean_b] = [&a, &b].map(|plane| blurred(plane));
    let [aa, bb, ab] = [(&a, &a), (&b, &b), (&a, &b)].map(|(a, b)| blurred(&product(a, b)));
    (0..a.len())
        .map(|i| {
            let (ma, mb) = (mean_a[i], mean_b[i]);
            let (va, vb, cov) = (aa[i] - ma * ma, bb[i] - mb * mb, ab[i] - ma * mb);
            ((2.0 * ma * mb + C1) * (2.0 * cov + C2)) / ((ma * ma + mb * mb + C1) * (va + vb + C2))
        })
        .collect()
}
