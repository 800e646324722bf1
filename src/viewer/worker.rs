//! The thread that loads, renders and exports, so that the interface never waits.
//!
//! What it is to do next lies in a mailbox of one letter of each kind: a newer view takes the place of an older one that
//! is not begun, and stops one that takes long.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

use catoptric::camera::Camera;
use catoptric::output::{CameraDescription, Outputs, camera_gbuffer, mirror_gbuffer};
use catoptric::reflect::sscr::heat::require_search;
use catoptric::renderer::{BackendChoice, Machine, Products, Renderer};
use catoptric::scene::{LoadedScene, Override, Scene};
use catoptric::settings::Settings;
use catoptric::{Error, Job, Progress};
use eframe::egui::ColorImage;

use super::buffers::Buffer;
use super::comparison::Comparison;
use super::pace::Detail;

/// What to open.
#[derive(Debug, Clone)]
pub(super) struct Opening {
    pub(super) path: PathBuf,
    pub(super) overrides: Vec<Override>,
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

/// A scene that is open.
#[derive(Debug, Clone)]
pub(super) struct Opened {
    pub(super) path: PathBuf,
    pub(super) scene: Scene,
    pub(super) loaded: Arc<LoadedScene>,
    pub(super) backend: &'static str,
    pub(super) adapter: Option<String>,
}

/// A frame, as it was asked for.
#[derive(Clone)]
pub(super) struct Shown {
    pub(super) request: Request,
    pub(super) products: Arc<Products>,
    /// From the request's beginning to its end, milliseconds.
    pub(super) ms: f64,
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
    /// The number of the request, where it was one, and a sentence for the person.
    Failed(Option<u64>, String),
    /// What was begun was stopped.
    Stopped(Option<u64>),
}

#[derive(Default)]
struct Mailbox {
    opening: Option<Opening>,
    export: Option<Export>,
    request: Option<Request>,
    paint: Option<Buffer>,
    second: Option<Request>,
    compare: Option<Box<(Shown, Shown, Buffer)>>,
    quit: bool,
    /// What runs: its handle, and whether a newer view stops it.
    running: Option<(Job, Running)>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Running {
    Opening,
    Export,
    /// A frame of little detail: it is soon done, and shown.
    Moving,
    Still,
    Second,
}

#[derive(Default)]
struct Shared {
    mailbox: Mutex<Mailbox>,
    posted: Condvar,
}

impl Shared {
    /// The mailbox; one that a panic left behind is as good as before, since it holds no half-made letters.
    fn mailbox(&self) -> MutexGuard<'_, Mailbox> {
        self.mailbox.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The handle on the thread.
pub(super) struct Worker {
    shared: Arc<Shared>,
    events: Receiver<Event>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread; it calls `wake` after each event.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub(super) fn start(
        choice: BackendChoice,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let (sender, events) = channel();
        let post = Post {
            sender,
            wake: Arc::new(wake),
        };
        let theirs = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("rendering".into())
            .spawn(move || Studio::new(choice, post).work(&theirs))?;
        Ok(Self {
            shared,
            events,
            thread: Some(thread),
        })
    }

    /// Opens a scene; whatever else is under way is stopped.
    pub(super) fn open(&self, opening: Opening) {
        let mut mailbox = self.shared.mailbox();
        mailbox.request = None;
        mailbox.export = None;
        mailbox.second = None;
        mailbox.opening = Some(opening);
        mailbox.stop(|_| true);
        self.shared.posted.notify_one();
    }

    /// Renders a view; an older one that is not begun is forgotten, a still one under way is stopped.
    pub(super) fn render(&self, request: Request) {
        let mut mailbox = self.shared.mailbox();
        mailbox.request = Some(request);
        mailbox.stop(|running| matches!(running, Running::Still | Running::Second));
        self.shared.posted.notify_one();
    }

    /// Paints another layer of the last frame.
    pub(super) fn paint(&self, buffer: Buffer) {
        self.shared.mailbox().paint = Some(buffer);
        self.shared.posted.notify_one();
    }

    /// Renders the same view with other settings, when there is nothing else to do.
    pub(super) fn second(&self, request: Request) {
        let mut mailbox = self.shared.mailbox();
        mailbox.second = Some(request);
        mailbox.stop(|running| running == Running::Second);
        self.shared.posted.notify_one();
    }

    /// Compares a frame with one of the same view, by a layer and by what mirrors show.
    pub(super) fn compare(&self, frame: Shown, with: Shown, buffer: Buffer) {
        self.shared.mailbox().compare = Some(Box::new((frame, with, buffer)));
        self.shared.posted.notify_one();
    }

    /// Writes files.
    pub(super) fn export(&self, export: Export) {
        let mut mailbox = self.shared.mailbox();
        mailbox.export = Some(export);
        mailbox.stop(|running| matches!(running, Running::Still | Running::Second));
        self.shared.posted.notify_one();
    }

