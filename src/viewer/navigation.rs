//! How a person moves the camera: a turntable about a pivot, panning, zooming to what is under the cursor, flying.

use catoptric::camera::Camera;
use catoptric::cloud::Bounds;
use glam::{DVec2, DVec3};

/// The camera never looks nearer to straight up or down than this, radians.
const POLE: f64 = 0.002;

/// What one notch of the wheel leaves of the distance.
const ZOOM: f64 = 0.85;

/// A camera that keeps its horizon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Navigator {
    pub(super) position: DVec3,
    /// What the camera turns about.
    pub(super) pivot: DVec3,
    /// Unit vector.
    up: DVec3,
    /// Direction of view about `up`, radians.
    yaw: f64,
    /// Its elevation, radians.
    pitch: f64,
}

/// Directions from which a scene is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NamedView {
    Front,
    Back,
    Left,
    Right,
    Top,
    Bottom,
}

impl NamedView {
    pub(super) const ALL: [(Self, &'static str); 6] = [
        (Self::Front, "Front"),
        (Self::Back, "Back"),
        (Self::Left, "Left"),
        (Self::Right, "Right"),
        (Self::Top, "Top"),
        (Self::Bottom, "Bottom"),
    ];
}

impl Navigator {
    /// As a camera looks; its roll is let go.
    pub(super) fn of(camera: &Camera) -> Self {
        let up = camera.up.normalize_or(DVec3::Y);
        let mut navigator = Self {
            position: camera.position,
            pivot: camera.target,
            up,
            yaw: 0.0,
            pitch: 0.0,
        };
        navigator.look_along(camera.target - camera.position);
        navigator
    }

    /// The camera, which is `like` another but for its place.
    pub(super) fn camera(&self, like: &Camera) -> Camera {
        let (_, _, forward) = self.axes();
        let distance = (self.pivot - self.position)
            .dot(forward)
            .max(self.reach() * 1e-3);
        Camera {
            position: self.position,
            target: self.position + forward * distance.max(f64::MIN_POSITIVE * 1e10),
            up: self.up,
            ..*like
        }
    }

    /// Two horizontal unit vectors: yaw 0 looks along the first.
    fn level(&self) -> (DVec3, DVec3) {
        // The axis that is least up, so that the same up has the same yaw.
        let a = self.up.abs();
        let axis = if a.z <= a.x && a.z <= a.y {
            DVec3::NEG_Z
        } else if a.y <= a.x {
            DVec3::Y
        } else {
            DVec3::X
        };
        let ahead = axis.reject_from(self.up).normalize_or(DVec3::X);
        (ahead, ahead.cross(self.up))
    }

    /// Right, up on screen and forward, unit vectors.
    pub(super) fn axes(&self) -> (DVec3, DVec3, DVec3) {
        let (ahead, right) = self.level();
        let level = ahead * self.yaw.cos() + right * self.yaw.sin();
        let forward = level * self.pitch.cos() + self.up * self.pitch.sin();
        let right = level.cross(self.up);
        (right, right.cross(forward), forward)
    }

    fn look_along(&mut self, direction: DVec3) {
        let Some(direction) = direction.try_normalize() else {
            return;
        };
        let (ahead, right) = self.level();
        self.yaw = direction.dot(right).atan2(direction.dot(ahead));
        let pole = std::f64::consts::FRAC_PI_2 - POLE;
        self.pitch = direction
            .dot(self.up)
            .clamp(-1.0, 1.0)
            .asin()
            .clamp(-pole, pole);
    }

    /// Distance to the pivot, above 0.
    pub(super) fn reach(&self) -> f64 {
        self.position
            .distance(self.pivot)
            .max(f64::MIN_POSITIVE * 1e10)
    }

