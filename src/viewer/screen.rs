//! Where the scene is in the window: the place of a point, the ray under a place, lines cut where they leave the view.
//!
//! All in f64 until it is a place in the window, so that coordinates of millions of metres do not jitter.

use catoptric::camera::Pinhole;
use eframe::egui::{Pos2, Rect};
use glam::{DVec2, DVec3};

/// How far beyond the picture lines go on, points of the window: their cut ends are not seen.
const MARGIN: f32 = 64.0;

/// A camera whose picture fills a rectangle of the window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Screen {
    rect: Rect,
    /// In the scene's frame.
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    near: f64,
    /// Points of the window per unit of slope, across and down.
    focal: DVec2,
    /// Where the axis meets the window.
    centre: DVec2,
}

impl Screen {
    /// `pinhole` is relative to `origin`, and its picture fills `rect`.
    pub(super) fn new(pinhole: &Pinhole, origin: DVec3, rect: Rect) -> Self {
        let size = DVec2::new(f64::from(rect.width()), f64::from(rect.height()));
        let scale = size / pinhole.size.as_dvec2().max(DVec2::ONE);
        let corner = DVec2::new(f64::from(rect.min.x), f64::from(rect.min.y));
        Self {
            rect,
            eye: origin + pinhole.eye.as_dvec3(),
            right: pinhole.right.as_dvec3(),
            up: pinhole.up.as_dvec3(),
            forward: pinhole.forward.as_dvec3(),
            near: f64::from(pinhole.near),
            focal: f64::from(pinhole.focal) * scale,
            centre: corner + pinhole.centre.as_dvec2() * scale,
        }
    }

    pub(super) fn rect(&self) -> Rect {
        self.rect
    }

    pub(super) fn eye(&self) -> DVec3 {
        self.eye
    }

    /// Unit vectors: right and up in the window, and along the axis.
    pub(super) fn axes(&self) -> [DVec3; 3] {
        [self.right, self.up, self.forward]
    }

    /// A point as the camera has it: to the right, up, ahead.
    fn view(&self, point: DVec3) -> DVec3 {
        let d = point - self.eye;
        DVec3::new(d.dot(self.right), d.dot(self.up), d.dot(self.forward))
    }

    fn place_of_view(&self, view: DVec3) -> DVec2 {
        self.centre + self.focal * DVec2::new(view.x, -view.y) / view.z
    }

    /// Where a point is in the window; `None` before the near plane and behind the camera.
    pub(super) fn place(&self, point: DVec3) -> Option<DVec2> {
        let view = self.view(point);
        let place = self.place_of_view(view);
        (view.z >= self.near && view.z > 0.0 && place.is_finite()).then_some(place)
    }

    /// The same, as egui has it.
    pub(super) fn pos(&self, point: DVec3) -> Option<Pos2> {
        self.place(point).map(pos)
    }

    /// Length in the scene of one point of the window, as far away as `point`.
    pub(super) fn unit(&self, point: DVec3) -> Option<f64> {
        let depth = self.view(point).z;
        let unit = depth / self.focal.y;
        (depth >= self.near && unit > 0.0 && unit.is_finite()).then_some(unit)
    }

    /// How the place of `point` changes while it goes along `direction`: points of the window per unit of length.
    pub(super) fn motion(&self, point: DVec3, direction: DVec3) -> Option<DVec2> {
        let at = self.view(point);
        let by = self.view(self.eye + direction);
        let slope =
            DVec2::new(by.x * at.z - at.x * by.z, -(by.y * at.z - at.y * by.z)) / (at.z * at.z);
        let motion = self.focal * slope;
        (at.z > 0.0 && motion.is_finite()).then_some(motion)
    }

    /// Unit vector from the eye through a place in the window.
    pub(super) fn ray(&self, place: DVec2) -> DVec3 {
        let slope = (place - self.centre) / self.focal;
        (self.right * slope.x - self.up * slope.y + self.forward).normalize_or(self.forward)
    }

    /// The part of a line that is in the picture, or little beyond.
    pub(super) fn line(&self, from: DVec3, to: DVec3) -> Option<[Pos2; 2]> {
        let (a, b) = (self.view(from), self.view(to));
        let near = self.near.max(f64::MIN_POSITIVE * 1e10);
        let cut = |behind: DVec3, ahead: DVec3| {
            if behind.z >= near {
                behind
            } else {
                behind + (ahead - behind) * ((near - behind.z) / (ahead.z - behind.z))
            }
        };
        if !(a.z >= near || b.z >= near) {
            return None;
        }
        let ends = [self.place_of_view(cut(a, b)), self.place_of_view(cut(b, a))];
        within(self.rect.expand(MARGIN), ends)
    }

    /// Lines through points one after the other, in as many parts as are seen.
    pub(super) fn lines(&self, points: &[DVec3]) -> Vec<Vec<Pos2>> {
        let mut parts: Vec<Vec<Pos2>> = Vec::new();
        for (from, to) in points.iter().zip(points.iter().skip(1)) {
            let Some([start, end]) = self.line(*from, *to) else {
                continue;
            };
            match parts.last_mut() {
                Some(part) if part.last().is_some_and(|last| last.distance(start) < 1e-2) => {
                    part.push(end);
                }
                _ => parts.push(vec![start, end]),
            }
        }
        parts
    }
}

/// A place as egui has it.
pub(super) fn pos(place: DVec2) -> Pos2 {
    Pos2::new(place.x as f32, place.y as f32)
}

