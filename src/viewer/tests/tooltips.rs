//! Every control says what it does when the pointer rests on it.

use std::collections::{BTreeMap, BTreeSet};

use catoptric::cloud::{MirrorRule, Select};
use egui::accesskit::Role;
use egui::{Order, Rect};
use egui_kittest::kittest::NodeT as _;
use glam::DVec3;

use super::*;
use crate::viewer::editing::{Kind, Selected};

/// As high as all of a panel needs.
const SIZE: egui::Vec2 = egui::Vec2::new(1024.0, 1500.0);

/// What a person can press, write into or drag.
fn is_control(role: Role) -> bool {
    matches!(
        role,
        Role::Button
            | Role::CheckBox
            | Role::ComboBox
            | Role::DisclosureTriangle
            | Role::Link
            | Role::MultilineTextInput
            | Role::RadioButton
            | Role::Slider
            | Role::SpinButton
            | Role::TextInput
    )
}

/// One of the window, as accessibility tells of it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Name {
    id: String,
    role: String,
    label: String,
    disabled: bool,
}

fn controls<S>(window: &Harness<'_, S>) -> Vec<(Name, Rect)> {
    let mut all = Vec::new();
    for node in window.root().children_recursive() {
        let known = node.accesskit_node();
        let name = Name {
            id: format!("{:?}", known.locate().0),
            role: format!("{:?}", known.role()),
            label: known.label().or(known.value()).unwrap_or_default(),
            disabled: known.is_disabled(),
        };
        // The frame of a window is egui's; a button that is not seen keeps its place.
        let of_frame = ["Close window", "Hide", "Show"].contains(&name.label.as_str());
        let none = of_frame || (name.label == "reset" && name.disabled);
        if is_control(known.role()) && !none {
            all.push((name, node.rect()));
        }
    }
    all
}

/// Presses and lets go.
fn click<S>(window: &mut Harness<'_, S>, at: Rect) {
    window.hover_at(at.center());
    window.run_steps(2);
    window.drag_at(at.center());
    window.step();
    window.drop_at(at.center());
    window.run_steps(4);
}

/// Those that were looked at.
#[derive(Debug, Default)]
struct Looked {
    seen: BTreeSet<Name>,
    /// Where those are that say nothing.
    silent: Vec<String>,
    /// Those that were never in sight, and where they should have been.
    hidden: BTreeMap<Name, String>,
}

impl Looked {
    /// Rests on each control that was not there before.
    fn at<S>(&mut self, window: &mut Harness<'_, S>, place: &str) {
        window.run_steps(3);
        let sight = window.ctx.content_rect();
        for (name, rect) in controls(window) {
            if self.seen.contains(&name) {
                continue;
            }
            if !sight.contains(rect.center()) {
                self.hidden.insert(name, place.to_owned());
                continue;
            }
            window.hover_at(rect.center());
            window.run_steps(4);
            // What comes and goes with the work under way is looked at where it stays.
            if !controls(window).contains(&(name.clone(), rect)) {
                continue;
            }
            let shown = window.ctx.memory(|m| m.areas().visible_layer_ids());
            // A menu in a menu opens where its tooltip would.
            let says = |order: Order| order == Order::Tooltip;
            let menu = name.label.starts_with("Open recent");
            if !shown.iter().any(|layer| says(layer.order)) && !menu {
                self.silent
                    .push(format!("{place}: {} {:?}", name.role, name.label));
            }
            self.hidden.remove(&name);
            self.seen.insert(name);
        }
    }

    /// The same of what opens when a control is clicked, which closes with a second click.
    fn behind<S>(&mut self, window: &mut Harness<'_, S>, control: Rect, place: &str) {
        click(window, control);
        self.at(window, place);
        click(window, control);
    }

    /// The same of every box of choices.
    fn behind_choices<S>(&mut self, window: &mut Harness<'_, S>, place: &str) {
        let all = controls(window).into_iter();
        for (name, rect) in all.filter(|(name, _)| name.role == "ComboBox") {
            self.behind(window, rect, &format!("{place}, {}", name.label));
        }
    }

    /// Nothing was silent, nothing out of sight, and what must be there was.
    fn judge(self, there: &[&str]) {
        for label in there {
            let found = self.seen.iter().any(|name| name.label.contains(label));
            assert!(found, "{label} was not looked at: {:#?}", self.seen);
        }
        assert!(self.silent.is_empty(), "say nothing: {:#?}", self.silent);
        assert!(self.hidden.is_empty(), "out of sight: {:#?}", self.hidden);
    }
}

/// Where a control is.
fn find<S>(window: &Harness<'_, S>, label: &str) -> Rect {
    let found = controls(window).into_iter().find(|(n, _)| n.label == label);
    found.unwrap_or_else(|| panic!("no {label}")).1
}

/// A scene with all that the tree can show, as high as it needs.
fn rich() -> Harness<'static, Viewer> {
    let (mut window, folder) = opened("tooltips");
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
               property uchar classification\nend_header\n0 0 0 2\n0.1 0 0 6\n0 0.1 0 2\n";
    let path = folder.join("classes.ply");
    std::fs::write(&path, ply).expect("a cloud");
    window.set_size(SIZE);
    window.state_mut().panels.remember(&path);
    window.state_mut().edit("rule", |document| {
        document.clouds[0].mirrors.push(MirrorRule {
            select: Select::Box {
                min: DVec3::ZERO,
                max: DVec3::ONE,
            },
            reflectance: 0.5,
        });
    });
    window.state_mut().add_cloud(path);
    until(&mut window, "both clouds", |v| {
        v.document().clouds.len() == 2 && is_at_rest(v)
    });
    window
}

