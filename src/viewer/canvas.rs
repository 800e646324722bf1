//! The picture in the middle of the window: what is drawn over it, and what mouse and keys do to it.

use catoptric::camera::Pinhole;
use eframe::egui::{self, Color32, Key, PointerButton, Pos2, Rect, Sense, Stroke, Vec2};
use glam::{DVec2, DVec3, UVec2};

use super::app::{Purpose, Viewer};
use super::editing;
use super::letters::Pick;
use super::navigation::Navigator;
use super::probe::Probe;
use super::second::Second;
use super::trail;

/// Turn of a drag across the picture's height, radians.
const TURN: f64 = 2.5;

/// Part of the distance to the pivot that is flown in a second.
const SPEED: f64 = 0.8;

const DIGITS: [Key; 10] = [
    Key::Num0,
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
    Key::Num8,
    Key::Num9,
];

/// The picture, as large as there is room.
pub(super) fn show(viewer: &mut Viewer, ui: &mut egui::Ui) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    let scale = ui.ctx().pixels_per_point();
    let size = UVec2::new(
        (rect.width() * scale).round().clamp(32.0, 8192.0) as u32,
        (rect.height() * scale).round().clamp(32.0, 8192.0) as u32,
    );
    if size != viewer.like.size {
        viewer.like.size = size;
        viewer.touch();
    }
    ui.painter().rect_filled(rect, 0.0, Color32::BLACK);
    if viewer.opened.is_none() {
        welcome(viewer, ui, rect);
        return;
    }
    if let Some(texture) = &viewer.texture {
        let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
        ui.painter()
            .image(texture.id(), rect, whole, Color32::WHITE);
    }
    if let Some(second) = &viewer.second {
        compared(viewer, second, ui, rect);
    }
    let taken = overlays(viewer, ui, rect, &response);

    let before = viewer.navigator;
    pointer(viewer, ui, rect, &response, taken);
    if !ui.ctx().egui_wants_keyboard_input() {
        keys(viewer, ui);
    }
    if viewer.navigator != before {
        viewer.touch();
        ui.ctx().request_repaint();
    }
}

fn welcome(viewer: &mut Viewer, ui: &mut egui::Ui, rect: Rect) {
    let area = Rect::from_center_size(rect.center(), Vec2::new(360.0, 160.0));
    ui.scope_builder(egui::UiBuilder::new().max_rect(area), |ui| {
        ui.vertical_centered(|ui| {
            if let Some(path) = &viewer.loading {
                ui.heading("Opening");
                ui.label(path.display().to_string());
                ui.spinner();
                let cancel = ui.button("Cancel");
                if cancel.on_hover_text("Stop reading (Esc)").clicked() {
                    viewer.cancel();
                }
            } else {
                ui.heading("catoptric");
                ui.label("Drop a scene (.toml) or a point cloud (.ply, .las, .laz) here");
                ui.add_space(8.0);
                let open = ui.button("Open...");
                let about = "Open a scene or a point cloud (Ctrl+O)";
                if open.on_hover_text(about).clicked() {
                    viewer.ask_for(ui.ctx(), Purpose::Open);
                }
                for path in viewer.panels.recent().to_vec() {
                    let link = ui.link(path.display().to_string());
                    if link.on_hover_text("Open it again").clicked() {
                        viewer.open(path);
                    }
                }
            }
        });
    });
}

/// The other picture to the left of the wiper, or the difference of the two.
fn compared(viewer: &Viewer, second: &Second, ui: &egui::Ui, rect: Rect) {
    let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
    if viewer.shows_difference {
        if let Some(difference) = &second.difference {
            ui.painter()
                .image(difference.id(), rect, whole, Color32::WHITE);
        }
        return;
    }
    let Some(texture) = &second.texture else {
        return;
    };
    let at = rect.min.x + rect.width() * viewer.wiper;
    let left = Rect::from_x_y_ranges(rect.min.x..=at, rect.y_range());
    let part = Rect::from_min_max(Pos2::ZERO, Pos2::new(viewer.wiper, 1.0));
    ui.painter().image(texture.id(), left, part, Color32::WHITE);
    ui.painter()
        .vline(at, rect.y_range(), Stroke::new(2.0, Color32::WHITE));
}

/// Where a point of the scene is on screen.
fn on_screen(pinhole: &Pinhole, origin: DVec3, rect: Rect, point: DVec3) -> Option<Pos2> {
    let view = pinhole.view_from_world((point - origin).as_vec3());
    let pixel = pinhole.pixel_from_view(view) / pinhole.size.as_vec2();
    (view.z > 0.0 && pixel.is_finite())
        .then(|| rect.min + Vec2::new(pixel.x * rect.width(), pixel.y * rect.height()))
}

