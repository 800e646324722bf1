//! Outlines of mirrors and boxes, as lines over the picture.

use std::f64::consts::TAU;

use catoptric::cloud::Bounds;
use catoptric::cloud::generate::Shape;
use catoptric::scene::MirrorShape;
use eframe::egui::{Painter, Stroke};
use glam::{DVec2, DVec3};

use super::handles::Handle;
use super::screen::Screen;

/// Parts of a circle.
const STEPS: usize = 64;

/// Lines through points in the scene's frame.
pub(super) type Polylines = Vec<Vec<DVec3>>;

/// The outline of a mirror; of a mesh the box around it, where that is known.
pub(super) fn of_mirror(mirror: &MirrorShape, mesh: Option<Bounds>) -> Polylines {
    match Handle::of_mirror(mirror) {
        Some(handle) => of_handle(&handle),
        None => mesh.map_or_else(Vec::new, of_box),
    }
}

/// The outline of what is moved by hand; of a blob and of bumps that of the ball that they are on the whole.
pub(super) fn of_handle(handle: &Handle) -> Polylines {
    let axes = handle.axes();
    let [right, up, axis] = axes;
    let circle = |centre: DVec3, [u, v]: [DVec3; 2], radius: f64| -> Vec<DVec3> {
        around(STEPS)
            .map(|d| centre + (u * d.x + v * d.y) * radius)
            .collect()
    };
    match *handle {
        Handle::Box(bounds) => of_box(bounds),
        Handle::Mirror(Shape::Plane { centre, size, .. }) => {
            let (x, y) = (right * (size.x / 2.0), up * (size.y / 2.0));
            let corner = [-x - y, x - y, x + y, y - x, -x - y];
            let front = axis * (size.min_element() / 4.0);
            vec![
                corner.into_iter().map(|c| centre + c).collect(),
                vec![centre, centre + front],
            ]
        }
        Handle::Mirror(
            Shape::Sphere { centre, radius }
            | Shape::Blob { centre, radius, .. }
            | Shape::Bumps { centre, radius },
        ) => [[right, up], [up, axis], [axis, right]]
            .map(|pair| circle(centre, pair, radius))
            .to_vec(),
        Handle::Mirror(Shape::Paraboloid {
            vertex,
            focal_length,
            rim_radius,
            ..
        }) => {
            let height = |radius: f64| axis * (radius * radius / (4.0 * focal_length));
            let ring = |radius| circle(vertex + height(radius), [right, up], radius);
            let mut lines = vec![ring(rim_radius), ring(rim_radius / 2.0)];
            // From rim to rim, through the vertex.
            for out in around(8).take(4) {
                let out = right * out.x + up * out.y;
                let along = |k| rim_radius * (f64::from(k) / 16.0);
                lines.push(
                    (-16..=16)
                        .map(|k| vertex + out * along(k) + height(along(k)))
                        .collect(),
                );
            }
            lines
        }
        Handle::Mirror(Shape::Torus {
            centre,
            major_radius,
            minor_radius,
            ..
        }) => {
            let ring = |shift: f64, radius| circle(centre + axis * shift, [right, up], radius);
            let mut lines = vec![
                ring(0.0, major_radius + minor_radius),
                ring(0.0, major_radius - minor_radius),
                ring(minor_radius, major_radius),
                ring(-minor_radius, major_radius),
            ];
            for out in around(8).take(8) {
                let out = right * out.x + up * out.y;
                lines.push(circle(
                    centre + out * major_radius,
                    [out, axis],
                    minor_radius,
                ));
            }
            lines
        }
        Handle::Mirror(Shape::Mesh(_)) => Vec::new(),
    }
}

/// The twelve edges.
pub(super) fn of_box(bounds: Bounds) -> Polylines {
    let (min, max) = (bounds.min, bounds.max);
    if !(min.cmple(max).all() && min.is_finite() && max.is_finite()) {
        return Vec::new();
    }
    let ring = |z: f64| -> Vec<DVec3> {
        [
            (min.x, min.y),
            (max.x, min.y),
            (max.x, max.y),
            (min.x, max.y),
            (min.x, min.y),
        ]
        .map(|(x, y)| DVec3::new(x, y, z))
        .to_vec()
    };
    let (below, above) = (ring(min.z), ring(max.z));
    let posts = below.iter().zip(&above).take(4).map(|(b, a)| vec![*b, *a]);
    posts.chain([below.clone(), above.clone()]).collect()
}

/// Draws lines over the picture, as far as they are in front of the camera.
pub(super) fn draw(painter: &Painter, screen: &Screen, lines: &[Vec<DVec3>], stroke: Stroke) {
    let painter = painter.with_clip_rect(screen.rect().intersect(painter.clip_rect()));
    for line in lines {
        for part in screen.lines(line) {
            painter.line(part, stroke);
        }
    }
}

/// Directions all around, the first once more at the end.
fn around(steps: usize) -> impl Iterator<Item = DVec2> {
    (0..=steps).map(move |k| DVec2::from_angle(k as f64 / steps as f64 * TAU))
}

