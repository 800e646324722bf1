//! The scene file: which clouds, mirrors and lights there are, the camera and the settings.
//!
//! A scene is read in three steps: the TOML becomes a tree that knows its lines, what the caller gives on top takes
//! its place in the tree, and the tree is read into the plain data below, with every key and value checked.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use glam::{DMat4, DVec3, UVec2, Vec3};

use crate::cloud::generate::{SceneName, Shape};
use crate::cloud::{Bounds, ColourBits, ColourBy, MirrorRule, UpAxis};
use crate::error::{Error, Result};
use crate::gi::SpotLight;
use crate::settings::Settings;

mod cache;
mod camera;
mod fit;
mod keys;
mod load;
mod overrides;
mod read;
mod reader;
mod settings;
mod tree;
mod write;

pub use cache::PointCache;
pub use camera::{DEFAULT_FOV_Y_DEGREES, DEFAULT_SIZE, default_camera};
pub use load::LoadedScene;
pub use overrides::Override;

use tree::{Entry, Node, Origin, Origins, Value};

/// The version of the scene format.
pub const FORMAT: i64 = 1;
/// Seed of a generated cloud that does not say which.
pub const DEFAULT_SEED: u64 = 1;
/// Largest scene file, bytes; whatever is larger is no scene.
const MAX_FILE_BYTES: u64 = 16 << 20;

/// What is to be drawn, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The scene file, or the cloud that stands for one.
    pub file: PathBuf,
    /// At least one.
    pub clouds: Vec<SceneCloud>,
    /// Mirrors put into the scene.
    pub mirrors: Vec<MirrorShape>,
    /// Lights; where there is none, the albedo is shown, shaded by depth.
    pub lights: Vec<SceneLight>,
    /// Light from everywhere.
    pub environment: Option<SceneEnvironment>,
    /// Only what lies in this box is drawn of the clouds, borders included; mirrors put into the scene stay whole. Sides
    /// that are not given are infinite.
    pub clip: Option<Bounds>,
    /// What the scene says of the camera; [`Scene::camera`] completes it.
    pub camera: SceneCamera,
    /// Every setting.
    pub settings: Settings,
}

/// One `[[cloud]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneCloud {
    /// Where its points come from.
    pub source: CloudSource,
    /// Which axis points up; `None` leaves that to the file.
    pub up_axis: Option<UpAxis>,
    /// How integer colours are read.
    pub colour_bits: ColourBits,
    /// From the file's coordinates to the scene's frame; affine, keeps handedness.
    pub transform: Option<DMat4>,
    /// Specular reflectance, 0 to 1, of points whose file says none.
    pub specular: f32,
    /// Phong exponent of points whose file says none.
    pub shininess: f32,
    /// Which points are mirrors; several rules add up.
    pub mirrors: Vec<MirrorRule>,
    /// What gives its points their albedo.
    pub colour: ColourBy,
    /// Whether it is drawn; one that is not is not read.
    pub visible: bool,
    /// What normals that its file lacks turn to, in the scene's frame; `None` is the camera of the scene.
    pub viewpoint: Option<DVec3>,
}

impl SceneCloud {
    /// A cloud of which nothing else is said.
    pub fn new(source: CloudSource) -> Self {
        Self {
            source,
            up_axis: None,
            colour_bits: ColourBits::default(),
            transform: None,
            specular: 0.0,
            shininess: 1.0,
            mirrors: Vec::new(),
            colour: ColourBy::default(),
            visible: true,
            viewpoint: None,
        }
    }
}

/// Where the points of a cloud come from.
#[derive(Debug, Clone, PartialEq)]
pub enum CloudSource {
    /// A point file.
    File(PathBuf),
    /// One of the reference scenes.
    Generated {
        /// Which.
        name: SceneName,
        /// How many points, 1 to [`crate::cloud::generate::MAX_POINTS`].
        points: usize,
        /// Of the random numbers.
        seed: u64,
        /// The mesh of "bunny" (needed) and "multi" (optional): PLY with faces.
        mesh: Option<PathBuf>,
    },
}

/// One `[[mirror]]`: a shape in the scene's frame.
#[derive(Debug, Clone, PartialEq)]
pub enum MirrorShape {
    /// Directions are unit vectors, lengths above 0.
    Shape(Shape),
    /// A triangle mesh: PLY with faces.
    Mesh {
        /// The file.
        path: PathBuf,
    },
}

/// One `[[light]]`, in the scene's frame: a spot, or a point light, which shines in all directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneLight {
    /// Where it is.
    pub position: DVec3,
    /// What a spot points at; differs from `position`. `None` is a point light.
    pub target: Option<DVec3>,
    /// W/sr per channel.
    pub intensity: Vec3,
    /// Half angle within which a spot is full, radians.
    pub inner_angle: f64,
    /// Half angle at which it has fallen to 0, radians; at least `inner_angle`.
    pub outer_angle: f64,
}

