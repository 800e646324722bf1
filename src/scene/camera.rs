//! The camera of a scene that does not say, or says only in part, where it is.

use glam::{DVec3, UVec2};

use super::fit::{Aim, corners, direction_to_eye, fitted};
use super::tree::{Origin, Origins};
use super::{Scene, SceneCamera};
use crate::camera::Camera;
use crate::cloud::{Bounds, UpAxis};
use crate::error::Result;

/// Width and height of a picture whose size nobody gives, pixels.
pub const DEFAULT_SIZE: UVec2 = UVec2::new(800, 600);
/// Vertical field of view that nobody gives, degrees.
pub const DEFAULT_FOV_Y_DEGREES: f64 = 60.0;
/// Nearest plane, relative to the farthest point: what is nearer to the eye is in it.
const NEAREST: f64 = 1e-4;

/// A camera outside of `bounds` (scene's frame) that sees all of them, from a little above and off the longer side.
pub fn default_camera(bounds: Bounds, up: UpAxis, size: UVec2) -> Camera {
    let stated = SceneCamera {
        size: Some(size),
        ..SceneCamera::unstated(Origins::of_table(Origin::given("")))
    };
    stated.complete(bounds, up)
}

impl SceneCamera {
    /// A camera of which nothing is said; `origins` is where it could have been.
    pub(super) fn unstated(origins: Origins) -> Self {
        Self {
            position: None,
            target: None,
            up: None,
            fov_y_degrees: None,
            near: None,
            far: None,
            size: None,
            origins,
        }
    }

    fn complete(&self, bounds: Bounds, up_axis: UpAxis) -> Camera {
        let corners = corners(bounds);
        let centre = bounds.centre();
        let size = self.size.unwrap_or(DEFAULT_SIZE);
        let fov_y_degrees = self.fov_y_degrees.unwrap_or(DEFAULT_FOV_Y_DEGREES);

        // Where it stands and looks.
        let (position, target) = match (self.position, self.target) {
            (Some(position), Some(target)) => (position, target),
            (Some(position), None) if position.distance(centre) > 1e-9 * bounds.size().length() => {
                (position, centre)
            }
            (Some(position), None) => {
                let level = direction_to_eye(bounds, up_axis).reject_from(up_axis.vector());
                (position, position - level)
            }
            (None, target) => {
                let half_height = (fov_y_degrees.to_radians() / 2.0).tan();
                let aspect = f64::from(size.x) / f64::from(size.y);
                let aim = Aim {
                    to_eye: direction_to_eye(bounds, up_axis),
                    up: self.up.unwrap_or(up_axis.vector()),
                    half_extent: (half_height * aspect, half_height),
                };
                fitted(bounds, target, &aim)
            }
        };
        let forward = (target - position).normalize_or(DVec3::NEG_Z);
        let up = self.up.unwrap_or_else(|| {
            let up = up_axis.vector();
            match up_axis {
                _ if up.cross(forward).length() > 1e-3 => up,
                // Looking straight down, what lies behind or north is up on screen.
                UpAxis::Y => DVec3::NEG_Z,
                UpAxis::Z => DVec3::Y,
            }
        });

        // What it sees.
        let depths = corners.map(|c| (c - position).dot(forward));
        let deepest = depths.iter().copied().fold(f64::MIN, f64::max);
        let farthest_corner = corners
            .iter()
            .map(|c| c.distance(position))
            .fold(f64::MIN_POSITIVE, f64::max);
        let deepest = if deepest > 0.0 {
            deepest
        } else {
            farthest_corner
        };
        let nearest = depths.iter().copied().fold(f64::MAX, f64::min);
        let far = self
            .far
            .unwrap_or_else(|| (deepest * 1.01).max(self.near.map_or(0.0, |near| near * 2.0)));
        let near = self
            .near
            .unwrap_or_else(|| (nearest * 0.99).clamp(far * NEAREST, far * 0.5));
        Camera {
            position,
            target,
            up,
            fov_y_degrees,
            near,
            far,
            size,
        }
    }
}

impl Scene {
    /// The camera, completed to fit `bounds` (scene's frame): a position outside of them
    /// or a target in their middle, `up` along `up_axis`, the planes around them.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] or [`crate::Error::Override`] where what is said does not make a camera: a target at the position,
    /// up along the view, planes in the wrong order.
    pub fn camera(&self, bounds: Bounds, up_axis: UpAxis) -> Result<Camera> {
        let camera = self.camera.complete(bounds, up_axis);
        match camera.axes() {
            Ok(_) => Ok(camera),
            Err(fault) => Err(self
                .camera
                .origins
                .to_blame(fault.keys)
                .error(fault.problem)),
        }
    }
}
