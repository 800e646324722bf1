//! One cloud in the scene's frame: moved, cleaned, coloured, its mirrors found.

use glam::{DMat4, DVec3, Mat3, Vec3};
use rayon::prelude::*;

use super::rules::mirror_column;
use super::tint::{by_height, by_intensity};
use super::{Bounds, CloudFacts, MAX_SHININESS, Material, PlacedCloud, RawCloud, Repairs, UpAxis};
use crate::error::{Error, Result};

/// Farther from 0 no survey reaches, and squares of distances would leave single precision.
const FARTHEST: f64 = 1e15;

/// Smallest volume of a transformed unit cube, as a part of its longest edge's cube, that is not flat.
const FLAT: f64 = 1e-12;

/// Values beyond their range by less than this are rounding.
const VALUE_EPS: f32 = 1e-3;

/// A cloud in the scene's frame. All columns are as long as `positions`.
pub(super) struct Placed {
    pub(super) positions: Vec<DVec3>,
    /// Unit length, or zero where the file's was unusable.
    pub(super) normals: Option<Vec<Vec3>>,
    pub(super) albedo: Vec<Vec3>,
    pub(super) mirror: Option<Vec<f32>>,
    pub(super) specular: Option<Vec<f32>>,
    pub(super) shininess: Option<Vec<f32>>,
    /// In the scene's frame; 0 where the file's was unusable.
    pub(super) radii: Option<Vec<f32>>,
    pub(super) material: Material,
    /// Index in the order of all sources.
    pub(super) source: Vec<u32>,
    pub(super) bounds: Bounds,
    pub(super) repairs: Repairs,
    pub(super) facts: CloudFacts,
}

/// Places a cloud whose first point has the index `first` among all sources.
pub(super) fn place(cloud: PlacedCloud, first: u32) -> Result<Placed> {
    let PlacedCloud {
        mut raw,
        transform,
        material,
        mirrors,
        name,
    } = cloud;
    check_lengths(&raw, &name)?;
    if let Some(transform) = transform {
        check_transform(&transform, &name)?;
        raw.positions
            .par_iter_mut()
            .for_each(|p| *p = transform.transform_point3(*p));
        move_directions(&mut raw, &transform);
    }
    let source = drop_lost_points(&mut raw, first);
    let mut repairs = raw.repairs;

    let mut mirror = mirror_column(&raw, &raw.positions, &mirrors, &name)?;
    let facts = CloudFacts {
        name,
        format: raw.format.clone(),
        points: raw.len() as u64,
        has_colour: raw.albedo.is_some(),
        has_normals: raw.normals.is_some(),
        has_intensity: raw.intensity.is_some(),
        column_names: std::mem::take(&mut raw.column_names),
        unit: raw.unit.take(),
        up_axis: raw.up_axis,
    };
    let mut albedo = match (
        raw.albedo.take(),
        raw.intensity.as_deref().and_then(by_intensity),
    ) {
        (Some(albedo), _) | (None, Some(albedo)) => albedo,
        (None, None) => by_height(&raw.positions, raw.up_axis.unwrap_or(UpAxis::Z).vector()),
    };
    repairs.values += albedo
        .par_iter_mut()
        .map(|rgb| u64::from(clamp_colour(rgb)))
        .sum::<u64>();
    for (column, largest) in [
        (&mut mirror, 1.0),
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
    let bounds = bounds_of(&raw.positions);
    Ok(Placed {
        positions: raw.positions,
        normals: raw.normals,
        albedo,
        mirror,
        specular: raw.specular,
        shininess: raw.shininess,
        radii: raw.radii,
        material,
        source,
        bounds,
        repairs,
        facts,
    })
}

fn bounds_of(positions: &[DVec3]) -> Bounds {
    let none = || Bounds::of([]);
    positions
        .par_chunks(1 << 14)
        .map(|chunk| Bounds::of(chunk.iter().copied()))
        .reduce(none, Bounds::union)
}

fn check_lengths(raw: &RawCloud, name: &str) -> Result<()> {
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

fn check_transform(transform: &DMat4, name: &str) -> Result<()> {
    let refuse = |why: &str| Err(Error::Setting(format!("the transform of {name} {why}")));
    let longest = transform
        .x_axis
        .length()
        .max(transform.y_axis.length())
        .max(transform.z_axis.length());
    let volume = transform.determinant();
    if !transform.is_finite() {
        refuse("holds a number that is not finite")
    } else if transform.row(3) != glam::DVec4::W {
        refuse("is not affine; its last row must be 0 0 0 1")
    } else if volume.abs() <= FLAT * longest.powi(3) {
        refuse("flattens it (it is singular); every axis must keep some length")
    } else if volume < 0.0 {
        refuse("mirrors it; turn one of its axes")
    } else {
        Ok(())
    }
}

/// Normals turn by the inverse transpose; radii grow by the mean scale.
fn move_directions(raw: &mut RawCloud, transform: &DMat4) {
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

/// Whether a point is somewhere.
fn is_sound(p: &DVec3) -> bool {
    p.is_finite() && p.abs().max_element() <= FARTHEST
}

/// Drops points without finite coordinates from every column and counts them; gives the source index of the others.
fn drop_lost_points(raw: &mut RawCloud, first: u32) -> Vec<u32> {
    let indices = first..first + raw.len() as u32;
    let kept: Vec<bool> = raw.positions.par_iter().map(is_sound).collect();
    let lost = kept.iter().filter(|&&kept| !kept).count() as u64;
    if lost == 0 {
        return indices.collect();
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
    indices
        .zip(kept)
        .filter_map(|(index, kept)| kept.then_some(index))
        .collect()
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

fn clamp_column(column: &mut Option<Vec<f32>>, largest: f32) -> u64 {
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
