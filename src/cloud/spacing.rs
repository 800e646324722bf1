//! The typical spacing of a cloud before it is prepared; mirrors put into a scene are sampled at it.

use glam::Vec3;

use super::neighbours::{Want, estimate};
use super::placed::is_sound;
use super::tint::percentile;
use super::{Bounds, PlacedCloud};
use crate::error::Result;
use crate::job::Job;

/// Points whose spacing is looked at; a median needs no more.
const SAMPLE: usize = 4096;

/// Median of the local spacing of a cloud, in the scene's unit, above 0: of its own radii where it has them, else
/// estimated at some of its points. A cloud without extent counts as one unit wide.
///
/// # Errors
/// [`crate::Error::Cancelled`], or [`crate::Error::NoPoints`] where no point has finite coordinates.
pub fn typical_spacing(cloud: &PlacedCloud, job: &Job) -> Result<f64> {
    let scale = cloud
        .transform
        .map_or(1.0, |transform| transform.determinant().abs().cbrt());
    let sound = |radius: &f32| *radius > 0.0 && radius.is_finite();
    let mut radii: Vec<f32> = match &cloud.raw.radii {
        Some(radii) => radii.iter().copied().filter(sound).collect(),
        None => estimated(cloud, job)?.into_iter().filter(sound).collect(),
    };
    if let Some(median) = percentile(&mut radii, 0.5) {
        return Ok(f64::from(median) * scale);
    }
    let finite = cloud.raw.positions.iter().copied().filter(is_sound);
    let extent = Bounds::of(finite).size().max_element();
    let extent = if extent > 0.0 && extent.is_finite() {
        extent
    } else {
        1.0
    };
    Ok(extent * scale / (cloud.raw.len().max(1) as f64).sqrt())
}

fn estimated(cloud: &PlacedCloud, job: &Job) -> Result<Vec<f32>> {
    let finite = || cloud.raw.positions.iter().copied().filter(is_sound);
    let centre = Bounds::of(finite()).centre();
    let positions: Vec<Vec3> = finite().map(|p| (p - centre).as_vec3()).collect();
    let mut radii = vec![0.0; positions.len()];
    let mut normals = vec![Vec3::ZERO; positions.len()];
    let step = positions.len().div_ceil(SAMPLE).max(1);
    let wanted = |index: usize| Want {
        spacing: index.is_multiple_of(step),
        normal: false,
    };
    estimate(&positions, wanted, &mut radii, &mut normals, job)?;
    Ok(radii)
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec3};

    use super::*;
    use crate::cloud::{Material, RawCloud};

    fn grid(radii: Option<Vec<f32>>) -> PlacedCloud {
        let positions =
            (0..10_000).map(|i| DVec3::new(f64::from(i % 100), f64::from(i / 100), 5e5));
        PlacedCloud {
            raw: RawCloud {
                positions: positions.collect(),
                radii,
                ..RawCloud::default()
            },
            transform: None,
            material: Material::default(),
            mirrors: Vec::new(),
            name: "grid".into(),
        }
    }

    #[test]
    fn the_spacing_of_a_square_grid_is_near_its_step() {
        let spacing = typical_spacing(&grid(None), &Job::default()).expect("a spacing");
        // The eighth neighbour of a square grid is a diagonal away: sqrt(2) * sqrt(pi / 8).
        assert!((spacing - 0.886).abs() < 0.01, "got {spacing}");
    }

    #[test]
    fn a_cloud_that_says_its_radii_is_believed_and_scaled() {
        let mut cloud = grid(Some(vec![0.25; 10_000]));
        cloud.transform = Some(DMat4::from_scale(DVec3::splat(2.0)));
        let spacing = typical_spacing(&cloud, &Job::default()).expect("a spacing");
        assert!((spacing - 0.5).abs() < 1e-9, "got {spacing}");
    }

    #[test]
    fn a_cloud_in_one_place_has_a_spacing_all_the_same() {
        let mut cloud = grid(None);
        cloud.raw.positions.truncate(1);
        let spacing = typical_spacing(&cloud, &Job::default()).expect("a spacing");
        assert!(spacing > 0.0, "got {spacing}");
    }
}
