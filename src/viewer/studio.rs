//! Where scenes are opened, and pictures made and written: what the rendering thread does.

use std::sync::Arc;
use std::time::Instant;

use catoptric::camera::Camera;
use catoptric::gi::virtual_lights::VirtualLights;
use catoptric::output::{CameraDescription, Outputs, camera_gbuffer, mirror_gbuffer};
use catoptric::reflect::MirrorGBuffer;
use catoptric::reflect::sscr::heat::require_search;
use catoptric::renderer::{BackendChoice, Machine, Products, Resident};
use catoptric::scene::PointCache;
use catoptric::settings::Settings;
use catoptric::{Error, Job};
use glam::DVec3;

use super::buffers::Buffer;
use super::comparison::Comparison;
use super::letters::{Event, Export, Layer, Opened, Pick, Request, Shown, Task};
use super::pace::Detail;
use super::pick;
use super::take::Filming;

/// The scene that is open, on its backend.
pub(super) struct Studio {
    pub(super) choice: BackendChoice,
    /// Opened when it is first needed, and again where it was lost.
    pub(super) machine: Option<Machine>,
    pub(super) points: PointCache,
    pub(super) opened: Option<Opened>,
    pub(super) full: Option<Resident>,
    /// The first points, of the last detail that was not full.
    pub(super) part: Option<(Detail, Resident)>,
    pub(super) last: Option<Shown>,
    /// Those of the last whole frame: they stay the same while the camera moves.
    pub(super) lights: Option<Arc<VirtualLights>>,
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
            lights: None,
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
            Task::Pick(pick) => {
                let Pick { shown, pixel } = *pick;
                let found = pick::region(&shown.products, shown.origin, pixel, shown.spacing);
                Ok(Event::Picked(found))
            }
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

    /// What is open, the machine, and as many of the points on it.
    fn stage(&mut self, detail: Detail) -> Result<(&Opened, &mut Machine, &mut Resident), Error> {
        let Some(opened) = &self.opened else {
            return Err(Error::Setting("open a scene or a point cloud first".into()));
        };
        let machine = machine(&mut self.machine, &self.choice)?;
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
        if request.buffer.needs_virtual_lights() {
            plan.ask_for_virtual_lights();
        }
        let view = opened.loaded.view_from(&camera)?;
        let products = machine.render(points, &view, &plan, &request.settings, job)?;
        Ok(Shown {
            products: Arc::new(products),
            ms: start.elapsed().as_secs_f64() * 1e3,
            request,
            origin: opened.loaded.surfels.origin,
            spacing: opened.loaded.facts.spacing,
        })
    }

    fn render(&mut self, request: Request, job: &Job) -> Result<Event, Error> {
        let mut shown = self.frame(request, job)?;
        if shown.request.whole {
            self.lights.clone_from(&shown.products.virtual_lights);
        } else if shown.request.buffer.needs_virtual_lights()
            && let Some(products) = Arc::get_mut(&mut shown.products)
        {
            products.virtual_lights.clone_from(&self.lights);
        }
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
pub(super) fn machine<'a>(
    machine: &'a mut Option<Machine>,
    choice: &BackendChoice,
) -> Result<&'a mut Machine, Error> {
    let opened = match machine.take() {
        Some(opened) => opened,
        None => Machine::open(choice)?,
    };
    Ok(machine.insert(opened))
}
