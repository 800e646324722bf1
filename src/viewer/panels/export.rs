//! Writing pictures and G-buffers of any size, and the command line that makes the same.

use std::path::PathBuf;

use catoptric::camera::{Camera, MAX_SIZE};
use eframe::egui;
use glam::UVec2;

use crate::viewer::app::Viewer;
use crate::viewer::history::quoted;
use crate::viewer::letters::Export;

/// What is to be written.
#[derive(Debug, Clone)]
pub(super) struct Form {
    /// Where, without an ending.
    stem: String,
    size: UVec2,
    picture: bool,
    gbuffer: bool,
    mirror_gbuffer: bool,
    camera_json: bool,
}

/// Opens the form.
pub(super) fn open(viewer: &mut Viewer) {
    let Some(opened) = &viewer.opened else {
        viewer.say("open a scene or a point cloud first");
        return;
    };
    let name = opened.opening.path.file_stem().unwrap_or_default();
    viewer.panels.export = Some(Form {
        stem: name.to_string_lossy().into_owned(),
        size: opened.loaded.camera.size,
        picture: true,
        gbuffer: false,
        mirror_gbuffer: false,
        camera_json: false,
    });
}

pub(super) fn show(viewer: &mut Viewer, ui: &egui::Ui) {
    let Some(mut form) = viewer.panels.export.clone() else {
        return;
    };
    let (mut stays, mut write) = (true, false);
    let camera = Camera {
        size: form.size,
        ..viewer.camera()
    };
    let words = {
        let mut words = viewer.command_line(&camera, &file(&form, "png"));
        words.insert(0, "catoptric".into());
        quoted(&words)
    };
    egui::Window::new("Export")
        .open(&mut stays)
        .resizable(false)
        .collapsible(false)
        .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
        .show(ui.ctx(), |ui| {
            write = fields(ui, &mut form);
            ui.separator();
            super::note_unsaved(viewer, ui);
            ui.weak("The same without a window:");
            egui::ScrollArea::vertical()
                .max_height(80.0)
                .show(ui, |ui| {
                    ui.set_max_width(420.0);
                    ui.monospace(&words);
                });
            let copy = ui.button("Copy");
            if copy.on_hover_text("Copy the command line").clicked() {
                ui.ctx().copy_text(words);
            }
        });
    if write {
        let named = |wanted: bool, ending: &str| wanted.then(|| file(&form, ending));
        let export = Export {
            camera,
            settings: viewer.settings().clone(),
            picture: named(form.picture, "png"),
            gbuffer: named(form.gbuffer, "gbuffer.exr"),
            mirror_gbuffer: named(form.mirror_gbuffer, "mirror.exr"),
            camera_json: named(form.camera_json, "camera.json"),
        };
        viewer.export(export);
        stays = false;
    }
    viewer.panels.export = stays.then_some(form);
}

/// Whether they are to be written.
fn fields(ui: &mut egui::Ui, form: &mut Form) -> bool {
    egui::Grid::new("export").num_columns(2).show(ui, |ui| {
        let about = "Folder and name, without an ending";
        ui.label("Name").on_hover_text(about);
        ui.add(egui::TextEdit::singleline(&mut form.stem).desired_width(300.0))
            .on_hover_text(about);
        ui.end_row();
        ui.label("Size").on_hover_text("Width and height, pixels");
        ui.horizontal(|ui| {
            ui.add(egui::DragValue::new(&mut form.size.x).range(1..=MAX_SIZE))
                .on_hover_text("Width, pixels");
            ui.label("x");
            ui.add(egui::DragValue::new(&mut form.size.y).range(1..=MAX_SIZE))
                .on_hover_text("Height, pixels");
        });
        ui.end_row();
    });
    ui.checkbox(&mut form.picture, "picture (.png)")
        .on_hover_text("What is seen, as it is seen");
    ui.checkbox(&mut form.gbuffer, "camera G-buffer (.gbuffer.exr)")
        .on_hover_text("Position, normal, depth and albedo of every pixel");
    ui.checkbox(&mut form.mirror_gbuffer, "mirrors' G-buffer (.mirror.exr)")
        .on_hover_text("The same of what mirrors show");
    ui.checkbox(&mut form.camera_json, "camera (.camera.json)")
        .on_hover_text("Its matrices, and where the buffers' positions are measured from");
    let any = form.picture || form.gbuffer || form.mirror_gbuffer || form.camera_json;
    let ready = any && !form.stem.trim().is_empty();
    ui.add_enabled(ready, egui::Button::new("Write"))
        .on_hover_text(
            "Render in this size, and write the files; those that are there are replaced",
        )
        .on_disabled_hover_text("Give a name, and choose what to write")
        .clicked()
}

fn file(form: &Form, ending: &str) -> PathBuf {
    PathBuf::from(format!("{}.{ending}", form.stem.trim()))
}
