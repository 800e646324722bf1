//! The camera as JSON, with what another program needs to project into the picture.

use glam::{DMat4, DVec3, DVec4};
use serde::Serialize;

use crate::camera::Camera;
use crate::error::Result;

/// A camera as another program needs it. The first seven keys are those of a scene's `[camera]`.
///
/// Matrices are row by row and take column vectors relative to `origin`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CameraDescription {
    /// Of this description: 1.
    pub format: u32,
    /// The eye, in the scene's frame.
    pub position: DVec3,
    /// What it looks at, in the scene's frame.
    pub target: DVec3,
    /// Roughly up.
    pub up: DVec3,
    /// Vertical field of view, degrees.
    pub fov_y_degrees: f64,
    /// Nearest depth along the axis.
    pub near: f64,
    /// Farthest depth along the axis.
    pub far: f64,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// What positions in buffers and both matrices are relative to, in the scene's frame.
    pub origin: DVec3,
    /// Pixels per unit of slope, horizontally and vertically alike.
    pub focal_pixels: f64,
    /// Where the axis meets the picture, pixels from the top left corner.
    pub principal_point: [f64; 2],
    /// To x right, y up, z forward.
    pub view_from_world: [[f64; 4]; 4],
    /// To clip space: after division by w, x and y are -1 to 1 (y up), z is 0 at `near` and 1 at `far`.
    pub clip_from_world: [[f64; 4]; 4],
}

impl CameraDescription {
    /// Describes `camera` relative to `origin`.
    ///
    /// # Errors
    /// Where the camera is degenerate, as [`Camera::pinhole`] says.
    pub fn new(camera: &Camera, origin: DVec3) -> Result<Self> {
        camera.pinhole(origin)?;
        let eye = camera.position - origin;
        let forward = (camera.target - camera.position).normalize_or_zero();
        let right = forward.cross(camera.up).normalize_or_zero();
        let up = right.cross(forward);
        let row = |axis: DVec3| axis.extend(-axis.dot(eye));
        let view_from_world =
            DMat4::from_cols(row(right), row(up), row(forward), DVec4::W).transpose();

        let size = camera.size.as_dvec2();
        let focal = size.y / 2.0 / (camera.fov_y_degrees.to_radians() / 2.0).tan();
        let stretch = camera.far / (camera.far - camera.near);
        let clip_from_view = DMat4::from_cols(
            DVec4::X * (2.0 * focal / size.x),
            DVec4::Y * (2.0 * focal / size.y),
            DVec4::new(0.0, 0.0, stretch, 1.0),
            DVec4::Z * (-stretch * camera.near),
        );
        let rows = |matrix: DMat4| matrix.transpose().to_cols_array_2d();
        Ok(Self {
            format: 1,
            position: camera.position,
            target: camera.target,
            up: camera.up,
            fov_y_degrees: camera.fov_y_degrees,
            near: camera.near,
            far: camera.far,
            size: camera.size.to_array(),
            origin,
            focal_pixels: focal,
            principal_point: (size / 2.0).to_array(),
            view_from_world: rows(view_from_world),
            clip_from_world: rows(clip_from_view * view_from_world),
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::{UVec2, Vec2};

    use super::*;

    fn camera() -> Camera {
        Camera {
            position: DVec3::new(636_010.0, 848_900.0, 500.0),
            target: DVec3::new(636_050.0, 848_990.0, 410.0),
            up: DVec3::Z,
            fov_y_degrees: 50.0,
            near: 0.5,
            far: 1000.0,
            size: UVec2::new(640, 360),
        }
    }

    #[test]
    fn the_matrix_projects_where_the_renderer_does() {
        let origin = DVec3::new(636_000.0, 849_000.0, 400.0);
        let described = CameraDescription::new(&camera(), origin).expect("a sound camera");
        let pinhole = camera().pinhole(origin).expect("a sound camera");
        let point = DVec3::new(48.0, -20.0, 15.0);
        let clip = described
            .clip_from_world
            .map(|row| DVec4::from(row).dot(point.extend(1.0)));
        let ndc = Vec2::new((clip[0] / clip[3]) as f32, (clip[1] / clip[3]) as f32);
        let got = (ndc * Vec2::new(0.5, -0.5) + 0.5) * pinhole.size.as_vec2();
        let view = pinhole.view_from_world(point.as_vec3());
        let expected = pinhole.pixel_from_view(view);
        assert!(
            (got - expected).length() < 0.01,
            "got {got}, expected {expected}"
        );
        assert!(
            (clip[3] as f32 - view.z).abs() < 1e-3,
            "w is the depth, {} not {}",
            view.z,
            clip[3]
        );
    }

    #[test]
    fn depth_runs_from_0_at_near_to_1_at_far() {
        let described =
            CameraDescription::new(&camera(), camera().position).expect("a sound camera");
        let forward = (camera().target - camera().position).normalize();
        for (depth, expected) in [(0.5, 0.0), (1000.0, 1.0)] {
            let clip = described
                .clip_from_world
                .map(|row| DVec4::from(row).dot((forward * depth).extend(1.0)));
            assert!(
                (clip[2] / clip[3] - expected).abs() < 1e-9,
                "at {depth}: got {}",
                clip[2] / clip[3]
            );
        }
    }

    #[test]
    fn its_keys_can_be_pasted_into_a_scene() {
        let described = CameraDescription::new(&camera(), DVec3::ZERO).expect("a sound camera");
        let json = serde_json::to_value(described).expect("JSON");
        assert_eq!(
            json["position"],
            serde_json::json!([636_010.0, 848_900.0, 500.0])
        );
        assert_eq!(json["size"], serde_json::json!([640, 360]));
        assert_eq!(json["fov_y_degrees"], serde_json::json!(50.0));
    }
}
