//! What an editor keeps of a scene's clouds, so that a change of how they look reads no file again.

use std::path::Path;
use std::sync::Arc;
use std::time::SystemTime;

use glam::DMat4;

use super::{CloudSource, MirrorShape, SceneCloud};
use crate::cloud::{CloudPoints, ColourBits, require_memory};
use crate::error::Result;

/// The points of a scene's clouds and mirrors, kept from one [loading](super::Scene::load_with) to the next.
///
/// Files that have changed since are read again. What is no longer part of the scene is let go, and so is everything where
/// memory is short.
#[derive(Debug, Default)]
pub struct PointCache {
    /// `None` keeps nothing.
    kept: Option<Vec<(Key, Arc<CloudPoints>)>>,
}

/// What the points of a cloud or a mirror depend on.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Key {
    Cloud {
        source: CloudSource,
        colour_bits: ColourBits,
        transform: Option<DMat4>,
        columns: Vec<String>,
        stamp: Option<Stamp>,
    },
    Mirror {
        shape: MirrorShape,
        spacing: f64,
        index: usize,
        stamp: Option<Stamp>,
    },
}

/// Length and time of a file's last change.
type Stamp = (u64, Option<SystemTime>);

fn stamp(path: &Path) -> Option<Stamp> {
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.len(), metadata.modified().ok()))
}

impl Key {
    pub(super) fn of_cloud(cloud: &SceneCloud, columns: Vec<String>) -> Self {
        let file = match &cloud.source {
            CloudSource::File(path) => Some(path),
            CloudSource::Generated { mesh, .. } => mesh.as_ref(),
        };
        Self::Cloud {
            source: cloud.source.clone(),
            colour_bits: cloud.colour_bits,
            transform: cloud.transform,
            columns,
            stamp: file.and_then(|path| stamp(path)),
        }
    }

    pub(super) fn of_mirror(shape: &MirrorShape, spacing: f64, index: usize) -> Self {
        let file = match shape {
            MirrorShape::Mesh { path } => stamp(path),
            MirrorShape::Shape(_) => None,
        };
        Self::Mirror {
            shape: shape.clone(),
            spacing,
            index,
            stamp: file,
        }
    }
}

impl PointCache {
    /// One that keeps points, and has them read with what an editor asks for: their classes.
    pub fn for_editing() -> Self {
        Self {
            kept: Some(Vec::new()),
        }
    }

    /// Whether it keeps what it is given.
    pub(super) fn keeps(&self) -> bool {
        self.kept.is_some()
    }

    /// What is kept under the key, or else what is made.
    pub(super) fn get_or(
        &mut self,
        key: Key,
        make: impl FnOnce() -> Result<CloudPoints>,
    ) -> Result<Arc<CloudPoints>> {
        let found = self.kept.iter().flatten().find(|(k, _)| *k == key);
        if let Some((_, points)) = found {
            return Ok(Arc::clone(points));
        }
        let points = Arc::new(make()?);
        if let Some(kept) = &mut self.kept {
            kept.push((key, Arc::clone(&points)));
        }
        Ok(points)
    }

    /// Lets go of what is not `wanted`, and of everything where `more` further bytes would not fit beside it.
    pub(super) fn keep(&mut self, wanted: &[Key], more: u64) {
        if let Some(kept) = &mut self.kept {
            kept.retain(|(key, _)| wanted.contains(key));
            if require_memory("keeping the points", more).is_err() {
                kept.clear();
            }
        }
    }
}
