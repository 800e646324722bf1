//! The window of the camera path: keyframes, turntable, preview, files.

use eframe::egui::{self, Button, DragValue};

use crate::viewer::app::Viewer;
use crate::viewer::path::{MAX_SECONDS, Turntable};

/// What is said of what cannot be done yet.
const NOTHING: &str = "Open a scene or a point cloud first";
const NO_PATH: &str = "The path has no keyframes yet";
const SHORT: &str = "The path has fewer than two keyframes yet";

/// What of it is kept.
#[derive(Debug, Default)]
pub(super) struct Window {
    pub(super) open: bool,
    /// A keyframe whose time is being changed: it takes its place in the list when that is done.
    retimed: Option<(usize, f64)>,
}

/// What a person did with a keyframe.
enum Deed {
    Look,
    Replace,
    Remove,
    Retime(f64),
}

pub(super) fn show(viewer: &mut Viewer, ui: &egui::Ui) {
    if !viewer.panels.path.open {
        return;
    }
    let mut open = true;
    egui::Window::new("Camera path")
        .open(&mut open)
        .resizable(false)
        .default_pos([320.0, 60.0])
        .show(ui.ctx(), |ui| {
            ui.set_width(330.0);
            beginnings(viewer, ui);
            ui.separator();
            if viewer.film.path.turntable.is_some() {
                turntable(viewer, ui);
            } else {
                keyframes(viewer, ui);
            }
            ui.separator();
            preview(viewer, ui);
            ui.separator();
            files(viewer, ui);
        });
    viewer.panels.path.open = open;
}

fn beginnings(viewer: &mut Viewer, ui: &mut egui::Ui) {
    let ready = viewer.opened.is_some();
    ui.horizontal(|ui| {
        let add = ui.add_enabled(ready, Button::new("Add keyframe").shortcut_text("K"));
        let about = "Add the present view to the path, two seconds behind the last keyframe";
        let add = add.on_hover_text(about).on_disabled_hover_text(NOTHING);
        if add.clicked() {
            viewer.add_keyframe();
        }
        let turn = ui.add_enabled(ready, Button::new("Turntable"));
        let about = "Go once about the pivot, from the present view; keyframes are kept for later";
        let turn = turn.on_hover_text(about).on_disabled_hover_text(NOTHING);
        if turn.clicked() {
            viewer.take_turntable();
            viewer.begin_playing();
        }
    });
}

fn keyframes(viewer: &mut Viewer, ui: &mut egui::Ui) {
    let count = viewer.film.path.keyframes().len();
    if count == 0 {
        ui.weak("Look from where the path is to pass, and press K; then go on to the next view.");
        return;
    }
    let (mut done, mut retimed) = (None, viewer.panels.path.retimed);
    let height = ui.spacing().interact_size.y;
    egui::ScrollArea::vertical()
        .max_height(220.0)
        .auto_shrink([false, true])
        .show_rows(ui, height, count, |ui, rows| {
            for (index, keyframe) in viewer.film.path.keyframes().iter().enumerate() {
                if rows.contains(&index) {
                    let deed = row(ui, index, keyframe.time, &mut retimed);
                    done = done.take().or(deed.map(|deed| (index, deed)));
                }
            }
        });
    viewer.panels.path.retimed = retimed;
    if let Some((index, deed)) = done {
        viewer.film.pause();
        act(viewer, index, deed);
    }
}

/// A keyframe's row.
fn row(
    ui: &mut egui::Ui,
    index: usize,
    time: f64,
    retimed: &mut Option<(usize, f64)>,
) -> Option<Deed> {
    let mut deed = None;
    ui.horizontal(|ui| {
        let height = ui.spacing().interact_size.y;
        let number = egui::Label::new(format!("{}", index + 1));
        ui.add_sized([24.0, height], number);
        let changing = retimed.filter(|(k, _)| *k == index);
        let mut shown = changing.map_or(time, |(_, time)| time);
        let value = DragValue::new(&mut shown)
            .range(0.0..=MAX_SECONDS)
            .speed(0.05)
            .max_decimals(3)
            .suffix(" s");
        let value = ui.add(value);
        if value.changed() {
            *retimed = Some((index, shown));
        }
        let changing = retimed.is_some_and(|(k, _)| k == index);
        if changing && !value.dragged() && !value.has_focus() {
            *retimed = None;
            deed = Some(Deed::Retime(shown));
        }
        value.on_hover_text("When the camera is here; the list is in the order of time");
        let mut button = |text: &str, about: &str, what: Deed| {
            if ui.button(text).on_hover_text(about).clicked() {
                deed = Some(what);
            }
        };
        button("Go to", "Look from this keyframe", Deed::Look);
        button("Replace", "Take the present view instead", Deed::Replace);
        button("Remove", "Take it out of the path", Deed::Remove);
    });
    deed
}

fn act(viewer: &mut Viewer, index: usize, deed: Deed) {
    let Some(keyframe) = viewer.film.path.keyframes().get(index).copied() else {
        return;
    };
    match deed {
        Deed::Look => viewer.scrub(keyframe.time),
        Deed::Replace => {
            let pose = viewer.pose();
            match pose.check() {
                Ok(()) => viewer.film.path.replace(index, pose),
                Err(problem) => viewer.fail(problem),
            }
        }
        Deed::Remove => viewer.film.path.remove(index),
        Deed::Retime(time) => viewer.film.path.set_time(index, time),
    }
}

