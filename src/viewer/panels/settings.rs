//! Every setting, made of the descriptions that the settings carry: a new one cannot be forgotten.

use catoptric::settings::{Description, Settings};
use eframe::egui::{self, RichText};
use toml::Value;

use crate::viewer::app::Viewer;

/// Width of a slider, points.
const SLIDER: f32 = 64.0;

/// What each group is about.
const GROUPS: [(&str, &str, &str); 7] = [
    ("splat", "Points", "How points are drawn"),
    ("gi", "Light", "Shadows, and light that surfaces send on"),
    (
        "reflect",
        "Mirrors",
        "How what mirrors show is found, and how often light is reflected",
    ),
    (
        "sscr",
        "Mirror search",
        "The search in screen space for points that mirrors show",
    ),
    (
        "lhc",
        "Mirror regions",
        "How mirrors are parted into regions, each of one curvature",
    ),
    (
        "ray_trace",
        "Ray tracing",
        "Reflected rays that are followed through the points",
    ),
    (
        "image",
        "Picture",
        "From light to the colours of the picture",
    ),
];

/// A name, what it changes, and the settings with their values as TOML.
type Preset = (
    &'static str,
    &'static str,
    &'static [(&'static str, &'static str)],
);

/// Names for settings that belong together, each with what it changes.
const PRESETS: [Preset; 4] = [
    ("Defaults", "Every setting as it is by default", &[]),
    (
        "Fast",
        "No indirect light, mirrors from fewer points",
        &[("gi.vpl_count", "0"), ("sscr.points_per_pixel", "2.0")],
    ),
    (
        "Accurate",
        "Reflected rays are traced, more virtual lights for every pixel",
        &[
            ("reflect.method", "\"ray_trace\""),
            ("gi.vpl_count", "1024"),
            ("gi.interleave", "2"),
        ],
    ),
    (
        "Thesis",
        "The interleaved search of the thesis",
        &[
            ("reflect.method", "\"sscr\""),
            ("sscr.search", "\"interleaved\""),
        ],
    ),
];

pub(super) fn show(viewer: &mut Viewer, ui: &mut egui::Ui) {
    ui.horizontal(|ui| {
        let presets = ui.menu_button("Presets", |ui| {
            for (name, about, values) in PRESETS {
                if ui.button(name).on_hover_text(about).clicked() {
                    preset(viewer, name, values);
                }
            }
        });
        (presets.response).on_hover_text("Settings that belong together");
        let filter = egui::TextEdit::singleline(&mut viewer.panels.filter);
        ui.add(
            filter
                .hint_text("find a setting")
                .desired_width(f32::INFINITY),
        )
        .on_hover_text("Part of a name, or of what a setting does");
    });
    ui.separator();
    let filter = viewer.panels.filter.to_lowercase();
    let settings = viewer.settings().clone();
    let mut changed = None;
    egui::ScrollArea::vertical().show(ui, |ui| {
        let described = Settings::describe();
        let mut groups: Vec<&str> = described.iter().filter_map(|d| group(&d.key)).collect();
        groups.dedup();
        for name in groups {
            let of_group: Vec<&Description> = described
                .iter()
                .filter(|d| group(&d.key) == Some(name))
                .filter(|d| {
                    filter.is_empty()
                        || d.key.contains(&filter)
                        || d.doc.to_lowercase().contains(&filter)
                })
                .collect();
            if of_group.is_empty() {
                continue;
            }
            let known = GROUPS.iter().find(|(group, _, _)| *group == name);
            let (title, about) = known.map_or((name, name), |(_, title, about)| (*title, *about));
            let open = (!filter.is_empty()).then_some(true);
            egui::CollapsingHeader::new(title)
                .id_salt(name)
                .default_open(matches!(name, "splat" | "reflect"))
                .open(open)
                .show(ui, |ui| {
                    for setting in of_group {
                        if let Some(value) = row(ui, setting, &settings) {
                            changed = Some((setting.key.clone(), value));
                        }
                    }
                })
                .header_response
                .on_hover_text(about);
        }
    });
    if let Some((key, value)) = changed {
        match settings.with(&key, value) {
            Ok(settings) => viewer.change(settings, &key),
            Err(refusal) => viewer.say(refusal.to_string()),
        }
    }
}

fn group(key: &str) -> Option<&str> {
    key.split_once('.').map(|(group, _)| group)
}