#[test]
fn a_control_that_says_nothing_is_found() {
    let mut window = Harness::new_ui(|ui| {
        let _ = ui.button("silent");
        let _ = ui.button("told").on_hover_text("what it does");
        let silent = ui.add_enabled(false, egui::Button::new("disabled"));
        let _ = silent.on_hover_text("is not shown of what is disabled");
    });
    let mut looked = Looked::default();
    looked.at(&mut window, "here");
    assert_eq!(
        looked.silent,
        ["here: Button \"silent\"", "here: Button \"disabled\""]
    );
}

#[test]
fn controls_of_an_empty_window_have_tooltips() {
    let (mut window, mut looked) = (window(None), Looked::default());
    window.set_size(SIZE);
    window.state_mut().panels.remember("a.ply".as_ref());
    looked.at(&mut window, "welcome");
    window.state_mut().loading = Some("b.ply".into());
    looked.at(&mut window, "opening");
    looked.judge(&["Open...", "a.ply", "Cancel"]);
}

#[test]
fn settings_and_layers_have_tooltips() {
    let (mut window, mut looked) = (rich(), Looked::default());
    looked.at(&mut window, "settings");
    let presets = find(&window, "Presets");
    looked.behind(&mut window, presets, "presets");
    let mut groups: Vec<String> = Settings::describe()
        .iter()
        .filter_map(|d| d.key.split_once('.').map(|(group, _)| format!("{group}.")))
        .collect();
    groups.dedup();
    for group in groups {
        window.state_mut().panels.filter_to(&group);
        looked.at(&mut window, &group);
        looked.behind_choices(&mut window, &group);
    }
    window.state_mut().panels.filter_to("splat.size");
    window.key_press(Key::Plus);
    looked.at(&mut window, "a setting that differs");
    let same = window.state().settings().clone();
    window.state_mut().compare_with("the same", same);
    looked.at(&mut window, "comparing");
    looked.judge(&["Accurate", "reset", "ray_trace", "residual", "difference"]);
}

#[test]
fn menus_and_forms_have_tooltips() {
    let (mut window, mut looked) = (rich(), Looked::default());
    looked.at(&mut window, "at first");
    for menu in ["File", "Edit", "View"] {
        let button = find(&window, menu);
        looked.behind(&mut window, button, menu);
    }
    let file = find(&window, "File");
    click(&mut window, file);
    let all = controls(&window).into_iter();
    let mut recent = all.filter(|(n, _)| n.label.starts_with("Open recent"));
    let (_, recent) = recent.next().expect("recent files");
    looked.behind(&mut window, recent, "recent files");
    click(&mut window, file);
    let shift = Modifiers::COMMAND | Modifiers::SHIFT;
    for (keys, form) in [(Modifiers::COMMAND, "export"), (shift, "save")] {
        window.key_press_modifiers(keys, Key::S);
        looked.at(&mut window, form);
        let close = window.get_by_label("Close window").rect();
        click(&mut window, close);
    }
    window.key_press(Key::F1);
    looked.at(&mut window, "help");
    window.key_press(Key::F1);
    window.state_mut().say("a message");
    looked.at(&mut window, "messages");
    looked.judge(&[
        "Undo",
        "Quit",
        "moving frame",
        "classes.ply",
        "Write",
        "Save",
        "Dismiss",
    ]);
}

#[test]
fn the_camera_path_has_tooltips() {
    let (mut window, mut looked) = (rich(), Looked::default());
    window.state_mut().panels.show_path();
    looked.at(&mut window, "no path");
    for _ in 0..2 {
        window.key_press(Key::K);
        window.run_steps(2);
        window.state_mut().navigator.orbit(0.6, 0.2);
    }
    looked.at(&mut window, "keyframes");
    let render = find(&window, "Render pictures...");
    click(&mut window, render);
    looked.at(&mut window, "pictures");
    let close = window.get_all_by_label("Close window").last();
    let close = close.expect("a form").rect();
    click(&mut window, close);
    window.state_mut().take_turntable();
    looked.at(&mut window, "turntable");
    looked.judge(&["Go to", "Play", "loop", "Write pictures", "anticlockwise"]);
}

#[test]
fn the_tree_of_the_scene_has_tooltips() {
    let (mut window, mut looked) = (rich(), Looked::default());
    let scene = find(&window, "Scene");
    click(&mut window, scene);
    looked.at(&mut window, "scene");
    let nodes = window.root().children_recursive();
    let clouds = nodes.filter(|n| {
        let about = n.accesskit_node().description().unwrap_or_default();
        about.starts_with("What the cloud's colours")
    });
    let toggles: Vec<Rect> = clouds.map(|n| n.rect()).collect();
    assert_eq!(toggles.len(), 2, "a toggle for each cloud");
    for toggle in toggles.into_iter().rev() {
        click(&mut window, toggle);
    }
    looked.at(&mut window, "clouds");
    looked.behind_choices(&mut window, "clouds");
    let all = controls(&window).into_iter();
    for (_, class) in all.filter(|(n, _)| n.label == "Class") {
        looked.behind(&mut window, class, "classes");
    }
    let insert = find(&window, "Insert");
    looked.behind(&mut window, insert, "insert");
    for (kind, name, _) in Kind::ALL {
        window.state_mut().insert(kind);
        looked.at(&mut window, name);
    }
    window.state_mut().edit("clip box", |document| {
        document.clip = Some(catoptric::cloud::Bounds {
            min: DVec3::splat(-2.0),
            max: DVec3::splat(2.0),
        });
    });
    window.state_mut().selected = Some(Selected::Clip);
    looked.at(&mut window, "clip box");
    looked.judge(&[
        "Region", "Class", "2 points", "height", "Torus", "by hand", "own axes",
    ]);
}
