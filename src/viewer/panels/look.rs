//! Which layer is shown, what its colours mean, and what is under the cursor.

use catoptric::output::heat_colour;
use eframe::egui::{self, Color32, Rect, Sense, Vec2};

use crate::viewer::app::Viewer;
use crate::viewer::buffers::Buffer;

pub(super) fn show(viewer: &mut Viewer, ui: &mut egui::Ui) {
    ui.heading("Layer");
    let mut buffer = viewer.buffer;
    egui::ComboBox::from_id_salt("layer")
        .width(ui.available_width() - 16.0)
        .height(400.0)
        .selected_text(buffer.name())
        .show_ui(ui, |ui| {
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
