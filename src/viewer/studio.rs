//! Where scenes are opened, and pictures made and written: what the rendering thread does.

use std::sync::Arc;
use std::time::Instant;

use catoptric::camera::Camera;
use catoptric::output::{CameraDescription, Outputs, camera_gbuffer, mirror_gbuffer};
use catoptric::reflect::MirrorGBuffer;
use catoptric::reflect::sscr::heat::require_search;
use catoptric::renderer::{BackendChoice, Machine, Products, Resident};
use catoptric::scene::{PointCache, Scene};
use catoptric::settings::Settings;
use catoptric::{Error, Job};
use glam::{DVec3, UVec2};

use super::buffers::Buffer;
use super::comparison::Comparison;
use super::letters::{Event, Export, Layer, Opened, Opening, Request, Save, Shown, Task};
use super::pace::Detail;
use super::pick;
use super::take::Filming;

/// The scene that is open, on its backend.
pub(super) struct Studio {
    choice: BackendChoice,
    /// Opened when it is first needed, and again where it was lost.
    machine: Option<Machine>,
    points: PointCache,
    pub(super) opened: Option<Opened>,
    full: Option<Resident>,
    /// The first points, of the last detail that was not full.
    part: Option<(Detail, Resident)>,
    last: Option<Shown>,
    /// Pictures of a path that are being written.
    pub(super) film: Option<Filming>,
}

impl Studio {
    pub(super) fn new(choice: BackendChoice) -> Self {
        Self {
            choice,
            machine: None,
            points: PointCache::for_editing(),
            opened: None,
            full: None,
            part: None,
            last: None,
            film: None,
        }
    }

    /// Does what was asked for.
    ///
    /// # Errors
    /// What it meets; a device that was lost is opened anew for the next frame.
    pub(super) fn answer(&mut self, task: Task, job: &Job) -> Result<Event, Error> {
        let films = matches!(task, Task::Picture);
        let done = match task {
            Task::Open(opening) => self.open(opening, job),
            Task::Export(export) => self.export(&export, job),
            Task::Save(save) => self.save(save),
            Task::Pick(pixel) => self.pick(pixel),
            Task::Film(take) => Ok(self.begin_film(take)),
            Task::Picture => self.picture(job),
            Task::EndFilm => Ok(self.end_film(None)),
            Task::Render(request) => self.render(request, job),
            Task::Paint(buffer) => self.paint(buffer),
            Task::Second(request) => {
                (self.frame(request, job)).map(|shown| Event::Second(Box::new(shown)))
            }
            Task::Compare(frames) => self.compare(&frames),
            #[cfg(test)]
            Task::Lose => self.lose_device(),
        };
        if matches!(done, Err(Error::Gpu(_))) {
            (self.machine, self.full, self.part) = (None, None, None);
        }
        match done {
            Err(error) if films => Ok(self.end_film(Some(error))),
            done => done,
        }
    }

    #[cfg(test)]
    fn lose_device(&self) -> Result<Event, Error> {
        let device = self.machine.as_ref().and_then(Machine::device);
        device.ok_or(Error::Cancelled)?.raw().destroy();
        Err(Error::Cancelled)
    }

