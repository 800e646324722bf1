//! What a frame cost and what it gave.

pub mod bench;
pub mod compare;
mod compare_report;
mod flip;
mod idle;
mod journal;
mod knobs;
pub mod page;
mod percentiles;
mod planes;
pub mod plots;
pub mod precision;
pub mod quality;
mod report;
mod row;
mod ssim;
pub mod sweep;
mod sweep_report;
pub mod truth;
pub mod tune;
mod tune_report;
mod tuner;
mod variant;

pub use knobs::USUAL_KEYS;
pub use percentiles::{Percentiles, median, percentile};
pub use planes::{Planes, srgb};
pub use report::{BounceReport, GBufferReport, Report, peak_memory_bytes, restart_peak_memory};
pub use row::{NUMBERS, Row};
pub use sweep_report::{NamedPlot, SweepReport};
pub use variant::Variant;
