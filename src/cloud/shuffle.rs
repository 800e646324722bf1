//! The order of surfels: a fixed random permutation, so that every prefix is a fair sample.

use rand::Rng;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::Surfels;

/// State and stream of the generator. Prefixes and slices of all pictures depend on them: they never change.
const STATE: u128 = 0x6361_746f_7074_7269_635f_7368_7566_666c;
const STREAM: u128 = 0x0a02_bdbf_7bb3_c0a7_ac28_fa16_a64a_bf96;

/// The same surfels in shuffled order. The order depends on their number alone.
pub(super) fn shuffled(surfels: Surfels) -> Surfels {
    let order = permutation(surfels.len() as u32);
    let Surfels {
        places,
        finishes,
        source,
        origin,
    } = surfels;
    let places = order
        .par_iter()
        .map(|&index| places[index as usize])
        .collect();
    let finishes = order
        .par_iter()
        .map(|&index| finishes[index as usize])
        .collect();
    let source = order
        .par_iter()
        .map(|&index| source[index as usize])
        .collect();
    Surfels {
        places,
        finishes,
        source,
        origin,
    }
}

/// A permutation of `0..count` by Fisher and Yates's method, spelled out so that no library's update changes it.
fn permutation(count: u32) -> Vec<u32> {
    let mut random = Pcg64::new(STATE, STREAM);
    let mut order: Vec<u32> = (0..count).collect();
    for last in (1..order.len()).rev() {
        let range = last as u128 + 1;
        let other = (u128::from(random.next_u64()) * range) >> 64;
        order.swap(last, other as usize);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_never_changes() {
        assert_eq!(permutation(8), [4, 5, 2, 3, 6, 0, 1, 7]);
    }

    #[test]
    fn every_index_comes_once_and_prefixes_are_fair() {
        let order = permutation(100_000);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..100_000), "a permutation");

        // The mean of 1000 fair draws is off by less than 4 of its standard deviations.
        let mean = order[..1000].iter().map(|&i| f64::from(i)).sum::<f64>() / 1000.0;
        let deviation = 100_000.0 / 12_f64.sqrt() / 1000_f64.sqrt();
        assert!(
            (mean - 50_000.0).abs() < 4.0 * deviation,
            "mean of the first 1000 is {mean}"
        );
    }
}