    /// Turns by angles, radians; the pivot stays where it is on screen.
    pub(super) fn orbit(&mut self, right: f64, up: f64) {
        let (x, y, z) = self.axes();
        let to_pivot = self.pivot - self.position;
        let seen = DVec3::new(to_pivot.dot(x), to_pivot.dot(y), to_pivot.dot(z));
        let pole = std::f64::consts::FRAC_PI_2 - POLE;
        self.yaw = (self.yaw + right) % std::f64::consts::TAU;
        self.pitch = (self.pitch + up).clamp(-pole, pole);
        let (x, y, z) = self.axes();
        self.position = self.pivot - (x * seen.x + y * seen.y + z * seen.z);
    }

    /// Turns the head, radians.
    pub(super) fn look(&mut self, right: f64, up: f64) {
        let ahead = self.reach();
        let pole = std::f64::consts::FRAC_PI_2 - POLE;
        self.yaw = (self.yaw + right) % std::f64::consts::TAU;
        self.pitch = (self.pitch + up).clamp(-pole, pole);
        self.pivot = self.position + self.axes().2 * ahead;
    }

    /// Shifts by pixels, so that what is as far as the pivot follows the cursor.
    pub(super) fn pan(&mut self, pixels: DVec2, like: &Camera) {
        let (right, up, forward) = self.axes();
        let depth = (self.pivot - self.position)
            .dot(forward)
            .abs()
            .max(self.reach() * 1e-2);
        let pixel = 2.0 * depth * (like.fov_y_degrees.to_radians() / 2.0).tan()
            / f64::from(like.size.y.max(1));
        let by = (up * pixels.y - right * pixels.x) * pixel;
        self.position += by;
        self.pivot += by;
    }

    /// Goes towards a point by notches of the wheel, or away from it.
    pub(super) fn zoom(&mut self, notches: f64, towards: DVec3) {
        let part = 1.0 - ZOOM.powf(notches.clamp(-20.0, 20.0));
        let by = (towards - self.position) * part;
        self.position += by;
        // The pivot keeps its distance to what is zoomed to, in proportion.
        self.pivot += (towards - self.pivot) * part.max(0.0);
    }

    /// Flies by this much to the right, up and ahead; the pivot comes along.
    pub(super) fn fly(&mut self, by: DVec3) {
        let (right, up, forward) = self.axes();
        let by = right * by.x + up * by.y + forward * by.z;
        self.position += by;
        self.pivot += by;
    }

    /// Steps back, or up, until a box fills the picture, looking the same way.
    pub(super) fn frame(&mut self, bounds: Bounds, like: &Camera) {
        let radius = (bounds.size().length() / 2.0).max(f64::MIN_POSITIVE * 1e10);
        let half = (like.fov_y_degrees.to_radians() / 2.0).tan();
        let aspect = f64::from(like.size.x) / f64::from(like.size.y.max(1));
        let narrow = (half * aspect.min(1.0)).atan();
        self.pivot = bounds.centre();
        self.position = self.pivot - self.axes().2 * (radius / narrow.sin());
    }

    /// Looks from a side at a box.
    pub(super) fn look_from(&mut self, view: NamedView, bounds: Bounds, like: &Camera) {
        let (ahead, right) = self.level();
        self.look_along(match view {
            NamedView::Front => ahead,
            NamedView::Back => -ahead,
            NamedView::Left => right,
            NamedView::Right => -right,
            NamedView::Top | NamedView::Bottom => ahead,
        });
        let pole = std::f64::consts::FRAC_PI_2 - POLE;
        match view {
            NamedView::Top => self.pitch = -pole,
            NamedView::Bottom => self.pitch = pole,
            _ => {}
        }
        self.frame(bounds, like);
    }

    /// Takes another axis for up, looking the same way as far as it can.
    pub(super) fn set_up(&mut self, up: DVec3) {
        let forward = self.axes().2;
        self.up = up.normalize_or(DVec3::Y);
        self.look_along(forward);
        self.position = self.pivot - self.axes().2 * self.reach();
    }

