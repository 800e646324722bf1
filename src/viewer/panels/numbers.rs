//! What frames take and what the search comes to.

use catoptric::measure::peak_memory_bytes;
use eframe::egui;
use egui_plot::{Bar, BarChart, Plot};

use crate::viewer::app::Viewer;

/// Room for so many frames, at least.
const BARS: u32 = 12;

pub(super) fn show(viewer: &Viewer, ui: &mut egui::Ui) {
    ui.heading("Numbers");
    let bounces = viewer
        .shown
        .as_ref()
        .map_or(&[][..], |s| &s.products.bounces);
    egui::Grid::new("mirrors").num_columns(2).show(ui, |ui| {
        let mut row = |name: &str, value: String, about: &str| {
            ui.weak(name).on_hover_text(about);
            ui.label(value);
            ui.end_row();
        };
        for bounce in bounces {
            let percent = |part: f64| format!("{:.1} %", part * 100.0);
            row("method", bounce.method.to_owned(), &bounce.reason);
            row(
                "regions",
                bounce.regions.to_string(),
                "Mirror parts of one curvature",
            );
            row(
                "hits",
                super::grouped(bounce.hits),
                "Places where mirrors show a point",
            );
            row(
                "hit rate",
                percent(bounce.hit_rate),
                "Points found, of those searched for",
            );
            row(
                "coverage",
                percent(bounce.coverage),
                "Mirror pixels that show something",
            );
            row(
                "closed",
                percent(bounce.coverage_closed),
                "The same after holes are closed",
            );
            row(
                "steps",
                format!("{:.1}", bounce.mean_steps),
                "Of a search, on average",
            );
        }
        if let Some(memory) = peak_memory_bytes() {
            row(
                "memory",
                format!("{} MB", memory >> 20),
                "The most that was in use",
            );
        }
    });
    ui.separator();
    ui.heading("Time per pass");
    times(viewer, ui);
}

/// Stacked bars, a frame each, and the last frame's as a table.
fn times(viewer: &Viewer, ui: &mut egui::Ui) {
    let Some(last) = viewer.times.back() else {
        ui.weak("Frames that draw everything are timed.");
        return;
    };
    let mut charts: Vec<BarChart> = Vec::new();
    for pass in last {
        let bars = viewer.times.iter().enumerate().map(|(k, passes)| {
            let same = passes.iter().filter(|p| p.name == pass.name);
            Bar::new(k as f64, same.map(|p| p.wall_ms).sum::<f64>())
        });
        let below: Vec<&BarChart> = charts.iter().collect();
        let chart = BarChart::new(pass.name.clone(), bars.collect()).stack_on(&below);
        charts.push(chart);
    }
    Plot::new("times")
        .height(120.0)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .show_grid(false)
        .show_axes([false, true])
        .include_x(0.0)
        .include_x(f64::from(BARS))
        .y_axis_label("ms")
        .show(ui, |plot| {
            for chart in charts {
                plot.bar_chart(chart);
            }
        });
    egui::Grid::new("passes")
        .num_columns(2)
        .striped(true)
        .show(ui, |ui| {
            for pass in last {
                ui.label(&pass.name);
                ui.monospace(format!("{:8.1} ms", pass.wall_ms));
                ui.end_row();
            }
            ui.strong("all");
            let all: f64 = last.iter().map(|p| p.wall_ms).sum();
            ui.monospace(format!("{all:8.1} ms"));
            ui.end_row();
        });
}
