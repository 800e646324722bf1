//! Files that are whole or not there: a temporary file in the target's folder, then a rename.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

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

/// Writes a file by `encode`, such that it is whole or as it was before.
///
/// The bytes go to a temporary file in the target's folder, which then takes the target's place. Links are followed
/// and kept; an existing file keeps its permissions, a new one gets those that the system gives new files. What is no
/// regular file (/dev/stdout, a pipe, a device) is written to directly, at its end. Hard links to an existing file
/// keep the old content.
///
/// Whoever can be cancelled passes [`Error::Cancelled`] through `encode` by [`io::Error::other`].
///
/// # Errors
/// [`Error::Write`] where the file cannot be written or `encode` fails, or the library's error that `encode` passes
/// through. Nothing is left behind then.
pub fn write_atomically(
    path: &Path,
    encode: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<()> {
    let written = match target(path) {
        Ok(Target::Stream(stream)) => append(&stream, encode),
        Ok(Target::File(file)) => replace(&file, encode),
        Err(e) => Err(e),
    };
    written.map_err(|e| match e.downcast::<Error>() {
        Ok(passed_through) => passed_through,
        Err(source) => Error::Write {
            path: path.to_owned(),
            source,
        },
    })
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

fn replace(path: &Path, encode: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let temporary = temporary(path)?;
    buffered(temporary.as_file(), encode)?;
    temporary.persist(path)?;
    Ok(())
}

fn append(path: &Path, encode: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    buffered(&OpenOptions::new().append(true).open(path)?, encode)
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
mod tests {
    use super::*;

    fn write(path: &Path, text: &str) -> Result<()> {
        write_atomically(path, |file| file.write_all(text.as_bytes()))
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder");
        let mut names: Vec<_> = entries
            .map(|e| {
                e.expect("an entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("out");
        write(&path, "old").expect("written");
        let failed = write_atomically(&path, |file| {
            file.write_all(&[b'x'; 1 << 20])?;
            Err(io::Error::other("the disk is full"))
        });
        assert!(matches!(failed, Err(Error::Write { .. })), "got {failed:?}");
        assert_eq!(fs::read_to_string(&path).expect("the old file"), "old");
        assert_eq!(names(folder.path()), ["out"]);
    }

    #[test]
    fn cancelling_passes_through_and_leaves_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let cancelled = write_atomically(&folder.path().join("out"), |_| {
            Err(io::Error::other(Error::Cancelled))
        });
        assert!(
            matches!(cancelled, Err(Error::Cancelled)),
            "got {cancelled:?}"
        );
        assert_eq!(names(folder.path()), [""; 0]);
    }

    #[test]
    fn a_missing_folder_and_a_folder_in_place_of_a_file_are_sentences() {
        let folder = tempfile::tempdir().expect("a folder");
        for path in [folder.path().join("missing/out"), folder.path().to_owned()] {
            for result in [check_writable(&path), write(&path, "x")] {
                let Err(Error::Write { source, .. }) = result else {
                    panic!("{} must be refused, got {result:?}", path.display());
                };
                assert!(source.to_string().contains("folder"), "{source}");
            }
        }
        assert_eq!(names(folder.path()), [""; 0]);
    }

    #[test]
    fn asking_first_leaves_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        check_writable(&folder.path().join("out")).expect("writable");
        assert_eq!(names(folder.path()), [""; 0]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_kept_and_their_targets_replaced() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("deep")).expect("a folder");
        symlink("deep/link", at("first")).expect("a link");
        symlink("file", at("deep/link")).expect("a link");
        for text in ["made by way of a dangling link", "and replaced"] {
            write(&at("first"), text).expect("written");
            assert_eq!(
                fs::read_to_string(at("deep/file")).expect("the target"),
                text
            );
        }
        assert!(
            at("first").is_symlink() && at("deep/link").is_symlink(),
            "the links must still be links"
        );
    }

    #[cfg(unix)]
    #[test]
    fn links_in_a_circle_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("circle");
        std::os::unix::fs::symlink("circle", &path).expect("a link");
        assert!(
            write(&path, "x").is_err(),
            "a circle has no end to write to"
        );
    }

    #[cfg(unix)]
    #[test]
    fn an_existing_file_keeps_its_permissions_and_a_new_one_gets_those_of_new_files() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a folder");
        let mode = |path: &Path| fs::metadata(path).expect("the file").permissions().mode() & 0o777;
        let (old, new, plain) = (
            folder.path().join("old"),
            folder.path().join("new"),
            folder.path().join("plain"),
        );
        fs::write(&old, "").expect("written");
        fs::set_permissions(&old, fs::Permissions::from_mode(0o640)).expect("permissions");
        fs::write(&plain, "").expect("written");
        write(&old, "x").expect("written");
        write(&new, "x").expect("written");
        assert_eq!(mode(&old), 0o640);
        assert_eq!(mode(&new), mode(&plain), "as a file that is simply made");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn devices_pipes_and_open_files_are_written_to_directly() {
        use std::io::Read;
        use std::os::fd::AsRawFd;
        use std::os::unix::fs::FileTypeExt;

        write(Path::new("/dev/null"), "x").expect("written");
        assert!(
            fs::metadata("/dev/null")
                .expect("the device")
                .file_type()
                .is_char_device(),
            "still a device"
        );

        let (mut reader, pipe) = io::pipe().expect("a pipe");
        write(
            Path::new(&format!("/proc/self/fd/{}", pipe.as_raw_fd())),
            "through the pipe",
        )
        .expect("written");
        drop(pipe);
        let mut got = String::new();
        reader.read_to_string(&mut got).expect("text");
        assert_eq!(got, "through the pipe");

        // As /dev/stdout is after `>> file`.
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("redirected");
        fs::write(&path, "before ").expect("written");
        let open = OpenOptions::new()
            .append(true)
            .open(&path)
            .expect("the file");
        write(Path::new(&format!("/dev/fd/{}", open.as_raw_fd())), "after").expect("written");
        assert_eq!(fs::read_to_string(&path).expect("the file"), "before after");
    }
}
