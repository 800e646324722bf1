//! The camera as a user gives it, and the pinhole that stages project with.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, UVec2, Vec2, Vec3};

use crate::error::{Error, Result};

/// Largest side of a picture, pixels.
pub const MAX_SIZE: u32 = 32_768;

/// A pinhole camera in the scene's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Where the eye is.
    pub position: DVec3,
    /// What it looks at.
    pub target: DVec3,
    /// Roughly up; need not be perpendicular to the view.
    pub up: DVec3,
    /// Vertical field of view, degrees, above 0 and below 180.
    pub fov_y_degrees: f64,
    /// Nothing nearer along the axis is drawn.
    pub near: f64,
    /// Nothing farther along the axis is drawn.
    pub far: f64,
    /// Width and height, pixels.
    pub size: UVec2,
}

/// A rule that a camera breaks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Fault {
    /// The keys of `[camera]` that do not agree, the likeliest to blame first.
    pub(crate) keys: &'static [&'static str],
    /// The rule, from the user's side.
    pub(crate) problem: String,
}

/// A pinhole projection relative to the scene's origin, ready for kernels.
///
/// View space: x to the right, y up, z forward (metres along the axis, positive in front). Pixel (i, j) from the
/// top left has its centre at (i + 0.5, j + 0.5). Same layout on the GPU (`shaders/shared/pinhole.wgsl`).
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Pinhole {
    /// Relative to the scene's origin.
    pub eye: Vec3,
    /// Pixels per unit of slope.
    pub focal: f32,
    /// Unit vector, right on screen.
    pub right: Vec3,
    /// Nothing nearer along the axis is drawn.
    pub near: f32,
    /// Unit vector, up on screen.
    pub up: Vec3,
    /// Nothing farther along the axis is drawn.
    pub far: f32,
    /// Unit vector, along the axis.
    pub forward: Vec3,
    /// 1 / `focal`.
    pub inverse_focal: f32,
    /// Principal point, pixels.
    pub centre: Vec2,
    /// Width and height, pixels.
    pub size: UVec2,
}

impl Camera {
    /// Right and forward of a camera that can see: unit vectors.
    ///
    /// # Errors
    /// The first rule that the camera breaks.
    pub(crate) fn axes(&self) -> Result<(DVec3, DVec3), Fault> {
        let wrong = |keys, problem| Err(Fault { keys, problem });
        let view = self.target - self.position;
        if ![self.position, self.target, self.up]
            .iter()
            .all(|v| v.is_finite())
        {
            return wrong(
                &["position", "target", "up"],
                "camera.position, camera.target and camera.up must be finite numbers".into(),
            );
        }
        let Some(forward) = view.try_normalize() else {
            return wrong(
                &["target", "position"],
                "camera.target must differ from camera.position".into(),
            );
        };
        let Some(right) = forward
            .cross(self.up)
            .try_normalize()
            .filter(|_| forward.cross(self.up).length() > 1e-6 * self.up.length())
        else {
            return wrong(
                &["up", "target", "position"],
                "camera.up must not be zero or point along the view; set camera.up to another axis"
                    .into(),
            );
        };
        if !(self.fov_y_degrees > 0.0 && self.fov_y_degrees < 179.0) {
            return wrong(
                &["fov_y_degrees"],
                format!(
                    "camera.fov_y_degrees is {}; it must be above 0 and below 179",
                    self.fov_y_degrees
                ),
            );
        }
        if !(self.near > 0.0 && self.far > self.near && self.far.is_finite()) {
            return wrong(
                &["near", "far"],
                format!(
                    "camera.near is {} and camera.far {}; they must obey 0 < near < far",
                    self.near, self.far
                ),
            );
        }
        if self.size.min_element() == 0 || self.size.max_element() > MAX_SIZE {
            return wrong(
                &["size"],
                format!(
                    "camera.size is {}x{}; each side must be 1 to {MAX_SIZE} pixels",
                    self.size.x, self.size.y
                ),
            );
        }
        Ok((right, forward))
    }

