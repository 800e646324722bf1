//! The camera path of what is open: making it, its preview in the window, its files, its pictures.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Instant;

use catoptric::output::write_atomically;
use eframe::egui;

use super::app::Viewer;
use super::navigation::Navigator;
use super::path::{self, CameraPath, Pose, Turntable};
use super::take::{Filmed, Take};

/// What came of reading or writing the file of a path.
enum Told {
    Read(CameraPath),
    Wrote(PathBuf),
    Failed(String),
}

/// The camera path of what is open.
pub(super) struct Film {
    pub(super) path: CameraPath,
    /// Where the preview is, seconds.
    pub(super) at: f64,
    /// Whether the preview begins anew at its end.
    pub(super) loops: bool,
    playing: Option<Playing>,
    /// Pictures that are written, and all that are to be, while they are.
    pub(super) rendering: Option<(usize, usize)>,
    /// What the path belongs to.
    file: PathBuf,
    others: BTreeMap<PathBuf, CameraPath>,
    told: (Sender<Told>, Receiver<Told>),
    context: egui::Context,
}

/// A preview that runs.
struct Playing {
    begun: Instant,
    /// Where it was then, seconds.
    from: f64,
    /// The view that it showed last, and its field of view: another one is a person's.
    view: (Navigator, f64),
}

impl Film {
    pub(super) fn new(context: &egui::Context) -> Self {
        Self {
            context: context.clone(),
            path: CameraPath::default(),
            at: 0.0,
            loops: false,
            playing: None,
            rendering: None,
            file: PathBuf::new(),
            others: BTreeMap::new(),
            told: channel(),
        }
    }

    pub(super) fn is_playing(&self) -> bool {
        self.playing.is_some()
    }

    /// Stops the preview where it is; tells whether there was one.
    pub(super) fn pause(&mut self) -> bool {
        self.playing.take().is_some()
    }

    /// The scene has another file now.
    pub(super) fn belongs_to(&mut self, file: &Path) {
        self.file = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
    }

    /// Takes the path of another scene, and keeps this one for when its scene is open again.
    pub(super) fn switch_to(&mut self, file: &Path) {
        self.pause();
        let before = std::mem::take(&mut self.file);
        self.belongs_to(file);
        let path = std::mem::take(&mut self.path);
        if !path.is_empty() {
            self.others.insert(before, path);
        }
        self.path = self.others.remove(&self.file).unwrap_or_default();
        self.at = self.path.span().0;
    }
}

impl Viewer {
    /// The view as it is now.
    pub(super) fn pose(&self) -> Pose {
        Pose::of(&self.navigator.camera(&self.like))
    }

    /// Takes a view.
    pub(super) fn look_from(&mut self, pose: Pose) {
        self.navigator = Navigator::of(&pose.camera(&self.like));
        self.like.fov_y_degrees = pose.fov_y_degrees;
        self.touch();
    }

    /// Adds the view to the path, behind the last keyframe.
    pub(super) fn add_keyframe(&mut self) {
        if self.opened.is_none() {
            self.say("open a scene or a point cloud first");
            return;
        }
        self.film.pause();
        self.film.path.turntable = None;
        match self.film.path.add(self.pose()) {
            Ok(time) => self.film.at = time,
            Err(problem) => self.fail(problem),
        }
        self.panels.show_path();
    }

    /// Makes a turntable of the view; how long it takes and which way it goes stay.
    pub(super) fn take_turntable(&mut self) {
        self.film.pause();
        let turntable = Turntable::new(self.pose(), self.navigator.pivot);
        self.film.path.turntable = Some(match self.film.path.turntable {
            Some(before) => Turntable {
                seconds: before.seconds,
                clockwise: before.clockwise,
                ..turntable
            },
            None => turntable,
        });
        self.film.at = 0.0;
    }

    /// Looks from where the path is at a time.
    pub(super) fn scrub(&mut self, time: f64) {
        self.film.at = time;
        if let Some(pose) = self.film.path.pose(time) {
            self.look_from(pose);
        }
    }

    /// Begins the preview where it is, or anew where it is at its end.
    pub(super) fn begin_playing(&mut self) {
        let (start, end) = self.film.path.span();
        if self.film.path.is_empty() || self.opened.is_none() {
            return;
        }
        let at = self.film.at;
        let from = if (start..end).contains(&at) {
            at
        } else {
            start
        };
        self.scrub(from);
        self.film.playing = Some(Playing {
            begun: Instant::now(),
            from,
            view: (self.navigator, self.like.fov_y_degrees),
        });
    }

