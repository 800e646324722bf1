//! What a frame cost and what it gave.

pub mod bench;
pub mod compare;
mod compare_report;
mod flip;
pub mod page;
mod percentiles;
mod planes;
pub mod plots;
pub mod quality;
mod report;
mod ssim;
pub mod truth;

pub use percentiles::{Percentiles, median, percentile};
pub use planes::{Planes, srgb};
pub use report::{BounceReport, GBufferReport, Report, peak_memory_bytes, restart_peak_memory};
