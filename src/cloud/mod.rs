//! Point clouds: reading, writing, generating, and making surfels of them.

mod clean;
mod colour;
mod facts;
pub mod generate;
mod guard;
mod las;
mod mesh;
mod neighbours;
mod normals;
mod order;
mod ply;
mod ply_write;
mod points;
mod prepare;
mod raw;
mod read;
mod rules;
mod shuffle;
mod spacing;
mod surfels;
mod tint;

pub(crate) use guard::require_memory;

pub(crate) use clean::transform_fault;
pub use facts::{Bounds, CloudFacts, Facts};
pub use mesh::{Faces, TriangleMesh};
pub use neighbours::{NORMAL_NEIGHBOURS, SPACING_NEIGHBOURS};
pub use order::along_curve;
pub use ply_write::write_ply;
pub use points::CloudPoints;
pub use prepare::{Look, Material, PlacedCloud, Prepared, assemble, prepare};
pub use raw::{RawCloud, Repairs, UpAxis};
pub use read::{ColourBits, ReadOptions, read_cloud};
pub use rules::{MirrorRule, Select};
pub use surfels::{
    Finish, MAX_SHININESS, Place, SHININESS_LOG_RANGE, Surfel, Surfels, shininess_from_log,
};
pub use tint::ColourBy;
