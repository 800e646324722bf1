//! Integer colours of files to linear albedo.

use glam::Vec3;

use super::ColourBits;
use crate::image::linear_from_srgb;

/// Largest value of an 8-bit channel.
const EIGHT_BIT_MAX: f32 = 255.0;

/// Largest value of a 16-bit channel.
const SIXTEEN_BIT_MAX: f32 = 65_535.0;

/// Largest value of a channel, by the caller's word or, failing that, by the values themselves: writers disagree on
/// whether 8-bit colours are stretched to 16 bits.
pub(super) fn channel_max(
    bits: ColourBits,
    eight_bit_type: bool,
    values: impl Iterator<Item = f32>,
) -> f32 {
    match bits {
        ColourBits::Eight => EIGHT_BIT_MAX,
        ColourBits::Sixteen => SIXTEEN_BIT_MAX,
        ColourBits::Auto if eight_bit_type => EIGHT_BIT_MAX,
        ColourBits::Auto => {
            if values.fold(0.0, f32::max) > EIGHT_BIT_MAX {
                SIXTEEN_BIT_MAX
            } else {
                EIGHT_BIT_MAX
            }
        }
    }
}

/// Turns sRGB integers to linear values, by a table.
pub(super) struct Linearizer {
    table: Vec<f32>,
}

impl Linearizer {
    /// For channels from 0 to `max`.
    pub(super) fn new(max: f32) -> Self {
        let table = (0..=max as u32)
            .map(|value| linear_from_srgb(value as f32 / max))
            .collect();
        Self { table }
    }

    /// Linear RGB of integer channels, and whether a channel was out of range and clamped.
    pub(super) fn albedo(&self, srgb: Vec3) -> (Vec3, bool) {
        let last = self.table.len().saturating_sub(1);
        let linear = |value: f32| {
            self.table
                .get((value as usize).min(last))
                .copied()
                .unwrap_or(0.0)
        };
        let albedo = Vec3::new(linear(srgb.x), linear(srgb.y), linear(srgb.z));
        (
            albedo,
            srgb.min_element() < 0.0 || srgb.max_element() > last as f32,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_bits_in_sixteen_are_told_apart_by_the_largest_value() {
        assert_eq!(
            channel_max(ColourBits::Auto, false, [3.0, 255.0].into_iter()),
            255.0
        );
        assert_eq!(
            channel_max(ColourBits::Auto, false, [3.0, 256.0].into_iter()),
            65_535.0
        );
        assert_eq!(
            channel_max(ColourBits::Sixteen, false, [3.0].into_iter()),
            65_535.0,
            "the caller's word counts"
        );
    }

    #[test]
    fn srgb_ends_and_middle_are_linear_as_the_standard_says() {
        let table = Linearizer::new(255.0);
        let (albedo, clamped) = table.albedo(Vec3::new(0.0, 128.0, 255.0));
        assert!(
            (albedo - Vec3::new(0.0, 0.215_86, 1.0)).abs().max_element() < 1e-5,
            "got {albedo}"
        );
        assert!(!clamped, "all in range");
        assert!(table.albedo(Vec3::new(-1.0, 0.0, 256.0)).1, "out of range");
    }
}
