//! Opening scenes, showing what was changed of them, and writing them: in the rendering thread.

use std::path::Path;
use std::sync::Arc;
use std::time::SystemTime;

use catoptric::renderer::BackendChoice;
use catoptric::scene::{PointCache, Scene};
use catoptric::{Error, Job};

use super::document::Document;
use super::letters::{Event, Opened, Opening, Save, Saved};
use super::studio::{Studio, machine};

impl Studio {
    /// Opens a file, or shows the scene that is open as it was changed.
    pub(super) fn open(&mut self, opening: Opening, job: &Job) -> Result<Event, Error> {
        let (file, opening, written, base, scene) = self.what_to_show(opening)?;
        // The points of another file are kept apart, so that those of this one stay where it cannot be read.
        let other = (self.opened.as_ref()).is_none_or(|o| o.opening.path != opening.path);
        let mut fresh = other.then(PointCache::for_editing);
        let cache = fresh.as_mut().unwrap_or(&mut self.points);
        let loaded = Arc::new(scene.load_with(cache, job)?);
        // The old points go before the new ones are brought to the device; where these cannot be, the old come back.
        (self.full, self.part) = (None, None);
        let machine = machine(&mut self.machine, &self.choice)?;
        self.full = Some(machine.bring(&loaded.surfels)?);
        let opened = Opened {
            opening,
            file,
            written,
            base,
            scene,
            loaded,
            backend: machine.backend(),
            adapter: machine.adapter(),
        };
        // What was chosen once is not looked for again.
        self.choice = match &opened.adapter {
            Some(adapter) => BackendChoice::Gpu(Some(adapter.clone())),
            None => BackendChoice::Cpu,
        };
        if let Some(fresh) = fresh {
            self.points = fresh;
        }
        (self.last, self.lights) = (None, None);
        self.opened = Some(opened.clone());
        Ok(Event::Opened(Box::new(opened)))
    }

    /// The number of the opening that brought the file, what is opened, when it was written, and the scene as it was and as
    /// it is to be.
    fn what_to_show(
        &self,
        opening: Opening,
    ) -> Result<(u64, Opening, Option<SystemTime>, Scene, Scene), Error> {
        let Some(edited) = &opening.edited else {
            let written = written(&opening.path);
            let scene = Scene::open(&opening.path, &opening.overrides)?;
            return Ok((opening.number, opening, written, scene.clone(), scene));
        };
        // An edit of a scene that is no longer open changes nothing.
        let opened = self.opened.as_ref().filter(|o| o.file == edited.file);
        let opened = opened.ok_or(Error::Cancelled)?;
        let own = Opening {
            number: opening.number,
            edited: None,
            ..opened.opening.clone()
        };
        let (written, base) = if edited.reads {
            let written = written(&own.path);
            (written, Scene::open(&own.path, &own.overrides)?)
        } else {
            (opened.written, opened.base.clone())
        };
        let scene = edited.document.put_into(&base);
        Ok((opened.file, own, written, base, scene))
    }

    /// Writes the scene; from now on it is the one of that file.
    pub(super) fn save(&mut self, save: Save) -> Result<Event, Error> {
        let opened = self.opened.as_mut().ok_or(Error::Cancelled)?;
        let Save {
            scene,
            path,
            replaces,
        } = save;
        let refuse = |what: &str| Err(Error::Setting(format!("{} {what}", path.display())));
        if path == opened.opening.path {
            if written(&path) != opened.written {
                return refuse(
                    "was changed by somebody else since it was opened; reload it (Ctrl+R), or save under another name",
                );
            }
        } else if !replaces && path.exists() {
            return refuse("is there already; choose another name, or replace it");
        }
        let read = scene.save(&path)?;
        let (asked, told) = (Document::of(&scene), Document::of(&read));
        if Document::of(&opened.scene).has_points_of(&asked) {
            opened.scene = told.put_into(&opened.scene);
        }
        opened.written = written(&path);
        opened.opening = Opening {
            number: opened.opening.number,
            path,
            overrides: Vec::new(),
            given: Vec::new(),
            edited: None,
        };
        opened.base = read;
        Ok(Event::Saved(Box::new(Saved {
            opened: opened.clone(),
            asked,
            read: told,
        })))
    }
}

fn written(path: &Path) -> Option<SystemTime> {
    std::fs::metadata(path).and_then(|m| m.modified()).ok()
}
