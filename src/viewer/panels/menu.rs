//! The menu, and the keys of its entries.

use eframe::egui::{self, Key, KeyboardShortcut, Modifiers};
use glam::DVec3;

use crate::viewer::app::{Purpose, Viewer};
use crate::viewer::canvas::frame_all;
use crate::viewer::history::{as_toml, quoted};
use crate::viewer::navigation::NamedView;

const OPEN: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::O);
const RELOAD: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::R);
const SAVE: KeyboardShortcut =
    KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::S);
const EXPORT: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::S);

const UPS: [(&str, DVec3); 4] = [
    ("Y up", DVec3::Y),
    ("Z up", DVec3::Z),
    ("X up", DVec3::X),
    ("-Y up", DVec3::NEG_Y),
];

const THEMES: [(egui::ThemePreference, &str); 3] = [
    (egui::ThemePreference::System, "As the system"),
    (egui::ThemePreference::Light, "Light"),
    (egui::ThemePreference::Dark, "Dark"),
];

/// Keys that work wherever the cursor is.
pub(super) fn shortcuts(viewer: &mut Viewer, ui: &egui::Ui) {
    let pressed = |shortcut: &KeyboardShortcut| ui.input_mut(|i| i.consume_shortcut(shortcut));
    if pressed(&OPEN) {
        viewer.ask_for(ui.ctx(), Purpose::Open);
    }
    if pressed(&RELOAD) {
        viewer.reload();
    }
    // Before the export, whose keys are among its own.
    if pressed(&SAVE) {
        super::save::open(viewer);
    }
    if pressed(&EXPORT) {
        super::export::open(viewer);
    }
    if ui.input(|i| i.key_pressed(Key::F1)) {
        viewer.panels.help = !viewer.panels.help;
    }
}

pub(super) fn show(viewer: &mut Viewer, ui: &mut egui::Ui) {
    egui::MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| file(viewer, ui))
            .response
            .on_hover_text("Open, save, export");
        ui.menu_button("Edit", |ui| edit(viewer, ui))
            .response
            .on_hover_text("Take changes back, copy settings");
        ui.menu_button("View", |ui| view(viewer, ui))
            .response
            .on_hover_text("Camera, panels and colours");
        if ui
            .button("Help")
            .on_hover_text("Keys and mouse (F1)")
            .clicked()
        {
            viewer.panels.help = true;
        }
    });
}

fn file(viewer: &mut Viewer, ui: &mut egui::Ui) {
    let entry = |ui: &mut egui::Ui, text: &str, shortcut: &KeyboardShortcut, about: &str| {
        let keys = ui.ctx().format_shortcut(shortcut);
        let button = egui::Button::new(text).shortcut_text(keys);
        ui.add(button).on_hover_text(about).clicked()
    };
    if entry(ui, "Open...", &OPEN, "Open a scene or a point cloud") {
        viewer.ask_for(ui.ctx(), Purpose::Open);
    }
    let any = !viewer.panels.recent.is_empty();
    let recent = ui.add_enabled_ui(any, |ui| {
        ui.menu_button("Open recent", |ui| {
            for path in viewer.panels.recent.clone() {
                let entry = ui.button(path.display().to_string());
                if entry.on_hover_text("Open it again").clicked() {
                    viewer.open(path);
                }
            }
        })
        .response
    });
    (recent.inner)
        .on_hover_text("Files that were open")
        .on_disabled_hover_text("Files that were open: none yet");
    if entry(
        ui,
        "Reload",
        &RELOAD,
        "Read the files anew; camera and settings stay",
    ) {
        viewer.reload();
    }
    ui.separator();
    let about = "Write clouds, mirrors, settings and camera as a scene file";
    if entry(ui, "Save scene...", &SAVE, about) {
        super::save::open(viewer);
    }
    if entry(
        ui,
        "Export...",
        &EXPORT,
        "Write a picture of any size, and G-buffers",
    ) {
        super::export::open(viewer);
    }
    let words = ui.button("Copy command line");
    let words = words.on_hover_text("What renders this picture without a window");
    if words.clicked() {
        let camera = viewer.camera();
        let mut words = viewer.command_line(&camera, "picture.png".as_ref());
        words.insert(0, "catoptric".into());
        ui.ctx().copy_text(quoted(&words));
        if viewer.must_be_saved() {
            viewer.say("the scene was changed: save it, and the command line renders the same");
        }
    }
    ui.separator();
    let quit = ui.button("Quit");
    if quit.on_hover_text("Close the window").clicked() {
        ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
    }
}

