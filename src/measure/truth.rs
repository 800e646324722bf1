//! What somebody else says that mirrors show, or how bright the picture is: NumPy archives and OpenEXR pictures.
//!
//! An archive (.npz) holds arrays of a value per pixel, row by row from the top: `mirror` (u8, above 0 on mirrors), `P`
//! (the mirror's point), `Q` (where the reflected ray ends), `Qid` (u8, from 10 on a mirror again) and `Qalb` (linear
//! albedo there), vectors being the last axis of 3. A picture (.exr) holds linear radiance as R, G and B.

use std::io::{Cursor, Read as _};
use std::path::Path;

use glam::{DVec3, UVec2, Vec4};

use super::quality::{Reference, Seen, Wanted};
use crate::camera::MAX_SIZE;
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::output::ExrImage;

/// Largest file that is read, bytes; pictures of the largest size are smaller.
const MAX_FILE_BYTES: u64 = 4 << 30;

/// The first id of what is a mirror in `Qid`.
const MIRROR_AGAIN: u8 = 10;

/// What somebody else says.
#[derive(Debug, Clone, PartialEq)]
pub enum Truth {
    /// Of what mirrors show.
    Mirrors(Reference),
    /// Of radiance, W/sr/m2; alpha is 1 everywhere.
    Picture(Grid<Vec4>),
}

impl Truth {
    /// Reads a file, whose ending says what it is.
    ///
    /// # Errors
    /// [`Error::Read`] where it cannot be read, [`Error::Setting`] where it is of another kind or damaged.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = read(path)?;
        let refused = |problem: String| Error::Setting(format!("{}: {problem}", path.display()));
        let is = |ending: &str| {
            path.extension()
                .is_some_and(|e| e.eq_ignore_ascii_case(ending))
        };
        if is("npz") {
            mirrors(&bytes).map(Self::Mirrors).map_err(refused)
        } else if is("exr") {
            picture(&bytes).map(Self::Picture).map_err(refused)
        } else {
            Err(refused(
                "a truth is an .npz archive or an .exr picture; docs/MEASURING.md says what they hold"
                    .to_owned(),
            ))
        }
    }

    /// Width and height, pixels.
    pub fn size(&self) -> UVec2 {
        match self {
            Self::Mirrors(reference) => reference.size(),
            Self::Picture(radiance) => radiance.size(),
        }
    }
}

fn read(path: &Path) -> Result<Vec<u8>> {
    let unreadable = |source| Error::Read {
        path: path.into(),
        source,
    };
    let found = std::fs::metadata(path).map_err(unreadable)?;
    if !found.is_file() || found.len() > MAX_FILE_BYTES {
        return Err(Error::Setting(format!(
            "{} is no file, or larger than 4 GiB; give an .npz archive or an .exr picture",
            path.display()
        )));
    }
    std::fs::read(path).map_err(unreadable)
}

fn picture(bytes: &[u8]) -> Result<Grid<Vec4>, String> {
    let image = ExrImage::decode(bytes).map_err(|e| e.to_string())?;
    let channel = |name: &str| {
        image
            .channels
            .get(name)
            .ok_or_else(|| format!("there is no channel {name}; a picture has R, G and B"))
    };
    let (r, g, b) = (channel("R")?, channel("G")?, channel("B")?);
    let pixels = r
        .iter()
        .zip(g)
        .zip(b)
        .map(|((&r, &g), &b)| Vec4::new(r, g, b, 1.0));
    Grid::from_vec(image.size, pixels.collect()).ok_or_else(|| "a channel is cut short".to_owned())
}

