//! What a person changes of a scene: its clouds and mirrors, what is cut away, and the settings.

use catoptric::cloud::Bounds;
use catoptric::scene::{MirrorShape, Scene, SceneCloud};
use catoptric::settings::Settings;

/// A scene, but for who looks and what shines.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Document {
    pub(super) clouds: Vec<SceneCloud>,
    pub(super) mirrors: Vec<MirrorShape>,
    pub(super) clip: Option<Bounds>,
    pub(super) settings: Settings,
}

impl Document {
    pub(super) fn of(scene: &Scene) -> Self {
        Self {
            clouds: scene.clouds.clone(),
            mirrors: scene.mirrors.clone(),
            clip: scene.clip,
            settings: scene.settings.clone(),
        }
    }

    /// Whether both have the same points, so that only their settings may differ.
    pub(super) fn has_points_of(&self, other: &Self) -> bool {
        self.clouds == other.clouds && self.mirrors == other.mirrors && self.clip == other.clip
    }

    /// The scene with what was changed.
    pub(super) fn put_into(&self, scene: &Scene) -> Scene {
        Scene {
            clouds: self.clouds.clone(),
            mirrors: self.mirrors.clone(),
            clip: self.clip,
            settings: self.settings.clone(),
            ..scene.clone()
        }
    }
}
