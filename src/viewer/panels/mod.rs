//! What stands around the picture.

mod clouds;
mod compare;
mod export;
mod fields;
mod help;
mod look;
mod menu;
mod numbers;
mod path;
mod pictures;
mod save;
mod scene;
mod settings;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use eframe::egui::{self, RichText};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::app::Viewer;
use super::canvas;

/// Files that are remembered.
const RECENT: usize = 8;

const KEY: &str = "panels";

/// What panels keep; what is serialised lasts beyond the window.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Panels {
    recent: Vec<PathBuf>,
    /// What is up in a file, where somebody changed that.
    up: BTreeMap<PathBuf, [f64; 3]>,
    hide_settings: bool,
    hide_numbers: bool,
    #[serde(skip)]
    filter: String,
    #[serde(skip)]
    help: bool,
    #[serde(skip)]
    export: Option<export::Form>,
    #[serde(skip)]
    path: path::Window,
    #[serde(skip)]
    pictures: Option<pictures::Form>,
    #[serde(skip)]
    save: Option<save::Form>,
    /// What the panel on the left shows.
    #[serde(skip)]
    tab: Tab,
}

/// What the panel on the left shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Tab {
    #[default]
    Settings,
    Scene,
}

impl Panels {
    /// Whether the scene's tree is seen.
    pub(super) fn shows_scene(&self) -> bool {
        self.tab == Tab::Scene && !self.hide_settings
    }

    pub(super) fn load(storage: Option<&dyn eframe::Storage>) -> Self {
        storage
            .and_then(|storage| eframe::get_value(storage, KEY))
            .unwrap_or_default()
    }

    pub(super) fn save(&self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, KEY, self);
    }

    /// Files that were open, the last one first.
    pub(super) fn recent(&self) -> &[PathBuf] {
        &self.recent
    }

    pub(super) fn remember(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.recent.retain(|p| *p != path);
        self.recent.insert(0, path);
        self.recent.truncate(RECENT);
    }

    pub(super) fn up_of(&self, path: &Path) -> Option<DVec3> {
        let path = std::path::absolute(path).ok()?;
        self.up.get(&path).copied().map(DVec3::from)
    }

    /// Opens the window of the camera path.
    pub(super) fn show_path(&mut self) {
        self.path.open = true;
    }

    pub(super) fn shows_path(&self) -> bool {
        self.path.open
    }

    /// Looks for settings.
    #[cfg(test)]
    pub(super) fn filter_to(&mut self, text: &str) {
        text.clone_into(&mut self.filter);
    }

    fn set_up(&mut self, path: &Path, up: DVec3) {
        if let Ok(path) = std::path::absolute(path) {
            self.up.insert(path, up.to_array());
        }
    }
}

/// The whole window.
pub(super) fn show(viewer: &mut Viewer, ui: &mut egui::Ui) {
    menu::shortcuts(viewer, ui);
    egui::Panel::top("menu").show(ui, |ui| menu::show(viewer, ui));
    egui::Panel::bottom("status").show(ui, |ui| status(viewer, ui));
    if !viewer.panels.hide_settings {
        egui::Panel::left("settings")
            .resizable(true)
            .default_size(300.0)
            .size_range(220.0..=480.0)
            .show(ui, |ui| {
                ui.horizontal(|ui| {
                    let tab = &mut viewer.panels.tab;
                    ui.selectable_value(tab, Tab::Settings, "Settings")
                        .on_hover_text("How the picture is made");
                    ui.selectable_value(tab, Tab::Scene, "Scene")
                        .on_hover_text("Clouds, mirrors and the clip box");
                });
                ui.separator();
                match viewer.panels.tab {
                    Tab::Settings => settings::show(viewer, ui),
                    Tab::Scene => scene::show(viewer, ui),
                }
            });
    }
    if !viewer.panels.hide_numbers {
        egui::Panel::right("numbers")
            .resizable(true)
            .default_size(260.0)
            .size_range(200.0..=480.0)
            .show(ui, |ui| {
                egui::ScrollArea::vertical().show(ui, |ui| {
                    look::show(viewer, ui);
                    ui.separator();
                    compare::show(viewer, ui);
                    ui.separator();
                    numbers::show(viewer, ui);
                });
            });
    }
    egui::CentralPanel::default()
        .frame(egui::Frame::NONE)
        .show(ui, |ui| canvas::show(viewer, ui));
    messages(viewer, ui);
    help::show(viewer, ui);
    export::show(viewer, ui);
    save::show(viewer, ui);
    path::show(viewer, ui);
    pictures::show(viewer, ui);
}

/// Adapter, points, what is under way.
fn status(viewer: &mut Viewer, ui: &mut egui::Ui) {
    ui.horizontal(|ui| {
        if let Some(opened) = &viewer.opened {
            let adapter = opened.adapter.as_deref().unwrap_or("the processor");
            ui.label(format!("{} ({adapter})", opened.backend))
                .on_hover_text("Where pictures are made; catoptric view --backend chooses");
            ui.separator();
            ui.label(format!("{} points", grouped(opened.loaded.facts.points)));
        }
        if let Some(shown) = &viewer.shown {
            let all = viewer.opened.as_ref().map_or(0, |o| o.loaded.surfels.len());
            let points = shown.request.detail.points(all);
            ui.separator();
            ui.label(format!(
                "{} drawn, {:.0} ms",
                grouped(points as u64),
                shown.ms
            ))
            .on_hover_text("Points of the frame that is shown, and its wall time");
        }
        if viewer.is_busy() {
            ui.separator();
            ui.spinner();
            if let Some((done, total)) = viewer.film.rendering {
                ui.label(format!("picture {} of {total}", (done + 1).min(total)));
            }
            match viewer.progress {
                Some(p) if p.total > 0 => {
                    let bar = egui::ProgressBar::new(p.done as f32 / p.total as f32);
                    ui.add(bar.desired_width(160.0).text(p.step));
                }
                Some(p) => {
                    ui.label(p.step);
                }
                None => {}
            }
            let cancel = ui.small_button("Cancel");
            if cancel
                .on_hover_text("Stop what is under way (Esc)")
                .clicked()
            {
                viewer.cancel();
            }
        }
    });
}

/// Errors and notes, until they are put away.
fn messages(viewer: &mut Viewer, ui: &egui::Ui) {
    if viewer.messages.is_empty() {
        return;
    }
    egui::Window::new("Messages")
        .anchor(egui::Align2::CENTER_BOTTOM, [0.0, -36.0])
        .collapsible(false)
        .resizable(false)
        .title_bar(false)
        .show(ui.ctx(), |ui| {
            ui.set_max_width(560.0);
            egui::ScrollArea::vertical()
                .max_height(160.0)
                .show(ui, |ui| {
                    for (failed, message) in &viewer.messages {
                        let text = RichText::new(message);
                        let red = ui.visuals().error_fg_color;
                        ui.label(if *failed { text.color(red) } else { text });
                    }
                });
            let dismiss = ui.button("Dismiss");
            if dismiss.on_hover_text("Put these messages away").clicked() {
                viewer.messages.clear();
            }
        });
}

/// Says that a command line renders the same only once the scene is saved, where that is so.
fn note_unsaved(viewer: &Viewer, ui: &mut egui::Ui) {
    if viewer.must_be_saved() {
        let warning = ui.visuals().warn_fg_color;
        ui.colored_label(
            warning,
            "The scene was changed: save it (Ctrl+Shift+S), and this renders the same.",
        );
    }
}

/// A number with its thousands apart.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{a0}');
        }
        text.push(digit);
    }
    text
}
