//! Light: the spot's shadow map, and shading.

use glam::Vec3;

use crate::settings_group;

settings_group! {
    /// How the light reaches the points.
    pub struct GiSettings in "gi" {
        /// Side of a light's depth map. Shadows sharpen with it, and its splatting cost grows with its square.
        /// 1024 is the knee on the reference scenes (512 loses 2 dB, 2048 gains 0.3).
        light_map_size: u32 = 1024, 16..=8192, "pixels";
        /// Depth by which a point may lie behind the light's nearest and still be lit, in multiples of the local spacing.
        /// The receiver's own plane is compared, so the result hardly depends on it.
        light_bias: f32 = 2.0, 0.0..=100.0, "x spacing";
    }
}

/// A spot light, relative to the scene's origin: full inside the inner half angle, falling linearly in angle to 0 at
/// the outer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotLight {
    /// Relative to the scene's origin.
    pub position: Vec3,
    /// Unit vector along the axis.
    pub axis: Vec3,
    /// W/sr per channel.
    pub intensity: Vec3,
    /// Half angle, radians.
    pub inner_angle: f32,
    /// Half angle, radians.
    pub outer_angle: f32,
}
