//! What is done to the scene by hand: what is chosen, inserted, marked, moved and removed.

use std::path::PathBuf;

use catoptric::camera::Pinhole;
use catoptric::cloud::generate::Shape;
use catoptric::cloud::{Bounds, MirrorRule, Select};
use catoptric::scene::{CloudSource, MirrorShape, SceneCloud};
use eframe::egui::{self, Color32, Rect, Stroke};
use glam::{DVec2, DVec3};

use super::app::Viewer;
use super::document::Document;
use super::handles::Handle;
use super::screen::Screen;
use super::wireframe;

/// Size of what is inserted, part of the distance to the pivot.
const INSERTED: f64 = 0.15;

/// Colours of outlines: what is chosen, and what is not.
const CHOSEN: Color32 = Color32::from_rgb(255, 200, 60);
const OTHER: Color32 = Color32::from_rgb(150, 170, 200);

/// What is chosen, to be looked at and moved by hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Selected {
    /// A mirror that was put into the scene.
    Mirror(usize),
    /// The clip box.
    Clip,
    /// A rule that makes mirrors of points.
    Rule { cloud: usize, rule: usize },
}

/// Mirrors that can be inserted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Plane,
    Sphere,
    Paraboloid,
    Torus,
    Blob,
    Bumps,
}

impl Kind {
    pub(super) const ALL: [(Self, &'static str, &'static str); 6] = [
        (Self::Plane, "Plane", "A flat mirror that looks at you"),
        (Self::Sphere, "Sphere", "A mirror ball"),
        (
            Self::Paraboloid,
            "Paraboloid",
            "A hollow mirror that opens towards you",
        ),
        (Self::Torus, "Torus", "A mirror ring"),
        (Self::Blob, "Blob", "A dented mirror ball"),
        (Self::Bumps, "Bumps", "A mirror ball with many small bumps"),
    ];

    /// One around a point, that looks to `front`.
    fn shape(self, centre: DVec3, size: f64, front: DVec3, up: DVec3) -> Shape {
        match self {
            Self::Plane => Shape::Plane {
                centre,
                normal: front,
                up: (up.reject_from_normalized(front)).normalize_or(front.any_orthonormal_vector()),
                size: DVec2::new(2.4, 1.8) * size,
            },
            Self::Sphere => Shape::Sphere {
                centre,
                radius: size,
            },
            Self::Paraboloid => Shape::Paraboloid {
                vertex: centre,
                axis: front,
                focal_length: size * 0.6,
                rim_radius: size,
            },
            Self::Torus => Shape::Torus {
                centre,
                axis: front,
                major_radius: size * 0.9,
                minor_radius: size * 0.3,
            },
            Self::Blob => Shape::Blob {
                centre,
                radius: size,
                amplitude: 0.25,
            },
            Self::Bumps => Shape::Bumps {
                centre,
                radius: size,
            },
        }
    }
}

/// What is chosen of a document, where it is something that can be moved by hand.
pub(super) fn handle(document: &Document, selected: Selected) -> Option<Handle> {
    match selected {
        Selected::Mirror(index) => Handle::of_mirror(document.mirrors.get(index)?),
        Selected::Clip => document
            .clip
            .filter(|c| c.size().is_finite())
            .map(Handle::Box),
        Selected::Rule { cloud, rule } => {
            match &document.clouds.get(cloud)?.mirrors.get(rule)?.select {
                Select::Box { min, max } => Some(Handle::Box(Bounds {
                    min: *min,
                    max: *max,
                })),
                Select::NearPlane {
                    within: Some(within),
                    ..
                } => Some(Handle::Box(*within)),
                _ => None,
            }
        }
    }
}

/// Puts a shape where what is chosen was.
fn put(document: &mut Document, selected: Selected, handle: &Handle) {
    match (selected, handle) {
        (Selected::Mirror(index), _) => {
            if let (Some(mirror), Some(shape)) = (document.mirrors.get_mut(index), handle.mirror())
            {
                *mirror = shape;
            }
        }
        (Selected::Clip, Handle::Box(bounds)) => document.clip = Some(*bounds),
        (Selected::Rule { cloud, rule }, Handle::Box(bounds)) => {
            let rule = (document.clouds.get_mut(cloud)).and_then(|c| c.mirrors.get_mut(rule));
            match rule.map(|rule| &mut rule.select) {
                Some(Select::Box { min, max }) => (*min, *max) = (bounds.min, bounds.max),
                Some(Select::NearPlane { within, .. }) => *within = Some(*bounds),
                _ => {}
            }
        }
        (Selected::Clip | Selected::Rule { .. }, Handle::Mirror(_)) => {}
    }
}

impl Viewer {
    /// The shape of what is chosen, as a drag under way has it.
    pub(super) fn selected_handle(&self) -> Option<(Selected, Handle)> {
        let selected = self.selected?;
        match &self.moving {
            Some((of, handle)) if *of == selected => Some((selected, handle.clone())),
            _ => Some((selected, handle(self.document(), selected)?)),
        }
    }

