//! The window's state, and what happens to it: events of the worker in, views to render out.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use catoptric::Progress;
use catoptric::camera::Camera;
use catoptric::timing::PassTime;
use eframe::egui;
use glam::{DVec3, UVec2};

use super::Start;
use super::buffers::Buffer;
use super::document::Document;
use super::editing::Selected;
use super::film::Film;
use super::gizmo::Gizmo;
use super::handles::Handle;
use super::history::History;
use super::letters::{Export, Opened, Opening, Request, Shown};
use super::navigation::Navigator;
use super::pace::{Detail, Pace};
use super::path::is_path_file;
use super::probe::Probe;
use super::second::Second;
use super::worker::Worker;

/// What a frame may take while the camera moves, milliseconds.
const BUDGET_MS: f64 = 60.0;

/// How long the camera rests before everything is drawn.
const REST: Duration = Duration::from_millis(150);

/// What a file is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    Open,
    AddCloud,
    InsertMesh,
}

/// A file that was chosen, and what for.
pub(super) type Chosen = (Purpose, PathBuf);

/// Everything that the window shows.
pub(super) struct Viewer {
    pub(super) worker: Worker,
    pub(super) chosen: (Sender<Chosen>, Receiver<Chosen>),
    pub(super) opened: Option<Opened>,
    pub(super) history: History,
    pub(super) navigator: Navigator,
    /// What of the camera does not follow from the navigator: field of view, planes, size.
    pub(super) like: Camera,
    pub(super) stored: [Option<Navigator>; 10],
    pub(super) pace: Pace,
    pub(super) buffer: Buffer,
    pub(super) shown: Option<Shown>,
    pub(super) texture: Option<egui::TextureHandle>,
    pub(super) scale: Option<(f32, f32)>,
    pub(super) times: VecDeque<Vec<PassTime>>,
    pub(super) probe: Option<Probe>,
    /// Eye, mirror and what it showed, when it was clicked.
    pub(super) path: Option<[DVec3; 3]>,
    /// Ends of the distance that is measured; the second may be missing.
    pub(super) measured: Vec<DVec3>,
    /// What is chosen, and moved by hand.
    pub(super) selected: Option<Selected>,
    pub(super) gizmo: Gizmo,
    /// What is being moved, as it is in this moment.
    pub(super) moving: Option<(Selected, Handle)>,
    /// The cloud of which the next click makes a region a mirror.
    pub(super) picking: Option<usize>,
    /// Edits that are a step back each, so far.
    pub(super) steps: u64,
    pub(super) film: Film,
    pub(super) second: Option<Second>,
    /// Where the two pictures meet, part of the width; and whether their difference is shown instead.
    pub(super) wiper: f32,
    pub(super) shows_difference: bool,
    pub(super) progress: Option<Progress>,
    pub(super) loading: Option<PathBuf>,
    /// What an edit that is loading shows; `None` where a file is read.
    pub(super) loading_points: Option<Document>,
    /// Whether the scene's file is read for what is loading.
    pub(super) loading_reads: bool,
    /// The number of the last opening.
    pub(super) opening: u64,
    pub(super) messages: Vec<(bool, String)>,
    pub(super) panels: super::panels::Panels,
    /// Whether the view has changed since the last request.
    dirty: bool,
    moved_at: Instant,
    pub(super) number: u64,
    pub(super) under_way: Option<(u64, Detail)>,
    /// Whether what is shown is all there is of the view.
    pub(super) complete: bool,
    /// Whether the graphics device was lost since the last frame.
    pub(super) lost: bool,
}

impl Viewer {
    /// # Errors
    /// Where the system gives no thread.
    pub(super) fn new(
        context: &egui::Context,
        storage: Option<&dyn eframe::Storage>,
        start: Start,
    ) -> std::io::Result<Self> {
        let wake = context.clone();
        let worker = Worker::start(start.choice.clone(), move || wake.request_repaint())?;
        let like = Camera {
            position: DVec3::Z,
            target: DVec3::ZERO,
            up: DVec3::Y,
            fov_y_degrees: 60.0,
            near: 0.01,
            far: 100.0,
            size: UVec2::new(800, 600),
        };
        let mut viewer = Self {
            worker,
            chosen: channel(),
            opened: None,
            history: History::default(),
            navigator: Navigator::of(&like),
            like,
            stored: [None; 10],
            pace: Pace::new(BUDGET_MS),
            buffer: Buffer::default(),
            shown: None,
            texture: None,
            scale: None,
            times: VecDeque::new(),
            probe: None,
            path: None,
            measured: Vec::new(),
            selected: None,
            gizmo: Gizmo::default(),
            moving: None,
            picking: None,
            steps: 0,
            film: Film::new(context),
            second: None,
            wiper: 0.5,
            shows_difference: false,
            progress: None,
            loading: None,
            loading_points: None,
            loading_reads: false,
            opening: 0,
            messages: Vec::new(),
            panels: super::panels::Panels::load(storage),
            dirty: false,
            moved_at: Instant::now(),
            number: 0,
            under_way: None,
            complete: false,
            lost: false,
        };
        if let Some(path) = start.path {
            viewer.begin_opening(Opening {
                number: 0,
                path,
                overrides: start.overrides,
                given: start.given,
                edited: None,
            });
        }
        Ok(viewer)
    }