fn edit(viewer: &mut Viewer, ui: &mut egui::Ui) {
    let mut entry = |can: bool, text: &str, keys: &str, about: &str, none: &str| {
        let button = egui::Button::new(text).shortcut_text(keys);
        let response = ui.add_enabled(can, button).on_hover_text(about);
        response.on_disabled_hover_text(none).clicked()
    };
    let (undo, redo) = (viewer.history.can_undo(), viewer.history.can_redo());
    let about = "Take the last change of settings or scene back";
    if entry(undo, "Undo", "Ctrl+Z", about, "Nothing was changed") {
        viewer.undo();
    }
    let about = "Change again what was taken back";
    if entry(redo, "Redo", "Ctrl+Y", about, "Nothing was taken back") {
        viewer.redo();
    }
    ui.separator();
    let copy = ui.button("Copy settings as TOML");
    let copy =
        copy.on_hover_text("Those that differ from the defaults, to paste into a scene file");
    if copy.clicked() {
        ui.ctx().copy_text(as_toml(viewer.settings()));
    }
}

fn view(viewer: &mut Viewer, ui: &mut egui::Ui) {
    let frame = egui::Button::new("Frame all").shortcut_text("F");
    if ui
        .add(frame)
        .on_hover_text("Step back until everything is seen")
        .clicked()
    {
        frame_all(viewer);
        viewer.touch();
    }
    let as_opened = ui.button("As opened");
    if as_opened.on_hover_text("The camera of the scene").clicked()
        && let Some(opened) = &viewer.opened
    {
        viewer.navigator = super::super::navigation::Navigator::of(&opened.loaded.camera);
        viewer.touch();
    }
    for (named, name) in NamedView::ALL {
        let about = "Look from this side, from where everything is seen";
        if ui.button(name).on_hover_text(about).clicked()
            && let Some(opened) = &viewer.opened
        {
            let bounds = opened.loaded.facts.bounds;
            viewer.navigator.look_from(named, bounds, &viewer.like);
            viewer.touch();
        }
    }
    ui.separator();
    for (name, up) in UPS {
        let chosen = viewer.navigator.up().distance(up) < 1e-6;
        let about = "Which way is up; remembered for this file";
        if ui.radio(chosen, name).on_hover_text(about).clicked() {
            viewer.navigator.set_up(up);
            if let Some(opened) = &viewer.opened {
                viewer.panels.set_up(&opened.opening.path, up);
            }
            viewer.touch();
        }
    }
    ui.separator();
    let field = egui::Slider::new(&mut viewer.like.fov_y_degrees, 5.0..=120.0);
    let field = ui.add(field.text("field of view").suffix("\u{b0}"));
    let budget = egui::Slider::new(&mut viewer.pace.budget_ms, 10.0..=500.0).logarithmic(true);
    let about = "What a frame may take while the camera moves; fewer points are drawn then";
    ui.add(budget.text("moving frame").suffix(" ms"))
        .on_hover_text(about);
    if field.on_hover_text("Vertical, degrees").changed() {
        viewer.touch();
    }
    ui.separator();
    let mut settings = !viewer.panels.hide_settings;
    let mut numbers = !viewer.panels.hide_numbers;
    ui.checkbox(&mut settings, "Settings panel")
        .on_hover_text("Show settings and scene, on the left");
    ui.checkbox(&mut numbers, "Numbers panel")
        .on_hover_text("Show layers, comparison and times, on the right");
    let path = ui.checkbox(&mut viewer.panels.path.open, "Camera path");
    path.on_hover_text("Keyframes, preview, turntable, numbered pictures (K adds a keyframe)");
    viewer.panels.hide_settings = !settings;
    viewer.panels.hide_numbers = !numbers;
    ui.separator();
    let mut theme = ui.ctx().options(|options| options.theme_preference);
    for (preference, name) in THEMES {
        let chosen = ui.radio_value(&mut theme, preference, name);
        if chosen.on_hover_text("Colours of the interface").clicked() {
            ui.ctx().set_theme(preference);
        }
    }
}
