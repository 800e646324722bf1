//! From a scene's plain data to surfels, a camera and lights.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::cache::{Key, PointCache};
use super::{CloudSource, MirrorShape, Scene, SceneCloud, SceneEnvironment};
use crate::camera::Camera;
use crate::cloud::generate::{Shape, generate, sample_mirror};
use crate::cloud::{
    Bounds, CloudPoints, ColourBy, Facts, Look, Material, ReadOptions, Surfels, TriangleMesh,
    UpAxis, assemble, read_cloud,
};
use crate::error::{Error, Result};
use crate::frame::View;
use crate::gi::SpotLight;
use crate::gi::environment::{Environment, Sky};
use crate::gi::sky_map::SkyMap;
use crate::job::Job;
use crate::plan::{Plan, SceneFacts};
use crate::settings::Settings;

/// Memory that a point takes beside what is kept of it for editing: packed, shuffled, on a device.
const EDITING_BYTES_PER_POINT: u64 = 128;

/// A scene with all of its points, ready to be drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedScene {
    /// All points, mirrors put into the scene among them.
    pub surfels: Arc<Surfels>,
    /// Counts, bounds, repairs.
    pub facts: Facts,
    /// Complete.
    pub camera: Camera,
    /// Relative to the origin of the surfels; point lights in their six parts.
    pub lights: Vec<SpotLight>,
    /// Light from everywhere.
    pub environment: Option<Arc<Environment>>,
    /// Which axis points up.
    pub up_axis: UpAxis,
    /// What normals turned to that files lack, where their cloud does not say otherwise; in the scene's frame.
    pub viewpoint: DVec3,
}

impl LoadedScene {
    /// Who looks, and by which light.
    ///
    /// # Errors
    /// As [`Camera::pinhole`]; a camera that came with the scene is sound.
    pub fn view(&self) -> Result<View> {
        self.view_from(&self.camera)
    }

    /// The same, from another camera.
    ///
    /// # Errors
    /// As [`Camera::pinhole`].
    pub fn view_from(&self, camera: &Camera) -> Result<View> {
        let origin = self.surfels.origin;
        let Bounds { min, max } = self.facts.bounds;
        Ok(View {
            pinhole: camera.pinhole(origin)?,
            lights: self.lights.clone(),
            environment: self.environment.clone(),
            bounds: ((min - origin).as_vec3(), (max - origin).as_vec3()),
        })
    }

    /// What a frame of this scene runs, and why.
    pub fn plan(&self, settings: &Settings) -> Plan {
        // A point light is six pyramids.
        let pyramids = self.lights.iter().filter(|light| light.pyramid).count();
        let facts = SceneFacts {
            points: self.facts.points,
            mirror_points: self.facts.mirror_points,
            lights: self.lights.len() - pyramids + pyramids / 6,
            environment: self.environment.is_some(),
        };
        Plan::new(&facts, settings)
    }
}

impl Scene {
    /// Reads and generates every visible cloud, puts the mirrors in, and completes the camera.
    ///
    /// # Errors
    /// What reading, generating and preparing meet; [`crate::Error::Scene`] or [`crate::Error::Override`] for a camera
    /// that cannot see.
    pub fn load(&self, job: &Job) -> Result<LoadedScene> {
        self.load_with(&mut PointCache::default(), job)
    }

    /// The same, with what was kept of an earlier loading.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn load_with(&self, cache: &mut PointCache, job: &Job) -> Result<LoadedScene> {
        // A missing map is noticed before the clouds are read.
        let sky = self.environment.as_ref().map(SceneEnvironment::load);
        let sky = sky.transpose()?;
        let mut parts = Vec::with_capacity(self.clouds.len() + self.mirrors.len());
        let mut wanted = Vec::new();
        for cloud in &self.clouds {
            let key = Key::of_cloud(cloud, cloud.columns(cache.keeps()));
            wanted.push(key.clone());
            if cloud.visible {
                let columns = cloud.columns(cache.keeps());
                let points = cache.get_or(key, || cloud.load(columns, job))?;
                parts.push((points, cloud.look(self.clip)));
            }
        }
        if parts.is_empty() {
            return Err(Error::NoPoints(
                "every cloud of the scene is hidden; make one visible".to_owned(),
            ));
        }
        let up_axis = self.up_axis(&parts);
        if !self.mirrors.is_empty() {
            let spacing = spacing_of(&parts);
            for (index, mirror) in self.mirrors.iter().enumerate() {
                let name = format!("mirror {index}");
                let key = Key::of_mirror(mirror, spacing, index);
                wanted.push(key.clone());
                let points = cache.get_or(key, || {
                    let raw = sample_mirror(&mirror.load(job)?, spacing, index as u64, job)?;
                    CloudPoints::new(raw, None, &name, job)
                })?;
                let look = Look {
                    name,
                    ..Look::default()
                };
                parts.push((points, look));
            }
        }

