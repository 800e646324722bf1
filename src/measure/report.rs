//! The report of a run, as JSON. `docs/OUTPUTS.md` describes it for its readers.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Serialize;

use crate::cloud::Repairs;
use crate::gbuffer::Coverage;
use crate::plan::Plan;
use crate::reflect::MirrorCoverage;
use crate::reflect::sscr::root_find::SearchCounts;
use crate::timing::PassTime;

/// What a run did, what it took, and what came out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Of this report: 1.
    pub format: u32,
    /// Of the program.
    pub version: &'static str,
    /// "cpu" or "gpu".
    pub backend: String,
    /// The graphics adapter's name, or `null` on the CPU.
    pub adapter: Option<String>,
    /// Surfels drawn from.
    pub points: u64,
    /// Points dropped or repaired, in reading and since.
    pub repairs: Repairs,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// What positions in buffers are relative to, in the scene's frame.
    pub origin: DVec3,
    /// Settings that differ from their defaults, by dotted name.
    pub settings: BTreeMap<String, toml::Value>,
    /// What ran, what did not, and why.
    pub plan: Plan,
    /// The time of each pass, in the order in which they first ran.
    pub passes: Vec<PassTime>,
    /// From the first byte read to the last pass, milliseconds.
    pub wall_ms: f64,
    /// Most memory that the process has held at once, bytes, or `null` where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
    /// How much of the picture shows something.
    pub gbuffer: GBufferReport,
    /// The search for reflections, bounce by bounce; empty where no mirror was searched.
    pub sscr: Vec<BounceReport>,
}

/// How much of the picture shows something, as shares of its pixels, 0 to 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct GBufferReport {
    /// Covered by splats.
    pub coverage: f64,
    /// Covered after holes were filled.
    pub coverage_filled: f64,
}

impl From<Coverage> for GBufferReport {
    fn from(counted: Coverage) -> Self {
        Self {
            coverage: share(counted.splatted, counted.pixels),
            coverage_filled: share(counted.filled, counted.pixels),
        }
    }
}

/// What the search for reflections gave in one bounce.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BounceReport {
    /// Counted from 1.
    pub bounce: u32,
    /// How it was found what the mirrors show: "guided", "interleaved" or "ray_trace".
    pub method: &'static str,
    /// Why so.
    pub reason: String,
    /// Mirror regions of one curvature.
    pub regions: u64,
    /// Pairs of point and region that were searched.
    pub points_offered: u64,
    /// Those of them that hit.
    pub points_hit: u64,
    /// `points_hit` over `points_offered`, before culling, 0 to 1.
    pub hit_rate: f64,
    /// Hits kept.
    pub hits: u64,
    /// Steps of the search, on average over the points offered.
    pub mean_steps: f64,
    /// Share of the mirror's pixels that hits cover, 0 to 1.
    pub coverage: f64,
    /// Share of the mirror's pixels that are covered after closing, 0 to 1.
    pub coverage_closed: f64,
    /// Share of the mirror's pixels that show a mirror, which is black there, 0 to 1.
    pub mirrors_seen: f64,
}

impl BounceReport {
    /// The report of a bounce: what the search counted, and what the mirrors show before and after closing.
    pub fn new(
        bounce: u32,
        regions: u64,
        counts: SearchCounts,
        searched: MirrorCoverage,
        closed: MirrorCoverage,
    ) -> Self {
        Self {
            bounce,
            method: "",
            reason: String::new(),
            regions,
            points_offered: counts.offered,
            points_hit: counts.hit,
            hit_rate: share(counts.hit, counts.offered),
            hits: counts.hits,
            mean_steps: share(counts.steps, counts.offered),
            coverage: share(searched.covered, searched.pixels),
            coverage_closed: share(closed.covered, closed.pixels),
            mirrors_seen: share(closed.mirrors, closed.pixels),
        }
    }
}

/// `part` of `whole`, 0 to 1; of nothing it is 0.
fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 {
        0.0
    } else {
        part as f64 / whole as f64
    }
}

/// Most memory that this process has held at once, bytes; `None` where the system does not tell (all but Linux).
pub fn peak_memory_bytes() -> Option<u64> {
    peak_memory_of(&std::fs::read_to_string("/proc/self/status").ok()?)
}

/// Lets [`peak_memory_bytes`] count from now on; whether the system could (Linux alone does).
pub fn restart_peak_memory() -> bool {
    std::fs::write("/proc/self/clear_refs", "5").is_ok()
}

