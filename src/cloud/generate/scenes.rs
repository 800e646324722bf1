//! The scenes by name, and the mirrors in them.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::Shape;
use crate::cloud::TriangleMesh;
use crate::error::{Error, Result};
use crate::setting_choice;

setting_choice! {
    /// A scene that can be generated.
    pub enum SceneName {
        /// A ball.
        Sphere = "sphere",
        /// A bowl that opens to the camera.
        Parabola = "parabola",
        /// A dented ball.
        Blob = "blob",
        /// A tilted ring.
        Torus = "torus",
        /// A flat mirror, turned a little.
        Plane = "plane",
        /// All the others except the bumps, smaller and side by side.
        Multi = "multi",
        /// A ball covered with small bumps and dents.
        Bumps = "bumps",
        /// The Stanford bunny, from a mesh that the user brings.
        Bunny = "bunny",
    }
}

impl SceneName {
    /// Every scene.
    pub const ALL: [Self; 8] = [
        Self::Sphere,
        Self::Parabola,
        Self::Blob,
        Self::Torus,
        Self::Plane,
        Self::Multi,
        Self::Bumps,
        Self::Bunny,
    ];

    /// The name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Parabola => "parabola",
            Self::Blob => "blob",
            Self::Torus => "torus",
            Self::Plane => "plane",
            Self::Multi => "multi",
            Self::Bumps => "bumps",
            Self::Bunny => "bunny",
        }
    }

    /// The mirrors in the room.
    ///
    /// # Errors
    /// [`Error::Setting`] where the bunny lacks its mesh, or a mesh is given to a scene that has no use for it.
    pub fn mirrors(self, mesh: Option<&TriangleMesh>) -> Result<Vec<Shape>> {
        let bunny = mesh.map(|mesh| Shape::Mesh(Arc::new(mesh.clone())));
        let single = match self {
            Self::Sphere => Shape::Sphere {
                centre: CENTRE,
                radius: 0.44,
            },
            Self::Parabola => Shape::Paraboloid {
                vertex: DVec3::new(0.0, 0.0, -1.3),
                axis: DVec3::Z,
                focal_length: 0.25,
                rim_radius: 0.44,
            },
            Self::Blob => Shape::Blob {
                centre: CENTRE,
                radius: 0.40,
                amplitude: 0.25,
            },
            Self::Torus => {
                let tilt = 35f64.to_radians();
                let axis = DVec3::new(0.0, -tilt.sin(), tilt.cos());
                Shape::Torus {
                    centre: CENTRE,
                    axis,
                    major_radius: 0.36,
                    minor_radius: 0.13,
                }
            }
            Self::Plane => {
                let turn = 20f64.to_radians();
                let normal = DVec3::new(turn.sin(), 0.0, turn.cos());
                Shape::Plane {
                    centre: CENTRE,
                    normal,
                    up: DVec3::Y,
                    size: DVec2::splat(0.8),
                }
            }
            Self::Bumps => Shape::Bumps {
                centre: CENTRE,
                radius: 0.42,
            },
            Self::Bunny => {
                return bunny.map(|b| vec![b]).ok_or_else(|| {
                    Error::Setting("the bunny needs its mesh; give it with --mesh FILE, or mesh = \"FILE\" in the scene".into())
                });
            }
            Self::Multi => return many(bunny),
        };
        if bunny.is_some() {
            return Err(Error::Setting(format!(
                "{} has no use for a mesh; leave it out, or generate bunny or multi",
                self.name()
            )));
        }
        Ok(vec![single])
    }
}

impl std::fmt::Display for SceneName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for SceneName {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        if let Some(found) = Self::ALL.into_iter().find(|n| n.name() == text) {
            return Ok(found);
        }
        let likeness = |n: &Self| strsim::jaro_winkler(n.name(), text);
        let nearest = Self::ALL
            .into_iter()
            .max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
        let nearest = nearest
            .filter(|n| likeness(n) > 0.7)
            .map_or(String::new(), |n| format!("did you mean {n}? "));
        let all = Self::ALL.map(Self::name).join(", ");
        Err(Error::Setting(format!(
            "no generated scene is called {text:?}; {nearest}there are {all}"
        )))
    }
}

/// Where the mirror of most scenes stands.
const CENTRE: DVec3 = DVec3::new(0.0, 0.0, -1.1);

/// The mirrors of `multi`, in two rows; without a bunny its place stays empty.
fn many(bunny: Option<Shape>) -> Result<Vec<Shape>> {
    let mut mirrors = Vec::with_capacity(6);
    for (name, x, y) in [
        (SceneName::Sphere, -0.66, 0.36),
        (SceneName::Parabola, 0.0, 0.36),
        (SceneName::Blob, 0.66, 0.36),
        (SceneName::Torus, -0.66, -0.38),
        (SceneName::Bunny, 0.0, -0.38),
        (SceneName::Plane, 0.66, -0.38),
    ] {
        let shapes = if name == SceneName::Bunny {
            bunny.iter().cloned().collect()
        } else {
            name.mirrors(None)?
        };
        let shift = DVec3::new(x, y, CENTRE.z) - CENTRE;
        mirrors.extend(
            shapes
                .iter()
                .map(|s| s.scaled_and_shifted(0.6, CENTRE, shift)),
        );
    }
    Ok(mirrors)
}
