//! Opening a point file of any kind that is read.

use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

use super::guard::guarded;
use super::{RawCloud, las, ply};
use crate::error::{Error, Result};
use crate::job::Job;

/// How integer colours are scaled.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ColourBits {
    /// 8 bits if the type is that small or no value exceeds 255, else 16 bits.
    #[default]
    Auto,
    /// 0 to 255.
    Eight,
    /// 0 to 65,535.
    Sixteen,
}

/// What to read beside the columns that every cloud may have.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Names of further columns to keep in [`RawCloud::columns`], for the rules that ask for them. A name that the
    /// file does not have is passed over here; the rule will complain.
    pub columns: Vec<String>,
    /// How integer colours are scaled.
    pub colour_bits: ColourBits,
}

/// An opened point file, whose length bounds every count that it claims.
pub(in crate::cloud) struct Source<'a> {
    pub(super) path: &'a Path,
    pub(super) file: File,
    /// Bytes.
    pub(super) length: u64,
}

impl<'a> Source<'a> {
    /// Opens a regular file that is not empty.
    pub(super) fn open(path: &'a Path) -> Result<Self> {
        let read_error = |source| Error::Read {
            path: path.to_owned(),
            source,
        };

        // Opening a pipe would wait for its writer.
        let kind = std::fs::metadata(path).map_err(read_error)?;
        if kind.is_dir() {
            return Err(Error::cloud(path, "it is a folder; name a file in it"));
        }
        if !kind.is_file() {
            return Err(Error::cloud(
                path,
                "it is not a regular file; copy its content to a file first",
            ));
        }
        let file = File::open(path).map_err(read_error)?;
        let length = file.metadata().map_err(read_error)?.len();
        if length == 0 {
            return Err(Error::cloud(path, "it is empty"));
        }
        Ok(Self { path, file, length })
    }

    /// A sentence about this file.
    pub(super) fn error(&self, problem: impl Into<String>) -> Error {
        Error::cloud(self.path, problem)
    }

    /// The system's error while reading this file; one that ends too early is the file's own fault.
    pub(super) fn io_error(&self, source: std::io::Error) -> Error {
        if source.kind() == std::io::ErrorKind::UnexpectedEof {
            self.error("it ends before all of its points; it was cut off, so get a whole copy")
        } else {
            Error::Read {
                path: self.path.to_owned(),
                source,
            }
        }
    }
}

/// Reads a point cloud: PLY (ascii or binary, any scalar types), LAS 1.0 to 1.4 and LAZ (all point formats).
///
/// The kind is told by the file's first bytes. Counts in headers are checked against the file's length and the free
/// memory before anything is allocated by them.
///
/// # Errors
/// [`Error::Read`] where the system refuses, [`Error::Cloud`] where the file is no regular file, of another kind, or
/// broken, [`Error::Memory`], [`Error::Cancelled`].
pub fn read_cloud(path: &Path, options: &ReadOptions, job: &Job) -> Result<RawCloud> {
    let mut source = Source::open(path)?;

    // The magic decides; the extension only words the refusal.
    let mut magic = [0; 4];
    let magic_length = source.length.min(4) as usize;
    source
        .file
        .read_exact(magic.get_mut(..magic_length).unwrap_or_default())
        .and_then(|()| source.file.rewind())
        .map_err(|e| source.io_error(e))?;
    match &magic {
        b"LASF" => guarded(path, || las::read(source, options, job)),
        [b'p', b'l', b'y', end] if end.is_ascii_whitespace() => {
            guarded(path, || ply::read(source, options, job))
        }
        _ => Err(Error::cloud(path, unknown_kind(path))),
    }
}

fn unknown_kind(path: &Path) -> &'static str {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("ply") => "it does not begin as a PLY file does (with a line `ply`)",
        Some("las" | "laz") => "it does not begin as a LAS or LAZ file does (with `LASF`)",
        _ => "it is of a kind that is not read; PLY, LAS and LAZ files are",
    }
}
