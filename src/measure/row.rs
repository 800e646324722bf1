//! One timed frame of a sweep.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::bench::{Cost, Quality};
use super::report::BounceReport;

/// A timed frame: a line of sweep.jsonl and of sweep.csv.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Which combination, from 0.
    pub combination: usize,
    /// Which frame of it, from 0.
    pub round: u32,
    /// The values of the keys that vary, in their order.
    pub values: Vec<String>,
    /// Settings that differ from their defaults.
    pub settings: BTreeMap<String, toml::Value>,
    /// Of the program.
    pub version: String,
    /// "cpu" or "gpu".
    pub backend: String,
    /// The graphics adapter's name, or `null`.
    pub adapter: Option<String>,
    /// Surfels drawn from.
    pub points: u64,
    /// Wall time of the traced reference of the same round, milliseconds.
    pub reference_ms: f64,
    /// Time of all passes of mirrors together, milliseconds.
    pub mirrors_ms: f64,
    /// Time of the search or of tracing alone, milliseconds.
    pub search_ms: f64,
    /// Regions of the mirrors.
    pub regions: u64,
    /// Points searched that hit, of those offered, 0 to 1.
    pub hit_rate: f64,
    /// Steps of a search, on average.
    pub mean_steps: f64,
    /// Share of the mirrors' pixels covered before holes are closed, 0 to 1.
    pub coverage_before: f64,
    /// What the frame took.
    pub cost: Cost,
    /// How well it shows what the reference does.
    pub quality: Quality,
}

/// Passes that find what mirrors show.
const SEARCHES: [&str; 6] = [
    "charts",
    "order",
    "root_find",
    "guided",
    "beam_tree",
    "ray_trace",
];

/// The first pass of mirrors; all after it are theirs.
const FIRST_OF_MIRRORS: &str = "surface";

/// What a column holds of a row.
type Value = fn(&Row) -> f64;

/// The numbers of a row, with the names of their columns.
pub const NUMBERS: &[(&str, Value)] = &[
    ("wall_ms", |r| r.cost.wall_ms),
    ("cpu_ms", |r| r.cost.cpu_ms.unwrap_or(f64::NAN)),
    ("reference_ms", |r| r.reference_ms),
    ("ratio", Row::ratio),
    ("mirrors_ms", |r| r.mirrors_ms),
    ("search_ms", |r| r.search_ms),
    ("peak_memory_bytes", |r| {
        r.cost.peak_memory_bytes.map_or(f64::NAN, |b| b as f64)
    }),
    ("points", |r| r.points as f64),
    ("mirror_pixels", |r| r.quality.mirrors.mirror_pixels as f64),
    ("regions", |r| r.regions as f64),
    ("hit_rate", |r| r.hit_rate),
    ("mean_steps", |r| r.mean_steps),
    ("coverage_before", |r| r.coverage_before),
    ("coverage", |r| r.quality.mirrors.coverage),
    ("recall", |r| r.quality.mirrors.recall),
    ("position_m_median", |r| r.quality.mirrors.position_m.median),
    ("position_m_p95", |r| r.quality.mirrors.position_m.p95),
    ("position_m_p99", |r| r.quality.mirrors.position_m.p99),
    ("position_px_median", |r| {
        r.quality.mirrors.position_px.median
    }),
    ("position_px_p95", |r| r.quality.mirrors.position_px.p95),
    ("position_px_p99", |r| r.quality.mirrors.position_px.p99),
    ("albedo_psnr", |r| r.quality.mirrors.albedo_psnr),
    ("albedo_ssim", |r| r.quality.mirrors.albedo_ssim),
    ("picture_psnr", |r| r.quality.picture.psnr),
    ("picture_ssim", |r| r.quality.picture.ssim),
    ("picture_flip", |r| r.quality.picture.flip),
];

impl Row {
    /// The row of a frame; which one it is, is filled in by whoever knows.
    pub(super) fn new(
        cost: Cost,
        reference_ms: f64,
        quality: Quality,
        search: Option<&BounceReport>,
    ) -> Self {
        let of_mirrors = cost
            .passes
            .iter()
            .skip_while(|p| p.name != FIRST_OF_MIRRORS);
        let searches = cost
            .passes
            .iter()
            .filter(|p| SEARCHES.contains(&p.name.as_str()));
        Self {
            combination: 0,
            round: 0,
            values: Vec::new(),
            settings: BTreeMap::new(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            backend: String::new(),
            adapter: None,
            points: 0,
            reference_ms,
            mirrors_ms: of_mirrors.map(|p| p.wall_ms).sum(),
            search_ms: searches.map(|p| p.wall_ms).sum(),
            regions: search.map_or(0, |s| s.regions),
            hit_rate: search.map_or(0.0, |s| s.hit_rate),
            mean_steps: search.map_or(0.0, |s| s.mean_steps),
            coverage_before: search.map_or(0.0, |s| s.coverage),
            cost,
            quality,
        }
    }

    /// Wall time of the frame, x that of the reference of the same round.
    pub fn ratio(&self) -> f64 {
        self.cost.wall_ms / self.reference_ms.max(1e-9)
    }

    /// The line of sweep.csv, with its line break.
    pub(super) fn csv(&self) -> String {
        let mut fields = vec![self.combination.to_string(), self.round.to_string()];
        fields.extend(self.values.iter().map(|v| quoted(v)));
        for (_, value) in NUMBERS {
            let value = value(self);
            fields.push(if value.is_finite() {
                value.to_string()
            } else {
                String::new()
            });
        }
        let passes = self
            .cost
            .passes
            .iter()
            .map(|p| format!("{}={:.3}", p.name, p.wall_ms));
        fields.push(quoted(&passes.collect::<Vec<_>>().join(";")));
        let settings = self.settings.iter().map(|(k, v)| format!("{k}={v}"));
        fields.push(quoted(&settings.collect::<Vec<_>>().join(";")));
        fields.push(quoted(&self.backend));
        fields.push(quoted(self.adapter.as_deref().unwrap_or_default()));
        fields.push(quoted(&self.version));
        fields.join(",") + "\n"
    }
}

/// The first line of sweep.csv, for keys that vary.
pub(super) fn csv_header(keys: &[String]) -> String {
    let mut fields = vec!["combination".to_owned(), "round".to_owned()];
    fields.extend(keys.iter().map(|k| quoted(k)));
    fields.extend(NUMBERS.iter().map(|(name, _)| (*name).to_owned()));
    fields.extend(["passes_ms", "settings", "backend", "adapter", "version"].map(str::to_owned));
    fields.join(",") + "\n"
}

/// A field of a CSV file [RFC 4180].
fn quoted(field: &str) -> String {
    if field.contains(['"', ',', '\n', '\r']) {
        format!(
            "\"{}\"",
            field.replace('"', "\"\"").replace(['\n', '\r'], " ")
        )
    } else {
        field.to_owned()
    }
}
