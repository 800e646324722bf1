//! What comes out: pictures, buffers and descriptions as files. `docs/OUTPUTS.md` describes each for its readers.

use std::path::Path;

use glam::Vec4;

use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::image::{ImageSettings, picture};

mod atomic;
mod camera_json;
mod exr;
mod gbuffer;
mod mirror_gbuffer;
mod png;

pub use atomic::{check_writable, write_atomically};
pub use camera_json::CameraDescription;
pub use exr::ExrImage;
pub use gbuffer::camera_gbuffer;
pub use mirror_gbuffer::mirror_gbuffer;
pub use png::encode_png;

/// The kinds of file that a picture is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureFormat {
    /// 8-bit sRGB, exposed and tone mapped.
    Png,
    /// Radiance in float32, neither exposed nor tone mapped.
    Exr,
}

impl PictureFormat {
    /// The format that a file's name asks for; PNG for what is no file but a device or pipe (/dev/stdout).
    ///
    /// # Errors
    /// [`Error::Setting`] where the name ends in neither .png nor .exr.
    pub fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            None if atomic::is_stream(path) => Ok(Self::Png),
            Some(_) | None => Err(Error::Setting(format!(
                "a picture is written as .png or .exr; give {} one of these endings",
                path.display()
            ))),
        }
    }
}

/// Writes radiance (W/sr/m2, alpha 1 where something is seen, else 0) as the picture that the name of `path` asks for.
///
/// # Errors
/// [`Error::Setting`] for another ending than .png or .exr, [`Error::Write`] where the file cannot be written; what
/// was there before is then still there.
pub fn write_picture(path: &Path, radiance: &Grid<Vec4>, settings: &ImageSettings) -> Result<()> {
    match PictureFormat::of(path)? {
        PictureFormat::Png => {
            let shown = picture(radiance, settings);
            write_atomically(path, |file| encode_png(file, &shown, settings.background))
        }
        PictureFormat::Exr => ExrImage::picture(radiance, settings.background).write(path),
    }
}

/// Writes `value` as JSON, indented, with a line break at the end.
///
/// # Errors
/// [`Error::Write`] where the file cannot be written; what was there before is then still there.
pub fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<()> {
    write_atomically(path, |file| {
        serde_json::to_writer_pretty(&mut *file, value)?;
        writeln!(file)
    })
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    #[test]
    fn the_ending_chooses_the_format() {
        assert_eq!(
            PictureFormat::of(Path::new("a/b.PNG")).expect("a format"),
            PictureFormat::Png
        );
        assert_eq!(
            PictureFormat::of(Path::new("a.b.exr")).expect("a format"),
            PictureFormat::Exr
        );
        #[cfg(unix)]
        assert_eq!(
            PictureFormat::of(Path::new("/dev/null")).expect("a format"),
            PictureFormat::Png
        );
    }

    #[test]
    fn another_ending_is_refused_with_the_remedy() {
        for name in ["a.jpg", "png", "", "a.png."] {
            let message = PictureFormat::of(Path::new(name))
                .expect_err("must be refused")
                .to_string();
            assert!(message.contains(".png or .exr"), "{name:?}: {message}");
        }
    }

    #[test]
    fn both_formats_are_written_by_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let radiance = Grid::new(UVec2::new(3, 2), Vec4::ONE);
        for (name, magic) in [
            ("a.png", &b"\x89PNG"[..]),
            ("a.exr", &b"\x76\x2f\x31\x01"[..]),
        ] {
            let path = folder.path().join(name);
            write_picture(&path, &radiance, &ImageSettings::default()).expect("a picture");
            assert!(
                std::fs::read(&path).expect("the file").starts_with(magic),
                "{name}"
            );
        }
    }
}
