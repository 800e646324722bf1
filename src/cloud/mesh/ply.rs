//! Vertices and faces of a PLY file.

use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use glam::DVec3;
use ply_rs::parser::{ParseError, Parser, Reader};
use ply_rs::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use super::Faces;
use crate::error::{Error, Result};
use crate::job::Job;

/// A header longer than this is not one, bytes.
const MAX_HEADER: u64 = 1 << 20;

/// Elements between two looks at the job.
const CHUNK: usize = 1 << 16;

/// What a mesh needs of a PLY file.
pub(super) struct PlyMesh {
    pub(super) vertices: Vec<DVec3>,
    pub(super) normals: Option<Vec<DVec3>>,
    pub(super) faces: Faces,
}

/// Reads a PLY file's vertices and faces.
pub(super) fn read(path: &Path, job: &Job) -> Result<PlyMesh> {
    let unreadable = |source| Error::Read {
        path: path.to_owned(),
        source,
    };
    // A pipe or a device would hang or never end.
    let facts = std::fs::metadata(path).map_err(unreadable)?;
    if !facts.is_file() {
        return Err(Error::cloud(
            path,
            "a mesh is read from an ordinary PLY file, not from a folder, pipe or device",
        ));
    }
    let file = File::open(path).map_err(unreadable)?;
    match catch_unwind(AssertUnwindSafe(|| parse(path, file, facts.len(), job))) {
        Ok(result) => result,
        Err(_) => Err(Error::cloud(
            path,
            "the PLY file is broken in a way that its decoder does not survive; export it again",
        )),
    }
}

fn parse(path: &Path, file: File, length: u64, job: &Job) -> Result<PlyMesh> {
    let mut reader = Reader::new(BufReader::new(file).take(MAX_HEADER));
    let header = Parser::<Vertex>::new()
        .read_header(&mut reader)
        .map_err(|e| {
            let at = e
                .line()
                .map_or(String::new(), |line| format!(" at line {line}"));
            Error::cloud(
                path,
                format!("its header is not that of a PLY file{at}; give a PLY file with faces"),
            )
        })?;
    check_header(path, &header, length)?;

    let mut reader = reader.into_inner().into_inner();
    let mut mesh = PlyMesh {
        vertices: Vec::new(),
        normals: None,
        faces: Faces::default(),
    };
    for element in header.elements.values() {
        let source = &mut Source {
            path,
            encoding: header.encoding,
            element,
            job,
        };
        match element.name.as_str() {
            "vertex" => {
                let with_normals = ["nx", "ny", "nz"]
                    .iter()
                    .all(|n| element.properties.contains_key(*n));
                mesh.vertices.reserve(element.count);
                let mut normals = Vec::with_capacity(if with_normals { element.count } else { 0 });
                source.each(&mut reader, |v: Vertex| {
                    mesh.vertices.push(v.position);
                    if with_normals {
                        normals.push(v.normal);
                    }
                })?;
                mesh.normals = with_normals.then_some(normals);
            }
            "face" => source.each(&mut reader, |f: Face| mesh.faces.push(&f.corners))?,
            _ => source.each(&mut reader, |_: Skipped| {})?,
        }
    }
    Ok(mesh)
}

/// Refuses counts that the file is too short for, before anything is allocated by them.
fn check_header(path: &Path, header: &Header, length: u64) -> Result<()> {
    let wrong = |problem: &str| Err(Error::cloud(path, problem));
    let scalar = |e: &ElementDef, name: &str| {
        matches!(
            e.properties.get(name).map(|p| &p.data_type),
            Some(PropertyType::Scalar(_))
        )
    };
    match header.elements.get("vertex") {
        Some(e) if ["x", "y", "z"].iter().all(|name| scalar(e, name)) => {}
        _ => {
            return wrong(
                "it has no vertices with x, y and z; give a PLY file with vertices and faces",
            );
        }
    }
    let list = |e: &ElementDef| {
        e.properties
            .values()
            .any(|p| is_corners(&p.name) && matches!(p.data_type, PropertyType::List(..)))
    };
    match header.elements.get("face") {
        Some(e) if e.count > 0 && list(e) => {}
        _ => {
            return wrong(
                "it has no faces, so it is a point cloud; give a PLY file with vertices and faces",
            );
        }
    }
    let mut needed = 0u128;
    for e in header.elements.values() {
        let bytes: u128 = match header.encoding {
            // A digit and a separator for each property.
            Encoding::Ascii => 2 * e.properties.len() as u128,
            Encoding::BinaryBigEndian | Encoding::BinaryLittleEndian => e
                .properties
                .values()
                .map(|p| match &p.data_type {
                    PropertyType::Scalar(t) | PropertyType::List(t, _) => size(t),
                })
                .sum(),
        };
        if bytes == 0 && e.count > 0 {
            return wrong(
                "its header announces elements without properties; export the mesh again",
            );
        }
        needed += bytes * e.count as u128;
    }
    // The last line of an ascii file may lack its line break.
    if needed > u128::from(length) + 1 {
        return wrong(
            "its header announces more elements than the file holds; it may be cut off, export or copy it again",
        );
    }
    Ok(())
}

