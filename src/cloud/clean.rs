//! What is done to the columns of a cloud before anything is made of them: moved, checked, brought into range.

use glam::{DMat4, DVec3, Mat3, Vec3};
use rayon::prelude::*;

use super::{MAX_SHININESS, RawCloud, Repairs};
use crate::error::{Error, Result};

/// Farther from 0 no survey reaches, and squares of distances would leave single precision.
const FARTHEST: f64 = 1e15;

/// Largest volume of a transformed unit cube, relative to a cuboid of the same edges, that is flat.
const FLAT: f64 = 1e-9;

/// Values beyond their range by less than this are rounding.
const VALUE_EPS: f32 = 1e-3;

/// Brings values into their ranges; counts those that were outside.
pub(super) fn clean(raw: &mut RawCloud, repairs: &mut Repairs) {
    if let Some(albedo) = &mut raw.albedo {
        repairs.values += albedo
            .par_iter_mut()
            .map(|rgb| u64::from(clamp_colour(rgb)))
            .sum::<u64>();
    }
    for (column, largest) in [
        (&mut raw.specular, 1.0),
        (&mut raw.shininess, MAX_SHININESS),
    ] {
        repairs.values += clamp_column(column, largest);
    }
    if let Some(radii) = &mut raw.radii {
        radii
            .par_iter_mut()
            .filter(|radius| !radius.is_finite() || **radius < 0.0)
            .for_each(|radius| *radius = 0.0);
    }
    if let Some(normals) = &mut raw.normals {
        normals
            .par_iter_mut()
            .for_each(|normal| *normal = normal.normalize_or_zero());
    }
}

pub(super) fn check_lengths(raw: &RawCloud, name: &str) -> Result<()> {
    let count = raw.len();
    let vectors = [&raw.normals, &raw.albedo]
        .into_iter()
        .flatten()
        .map(Vec::len);
    let scalars = [
        &raw.intensity,
        &raw.mirror,
        &raw.specular,
        &raw.shininess,
        &raw.radii,
    ];
    let scalars = scalars
        .into_iter()
        .flatten()
        .chain(raw.columns.values())
        .map(Vec::len);
    if vectors.chain(scalars).all(|length| length == count) {
        Ok(())
    } else {
        Err(Error::Setting(format!(
            "the columns of {name} are not all as long as its {count} positions"
        )))
    }
}

/// Why a transform cannot place a cloud, where it cannot.
pub(crate) fn transform_fault(scene_from_cloud: &DMat4) -> Option<&'static str> {
    let axes = glam::DMat3::from_mat4(*scene_from_cloud);
    let volume = axes.determinant();
    let edges = axes.x_axis.length() * axes.y_axis.length() * axes.z_axis.length();
    if !scene_from_cloud.is_finite() || !edges.is_finite() {
        Some("holds a number that is not finite or too large")
    } else if scene_from_cloud.row(3) != glam::DVec4::W {
        Some("must have 0, 0, 0, 1 as its last row; it moves, turns and scales")
    } else if volume.abs() <= FLAT * edges {
        Some("is singular and would flatten the cloud; its first three columns must span space")
    } else if volume < 0.0 {
        Some("mirrors the cloud (negative determinant); only motions and scalings are allowed")
    } else {
        None
    }
}

/// Normals turn by the inverse transpose; radii grow by the mean scale.
pub(super) fn move_directions(raw: &mut RawCloud, transform: &DMat4) {
    if let Some(normals) = &mut raw.normals {
        let matrix: Mat3 = glam::DMat3::from_mat4(*transform)
            .inverse()
            .transpose()
            .as_mat3();
        normals
            .par_iter_mut()
            .for_each(|normal| *normal = matrix * *normal);
    }
    if let Some(radii) = &mut raw.radii {
        let scale = transform.determinant().cbrt() as f32;
        radii.par_iter_mut().for_each(|radius| *radius *= scale);
    }
}

/// Whether a point is somewhere: finite, and no farther from 0 than 1e15.
pub(crate) fn is_sound(p: &DVec3) -> bool {
    p.is_finite() && p.abs().max_element() <= FARTHEST
}

/// Drops points without finite coordinates from every column and counts them; gives the index that the others had, where
/// some were dropped.
pub(super) fn drop_lost_points(raw: &mut RawCloud) -> Option<Vec<u32>> {
    let indices = 0..raw.len() as u32;
    let kept: Vec<bool> = raw.positions.par_iter().map(is_sound).collect();
    let lost = kept.iter().filter(|&&kept| !kept).count() as u64;
    if lost == 0 {
        return None;
    }
    raw.repairs.not_finite += lost;
    retain(&mut raw.positions, &kept);
    for column in [&mut raw.normals, &mut raw.albedo].into_iter().flatten() {
        retain(column, &kept);
    }
    let scalars = [
        &mut raw.intensity,
        &mut raw.mirror,
        &mut raw.specular,
        &mut raw.shininess,
        &mut raw.radii,
    ];
    for column in scalars
        .into_iter()
        .flatten()
        .chain(raw.columns.values_mut())
    {
        retain(column, &kept);
    }
    let still = indices.zip(kept);
    Some(
        still
            .filter_map(|(index, kept)| kept.then_some(index))
            .collect(),
    )
}

fn retain<T>(column: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    column.retain(|_| kept.next().copied().unwrap_or(false));
}

/// Brings a colour into range; says whether more than rounding was off.
fn clamp_colour(rgb: &mut Vec3) -> bool {
    let sound =
        rgb.is_finite() && rgb.min_element() >= -VALUE_EPS && rgb.max_element() <= 1.0 + VALUE_EPS;
    *rgb = if rgb.is_finite() {
        rgb.clamp(Vec3::ZERO, Vec3::ONE)
    } else {
        Vec3::ZERO
    };
    !sound
}

pub(super) fn clamp_column(column: &mut Option<Vec<f32>>, largest: f32) -> u64 {
    let values = column.iter_mut().flat_map(|column| column.iter_mut());
    let mut clamped = 0;
    for value in values {
        let sound = value.is_finite() && (-VALUE_EPS..=largest + VALUE_EPS).contains(value);
        *value = if value.is_nan() {
            0.0
        } else {
            value.clamp(0.0, largest)
        };
        clamped += u64::from(!sound);
    }
    clamped
}
