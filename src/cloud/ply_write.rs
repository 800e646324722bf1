//! Writes PLY: binary little endian, linear float colours.

use std::io::Write;
use std::path::Path;

use glam::DVec3;

use super::{RawCloud, UpAxis};
use crate::error::{Error, Result};
use crate::job::Job;

/// Points between two looks at the job.
const CHUNK: usize = 1 << 16;

/// Rounding of coordinates that does not count, as a part of the cloud's size.
const ROUNDING: f64 = 1e-7;

/// Columns with fixed names that hold one number a point.
type Scalars<'a> = Vec<(&'a str, &'a [f32])>;

/// Writes `cloud` to `out` as PLY; `path` is only named in errors.
///
/// Coordinates are `float`, or `double` where that would lose digits that matter: more than half a quantum of the
/// file they came from, or 1e-7 of the cloud's size. Colours are linear `float`. Every column that the cloud has is
/// written, and `comment up_axis y` or `z` where it has one.
///
/// # Errors
/// [`Error::Write`] with what `out` says, [`Error::Cancelled`].
pub fn write_ply(out: &mut dyn Write, path: &Path, cloud: &RawCloud, job: &Job) -> Result<()> {
    let write_error = |source| Error::Write {
        path: path.to_owned(),
        source,
    };
    let doubles = needs_doubles(cloud);
    let scalars = scalars_of(cloud);
    out.write_all(header(cloud, doubles, &scalars).as_bytes())
        .map_err(write_error)?;

    let count = cloud.len();
    let mut bytes = Vec::new();
    for (index, position) in cloud.positions.iter().enumerate() {
        if index % CHUNK == 0 {
            job.progress("writing", index as u64, count as u64)?;
            out.write_all(&bytes).map_err(write_error)?;
            bytes.clear();
        }
        for value in position.to_array() {
            if doubles {
                bytes.extend_from_slice(&value.to_le_bytes());
            } else {
                bytes.extend_from_slice(&(value as f32).to_le_bytes());
            }
        }
        for column in [&cloud.normals, &cloud.albedo].into_iter().flatten() {
            let vector = column.get(index).copied().unwrap_or_default();
            bytes.extend(vector.to_array().into_iter().flat_map(f32::to_le_bytes));
        }
        for (_, column) in &scalars {
            bytes.extend_from_slice(&column.get(index).copied().unwrap_or_default().to_le_bytes());
        }
    }
    out.write_all(&bytes).map_err(write_error)?;
    out.flush().map_err(write_error)?;
    job.progress("writing", count as u64, count as u64)
}

fn header(cloud: &RawCloud, doubles: bool, scalars: &Scalars<'_>) -> String {
    let mut header = String::from("ply\nformat binary_little_endian 1.0\n");
    match cloud.up_axis {
        Some(UpAxis::Y) => header.push_str("comment up_axis y\n"),
        Some(UpAxis::Z) => header.push_str("comment up_axis z\n"),
        None => {}
    }
    header.push_str(&format!("element vertex {}\n", cloud.len()));
    let coordinate = if doubles { "double" } else { "float" };
    let mut property =
        |scalar: &str, name: &str| header.push_str(&format!("property {scalar} {name}\n"));
    for name in ["x", "y", "z"] {
        property(coordinate, name);
    }
    if cloud.normals.is_some() {
        ["nx", "ny", "nz"]
            .iter()
            .for_each(|name| property("float", name));
    }
    if cloud.albedo.is_some() {
        ["red", "green", "blue"]
            .iter()
            .for_each(|name| property("float", name));
    }
    for (name, _) in scalars {
        property("float", &identifier(name));
    }
    header.push_str("end_header\n");
    header
}

fn scalars_of(cloud: &RawCloud) -> Scalars<'_> {
    let known = [
        ("mirror", &cloud.mirror),
        ("specular", &cloud.specular),
        ("shininess", &cloud.shininess),
        ("radius", &cloud.radii),
        ("intensity", &cloud.intensity),
    ];
    let mut scalars: Scalars<'_> = known
        .into_iter()
        .filter_map(|(name, column)| Some((name, column.as_deref()?)))
        .collect();

    // A rule's column may be one of those above, or a coordinate.
    const TAKEN: [&str; 9] = ["x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"];
    for (name, column) in &cloud.columns {
        let taken = TAKEN
            .iter()
            .copied()
            .chain(scalars.iter().map(|(name, _)| *name));
        if !taken
            .into_iter()
            .any(|taken| taken.eq_ignore_ascii_case(name))
        {
            scalars.push((name, column));
        }
    }
    scalars
}

/// A property name that every reader understands.
fn identifier(name: &str) -> String {
    let name: String = name
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
        .collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
        name
    } else {
        format!("_{name}")
    }
}

/// Whether `float` coordinates would lose digits that matter.
fn needs_doubles(cloud: &RawCloud) -> bool {
    let finite = || cloud.positions.iter().copied().filter(|p| p.is_finite());
    if finite().all(|p| p.as_vec3().as_dvec3() == p) {
        return false;
    }
    let (min, max) = finite().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| {
        (min.min(p), max.max(p))
    });
    let allowed = match cloud.scale {
        Some(scale) => scale.min_element() / 2.0,
        None => (max - min).max_element() * ROUNDING,
    };
    let rounding = min.abs().max(max.abs()).max_element() * f64::from(f32::EPSILON) / 2.0;
    rounding > allowed
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud_at(positions: Vec<DVec3>) -> RawCloud {
        RawCloud {
            positions,
            ..RawCloud::default()
        }
    }

    #[test]
    fn doubles_are_written_where_floats_would_lose_digits() {
        let near = cloud_at(vec![DVec3::new(-1.0, 0.1, 0.0), DVec3::new(1.0, 0.0, 0.3)]);
        assert!(
            !needs_doubles(&near),
            "a room around the origin fits floats"
        );
        let far = cloud_at(vec![
            DVec3::new(636_001.76, 848_935.2, 0.0),
            DVec3::new(637_001.0, 849_000.0, 9.0),
        ]);
        assert!(needs_doubles(&far), "state plane coordinates do not");
        let exact = cloud_at(vec![DVec3::splat(1_000_000.5), DVec3::splat(1_000_001.0)]);
        assert!(
            !needs_doubles(&exact),
            "floats that hold every digit are enough"
        );
    }

    #[test]
    fn odd_names_become_identifiers() {
        assert_eq!(identifier("Illuminance (PCV)"), "Illuminance__PCV_");
        assert_eq!(identifier("2nd"), "_2nd");
    }
}
