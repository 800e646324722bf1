//! Albedo for clouds without colours: by intensity, or else by height.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// What lies below the first or above the second of these parts of all values is drawn as they are.
const STRETCH: [f64; 2] = [0.02, 0.98];

/// Linear albedo from the lowest to the highest points: dark and blue to light and warm, ever lighter.
const HEIGHT_COLOURS: [Vec3; 5] = [
    Vec3::new(0.04, 0.08, 0.30),
    Vec3::new(0.05, 0.30, 0.36),
    Vec3::new(0.22, 0.48, 0.18),
    Vec3::new(0.72, 0.58, 0.24),
    Vec3::new(0.90, 0.87, 0.82),
];

/// Albedo of points that cannot be told apart.
const PLAIN: Vec3 = Vec3::splat(0.8);

/// Grey by intensity, stretched between the 2nd and 98th percentile; `None` where these are the same.
pub(super) fn by_intensity(intensity: &[f32]) -> Option<Vec<Vec3>> {
    let stretched = stretch(intensity.to_vec())?;
    Some(
        intensity
            .par_iter()
            .map(|&value| Vec3::splat(stretched(value)))
            .collect(),
    )
}

/// Colours by height along `up`, stretched in the same way; plain grey where all points are of one height.
pub(super) fn by_height(positions: &[DVec3], up: DVec3) -> Vec<Vec3> {
    // Heights relative to the first point keep their digits in single precision.
    let base = positions.first().copied().unwrap_or_default();
    let heights: Vec<f32> = positions
        .par_iter()
        .map(|&p| (p - base).dot(up) as f32)
        .collect();
    match stretch(heights.clone()) {
        Some(stretched) => heights
            .par_iter()
            .map(|&height| ramp(stretched(height)))
            .collect(),
        None => vec![PLAIN; positions.len()],
    }
}

fn stretch(mut values: Vec<f32>) -> Option<impl Fn(f32) -> f32> {
    values.retain(|value| value.is_finite());
    let [low, high] = STRETCH.map(|part| percentile(&mut values, part));
    let (low, high) = (low?, high?);
    (high > low).then_some(move |value: f32| ((value - low) / (high - low)).clamp(0.0, 1.0))
}

/// The value below which the `part` of all values lies; reorders them.
pub(super) fn percentile(values: &mut [f32], part: f64) -> Option<f32> {
    let last = values.len().checked_sub(1)?;
    let index = ((last as f64 * part).round() as usize).min(last);
    Some(*values.select_nth_unstable_by(index, f32::total_cmp).1)
}

fn ramp(part: f32) -> Vec3 {
    let place = part * (HEIGHT_COLOURS.len() - 1) as f32;
    let below = (place as usize).min(HEIGHT_COLOURS.len() - 2);
    HEIGHT_COLOURS[below].lerp(HEIGHT_COLOURS[below + 1], place - below as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intensity_is_stretched_between_percentiles_whatever_the_outliers() {
        let mut intensity: Vec<f32> = (0..=1000).map(|i| 100.0 + i as f32).collect();
        intensity[0] = 60_000.0;
        let albedo = by_intensity(&intensity).unwrap();
        assert_eq!(albedo[0], Vec3::ONE);
        assert!(
            (albedo[500].x - 0.5).abs() < 0.01,
            "the middle is grey: {}",
            albedo[500]
        );
        assert_eq!(
            by_intensity(&[5.0; 10]),
            None,
            "equal intensities say nothing"
        );
    }

    #[test]
    fn height_runs_from_dark_to_light() {
        let positions: Vec<DVec3> = (0..100)
            .map(|i| DVec3::new(1e6, f64::from(i), 0.0))
            .collect();
        let albedo = by_height(&positions, DVec3::Y);
        assert_eq!(albedo[0], HEIGHT_COLOURS[0]);
        assert_eq!(albedo[99], HEIGHT_COLOURS[4]);
        assert_eq!(
            by_height(&positions, DVec3::Z),
            vec![PLAIN; 100],
            "all of one height"
        );
    }
}
