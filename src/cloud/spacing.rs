//! The typical spacing of a cloud; mirrors put into a scene are sampled at it.

use super::CloudPoints;
use super::tint::percentile;

/// Points whose spacing is looked at; a median needs no more.
const SAMPLE: usize = 4096;

impl CloudPoints {
    /// Median of the local spacing, in the scene's unit, above 0; `None` where there is no point.
    pub fn typical_spacing(&self) -> Option<f64> {
        let step = self.radii.len().div_ceil(SAMPLE).max(1);
        let mut radii: Vec<f32> = self.radii.iter().copied().step_by(step).collect();
        percentile(&mut radii, 0.5).map(f64::from)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec3};

    use super::*;
    use crate::cloud::RawCloud;
    use crate::job::Job;

    fn grid(count: i32, radii: Option<Vec<f32>>, transform: Option<DMat4>) -> CloudPoints {
        let positions = (0..count).map(|i| DVec3::new(f64::from(i % 100), f64::from(i / 100), 5e5));
        let raw = RawCloud {
            positions: positions.collect(),
            radii,
            ..RawCloud::default()
        };
        CloudPoints::new(raw, transform.as_ref(), "grid", &Job::default()).expect("points")
    }

    #[test]
    fn the_spacing_of_a_square_grid_is_near_its_step() {
        let spacing = grid(10_000, None, None)
            .typical_spacing()
            .expect("a spacing");
        // The eighth neighbour of a square grid is a diagonal away: sqrt(2) * sqrt(pi / 8).
        assert!((spacing - 0.886).abs() < 0.01, "got {spacing}");
    }

    #[test]
    fn a_cloud_that_says_its_radii_is_believed_and_scaled() {
        let larger = DMat4::from_scale(DVec3::splat(2.0));
        let cloud = grid(10_000, Some(vec![0.25; 10_000]), Some(larger));
        let spacing = cloud.typical_spacing().expect("a spacing");
        assert!((spacing - 0.5).abs() < 1e-9, "got {spacing}");
    }

    #[test]
    fn a_cloud_in_one_place_has_a_spacing_all_the_same() {
        let spacing = grid(1, None, None).typical_spacing().expect("a spacing");
        assert!(spacing > 0.0, "got {spacing}");
    }
}