/// The `[environment]`: radiance by direction, W/sr/m2 per channel.
#[derive(Debug, Clone, PartialEq)]
pub enum SceneEnvironment {
    /// From the horizon's to the zenith's in proportion to the elevation; the same for both is an even sky.
    Gradient {
        /// Straight up.
        zenith: Vec3,
        /// At the horizon and below.
        horizon: Vec3,
    },
    /// An equirectangular picture.
    Map {
        /// An OpenEXR file.
        path: PathBuf,
    },
}

/// What a scene says of its camera.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneCamera {
    /// Where the eye is.
    pub position: Option<DVec3>,
    /// What it looks at.
    pub target: Option<DVec3>,
    /// Roughly up.
    pub up: Option<DVec3>,
    /// Vertical field of view, degrees.
    pub fov_y_degrees: Option<f64>,
    /// Nothing nearer along the axis is drawn.
    pub near: Option<f64>,
    /// Nothing farther along the axis is drawn.
    pub far: Option<f64>,
    /// Width and height, pixels.
    pub size: Option<UVec2>,
    /// Whom to tell that they do not fit together.
    origins: Origins,
}

impl Scene {
    /// Reads a scene file (its name ends in `.toml`), or makes a scene of the point file `path` alone. What
    /// `overrides` say takes the place of what the file says.
    ///
    /// # Errors
    /// [`Error::Read`] where the file cannot be read, [`Error::Scene`] (with the line) where the file is wrong,
    /// [`Error::Override`] where what was given on top of it is. A point file is not opened here.
    pub fn open(path: &Path, overrides: &[Override]) -> Result<Self> {
        if is_scene_file(path) {
            Self::parse(&read_text(path)?, path, overrides)
        } else {
            let node = |value| Node {
                value,
                origin: Origin::File {
                    path: path.into(),
                    line: None,
                },
            };
            let entry = |key: &str, value| Entry {
                key: key.into(),
                origin: node(Value::Boolean(true)).origin,
                node: node(value),
            };
            // The path is used as it is: it starts from the current folder, not from the cloud's own.
            let file = path.file_name().map_or(path, Path::new);
            let cloud = node(Value::Table(vec![entry("path", Value::Path(file.into()))]));
            let format = entry("format", Value::Integer(FORMAT));
            read::scene(
                node(Value::Table(vec![
                    format,
                    entry("cloud", Value::Array(vec![cloud])),
                ])),
                path,
                overrides,
            )
        }
    }

    /// Whether this scene and another have the same points, lights and camera, so that only their settings may differ.
    pub fn shows_the_same(&self, other: &Self) -> bool {
        self.clouds == other.clouds
            && self.mirrors == other.mirrors
            && self.lights == other.lights
            && self.environment == other.environment
            && self.clip == other.clip
            && self.camera.sees_as(&other.camera)
    }

    /// Reads the text of the scene file `path`; paths in it are relative to its folder.
    ///
    /// # Errors
    /// As [`Scene::open`].
    pub fn parse(text: &str, path: &Path, overrides: &[Override]) -> Result<Self> {
        read::scene(Node::parse_document(text, path)?, path, overrides)
    }
}

impl SceneCamera {
    fn sees_as(&self, other: &Self) -> bool {
        let of = |c: &Self| {
            (
                c.position,
                c.target,
                c.up,
                c.fov_y_degrees,
                c.near,
                c.far,
                c.size,
            )
        };
        of(self) == of(other)
    }
}

impl SceneLight {
    /// The light, relative to the scene's origin: a spot, or the six parts of a point light.
    pub fn relative_to(&self, origin: DVec3) -> Vec<SpotLight> {
        let position = (self.position - origin).as_vec3();
        let Some(target) = self.target else {
            return SpotLight::all_around(position, self.intensity).to_vec();
        };
        vec![SpotLight {
            position,
            axis: (target - self.position)
                .normalize_or(DVec3::NEG_Z)
                .as_vec3(),
            intensity: self.intensity,
            inner_angle: self.inner_angle as f32,
            outer_angle: self.outer_angle as f32,
            pyramid: false,
        }]
    }
}

/// Whether `path` names a scene file rather than a point file.
pub fn is_scene_file(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"))
}

fn read_text(path: &Path) -> Result<String> {
    let unreadable = |source| Error::Read {
        path: path.into(),
        source,
    };
    let wrong = |problem: &str| Error::Scene {
        path: path.into(),
        line: None,
        problem: problem.into(),
    };
    // Opening a pipe would wait for whoever writes into it.
    let kind = std::fs::metadata(path).map_err(unreadable)?;
    if !kind.is_file() {
        return Err(wrong("is not a file; give the path of a scene file"));
    }
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(unreadable)?;
    file.take(MAX_FILE_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(wrong(
            "is larger than 16 MiB, which no scene file is; clouds belong into files of their own",
        ));
    }
    String::from_utf8(bytes).map_err(|_| wrong("is not UTF-8 text; a scene file is TOML"))
}