    /// The projection of this camera, relative to `origin`.
    ///
    /// # Errors
    /// Where the camera is degenerate: target at the position, up along the view, an impossible field of view,
    /// planes or size.
    pub fn pinhole(&self, origin: DVec3) -> Result<Pinhole> {
        let (right, forward) = self.axes().map_err(|fault| Error::Setting(fault.problem))?;
        let focal = f64::from(self.size.y) / 2.0 / (self.fov_y_degrees.to_radians() / 2.0).tan();
        Ok(Pinhole {
            eye: (self.position - origin).as_vec3(),
            focal: focal as f32,
            right: right.as_vec3(),
            near: self.near as f32,
            up: right.cross(forward).as_vec3(),
            far: self.far as f32,
            forward: forward.as_vec3(),
            inverse_focal: (1.0 / focal) as f32,
            centre: self.size.as_vec2() * 0.5,
            size: self.size,
        })
    }
}

impl Pinhole {
    /// A point relative to the origin, in view space.
    pub fn view_from_world(&self, point: Vec3) -> Vec3 {
        self.view_from_world_direction(point - self.eye)
    }

    /// A direction in view space.
    pub fn view_from_world_direction(&self, d: Vec3) -> Vec3 {
        // Written out, so that both backends add in the same order.
        let dot = |a: Vec3| a.x * d.x + a.y * d.y + a.z * d.z;
        Vec3::new(dot(self.right), dot(self.up), dot(self.forward))
    }

    /// Slopes x/z, y/z of the ray through the point `pixel` (centres at + 0.5).
    pub fn slope(&self, pixel: Vec2) -> Vec2 {
        Vec2::new(
            (pixel.x - self.centre.x) * self.inverse_focal,
            (self.centre.y - pixel.y) * self.inverse_focal,
        )
    }

    /// Where a point in view space appears, pixels.
    pub fn pixel_from_view(&self, view: Vec3) -> Vec2 {
        Vec2::new(
            self.centre.x + self.focal * view.x / view.z,
            self.centre.y - self.focal * view.y / view.z,
        )
    }

    /// The point at `depth` along the axis on the ray through `pixel`, relative to the origin.
    pub fn world_from_pixel(&self, pixel: Vec2, depth: f32) -> Vec3 {
        self.eye + self.direction(pixel) * depth
    }

    /// The ray through `pixel`, scaled to 1 along the axis.
    pub fn direction(&self, pixel: Vec2) -> Vec3 {
        let s = self.slope(pixel);
        self.right * s.x + self.up * s.y + self.forward
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            position: DVec3::new(0.0, 0.0, 0.9),
            target: DVec3::new(0.0, 0.0, 0.0),
            up: DVec3::Y,
            fov_y_degrees: 60.0,
            near: 0.05,
            far: 10.0,
            size: UVec2::new(800, 600),
        }
    }

    #[test]
    fn pixel_rays_are_those_of_the_reference_scenes() {
        let p = camera().pinhole(DVec3::ZERO).expect("a sound camera");
        let d = p.direction(Vec2::new(0.5, 0.5));
        let tan = 30f32.to_radians().tan();
        let expected = Vec3::new(
            (1.0 / 800.0 - 1.0) * tan * 4.0 / 3.0,
            (1.0 - 1.0 / 600.0) * tan,
            -1.0,
        );
        assert!(
            (d - expected).length() < 1e-6,
            "got {d}, expected {expected}"
        );
    }

    #[test]
    fn a_pixel_and_its_depth_give_the_point_back() {
        let p = camera().pinhole(DVec3::ZERO).expect("a sound camera");
        let point = Vec3::new(0.3, -0.7, -2.0);
        let view = p.view_from_world(point);
        let back = p.world_from_pixel(p.pixel_from_view(view), view.z);
        assert!(
            (back - point).length() < 1e-5,
            "got {back}, expected {point}"
        );
    }

    #[test]
    fn degenerate_cameras_are_refused_with_a_sentence() {
        let broken = [
            Camera {
                target: camera().position,
                ..camera()
            },
            Camera {
                up: DVec3::Z,
                ..camera()
            },
            Camera {
                up: DVec3::ZERO,
                ..camera()
            },
            Camera {
                fov_y_degrees: 180.0,
                ..camera()
            },
            Camera {
                near: 0.0,
                ..camera()
            },
            Camera {
                far: f64::NAN,
                ..camera()
            },
            Camera {
                size: UVec2::new(0, 600),
                ..camera()
            },
            Camera {
                position: DVec3::NAN,
                ..camera()
            },
        ];
        for c in broken {
            assert!(c.pinhole(DVec3::ZERO).is_err(), "{c:?} must be refused");
        }
    }
}
