//! Writing the scene as it is now to a file.

use std::path::PathBuf;

use catoptric::scene::is_scene_file;
use eframe::egui;

use crate::viewer::app::Viewer;

/// Where the scene is to be written.
#[derive(Debug, Clone)]
pub(super) struct Form {
    path: String,
    /// Whether the camera of this view becomes that of the scene.
    with_view: bool,
    /// Whether a file that is there already is replaced.
    replaces: bool,
}

/// Opens the form.
pub(super) fn open(viewer: &mut Viewer) {
    let Some(opened) = &viewer.opened else {
        viewer.say("open a scene or a point cloud first");
        return;
    };
    let path = &opened.opening.path;
    let own = is_scene_file(path);
    let path = if own {
        path.clone()
    } else {
        path.with_extension("toml")
    };
    viewer.panels.save = Some(Form {
        path: path.display().to_string(),
        with_view: true,
        replaces: own,
    });
}

pub(super) fn show(viewer: &mut Viewer, ui: &egui::Ui) {
    let Some(mut form) = viewer.panels.save.clone() else {
        return;
    };
    let (mut stays, mut write) = (true, false);
    egui::Window::new("Save scene")
        .open(&mut stays)
        .resizable(false)
        .collapsible(false)
        .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
        .show(ui.ctx(), |ui| {
            ui.horizontal(|ui| {
                ui.label("File").on_hover_text("Folder and name; it ends in .toml");
                ui.add(egui::TextEdit::singleline(&mut form.path).desired_width(360.0))
                    .on_hover_text("Paths of clouds are written relative to this file where they lie beside or below it");
            });
            ui.checkbox(&mut form.with_view, "with the camera of this view")
                .on_hover_text("Whoever opens the scene sees what you see now");
            ui.checkbox(&mut form.replaces, "replace a file that is there")
                .on_hover_text("Comments in it stay wherever nothing has changed");
            let ready = is_scene_file(form.path.trim().as_ref());
            let save = ui.add_enabled(ready, egui::Button::new("Save"));
            write = save
                .on_hover_text("Write the scene")
                .on_disabled_hover_text("The name of a scene file ends in .toml")
                .clicked();
        });
    if write {
        let path = PathBuf::from(form.path.trim());
        viewer.save_scene(path, form.with_view, form.replaces);
        stays = false;
    }
    viewer.panels.save = stays.then_some(form);
}
