//! The thread that loads, renders and exports, so that the interface never waits.
//!
//! What it is to do next lies in a mailbox of one letter of each kind: a newer view takes the place of an older one that
//! is not begun, and stops one that takes long.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use catoptric::renderer::BackendChoice;
use catoptric::{Error, Job};

use super::buffers::Buffer;
use super::letters::{Event, Export, Opening, Pick, Request, Save, Shown, Task};
use super::pace::Detail;
use super::studio::Studio;
use super::take::Take;

#[derive(Default)]
struct Mailbox {
    opening: Option<Opening>,
    export: Option<Export>,
    save: Option<Save>,
    pick: Option<Box<Pick>>,
    film: Option<Take>,
    /// Whether the pictures of a path that are under way are to end.
    ends_film: bool,
    #[cfg(test)]
    loses_device: bool,
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
    /// One of a path's pictures.
    Picture,
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
            .spawn(move || work(Studio::new(choice), &post, &theirs))?;
        Ok(Self {
            shared,
            events,
            thread: Some(thread),
        })
    }

    /// Opens a scene, or shows one as it was changed; whatever else is under way is stopped, but what is written of a scene
    /// that stays.
    pub(super) fn open(&self, opening: Opening) {
        let mut mailbox = self.shared.mailbox();
        mailbox.request = None;
        mailbox.second = None;
        mailbox.ends_film = true;
        let stays = opening.edited.is_some();
        if !stays {
            mailbox.export = None;
        }
        mailbox.opening = Some(opening);
        mailbox.stop(|running| !(stays && running == Running::Export));
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

    /// Writes the scene to a file.
    pub(super) fn save(&self, save: Save) {
        self.shared.mailbox().save = Some(save);
        self.shared.posted.notify_one();
    }

    /// Finds the surface around a pixel of the last frame.
    pub(super) fn pick(&self, pick: Pick) {
        self.shared.mailbox().pick = Some(Box::new(pick));
        self.shared.posted.notify_one();
    }

    /// Writes pictures of a path, one by one, whenever no view is asked for. There is to be none under way.
    pub(super) fn film(&self, take: Take) {
        let mut mailbox = self.shared.mailbox();
        mailbox.film = Some(take);
        mailbox.ends_film = false;
        self.shared.posted.notify_one();
    }

    /// Writes no more pictures of a path; those that are written stay.
    pub(super) fn end_film(&self) {
        let mut mailbox = self.shared.mailbox();
        mailbox.ends_film = true;
        mailbox.stop(|running| running == Running::Picture);
        self.shared.posted.notify_one();
    }

    /// Stops what is under way, and forgets what was to come.
    pub(super) fn cancel(&self) {
        let mut mailbox = self.shared.mailbox();
        mailbox.opening = None;
        mailbox.export = None;
        mailbox.request = None;
        mailbox.second = None;
        mailbox.ends_film = true;
        mailbox.stop(|_| true);
    }

    /// Takes the graphics device away before anything else is begun.
    #[cfg(test)]
    pub(super) fn lose_device(&self) {
        self.shared.mailbox().loses_device = true;
        self.shared.posted.notify_one();
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
    /// The letter to answer first; `films` tells whether pictures of a path are under way.
    fn next(&mut self, films: bool) -> Option<(Task, Running)> {
        // Begun before it ends, so that its end is told.
        if let Some(take) = self.film.take() {
            return Some((Task::Film(take), Running::Picture));
        }
        if std::mem::take(&mut self.ends_film) && films {
            return Some((Task::EndFilm, Running::Picture));
        }
        #[cfg(test)]
        if std::mem::take(&mut self.loses_device) {
            return Some((Task::Lose, Running::Moving));
        }
        // What is written is of the scene as it was when that was asked for.
        if let Some(save) = self.save.take() {
            return Some((Task::Save(save), Running::Export));
        }
        if let Some(export) = self.export.take() {
            return Some((Task::Export(export), Running::Export));
        }
        if let Some(opening) = self.opening.take() {
            return Some((Task::Open(opening), Running::Opening));
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
        if let Some(pick) = self.pick.take() {
            return Some((Task::Pick(pick), Running::Moving));
        }
        if let Some(frames) = self.compare.take() {
            return Some((Task::Compare(frames), Running::Moving));
        }
        if films {
            return Some((Task::Picture, Running::Picture));
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

/// Answers letters until the window is closed.
fn work(mut studio: Studio, post: &Post, shared: &Shared) {
    while let Some((task, job)) = next(post, shared, studio.film.is_some()) {
        let number = match &task {
            Task::Render(request) | Task::Second(request) => Some(request.number),
            Task::Open(opening) => Some(opening.number),
            Task::Export(_) | Task::Save(_) | Task::Pick(_) | Task::Paint(_) | Task::Compare(_) => {
                None
            }
            Task::Film(_) | Task::Picture | Task::EndFilm => None,
            #[cfg(test)]
            Task::Lose => None,
        };
        let done = studio.answer(task, &job);
        shared.mailbox().running = None;
        post.send(match done {
            Ok(event) => event,
            Err(Error::Cancelled) => Event::Stopped(number),
            Err(error @ Error::Gpu(_)) => Event::Lost(number, error.to_string()),
            Err(error) => Event::Failed(number, error.to_string()),
        });
    }
}

/// Waits for something to do; `None` where there will be nothing more.
fn next(post: &Post, shared: &Shared, films: bool) -> Option<(Task, Job)> {
    let mut mailbox = shared.mailbox();
    loop {
        if mailbox.quit {
            return None;
        }
        if let Some((task, running)) = mailbox.next(films) {
            let post = post.clone();
            let job = Job::with_listener(move |p| post.send(Event::Progress(p)));
            mailbox.running = Some((job.clone(), running));
            return Some((task, job));
        }
        mailbox = (shared.posted.wait(mailbox)).unwrap_or_else(PoisonError::into_inner);
    }
}
