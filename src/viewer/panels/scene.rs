//! The scene as a tree: clouds, what of them is a mirror, mirrors put into it, and the clip box.

use catoptric::cloud::Bounds;
use eframe::egui::{self, RichText};
use glam::DVec3;

use super::{clouds, fields};
use crate::viewer::app::{Purpose, Viewer};
use crate::viewer::editing::{Kind, Selected};

pub(super) fn show(viewer: &mut Viewer, ui: &mut egui::Ui) {
    if viewer.opened.is_none() {
        ui.weak("Open a scene or a point cloud first.");
        return;
    }
    ui.horizontal(|ui| {
        let save = ui.button("Save scene...");
        if save
            .on_hover_text(
                "Write clouds, mirrors, settings and camera as a scene file (Ctrl+Shift+S)",
            )
            .clicked()
        {
            super::save::open(viewer);
        }
        if viewer.is_edited() {
            ui.weak("changed")
                .on_hover_text("What is shown is not what the scene's file says");
        }
    });
    ui.separator();
    egui::ScrollArea::vertical().show(ui, |ui| {
        clouds::show(viewer, ui);
        ui.separator();
        mirrors(viewer, ui);
        ui.separator();
        clip(viewer, ui);
        if let Some((selected, handle)) = viewer.selected_handle() {
            ui.separator();
            ui.heading("Chosen");
            let mut gizmo = std::mem::take(&mut viewer.gizmo);
            gizmo.buttons(ui, &handle);
            viewer.gizmo = gizmo;
            if let Some((shape, finished)) = fields::of_handle(ui, selected, &handle) {
                viewer.move_selected(shape, finished);
            }
        }
    });
}

fn mirrors(viewer: &mut Viewer, ui: &mut egui::Ui) {
    ui.horizontal(|ui| {
        ui.heading("Mirrors");
        let menu = ui.menu_button("Insert", |ui| {
            for (kind, name, about) in Kind::ALL {
                if ui.button(name).on_hover_text(about).clicked() {
                    viewer.insert(kind);
                }
            }
            let mesh = ui.button("Mesh...");
            if mesh
                .on_hover_text("A mirror of a PLY file with faces, where the file has it")
                .clicked()
            {
                viewer.ask_for(ui.ctx(), Purpose::InsertMesh);
            }
        });
        menu.response.on_hover_text(
            "Put a mirror where the pivot is; double click puts the pivot on a point",
        );
    });
    if viewer.document().mirrors.is_empty() {
        ui.weak("None was put into the scene.");
    }
    for index in 0..viewer.document().mirrors.len() {
        let Some(mirror) = viewer.document().mirrors.get(index) else {
            break;
        };
        let name = format!("{} {}", index + 1, fields::name_of(mirror));
        let this = Selected::Mirror(index);
        let label = ui.selectable_label(viewer.selected == Some(this), name);
        if label
            .on_hover_text("Choose it, to be moved by hand")
            .clicked()
        {
            let chosen = viewer.selected == Some(this);
            viewer.selected = (!chosen).then_some(this);
        }
    }
    if let Some(Selected::Mirror(index)) = viewer.selected {
        ui.horizontal(|ui| {
            let double = ui.button("Duplicate");
            if double
                .on_hover_text("A second one in the same place")
                .clicked()
                && let Some(mirror) = viewer.document().mirrors.get(index).cloned()
            {
                viewer.insert_mirror(mirror);
            }
            let remove = ui.button("Remove");
            if remove
                .on_hover_text("Take it out of the scene (Delete)")
                .clicked()
            {
                viewer.remove_selected();
            }
            let look = ui.button("Pivot here");
            if look.on_hover_text("Turn about it").clicked()
                && let Some((_, handle)) = viewer.selected_handle()
            {
                viewer.navigator.pivot = handle.centre();
                viewer.touch();
            }
        });
    }
}

fn clip(viewer: &mut Viewer, ui: &mut egui::Ui) {
    let Some(bounds) = viewer.opened.as_ref().map(|o| o.loaded.facts.bounds) else {
        return;
    };
    ui.horizontal(|ui| {
        let mut on = viewer.document().clip.is_some();
        let check = ui.checkbox(&mut on, RichText::new("Clip box").heading());
        let about = "Draw only what lies in a box; mirrors put into the scene stay whole";
        if check.on_hover_text(about).changed() {
            viewer.edit("clip box", |document| document.clip = on.then_some(bounds));
            viewer.selected = on.then_some(Selected::Clip);
        }
        if on {
            let chosen = viewer.selected == Some(Selected::Clip);
            let by_hand = ui.selectable_label(chosen, "by hand");
            if by_hand
                .on_hover_text("Show its handles in the picture")
                .clicked()
            {
                // Sides that the file leaves open end where the points do.
                let finite = viewer.document().clip.map(|clip| within(clip, bounds));
                viewer.edit("clip box", |document| document.clip = finite);
                viewer.selected = (!chosen).then_some(Selected::Clip);
            }
        }
    });
}

/// The box, but for sides that are infinitely far.
fn within(clip: Bounds, bounds: Bounds) -> Bounds {
    let side = |side: DVec3, end: DVec3| {
        DVec3::from_array(std::array::from_fn(|k| {
            if side[k].is_finite() { side[k] } else { end[k] }
        }))
    };
    let (a, b) = (side(clip.min, bounds.min), side(clip.max, bounds.max));
    Bounds {
        min: a.min(b),
        max: a.max(b),
    }
}
