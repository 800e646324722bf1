//! What tuning came to, as TOML.

use std::fmt::Write as _;

use super::compare_report::aligned;
use super::idle::is_idle;
use super::tune::{Goal, Tuned};

impl Tuned {
    /// What was wanted and is not there, with the best that was; `None` where it is.
    pub fn missed(&self) -> Option<String> {
        let (time, quality) = (
            self.best.ratio().median * self.reference_ms.median,
            self.best.quality,
        );
        let wanted = match self.goal {
            Goal::BudgetMs(budget) => format!("{budget} ms"),
            Goal::Quality(quality) => format!("{quality} dB"),
        };
        (!self.reached).then(|| {
            format!("{wanted} was not reached; the best was {time:.1} ms with {quality:.2} dB")
        })
    }

    /// TOML to paste into a scene: the settings, and as comments what to expect of them and what was tried.
    pub fn toml(&self) -> String {
        let mut text = String::new();
        let ratio = self.best.ratio();
        let ms = |ratio: f64| ratio * self.reference_ms.median;
        let _ = writeln!(
            text,
            "# Expect {:.1} ms a frame ({:.1} to {:.1}), {:.3} x the traced reference, and {:.2} dB of albedo in mirrors.",
            ms(ratio.median),
            ms(ratio.min),
            ms(ratio.max),
            ratio.median,
            self.best.quality
        );
        if let Some(missed) = self.missed() {
            let _ = writeln!(text, "# {missed}.");
        }
        let mut group = "";
        let mut knobs: Vec<_> = self.knobs.iter().zip(&self.best.values).collect();
        knobs.retain(|(knob, _)| !is_idle(&knob.key, &self.best.settings));
        knobs.sort_by_key(|(knob, _)| &knob.key);
        for (knob, value) in knobs {
            let (of, name) = knob.key.split_once('.').unwrap_or(("", &knob.key));
            if of != group {
                let _ = writeln!(text, "[settings.{of}]");
                group = of;
            }
            let _ = writeln!(text, "{name} = {value}");
        }
        let _ = writeln!(text, "\n# Tried, the best first:");
        if self.given_up > 0 {
            let _ = writeln!(
                text,
                "# ({} more were given up: their first frame took longer than would be of use.)",
                self.given_up
            );
        }
        let mut rows = vec![["settings", "frames", "ms", "dB"].map(str::to_owned)];
        for tried in std::iter::once(&self.best).chain(&self.tried) {
            let differs = (self.knobs.iter().zip(&tried.values)).filter(|(k, v)| k.default != **v);
            let differs: Vec<String> = differs.map(|(k, v)| format!("{}={v}", k.key)).collect();
            rows.push([
                if differs.is_empty() {
                    "the scene's own".to_owned()
                } else {
                    differs.join(" ")
                },
                (tried.whole.len() + tried.reckoned.len()).to_string(),
                format!("{:.1}", ms(tried.ratio().median)),
                format!("{:.2}", tried.quality),
            ]);
        }
        for line in aligned(&rows).lines() {
            let _ = writeln!(text, "# {line}");
        }
        text
    }
}
