//! What a frame cost and what it gave.

mod report;

pub use report::{BounceReport, GBufferReport, Report, peak_memory_bytes};