    /// Moves what is chosen: for the eye alone, or, where a drag is over, in the scene.
    pub(super) fn move_selected(&mut self, shape: Handle, finished: bool) {
        let Some(selected) = self.selected else {
            return;
        };
        if finished {
            self.moving = None;
            // Each drag is a step of its own.
            self.edit_once("drag", |document| put(document, selected, &shape));
        } else {
            self.moving = Some((selected, shape));
        }
    }

    /// Puts a mirror where the pivot is, and chooses it.
    pub(super) fn insert(&mut self, kind: Kind) {
        let (_, _, forward) = self.navigator.axes();
        let (centre, up) = (self.navigator.pivot, self.navigator.up());
        let size = self.navigator.reach() * INSERTED;
        let front = (-forward).normalize_or(DVec3::Z);
        let shape = kind.shape(centre, size, front, up);
        self.insert_mirror(MirrorShape::Shape(shape));
    }

    /// Puts a mirror into the scene, and chooses it.
    pub(super) fn insert_mirror(&mut self, mirror: MirrorShape) {
        let index = self.document().mirrors.len();
        self.edit_once("insert", |document| document.mirrors.push(mirror));
        self.selected = Some(Selected::Mirror(index));
    }

    /// Adds a cloud to what is open; opens it where nothing is.
    pub(super) fn add_cloud(&mut self, path: PathBuf) {
        if self.opened.is_none() {
            self.open(path);
            return;
        }
        if catoptric::scene::is_scene_file(&path) {
            self.say("a scene is opened, not added; add point clouds");
            return;
        }
        self.edit_once("add a cloud", |document| {
            document
                .clouds
                .push(SceneCloud::new(CloudSource::File(path)));
        });
    }

    /// Makes mirrors of what a rule chooses, and chooses the rule where it can be moved.
    pub(super) fn mark(&mut self, cloud: usize, select: Select) {
        let Some(marked) = self.document().clouds.get(cloud) else {
            return;
        };
        let rule = marked.mirrors.len();
        self.edit_once("mark", |document| {
            if let Some(cloud) = document.clouds.get_mut(cloud) {
                cloud.mirrors.push(MirrorRule {
                    select,
                    reflectance: 1.0,
                });
            }
        });
        self.selected = Some(Selected::Rule { cloud, rule });
    }

    /// A box about the pivot, to begin with.
    pub(super) fn box_about_pivot(&self) -> Bounds {
        let half = DVec3::splat(self.navigator.reach() * INSERTED);
        let centre = self.navigator.pivot;
        Bounds {
            min: centre - half,
            max: centre + half,
        }
    }

    /// Takes what is chosen out of the scene.
    pub(super) fn remove_selected(&mut self) {
        let Some(selected) = self.selected.take() else {
            return;
        };
        self.moving = None;
        self.edit_once("remove", |document| match selected {
            Selected::Mirror(index) if index < document.mirrors.len() => {
                document.mirrors.remove(index);
            }
            Selected::Clip => document.clip = None,
            Selected::Rule { cloud, rule } => {
                if let Some(cloud) = document.clouds.get_mut(cloud)
                    && rule < cloud.mirrors.len()
                {
                    cloud.mirrors.remove(rule);
                }
            }
            Selected::Mirror(_) => {}
        });
    }

    /// The region under the cursor becomes a mirror of this cloud, once it is found.
    pub(super) fn picked(&mut self, select: Option<Select>) {
        let Some(cloud) = self.picking.take() else {
            return;
        };
        match select {
            Some(select) => self.mark(cloud, select),
            None => self.say("no point is there to begin a region with"),
        }
    }
}

/// Outlines over the picture, and the gizmo of what is chosen; whether the pointer is the gizmo's.
pub(super) fn show(
    viewer: &mut Viewer,
    ui: &egui::Ui,
    rect: Rect,
    canvas: &egui::Response,
    pinhole: &Pinhole,
    origin: DVec3,
) -> bool {
    let screen = Screen::new(pinhole, origin, rect);
    let painter = ui.painter().with_clip_rect(rect);
    let chosen = viewer.selected_handle();
    if viewer.panels.shows_scene() {
        let is_chosen = |index| viewer.selected == Some(Selected::Mirror(index));
        for (index, mirror) in viewer.document().mirrors.iter().enumerate() {
            if !is_chosen(index) {
                let lines = wireframe::of_mirror(mirror, None);
                wireframe::draw(&painter, &screen, &lines, Stroke::new(1.0, OTHER));
            }
        }
    }
    let Some((selected, handle)) = chosen else {
        return false;
    };
    let lines = wireframe::of_handle(&handle);
    wireframe::draw(&painter, &screen, &lines, Stroke::new(1.5, CHOSEN));
    let of = egui::Id::unique(selected);
    let mut gizmo = std::mem::take(&mut viewer.gizmo);
    if let Some(moved) = gizmo.interact(ui, canvas, &screen, of, &handle) {
        viewer.move_selected(moved.handle, moved.finished);
        ui.ctx().request_repaint();
    }
    let taken = gizmo.is_hovered() || gizmo.is_active();
    viewer.gizmo = gizmo;
    taken
}
