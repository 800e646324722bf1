//! Light: the spot's shadow map, and shading.

pub mod ism;
mod light;
pub mod light_close;
pub mod shade;
pub mod vpl;

pub use light::{MAX_OUTER_DEGREES, SpotLight};

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