    /// Goes on with the preview, until it ends or a person moves the camera.
    pub(super) fn play(&mut self) {
        let Some(playing) = self.film.playing.take() else {
            return;
        };
        let (start, end) = self.film.path.span();
        let taken_over = playing.view != (self.navigator, self.like.fov_y_degrees);
        if taken_over || self.film.path.is_empty() {
            return;
        }
        let time = playing.from + playing.begun.elapsed().as_secs_f64();
        if time < end {
            self.scrub(time);
        } else if self.film.loops && end > start {
            self.scrub(start + (time - start).rem_euclid(end - start));
        } else {
            self.scrub(end);
            return;
        }
        self.film.playing = Some(Playing {
            view: (self.navigator, self.like.fov_y_degrees),
            ..playing
        });
        self.film.context.request_repaint();
    }

    /// Writes the pictures of the path.
    pub(super) fn begin_film(&mut self, take: Take) {
        match take.count() {
            Ok(_) if self.loading.is_some() => self.say("wait until the scene is open"),
            Ok(total) => {
                self.film.pause();
                self.film.rendering = Some((0, total));
                self.worker.film(take);
            }
            Err(problem) => self.fail(problem),
        }
    }

    /// What the pictures came to.
    pub(super) fn filmed(&mut self, filmed: &Filmed) {
        self.progress = None;
        self.film.rendering = None;
        let Filmed { written, total, .. } = filmed;
        let which = match &filmed.files {
            Some([first, last]) if first != last => {
                format!(": {} to {}", first.display(), last.display())
            }
            Some([only, _]) => format!(": {}", only.display()),
            None => String::new(),
        };
        match &filmed.problem {
            Some(problem) => self.fail(format!(
                "{problem}; {written} of {total} pictures are written{which}"
            )),
            None if written == total => self.say(format!("wrote {total} pictures{which}")),
            None => self.say(format!(
                "stopped; {written} of {total} pictures are written{which}"
            )),
        }
    }

    /// Reads a path from a file, in a thread of its own.
    pub(super) fn load_path(&mut self, file: PathBuf) {
        if self.opened.is_none() {
            self.say("open a scene or a point cloud first, then its camera path");
            return;
        }
        self.apart(move || {
            Some(match path::read(&file) {
                Ok(path) => Told::Read(path),
                Err(problem) => Told::Failed(problem),
            })
        });
    }

    /// Asks for a file, and reads a path from it.
    pub(super) fn ask_for_path(&self) {
        self.apart(|| {
            let dialog = rfd::FileDialog::new().add_filter("camera paths", &["toml"]);
            Some(match path::read(&dialog.pick_file()?) {
                Ok(path) => Told::Read(path),
                Err(problem) => Told::Failed(problem),
            })
        });
    }

    /// Asks where to write the path, and does.
    pub(super) fn ask_to_save_path(&self) {
        let path = self.film.path.clone();
        let scene = self.film.file.file_stem().unwrap_or_default();
        let name = format!("{}.path.toml", scene.to_string_lossy());
        self.apart(move || {
            let dialog = rfd::FileDialog::new().set_file_name(name);
            Some(save(&path, dialog.save_file()?))
        });
    }

    /// Does what may take long, in a thread of its own.
    fn apart(&self, what: impl FnOnce() -> Option<Told> + Send + 'static) {
        let (sender, context) = (self.film.told.0.clone(), self.film.context.clone());
        let work = move || {
            if let Some(told) = what() {
                // A closed window has no more ears.
                let _ = sender.send(told);
                context.request_repaint();
            }
        };
        if let Err(e) = std::thread::Builder::new().spawn(work) {
            log::warn!("no file can be read or written: {e}");
        }
    }

    /// What became of the path's files.
    pub(super) fn hear_film(&mut self) {
        let told: Vec<Told> = self.film.told.1.try_iter().collect();
        for told in told {
            match told {
                Told::Read(path) => {
                    self.film.pause();
                    self.film.at = path.span().0;
                    self.film.path = path;
                    self.panels.show_path();
                }
                Told::Wrote(file) => self.say(format!("wrote {}", file.display())),
                Told::Failed(problem) => self.fail(problem),
            }
        }
    }
}

fn save(path: &CameraPath, file: PathBuf) -> Told {
    let text = match path::text(path) {
        Ok(text) => text,
        Err(problem) => return Told::Failed(problem),
    };
    match write_atomically(&file, |to| to.write_all(text.as_bytes())) {
        Ok(()) => Told::Wrote(file),
        Err(error) => Told::Failed(format!("{:#}", anyhow::Error::from(error))),
    }
}
