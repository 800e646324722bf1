//! The table of shaders.

use super::accumulate::HitParams;
use super::blend::BlendParams;
use super::curvature::CurvatureParams;
use super::edl::EdlParams;
use super::fill::{CoverageParams, RingParams};
use super::gather::{FilterParams, GatherParams};
use super::guided::{BeamNode, FieldParams, GuidedParams};
use super::ism::IsmParams;
use super::kernel::{PIXEL_GROUP, POINT_GROUP};
use super::layout::{GpuStruct, Layout};
use super::mirror_pixels::MirrorPixelsParams;
use super::photons::{AddParams, PhotonParams};
use super::pull_push::{Cell, PullParams, PushParams};
use super::receivers::{MirrorReceiverParams, ReceiverParams, SettleParams};
use super::root_find::{DistributeParams, Region, RootFindParams};
use super::shade::{LightParams, ShadeMirrorParams, ShadeParams};
use super::smooth::SmoothParams;
use super::splat::{ClearParams, LightCloseParams, SplatParams};
use super::surface::{EyeParams, ReflectedRaysParams, SurfaceParams};
use crate::camera::Pinhole;
use crate::cloud::SHININESS_LOG_RANGE;
use crate::gbuffer::disc::{BOUNDS_SLACK, EDGE_ON_COSINE_SQUARED, MAX_TOLERANCE_SLOPE, RIM};
use crate::gbuffer::fill::{AGREE_SPACINGS, MIN_NEIGHBOURS};
use crate::gbuffer::leak::{LEAK_NEIGHBOURS, LEAK_REACH, LEAK_SPACINGS};
use crate::gbuffer::smooth::{DEPTH_SPACINGS, NORMAL_DIFFERENCE};
use crate::gi::add_indirect::MIN_LUMINANCE;
use crate::gi::gather::RESIDUAL_SOFTENING;
use crate::gi::indirect_filter::{ALIKE, NORMAL_COSINE, PLANE_SLOPE, PLANE_SPACINGS};
use crate::gi::ism::{
    BIAS, BIAS_TEXELS, DISTANCE_BASE, DISTANCE_MAX, DISTANCE_SHIFT, OWN_COSINE, OWN_HEIGHT,
    OWN_REACH, REACH, SURFEL_BITS,
};
use crate::gi::photons::Photon;
use crate::gi::settle;
use crate::gi::shade::RECEIVER_COSINE;
use crate::gi::vpl::Vpl;
use crate::reflect::Hit;
use crate::reflect::sscr::accumulate::{DEPTH_RANGE, LARGEST_REACH};
use crate::reflect::sscr::charts::MAP_SIDE;
use crate::reflect::sscr::curvature::{
    CONCAVE, CONVEX, MIN_STEP_SINE, PLANAR, X_STEP, Y_SHIFT, Y_STEP,
};
use crate::reflect::sscr::field::OUTLINE;
use crate::reflect::sscr::guided::{END_REACH, SAME_ROOT, STAY};
use crate::reflect::sscr::heat::{MAX_RESIDUAL, RESIDUAL_SCALE};
use crate::reflect::sscr::mirror_error::SMALLEST_COSINE;
use crate::reflect::sscr::newton::{
    DAMPING, FOLD, HALVINGS, LAST_STEP, LONGEST_STEP, MAX_STEPS, RESIDUAL, RESIDUAL_FLOOR,
};
use crate::reflect::sscr::root_find::SMALLEST_STEP;

/// One kernel's source. Its name is the file's, the label in a profile and the row in the report.
#[derive(Debug, Clone, Copy)]
pub struct Shader {
    /// The file `shaders/<name>.wgsl`.
    pub name: &'static str,
    /// Its text, before linking.
    pub source: &'static str,
    /// Values of its `override`s, from the twin's constants.
    pub constants: &'static [(&'static str, f64)],
}

