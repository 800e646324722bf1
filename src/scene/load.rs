//! From a scene's plain data to surfels, a camera and lights.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::{CloudSource, MirrorShape, Scene, SceneCloud, SceneEnvironment};
use crate::camera::Camera;
use crate::cloud::generate::{Shape, generate, sample_mirror};
use crate::cloud::{
    Bounds, Facts, Material, PlacedCloud, RawCloud, ReadOptions, Surfels, TriangleMesh, UpAxis,
    is_sound, prepare, read_cloud, typical_spacing,
};
use crate::error::Result;
use crate::frame::View;
use crate::gi::SpotLight;
use crate::gi::environment::{Environment, Sky};
use crate::gi::sky_map::SkyMap;
use crate::job::Job;
use crate::plan::{Plan, SceneFacts};
use crate::settings::Settings;

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
    /// Reads and generates every cloud, puts the mirrors in, and completes the camera.
    ///
    /// # Errors
    /// What reading, generating and preparing meet; [`crate::Error::Scene`] or [`crate::Error::Override`] for a camera
    /// that cannot see.
    pub fn load(&self, job: &Job) -> Result<LoadedScene> {
        // A missing map is noticed before the clouds are read.
        let sky = self.environment.as_ref().map(SceneEnvironment::load);
        let sky = sky.transpose()?;
        let mut clouds = Vec::with_capacity(self.clouds.len() + self.mirrors.len());
        for cloud in &self.clouds {
            clouds.push(cloud.load(job)?);
        }
        let up_axis = self.up_axis(&clouds);
        if !self.mirrors.is_empty() {
            let spacing = spacing_of(&clouds, job)?;
            for (index, mirror) in self.mirrors.iter().enumerate() {
                let raw = sample_mirror(&mirror.load(job)?, spacing, index as u64, job)?;
                clouds.push(placed(raw, format!("mirror {index}")));
            }
        }

        // Normals that are missing turn to the eye, which a fitted camera places by the bounds.
        let bounds = bounds_of(&clouds);
        let viewpoint = self.camera(bounds, up_axis)?.position;
        let prepared = prepare(clouds, viewpoint, job)?;
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

    /// What the first cloud says, or else its file, or else what is usual for its kind.
    fn up_axis(&self, clouds: &[PlacedCloud]) -> UpAxis {
        let stated = self.clouds.first().and_then(|cloud| cloud.up_axis);
        stated
            .or_else(|| clouds.first().and_then(|cloud| cloud.raw.up_axis))
            .unwrap_or(UpAxis::Z)
    }
}

impl SceneCloud {
    fn load(&self, job: &Job) -> Result<PlacedCloud> {
        let raw = match &self.source {
            CloudSource::File(path) => {
                let columns = self
                    .mirrors
                    .iter()
                    .filter_map(|rule| rule.select.column())
                    .map(str::to_owned)
                    .collect();
                read_cloud(
                    path,
                    &ReadOptions {
                        columns,
                        colour_bits: self.colour_bits,
                    },
                    job,
                )?
            }
            CloudSource::Generated {
                name,
                points,
                seed,
                mesh,
            } => {
                let mesh = mesh
                    .as_ref()
                    .map(|path| TriangleMesh::read(path, job))
                    .transpose()?;
                generate(*name, *points, *seed, mesh.as_ref(), job)?
            }
        };
        let name = match &self.source {
            CloudSource::File(path) => path.display().to_string(),
            CloudSource::Generated { name, .. } => name.to_string(),
        };
        Ok(PlacedCloud {
            transform: self.transform,
            material: Material {
                specular: self.specular,
                shininess: self.shininess,
            },
            mirrors: self.mirrors.clone(),
            ..placed(raw, name)
        })
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

fn placed(raw: RawCloud, name: String) -> PlacedCloud {
    PlacedCloud {
        raw,
        transform: None,
        material: Material::default(),
        mirrors: Vec::new(),
        name,
    }
}

/// The spacing at which mirrors are sampled: that of the densest cloud.
fn spacing_of(clouds: &[PlacedCloud], job: &Job) -> Result<f64> {
    let mut densest = f64::INFINITY;
    for cloud in clouds {
        densest = densest.min(typical_spacing(cloud, job)?);
    }
    Ok(densest)
}

/// The box of all points that are drawn, in the scene's frame; a point at 0 where there is none.
fn bounds_of(clouds: &[PlacedCloud]) -> Bounds {
    let of_cloud = |cloud: &PlacedCloud| {
        let place = |p: &DVec3| {
            cloud
                .transform
                .map_or(*p, |transform| transform.transform_point3(*p))
        };
        let chunks = cloud.raw.positions.par_chunks(1 << 16);
        let boxes = chunks.map(|chunk| Bounds::of(chunk.iter().map(place).filter(is_sound)));
        boxes.reduce(|| Bounds::of([]), Bounds::union)
    };
    let bounds = clouds
        .iter()
        .map(of_cloud)
        .fold(Bounds::of([]), Bounds::union);
    if bounds.min.cmple(bounds.max).all() {
        bounds
    } else {
        Bounds {
            min: DVec3::ZERO,
            max: DVec3::ZERO,
        }
    }
}
