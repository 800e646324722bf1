//! Files that are whole or not there, and appear together: temporary files in the targets' folders, then renames.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::job::Job;

/// Links that are followed before they count as a cycle, as many as Linux follows.
const MAX_LINKS: usize = 40;

/// Where the bytes go.
#[derive(Debug, PartialEq, Eq)]
enum Target {
    /// A file, there or not yet, all links followed: it is replaced in one step.
    File(PathBuf),
    /// A device, a pipe or an open file of a process: it is written to as it stands.
    Stream(PathBuf),
}

/// Files that appear together: each is encoded to a temporary file, and all take their places at the end.
///
/// A temporary file lies in its target's folder. Links are followed and kept; an existing file keeps its permissions, a
/// new one gets those that the system gives new files. What is no regular file (/dev/stdout, a pipe, a device) gets the
/// encoded bytes at the end, appended. Hard links to an existing file keep the old content. Without
/// [`Outputs::commit`] nothing is written.
#[derive(Debug, Default)]
pub struct Outputs {
    staged: Vec<Staged>,
}

/// An encoded file that has not taken its place yet.
#[derive(Debug)]
struct Staged {
    /// As the caller named it.
    path: PathBuf,
    content: Content,
}

#[derive(Debug)]
enum Content {
    File {
        temporary: tempfile::NamedTempFile,
        target: PathBuf,
    },
    Stream {
        bytes: Vec<u8>,
        target: PathBuf,
    },
}

impl Outputs {
    /// Encodes a file for `path`, which stays as it is.
    ///
    /// Whoever can be cancelled passes [`Error::Cancelled`] through `encode` by [`io::Error::other`].
    ///
    /// # Errors
    /// [`Error::Write`] where the file cannot be written or `encode` fails, or the library's error that `encode` passes
    /// through. Nothing of this file is left behind then.
    pub fn stage(
        &mut self,
        path: &Path,
        encode: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<()> {
        let content = Content::encode(path, encode).map_err(|e| failed(path, e))?;
        self.staged.push(Staged {
            path: path.to_owned(),
            content,
        });
        Ok(())
    }

    /// Lets every staged file take its place, unless the job was cancelled.
    ///
    /// # Errors
    /// [`Error::Cancelled`], and nothing is written; [`Error::Write`] where a stream cannot be written to or a file
    /// cannot be replaced, and those behind it are not.
    pub fn commit(mut self, job: &Job) -> Result<()> {
        job.check()?;
        // Streams first: they may fail, while files are there already but for their names.
        self.staged
            .sort_by_key(|staged| matches!(staged.content, Content::File { .. }));
        for Staged { path, content } in self.staged {
            content.commit().map_err(|e| failed(&path, e))?;
        }
        Ok(())
    }
}

impl Content {
    fn encode(
        path: &Path,
        encode: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<Self> {
        match target(path)? {
            Target::Stream(target) => {
                let mut bytes = Vec::new();
                encode(&mut bytes)?;
                Ok(Self::Stream { bytes, target })
            }
            Target::File(target) => {
                let temporary = temporary(&target)?;
                buffered(temporary.as_file(), encode)?;
                Ok(Self::File { temporary, target })
            }
        }
    }

    fn commit(self) -> io::Result<()> {
        match self {
            Self::Stream { bytes, target } => OpenOptions::new()
                .append(true)
                .open(target)?
                .write_all(&bytes),
            Self::File { temporary, target } => {
                temporary.persist(target)?;
                Ok(())
            }
        }
    }
}

fn failed(path: &Path, error: io::Error) -> Error {
    match error.downcast::<Error>() {
        Ok(passed_through) => passed_through,
        Err(source) => Error::Write {
            path: path.to_owned(),
            source,
        },
    }
}

/// Writes one file by `encode`, such that it is whole or as it was before; as [`Outputs`] does.
///
/// # Errors
/// As [`Outputs::stage`]. Nothing is left behind then.
pub fn write_atomically(
    path: &Path,
    encode: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<()> {
    let mut outputs = Outputs::default();
    outputs.stage(path, encode)?;
    outputs.commit(&Job::default())
}

/// Whether [`write_atomically`] can be expected to succeed, to be asked before long work.
///
/// # Errors
/// [`Error::Write`] where the folder is missing, or the folder or the file is not writable.
pub fn check_writable(path: &Path) -> Result<()> {
    let checked = match target(path) {
        Ok(Target::Stream(_)) => Ok(()),
        Ok(Target::File(file)) => temporary(&file).map(drop),
        Err(e) => Err(e),
    };
    checked.map_err(|source| Error::Write {
        path: path.to_owned(),
        source,
    })
}

/// Whether `path` is a device, a pipe or an open file of a process.
pub(super) fn is_stream(path: &Path) -> bool {
    matches!(target(path), Ok(Target::Stream(_)))
}

/// Follows the links of `path` to where its bytes go.
fn target(path: &Path) -> io::Result<Target> {
    let mut followed = path.to_owned();
    for _ in 0..MAX_LINKS {
        let Ok(found) = fs::symlink_metadata(&followed) else {
            return Ok(Target::File(followed));
        };
        if found.is_dir() {
            return Err(io::Error::new(
                io::ErrorKind::IsADirectory,
                "it is a folder; give a file's name",
            ));
        }
        if found.is_file() {
            return Ok(Target::File(followed));
        }
        // A link in /proc stands for an open file, whatever path it shows.
        if !found.is_symlink() || folder(&followed).canonicalize()?.starts_with("/proc") {
            return Ok(Target::Stream(followed));
        }
        followed = folder(&followed).join(fs::read_link(&followed)?);
    }
    Err(io::Error::other("its links lead in a circle"))
}

/// The folder that holds `path`.
fn folder(path: &Path) -> &Path {
    path.parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

/// A temporary file beside `path`, which it may take the place of.
fn temporary(path: &Path) -> io::Result<tempfile::NamedTempFile> {
    let folder = folder(path);
    if !folder.is_dir() {
        let problem = format!("there is no folder {}; make it first", folder.display());
        return Err(io::Error::new(io::ErrorKind::NotFound, problem));
    }
    if path.file_name().is_none() {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "give a file's name",
        ));
    }
    // Opened but not changed: what is write protected stays.
    let permissions = match OpenOptions::new().write(true).open(path) {
        Ok(existing) => Some(existing.metadata()?.permissions()),
        Err(e) if e.kind() == io::ErrorKind::NotFound => None,
        Err(e) => return Err(e),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".catoptric-").suffix(".part");
    #[cfg(unix)]
    let builder = builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let temporary = builder.tempfile_in(folder)?;
    if let Some(permissions) = permissions {
        temporary.as_file().set_permissions(permissions)?;
    }
    Ok(temporary)
}

fn buffered(file: &File, encode: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut writer = BufWriter::with_capacity(1 << 16, file);
    let encoded = encode(&mut writer);
    match encoded {
        Ok(()) => writer.flush(),
        Err(e) => {
            // What is still buffered of a failed file is of no use.
            drop(writer.into_parts());
            Err(e)
        }
    }
}

#[cfg(test)]
mod tests;
