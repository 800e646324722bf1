//! Clouds from files: what is read is what the file holds, and a broken file is a sentence.

mod broken;
mod las_files;
mod ply_files;
mod prepared;
mod samples;

use std::path::Path;

use catoptric::cloud::{RawCloud, ReadOptions, read_cloud};
use catoptric::{Error, Job, Result};
use libtest_mimic::{Failed, Trial};

/// The tests of this folder. Those of real scans are ignored where `CATOPTRIC_SCANS` does not name their folder.
pub(crate) fn tests() -> Vec<Trial> {
    let parts = [
        samples::tests(),
        ply_files::tests(),
        las_files::tests(),
        broken::tests(),
        prepared::tests(),
    ];
    parts.into_iter().flatten().collect()
}

/// Fails with a message that says what was got and what was expected.
fn demand(holds: bool, otherwise: impl Into<String>) -> Result<(), Failed> {
    if holds {
        Ok(())
    } else {
        Err(otherwise.into().into())
    }
}

fn read(path: &Path) -> Result<RawCloud> {
    read_cloud(path, &ReadOptions::default(), &Job::default())
}

/// Reads a file of these bytes.
fn read_bytes(bytes: &[u8], options: &ReadOptions) -> Result<RawCloud> {
    let io_error = |source| Error::Write {
        path: "a temporary file".into(),
        source,
    };
    let file = tempfile::NamedTempFile::new().map_err(io_error)?;
    std::fs::write(file.path(), bytes).map_err(io_error)?;
    read_cloud(file.path(), options, &Job::default())
}
