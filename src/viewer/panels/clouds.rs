//! Clouds of the scene, what colours them, and what of them is a mirror.

use catoptric::cloud::{Bounds, CloudFacts, ColourBy, MirrorRule, Select};
use catoptric::scene::{CloudSource, SceneCloud};
use eframe::egui;

use crate::viewer::app::{Purpose, Viewer};
use crate::viewer::editing::Selected;

pub(super) fn show(viewer: &mut Viewer, ui: &mut egui::Ui) {
    ui.horizontal(|ui| {
        ui.heading("Clouds");
        let add = ui.small_button("Add...");
        let about =
            "Add a point cloud to those that are here; or drop it onto the window with Shift";
        if add.on_hover_text(about).clicked() {
            viewer.ask_for(ui.ctx(), Purpose::AddCloud);
        }
    });
    let count = viewer.document().clouds.len();
    for index in 0..count {
        let Some(cloud) = viewer.document().clouds.get(index).cloned() else {
            break;
        };
        let mut edited = cloud.clone();
        let id = ui.make_persistent_id(("cloud", index));
        let header =
            egui::collapsing_header::CollapsingState::load_with_default_open(ui.ctx(), id, false);
        let (toggle, ..) = header
            .show_header(ui, |ui| {
                let seen = ui.checkbox(&mut edited.visible, "");
                seen.on_hover_text("Whether the cloud is drawn");
                ui.label(short_name(&cloud))
                    .on_hover_text(about(viewer, index, &cloud));
            })
            .body(|ui| {
                of_cloud(viewer, ui, index, &mut edited);
                let remove = egui::Button::new("Remove");
                let remove = ui.add_enabled(count > 1, remove);
                if remove
                    .on_hover_text("Take the cloud out of the scene; its file stays")
                    .on_disabled_hover_text("A scene has at least one cloud")
                    .clicked()
                {
                    (viewer.selected, viewer.picking) = (None, None);
                    viewer.edit_once("remove a cloud", |document| {
                        document.clouds.remove(index);
                    });
                }
            });
        toggle.on_hover_text("What the cloud's colours are, and what of it is a mirror");
        if edited != cloud && viewer.document().clouds.get(index) == Some(&cloud) {
            let what = format!("cloud {index}");
            viewer.edit(&what, |document| {
                if let Some(cloud) = document.clouds.get_mut(index) {
                    *cloud = edited;
                }
            });
        }
    }
}

fn short_name(cloud: &SceneCloud) -> String {
    match &cloud.source {
        CloudSource::File(path) => {
            let name = path.file_name().unwrap_or(path.as_os_str());
            name.to_string_lossy().into_owned()
        }
        CloudSource::Generated { name, .. } => name.to_string(),
    }
}

/// What is known of the points of a cloud, where it is drawn.
fn facts(viewer: &Viewer, index: usize) -> Option<&CloudFacts> {
    let opened = viewer.opened.as_ref()?;
    let shown = opened.scene.clouds.get(index).filter(|cloud| cloud.visible);
    let before = opened.scene.clouds.iter().take(index);
    let place = before.filter(|cloud| cloud.visible).count();
    shown.and_then(|_| opened.loaded.facts.clouds.get(place))
}

/// The same, for people.
fn about(viewer: &Viewer, index: usize, cloud: &SceneCloud) -> String {
    let name = cloud.name();
    facts(viewer, index).map_or_else(
        || name.clone(),
        |facts| {
            let points = super::grouped(facts.points);
            format!("{name}\n{}\n{points} points are drawn", facts.format)
        },
    )
}

/// What can be said of one cloud.
fn of_cloud(viewer: &mut Viewer, ui: &mut egui::Ui, index: usize, cloud: &mut SceneCloud) {
    ui.horizontal(|ui| {
        ui.label("colour by")
            .on_hover_text("What gives points their colour");
        egui::ComboBox::from_id_salt(("colour", index))
            .selected_text(cloud.colour.name())
            .show_ui(ui, |ui| {
                for by in ColourBy::ALL {
                    ui.selectable_value(&mut cloud.colour, by, by.name())
                        .on_hover_text(colour_help(by));
                }
            })
            .response
            .on_hover_text(colour_help(cloud.colour));
    });
    ui.horizontal_wrapped(|ui| {
        ui.label("mark as mirror")
            .on_hover_text("Points of the cloud that are a mirror");
        let by_box = ui.button("Box");
        if by_box
            .on_hover_text("Points in a box about the pivot, which can be moved by hand")
            .clicked()
        {
            let Bounds { min, max } = viewer.box_about_pivot();
            viewer.mark(index, Select::Box { min, max });
        }
        let picking = viewer.picking == Some(index);
        let pick = ui.selectable_label(picking, "Region");
        if pick
            .on_hover_text("The surface that is clicked on next, up to its edges")
            .clicked()
        {
            viewer.picking = (!picking).then_some(index);
        }
        classes(viewer, ui, index, cloud);
    });
    let mut removed = None;
    for (rule, marked) in cloud.mirrors.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            let this = Selected::Rule { cloud: index, rule };
            let label = ui.selectable_label(viewer.selected == Some(this), rule_name(marked));
            let label = label.on_hover_text("Choose it; a box can be moved by hand");
            if label.clicked() {
                viewer.selected = Some(this);
            }
            reflectance(ui, (index, rule), &mut marked.reflectance);
            if ui
                .small_button("Remove")
                .on_hover_text("These points are no mirror")
                .clicked()
            {
                removed = Some(rule);
            }
        });
    }
    if let Some(rule) = removed {
        cloud.mirrors.remove(rule);
        viewer.selected = None;
    }
}