    fn open(&mut self, opening: Opening, job: &Job) -> Result<Event, Error> {
        let (base, scene) = match (&opening.edited, &self.opened) {
            (Some(edited), Some(opened)) => (opened.base.clone(), (**edited).clone()),
            _ => {
                let scene = Scene::open(&opening.path, &opening.overrides)?;
                (scene.clone(), scene)
            }
        };
        let again = |opened: &Opened| opened.opening.path == opening.path;
        if !self.opened.as_ref().is_some_and(again) {
            self.points = PointCache::for_editing();
        }
        let loaded = Arc::new(scene.load_with(&mut self.points, job)?);
        // The old points go before the new ones are brought to the device; where these cannot be, the old come back.
        (self.full, self.part) = (None, None);
        let machine = open(&mut self.machine, &self.choice)?;
        self.full = Some(machine.bring(&loaded.surfels)?);
        let opened = Opened {
            opening: Opening {
                edited: None,
                ..opening
            },
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
        self.last = None;
        self.opened = Some(opened.clone());
        Ok(Event::Opened(Box::new(opened)))
    }

    /// Writes the scene; from now on it is the one of that file.
    fn save(&mut self, save: Save) -> Result<Event, Error> {
        let opened = self.opened.as_mut().ok_or(Error::Cancelled)?;
        let Save {
            scene,
            path,
            replaces,
        } = save;
        if !replaces && path.exists() {
            return Err(Error::Setting(format!(
                "{} is there already; choose another name, or replace it",
                path.display()
            )));
        }
        let read = scene.save(&path)?;
        opened.opening = Opening {
            path,
            overrides: Vec::new(),
            given: Vec::new(),
            edited: None,
            ..opened.opening
        };
        (opened.base, opened.scene) = (read.clone(), read);
        Ok(Event::Saved(Box::new(opened.clone())))
    }

    fn pick(&self, pixel: UVec2) -> Result<Event, Error> {
        let open = self.opened.as_ref().zip(self.last.as_ref());
        let (opened, shown) = open.ok_or(Error::Cancelled)?;
        let (origin, spacing) = (opened.loaded.surfels.origin, opened.loaded.facts.spacing);
        let found = pick::region(&shown.products, origin, pixel, spacing);
        Ok(Event::Picked(found))
    }

    /// What is open, the machine, and as many of the points on it.
    fn stage(&mut self, detail: Detail) -> Result<(&Opened, &mut Machine, &mut Resident), Error> {
        let Some(opened) = &self.opened else {
            return Err(Error::Setting("open a scene or a point cloud first".into()));
        };
        let machine = open(&mut self.machine, &self.choice)?;
        let surfels = &opened.loaded.surfels;
        if detail.points(surfels.len()) == surfels.len() {
            let full = match self.full.take() {
                Some(full) => full,
                None => machine.bring(surfels)?,
            };
            return Ok((opened, machine, self.full.insert(full)));
        }
        let part = match self.part.take() {
            Some((of, part)) if of == detail => part,
            _ => machine.bring(&detail.of(surfels))?,
        };
        Ok((opened, machine, &mut self.part.insert((detail, part)).1))
    }

    fn frame(&mut self, request: Request, job: &Job) -> Result<Shown, Error> {
        let detail = request.detail;
        let (opened, machine, points) = self.stage(detail)?;
        let start = Instant::now();
        let camera = Camera {
            size: detail.size(request.camera.size),
            ..request.camera
        };
        let mut plan = opened.loaded.plan(&request.settings);
        let heat = request.buffer.needs_search_heat();
        if heat && require_search(&request.settings).is_ok() {
            plan.ask_for_search_heat(&request.settings)?;
        }
        let view = opened.loaded.view_from(&camera)?;
        let products = machine.render(points, &view, &plan, &request.settings, job)?;
        Ok(Shown {
            products: Arc::new(products),
            ms: start.elapsed().as_secs_f64() * 1e3,
            request,
        })
    }

    fn render(&mut self, request: Request, job: &Job) -> Result<Event, Error> {
        let shown = self.frame(request, job)?;
        self.last = Some(shown.clone());
        let layer = Layer::new(&shown, shown.request.buffer);
        Ok(Event::Shown(Box::new(shown), layer))
    }

    fn compare(&self, frames: &(Shown, Shown, Buffer)) -> Result<Event, Error> {
        let opened = self.opened.as_ref().ok_or(Error::Cancelled)?;
        let (frame, with, buffer) = frames;
        let origin = opened.loaded.surfels.origin;
        let comparison = Comparison::new(frame, with, *buffer, origin)?;
        Ok(Event::Compared(Box::new(comparison)))
    }

    fn paint(&mut self, buffer: Buffer) -> Result<Event, Error> {
        let shown = self.last.as_ref().ok_or(Error::Cancelled)?;
        Ok(Event::Painted(Layer::new(shown, buffer)))
    }

    /// What a camera sees in full, and what positions are relative to.
    pub(super) fn products(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        job: &Job,
    ) -> Result<(Products, DVec3), Error> {
        let (opened, machine, points) = self.stage(Detail::FULL)?;
        let loaded = &opened.loaded;
        let (plan, view) = (loaded.plan(settings), loaded.view_from(camera)?);
        let products = machine.render(points, &view, &plan, settings, job)?;
        Ok((products, loaded.surfels.origin))
    }

    fn export(&mut self, export: &Export, job: &Job) -> Result<Event, Error> {
        let (products, origin) = self.products(&export.camera, &export.settings, job)?;
        let mut outputs = Outputs::default();
        if let Some(path) = &export.picture {
            let image = &export.settings.image;
            outputs.stage_picture(path, &products.radiance, image, job)?;
        }
        if let Some(path) = &export.gbuffer {
            outputs.stage_exr(path, camera_gbuffer(&products.gbuffer, origin), job)?;
        }
        if let Some(path) = &export.mirror_gbuffer {
            let nothing = MirrorGBuffer::empty(export.camera.size);
            let mirror = products.mirror.as_ref().unwrap_or(&nothing);
            outputs.stage_exr(path, mirror_gbuffer(mirror, origin), job)?;
        }
        if let Some(path) = &export.camera_json {
            outputs.stage_json(path, &CameraDescription::new(&export.camera, origin)?)?;
        }
        outputs.commit(job)?;
        let files = [
            &export.picture,
            &export.gbuffer,
            &export.mirror_gbuffer,
            &export.camera_json,
        ];
        Ok(Event::Exported(
            files.into_iter().flatten().cloned().collect(),
        ))
    }
}

/// The machine, opened where it is not yet.
fn open<'a>(
    machine: &'a mut Option<Machine>,
    choice: &BackendChoice,
) -> Result<&'a mut Machine, Error> {
    let opened = match machine.take() {
        Some(opened) => opened,
        None => Machine::open(choice)?,
    };
    Ok(machine.insert(opened))
}
