//! Triangle meshes: only ever sampled into points, never drawn.

mod ply;

use std::path::Path;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::job::Job;

/// A triangle mesh with a smooth normal at every vertex.
#[derive(Debug, Clone, PartialEq)]
pub struct TriangleMesh {
    vertices: Vec<DVec3>,
    normals: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    skipped: u64,
}

impl TriangleMesh {
    /// Reads the vertices and faces of a PLY file: ascii or binary, any scalar types, polygons fanned into triangles.
    ///
    /// The file's own vertex normals are used where every vertex has one; otherwise they are averaged from the
    /// faces around, weighted by angle.
    ///
    /// # Errors
    /// [`Error::Read`] where the file cannot be read, [`Error::Cloud`] where it is broken, no ordinary file, or has no
    /// face with an area, [`Error::Cancelled`] once the job is cancelled.
    pub fn read(path: &Path, job: &Job) -> Result<Self> {
        let file = ply::read(path, job)?;
        Self::new(file.vertices, file.normals, &file.faces)
            .map_err(|e| Error::cloud(path, e.to_string()))
    }

    /// A mesh from its vertices, their normals (or `None` to average them from the faces), and faces of three or
    /// more corners each, which are fanned into triangles from their first corner.
    ///
    /// # Errors
    /// [`Error::Setting`] where a face names a vertex that is not there, or no triangle has an area.
    pub fn new(vertices: Vec<DVec3>, normals: Option<Vec<DVec3>>, faces: &Faces) -> Result<Self> {
        let wrong = |what: String| Err(Error::Setting(what));
        // Fan the faces, leaving out what has no area.
        let (mut triangles, mut skipped) = (Vec::with_capacity(faces.len()), 0);
        for (number, face) in faces.iter().enumerate() {
            if let Some(corner) = face.iter().find(|&&c| c as usize >= vertices.len()) {
                return wrong(format!(
                    "face {} of the mesh names vertex {corner}, but there are {} vertices; export the mesh again",
                    number + 1,
                    vertices.len()
                ));
            }
            let mut kept = false;
            if let [first, rest @ ..] = face {
                for pair in rest.windows(2) {
                    if let [second, third] = *pair
                        && doubled_area(&vertices, [*first, second, third]).is_some()
                    {
                        triangles.push([*first, second, third]);
                        kept = true;
                    }
                }
            }
            skipped += u64::from(!kept);
        }
        if triangles.is_empty() {
            return wrong("the mesh has no face with an area; give a PLY file with faces".into());
        }

        // Normals: the file's, where all are sound.
        let given = normals.filter(|n| n.len() == vertices.len()).and_then(|n| {
            n.into_iter()
                .map(DVec3::try_normalize)
                .collect::<Option<Vec<_>>>()
        });
        let normals = given.unwrap_or_else(|| smooth_normals(&vertices, &triangles));
        Ok(Self {
            vertices,
            normals,
            triangles,
            skipped,
        })
    }

    /// Positions of the vertices.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Unit normals of the vertices; zero where no face meets.
    pub fn normals(&self) -> &[DVec3] {
        &self.normals
    }

    /// Corners of the triangles, as indices of vertices.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Number of faces that were left out, having no area or a corner that is not finite.
    pub fn skipped(&self) -> u64 {
        self.skipped
    }

    /// The mesh with every vertex moved by `place`, which must keep angles.
    pub(crate) fn with_places(&self, place: impl Fn(DVec3) -> DVec3) -> Self {
        let vertices = self.vertices.iter().map(|&v| place(v)).collect();
        Self {
            vertices,
            ..self.clone()
        }
    }

    /// Area of the triangles up to and including each.
    pub(crate) fn cumulative_area(&self) -> Vec<f64> {
        self.triangles
            .iter()
            .scan(0.0, |sum, &t| {
                *sum += doubled_area(&self.vertices, t).map_or(0.0, |n| n.length() / 2.0);
                Some(*sum)
            })
            .collect()
    }

