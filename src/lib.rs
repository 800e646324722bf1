//! catoptric renders point clouds with global illumination and true reflections on curved mirrors, and measures
//! what its speed costs in accuracy.

pub mod backend;
pub mod camera;
pub mod cloud;
pub mod error;
pub mod frame;
pub mod gbuffer;
pub mod gi;
pub mod grid;
pub mod image;
pub mod job;
pub mod measure;
mod memory;
pub mod output;
pub mod plan;
pub mod reflect;
pub mod renderer;
pub mod scene;
pub mod settings;
pub mod text;
pub mod timing;

pub use error::{Error, Result};
pub use job::{Job, Progress};
