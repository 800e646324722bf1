//! Numbers of a shape, to be typed or dragged.

use catoptric::cloud::generate::Shape;
use catoptric::scene::MirrorShape;
use eframe::egui::{self, DragValue, Response};
use glam::DVec3;

use crate::viewer::editing::Selected;
use crate::viewer::handles::Handle;

/// A drag of one point of the window changes a length by this part of it.
const SPEED: f64 = 0.005;

pub(super) fn name_of(mirror: &MirrorShape) -> String {
    match mirror {
        MirrorShape::Mesh { path } => {
            let name = path.file_name().unwrap_or(path.as_os_str());
            format!("mesh {}", name.to_string_lossy())
        }
        MirrorShape::Shape(shape) => match shape {
            Shape::Plane { .. } => "plane",
            Shape::Sphere { .. } => "sphere",
            Shape::Paraboloid { .. } => "paraboloid",
            Shape::Torus { .. } => "torus",
            Shape::Blob { .. } => "blob",
            Shape::Bumps { .. } => "bumps",
            Shape::Mesh(_) => "mesh",
        }
        .to_owned(),
    }
}

/// A number of a shape, or three of them.
enum Field<'a> {
    Point(&'static str, &'a mut DVec3),
    Direction(&'static str, &'a mut DVec3),
    /// Above 0.
    Length(&'static str, &'a mut f64),
    /// From 0 to 0.9.
    Part(&'static str, &'a mut f64),
}

/// The shape as it was changed, and whether the change is over; `None` where nothing was.
pub(super) fn of_handle(
    ui: &mut egui::Ui,
    selected: Selected,
    handle: &Handle,
) -> Option<(Handle, bool)> {
    let mut changed = handle.clone();
    let size = size_of(handle);
    let (mut any, mut over) = (false, false);
    let mut hear = |response: &Response| {
        any |= response.changed();
        over |= (response.changed() && !response.dragged()) || response.drag_stopped();
    };
    egui::Grid::new(("fields", selected))
        .num_columns(2)
        .show(ui, |ui| {
            for field in fields(&mut changed) {
                match field {
                    Field::Point(name, point) => {
                        ui.label(name).on_hover_text("In the scene's frame");
                        three(
                            ui,
                            point,
                            size * SPEED,
                            4,
                            "In the scene's frame",
                            &mut hear,
                        );
                    }
                    Field::Direction(name, direction) => {
                        ui.label(name)
                            .on_hover_text("A direction; its length does not count");
                        let before = *direction;
                        let about = "A direction; its length does not count";
                        three(ui, direction, 0.01, 3, about, &mut hear);
                        if direction.try_normalize().is_none() {
                            *direction = before;
                        }
                    }
                    Field::Length(name, length) => {
                        ui.label(name).on_hover_text("In the clouds' unit");
                        let value = typed(length).range(1e-9..=9e11);
                        let value = value.speed((size * SPEED).max(1e-9)).max_decimals(6);
                        hear(&ui.add(value).on_hover_text("In the clouds' unit"));
                    }
                    Field::Part(name, part) => {
                        ui.label(name).on_hover_text("Relative to the radius");
                        let value = typed(part).range(0.0..=0.9).speed(0.005);
                        hear(&ui.add(value).on_hover_text("Relative to the radius"));
                    }
                }
                ui.end_row();
            }
        });
    // A drag that ends where it was is over all the same.
    (any || over).then(|| (sound(changed, handle), over))
}

/// A number that counts once it is typed whole.
fn typed(value: &mut f64) -> DragValue<'_> {
    DragValue::new(value).update_while_editing(false)
}

fn three(
    ui: &mut egui::Ui,
    point: &mut DVec3,
    speed: f64,
    decimals: usize,
    about: &str,
    hear: &mut impl FnMut(&Response),
) {
    ui.horizontal(|ui| {
        ui.spacing_mut().interact_size.x = 44.0;
        ui.spacing_mut().item_spacing.x = 3.0;
        for value in [&mut point.x, &mut point.y, &mut point.z] {
            let value = typed(value).range(-9e14..=9e14);
            let value = value.speed(speed.max(1e-9)).max_decimals(decimals);
            hear(&ui.add(value).on_hover_text(about));
        }
    });
}

fn fields(handle: &mut Handle) -> Vec<Field<'_>> {
    use Field::{Direction, Length, Part, Point};
    match handle {
        Handle::Box(bounds) => vec![Point("min", &mut bounds.min), Point("max", &mut bounds.max)],
        Handle::Mirror(shape) => match shape {
            Shape::Plane {
                centre,
                normal,
                up,
                size,
            } => vec![
                Point("centre", centre),
                Direction("normal", normal),
                Direction("up", up),
                Length("width", &mut size.x),
                Length("height", &mut size.y),
            ],
            Shape::Sphere { centre, radius } | Shape::Bumps { centre, radius } => {
                vec![Point("centre", centre), Length("radius", radius)]
            }
            Shape::Paraboloid {
                vertex,
                axis,
                focal_length,
                rim_radius,
            } => vec![
                Point("vertex", vertex),
                Direction("axis", axis),
                Length("focal length", focal_length),
                Length("rim radius", rim_radius),
            ],
            Shape::Torus {
                centre,
                axis,
                major_radius,
                minor_radius,
            } => vec![
                Point("centre", centre),
                Direction("axis", axis),
                Length("major radius", major_radius),
                Length("minor radius", minor_radius),
            ],
            Shape::Blob {
                centre,
                radius,
                amplitude,
            } => vec![
                Point("centre", centre),
                Length("radius", radius),
                Part("amplitude", amplitude),
            ],
            Shape::Mesh(_) => Vec::new(),
        },
    }
}

/// What a drag's speed is measured by.
fn size_of(handle: &Handle) -> f64 {
    let longest = handle
        .arms()
        .into_iter()
        .map(|arm| arm.at.distance(handle.centre()));
    longest.fold(1e-6, f64::max)
}

/// The shape, such that a scene file may hold it: directions of unit length, corners in order.
fn sound(mut changed: Handle, before: &Handle) -> Handle {
    match &mut changed {
        Handle::Box(bounds) => {
            (bounds.min, bounds.max) = (bounds.min.min(bounds.max), bounds.max.max(bounds.min));
        }
        Handle::Mirror(Shape::Plane { normal, up, .. }) => {
            *normal = normal.normalize_or(DVec3::Z);
            let across = normal.any_orthonormal_vector();
            *up = up.reject_from_normalized(*normal).normalize_or(across);
        }
        Handle::Mirror(Shape::Paraboloid { axis, .. }) => *axis = axis.normalize_or(DVec3::Z),
        Handle::Mirror(Shape::Torus {
            axis,
            major_radius,
            minor_radius,
            ..
        }) => {
            *axis = axis.normalize_or(DVec3::Z);
            if minor_radius >= major_radius {
                return before.clone();
            }
        }
        Handle::Mirror(_) => {}
    }
    changed
}
