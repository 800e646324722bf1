//! What is open, as a person changes it: undo and redo, what is shown of it, saving, and the command line.

use std::path::{Path, PathBuf};
use std::time::Instant;

use catoptric::camera::Camera;
use catoptric::settings::Settings;

use super::app::Viewer;
use super::document::Document;
use super::history;
use super::letters::{Edited, Opening, Save};

impl Viewer {
    pub(super) fn document(&self) -> &Document {
        self.history.now()
    }

    pub(super) fn settings(&self) -> &Settings {
        &self.history.now().settings
    }

    /// Takes new settings; `what` changed them.
    pub(super) fn change(&mut self, settings: Settings, what: &str) {
        self.edit(what, |document| document.settings = settings);
    }

    /// Changes what is open; `what` is for undo: changes of one thing that follow one another are one step.
    pub(super) fn edit(&mut self, what: &str, change: impl FnOnce(&mut Document)) {
        let mut document = self.history.now().clone();
        change(&mut document);
        self.history.change(document, what, Instant::now());
        self.follow_history();
    }

    /// The same, as a step of its own.
    pub(super) fn edit_once(&mut self, what: &str, change: impl FnOnce(&mut Document)) {
        self.steps += 1;
        let what = format!("{what} {}", self.steps);
        self.edit(&what, change);
    }

    pub(super) fn undo(&mut self) {
        self.history.undo();
        self.follow_history();
    }

    pub(super) fn redo(&mut self) {
        self.history.redo();
        self.follow_history();
    }

    /// Shows what the document has become.
    fn follow_history(&mut self) {
        let same = match (&self.loading, &self.loading_points) {
            // Another file is on its way: it brings a document of its own.
            (Some(path), None) if self.opened.as_ref().is_none_or(|o| o.opening.path != *path) => {
                true
            }
            (Some(_), None) => self.shows_document(),
            (Some(_), Some(loading)) => loading.has_points_of(self.history.now()),
            (None, _) => self.shows_document(),
        };
        if same {
            self.touch();
        } else {
            self.show_edits(false);
        }
    }

    /// Whether the points that are shown are those of the document.
    pub(super) fn shows_document(&self) -> bool {
        let shown = self.opened.as_ref().map(|o| Document::of(&o.scene));
        shown.is_none_or(|shown| shown.has_points_of(self.history.now()))
    }

    /// Loads the document; where `reads`, what its file says besides is read anew.
    pub(super) fn show_edits(&mut self, reads: bool) {
        // A reading that was under way is not forgotten.
        let reads = reads || (self.loading.is_some() && self.loading_reads);
        if let Some(opened) = &self.opened {
            let edited = Edited {
                document: Box::new(self.history.now().clone()),
                file: opened.file,
                reads,
            };
            let opening = Opening {
                edited: Some(edited),
                ..opened.opening.clone()
            };
            self.begin_opening(opening);
        }
    }

    /// Reads what is open anew; camera, settings and edits stay.
    pub(super) fn reload(&mut self) {
        if self.is_edited() {
            self.show_edits(true);
        } else if let Some(opened) = &self.opened {
            let opening = opened.opening.clone();
            self.begin_opening(opening);
        }
    }

    /// Whether clouds or mirrors are not as the scene's file has them.
    pub(super) fn is_edited(&self) -> bool {
        let base = self.opened.as_ref().map(|o| Document::of(&o.base));
        base.is_some_and(|base| !base.has_points_of(self.history.now()))
    }

    /// Writes the scene as it is now, with the camera of this view where that is wanted.
    pub(super) fn save_scene(&mut self, path: PathBuf, with_view: bool, replaces: bool) {
        let turned = self.turned_clouds();
        let Some(opened) = &self.opened else { return };
        let mut document = self.history.now().clone();
        if with_view {
            // Normals stay turned to where the eye was when they were.
            for index in turned {
                if let Some(cloud) = document.clouds.get_mut(index) {
                    cloud.viewpoint = Some(opened.loaded.viewpoint);
                }
            }
        }
        let mut scene = document.put_into(&opened.base);
        if with_view {
            let camera = self.navigator.camera(&self.like);
            scene.camera.position = Some(camera.position);
            scene.camera.target = Some(camera.target);
            scene.camera.up = Some(camera.up);
            scene.camera.fov_y_degrees = Some(camera.fov_y_degrees);
        }
        self.history.replace_points(&document);
        self.worker.save(Save {
            scene: Box::new(scene),
            path,
            replaces,
        });
    }

    /// Clouds of which it counts where their normals were turned to: mirrors are black from behind, and these have none of
    /// their own.
    fn turned_clouds(&self) -> Vec<usize> {
        let Some(opened) = &self.opened else {
            return Vec::new();
        };
        let facts = &opened.loaded.facts;
        if facts.mirror_points == 0 {
            return Vec::new();
        }
        let clouds = opened.scene.clouds.iter().enumerate();
        let seen = clouds.filter(|(_, cloud)| cloud.visible).zip(&facts.clouds);
        seen.filter(|((_, cloud), facts)| !facts.has_normals && cloud.viewpoint.is_none())
            .map(|((index, _), _)| index)
            .collect()
    }

    /// The words that render this picture without a window; the scene must be [saved](Viewer::must_be_saved) where it has
    /// to be.
    pub(super) fn command_line(&self, camera: &Camera, output: &Path) -> Vec<String> {
        let opened = self.opened.as_ref();
        let defaults = Settings::default();
        let differences = opened.and_then(|o| history::differences(&o.base, self.document()));
        let mut differences = differences.unwrap_or_default();
        if let Some(opened) = opened {
            let [x, y, z] = opened.loaded.viewpoint.to_array();
            for index in self.turned_clouds() {
                differences.push(format!("cloud.{index}.viewpoint=[{x},{y},{z}]"));
            }
        }
        history::command_line(
            &opened.map_or_else(String::new, |o| o.opening.path.display().to_string()),
            opened.map_or(&[], |o| &o.opening.given),
            &differences,
            opened.map_or(&defaults, |o| &o.base.settings),
            self.settings(),
            camera,
            &output.display().to_string(),
        )
    }

    /// Whether the scene has become one that no command line can tell.
    pub(super) fn must_be_saved(&self) -> bool {
        let opened = self.opened.as_ref();
        opened.is_some_and(|o| history::differences(&o.base, self.document()).is_none())
    }
}
