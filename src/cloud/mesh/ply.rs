//! Reads the vertices and faces of a PLY file, by the reader of clouds.

use std::io::{BufReader, Seek, SeekFrom};
use std::path::Path;

use glam::DVec3;
use ply_rs::ply::{PropertyType, ScalarType};

use super::Faces;
use crate::cloud::guard::{guarded, require_memory};
use crate::cloud::ply::body::{Body, LIST, Row};
use crate::cloud::ply::header::{Element, Header};
use crate::cloud::read::Source;
use crate::error::Result;
use crate::job::Job;

/// Numbers of a vertex, by slot; the first three must be there.
const VERTEX: [&str; 6] = ["x", "y", "z", "nx", "ny", "nz"];

/// Names under which the corners of a face go.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Memory of a vertex with its normal, while both are made unit length or averaged.
const BYTES_PER_VERTEX: u64 = 72;

/// Memory of a triangle: its corners in the file's faces and in the mesh, and where it ends.
const BYTES_PER_FACE: u64 = 32;

/// What a mesh needs of a PLY file.
pub(super) struct PlyMesh {
    pub(super) vertices: Vec<DVec3>,
    pub(super) normals: Option<Vec<DVec3>>,
    pub(super) faces: Faces,
}

/// Reads a PLY file's vertices and faces.
pub(super) fn read(path: &Path, job: &Job) -> Result<PlyMesh> {
    let source = Source::open(path)?;
    guarded(path, || parse(source, job))
}

fn parse(mut source: Source<'_>, job: &Job) -> Result<PlyMesh> {
    let header = Header::read(&mut source)?;
    header.check_counts(&source, header.elements().len())?;
    let vertices = header.points();
    let slots = VERTEX.map(|name| position(vertices, |n, t| n == name && is_scalar(t)));
    if slots.iter().take(3).any(Option::is_none) {
        return Err(source
            .error("it has no vertices with x, y and z; give a PLY file with vertices and faces"));
    }
    let is_face = |element: &Element| matches!(element.name(), "face" | "faces");
    let corners = header
        .elements()
        .iter()
        .find(|element| is_face(element) && element.def.count > 0)
        .and_then(|face| position(face, |n, t| CORNERS.contains(&n) && is_list_of_indices(t)))
        .ok_or_else(|| {
            source.error(
                "it has no faces that list their vertices by `vertex_indices`, so it is a point cloud; give a PLY \
                 file with vertices and faces",
            )
        })?;
    let face_count: usize = header
        .elements()
        .iter()
        .filter(|element| is_face(element))
        .map(|element| element.def.count)
        .sum();
    require_memory(
        "the mesh",
        vertices.def.count as u64 * BYTES_PER_VERTEX + face_count as u64 * BYTES_PER_FACE,
    )?;

    source
        .file
        .seek(SeekFrom::Start(header.length))
        .map_err(|e| source.io_error(e))?;
    let mut body = Body::new(BufReader::new(&source.file), &header, &source);
    let with_normals = slots.iter().all(Option::is_some);
    let mut mesh = PlyMesh {
        vertices: Vec::with_capacity(vertices.def.count),
        normals: with_normals.then(|| Vec::with_capacity(vertices.def.count)),
        faces: Faces::default(),
    };
    for (index, element) in header.elements().iter().enumerate() {
        if index == header.points_index() {
            let kept = element.renamed(|property| {
                let slot = slots.iter().position(|&slot| slot == Some(property));
                slot.map_or(format!("-{property}"), |slot| {
                    char::from(slot as u8).to_string()
                })
            });
            body.read(&kept, job, |record| {
                let &[x, y, z, nx, ny, nz, ..]: &Row = &record.row;
                mesh.vertices.push(DVec3::new(x, y, z));
                if let Some(normals) = &mut mesh.normals {
                    normals.push(DVec3::new(nx, ny, nz));
                }
                Ok(())
            })?;
        } else if is_face(element) {
            let kept = element.renamed(|property| {
                if property == corners {
                    LIST.to_owned()
                } else {
                    format!("-{property}")
                }
            });
            body.read(&kept, job, |record| {
                mesh.faces.push(&record.list);
                Ok(())
            })?;
        } else {
            body.read(element, job, |_| Ok(()))?;
        }
    }
    if let Some(last) = header.elements().iter().rfind(|e| e.def.count > 0) {
        body.finish(last)?;
    }
    Ok(mesh)
}

/// The first property of `element` that is as `wanted`, by its name (in small letters) and type.
fn position(element: &Element, wanted: impl Fn(&str, &PropertyType) -> bool) -> Option<usize> {
    element
        .names
        .iter()
        .zip(element.def.properties.values())
        .position(|(name, property)| wanted(&name.to_ascii_lowercase(), &property.data_type))
}

fn is_scalar(data_type: &PropertyType) -> bool {
    matches!(data_type, PropertyType::Scalar(_))
}

fn is_list_of_indices(data_type: &PropertyType) -> bool {
    matches!(
        data_type,
        PropertyType::List(
            _,
            ScalarType::Char
                | ScalarType::UChar
                | ScalarType::Short
                | ScalarType::UShort
                | ScalarType::Int
                | ScalarType::UInt
        )
    )
}
