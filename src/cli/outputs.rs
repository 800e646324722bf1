//! The files that a rendering writes, checked before any work is done.

use std::path::{Path, PathBuf};

use catoptric::output::{PictureFormat, check_writable};

use super::Usage;

/// What a file will hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    Picture,
    GBuffer,
    Json,
}

/// A file to write: the flag that named it, what it will hold, and where it goes.
pub(super) struct Output<'a> {
    pub(super) flag: &'static str,
    pub(super) content: Content,
    pub(super) path: &'a Path,
}

/// Refuses outputs of the wrong kind, of the same place, over an input, and where nothing can be written.
pub(super) fn check(outputs: &[Output<'_>], inputs: &[&Path]) -> anyhow::Result<()> {
    for output in outputs {
        check_kind(output)?;
    }
    for (index, output) in outputs.iter().enumerate() {
        let place = place(output.path);
        let same = |other: &Path| self::place(other) == place;
        if let Some(other) = outputs
            .iter()
            .skip(index + 1)
            .find(|other| same(other.path))
            && place != Path::new("/dev/null")
        {
            let message = format!(
                "{} and {} both write {}; give each a file of its own",
                output.flag,
                other.flag,
                output.path.display()
            );
            return Err(Usage(message).into());
        }
        if inputs.iter().any(|input| same(input)) {
            let message = format!(
                "{} would overwrite {}, which the scene reads; give it another name",
                output.flag,
                output.path.display()
            );
            return Err(Usage(message).into());
        }
    }
    for output in outputs {
        check_writable(output.path)?;
    }
    Ok(())
}

fn check_kind(output: &Output<'_>) -> Result<(), Usage> {
    let format = PictureFormat::of(output.path);
    let refused = |what: &str| {
        Err(Usage(format!(
            "{} writes {what}; {} has another ending",
            output.flag,
            output.path.display()
        )))
    };
    match (output.content, format) {
        (Content::Picture, Err(e)) => Err(Usage(e.to_string())),
        (Content::GBuffer, Ok(PictureFormat::Png) | Err(_)) if has_ending(output.path) => {
            refused("an .exr file")
        }
        (Content::Json, _) if has_ending(output.path) && !is_json(output.path) => {
            refused("a .json file")
        }
        _ => Ok(()),
    }
}

fn is_json(path: &Path) -> bool {
    path.extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("json"))
}

/// Devices and pipes (/dev/stdout) have no ending, and take anything.
fn has_ending(path: &Path) -> bool {
    path.extension().is_some() || !path.exists()
}

/// Where the bytes end up, links followed, so that two names of the same place are equal.
fn place(path: &Path) -> PathBuf {
    if let Ok(place) = path.canonicalize() {
        return place;
    }
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    match (folder.canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}
