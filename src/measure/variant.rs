//! Settings with a name.

use super::compare::Task;
use crate::error::{Error, Result};
use crate::scene::{Override, Scene};
use crate::settings::Settings;

/// Settings with a name.
#[derive(Debug, Clone, PartialEq)]
pub struct Variant {
    /// For people.
    pub name: String,
    /// What differs from the scene's settings.
    pub overrides: Vec<Override>,
}

impl Variant {
    /// Reads `NAME:key=value,key=value`, where a value may hold commas itself.
    ///
    /// # Errors
    /// [`Error::Override`] where that is not what it says.
    pub fn parse(text: &str) -> Result<Self> {
        let given = format!("--variant {text}");
        let wrong = || Error::Override {
            given: given.clone(),
            problem: "write NAME:key=value,key=value, as in fast:sscr.points_per_pixel=2".into(),
        };
        let (name, settings) = text.split_once(':').ok_or_else(wrong)?;
        if name.trim().is_empty() {
            return Err(wrong());
        }
        let mut parts: Vec<String> = Vec::new();
        for part in settings.split(',').filter(|p| !p.trim().is_empty()) {
            match parts.last_mut() {
                Some(last) if !part.contains('=') => {
                    last.push(',');
                    last.push_str(part);
                }
                _ => parts.push(part.to_owned()),
            }
        }
        let overrides = parts.iter().map(|part| Override::parse(part, &given));
        Ok(Self {
            name: name.trim().to_owned(),
            overrides: overrides.collect::<Result<_>>()?,
        })
    }

    /// What is compared unless told otherwise: both searches, and traced rays.
    ///
    /// # Errors
    /// None that can be met: the settings are there.
    pub fn usual() -> Result<Vec<Self>> {
        [
            "interleaved:reflect.method=sscr,sscr.search=interleaved",
            "guided:reflect.method=sscr,sscr.search=guided",
            "ray_trace:reflect.method=ray_trace",
        ]
        .map(Self::parse)
        .into_iter()
        .collect()
    }

    /// The settings of the variant, which may change nothing else.
    pub(super) fn settings(&self, task: &Task<'_>, scene: &Scene) -> Result<Settings> {
        let all = [task.overrides, &self.overrides].concat();
        let changed = Scene::open(task.path, &all)?;
        if !changed.shows_the_same(scene) {
            return Err(Error::Override {
                given: format!("--variant {}", crate::text::short_name(&self.name)),
                problem:
                    "it changes what is seen, not only how; compare such scenes by catoptric sweep"
                        .into(),
            });
        }
        Ok(changed.settings)
    }
}