    /// Stops what is under way, and forgets what was to come.
    pub(super) fn cancel(&self) {
        let mut mailbox = self.shared.mailbox();
        mailbox.opening = None;
        mailbox.export = None;
        mailbox.request = None;
        mailbox.second = None;
        mailbox.stop(|_| true);
    }

    /// What happened since the last call.
    pub(super) fn events(&self) -> impl Iterator<Item = Event> + '_ {
        self.events.try_iter()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        let mut mailbox = self.shared.mailbox();
        mailbox.quit = true;
        mailbox.stop(|_| true);
        self.shared.posted.notify_one();
        drop(mailbox);
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been told already.
            let _ = thread.join();
        }
    }
}

impl Mailbox {
    /// The letter to answer first.
    fn next(&mut self) -> Option<(Task, Running)> {
        if let Some(opening) = self.opening.take() {
            return Some((Task::Open(opening), Running::Opening));
        }
        if let Some(export) = self.export.take() {
            return Some((Task::Export(export), Running::Export));
        }
        if let Some(request) = self.request.take() {
            let running = if request.detail == Detail::FULL {
                Running::Still
            } else {
                Running::Moving
            };
            return Some((Task::Render(request), running));
        }
        if let Some(buffer) = self.paint.take() {
            return Some((Task::Paint(buffer), Running::Moving));
        }
        if let Some(frames) = self.compare.take() {
            return Some((Task::Compare(frames), Running::Moving));
        }
        let second = self.second.take()?;
        Some((Task::Second(second), Running::Second))
    }

    fn stop(&self, which: impl Fn(Running) -> bool) {
        if let Some((job, running)) = &self.running
            && which(*running)
        {
            job.cancel();
        }
    }
}

#[derive(Clone)]
struct Post {
    sender: Sender<Event>,
    wake: Arc<dyn Fn() + Send + Sync>,
}

impl Post {
    fn send(&self, event: Event) {
        // A closed window has no more ears.
        let _ = self.sender.send(event);
        (self.wake)();
    }
}

enum Task {
    Open(Opening),
    Export(Export),
    Render(Request),
    Paint(Buffer),
    Second(Request),
    Compare(Box<(Shown, Shown, Buffer)>),
}

/// Where pictures are made: the thread's own.
struct Studio {
    choice: BackendChoice,
    post: Post,
    opened: Option<Opened>,
    full: Option<Renderer>,
    /// The renderer of the last detail that was not full.
    part: Option<(Detail, Renderer)>,
    last: Option<Shown>,
}

impl Studio {
    fn new(choice: BackendChoice, post: Post) -> Self {
        Self {
            choice,
            post,
            opened: None,
            full: None,
            part: None,
            last: None,
        }
    }

    fn work(mut self, shared: &Shared) {
        while let Some((task, job)) = self.next(shared) {
            let number = match &task {
                Task::Render(request) | Task::Second(request) => Some(request.number),
                Task::Open(_) | Task::Export(_) | Task::Paint(_) | Task::Compare(_) => None,
            };
            let done = match task {
                Task::Open(opening) => self.open(opening, &job),
                Task::Export(export) => self.export(&export, &job),
                Task::Render(request) => self.render(request, &job),
                Task::Paint(buffer) => self.paint(buffer),
                Task::Second(request) => {
                    (self.frame(request, &job)).map(|shown| Event::Second(Box::new(shown)))
                }
                Task::Compare(frames) => self.compare(&frames),
            };
            shared.mailbox().running = None;
            match done {
                Ok(event) => self.post.send(event),
                Err(Error::Cancelled) => self.post.send(Event::Stopped(number)),
                Err(error) => {
                    if matches!(error, Error::Gpu(_)) {
                        // A device that was lost is opened anew for the next frame.
                        (self.full, self.part) = (None, None);
                    }
                    self.post.send(Event::Failed(number, error.to_string()));
                }
            }
        }
    }

    /// Waits for something to do; `None` where there will be nothing more.
    fn next(&self, shared: &Shared) -> Option<(Task, Job)> {
        let mut mailbox = shared.mailbox();
        loop {
            if mailbox.quit {
                return None;
            }
            if let Some((task, running)) = mailbox.next() {
                let post = self.post.clone();
                let job = Job::with_listener(move |p| post.send(Event::Progress(p)));
                mailbox.running = Some((job.clone(), running));
                return Some((task, job));
            }
            mailbox = (shared.posted.wait(mailbox)).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn open(&mut self, opening: Opening, job: &Job) -> Result<Event, Error> {
        let scene = Scene::open(&opening.path, &opening.overrides)?;
        let loaded = Arc::new(scene.load(job)?);
        // The old scene goes before the new one is brought to the device.
        (self.full, self.part, self.opened, self.last) = (None, None, None, None);
        let full = Machine::open(&self.choice)?.upload(&loaded.surfels)?;
        let opened = Opened {
            path: opening.path,
            scene,
            loaded,
            backend: full.backend(),
            adapter: full.adapter(),
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
        if let (Some(path), Some(mirror)) = (&export.mirror_gbuffer, &products.mirror) {
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
