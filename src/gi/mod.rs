//! Light: shadow maps, virtual point lights with imperfect shadow maps, and shading.

pub mod add_indirect;
pub mod background;
mod bounce;
pub mod environment;
pub mod gather;
mod indirect;
pub mod indirect_filter;
pub mod ism;
mod light;
pub mod light_close;
mod mirror_light;
pub mod photons;
pub mod receivers;
pub mod settle;
pub mod shade;
pub mod sky_map;
pub mod virtual_lights;
pub mod vpl;

pub use indirect::{Illuminator, Indirect, IndirectSources, vpl_pinhole};
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
        /// Virtual point lights of the first bounce, from which indirect light comes; later bounces have fewer, each with the
        /// same flux. An environment is as many. 0 leaves the light of lamps alone. Cost grows with it. 512 is the knee on the
        /// sphere scene: 256 err by a seventh more, 1024 by a sixteenth less at half as much time again.
        vpl_count: u32 = 512, 0..=65536, "lights";
        /// Diffuse bounces of indirect light. Each holds about half of the one before and costs about half: 3 leave out 12 % of
        /// the indirect light of the sphere scene, 5 leave out 7 %, 8 leave out 5 %. 0 leaves direct light, of lamps and environment.
        bounces: u32 = 5, 0..=16, "bounces";
        /// Pixels of a block, n x n, that share the lights: each takes another n^2-th part, and a filter merges them
        /// [Keller and Heidrich 2001]. 1 lets every pixel gather every light.
        interleave: u32 = 4, 1..=8, "pixels";
        /// Width of the filter that merges interleaved pixels, in multiples of `gi.interleave`; 0 leaves them unmerged.
        filter: u32 = 1, 0..=4, "x interleave";
        /// Side of a virtual light's shadow map. 64 is the knee on the sphere scene: 32 errs by a seventh more, 128 by as much at
        /// twice the cost.
        ism_size: u32 = 64, 16..=512, "pixels";
        /// Points in a virtual light's shadow map: a slice of the shuffled cloud. 4000 is the knee on the sphere scene: 1000 err
        /// by a twentieth more, 12,500 by as much.
        ism_points: u32 = 4000, 1..=16384, "points";
        /// Whether indirect light goes on from mirrors to other surfaces: diffuse, mirror, diffuse.
        mirror_light: bool = true;
        /// Whether the lights' own light goes on from mirrors: caustics, blurred.
        caustics: bool = false;
        /// What colours are multiplied with to be reflectances. Colours of scans are what a camera saw under the light of the
        /// day, and may be too bright for surfaces.
        albedo_scale: f32 = 1.0, 0.0..=1.0, "";
    }
}