/// A place of egui's.
pub(super) fn place(pos: Pos2) -> DVec2 {
    DVec2::new(f64::from(pos.x), f64::from(pos.y))
}

/// The part of a line that is in a rectangle.
fn within(rect: Rect, [from, to]: [DVec2; 2]) -> Option<[Pos2; 2]> {
    if !(from.is_finite() && to.is_finite()) {
        return None;
    }
    let (min, max) = (place(rect.min), place(rect.max));
    let along = to - from;
    let (mut first, mut last) = (0.0f64, 1.0f64);
    for axis in 0..2 {
        if along[axis].abs() < 1e-12 {
            if from[axis] < min[axis] || from[axis] > max[axis] {
                return None;
            }
            continue;
        }
        let (a, b) = (
            (min[axis] - from[axis]) / along[axis],
            (max[axis] - from[axis]) / along[axis],
        );
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    (first <= last).then(|| [pos(from + along * first), pos(from + along * last)])
}

#[cfg(test)]
pub(super) mod tests {
    use catoptric::camera::Camera;
    use eframe::egui::{Rect, pos2, vec2};
    use glam::UVec2;

    use super::*;

    /// Looks from 5 along z at `target`; one unit there is 100 points of an 800 x 600 window at (100, 50).
    pub(in crate::viewer) fn ahead(target: DVec3, origin: DVec3) -> Screen {
        let camera = Camera {
            position: target + DVec3::Z * 5.0,
            target,
            up: DVec3::Y,
            fov_y_degrees: 2.0 * (300.0f64 / 500.0).atan().to_degrees(),
            near: 0.1,
            far: 100.0,
            size: UVec2::new(1600, 1200),
        };
        let rect = Rect::from_min_size(pos2(100.0, 50.0), vec2(800.0, 600.0));
        Screen::new(&camera.pinhole(origin).expect("a camera"), origin, rect)
    }

    fn near(a: DVec2, b: DVec2) -> bool {
        a.distance(b) < 1e-3
    }

    #[test]
    fn a_unit_at_five_units_is_a_hundred_points() {
        let screen = ahead(DVec3::ZERO, DVec3::ZERO);
        let middle = DVec2::new(500.0, 350.0);
        for (point, by) in [
            (DVec3::ZERO, DVec2::ZERO),
            (DVec3::X, DVec2::new(100.0, 0.0)),
            (DVec3::Y, DVec2::new(0.0, -100.0)),
            (DVec3::new(1.0, 0.0, -5.0), DVec2::new(50.0, 0.0)),
        ] {
            let place = screen.place(point).expect("in front");
            assert!(near(place, middle + by), "{point} at {place}");
            let seen = screen.eye() + screen.ray(place) * screen.eye().distance(point);
            assert!(seen.distance(point) < 1e-6, "{point} from {seen}");
        }
        let unit = screen.unit(DVec3::X).expect("in front");
        assert!((unit - 0.01).abs() < 1e-7, "{unit}");
        assert_eq!(screen.place(DVec3::Z * 4.95), None, "before the near plane");
        assert_eq!(screen.place(DVec3::Z * 6.0), None, "behind");
    }

    #[test]
    fn millions_of_metres_from_zero_a_millimetre_is_a_tenth_of_a_point() {
        let far = DVec3::new(432_100.25, 5_300_200.5, 612.125);
        let screen = ahead(far, far - DVec3::new(3.0, 2.0, 1.0));
        let place = |x: f64| screen.place(far + DVec3::X * x).expect("in front");
        assert!(near(place(0.0), DVec2::new(500.0, 350.0)), "{}", place(0.0));
        assert!(near(place(0.001) - place(0.0), DVec2::new(0.1, 0.0)));
    }

    #[test]
    fn motion_is_how_places_change() {
        let screen = ahead(DVec3::ZERO, DVec3::ZERO);
        let (point, along) = (DVec3::new(0.7, -0.4, 1.0), DVec3::new(0.3, 0.5, -0.8));
        let at = |t: f64| screen.place(point + along * t).expect("in front");
        let by_parts = (at(1e-5) - at(-1e-5)) / 2e-5;
        let motion = screen.motion(point, along).expect("in front");
        assert!(motion.distance(by_parts) < 1e-4, "{motion} {by_parts}");
    }

    #[test]
    fn lines_end_at_the_near_plane_and_little_beyond_the_picture() {
        let screen = ahead(DVec3::ZERO, DVec3::ZERO);
        let behind = screen.line(DVec3::new(1.0, 0.0, 6.0), DVec3::new(1.0, 0.0, 0.0));
        let [a, b] = behind.expect("half of it is in front");
        assert!(
            (b.x - 600.0).abs() < 1e-2 && a.x > 900.0 && a.x < 965.0,
            "{a} {b}"
        );
        assert_eq!(screen.line(DVec3::Z * 6.0, DVec3::Z * 7.0), None);
        assert_eq!(screen.line(DVec3::NAN, DVec3::NAN), None);
        let aside = screen.line(DVec3::new(-9.0, 9.0, 0.0), DVec3::new(9.0, 9.0, 0.0));
        assert_eq!(aside, None, "above the picture");
        // Into the picture, through behind the camera, and into the picture again: two parts.
        let parts = screen.lines(&[
            DVec3::new(-1.0, 0.0, 0.0),
            DVec3::new(-1.0, 0.0, 9.0),
            DVec3::new(1.0, 0.0, 9.0),
            DVec3::new(1.0, 0.0, 0.0),
        ]);
        assert_eq!(parts.len(), 2, "{parts:?}");
    }
}
