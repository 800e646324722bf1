//! Reading `[[mirror]]`: the shapes that are put into a scene.

use glam::{DVec2, DVec3};

use crate::cloud::generate::Shape;
use crate::error::Result;
use crate::scene::reader::{AMPLITUDE, Field, LENGTH};
use crate::scene::{MirrorShape, keys};

/// One `[[mirror]]`.
pub(super) fn read(field: &Field<'_>) -> Result<MirrorShape> {
    // The shape decides which keys there are.
    let all: Vec<&str> = keys::SHAPES
        .iter()
        .flat_map(|(_, keys)| keys.iter().copied())
        .chain(["shape"])
        .collect();
    let names: Vec<&'static str> = keys::SHAPES.iter().map(|(name, _)| *name).collect();
    let shape = field
        .table(&all)?
        .required("shape", "\"sphere\"")?
        .choice(&names)?;
    let own = keys::SHAPES
        .iter()
        .find(|(name, _)| *name == shape)
        .map_or(&[][..], |(_, keys)| keys);
    let known: Vec<&str> = own.iter().copied().chain(["shape"]).collect();
    let table = field.table(&known)?;

    let point = |key| table.required(key, "[x, y, z]")?.point();
    let direction = |key| table.required(key, "[x, y, z]")?.direction();
    let length = |key| table.required(key, "0.5")?.number(&LENGTH);
    Ok(MirrorShape::Shape(match shape {
        "plane" => {
            let normal = direction("normal")?;
            let up = match table.get("up") {
                Some(up) if up.direction()?.cross(normal).length() < 1e-6 => {
                    return up.error("points along the normal; it must lie across it");
                }
                Some(up) => up.direction()?,
                None => {
                    if normal.y.abs() < 0.9 {
                        DVec3::Y
                    } else {
                        DVec3::Z
                    }
                }
            };
            let size = table
                .required("size", "[width, height]")?
                .numbers("[width, height]", &LENGTH)?;
            // One that lies across, but for rounding, stays as it is.
            let up = if up.dot(normal).abs() < 4.0 * f64::EPSILON {
                up
            } else {
                up.reject_from_normalized(normal).normalize_or(up)
            };
            Shape::Plane {
                centre: point("centre")?,
                normal,
                up,
                size: DVec2::from_array(size),
            }
        }
        "sphere" => Shape::Sphere {
            centre: point("centre")?,
            radius: length("radius")?,
        },
        "paraboloid" => Shape::Paraboloid {
            vertex: point("vertex")?,
            axis: direction("axis")?,
            focal_length: length("focal_length")?,
            rim_radius: length("rim_radius")?,
        },
        "torus" => {
            let (major_radius, minor_radius) = (length("major_radius")?, length("minor_radius")?);
            if minor_radius >= major_radius {
                return table
                    .required("minor_radius", "0.1")?
                    .error("must be less than major_radius");
            }
            Shape::Torus {
                centre: point("centre")?,
                axis: direction("axis")?,
                major_radius,
                minor_radius,
            }
        }
        "blob" => Shape::Blob {
            centre: point("centre")?,
            radius: length("radius")?,
            amplitude: table
                .optional("amplitude", |f| f.number(&AMPLITUDE))?
                .unwrap_or(0.25),
        },
        "bumps" => Shape::Bumps {
            centre: point("centre")?,
            radius: length("radius")?,
        },
        _ => {
            let path = table.required("path", "\"FILE.ply\"")?.path()?;
            return Ok(MirrorShape::Mesh { path });
        }
    }))
}