    /// Opens a scene or a cloud in place of what is open, or takes a camera path into it.
    pub(super) fn open(&mut self, path: PathBuf) {
        if is_path_file(&path) {
            return self.load_path(path);
        }
        self.begin_opening(Opening {
            number: 0,
            path,
            overrides: Vec::new(),
            given: Vec::new(),
            edited: None,
        });
    }

    /// What is open stays until the new scene is there.
    pub(super) fn begin_opening(&mut self, opening: Opening) {
        self.number += 1;
        self.loading_reads = opening.edited.as_ref().is_none_or(|e| e.reads);
        self.loading_points = opening
            .edited
            .as_ref()
            .map(|e| Document::clone(&e.document));
        self.opening = self.number;
        self.loading = Some(opening.path.clone());
        self.under_way = None;
        self.worker.open(Opening {
            number: self.number,
            ..opening
        });
    }

    /// Asks for a file, in a thread of its own: the dialog is the system's.
    pub(super) fn ask_for(&self, context: &egui::Context, purpose: Purpose) {
        let (sender, context) = (self.chosen.0.clone(), context.clone());
        let ask = move || {
            let (kinds, endings): (_, &[&str]) = match purpose {
                Purpose::Open => ("scenes and point clouds", &["toml", "ply", "las", "laz"]),
                Purpose::AddCloud => ("point clouds", &["ply", "las", "laz"]),
                Purpose::InsertMesh => ("meshes", &["ply"]),
            };
            let dialog = rfd::FileDialog::new().add_filter(kinds, endings);
            if let Some(path) = dialog.pick_file() {
                // A closed window opens nothing.
                let _ = sender.send((purpose, path));
                context.request_repaint();
            }
        };
        if let Err(e) = std::thread::Builder::new().spawn(ask) {
            log::warn!("no file can be asked for: {e}");
        }
    }

    /// Stops loading, rendering and writing.
    pub(super) fn cancel(&mut self) {
        self.worker.cancel();
        // A view that was not begun is not told of again.
        self.under_way = None;
        if self.loading.take().is_some() {
            self.give_up_edits(Some(self.opening));
        }
        self.dirty = false;
        self.complete = true;
    }

    /// The view has changed.
    pub(super) fn touch(&mut self) {
        self.dirty = true;
        self.complete = false;
        self.moved_at = Instant::now();
    }

    /// Shows another layer.
    pub(super) fn set_buffer(&mut self, buffer: Buffer) {
        self.buffer = buffer;
        self.compare();
        self.probe = None;
        let asked = self.shown.as_ref().map(|shown| shown.request.buffer);
        if buffer.comes_with(asked.unwrap_or_default()) {
            self.worker.paint(buffer);
        } else {
            self.touch();
        }
    }

    /// The camera as it looks now, at what is open.
    pub(super) fn camera(&self) -> Camera {
        let camera = self.navigator.camera(&self.like);
        match &self.opened {
            Some(opened) => opened.fitted(camera),
            None => camera,
        }
    }

    pub(super) fn export(&mut self, export: Export) {
        if self.loading.is_some() {
            self.say("wait until the scene is there, then export it");
            return;
        }
        self.under_way = None;
        self.worker.export(export);
        self.touch();
    }

    pub(super) fn say(&mut self, message: impl Into<String>) {
        self.messages.push((false, message.into()));
    }

    pub(super) fn fail(&mut self, message: String) {
        if self
            .messages
            .last()
            .is_none_or(|(_, last)| *last != message)
        {
            self.messages.push((true, message));
        }
    }

    /// Whether anything is being made.
    pub(super) fn is_busy(&self) -> bool {
        self.loading.is_some() || self.under_way.is_some() || self.film.rendering.is_some()
    }

    /// Asks for the next frame, where one is due.
    fn ask(&mut self, context: &egui::Context) {
        if self.opened.is_none() || self.loading.is_some() {
            return;
        }
        let rested = self.moved_at.elapsed() >= REST;
        if self.dirty {
            // A frame of little detail is soon done; one of all there is gives way.
            let waits = self
                .under_way
                .is_some_and(|(_, detail)| detail != Detail::FULL);
            if !waits {
                self.dirty = false;
                self.request(self.pace.detail(), true);
            }
        } else if !self.complete && self.under_way.is_none() {
            if rested {
                self.complete = true;
                self.request(Detail::FULL, false);
            } else {
                context.request_repaint_after(REST.saturating_sub(self.moved_at.elapsed()));
            }
        }
    }

    fn request(&mut self, detail: Detail, moving: bool) {
        let settings = if moving {
            detail.settings(self.settings())
        } else {
            self.settings().clone()
        };
        // Nothing was left out: there is nothing to come.
        let whole = detail == Detail::FULL && settings == *self.settings();
        self.complete |= whole;
        self.number += 1;
        self.under_way = Some((self.number, detail));
        self.worker.render(Request {
            number: self.number,
            buffer: self.buffer,
            camera: self.camera(),
            settings,
            detail,
            whole,
        });
    }
}

impl eframe::App for Viewer {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        self.hear(&context);
        self.play();
        super::panels::show(self, ui);
        self.ask(&context);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.panels.save(storage);
    }
}
