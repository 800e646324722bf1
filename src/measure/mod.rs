//! What a frame cost and what it gave.

mod flip;
mod percentiles;
mod planes;
pub mod quality;
mod report;
mod ssim;
pub mod truth;

pub use percentiles::{Percentiles, median, percentile};
pub use planes::{Planes, srgb};
pub use report::{BounceReport, GBufferReport, Report, peak_memory_bytes};
