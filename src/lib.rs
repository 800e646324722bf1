//! catoptric renders point clouds with global illumination and true reflections on curved mirrors, and measures
//! what its speed costs in accuracy.
//!
//! From a scene to a picture in main memory:
//!
//! ```
//! use catoptric::job::Job;
//! use catoptric::renderer::{BackendChoice, Renderer};
//! use catoptric::scene::Scene;
//!
//! # fn main() -> catoptric::Result<()> {
//! let text = r#"
//!     format = 1
//!     [[cloud]]
//!     generate = "sphere"
//!     points = 20000
//!     [camera]
//!     position = [0, 0, 0.9]
//!     target = [0, 0, -1]
//!     size = [80, 60]
//! "#;
//! let scene = Scene::parse(text, "example.toml".as_ref(), &[])?;
//! let job = Job::default();
//! let loaded = scene.load(&job)?;
//! let plan = loaded.plan(&scene.settings);
//! let mut renderer = Renderer::new(&BackendChoice::Cpu, &loaded.surfels)?;
//! let products = renderer.render(&loaded.view()?, &plan, &scene.settings, &job)?;
//! assert!(products.coverage.filled > 4700, "a closed room fills the picture of 4800 pixels");
//! assert!(products.mirror.is_some(), "the camera sees a mirror");
//! # Ok(())
//! # }
//! ```

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
mod parts;
pub mod plan;
pub mod reflect;
pub mod renderer;
pub mod scene;
pub mod settings;
pub mod text;
pub mod timing;

pub use error::{Error, Result};
pub use job::{Job, Progress};