/// Lines over the picture: what is edited, what a mirror's pixel shows, and what is measured; whether the pointer is on
/// what is moved by hand.
fn overlays(viewer: &mut Viewer, ui: &egui::Ui, rect: Rect, response: &egui::Response) -> bool {
    let Some(opened) = (viewer.opened.as_ref()).filter(|_| viewer.buffer.is_of_view()) else {
        return false;
    };
    let origin = opened.loaded.surfels.origin;
    let camera = viewer.camera();
    let Ok(pinhole) = camera.pinhole(origin) else {
        return false;
    };
    let taken = editing::show(viewer, ui, rect, response, &pinhole, origin);
    let painter = ui.painter().with_clip_rect(rect);
    let line = |points: &[DVec3], colour: Color32| {
        let places: Vec<Pos2> = points
            .iter()
            .filter_map(|p| on_screen(&pinhole, origin, rect, *p))
            .collect();
        for place in &places {
            painter.circle(
                *place,
                4.0,
                colour.gamma_multiply(0.5),
                Stroke::new(1.5, colour),
            );
        }
        painter.line(places, Stroke::new(2.0, colour));
    };
    if let Some(path) = &viewer.path {
        line(path, Color32::from_rgb(255, 200, 60));
    }
    if viewer.panels.shows_path() {
        trail::show(&viewer.film, &painter, &camera, |point| {
            on_screen(&pinhole, origin, rect, point)
        });
    }
    line(&viewer.measured, Color32::from_rgb(90, 200, 255));
    if let [a, b] = viewer.measured[..]
        && let Some(place) = on_screen(&pinhole, origin, rect, (a + b) / 2.0)
    {
        let text = format!("{:.4}", a.distance(b));
        let font = egui::FontId::proportional(16.0);
        let (dark, light) = (Color32::BLACK, Color32::from_rgb(90, 200, 255));
        let below = place + Vec2::new(1.0, 1.0);
        painter.text(
            below,
            egui::Align2::CENTER_BOTTOM,
            &text,
            font.clone(),
            dark,
        );
        painter.text(place, egui::Align2::CENTER_BOTTOM, &text, font, light);
    }
    taken
}

/// What a place on screen shows, as far as the last frame tells.
fn probe(viewer: &Viewer, rect: Rect, at: Pos2) -> Option<Probe> {
    let shown = viewer.shown.as_ref()?;
    let pixel = pixel(viewer, rect, at)?;
    let origin = shown.origin;
    Some(Probe::new(&shown.products, origin, pixel, viewer.buffer))
}

/// The pixel of the last frame that is there.
fn pixel(viewer: &Viewer, rect: Rect, at: Pos2) -> Option<UVec2> {
    let size = (viewer.shown.as_ref()?).products.gbuffer.surface.size();
    let part = (at - rect.min) / rect.size();
    let inside = part.x >= 0.0 && part.y >= 0.0 && part.x < 1.0 && part.y < 1.0;
    let pixel = UVec2::new(
        (part.x * size.x as f32) as u32,
        (part.y * size.y as f32) as u32,
    );
    inside.then_some(pixel)
}

/// `taken`: drags and clicks belong to what is moved by hand.
fn pointer(viewer: &mut Viewer, ui: &egui::Ui, rect: Rect, response: &egui::Response, taken: bool) {
    let hovered = response.hover_pos().and_then(|at| probe(viewer, rect, at));
    if hovered.is_some() {
        viewer.probe = hovered;
    }
    if !viewer.buffer.is_of_view() {
        // A camera that nobody sees through stays where it is.
        return;
    }
    let under_cursor = viewer.probe.as_ref().and_then(|p| p.position);

    wheel(viewer, ui, response, under_cursor);
    if taken {
        return;
    }
    let drag = response.drag_delta();
    let (x, y) = (f64::from(drag.x), f64::from(drag.y));
    let turn = TURN / f64::from(rect.height().max(1.0));
    let shift = ui.input(|i| i.modifiers.shift);
    if response.dragged_by(PointerButton::Primary) && !shift {
        viewer.navigator.orbit(-x * turn, -y * turn);
    } else if response.dragged_by(PointerButton::Secondary) {
        viewer.navigator.look(x * turn, -y * turn);
    } else if response.dragged() {
        let scale = f64::from(ui.ctx().pixels_per_point());
        viewer.navigator.pan(DVec2::new(x, y) * scale, &viewer.like);
    }
    if response.double_clicked()
        && let Some(point) = under_cursor
    {
        viewer.navigator.pivot = point;
    } else if response.clicked() {
        let probe = viewer.probe.clone().unwrap_or_default();
        let at = response.interact_pointer_pos();
        if viewer.picking.is_some()
            && let Some(pixel) = at.and_then(|at| pixel(viewer, rect, at))
        {
            if let Some(shown) = viewer.shown.clone() {
                viewer.worker.pick(Pick { shown, pixel });
            }
        } else if shift {
            // What a mirror shows is measured to where it really is.
            if viewer.measured.len() > 1 {
                viewer.measured.clear();
            }
            viewer.measured.extend(probe.reflected.or(probe.position));
            if probe.reflected.is_some() {
                viewer.say("the point is in a mirror: measured to where it really is");
            }
        } else {
            viewer.path = match (probe.position, probe.reflected) {
                (Some(mirror), Some(shown)) => Some([viewer.navigator.position, mirror, shown]),
                _ => None,
            };
        }
    }
}

