//! What the interface and the rendering thread write to each other.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::SystemTime;

use catoptric::Progress;
use catoptric::camera::Camera;
use catoptric::cloud::Select;
use catoptric::renderer::Products;
use catoptric::scene::{LoadedScene, Override, Scene};
use catoptric::settings::Settings;
use eframe::egui::ColorImage;
use glam::{DVec3, UVec2};

use super::buffers::Buffer;
use super::comparison::Comparison;
use super::document::Document;
use super::pace::Detail;
use super::take::{Filmed, Take};

/// What to open.
#[derive(Debug, Clone)]
pub(super) struct Opening {
    /// Counted up by who asks, together with requests.
    pub(super) number: u64,
    pub(super) path: PathBuf,
    pub(super) overrides: Vec<Override>,
    /// What was said on top of the scene, as words of a command line.
    pub(super) given: Vec<String>,
    /// What a person made of the scene that is open, in place of what its file says.
    pub(super) edited: Option<Edited>,
}

/// A scene that is open, changed.
#[derive(Debug, Clone)]
pub(super) struct Edited {
    pub(super) document: Box<Document>,
    /// The number of the opening that the scene came with: another one is not changed by this.
    pub(super) file: u64,
    /// Whether the file is read anew for what was not changed.
    pub(super) reads: bool,
}

/// What to render.
#[derive(Debug, Clone)]
pub(super) struct Request {
    /// Counted up by who asks.
    pub(super) number: u64,
    /// The layer to paint.
    pub(super) buffer: Buffer,
    pub(super) camera: Camera,
    pub(super) settings: Settings,
    pub(super) detail: Detail,
    /// Whether nothing is left out of what the window's settings say.
    pub(super) whole: bool,
}

/// What to write: any of these files.
#[derive(Debug, Clone)]
pub(super) struct Export {
    pub(super) camera: Camera,
    pub(super) settings: Settings,
    pub(super) picture: Option<PathBuf>,
    pub(super) gbuffer: Option<PathBuf>,
    pub(super) mirror_gbuffer: Option<PathBuf>,
    pub(super) camera_json: Option<PathBuf>,
}

/// A scene to be written.
#[derive(Debug, Clone)]
pub(super) struct Save {
    pub(super) scene: Box<Scene>,
    pub(super) path: PathBuf,
    /// Whether a file that is there already is replaced.
    pub(super) replaces: bool,
}

/// A scene that was written.
pub(super) struct Saved {
    /// What is open, now the scene of that file.
    pub(super) opened: Opened,
    /// What was to be written, and what is read back of it: the same but for last bits and for how files are named.
    pub(super) asked: Document,
    pub(super) read: Document,
}

/// A pixel of a frame, around which a surface is looked for.
#[derive(Clone)]
pub(super) struct Pick {
    pub(super) shown: Shown,
    pub(super) pixel: UVec2,
}

/// A scene that is open.
#[derive(Debug, Clone)]
pub(super) struct Opened {
    pub(super) opening: Opening,
    /// The number of the opening that brought the file.
    pub(super) file: u64,
    /// When the file was written last, as far as that is known.
    pub(super) written: Option<SystemTime>,
    /// As its file and what was said on top of it have it.
    pub(super) base: Scene,
    /// As it is shown.
    pub(super) scene: Scene,
    pub(super) loaded: Arc<LoadedScene>,
    pub(super) backend: &'static str,
    pub(super) adapter: Option<String>,
}

impl Opened {
    /// The camera with planes that fit the scene from where it is, unless the scene says which.
    pub(super) fn fitted(&self, camera: Camera) -> Camera {
        let mut scene = self.scene.clone();
        scene.camera.position = Some(camera.position);
        scene.camera.target = Some(camera.target);
        scene.camera.up = Some(camera.up);
        scene.camera.fov_y_degrees = Some(camera.fov_y_degrees);
        scene.camera.size = Some(camera.size);
        let fitted = scene.camera(self.loaded.facts.bounds, self.loaded.up_axis);
        fitted.unwrap_or(camera)
    }
}

/// A frame, as it was asked for.
#[derive(Clone)]
pub(super) struct Shown {
    pub(super) request: Request,
    pub(super) products: Arc<Products>,
    /// From the request's beginning to its end, milliseconds.
    pub(super) ms: f64,
    /// What positions are relative to, and the spacing of points.
    pub(super) origin: DVec3,
    pub(super) spacing: f64,
}

/// A layer of a frame, in colours.
pub(super) struct Layer {
    pub(super) buffer: Buffer,
    pub(super) image: ColorImage,
    /// What the darkest and the brightest colour stand for.
    pub(super) scale: Option<(f32, f32)>,
}

impl Layer {
    pub(super) fn new(shown: &Shown, buffer: Buffer) -> Self {
        let painted = buffer.paint(&shown.products, &shown.request.settings.image);
        let size = painted.picture.size().as_usizevec2().to_array();
        let bytes = painted.picture.values().as_flattened();
        Self {
            buffer,
            image: ColorImage::from_rgba_unmultiplied(size, bytes),
            scale: painted.scale,
        }
    }
}

/// What the thread tells.
pub(super) enum Event {
    Progress(Progress),
    Opened(Box<Opened>),
    Shown(Box<Shown>, Layer),
    /// Another layer of the frame that is shown.
    Painted(Layer),
    /// A frame to compare with the one that is shown.
    Second(Box<Shown>),
    /// How the two compare.
    Compared(Box<Comparison>),
    Exported(Vec<PathBuf>),
    /// The scene was written, and is now this one.
    Saved(Box<Saved>),
    /// What chooses the points of the surface that was asked for.
    Picked(Option<Select>),
    /// Pictures of a path that are written, and all that are to be.
    Picture(usize, usize),
    /// There are no more.
    Filmed(Filmed),
    /// The number of what was asked for, where it has one, and a sentence for the person.
    Failed(Option<u64>, String),
    /// The same where the graphics device is what failed; it is opened anew.
    Lost(Option<u64>, String),
    /// What was begun was stopped.
    Stopped(Option<u64>),
}

/// What the thread does.
pub(super) enum Task {
    Open(Opening),
    Export(Export),
    Save(Save),
    /// Finds the surface around a pixel.
    Pick(Box<Pick>),
    /// Begins to write pictures of a path.
    Film(Take),
    /// Writes the next one.
    Picture,
    /// Writes no more.
    EndFilm,
    Render(Request),
    Paint(Buffer),
    Second(Request),
    Compare(Box<(Shown, Shown, Buffer)>),
    /// Takes the graphics device away, as a driver may.
    #[cfg(test)]
    Lose,
}