fn size(scalar: &ScalarType) -> u128 {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

fn is_corners(name: &str) -> bool {
    matches!(name, "vertex_indices" | "vertex_index")
}

/// One kind of element of an open file.
struct Source<'a> {
    path: &'a Path,
    encoding: Encoding,
    element: &'a ElementDef,
    job: &'a Job,
}

impl Source<'_> {
    /// Reads the elements one by one, so that memory holds only what the mesh keeps.
    fn each<E: PropertyAccess>(
        &self,
        reader: &mut BufReader<File>,
        mut keep: impl FnMut(E),
    ) -> Result<()> {
        let parser = Parser::<E>::new();
        let count = self.element.count;
        let mut line = String::new();
        for index in 0..count {
            if index.is_multiple_of(CHUNK) {
                self.job
                    .progress("reading the mesh", index as u64, count as u64)?;
            }
            let element = match self.encoding {
                Encoding::Ascii => {
                    line.clear();
                    match reader.read_line(&mut line) {
                        Ok(0) => Err(ErrorKind::UnexpectedEof),
                        Ok(_) => parser.read_ascii_element(&line, self.element).map_err(kind),
                        Err(e) => Err(e.kind()),
                    }
                }
                Encoding::BinaryBigEndian => parser
                    .read_big_endian_element(reader, self.element)
                    .map_err(kind),
                Encoding::BinaryLittleEndian => parser
                    .read_little_endian_element(reader, self.element)
                    .map_err(kind),
            };
            keep(element.map_err(|kind| self.broken(kind, index))?);
        }
        Ok(())
    }

    fn broken(&self, kind: ErrorKind, index: usize) -> Error {
        let what = match self.element.name.as_str() {
            "vertex" => "vertex",
            "face" => "face",
            _ => "element",
        };
        let problem = if kind == ErrorKind::UnexpectedEof {
            format!(
                "it ends before {what} {} of {}; it may be cut off, export or copy it again",
                index + 1,
                self.element.count
            )
        } else {
            format!("{what} {} is broken; export the mesh again", index + 1)
        };
        Error::cloud(self.path, problem)
    }
}

#[expect(
    clippy::needless_pass_by_value,
    reason = "used as a function of map_err"
)]
fn kind(error: ParseError) -> ErrorKind {
    error.kind()
}

#[derive(Debug, Default)]
struct Vertex {
    position: DVec3,
    normal: DVec3,
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let target = match name {
            "x" => &mut self.position.x,
            "y" => &mut self.position.y,
            "z" => &mut self.position.z,
            "nx" => &mut self.normal.x,
            "ny" => &mut self.normal.y,
            "nz" => &mut self.normal.z,
            _ => return PropertyAccessResult::Ignored,
        };
        match number(&property) {
            Some(value) => *target = value,
            None => return PropertyAccessResult::UnsupportedType,
        }
        PropertyAccessResult::Set
    }
}

/// A scalar's value; `None` for a list.
fn number(property: &Property) -> Option<f64> {
    match *property {
        Property::Char(v) => Some(v.into()),
        Property::UChar(v) => Some(v.into()),
        Property::Short(v) => Some(v.into()),
        Property::UShort(v) => Some(v.into()),
        Property::Int(v) => Some(v.into()),
        Property::UInt(v) => Some(v.into()),
        Property::Float(v) => Some(v.into()),
        Property::Double(v) => Some(v),
        Property::ListChar(_)
        | Property::ListUChar(_)
        | Property::ListShort(_)
        | Property::ListUShort(_)
        | Property::ListInt(_)
        | Property::ListUInt(_)
        | Property::ListFloat(_)
        | Property::ListDouble(_) => None,
    }
}

#[derive(Debug, Default)]
struct Face {
    corners: Vec<u32>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !is_corners(name) {
            return PropertyAccessResult::Ignored;
        }
        match property.to_u32_list() {
            Some(corners) => self.corners = corners,
            None => return PropertyAccessResult::UnsupportedType,
        }
        PropertyAccessResult::Set
    }
}

/// An element that a mesh does not need.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}