/// The peak of resident memory, bytes, in the text of /proc/PID/status, which gives it in KiB.
fn peak_memory_of(status: &str) -> Option<u64> {
    let value = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u64 = value.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kib.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::plan::{Row, Stage, State};
    use crate::settings::Settings;

    fn report() -> Report {
        let mut settings = Settings::default();
        settings.splat.size = 1.7;
        settings.image.tone_map = crate::image::ToneMap::Aces;
        Report {
            format: 1,
            version: "0.1.0",
            backend: "cpu".to_owned(),
            adapter: None,
            points: 1_600_000,
            repairs: Repairs {
                not_finite: 3,
                ..Repairs::default()
            },
            size: [800, 600],
            origin: DVec3::new(636_000.0, 0.0, 0.5),
            settings: settings.changed().into_iter().collect(),
            plan: Plan {
                rows: vec![
                    Row {
                        stage: Stage::Smooth,
                        state: State::IfMirrorSeen("10 mirror points".to_owned()),
                    },
                    Row {
                        stage: Stage::Edl,
                        state: State::Skip("the scene has a light".to_owned()),
                    },
                ],
            },
            passes: vec![
                PassTime {
                    name: "depth".to_owned(),
                    wall_ms: 1.5,
                    gpu_ms: None,
                    cpu_ms: None,
                },
                PassTime {
                    name: "visibility".to_owned(),
                    wall_ms: 2.5,
                    gpu_ms: Some(2.0),
                    cpu_ms: Some(3.5),
                },
            ],
            wall_ms: 12.25,
            peak_memory_bytes: None,
            gbuffer: Coverage {
                pixels: 1000,
                splatted: 750,
                filled: 1000,
                mirror: 10,
            }
            .into(),
            sscr: Vec::new(),
        }
    }

    #[test]
    fn the_report_is_as_readers_know_it() {
        let expected = json!({
            "format": 1,
            "version": "0.1.0",
            "backend": "cpu",
            "adapter": null,
            "points": 1_600_000,
            "repairs": { "not_finite": 3, "withheld": 0, "normals": 0, "radii": 0, "values": 0 },
            "size": [800, 600],
            "origin": [636_000.0, 0.0, 0.5],
            "settings": { "splat.size": 1.7, "image.tone_map": "aces" },
            "plan": [
                { "stage": "smooth", "state": "if_mirror_seen", "reason": "10 mirror points" },
                { "stage": "edl", "state": "skip", "reason": "the scene has a light" },
            ],
            "passes": [{ "name": "depth", "wall_ms": 1.5 }, { "name": "visibility", "wall_ms": 2.5, "gpu_ms": 2.0, "cpu_ms": 3.5 }],
            "wall_ms": 12.25,
            "peak_memory_bytes": null,
            "gbuffer": { "coverage": 0.75, "coverage_filled": 1.0 },
            "sscr": [],
        });
        assert_eq!(serde_json::to_value(report()).expect("JSON"), expected);
    }

    #[test]
    fn every_key_is_documented() {
        let documentation = include_str!("../../docs/OUTPUTS.md");
        let report = serde_json::to_value(report()).expect("JSON");
        for (key, _) in report.as_object().expect("an object") {
            assert!(
                documentation.contains(&format!("| `{key}` |")),
                "docs/OUTPUTS.md does not name {key}"
            );
        }
    }

    #[test]
    fn nothing_is_covered_of_nothing() {
        assert_eq!(
            GBufferReport::from(Coverage::default()),
            GBufferReport::default()
        );
    }

    #[test]
    fn peak_memory_is_read_from_the_systems_table() {
        let status =
            "Name:\tcatoptric\nVmPeak:\t  999999 kB\nVmHWM:\t    2048 kB\nVmRSS:\t    1024 kB\n";
        assert_eq!(peak_memory_of(status), Some(2 << 20));
        for broken in [
            "",
            "VmHWM:",
            "VmHWM: 1 MB",
            "VmHWM: x kB",
            "VmHWM: 99999999999999999999 kB",
        ] {
            assert_eq!(peak_memory_of(broken), None, "{broken:?}");
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_peak_grows_with_what_is_held() {
        let before = peak_memory_bytes().expect("Linux tells");
        let held = vec![1u8; 256 << 20];
        let after = peak_memory_bytes().expect("Linux tells");
        assert!(
            std::hint::black_box(&held).len() == 256 << 20,
            "the memory is held until here"
        );
        assert!(
            after >= before.max(256 << 20),
            "got {after} bytes after {before}"
        );
    }
}