    /// Position and unit normal in a triangle at barycentric `weights`. An index past the end means the last.
    pub(crate) fn interpolate(&self, triangle: usize, weights: DVec3) -> (DVec3, DVec3) {
        let Some(&corners) = self.triangles.get(triangle).or(self.triangles.last()) else {
            return (DVec3::ZERO, DVec3::ZERO);
        };
        let blend = |values: &[DVec3]| {
            let value = |c: u32| values.get(c as usize).copied().unwrap_or(DVec3::ZERO);
            let [a, b, c] = corners.map(value);
            a * weights.x + b * weights.y + c * weights.z
        };
        // Opposed normals may cancel; the face's own is left then.
        let face_normal = || doubled_area(&self.vertices, corners).and_then(DVec3::try_normalize);
        let normal = blend(&self.normals)
            .try_normalize()
            .or_else(face_normal)
            .unwrap_or(DVec3::ZERO);
        (blend(&self.vertices), normal)
    }
}

/// The faces of a mesh: lists of vertex indices, one after the other.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Faces {
    corners: Vec<u32>,
    ends: Vec<usize>,
}

impl Faces {
    /// Adds a face.
    pub fn push(&mut self, corners: &[u32]) {
        self.corners.extend_from_slice(corners);
        self.ends.push(self.corners.len());
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The corners of each face.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts
            .zip(&self.ends)
            .map(|(&start, &end)| self.corners.get(start..end).unwrap_or(&[]))
    }
}

/// Normal of a triangle, as long as twice its area; `None` where it has no area or a corner is not finite.
fn doubled_area(vertices: &[DVec3], triangle: [u32; 3]) -> Option<DVec3> {
    let [a, b, c] = triangle.map(|i| vertices.get(i as usize).copied().unwrap_or(DVec3::NAN));
    let normal = (b - a).cross(c - a);
    (normal.is_finite() && normal.length_squared() > 0.0).then_some(normal)
}

/// Normals of the faces around each vertex, averaged by the angle of their corner.
fn smooth_normals(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; vertices.len()];
    for &triangle in triangles {
        let Some(normal) = doubled_area(vertices, triangle).and_then(DVec3::try_normalize) else {
            continue;
        };
        let [a, b, c] = triangle;
        for (corner, next, last) in [(a, b, c), (b, c, a), (c, a, b)] {
            let at = |i: u32| vertices.get(i as usize).copied().unwrap_or(DVec3::ZERO);
            let angle = (at(next) - at(corner)).angle_between(at(last) - at(corner));
            if let Some(sum) = normals.get_mut(corner as usize) {
                *sum += normal * angle;
            }
        }
    }
    normals.into_iter().map(DVec3::normalize_or_zero).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> (Vec<DVec3>, Faces) {
        let vertices = (0..8u32)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect();
        let mut faces = Faces::default();
        for face in [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ] {
            faces.push(&face);
        }
        (vertices, faces)
    }

    #[test]
    fn quads_are_fanned_and_their_area_kept() {
        let (vertices, faces) = cube();
        let mesh = TriangleMesh::new(vertices, None, &faces).expect("a sound mesh");
        assert_eq!(mesh.triangles().len(), 12, "two triangles a face");
        let area = mesh.cumulative_area().last().copied();
        assert!(
            area.is_some_and(|a| (a - 6.0).abs() < 1e-12),
            "got {area:?}, expected 6"
        );
    }

    #[test]
    fn smooth_normals_of_a_cube_point_along_its_diagonals() {
        let (vertices, faces) = cube();
        let mesh = TriangleMesh::new(vertices, None, &faces).expect("a sound mesh");
        for (v, n) in mesh.vertices().iter().zip(mesh.normals()) {
            let expected = (*v - 0.5).normalize();
            assert!(
                (*n - expected).length() < 1e-12,
                "at {v}: got {n}, expected {expected}"
            );
        }
    }

    #[test]
    fn faces_without_area_are_skipped_and_counted() {
        let (vertices, mut faces) = cube();
        faces.push(&[0, 0, 1]);
        faces.push(&[0, 1]);
        faces.push(&[]);
        let mesh = TriangleMesh::new(vertices, None, &faces).expect("a sound mesh");
        assert_eq!(
            (mesh.skipped(), mesh.triangles().len()),
            (3, 12),
            "three of the faces have no area"
        );
    }

    #[test]
    fn a_face_that_names_a_missing_vertex_is_refused() {
        let (vertices, mut faces) = cube();
        faces.push(&[0, 1, 8]);
        let error = TriangleMesh::new(vertices, None, &faces)
            .expect_err("vertex 8 is not there")
            .to_string();
        assert!(
            error.contains("face 7") && error.contains("vertex 8"),
            "{error}"
        );
    }
}
