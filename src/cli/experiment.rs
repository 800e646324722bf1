//! Files that say what to sweep over: docs/experiments.

use std::path::{Path, PathBuf};

use catoptric::Error;
use serde::Deserialize;

/// A scene, and what to vary of it.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Experiment {
    /// Of the report.
    pub(super) title: Option<String>,
    /// Relative to the file.
    pub(super) scene: PathBuf,
    /// As for --set.
    #[serde(default)]
    pub(super) set: Vec<String>,
    /// As for --vary.
    pub(super) vary: Vec<String>,
    /// As for --repeats.
    pub(super) repeats: Option<u32>,
}

impl Experiment {
    /// The experiment of a file, or `None` where it is another kind of file: a scene or a cloud.
    pub(super) fn open(path: &Path) -> anyhow::Result<Option<Self>> {
        if !catoptric::scene::is_scene_file(path) {
            return Ok(None);
        }
        let Ok(text) = std::fs::read_to_string(path) else {
            // Whoever opens it as a scene says why.
            return Ok(None);
        };
        if !toml::from_str::<toml::Table>(&text).is_ok_and(|table| table.contains_key("vary")) {
            return Ok(None);
        }
        let mut experiment: Self = toml::from_str(&text).map_err(|e| Error::Scene {
            path: path.into(),
            line: e
                .span()
                .map(|span| text[..span.start].matches('\n').count() + 1),
            problem: e.message().lines().next().unwrap_or("is wrong").to_owned(),
        })?;
        if let Some(folder) = path.parent() {
            experiment.scene = folder.join(&experiment.scene);
        }
        Ok(Some(experiment))
    }
}
