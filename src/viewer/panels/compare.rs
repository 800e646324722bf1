//! Two settings side by side, and what traced rays say of the picture.

use eframe::egui;

use crate::viewer::app::Viewer;

pub(super) fn show(viewer: &mut Viewer, ui: &mut egui::Ui) {
    ui.heading("Compare");
    ui.horizontal_wrapped(|ui| {
        let keep = ui.button("Keep these settings");
        let about = "Then change some: what is kept is drawn left of the wiper, in the same view";
        if keep.on_hover_text(about).clicked() {
            let settings = viewer.settings().clone();
            viewer.compare_with("kept settings", settings);
        }
        let trace = ui.button("Trace the reference");
        let about =
            "Trace the reflected rays of this view, and measure what the mirrors show against them";
        if trace.on_hover_text(about).clicked() {
            let method = toml::Value::String("ray_trace".into());
            match viewer.settings().with("reflect.method", method) {
                Ok(settings) => viewer.compare_with("traced rays", settings),
                Err(refusal) => viewer.say(refusal.to_string()),
            }
        }
    });
    let Some(second) = &viewer.second else { return };
    ui.label(format!("left: {}", second.name));
    if let Some(refusal) = &second.refusal {
        ui.colored_label(ui.visuals().error_fg_color, refusal);
    } else if second.texture.is_none() {
        ui.horizontal(|ui| {
            ui.spinner();
            ui.weak("to come when the camera rests");
        });
    }
    egui::Grid::new("compared").num_columns(2).show(ui, |ui| {
        for (name, value) in &second.lines {
            ui.weak(*name);
            ui.label(value);
            ui.end_row();
        }
    });
    let wiper = egui::Slider::new(&mut viewer.wiper, 0.0..=1.0).show_value(false);
    ui.add(wiper.text("wiper"))
        .on_hover_text("Where the two pictures meet");
    let difference = ui.checkbox(&mut viewer.shows_difference, "difference");
    difference.on_hover_text("Where the two pictures differ, four times as bright");
    let stop = ui.button("Stop comparing");
    if stop.on_hover_text("Show one picture again").clicked() {
        viewer.second = None;
        viewer.shows_difference = false;
    }
}