fn mirrors(bytes: &[u8]) -> Result<Reference, String> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let mut array = |name: &str| Array::read(&mut archive, name);
    let mirror = array("mirror")?;
    let size = mirror.size;
    let (ids, points) = (array("Qid")?, array("P")?);
    let (positions, albedo) = (array("Q")?, array("Qalb")?);
    for (other, of, depth) in [
        (&mirror, "mirror", 1),
        (&ids, "Qid", 1),
        (&points, "P", 3),
        (&positions, "Q", 3),
        (&albedo, "Qalb", 3),
    ] {
        if other.size != size || other.depth != depth {
            return Err(format!("the shape of {of} does not fit to that of mirror"));
        }
    }
    let of_mirror: Vec<bool> = mirror.values.iter().map(|&m| m > 0.0).collect();
    let wanted = |i: usize| Wanted {
        point: points.vector(i),
        seen: Seen {
            position: positions.vector(i),
            albedo: albedo.vector(i),
        },
        wall: ids
            .values
            .get(i)
            .is_some_and(|&id| id < f64::from(MIRROR_AGAIN)),
    };
    let pixels = (of_mirror.iter().enumerate()).map(|(i, &m)| {
        let wanted = wanted(i);
        (m && wanted.point.is_finite() && wanted.seen.position.is_finite()).then_some(wanted)
    });
    let pixels = pixels.collect();
    Ok(Reference::new(size, of_mirror, pixels))
}

/// An array of an archive.
struct Array {
    /// Width and height, pixels.
    size: UVec2,
    /// Values per pixel.
    depth: usize,
    values: Vec<f64>,
}

impl Array {
    /// The array `name`, of numbers of 1 to 4 bytes.
    fn read(archive: &mut zip::ZipArchive<Cursor<&[u8]>>, name: &str) -> Result<Self, String> {
        let member = archive
            .by_name(&format!("{name}.npy"))
            .map_err(|e| format!("{name}: {e}"))?;
        // The header is read first and says how many bytes may follow, whatever the archive claims.
        let mut member = member.take(MAX_FILE_BYTES);
        let npy = npyz::NpyFile::new(&mut member).map_err(|e| format!("{name}: {e}"))?;
        let (height, width, depth) = match *npy.shape() {
            [height, width] => (height, width, 1),
            [height, width, depth] => (height, width, depth),
            _ => return Err(format!("{name} has not the shape of a picture")),
        };
        let side = 1..=u64::from(MAX_SIZE);
        if !side.contains(&height) || !side.contains(&width) || !(1..=4).contains(&depth) {
            return Err(format!("{name} has not the shape of a picture"));
        }
        if npy.order() != npyz::Order::C {
            return Err(format!("{name} is not in C order"));
        }
        crate::cloud::require_memory("the truth", width * height * depth * 16)
            .map_err(|e| e.to_string())?;
        let values = values(npy).map_err(|e| format!("{name}: {e}"))?;
        Ok(Self {
            size: UVec2::new(width as u32, height as u32),
            depth: depth as usize,
            values,
        })
    }

    fn vector(&self, pixel: usize) -> DVec3 {
        let of = |c: usize| self.values.get(3 * pixel + c).copied().unwrap_or(f64::NAN);
        DVec3::new(of(0), of(1), of(2))
    }
}

fn values<R: std::io::Read>(npy: npyz::NpyFile<R>) -> Result<Vec<f64>, String> {
    fn all<T: npyz::Deserialize, R: std::io::Read>(
        npy: npyz::NpyFile<R>,
        number: impl Fn(T) -> f64,
    ) -> Result<Vec<f64>, String> {
        let values = npy.data::<T>().map_err(|e| e.to_string())?;
        values
            .map(|v| v.map(&number).map_err(|e| e.to_string()))
            .collect()
    }
    match npy.dtype().descr().trim_matches('\'') {
        "|u1" => all::<u8, R>(npy, f64::from),
        "<f2" => all::<exr::prelude::f16, R>(npy, |v| v.to_f64()),
        "<f4" => all::<f32, R>(npy, f64::from),
        "<f8" => all::<f64, R>(npy, |v| v),
        other => Err(format!(
            "numbers of the kind {} are not read; write u1, f2, f4 or f8",
            crate::text::short_name(other)
        )),
    }
}
