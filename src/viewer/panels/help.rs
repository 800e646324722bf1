//! Keys and mouse.

use eframe::egui;

use crate::viewer::app::Viewer;

const KEYS: [(&str, &str); 24] = [
    ("drag", "turn about the pivot"),
    ("right drag", "look around"),
    ("middle drag, Shift drag", "shift"),
    ("wheel", "go to what is under the cursor, or away"),
    ("double click", "put the pivot on a point"),
    (
        "click on a mirror",
        "draw the way from the eye over the mirror to the point",
    ),
    ("Shift click", "measure between two points"),
    ("W A S D, Q E", "fly; with Shift faster"),
    ("F", "frame all"),
    ("Ctrl+0 to 9", "store the camera; 0 to 9 recalls it"),
    ("K", "add a keyframe to the camera path"),
    ("+ -", "larger, smaller points"),
    ("Ctrl+Z, Ctrl+Y", "undo, redo settings"),
    ("Ctrl+O", "open"),
    ("Ctrl+R", "reload"),
    ("Ctrl+S", "export"),
    ("Ctrl+Shift+S", "save the scene"),
    ("G, R, T", "move, turn, scale what is chosen of the scene"),
    ("Delete", "take it out of the scene"),
    ("Esc", "stop what is under way or plays, put marks away"),
    ("drop a file", "open it"),
    ("drop with Shift", "add a cloud to what is open"),
    ("Ctrl + -", "larger, smaller interface"),
    ("F1", "this help"),
];

pub(super) fn show(viewer: &mut Viewer, ui: &egui::Ui) {
    let mut open = viewer.panels.help;
    egui::Window::new("Keys and mouse")
        .open(&mut open)
        .resizable(false)
        .collapsible(false)
        .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
        .show(ui.ctx(), |ui| {
            egui::Grid::new("keys")
                .num_columns(2)
                .striped(true)
                .show(ui, |ui| {
                    for (keys, what) in KEYS {
                        ui.strong(keys);
                        ui.label(what);
                        ui.end_row();
                    }
                });
        });
    viewer.panels.help = open;
}
