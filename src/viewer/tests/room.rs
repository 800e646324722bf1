//! At 1024 x 700 nothing is cut off.

use egui::Rect;
use egui::accesskit::Role;
use egui_kittest::kittest::NodeT as _;
use glam::DVec3;

use super::*;
use crate::viewer::editing::{Kind, Selected};

/// What is seen beyond the panel that it belongs to, or beyond the window.
fn cut_off<S>(window: &Harness<'_, S>) -> Vec<String> {
    let whole = window.ctx.content_rect().expand(1.0);
    let nodes: Vec<(Role, String, Rect)> = window
        .root()
        .children_recursive()
        .map(|node| {
            let known = node.accesskit_node();
            let name = known.label().or(known.value()).unwrap_or_default();
            (known.role(), name, known)
        })
        .filter(|(_, _, known)| known.bounding_box().is_some())
        .map(|(role, name, known)| {
            let r = known.bounding_box().unwrap_or_default();
            let rect = Rect::from_x_y_ranges(r.x0 as f32..=r.x1 as f32, r.y0 as f32..=r.y1 as f32);
            (role, name, rect)
        })
        .collect();
    // Panels end where they are made wider.
    let edges = nodes
        .iter()
        .filter(|(role, name, _)| *role == Role::Splitter && name == "Resize panel");
    let mut edges: Vec<Rect> = edges.map(|(_, _, rect)| *rect).collect();
    edges.sort_by(|a, b| a.min.x.total_cmp(&b.min.x));
    let windows: Vec<Rect> = nodes
        .iter()
        // The window itself is none that lies above its panels.
        .filter(|(role, _, rect)| *role == Role::Window && !rect.expand(2.0).contains_rect(whole))
        .map(|(_, _, rect)| *rect)
        .collect();
    let mut found = Vec::new();
    for (role, name, rect) in &nodes {
        let seen = matches!(
            role,
            Role::Button
                | Role::CheckBox
                | Role::ComboBox
                | Role::DisclosureTriangle
                | Role::Label
                | Role::RadioButton
                | Role::Slider
                | Role::SpinButton
                | Role::TextInput
        );
        let above = windows.iter().any(|w| w.contains(rect.center()));
        // Beside the panels' edges it belongs to where it begins on the left, and ends on the right.
        let beside = |edge: &Rect| !above && edge.y_range().contains(rect.center().y);
        let room = match edges[..] {
            [left, _] if beside(&left) && rect.min.x < left.center().x => {
                whole.min.x..=left.center().x + 1.0
            }
            [_, right] if beside(&right) && rect.max.x > right.center().x => {
                right.center().x - 1.0..=whole.max.x
            }
            _ => whole.min.x..=whole.max.x,
        };
        let beyond = !(room.contains(&rect.min.x) && room.contains(&rect.max.x));
        if (seen && beyond) || (*role == Role::Window && !whole.contains_rect(*rect)) {
            found.push(format!("{role:?} {name:?} {rect:?}, room {room:?}"));
        }
    }
    found
}

fn judge<S>(window: &mut Harness<'_, S>, place: &str) {
    window.run_steps(4);
    let found = cut_off(window);
    assert!(found.is_empty(), "{place}: {found:#?}");
}

#[test]
fn what_is_cut_off_is_found() {
    let mut small = Harness::builder()
        .with_size(egui::Vec2::new(400.0, 100.0))
        .build_ui(|ui| {
            let long = || {
                egui::Button::new("wider than its panel by far")
                    .wrap_mode(egui::TextWrapMode::Extend)
            };
            let left = egui::Panel::left("left").size_range(80.0..=80.0);
            left.show(ui, |ui| ui.add(long()));
            let right = egui::Panel::right("right").size_range(80.0..=80.0);
            right.show(ui, |ui| ui.button("fits"));
        });
    small.run_steps(3);
    let found = cut_off(&small);
    assert!(
        matches!(&found[..], [one] if one.contains("wider")),
        "{found:#?}"
    );
}

#[test]
fn no_panel_is_cut_off() {
    let (mut window, _) = opened("room");
    judge(&mut window, "settings");
    for setting in Settings::describe() {
        window.state_mut().panels.filter_to(&setting.key);
        judge(&mut window, &setting.key);
    }
    let same = window.state().settings().clone();
    window.state_mut().compare_with("the same", same);
    judge(&mut window, "comparing");
    window.state_mut().panels.show_path();
    for _ in 0..2 {
        window.key_press(Key::K);
        judge(&mut window, "a camera path");
        window.state_mut().navigator.orbit(0.6, 0.2);
    }
    window.get_by_label("Close window").click();
    window.run_steps(3);
    window.get_by_label("Scene").click();
    window.run_steps(3);
    for (kind, name, _) in Kind::ALL {
        window.state_mut().insert(kind);
        judge(&mut window, name);
    }
    window.state_mut().edit("clip box", |document| {
        document.clip = Some(catoptric::cloud::Bounds {
            min: DVec3::splat(-123.456_789),
            max: DVec3::splat(123.456_789),
        });
    });
    window.state_mut().selected = Some(Selected::Clip);
    judge(&mut window, "clip box");
    for (keys, key) in [
        (Modifiers::COMMAND, Key::S),
        (Modifiers::COMMAND | Modifiers::SHIFT, Key::S),
        (Modifiers::NONE, Key::F1),
    ] {
        window.key_press_modifiers(keys, key);
        judge(&mut window, &format!("{key:?}"));
        window.get_by_label("Close window").click();
        window.run_steps(3);
    }
    for k in 0..30 {
        window.state_mut().say(format!(
            "a message of many words, which is number {k} of thirty"
        ));
    }
    judge(&mut window, "messages");
}
