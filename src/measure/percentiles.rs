//! How values are spread.

use serde::{Deserialize, Serialize};

/// Percentiles of values, between neighbours in proportion; all 0 of no value.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Percentiles {
    /// Half are smaller.
    pub median: f64,
    /// 90 % are smaller.
    pub p90: f64,
    /// 95 % are smaller.
    pub p95: f64,
    /// 99 % are smaller.
    pub p99: f64,
    /// The largest.
    pub max: f64,
}

impl Percentiles {
    /// Of these values, in any order.
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let at = |percent| percentile(&values, percent);
        Self {
            median: at(50.0),
            p90: at(90.0),
            p95: at(95.0),
            p99: at(99.0),
            max: at(100.0),
        }
    }
}

/// The value that `percent` of the sorted values are smaller than, between neighbours in proportion; 0 of no value.
pub fn percentile(sorted: &[f64], percent: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    let place = percent / 100.0 * last as f64;
    let below = (place as usize).min(last);
    let of = |i: usize| sorted.get(i.min(last)).copied().unwrap_or_default();
    of(below) + (of(below + 1) - of(below)) * (place - below as f64)
}

/// The median of values in any order; 0 of none.
pub fn median(values: &[f64]) -> f64 {
    Percentiles::of(values.to_vec()).median
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_lie_between_neighbours() {
        let p = Percentiles::of((0..=10).rev().map(f64::from).collect());
        assert_eq!((p.median, p.p90, p.p95, p.max), (5.0, 9.0, 9.5, 10.0));
        assert_eq!(median(&[4.0, 1.0]), 2.5);
        assert_eq!(Percentiles::of(Vec::new()), Percentiles::default());
    }
}
