//! Random numbers of the search: integers, so that a GPU draws the same.

/// A random sequence of its own for every point.
pub(super) struct Random(u32);

impl Random {
    pub(super) fn new(point: u32) -> Self {
        Self(scramble(point))
    }

    /// 0 to 1, exclusive.
    pub(super) fn next(&mut self) -> f32 {
        self.0 = scramble(self.0);
        (self.0 >> 8) as f32 * (1.0 / 16_777_216.0)
    }
}

/// A permutation of the integers without pattern: one step of a linear congruence, permuted by its own top bits
/// [O'Neill 2014, "PCG", RXS-M-XS].
fn scramble(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn random_numbers_fill_their_range_evenly() {
        let mut bins = [0; 16];
        for point in 0..4096 {
            let mut random = Random::new(point);
            for _ in 0..4 {
                let u = random.next();
                assert!((0.0..1.0).contains(&u), "{u}");
                bins[(u * 16.0) as usize] += 1;
            }
        }
        // 1024 expected, standard deviation 31.
        assert!(
            bins.iter().all(|n| (1024 - 140..=1024 + 140).contains(n)),
            "{bins:?}"
        );
    }
}