macro_rules! shader {
    ($(#[doc = $doc:literal])* $const:ident = $name:literal, $constants:expr) => {
        $(#[doc = $doc])*
        pub(super) const $const: Shader = Shader {
            name: $name,
            source: include_str!(concat!("../../../shaders/", $name, ".wgsl")),
            constants: $constants,
        };
    };
}

macro_rules! shared {
    ($($name:literal),*) => {
        &[$(($name, include_str!(concat!("../../../shaders/shared/", $name, ".wgsl")))),*]
    };
}

const POINT: (&str, f64) = ("POINT_GROUP", POINT_GROUP as f64);
const PIXEL: (&str, f64) = ("PIXEL_GROUP", PIXEL_GROUP as f64);
const AGREE: (&str, f64) = ("AGREE_SPACINGS", AGREE_SPACINGS as f64);

const COSINE: (&str, f64) = ("SMALLEST_COSINE", SMALLEST_COSINE as f64);

const RECEIVER: (&str, f64) = ("RECEIVER_COSINE", RECEIVER_COSINE as f64);
const SHININESS: (&str, f64) = ("SHININESS_LOG_RANGE", SHININESS_LOG_RANGE as f64);
const SURFEL_KEY: (&str, f64) = ("SURFEL_BITS", SURFEL_BITS as f64);

/// Constants of the distances in `shared/ism.wgsl`.
const DISTANCE_KEY: [(&str, f64); 3] = [
    ("DISTANCE_SHIFT", DISTANCE_SHIFT as f64),
    ("DISTANCE_BASE", DISTANCE_BASE as f64),
    ("DISTANCE_MAX", DISTANCE_MAX as f64),
];

/// Constants of `shared/disc.wgsl`, and the workgroup.
const DISC: &[(&str, f64)] = &[
    POINT,
    ("EDGE_ON_COSINE_SQUARED", EDGE_ON_COSINE_SQUARED as f64),
    ("MAX_TOLERANCE_SLOPE", MAX_TOLERANCE_SLOPE as f64),
    ("RIM", RIM as f64),
    ("BOUNDS_SLACK", BOUNDS_SLACK as f64),
];

/// Constants of `shared/hit_splat.wgsl`, and the workgroup.
const HIT: &[(&str, f64)] = &[
    POINT,
    ("DEPTH_RANGE", DEPTH_RANGE as f64),
    ("LARGEST_REACH", LARGEST_REACH as f64),
    ("EDGE_ON_COSINE_SQUARED", EDGE_ON_COSINE_SQUARED as f64),
    ("MAX_TOLERANCE_SLOPE", MAX_TOLERANCE_SLOPE as f64),
];

shader! {
    /// Sets depth keys to "nothing seen".
    CLEAR = "clear", &[PIXEL]
}
shader! {
    /// The nearest fragment of every pixel, and how many there are.
    DEPTH = "depth", DISC
}
shader! {
    /// The nearest fragment of every texel of a light's map.
    LIGHT_DEPTH = "light_depth", DISC
}
shader! {
    /// Closes leaks of a light's map.
    LIGHT_CLOSE = "light_close", &[PIXEL]
}
shader! {
    /// Sums the attributes of the visible fragments.
    VISIBILITY = "visibility", DISC
}
shader! {
    /// Turns sums into the one surfel that a pixel shows.
    AVERAGE = "average", &[PIXEL, SHININESS]
}

shader! {
    /// Closes one ring of small holes.
    FILL = "fill", &[PIXEL, AGREE, ("MIN_NEIGHBOURS", MIN_NEIGHBOURS as f64)]
}
shader! {
    /// Marks gaps through which the background shows.
    LEAK = "leak", &[PIXEL, AGREE, ("LEAK_NEIGHBOURS", LEAK_NEIGHBOURS as f64), ("LEAK_REACH", LEAK_REACH as f64), ("LEAK_SPACINGS", LEAK_SPACINGS as f64)]
}
shader! {
    /// Counts the pixels that show something.
    COVERAGE = "coverage", &[PIXEL]
}
shader! {
    /// Smooths the normals and depths of mirrors.
    SMOOTH = "smooth", &[PIXEL, ("DEPTH_SPACINGS", DEPTH_SPACINGS as f64), ("NORMAL_DIFFERENCE", NORMAL_DIFFERENCE as f64)]
}
shader! {
    /// Adds the light of one spot.
    SHADE = "shade", &[PIXEL, RECEIVER]
}
shader! {
    /// What the camera sees, as indirect light takes it.
    RECEIVERS = "receivers", &[PIXEL]
}
shader! {
    /// What the mirrors show, as indirect light takes it.
    MIRROR_RECEIVERS = "mirror_receivers", &[PIXEL]
}
shader! {
    /// Puts what closed holes of mirrors show to where the nearest found pixel lies.
    SETTLE = "settle", &[
        PIXEL,
        ("REACH", settle::REACH as f64),
        ("NORMAL_COSINE", settle::NORMAL_COSINE as f64),
    ]
}
shader! {
    /// The shadow maps of virtual point lights.
    ISM = "ism", &[
        POINT,
        SURFEL_KEY,
        DISTANCE_KEY[0],
        DISTANCE_KEY[1],
        DISTANCE_KEY[2],
        ("EDGE_ON_COSINE_SQUARED", EDGE_ON_COSINE_SQUARED as f64),
        ("REACH", REACH as f64),
        ("OWN_COSINE", OWN_COSINE as f64),
        ("OWN_HEIGHT", OWN_HEIGHT as f64),
        ("OWN_REACH", OWN_REACH as f64),
    ]
}
shader! {
    /// What virtual point lights send to every pixel.
    GATHER = "gather", &[
        PIXEL,
        SURFEL_KEY,
        DISTANCE_KEY[0],
        DISTANCE_KEY[1],
        DISTANCE_KEY[2],
        ("BIAS", BIAS as f64),
        ("BIAS_TEXELS", BIAS_TEXELS as f64),
        ("RESIDUAL_SOFTENING", RESIDUAL_SOFTENING as f64),
    ]
}
shader! {
    /// Merges interleaved pixels in one direction.
    INDIRECT_FILTER = "indirect_filter", &[
        PIXEL,
        ("PLANE_SLOPE", PLANE_SLOPE as f64),
        ("PLANE_SPACINGS", PLANE_SPACINGS as f64),
        ("NORMAL_COSINE", NORMAL_COSINE as f64),
        ("ALIKE", ALIKE as f64),
    ]
}
shader! {
    /// Light that came by way of mirrors.
    PHOTONS = "photons", &[PIXEL]
}
shader! {
    /// Adds the radiance of the indirect light.
    ADD_INDIRECT = "add_indirect", &[PIXEL, ("MIN_LUMINANCE", MIN_LUMINANCE as f64)]
}
shader! {
    /// Eye-dome lighting.
    EDL = "edl", &[PIXEL]
}

shader! {
    /// The mirrors that the camera sees from the front.
    SURFACE = "surface", &[PIXEL]
}
shader! {
    /// The ray of every mirror pixel.
    REFLECTED_RAYS = "reflected_rays", &[PIXEL]
}
shader! {
    /// How the mirrors bend.
    CURVATURE = "curvature", &[
        PIXEL,
        ("CONCAVE", CONCAVE as f64),
        ("CONVEX", CONVEX as f64),
        ("PLANAR", PLANAR as f64),
        ("Y_SHIFT", Y_SHIFT as f64),
        ("X_STEP", X_STEP as f64),
        ("Y_STEP", Y_STEP as f64),
        ("MIN_STEP_SINE", MIN_STEP_SINE as f64),
    ]
}
shader! {
    /// The mirrors, laid out for searches.
    MIRROR_PIXELS = "mirror_pixels", &[PIXEL, COSINE]
}
shader! {
    /// Searches the points in the mirrors.
    ROOT_FIND = "root_find", &[POINT, COSINE, ("SMALLEST_STEP", SMALLEST_STEP as f64)]
}

shader! {
    /// Searches the points on the charts of the mirrors.
    GUIDED = "guided", &[
        POINT,
        ("OUTLINE", OUTLINE as f64),
        ("MAX_STEPS", MAX_STEPS as f64),
        ("LONGEST_STEP", LONGEST_STEP as f64),
        ("HALVINGS", HALVINGS as f64),
        ("LAST_STEP", LAST_STEP as f64),
        ("RESIDUAL", RESIDUAL as f64),
        ("RESIDUAL_FLOOR", RESIDUAL_FLOOR as f64),
        ("FOLD", FOLD as f64),
        ("DAMPING", DAMPING as f64),
        ("SAME_ROOT", SAME_ROOT as f64),
        ("STAY", STAY as f64),
        ("END_REACH", END_REACH as f64),
        ("MAP_SIDE", MAP_SIDE as f64),
        ("LARGEST_REACH", LARGEST_REACH as f64),
    ]
}

shader! {
    /// Where the searches end.
    SEARCH_HEAT = "search_heat", &[
        POINT,
        COSINE,
        ("SMALLEST_STEP", SMALLEST_STEP as f64),
        ("RESIDUAL_SCALE", RESIDUAL_SCALE as f64),
        ("MAX_RESIDUAL", MAX_RESIDUAL as f64),
    ]
}
shader! {
    /// The nearest hit of every mirror pixel, and how many there are.
    HIT_DEPTH = "hit_depth", HIT
}
shader! {
    /// Sums the attributes of the visible hits.
    HIT_VISIBILITY = "hit_visibility", HIT
}
shader! {
    /// Turns sums into the one surfel that a mirror pixel shows.
    HIT_AVERAGE = "hit_average", &[PIXEL, SHININESS]
}
shader! {
    /// Counts the mirrors' pixels that show something.
    MIRROR_COVERAGE = "mirror_coverage", &[PIXEL]
}
shader! {
    /// The finest level of the pyramid that fills holes.
    PULL_FINEST = "pull_finest", &[PIXEL]
}
shader! {
    /// A coarser level of the pyramid that fills holes.
    PULL = "pull", &[PIXEL]
}
shader! {
    /// Fills holes from one level of the pyramid.
    PUSH = "push", &[PIXEL]
}
shader! {
    /// Adds the light of one spot to what mirrors show.
    SHADE_MIRROR = "shade_mirror", &[PIXEL, RECEIVER]
}
shader! {
    /// What the mirrors show over the points' own part.
    BLEND = "blend", &[PIXEL]
}

/// What shaders import: name and text.
pub const SHARED: &[(&str, &str)] = shared![
    "average",
    "coverage",
    "depth_key",
    "disc",
    "distribute",
    "dot3",
    "eye",
    "field",
    "hit",
    "hit_params",
    "hit_splat",
    "hits",
    "ism",
    "light",
    "mirror_space",
    "neighbours",
    "newton",
    "pinhole",
    "plane_depth",
    "pull",
    "receiver",
    "ring",
    "root_find",
    "splat",
    "sums",
    "surfel",
    "unit",
    "weight"
];

/// Every kernel there is.
pub const SHADERS: &[Shader] = &[
    CLEAR,
    DEPTH,
    LIGHT_DEPTH,
    LIGHT_CLOSE,
    VISIBILITY,
    AVERAGE,
    LEAK,
    FILL,
    COVERAGE,
    SMOOTH,
    SHADE,
    RECEIVERS,
    MIRROR_RECEIVERS,
    SETTLE,
    ISM,
    GATHER,
    INDIRECT_FILTER,
    PHOTONS,
    ADD_INDIRECT,
    EDL,
    SURFACE,
    REFLECTED_RAYS,
    CURVATURE,
    MIRROR_PIXELS,
    ROOT_FIND,
    GUIDED,
    SEARCH_HEAT,
    HIT_DEPTH,
    HIT_VISIBILITY,
    HIT_AVERAGE,
    MIRROR_COVERAGE,
    PULL_FINEST,
    PULL,
    PUSH,
    SHADE_MIRROR,
    BLEND,
];

/// Every struct that a shader and Rust both see.
pub const LAYOUTS: &[Layout] = &[
    Pinhole::LAYOUT,
    SplatParams::LAYOUT,
    ClearParams::LAYOUT,
    LightCloseParams::LAYOUT,
    RingParams::LAYOUT,
    CoverageParams::LAYOUT,
    SmoothParams::LAYOUT,
    ShadeParams::LAYOUT,
    ReceiverParams::LAYOUT,
    MirrorReceiverParams::LAYOUT,
    SettleParams::LAYOUT,
    IsmParams::LAYOUT,
    GatherParams::LAYOUT,
    FilterParams::LAYOUT,
    PhotonParams::LAYOUT,
    AddParams::LAYOUT,
    Vpl::LAYOUT,
    Photon::LAYOUT,
    EdlParams::LAYOUT,
    SurfaceParams::LAYOUT,
    EyeParams::LAYOUT,
    ReflectedRaysParams::LAYOUT,
    CurvatureParams::LAYOUT,
    MirrorPixelsParams::LAYOUT,
    Region::LAYOUT,
    DistributeParams::LAYOUT,
    RootFindParams::LAYOUT,
    FieldParams::LAYOUT,
    GuidedParams::LAYOUT,
    BeamNode::LAYOUT,
    Hit::LAYOUT,
    HitParams::LAYOUT,
    Cell::LAYOUT,
    PullParams::LAYOUT,
    PushParams::LAYOUT,
    LightParams::LAYOUT,
    ShadeMirrorParams::LAYOUT,
    BlendParams::LAYOUT,
];