/// A number that counts once it is typed whole, or let go.
fn reflectance(ui: &mut egui::Ui, of: (usize, usize), reflectance: &mut f32) {
    let id = ui.scope_id().with(("reflectance", of));
    let dragged = ui.data(|d| d.get_temp::<f32>(id));
    let mut shown = dragged.unwrap_or(*reflectance);
    let value = egui::DragValue::new(&mut shown).range(0.0..=1.0);
    let response = ui.add(value.speed(0.01).update_while_editing(false));
    if response.dragged() {
        ui.data_mut(|d| d.insert_temp(id, shown));
    } else if dragged.is_some() || response.changed() {
        ui.data_mut(|d| d.remove::<f32>(id));
        *reflectance = shown;
    }
    response.on_hover_text("Reflectance, 0 to 1");
}

fn colour_help(by: ColourBy) -> &'static str {
    match by {
        ColourBy::Auto => "Their own colours; without any, intensity, or else height",
        ColourBy::Rgb => "Their own colours",
        ColourBy::Intensity => "Grey by intensity, from the 2nd to the 98th percentile",
        ColourBy::Height => "From low and dark to high and light",
        ColourBy::Class => "A colour for each class: ground, vegetation, buildings ...",
    }
}

/// The classes that the cloud has; those that are chosen are mirrors.
fn classes(viewer: &Viewer, ui: &mut egui::Ui, index: usize, cloud: &mut SceneCloud) {
    let known = facts(viewer, index).map(|facts| facts.classes.clone());
    let known = known.unwrap_or_default();
    let menu = ui.add_enabled_ui(!known.is_empty(), |ui| {
        ui.menu_button("Class", |ui| {
            let rule = cloud.mirrors.iter().position(is_of_classes);
            let mut chosen: Vec<u8> = match rule.and_then(|r| cloud.mirrors.get(r)) {
                Some(MirrorRule {
                    select: Select::Classification(classes),
                    ..
                }) => classes.clone(),
                _ => Vec::new(),
            };
            let before = chosen.clone();
            for (class, points) in &known {
                let mut is = chosen.contains(class);
                let text = format!("{class} ({} points)", super::grouped(*points));
                if ui
                    .checkbox(&mut is, text)
                    .on_hover_text(class_name(*class))
                    .changed()
                {
                    chosen.retain(|c| c != class);
                    if is {
                        chosen.push(*class);
                    }
                }
            }
            if chosen != before {
                chosen.sort_unstable();
                let select = Select::Classification(chosen.clone());
                match rule {
                    Some(rule) if chosen.is_empty() => {
                        cloud.mirrors.remove(rule);
                    }
                    Some(rule) => {
                        if let Some(rule) = cloud.mirrors.get_mut(rule) {
                            rule.select = select;
                        }
                    }
                    None => cloud.mirrors.push(MirrorRule {
                        select,
                        reflectance: 1.0,
                    }),
                }
            }
        });
    });
    menu.response
        .on_hover_text("Points of these classes")
        .on_disabled_hover_text("The file has none, or the cloud is hidden");
}

fn is_of_classes(rule: &MirrorRule) -> bool {
    matches!(rule.select, Select::Classification(_))
}

fn class_name(class: u8) -> &'static str {
    match class {
        0 => "never classified",
        1 => "unclassified",
        2 => "ground",
        3 => "low vegetation",
        4 => "medium vegetation",
        5 => "high vegetation",
        6 => "building",
        7 => "low noise",
        8 => "model key point",
        9 => "water",
        10 => "rail",
        11 => "road surface",
        12 => "overlap",
        13 => "wire, guard",
        14 => "wire, conductor",
        15 => "transmission tower",
        16 => "wire connector",
        17 => "bridge deck",
        18 => "high noise",
        _ => "of the file's own",
    }
}

fn rule_name(rule: &MirrorRule) -> String {
    match &rule.select {
        Select::Property(name) => format!("column {name}"),
        Select::Classification(classes) => {
            let classes: Vec<String> = classes.iter().map(u8::to_string).collect();
            format!("class {}", classes.join(", "))
        }
        Select::Box { .. } => "box".to_owned(),
        Select::NearPlane { within: None, .. } => "plane".to_owned(),
        Select::NearPlane { .. } => "region".to_owned(),
    }
}