    /// Unit vector.
    pub(super) fn up(&self) -> DVec3 {
        self.up
    }
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    fn camera() -> Camera {
        Camera {
            position: DVec3::new(1.0, 2.0, 3.0),
            target: DVec3::new(-1.0, 0.5, -4.0),
            up: DVec3::Y,
            fov_y_degrees: 60.0,
            near: 0.01,
            far: 100.0,
            size: UVec2::new(800, 600),
        }
    }

    fn pixel(navigator: &Navigator, point: DVec3) -> glam::Vec2 {
        let pinhole = navigator
            .camera(&camera())
            .pinhole(DVec3::ZERO)
            .expect("a camera");
        pinhole.pixel_from_view(pinhole.view_from_world(point.as_vec3()))
    }

    #[test]
    fn a_camera_that_nobody_moves_stays() {
        for up in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_Y] {
            let still = Camera { up, ..camera() };
            let back = Navigator::of(&still).camera(&still);
            assert!((back.position - still.position).length() < 1e-12, "{up}");
            assert!(
                (back.target - still.target).length() < 1e-9,
                "{up}: {back:?}"
            );
        }
    }

    #[test]
    fn the_pivot_stays_on_screen_while_one_turns_about_it() {
        let mut navigator = Navigator::of(&camera());
        navigator.pivot += DVec3::new(0.7, -0.4, 0.9);
        let (before, reach) = (pixel(&navigator, navigator.pivot), navigator.reach());
        navigator.orbit(0.8, 0.3);
        let after = pixel(&navigator, navigator.pivot);
        assert!((after - before).length() < 0.01, "{before} -> {after}");
        assert!((navigator.reach() - reach).abs() < 1e-12);
        assert!(
            (navigator.position - camera().position).length() > 1.0,
            "it moved"
        );
    }

    #[test]
    fn what_is_under_the_cursor_stays_there_when_one_zooms_to_it() {
        let mut navigator = Navigator::of(&camera());
        let point = DVec3::new(-0.5, 1.5, -2.0);
        let before = pixel(&navigator, point);
        navigator.zoom(3.0, point);
        assert!((pixel(&navigator, point) - before).length() < 0.01);
        let near = navigator.position.distance(point);
        navigator.zoom(-3.0, point);
        assert!(
            (navigator.position - camera().position).length() < 1e-9,
            "and back"
        );
        assert!(near < camera().position.distance(point));
    }

    #[test]
    fn what_is_panned_follows_the_cursor() {
        let mut navigator = Navigator::of(&camera());
        let point = navigator.pivot;
        let before = pixel(&navigator, point);
        navigator.pan(DVec2::new(40.0, -25.0), &camera());
        let moved = pixel(&navigator, point) - before;
        assert!(
            (moved - glam::Vec2::new(40.0, -25.0)).length() < 0.05,
            "{moved}"
        );
    }

    #[test]
    fn all_of_a_box_is_in_the_picture_from_every_side() {
        let bounds = Bounds {
            min: DVec3::new(-1.0, 0.0, 5.0),
            max: DVec3::new(2.0, 8.0, 6.0),
        };
        for up in [DVec3::Y, DVec3::Z] {
            for (view, name) in NamedView::ALL {
                let mut navigator = Navigator::of(&Camera { up, ..camera() });
                navigator.look_from(view, bounds, &camera());
                for corner in 0..8 {
                    let part = DVec3::new(
                        f64::from(corner & 1),
                        f64::from(corner >> 1 & 1),
                        f64::from(corner >> 2),
                    );
                    let p = pixel(&navigator, bounds.min + part * bounds.size());
                    assert!(
                        p.x >= 0.0 && p.y >= 0.0 && p.x <= 800.0 && p.y <= 600.0,
                        "{name}, up {up}: corner {corner} at {p}"
                    );
                }
            }
        }
    }

    #[test]
    fn no_turn_goes_over_the_pole() {
        let mut navigator = Navigator::of(&camera());
        for _ in 0..100 {
            navigator.orbit(0.1, 0.5);
            assert!(navigator.camera(&camera()).pinhole(DVec3::ZERO).is_ok());
        }
    }
}
