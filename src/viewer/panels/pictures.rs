//! Writing numbered pictures along the camera path, and the command line that makes one of them.

use catoptric::camera::MAX_SIZE;
use eframe::egui::{self, DragValue};
use glam::UVec2;

use crate::viewer::app::Viewer;
use crate::viewer::history::quoted;
use crate::viewer::path::RATES;
use crate::viewer::take::Take;

/// What is to be written.
#[derive(Debug, Clone)]
pub(super) struct Form {
    /// Folder and name, without number and ending.
    stem: String,
    size: UVec2,
    /// Pictures a second.
    rate: f64,
    /// The picture whose command line is shown.
    picture: usize,
}

/// Opens the form.
pub(super) fn open(viewer: &mut Viewer) {
    let Some(opened) = &viewer.opened else {
        viewer.say("open a scene or a point cloud first");
        return;
    };
    let name = opened.opening.path.file_stem().unwrap_or_default();
    viewer.panels.pictures = Some(Form {
        stem: name.to_string_lossy().into_owned(),
        size: opened.loaded.camera.size,
        rate: 25.0,
        picture: 0,
    });
}

pub(super) fn show(viewer: &mut Viewer, ui: &egui::Ui) {
    let (Some(mut form), Some(opened)) = (viewer.panels.pictures.clone(), viewer.opened.clone())
    else {
        return;
    };
    let (mut stays, mut write) = (true, false);
    let take = Take {
        path: viewer.film.path.clone(),
        rate: form.rate,
        size: form.size,
        settings: viewer.settings().clone(),
        stem: form.stem.trim().to_owned(),
    };
    let count = take.count();
    let last = count.as_ref().map_or(0, |count| count - 1);
    form.picture = form.picture.min(last);
    let camera = take.camera(form.picture, &opened);
    let words = camera.map(|camera| {
        let mut words = viewer.command_line(&camera, &take.file(form.picture));
        words.insert(0, "catoptric".into());
        quoted(&words)
    });
    egui::Window::new("Render pictures")
        .open(&mut stays)
        .resizable(false)
        .collapsible(false)
        .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
        .show(ui.ctx(), |ui| {
            fields(ui, &mut form);
            match &count {
                Ok(count) => {
                    let [first, last] = [0, last].map(|picture| take.file(picture));
                    ui.label(format!("{count} pictures, and the path:"));
                    ui.weak(format!("{} to {}", first.display(), last.display()));
                    ui.weak(take.path_file().display().to_string());
                }
                Err(problem) => {
                    ui.label(problem);
                }
            }
            let idle = viewer.film.rendering.is_none();
            let ready = count.is_ok() && idle && !take.stem.is_empty();
            let render = ui.add_enabled(ready, egui::Button::new("Write pictures"));
            let about = "One after the other, between what the window draws; files of these names are replaced";
            let none = "Not while pictures are written; a name and a path are needed";
            let render = render.on_hover_text(about).on_disabled_hover_text(none);
            write = render.clicked();
            ui.separator();
            if let Some(words) = &words {
                super::note_unsaved(viewer, ui);
                command_line(ui, &mut form.picture, last, words);
            }
        });
    if write {
        viewer.begin_film(take);
        stays = false;
    }
    viewer.panels.pictures = stays.then_some(form);
}

fn fields(ui: &mut egui::Ui, form: &mut Form) {
    egui::Grid::new("pictures").num_columns(2).show(ui, |ui| {
        let about = "Folder and name, without number and ending";
        ui.label("Name").on_hover_text(about);
        let name = egui::TextEdit::singleline(&mut form.stem).desired_width(300.0);
        ui.add(name).on_hover_text(about);
        ui.end_row();
        ui.label("Size").on_hover_text("Width and height, pixels");
        ui.horizontal(|ui| {
            let side = |ui: &mut egui::Ui, side: &mut u32, about: &str| {
                ui.add(DragValue::new(side).range(1..=MAX_SIZE))
                    .on_hover_text(about);
            };
            side(ui, &mut form.size.x, "Width, pixels");
            ui.label("x");
            side(ui, &mut form.size.y, "Height, pixels");
        });
        ui.end_row();
        ui.label("Rate").on_hover_text("Pictures a second");
        let rate = DragValue::new(&mut form.rate).range(RATES).speed(0.2);
        ui.add(rate.max_decimals(3).suffix(" a second"))
            .on_hover_text("How many pictures a second of the path is");
        ui.end_row();
    });
}

/// What makes one of the pictures without a window.
fn command_line(ui: &mut egui::Ui, picture: &mut usize, last: usize, words: &str) {
    ui.horizontal(|ui| {
        ui.weak("Without a window, picture");
        ui.add(DragValue::new(picture).range(0..=last))
            .on_hover_text("Which picture the command line makes, byte for byte");
    });
    egui::ScrollArea::vertical()
        .max_height(80.0)
        .show(ui, |ui| {
            ui.set_max_width(420.0);
            ui.monospace(words);
        });
    let copy = ui.button("Copy");
    if copy.on_hover_text("Copy the command line").clicked() {
        ui.ctx().copy_text(words.to_owned());
    }
}
