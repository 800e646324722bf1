//! What comes out: pictures, buffers and descriptions as files. `docs/OUTPUTS.md` describes each for its readers.

use std::path::Path;

use glam::Vec4;

use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::image::{Background, ImageSettings, picture};
use crate::job::Job;
use crate::reflect::sscr::heat::HeatSums;

mod atomic;
mod camera_json;
mod exr;
mod gbuffer;
mod mirror_gbuffer;
mod png;
mod search_heat;

pub use atomic::{Outputs, check_writable, write_atomically};
pub use camera_json::CameraDescription;
pub use exr::ExrImage;
pub use gbuffer::camera_gbuffer;
pub use mirror_gbuffer::mirror_gbuffer;
pub use png::encode_png;
pub use search_heat::{heat_colour, search_heat, search_heat_picture};

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

/// The files that take memory to encode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutputKind {
    /// What the camera sees.
    Picture(PictureFormat),
    /// [`camera_gbuffer`].
    CameraGBuffer,
    /// [`mirror_gbuffer`].
    MirrorGBuffer,
    /// [`search_heat`].
    SearchHeat(PictureFormat),
}

impl OutputKind {
    /// Bytes that encoding takes at most, per pixel: a PNG's is tone mapped, then compressed row by row; an EXR holds all
    /// channels, and the encoded file, which may be as long.
    pub(crate) fn bytes_per_pixel(self) -> u64 {
        let exr = |channels: u64| channels * 2 * size_of::<f32>() as u64;
        match self {
            Self::Picture(PictureFormat::Png) => 2 * size_of::<[u8; 4]>() as u64,
            Self::Picture(PictureFormat::Exr) => exr(4),
            Self::CameraGBuffer => exr(14),
            Self::MirrorGBuffer => exr(17),
            // Its values are sorted, panel by panel, while the panels are held.
            Self::SearchHeat(PictureFormat::Png) => 3 * 2 * size_of::<[u8; 4]>() as u64 + 4,
            Self::SearchHeat(PictureFormat::Exr) => exr(4),
        }
    }
}

impl Outputs {
    /// Encodes radiance (W/sr/m2, alpha 1 where something is seen, else 0) as the picture that the name of `path` asks
    /// for.
    ///
    /// # Errors
    /// [`Error::Setting`] for another ending than .png or .exr, [`Error::Write`] where the file cannot be written,
    /// [`Error::Cancelled`].
    pub fn stage_picture(
        &mut self,
        path: &Path,
        radiance: &Grid<Vec4>,
        settings: &ImageSettings,
        job: &Job,
    ) -> Result<()> {
        job.check()?;
        match PictureFormat::of(path)? {
            PictureFormat::Png => {
                let shown = picture(radiance, settings);
                self.stage(path, |file| {
                    encode_png(file, &shown, settings.background, job)
                })
            }
            PictureFormat::Exr => {
                self.stage_exr(path, ExrImage::picture(radiance, settings.background), job)
            }
        }
    }

    /// Encodes where searches end: as layers, or as three pictures side by side, as the name of `path` asks for.
    ///
    /// # Errors
    /// As [`Outputs::stage_picture`].
    pub fn stage_search_heat(
        &mut self,
        path: &Path,
        heat: &Grid<HeatSums>,
        job: &Job,
    ) -> Result<()> {
        job.check()?;
        match PictureFormat::of(path)? {
            PictureFormat::Png => {
                let shown = search_heat_picture(heat);
                let opaque = Background::Colour([0; 3]);
                self.stage(path, |file| encode_png(file, &shown, opaque, job))
            }
            PictureFormat::Exr => self.stage_exr(path, search_heat(heat), job),
        }
    }

    /// Encodes an image as EXR.
    ///
    /// # Errors
    /// [`Error::Write`] where it cannot be encoded or written, [`Error::Cancelled`].
    pub fn stage_exr(&mut self, path: &Path, image: ExrImage, job: &Job) -> Result<()> {
        self.stage(path, |file| file.write_all(&image.encode(job)?))
    }

    /// Encodes `value` as JSON, indented, with a line break at the end.
    ///
    /// # Errors
    /// [`Error::Write`] where the file cannot be written.
    pub fn stage_json(&mut self, path: &Path, value: &impl serde::Serialize) -> Result<()> {
        self.stage(path, |file| {
            serde_json::to_writer_pretty(&mut *file, value)?;
            writeln!(file)
        })
    }
}

/// Writes radiance as a picture; as [`Outputs::stage_picture`] says.
///
/// # Errors
/// As there; what was there before is then still there.
pub fn write_picture(path: &Path, radiance: &Grid<Vec4>, settings: &ImageSettings) -> Result<()> {
    let (mut outputs, job) = (Outputs::default(), Job::default());
    outputs.stage_picture(path, radiance, settings, &job)?;
    outputs.commit(&job)
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;
    use crate::camera::Camera;
    use crate::gbuffer::GBuffer;
    use crate::image::Background;
    use crate::reflect::MirrorGBuffer;

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
    fn memory_is_reckoned_with_for_every_channel() {
        let size = UVec2::ONE;
        let camera = Camera {
            position: glam::DVec3::ZERO,
            target: glam::DVec3::X,
            up: glam::DVec3::Z,
            fov_y_degrees: 60.0,
            near: 0.1,
            far: 10.0,
            size,
        };
        let origin = glam::DVec3::ZERO;
        let pinhole = camera.pinhole(origin).expect("a sound camera");
        let radiance = Grid::new(size, Vec4::ONE);
        for (kind, image) in [
            (
                OutputKind::Picture(PictureFormat::Exr),
                ExrImage::picture(&radiance, Background::Transparent),
            ),
            (
                OutputKind::CameraGBuffer,
                camera_gbuffer(&GBuffer::empty(pinhole), origin),
            ),
            (
                OutputKind::MirrorGBuffer,
                mirror_gbuffer(&MirrorGBuffer::empty(size), origin),
            ),
        ] {
            assert_eq!(
                kind.bytes_per_pixel(),
                image.channels.len() as u64 * 8,
                "{kind:?}"
            );
        }
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