/// Goes to what is under the cursor, or away from it.
fn wheel(
    viewer: &mut Viewer,
    ui: &egui::Ui,
    response: &egui::Response,
    under_cursor: Option<DVec3>,
) {
    if response.contains_pointer() {
        let notches = f64::from(ui.input(|i| i.smooth_scroll_delta().y)) / 50.0;
        if notches != 0.0 {
            let towards = under_cursor.unwrap_or(viewer.navigator.pivot);
            viewer.navigator.zoom(notches, towards);
        }
    }
}

fn keys(viewer: &mut Viewer, ui: &egui::Ui) {
    let (held, fast, seconds) = ui.input(|i| {
        let axis = |plus, minus| f64::from(i.key_down(plus)) - f64::from(i.key_down(minus));
        let held = DVec3::new(
            axis(Key::D, Key::A),
            axis(Key::E, Key::Q),
            axis(Key::W, Key::S),
        );
        let held = if i.modifiers.command {
            DVec3::ZERO
        } else {
            held
        };
        (held, i.modifiers.shift, f64::from(i.stable_dt.min(0.1)))
    });
    if held != DVec3::ZERO {
        let speed = SPEED * if fast { 4.0 } else { 1.0 } * viewer.navigator.reach();
        viewer.navigator.fly(held * speed * seconds);
    }
    if ui.input(|i| i.key_pressed(Key::F)) {
        frame_all(viewer);
    }
    for (number, key) in DIGITS.into_iter().enumerate() {
        let (pressed, store) = ui.input(|i| (i.key_pressed(key), i.modifiers.command));
        if pressed && store {
            viewer.stored[number] = Some(viewer.navigator);
            viewer.say(format!(
                "stored camera {number}; the key {number} recalls it"
            ));
        } else if pressed && let Some(stored) = viewer.stored[number] {
            viewer.navigator = stored;
        }
    }
    let larger = ui.input(|i| i.key_pressed(Key::Plus) || i.key_pressed(Key::Equals));
    let smaller = ui.input(|i| i.key_pressed(Key::Minus));
    if larger != smaller {
        let settings = viewer.settings();
        let factor = if larger { 1.1 } else { 1.0 / 1.1 };
        let size = f64::from(settings.splat.size) * factor;
        // Beyond its range it stays as it is.
        if let Ok(settings) = settings.with("splat.size", toml::Value::Float(size)) {
            viewer.change(settings, "splat.size");
        }
    }
    let (undo, redo) = ui.input(|i| {
        let z = i.modifiers.command && i.key_pressed(Key::Z);
        let y = i.modifiers.command && i.key_pressed(Key::Y);
        (z && !i.modifiers.shift, y || (z && i.modifiers.shift))
    });
    if undo {
        viewer.undo();
    } else if redo {
        viewer.redo();
    }
    if ui.input(|i| i.key_pressed(Key::Delete)) {
        viewer.remove_selected();
    }
    if ui.input(|i| i.key_pressed(Key::K) && !i.modifiers.command) {
        viewer.add_keyframe();
    }
    // A preview that is stopped is all that is put away.
    if ui.input(|i| i.key_pressed(Key::Escape)) && !viewer.film.pause() {
        (viewer.path, viewer.measured) = (None, Vec::new());
        (viewer.selected, viewer.picking) = (None, None);
        if viewer.is_busy() {
            viewer.cancel();
        }
    }
}

/// Steps back until everything is seen.
pub(super) fn frame_all(viewer: &mut Viewer) {
    if let Some(opened) = &viewer.opened {
        let mut navigator: Navigator = viewer.navigator;
        navigator.frame(opened.loaded.facts.bounds, &viewer.like);
        viewer.navigator = navigator;
    }
}
