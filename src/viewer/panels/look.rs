//! Which layer is shown, what its colours mean, and what is under the cursor.

use catoptric::output::heat_colour;
use catoptric::plan::{Stage, State};
use eframe::egui::{self, Color32, Rect, Sense, Vec2};

use crate::viewer::app::Viewer;
use crate::viewer::buffers::Buffer;

pub(super) fn show(viewer: &mut Viewer, ui: &mut egui::Ui) {
    ui.heading("Layer");
    let mut buffer = viewer.buffer;
    egui::ComboBox::from_id_salt("layer")
        .width(ui.available_width() - 16.0)
        .height(600.0)
        .selected_text(buffer.name())
        .show_ui(ui, |ui| {
            // All of them are seen at once.
            ui.spacing_mut().item_spacing.y = 0.0;
            for each in Buffer::ALL {
                ui.selectable_value(&mut buffer, each, each.name())
                    .on_hover_text(each.about());
            }
        })
        .response
        .on_hover_text(buffer.about());
    if buffer != viewer.buffer {
        viewer.set_buffer(buffer);
    }
    let mirror = (viewer.shown.as_ref()).is_some_and(|s| s.products.mirror.is_some());
    if buffer.is_of_mirrors() && !mirror {
        ui.weak("The camera sees no mirror.");
    }
    let heat = (viewer.shown.as_ref()).is_some_and(|s| s.products.search_heat.is_some());
    if buffer.needs_search_heat() && mirror && !heat {
        ui.weak("Only the interleaved search tells: sscr.search = \"interleaved\".");
    }
    if buffer.needs_virtual_lights()
        && let Some(sentence) = virtual_lights(viewer)
    {
        ui.weak(sentence);
    }
    if let Some((low, high)) = viewer.scale {
        legend(ui, low, high);
    }
    ui.separator();

    ui.heading("Under the cursor");
    let lines = viewer.probe.as_ref().map_or(&[][..], |p| &p.lines);
    egui::Grid::new("probe").num_columns(2).show(ui, |ui| {
        for (name, value) in lines {
            ui.weak(*name);
            ui.monospace(value);
            ui.end_row();
        }
    });
    if let [a, b] = viewer.measured[..] {
        ui.label(format!("measured {:.4}", a.distance(b)));
    } else {
        ui.weak("Shift and click on two points measures between them.");
    }
}

/// What there is of virtual lights, or why there is none.
fn virtual_lights(viewer: &Viewer) -> Option<String> {
    let (opened, shown) = (viewer.opened.as_ref()?, viewer.shown.as_ref()?);
    let plan = opened.loaded.plan(viewer.settings());
    let indirect = plan
        .rows
        .into_iter()
        .find(|row| row.stage == Stage::Indirect);
    if let Some(State::Skip(reason)) = indirect.map(|row| row.state) {
        return Some(format!("There are no virtual lights: {reason}."));
    }
    let Some(told) = &shown.products.virtual_lights else {
        return Some("They come with the whole picture, when the camera rests.".to_owned());
    };
    let (all, Some(last)) = (told.lights.len(), told.lights.last()) else {
        return Some("No light falls on what would reflect it.".to_owned());
    };
    if viewer.buffer == Buffer::ShadowMaps {
        let kept: usize = told.maps.iter().map(|maps| maps.count()).sum();
        return Some(format!(
            "Maps of {kept} of {all} lights, the first of each bounce. Grey is where a map shows nothing: there light passes."
        ));
    }
    let until = |bounce: u32| told.lights.partition_point(|light| light.bounce <= bounce);
    let environment = until(0);
    let bounces: Vec<String> = (1..=last.bounce)
        .map(|bounce| (until(bounce) - until(bounce - 1)).to_string())
        .collect();
    let mut parts = Vec::new();
    if environment > 0 {
        parts.push(format!("{environment} of the environment"));
    }
    if !bounces.is_empty() {
        parts.push(format!("{} by bounce", bounces.join(" + ")));
    }
    Some(format!(
        "{all} lights: {}. Faint ones lie behind what is seen.",
        parts.join(", ")
    ))
}

/// From dark to bright, with what the ends stand for.
fn legend(ui: &mut egui::Ui, low: f32, high: f32) {
    let size = Vec2::new(ui.available_width(), 12.0);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let steps = 64;
    for k in 0..steps {
        let at = |k: i32| rect.min.x + rect.width() * k as f32 / steps as f32;
        let part = Rect::from_x_y_ranges(at(k)..=at(k + 1) + 0.5, rect.y_range());
        let [r, g, b] = heat_colour(k as f32 / (steps - 1) as f32);
        ui.painter()
            .rect_filled(part, 0.0, Color32::from_rgb(r, g, b));
    }
    ui.horizontal(|ui| {
        ui.small(format!("{low:.4}"));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Min), |ui| {
            ui.small(format!("{high:.4}"));
        });
    });
}
