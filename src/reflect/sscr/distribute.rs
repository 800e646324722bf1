//! One region for each point: by the region's weight, so that large regions get the points that they need, or by turns
//! [Preiner 2010, sections 3.6 and 4.5.1].

use super::{Distribution, Region};

/// One dimension of the Halton sequence: the radical inverse to a prime base [Halton 1960].
///
/// Whole numbers up to the last product, so that both backends get the same bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Halton {
    /// A prime.
    pub base: u32,
    /// Digits that count: as many as f32 holds exactly.
    pub digits: u32,
    /// 1 / base ^ digits.
    pub scale: f32,
}

impl Halton {
    /// The dimension of a prime base.
    const fn new(base: u32) -> Self {
        let (mut digits, mut power) = (0, 1);
        while power * base <= 1 << f32::MANTISSA_DIGITS {
            power *= base;
            digits += 1;
        }
        Self {
            base,
            digits,
            scale: 1.0 / power as f32,
        }
    }

    /// The number of an index, 0 to 1.
    pub fn number(&self, index: u32) -> f32 {
        self.mirrored(index) as f32 * self.scale
    }

    /// The index with its digits in reverse order.
    fn mirrored(&self, mut index: u32) -> u32 {
        // The most used base has an instruction of its own.
        if self.base == 2 {
            return index.reverse_bits() >> (u32::BITS - self.digits);
        }
        let mut mirrored = 0;
        for _ in 0..self.digits {
            mirrored = mirrored * self.base + index % self.base;
            index /= self.base;
        }
        mirrored
    }
}

/// A dimension for each pass of `sscr.passes`: a point goes to regions that have nothing to do with each other.
pub const PASSES: [Halton; 16] = {
    const PRIMES: [u32; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];
    let mut passes = [Halton::new(2); 16];
    let mut i = 1;
    while i < passes.len() {
        passes[i] = Halton::new(PRIMES[i]);
        i += 1;
    }
    passes
};

/// The region of a point in a pass of `sscr.passes` (counted from 0), as a label of the LHC map; `None` where there is
/// no region.
///
/// `index` is the point's place in the shuffled cloud.
pub fn distribute(
    regions: &[Region],
    distribution: Distribution,
    index: u32,
    pass: u32,
) -> Option<u32> {
    let last = u32::try_from(regions.len()).ok()?.checked_sub(1)?;
    let region = match distribution {
        Distribution::Weighted => {
            let number = PASSES[pass as usize % PASSES.len()].number(index);
            regions.partition_point(|r| r.accumulated_weight <= number) as u32
        }
        Distribution::Uniform => index.wrapping_add(pass) % (last + 1),
    };
    Some(region.min(last) + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gbuffer::disc::PixelRect;

    const POINTS: u32 = 100_000;

    /// Regions of so many pixels, in descending order.
    fn regions(pixels: &[u32]) -> Vec<Region> {
        let total: f64 = pixels.iter().map(|&p| f64::from(p)).sum();
        let mut sum = 0.0;
        let region = |&pixels: &u32| {
            sum += f64::from(pixels);
            Region {
                bounds: PixelRect {
                    x0: 0,
                    y0: 0,
                    x1: 1,
                    y1: 1,
                },
                pixels,
                weight: (f64::from(pixels) / total) as f32,
                accumulated_weight: (sum / total) as f32,
            }
        };
        pixels.iter().map(region).collect()
    }

    /// The share of the points that each region gets in a pass.
    fn shares(regions: &[Region], distribution: Distribution, pass: u32) -> Vec<f64> {
        let mut counts = vec![0; regions.len()];
        for index in 0..POINTS {
            let label = distribute(regions, distribution, index, pass).unwrap();
            counts[label as usize - 1] += 1;
        }
        let share = |c: u32| f64::from(c) / f64::from(POINTS);
        counts.into_iter().map(share).collect()
    }

    /// The first region whose share differs from what it ought to be by more than chance allows.
    fn wrong_share(shares: &[f64], expected: &[f64]) -> Option<usize> {
        let tolerance = 1.0 / f64::from(POINTS).sqrt();
        let wrong = |(a, b): (&f64, &f64)| (a - b).abs() > tolerance;
        shares.iter().zip(expected).position(wrong)
    }

    #[test]
    fn shares_of_points_are_the_weights_in_every_pass() {
        let regions = regions(&[4000, 3000, 2000, 900, 99, 1]);
        let weights: Vec<f64> = regions.iter().map(|r| f64::from(r.weight)).collect();
        for pass in 0..16 {
            let shares = shares(&regions, Distribution::Weighted, pass);
            let wrong = wrong_share(&shares, &weights);
            assert_eq!(wrong, None, "pass {pass}: {shares:?}, expected {weights:?}");
        }
    }

    #[test]
    fn uniform_shares_are_not_the_weights() {
        let regions = regions(&[4000, 3000, 2000, 900, 99, 1]);
        let weights: Vec<f64> = regions.iter().map(|r| f64::from(r.weight)).collect();
        let shares = shares(&regions, Distribution::Uniform, 1);
        assert_eq!(wrong_share(&shares, &[1.0 / 6.0; 6]), None, "{shares:?}");
        assert!(wrong_share(&shares, &weights).is_some(), "{shares:?}");
    }

    #[test]
    fn passes_send_points_to_regions_that_have_nothing_to_do_with_each_other() {
        let regions = regions(&[1, 1]);
        let label = |index, pass| distribute(&regions, Distribution::Weighted, index, pass);
        for (a, b) in [(0, 1), (0, 15), (3, 4)] {
            let again = (0..POINTS).filter(|&i| label(i, a) == label(i, b)).count();
            let share = again as f64 / f64::from(POINTS);
            assert!(
                (share - 0.5).abs() < 0.02,
                "passes {a} and {b}: {share} of the points go to the same of two regions"
            );
        }
    }

    #[test]
    fn halton_numbers_are_digits_mirrored_at_the_point() {
        let numbers = |base: usize| [1, 2, 3, 4].map(|i| PASSES[base].number(i));
        assert_eq!(numbers(0), [0.5, 0.25, 0.75, 0.125], "base 2");
        let thirds = [1.0 / 3.0, 2.0 / 3.0, 1.0 / 9.0, 4.0 / 9.0];
        for (got, expected) in numbers(1).into_iter().zip(thirds) {
            assert!((got - expected).abs() < 1e-6, "base 3: {got}, {expected}");
        }
    }

    #[test]
    fn every_index_has_a_region_if_there_is_one() {
        let regions = regions(&[1_000_000, 1]);
        for index in [0, 1, u32::MAX / 2, u32::MAX - 1, u32::MAX] {
            for pass in 0..16 {
                for distribution in [Distribution::Weighted, Distribution::Uniform] {
                    let label = distribute(&regions, distribution, index, pass);
                    assert!(matches!(label, Some(1 | 2)), "{index} {pass}: {label:?}");
                    assert_eq!(distribute(&[], distribution, index, pass), None);
                }
            }
        }
    }
}