#[cfg(test)]
mod tests {
    use eframe::egui::Color32;

    use super::*;
    use crate::viewer::screen::tests::ahead;

    const CENTRE: DVec3 = DVec3::new(431_000.5, 5_300_000.25, 600.0);

    fn shapes() -> Vec<Shape> {
        let axis = DVec3::new(0.3, -0.5, 0.8).normalize();
        vec![
            Shape::Plane {
                centre: CENTRE,
                normal: axis,
                up: axis.any_orthonormal_vector(),
                size: DVec2::new(2.0, 1.0),
            },
            Shape::Sphere {
                centre: CENTRE,
                radius: 0.7,
            },
            Shape::Paraboloid {
                vertex: CENTRE,
                axis,
                focal_length: 0.25,
                rim_radius: 0.6,
            },
            Shape::Torus {
                centre: CENTRE,
                axis,
                major_radius: 0.6,
                minor_radius: 0.2,
            },
        ]
    }

    /// How far a point is off the shape's surface, by its formula.
    fn off(shape: &Shape, point: DVec3) -> f64 {
        let p = point - CENTRE;
        match *shape {
            Shape::Plane { normal, .. } => p.dot(normal),
            Shape::Sphere { radius, .. } => p.length() - radius,
            Shape::Paraboloid {
                axis, focal_length, ..
            } => {
                let along = p.dot(axis);
                along - (p - axis * along).length_squared() / (4.0 * focal_length)
            }
            Shape::Torus {
                axis,
                major_radius,
                minor_radius,
                ..
            } => {
                let along = p.dot(axis);
                let across = (p - axis * along).length() - major_radius;
                across.hypot(along) - minor_radius
            }
            _ => f64::NAN,
        }
    }

    #[test]
    fn outlines_lie_on_their_surfaces() {
        for shape in shapes() {
            let lines = of_mirror(&MirrorShape::Shape(shape.clone()), None);
            // The plane's last line is its normal.
            let count = lines.len() - usize::from(matches!(shape, Shape::Plane { .. }));
            assert!(count > 0, "{shape:?} has no outline");
            for point in lines.iter().take(count).flatten() {
                let off = off(&shape, *point);
                assert!(off.abs() < 1e-8, "{shape:?}: {point} is {off} off");
            }
        }
    }

    #[test]
    fn a_plane_has_its_size_and_looks_where_its_normal_does() {
        let lines = of_mirror(&MirrorShape::Shape(shapes().swap_remove(0)), None);
        let sides: Vec<f64> = (lines[0].windows(2)).map(|w| w[0].distance(w[1])).collect();
        for (side, size) in sides.iter().zip([2.0, 1.0, 2.0, 1.0]) {
            assert!((side - size).abs() < 1e-8, "{sides:?}");
        }
        let normal = lines[1][1] - lines[1][0];
        assert!(normal.dot(DVec3::new(0.3, -0.5, 0.8)) > 0.2, "{normal}");
    }

    #[test]
    fn a_box_has_twelve_edges_and_a_mesh_the_box_around_it() {
        let bounds = Bounds {
            min: DVec3::new(1.0, 2.0, 3.0),
            max: DVec3::new(2.0, 4.0, 7.0),
        };
        let mesh = MirrorShape::Mesh {
            path: "mesh.ply".into(),
        };
        let lines = of_mirror(&mesh, Some(bounds));
        let edges: Vec<f64> = lines
            .iter()
            .flat_map(|line| line.windows(2).map(|w| w[0].distance(w[1])))
            .collect();
        assert_eq!(edges.len(), 12);
        assert_eq!(edges.iter().sum::<f64>(), 4.0 * (1.0 + 2.0 + 4.0));
        assert!(of_mirror(&mesh, None).is_empty());
        let empty = Bounds::of([]);
        assert!(of_box(empty).is_empty(), "nothing has no edges");
    }

    #[test]
    fn what_is_behind_the_camera_is_not_drawn() {
        let screen = ahead(CENTRE, CENTRE);
        let ball = |z: f64| {
            of_handle(&Handle::Mirror(Shape::Sphere {
                centre: CENTRE + DVec3::Z * z,
                radius: 1.0,
            }))
        };
        let seen = |lines: &Polylines| lines.iter().map(|l| screen.lines(l).len()).sum::<usize>();
        assert_eq!(seen(&ball(0.0)), 3);
        let context = eframe::egui::Context::default();
        let painted = |z: f64| {
            let output = context.run_ui(Default::default(), |ui| {
                let painter = ui.painter().with_clip_rect(screen.rect());
                draw(
                    &painter,
                    &screen,
                    &ball(z),
                    Stroke::new(1.0, Color32::WHITE),
                );
            });
            output.shapes.len()
        };
        assert_eq!(painted(0.0) - painted(7.0), 3, "as many lines are drawn");
        assert_eq!(seen(&ball(7.0)), 0);
        assert!(seen(&ball(5.0)) > 0, "the camera is inside");
    }
}