fn turntable(viewer: &mut Viewer, ui: &mut egui::Ui) {
    let Some(mut turntable) = viewer.film.path.turntable else {
        return;
    };
    let mut back = false;
    ui.horizontal(|ui| {
        ui.label("Once about the pivot in");
        let seconds = DragValue::new(&mut turntable.seconds)
            .range(Turntable::SECONDS)
            .speed(0.1)
            .max_decimals(3)
            .suffix(" s");
        ui.add(seconds).on_hover_text("How long the circle takes");
    });
    ui.horizontal(|ui| {
        let about = "Which way the camera goes, seen from above";
        for (clockwise, name) in [(false, "anticlockwise"), (true, "clockwise")] {
            let choice = ui.radio_value(&mut turntable.clockwise, clockwise, name);
            choice.on_hover_text(about);
        }
    });
    if !viewer.film.path.keyframes().is_empty() {
        let keyframes = ui.button("Keyframes");
        let about = "Put the turntable away, and follow the keyframes again";
        back = keyframes.on_hover_text(about).clicked();
    }
    if viewer.film.path.turntable != Some(turntable) || back {
        viewer.film.pause();
        viewer.film.path.turntable = (!back).then_some(turntable);
        viewer.film.at = viewer.film.path.span().0;
    }
}

fn preview(viewer: &mut Viewer, ui: &mut egui::Ui) {
    let (start, end) = viewer.film.path.span();
    let ready = viewer.opened.is_some() && end > start;
    ui.add_enabled_ui(ready, |ui| {
        let mut at = viewer.film.at.clamp(start, end);
        ui.spacing_mut().slider_width = 200.0;
        let slider = egui::Slider::new(&mut at, start..=end.max(start + 1e-3));
        // Rounding the value itself would be a change, and stop the preview.
        let slider = slider.custom_formatter(|at, _| format!("{at:.2}"));
        let slider = ui.add(slider.suffix(" s").text("time"));
        let about = "Look from the path at this time";
        let slider = slider.on_hover_text(about).on_disabled_hover_text(SHORT);
        if slider.changed() {
            viewer.film.pause();
            viewer.scrub(at);
        }
        ui.horizontal(|ui| {
            let plays = viewer.film.is_playing();
            let play = ui.button(if plays { "Pause" } else { "Play" });
            let about = "Go along the path; moving the camera or Esc stops it";
            let play = play.on_hover_text(about).on_disabled_hover_text(SHORT);
            if play.clicked() && !viewer.film.pause() {
                viewer.begin_playing();
            }
            let again = ui.checkbox(&mut viewer.film.loops, "loop");
            again
                .on_hover_text("Begin anew at the end")
                .on_disabled_hover_text(SHORT);
            let put = Button::new("Keyframe here");
            let put = ui.add_enabled(viewer.film.path.turntable.is_none(), put);
            let about = "Put the present view into the path at this time; a keyframe that is there takes it";
            let put = put.on_hover_text(about);
            let none = "A turntable has no keyframes, and a path at least two";
            if put.on_disabled_hover_text(none).clicked() {
                viewer.film.pause();
                let pose = viewer.pose();
                if let Err(problem) = viewer.film.path.put(viewer.film.at, pose) {
                    viewer.fail(problem);
                }
            }
        });
    });
}

fn files(viewer: &mut Viewer, ui: &mut egui::Ui) {
    let (ready, any) = (viewer.opened.is_some(), !viewer.film.path.is_empty());
    ui.horizontal(|ui| {
        let load = ui.add_enabled(ready, Button::new("Load..."));
        let about = "Take a path from a file (.path.toml) in place of this one; dropping the file does the same";
        let load = load.on_hover_text(about).on_disabled_hover_text(NOTHING);
        if load.clicked() {
            viewer.ask_for_path();
        }
        let save = ui.add_enabled(any, Button::new("Save..."));
        let save = save.on_hover_text("Write the path to a file");
        if save.on_disabled_hover_text(NO_PATH).clicked() {
            viewer.ask_to_save_path();
        }
        let idle = viewer.film.rendering.is_none();
        let render = ui.add_enabled(ready && any && idle, Button::new("Render pictures..."));
        let render = render.on_hover_text("Write numbered pictures along the path");
        let none = "Not while pictures are written, nor without a path";
        if render.on_disabled_hover_text(none).clicked() {
            super::pictures::open(viewer);
        }
    });
    if let Some((done, total)) = viewer.film.rendering {
        ui.horizontal(|ui| {
            let bar = egui::ProgressBar::new(done as f32 / total.max(1) as f32);
            let text = format!("picture {} of {total}", (done + 1).min(total));
            ui.add(bar.desired_width(200.0).text(text));
            let stop = ui.button("Stop");
            let about = "Write no more pictures; those that are written stay";
            if stop.on_hover_text(about).clicked() {
                viewer.worker.end_film();
            }
        });
    }
}
