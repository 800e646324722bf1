//! Point clouds: reading, writing, generating, and making surfels of them.

mod raw;
mod surfels;

pub use raw::{RawCloud, Repairs, UpAxis};
pub use surfels::{
    Finish, MAX_SHININESS, Place, SHININESS_LOG_RANGE, Surfel, Surfels, shininess_from_log,
};
