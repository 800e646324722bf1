//! Reads NumPy's `.npz` archives: zip files of `.npy` arrays, stored or deflated.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

/// The arrays of an archive by name: element type as NumPy spells it, and bytes in C order.
pub(crate) struct Npz(BTreeMap<String, (String, Vec<u8>)>);

impl Npz {
    pub(crate) fn open(path: &Path) -> Result<Self, String> {
        let bytes =
            std::fs::read(path).map_err(|e| format!("cannot read {}: {e}", path.display()))?;
        let end = bytes
            .windows(4)
            .rposition(|w| w == b"PK\x05\x06")
            .ok_or("no end of a zip directory")?;
        let (count, mut at) = (short(&bytes, end + 10)?, long(&bytes, end + 16)?);
        let mut arrays = BTreeMap::new();
        for _ in 0..count {
            // Walk the directory at the end: the sizes in front of the data may be left out.
            let (method, packed) = (short(&bytes, at + 10)?, long(&bytes, at + 20)?);
            let (name_length, extra, comment) = (
                short(&bytes, at + 28)?,
                short(&bytes, at + 30)?,
                short(&bytes, at + 32)?,
            );
            let local = long(&bytes, at + 42)?;
            let text = bytes
                .get(at + 46..at + 46 + name_length)
                .ok_or("a cut name")?;
            let start = local + 30 + short(&bytes, local + 26)? + short(&bytes, local + 28)?;
            let data = bytes.get(start..start + packed).ok_or("a cut member")?;
            let data = match method {
                0 => data.to_vec(),
                8 => {
                    let mut out = Vec::new();
                    let mut inflate = flate2::read::DeflateDecoder::new(data);
                    inflate.read_to_end(&mut out).map_err(|e| e.to_string())?;
                    out
                }
                other => return Err(format!("zip method {other} is not read")),
            };
            let name = String::from_utf8_lossy(text)
                .trim_end_matches(".npy")
                .to_string();
            arrays.insert(name, array(&data)?);
            at += 46 + name_length + extra + comment;
        }
        Ok(Self(arrays))
    }

    /// An array of 32- or 16-bit floats.
    pub(crate) fn floats(&self, name: &str) -> Result<Vec<f32>, String> {
        if let Ok(bytes) = self.of_type(name, "<f2") {
            return Ok(bytes
                .as_chunks()
                .0
                .iter()
                .map(|b| half(u16::from_le_bytes(*b)))
                .collect());
        }
        let bytes = self.of_type(name, "<f4")?;
        Ok(bytes
            .as_chunks()
            .0
            .iter()
            .map(|b| f32::from_le_bytes(*b))
            .collect())
    }

    /// An array of float triples.
    pub(crate) fn vectors(&self, name: &str) -> Result<Vec<glam::DVec3>, String> {
        let floats = self.floats(name)?;
        Ok(floats
            .as_chunks()
            .0
            .iter()
            .map(|&v: &[f32; 3]| glam::Vec3::from(v).as_dvec3())
            .collect())
    }

    /// An array of bytes.
    pub(crate) fn bytes(&self, name: &str) -> Result<&[u8], String> {
        self.of_type(name, "|u1")
    }

    fn of_type(&self, name: &str, expected: &str) -> Result<&[u8], String> {
        match self.0.get(name) {
            Some((found, bytes)) if found == expected => Ok(bytes),
            Some((found, _)) => Err(format!("{name} is {found}, not {expected}")),
            None => Err(format!("there is no array {name}")),
        }
    }
}

/// A 16-bit float.
fn half(bits: u16) -> f32 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    let size = match exponent {
        0 => fraction * 2f32.powi(-24),
        31 => f32::NAN,
        _ => (1024.0 + fraction) * 2f32.powi(exponent - 25),
    };
    if bits >> 15 == 1 { -size } else { size }
}

/// Element type and data of one `.npy` file.
fn array(npy: &[u8]) -> Result<(String, Vec<u8>), String> {
    let length = match npy.get(..8) {
        Some(b"\x93NUMPY\x01\x00") => short(npy, 8)?,
        _ => return Err("only version 1 of the npy format is read".into()),
    };
    let header = npy.get(10..10 + length).ok_or("a cut npy header")?;
    let header = String::from_utf8_lossy(header);
    if !header.contains("'fortran_order': False") {
        return Err("only arrays in C order are read".into());
    }
    let kind = header
        .split("'descr': '")
        .nth(1)
        .and_then(|rest| rest.split('\'').next());
    Ok((
        kind.ok_or("no element type")?.into(),
        npy[10 + length..].to_vec(),
    ))
}

fn short(bytes: &[u8], at: usize) -> Result<usize, String> {
    let b = bytes.get(at..at + 2).ok_or("a cut zip file")?;
    Ok(usize::from(b[0]) | usize::from(b[1]) << 8)
}

fn long(bytes: &[u8], at: usize) -> Result<usize, String> {
    Ok(short(bytes, at)? | short(bytes, at + 2)? << 16)
}
