//! What happens to the window's state when the rendering thread tells something.

use catoptric::camera::Camera;
use catoptric::scene::MirrorShape;
use eframe::egui;
use glam::UVec2;

use super::app::{Purpose, Viewer};
use super::document::Document;
use super::history::History;
use super::letters::{Event, Layer, Opened, Shown};
use super::navigation::Navigator;
use super::pace::Detail;

/// Frames whose times are kept.
const KEPT: usize = 60;

impl Viewer {
    /// What the worker and the dialogs told.
    pub(super) fn hear(&mut self, context: &egui::Context) {
        let events: Vec<Event> = self.worker.events().collect();
        for event in events {
            match event {
                Event::Progress(progress) => self.progress = Some(progress),
                Event::Opened(opened) => self.begin(*opened),
                Event::Shown(shown, layer) => self.show(*shown, layer, context),
                Event::Painted(layer) => self.put(layer, context),
                Event::Second(shown) => {
                    self.progress = None;
                    if let Some(second) = &mut self.second {
                        second.shown = Some(*shown);
                    }
                    self.compare();
                }
                Event::Compared(comparison) => self.put_comparison(*comparison, context),
                Event::Exported(files) => {
                    self.progress = None;
                    for file in files {
                        self.say(format!("wrote {}", file.display()));
                    }
                }
                Event::Saved(saved) => {
                    let path = saved.opened.opening.path.clone();
                    self.panels.remember(&path);
                    self.say(format!("wrote {}", path.display()));
                    // The same scene, as it is read back.
                    if self.document().has_points_of(&saved.asked) {
                        self.history.replace_points(&saved.read);
                    }
                    self.opened = Some(saved.opened);
                }
                Event::Picked(select) => self.picked(select),
                Event::Picture(done, total) => {
                    self.progress = None;
                    self.film.rendering = Some((done, total));
                }
                Event::Filmed(filmed) => self.filmed(&filmed),
                Event::Failed(number, message) => {
                    // What cannot be made is not asked for again; other failures leave the view to be completed.
                    self.complete |= self.under_way.is_some_and(|(n, _)| Some(n) == number);
                    self.done(number);
                    self.refuse_comparison(number, &message);
                    self.fail(message);
                    self.give_up_edits(number);
                }
                Event::Lost(number, message) => {
                    // What cannot be made is not asked for again; other failures leave the view to be completed.
                    self.complete |= self.under_way.is_some_and(|(n, _)| Some(n) == number);
                    self.done(number);
                    self.fail(message);
                    self.give_up_edits(number);
                    // Once: where it fails again and again, a person decides.
                    if !std::mem::replace(&mut self.lost, true) {
                        self.touch();
                    }
                }
                Event::Stopped(number) => {
                    self.done(number);
                    self.give_up_edits(number);
                }
            }
        }
        self.hear_film();
        if let Ok((purpose, path)) = self.chosen.1.try_recv() {
            match purpose {
                Purpose::Open => self.open(path),
                Purpose::AddCloud => self.add_cloud(path),
                Purpose::InsertMesh => self.insert_mirror(MirrorShape::Mesh { path }),
            }
        }
        let (dropped, adds) = context.input(|i| {
            let files = i.raw.dropped_files.iter().map(|f| f.path().to_owned());
            (files.collect::<Vec<_>>(), i.modifiers.shift)
        });
        for path in dropped {
            if adds {
                self.add_cloud(path);
            } else {
                self.open(path);
                break;
            }
        }
    }

    /// What was asked for is done, one way or another.
    fn done(&mut self, number: Option<u64>) {
        self.progress = None;
        match number {
            Some(number) if self.under_way.is_some_and(|(n, _)| n == number) => {
                self.under_way = None;
            }
            Some(number) if number == self.opening => self.loading = None,
            Some(_) | None => {}
        }
    }

    /// What could not be opened, or was stopped, may have been an edit: what is shown counts.
    pub(super) fn give_up_edits(&mut self, number: Option<u64>) {
        if number == Some(self.opening)
            && let Some(opened) = &self.opened
        {
            let shown = Document::of(&opened.scene);
            if !shown.has_points_of(self.history.now()) {
                self.history.refuse(&shown);
            }
        }
    }

    fn begin(&mut self, opened: Opened) {
        self.done(Some(opened.opening.number));
        let again = (self.opened.as_ref()).is_some_and(|o| o.opening.path == opened.opening.path);
        if !again {
            let size = self.like.size;
            let camera = fitted(&opened, size);
            self.navigator = Navigator::of(&camera);
            self.like = Camera { size, ..camera };
            self.second = None;
            self.history = History::new(Document::of(&opened.scene));
            (self.path, self.measured) = (None, Vec::new());
            (self.selected, self.moving, self.picking) = (None, None, None);
            self.film.switch_to(&opened.opening.path);
            self.times.clear();
            self.panels.remember(&opened.opening.path);
            if let Some(up) = self.panels.up_of(&opened.opening.path) {
                self.navigator.set_up(up);
            }
        }
        let fresh = opened.file == opened.opening.number;
        if fresh {
            for sentence in opened.loaded.facts.repairs.sentences() {
                self.say(sentence);
            }
        }
        if fresh && again {
            // Somebody may have changed the file.
            self.history.replace_points(&Document::of(&opened.scene));
        }
        if let Some(second) = &mut self.second {
            // It was of other points.
            second.shown = None;
        }
        self.opened = Some(opened);
        if self.loading.is_none() && !self.shows_document() {
            // It was given up just when it was there.
            self.show_edits(false);
        } else {
            self.touch();
        }
    }

    fn show(&mut self, shown: Shown, layer: Layer, context: &egui::Context) {
        self.done(Some(shown.request.number));
        let full = shown.request.detail == Detail::FULL;
        if !full || shown.request.settings.gi.vpl_count == 0 {
            self.pace.took(shown.request.detail, shown.ms);
        }
        if full {
            self.times.push_back(shown.products.passes.clone());
            while self.times.len() > KEPT {
                self.times.pop_front();
            }
        }
        if layer.buffer == self.buffer {
            self.put(layer, context);
        } else {
            self.worker.paint(self.buffer);
        }
        self.shown = Some(shown);
        if std::mem::take(&mut self.lost) {
            self.say("the graphics device was opened anew");
        }
        if let Some(second) = &mut self.second {
            // What was compared was another view.
            (second.texture, second.difference) = (None, None);
            second.lines.clear();
        }
        self.compare();
    }

    fn put(&mut self, layer: Layer, context: &egui::Context) {
        if layer.buffer != self.buffer {
            return;
        }
        self.scale = layer.scale;
        let options = egui::TextureOptions::LINEAR;
        match &mut self.texture {
            Some(texture) => texture.set(layer.image, options),
            None => self.texture = Some(context.load_texture("view", layer.image, options)),
        }
    }
}

/// The camera of a scene; one that nobody gave fits the window.
fn fitted(opened: &Opened, size: UVec2) -> Camera {
    let mut scene = opened.scene.clone();
    scene.camera.size = Some(size);
    let (bounds, up) = (opened.loaded.facts.bounds, opened.loaded.up_axis);
    scene.camera(bounds, up).unwrap_or(opened.loaded.camera)
}
