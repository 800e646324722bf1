//! Numbered pictures along a camera's path: made one by one, between the views that the window asks for.

use std::path::PathBuf;
use std::sync::Arc;

use catoptric::camera::Camera;
use catoptric::output::{Outputs, check_writable};
use catoptric::settings::Settings;
use catoptric::{Error, Job};
use glam::UVec2;

use super::letters::{Event, Opened};
use super::path::{self, CameraPath};
use super::studio::Studio;

/// What is to be written.
#[derive(Debug, Clone)]
pub(super) struct Take {
    pub(super) path: CameraPath,
    /// Pictures a second.
    pub(super) rate: f64,
    pub(super) size: UVec2,
    pub(super) settings: Settings,
    /// Folder and name, without number and ending.
    pub(super) stem: String,
}

/// Pictures that are being written.
pub(super) struct Filming {
    take: Arc<Take>,
    written: usize,
    total: usize,
}

/// What came of it.
pub(super) struct Filmed {
    pub(super) written: usize,
    pub(super) total: usize,
    /// The first and the last picture that are written.
    pub(super) files: Option<[PathBuf; 2]>,
    /// Why there are no more, where that is nobody's wish.
    pub(super) problem: Option<String>,
}

impl Take {
    /// How many pictures.
    ///
    /// # Errors
    /// A sentence where they are none or too many.
    pub(super) fn count(&self) -> Result<usize, String> {
        self.path.pictures(self.rate)
    }

    /// The camera of a picture; `None` where there is no path.
    pub(super) fn camera(&self, picture: usize, opened: &Opened) -> Option<Camera> {
        let pose = self.path.pose(self.path.time_of(picture, self.rate))?;
        let like = Camera {
            size: self.size,
            ..opened.loaded.camera
        };
        Some(opened.fitted(pose.camera(&like)))
    }

    /// The file of a picture. All numbers are as wide as the last, and four digits at least.
    pub(super) fn file(&self, picture: usize) -> PathBuf {
        let last = self.count().unwrap_or(1).saturating_sub(1);
        let width = last.to_string().len().max(4);
        PathBuf::from(format!("{}-{picture:0width$}.png", self.stem))
    }

    /// The file of the path.
    pub(super) fn path_file(&self) -> PathBuf {
        PathBuf::from(format!("{}.path.toml", self.stem))
    }
}

impl Studio {
    /// Begins a film; its pictures follow one by one.
    pub(super) fn begin_film(&mut self, take: Take) -> Event {
        let total = match take.count() {
            Ok(total) => total,
            Err(problem) => return ended(0, 0, None, Some(problem)),
        };
        // Known before the first picture is made.
        if let Err(error) = check_writable(&take.file(0)) {
            return ended(0, total, None, Some(sentence(error)));
        }
        self.film = Some(Filming {
            take: Arc::new(take),
            written: 0,
            total,
        });
        Event::Picture(0, total)
    }

    /// Makes and writes the next picture; with the first one the path.
    ///
    /// # Errors
    /// What rendering and writing meet; nothing of this picture is left behind.
    pub(super) fn picture(&mut self, job: &Job) -> Result<Event, Error> {
        let (Some(film), Some(opened)) = (&self.film, &self.opened) else {
            return Err(Error::Cancelled);
        };
        let (take, picture) = (Arc::clone(&film.take), film.written);
        let camera = take.camera(picture, opened).ok_or(Error::Cancelled)?;
        let (products, _) = self.products(&camera, &take.settings, job)?;
        let mut outputs = Outputs::default();
        let image = &take.settings.image;
        outputs.stage_picture(&take.file(picture), &products.radiance, image, job)?;
        if picture == 0 {
            let text = path::text(&take.path).map_err(Error::Setting)?;
            outputs.stage(&take.path_file(), |file| file.write_all(text.as_bytes()))?;
        }
        outputs.commit(job)?;
        let Some(film) = &mut self.film else {
            return Err(Error::Cancelled);
        };
        film.written += 1;
        if film.written < film.total {
            return Ok(Event::Picture(film.written, film.total));
        }
        Ok(self.end_film(None))
    }

    /// Writes no more pictures.
    pub(super) fn end_film(&mut self, error: Option<Error>) -> Event {
        let problem = error
            .filter(|error| !matches!(error, Error::Cancelled))
            .map(sentence);
        let Some(film) = self.film.take() else {
            return ended(0, 0, None, problem);
        };
        let last = film.written.checked_sub(1);
        let files = last.map(|last| [0, last].map(|picture| film.take.file(picture)));
        ended(film.written, film.total, files, problem)
    }
}

fn ended(
    written: usize,
    total: usize,
    files: Option<[PathBuf; 2]>,
    problem: Option<String>,
) -> Event {
    Event::Filmed(Filmed {
        written,
        total,
        files,
        problem,
    })
}

/// With what the system said.
fn sentence(error: Error) -> String {
    format!("{:#}", anyhow::Error::from(error))
}
