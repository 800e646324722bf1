//! Time per pass. The name of a row is the pass's name everywhere: shader, twin, profile, report.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

/// The time that one pass took.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PassTime {
    /// The pass.
    pub name: String,
    /// Wall time, milliseconds.
    pub wall_ms: f64,
    /// Time on the device, milliseconds, where it can be measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gpu_ms: Option<f64>,
    /// Time of all processor cores together, milliseconds, where the system tells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpu_ms: Option<f64>,
}

/// The times of the passes of a frame, in the order in which they first ran.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Timings {
    /// A row per pass and use: "depth", "light_depth".
    pub passes: Vec<PassTime>,
}

impl Timings {
    /// Adds `wall` to the row `name`.
    pub fn add(&mut self, name: &str, wall: Duration) {
        let ms = wall.as_secs_f64() * 1e3;
        match self.passes.iter_mut().find(|p| p.name == name) {
            Some(pass) => pass.wall_ms += ms,
            None => self.passes.push(PassTime {
                name: name.to_owned(),
                wall_ms: ms,
                gpu_ms: None,
                cpu_ms: None,
            }),
        }
    }

    /// Adds `ms` on the device to the row `name`, which [`Timings::add`] has made.
    pub fn add_gpu(&mut self, name: &str, ms: f64) {
        if let Some(pass) = self.passes.iter_mut().find(|p| p.name == name) {
            *pass.gpu_ms.get_or_insert(0.0) += ms;
        }
    }

    /// Runs `work` and adds its time, wall and processor, to the row `name`.
    pub fn time<R>(&mut self, name: &str, work: impl FnOnce() -> R) -> R {
        let (start, cpu) = (Instant::now(), process_ms());
        let result = work();
        self.add(name, start.elapsed());
        let spent = process_ms().zip(cpu).map(|(now, then)| now - then);
        if let (Some(spent), Some(pass)) = (spent, self.passes.iter_mut().find(|p| p.name == name))
        {
            *pass.cpu_ms.get_or_insert(0.0) += spent;
        }
        result
    }
}

/// Time that all threads of this process have spent on processor cores, milliseconds; `None` where the system does not
/// tell (all but Unix).
pub fn process_ms() -> Option<f64> {
    #[cfg(unix)]
    {
        let spent = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Some(spent.tv_sec as f64 * 1e3 + spent.tv_nsec as f64 / 1e6)
    }
    #[cfg(not(unix))]
    None
}