/// Sets what a preset names, on top of the scene's own settings for what it does not.
fn preset(viewer: &mut Viewer, name: &str, values: &[(&str, &str)]) {
    let mut settings = if values.is_empty() {
        Settings::default()
    } else {
        viewer.settings().clone()
    };
    for (key, text) in values {
        let value = text.parse::<Value>();
        let with = value.ok().and_then(|value| settings.with(key, value).ok());
        if let Some(with) = with {
            settings = with;
        }
    }
    viewer.change(settings, name);
}

/// A setting's name, its control, and what brings back the default; the value that was chosen.
fn row(ui: &mut egui::Ui, setting: &Description, settings: &Settings) -> Option<Value> {
    let value = settings.value(&setting.key)?;
    let name = setting.key.split_once('.').map_or("", |(_, name)| name);
    let differs = value != setting.default;
    let mut chosen = None;
    ui.spacing_mut().slider_width = SLIDER;
    ui.horizontal(|ui| {
        let mut text = RichText::new(name.replace('_', " "));
        if differs {
            text = text.strong();
        }
        ui.label(text).on_hover_text(about(setting));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let button = egui::Button::new(RichText::new("reset").small());
            let reset = ui.add_visible(differs, button.frame(false));
            let reset = reset.on_hover_text(format!("Back to {}", setting.default));
            if reset.clicked() {
                chosen = Some(setting.default.clone());
            }
            if let Some(value) = control(ui, setting, &value) {
                chosen = Some(value);
            }
        });
    });
    chosen
}

fn about(setting: &Description) -> String {
    let range = setting.range.map_or_else(String::new, |(low, high)| {
        format!("\n{low} to {high} {}", setting.unit)
    });
    format!(
        "{}\n{}{range}\ndefault {}",
        setting.key, setting.doc, setting.default
    )
}

/// The control of a value, by what it can be; the value that was chosen.
fn control(ui: &mut egui::Ui, setting: &Description, value: &Value) -> Option<Value> {
    let about = about(setting);
    match (value, setting.range) {
        (Value::Boolean(on), _) => {
            let mut on = *on;
            let response = ui.checkbox(&mut on, "").on_hover_text(about);
            response.changed().then_some(Value::Boolean(on))
        }
        (Value::Integer(number), Some((low, high))) => {
            let mut number = *number as f64;
            let slider = egui::Slider::new(&mut number, low..=high).integer();
            let response = ui.add(slid(slider, low, high)).on_hover_text(about);
            response.changed().then_some(Value::Integer(number as i64))
        }
        (Value::Float(number), Some((low, high))) => {
            let mut number = *number;
            let slider = egui::Slider::new(&mut number, low..=high);
            let slider = slid(slider, low, high).max_decimals(4);
            let response = ui.add(slider).on_hover_text(about);
            response.changed().then_some(Value::Float(number))
        }
        (Value::String(text), _) if !setting.choices.is_empty() => {
            let mut chosen = None;
            egui::ComboBox::from_id_salt(&setting.key)
                .selected_text(text)
                .show_ui(ui, |ui| {
                    for choice in setting.choices {
                        let entry = ui.selectable_label(text == choice, *choice);
                        if entry.on_hover_text(&about).clicked() {
                            chosen = Some(Value::String((*choice).to_owned()));
                        }
                    }
                })
                .response
                .on_hover_text(about);
            chosen
        }
        (Value::String(text), _) => {
            // Half-written text is no value yet: it is taken when the field is left.
            let id = ui.scope_id().with(&setting.key);
            let mut written = ui
                .data_mut(|d| d.get_temp::<String>(id))
                .unwrap_or_else(|| text.clone());
            let field = egui::TextEdit::singleline(&mut written).desired_width(100.0);
            let response = ui.add(field).on_hover_text(about);
            if response.lost_focus() {
                ui.data_mut(|d| d.remove::<String>(id));
                return (written != *text).then_some(Value::String(written));
            }
            if response.changed() {
                ui.data_mut(|d| d.insert_temp(id, written));
            }
            None
        }
        _ => None,
    }
}

/// A slider whose steps are ratios where its range is wide.
fn slid(slider: egui::Slider<'_>, low: f64, high: f64) -> egui::Slider<'_> {
    let wide = low >= 0.0 && high / low.max(1.0) >= 64.0;
    slider.logarithmic(wide)
}
