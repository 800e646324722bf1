//! Where scenes are opened, and pictures made and written: what the rendering thread does.

use std::sync::Arc;
use std::time::Instant;

use catoptric::camera::Camera;
use catoptric::output::{CameraDescription, Outputs, camera_gbuffer, mirror_gbuffer};
use catoptric::reflect::MirrorGBuffer;
use catoptric::reflect::sscr::heat::require_search;
use catoptric::renderer::{BackendChoice, Machine, Renderer};
use catoptric::scene::Scene;
use catoptric::{Error, Job};

use super::buffers::Buffer;
use super::comparison::Comparison;
use super::letters::{Event, Export, Layer, Opened, Opening, Request, Shown, Task};
use super::pace::Detail;

/// The scene that is open, on its backend.
pub(super) struct Studio {
    choice: BackendChoice,
    opened: Option<Opened>,
    full: Option<Renderer>,
    /// The renderer of the last detail that was not full.
    part: Option<(Detail, Renderer)>,
    last: Option<Shown>,
}

impl Studio {
    pub(super) fn new(choice: BackendChoice) -> Self {
        Self {
            choice,
            opened: None,
            full: None,
            part: None,
            last: None,
        }
    }

    /// Does what was asked for.
    ///
    /// # Errors
    /// What it meets; a device that was lost is opened anew for the next frame.
    pub(super) fn answer(&mut self, task: Task, job: &Job) -> Result<Event, Error> {
        let done = match task {
            Task::Open(opening) => self.open(opening, job),
            Task::Export(export) => self.export(&export, job),
            Task::Render(request) => self.render(request, job),
            Task::Paint(buffer) => self.paint(buffer),
            Task::Second(request) => {
                (self.frame(request, job)).map(|shown| Event::Second(Box::new(shown)))
            }
            Task::Compare(frames) => self.compare(&frames),
        };
        if matches!(done, Err(Error::Gpu(_))) {
            (self.full, self.part) = (None, None);
        }
        done
    }

    fn open(&mut self, opening: Opening, job: &Job) -> Result<Event, Error> {
        let scene = Scene::open(&opening.path, &opening.overrides)?;
        let loaded = Arc::new(scene.load(job)?);
        // The old scene goes before the new one is brought to the device.
        (self.full, self.part, self.opened, self.last) = (None, None, None, None);
        let full = Machine::open(&self.choice)?.upload(&loaded.surfels)?;
        let opened = Opened {
            opening,
            scene,
            loaded,
            backend: full.backend(),
            adapter: full.adapter(),
        };
        // What was chosen once is not looked for again.
        self.choice = match &opened.adapter {
            Some(adapter) => BackendChoice::Gpu(Some(adapter.clone())),
            None => BackendChoice::Cpu,
        };
        self.full = Some(full);
        self.opened = Some(opened.clone());
        Ok(Event::Opened(Box::new(opened)))
    }

    fn renderer(&mut self, detail: Detail) -> Result<(&Opened, &mut Renderer), Error> {
        let Some(opened) = &self.opened else {
            return Err(Error::Setting("open a scene or a point cloud first".into()));
        };
        let surfels = &opened.loaded.surfels;
        let open = |surfels| Machine::open(&self.choice)?.upload(surfels);
        if detail.points(surfels.len()) == surfels.len() {
            let full = match self.full.take() {
                Some(full) => full,
                None => open(surfels)?,
            };
            return Ok((opened, self.full.insert(full)));
        }
        let part = match self.part.take() {
            Some((of, part)) if of == detail => part,
            _ => open(&detail.of(surfels))?,
        };
        Ok((opened, &mut self.part.insert((detail, part)).1))
    }

    fn frame(&mut self, request: Request, job: &Job) -> Result<Shown, Error> {
        let detail = request.detail;
        let (opened, renderer) = self.renderer(detail)?;
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
        let products = renderer.render(&view, &plan, &request.settings, job)?;
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

    fn export(&mut self, export: &Export, job: &Job) -> Result<Event, Error> {
        let (opened, renderer) = self.renderer(Detail::FULL)?;
        let loaded = &opened.loaded;
        let (plan, view) = (
            loaded.plan(&export.settings),
            loaded.view_from(&export.camera)?,
        );
        let products = renderer.render(&view, &plan, &export.settings, job)?;
        let origin = loaded.surfels.origin;
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
