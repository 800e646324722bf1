//! Folders to write to, checked before any work is done.

use std::path::Path;

use catoptric::output::check_writable;

use super::Usage;

/// Refuses, before any work, a folder that cannot be made or in which `files` cannot be written.
pub(super) fn check_folder(folder: &Path, files: &[&Path]) -> anyhow::Result<()> {
    let is_empty = |path: &Path| path.as_os_str().is_empty();
    let nearest = folder
        .ancestors()
        .find(|path| !is_empty(path) && path.exists());
    match nearest {
        Some(path) if !path.is_dir() => Err(Usage(format!(
            "--output is a folder to write to, and {} is a file; name another place",
            path.display()
        ))
        .into()),
        Some(path) if path != folder => Ok(check_writable(&path.join("scene"))?),
        None if !is_empty(folder) => Ok(check_writable(Path::new("scene"))?),
        Some(_) | None => {
            for file in files {
                check_writable(file)?;
            }
            Ok(())
        }
    }
}

/// Makes a folder where it is missing.
pub(super) fn make_folder(folder: &Path) -> catoptric::Result<()> {
    if folder.as_os_str().is_empty() {
        return Ok(());
    }
    std::fs::create_dir_all(folder).map_err(|source| catoptric::Error::Write {
        path: folder.into(),
        source,
    })
}