        // Normals that are missing turn to the eye, which a fitted camera places by the bounds.
        let viewpoint = self.camera(bounds_of(&parts), up_axis)?.position;
        let count: u64 = parts.iter().map(|(points, _)| points.len() as u64).sum();
        cache.keep(&wanted, count * EDITING_BYTES_PER_POINT);
        let prepared = assemble(parts, viewpoint, job)?;
        let camera = self.camera(prepared.facts.bounds, up_axis)?;
        let origin = prepared.surfels.origin;
        // What is up on screen is another axis where the camera looks straight down.
        let up = self.camera.up.unwrap_or(up_axis.vector()).as_vec3();
        Ok(LoadedScene {
            surfels: Arc::new(prepared.surfels),
            facts: prepared.facts,
            camera,
            lights: self
                .lights
                .iter()
                .flat_map(|light| light.relative_to(origin))
                .collect(),
            environment: sky.map(|sky| Arc::new(Environment::new(sky, up))),
            up_axis,
            viewpoint,
        })
    }

    /// Every file that the scene reads, itself first.
    pub fn inputs(&self) -> Vec<&Path> {
        let mut inputs = vec![self.file.as_path()];
        for cloud in &self.clouds {
            match &cloud.source {
                CloudSource::File(path) => inputs.push(path),
                CloudSource::Generated { mesh, .. } => inputs.extend(mesh.as_deref()),
            }
        }
        inputs.extend(self.mirrors.iter().filter_map(|mirror| match mirror {
            MirrorShape::Mesh { path } => Some(path.as_path()),
            MirrorShape::Shape(_) => None,
        }));
        if let Some(SceneEnvironment::Map { path }) = &self.environment {
            inputs.push(path);
        }
        inputs
    }

    /// What the first cloud says, or else the file of the first that is visible, or else what is usual for its kind.
    fn up_axis(&self, parts: &[(Arc<CloudPoints>, Look)]) -> UpAxis {
        let stated = self.clouds.first().and_then(|cloud| cloud.up_axis);
        stated
            .or_else(|| parts.first().and_then(|(points, _)| points.up_axis()))
            .unwrap_or(UpAxis::Z)
    }
}

impl SceneCloud {
    /// For people: the file, or what is generated.
    pub fn name(&self) -> String {
        match &self.source {
            CloudSource::File(path) => path.display().to_string(),
            CloudSource::Generated { name, .. } => name.to_string(),
        }
    }

    /// The columns that are asked for beside those that every cloud may have.
    fn columns(&self, for_editing: bool) -> Vec<String> {
        let of_rules = self.mirrors.iter().filter_map(|rule| rule.select.column());
        let class = ColourBy::Class.column().filter(|_| for_editing);
        let all = of_rules.chain(self.colour.column()).chain(class);
        let mut columns: Vec<String> = all.map(str::to_owned).collect();
        columns.sort_unstable();
        columns.dedup();
        columns
    }

    fn look(&self, clip: Option<Bounds>) -> Look {
        Look {
            name: self.name(),
            material: Material {
                specular: self.specular,
                shininess: self.shininess,
            },
            mirrors: self.mirrors.clone(),
            colour: self.colour,
            viewpoint: self.viewpoint,
            clip,
        }
    }

    fn load(&self, columns: Vec<String>, job: &Job) -> Result<CloudPoints> {
        let raw = match &self.source {
            CloudSource::File(path) => {
                let options = ReadOptions {
                    columns,
                    colour_bits: self.colour_bits,
                };
                read_cloud(path, &options, job)?
            }
            CloudSource::Generated {
                name,
                points,
                seed,
                mesh,
            } => {
                let mesh = mesh.as_ref().map(|path| TriangleMesh::read(path, job));
                generate(*name, *points, *seed, mesh.transpose()?.as_ref(), job)?
            }
        };
        CloudPoints::new(raw, self.transform.as_ref(), &self.name(), job)
    }
}

impl SceneEnvironment {
    fn load(&self) -> Result<Sky> {
        Ok(match self {
            Self::Gradient { zenith, horizon } => Sky::Gradient {
                zenith: *zenith,
                horizon: *horizon,
            },
            Self::Map { path } => Sky::Map(SkyMap::read(path)?),
        })
    }
}

impl MirrorShape {
    fn load(&self, job: &Job) -> Result<Shape> {
        match self {
            Self::Shape(shape) => Ok(shape.clone()),
            Self::Mesh { path } => Ok(Shape::Mesh(Arc::new(TriangleMesh::read(path, job)?))),
        }
    }
}

/// The spacing at which mirrors are sampled: that of the densest cloud.
fn spacing_of(parts: &[(Arc<CloudPoints>, Look)]) -> f64 {
    let spacings = parts
        .iter()
        .filter_map(|(points, _)| points.typical_spacing());
    let densest = spacings.fold(f64::INFINITY, f64::min);
    if densest.is_finite() { densest } else { 1.0 }
}

/// The box of all points that may be drawn, in the scene's frame; a point at 0 where there is none.
fn bounds_of(parts: &[(Arc<CloudPoints>, Look)]) -> Bounds {
    let seen = parts.iter().map(|(points, look)| match look.clip {
        Some(clip) => points.bounds().intersection(clip),
        None => points.bounds(),
    });
    let bounds = seen
        .filter(|bounds| !bounds.is_empty())
        .fold(Bounds::of([]), Bounds::union);
    if bounds.is_empty() {
        Bounds {
            min: DVec3::ZERO,
            max: DVec3::ZERO,
        }
    } else {
        bounds
    }
}
