//! What a scene asks of its clouds before they are prepared: how large they are, for the camera, and how dense, for
//! the mirrors that it puts among them.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::neighbours::{Want, estimate};
use super::placed::is_sound;
use super::tint::percentile;
use super::{Bounds, PlacedCloud};
use crate::error::Result;
use crate::job::Job;

/// Points whose spacing is looked at; the median of so many is sure to a few percent.
const SAMPLES: usize = 4096;

/// The box of all points in the scene's frame, as [`super::Facts::bounds`] will say; `None` where no point has finite
/// coordinates.
pub fn bounds_of(clouds: &[PlacedCloud]) -> Option<Bounds> {
    let none = || Bounds::of([]);
    let bounds = clouds.iter().map(|cloud| {
        let points = in_scene(cloud).filter(is_sound).map(|p| Bounds::of([p]));
        points.reduce(none, Bounds::union)
    });
    bounds
        .reduce(Bounds::union)
        .filter(|bounds| bounds.min.is_finite())
}

/// The median of the local spacing of a cloud, in the scene's frame, by a sample of its points; `None` where fewer
/// than two points differ.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn typical_spacing(cloud: &PlacedCloud, job: &Job) -> Result<Option<f64>> {
    if let Some(radii) = &cloud.raw.radii {
        let scale = cloud
            .transform
            .map_or(1.0, |transform| transform.determinant().abs().cbrt());
        let mut radii: Vec<f32> = radii
            .iter()
            .copied()
            .filter(|r| r.is_finite() && *r > 0.0)
            .collect();
        if let Some(median) = percentile(&mut radii, 0.5) {
            return Ok(Some(f64::from(median) * scale));
        }
    }
    let Some(bounds) = bounds_of(std::slice::from_ref(cloud)) else {
        return Ok(None);
    };
    let centre = bounds.centre();
    let positions: Vec<Vec3> = in_scene(cloud)
        .filter(is_sound)
        .map(|p| (p - centre).as_vec3())
        .collect();
    let stride = positions.len().div_ceil(SAMPLES).max(1);
    let wanted = |index: usize| Want {
        spacing: index.is_multiple_of(stride),
        normal: false,
    };
    let mut radii = vec![0.0; positions.len()];
    let mut normals = vec![Vec3::ZERO; positions.len()];
    estimate(&positions, wanted, &mut radii, &mut normals, job)?;
    radii.retain(|&radius| radius > 0.0);
    Ok(percentile(&mut radii, 0.5).map(f64::from))
}

fn in_scene(cloud: &PlacedCloud) -> impl ParallelIterator<Item = DVec3> {
    let transform = cloud.transform;
    cloud
        .raw
        .positions
        .par_iter()
        .map(move |&p| transform.map_or(p, |transform| transform.transform_point3(p)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloud::RawCloud;
    use glam::DMat4;

    #[test]
    fn a_survey_agrees_with_what_is_prepared() {
        let mut positions: Vec<DVec3> = (0..40_000)
            .map(|i| DVec3::new(f64::from(i % 200), f64::from(i / 200), 0.0))
            .collect();
        positions[7] = DVec3::NAN;
        let cloud = PlacedCloud {
            raw: RawCloud {
                positions,
                ..RawCloud::default()
            },
            transform: Some(DMat4::from_scale(DVec3::splat(0.5))),
            material: Default::default(),
            mirrors: Vec::new(),
            name: "grid".to_owned(),
        };
        let job = Job::default();
        let bounds = bounds_of(std::slice::from_ref(&cloud));
        let spacing = typical_spacing(&cloud, &job).unwrap().unwrap_or_default();
        let facts = crate::cloud::prepare(vec![cloud], DVec3::Z, &job)
            .unwrap()
            .facts;
        assert_eq!(bounds, Some(facts.bounds));
        assert!(
            (spacing / facts.spacing - 1.0).abs() < 1e-5,
            "got {spacing}, expected {}",
            facts.spacing
        );
    }
}
