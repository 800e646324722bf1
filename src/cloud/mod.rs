//! Point clouds: reading, writing, generating, and making surfels of them.

pub mod generate;
mod mesh;
mod raw;
mod surfels;

pub use mesh::{Faces, TriangleMesh};
pub use raw::{RawCloud, Repairs, UpAxis};
pub use surfels::{
    Finish, MAX_SHININESS, Place, SHININESS_LOG_RANGE, Surfel, Surfels, shininess_from_log,
};
