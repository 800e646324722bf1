//! A scene back to its file: what has not changed stays as it was written, comments and all.

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value, value};

mod merge;

use super::{
    CloudSource, FORMAT, MirrorShape, Scene, SceneCamera, SceneCloud, SceneEnvironment, SceneLight,
    read_text,
};
use crate::cloud::generate::Shape;
use crate::cloud::{Bounds, ColourBits, ColourBy, MirrorRule, Select, UpAxis};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::output::Outputs;
use crate::settings::Settings;

impl Scene {
    /// Writes the scene to the file `path`, and gives it as it is read from there. Where the scene came from a scene file, what
    /// has not changed stays as it is written there, comments and all.
    ///
    /// # Errors
    /// [`Error::Setting`] for a path that is no text, and where `path` is the scene's own file and can no longer be read as
    /// one; [`Error::Write`].
    pub fn save(&self, path: &Path) -> Result<Self> {
        let own = super::is_scene_file(&self.file).then(|| read_text(&self.file).ok());
        let like = own.flatten();
        let text = self.to_toml(path, like.as_deref())?;
        // What cannot be read back is not written.
        let read = Self::parse(&text, path, &[])?;
        let mut outputs = Outputs::default();
        outputs.stage(path, |file| file.write_all(text.as_bytes()))?;
        outputs.commit(&Job::default())?;
        Ok(read)
    }

    /// The text of a scene file that would lie at `path`. What `like`, the text of another one, says in the same way stays
    /// as it is there.
    ///
    /// # Errors
    /// [`Error::Setting`] for a path that is no text, and for a `like` that is no scene.
    pub fn to_toml(&self, path: &Path, like: Option<&str>) -> Result<String> {
        let (mut document, old) = match like {
            None => (DocumentMut::new(), None),
            Some(text) => {
                let document: Result<DocumentMut, _> = text.parse();
                let document = document.ok().filter(|d| d.contains_key("cloud"));
                let document = document.ok_or_else(|| {
                    Error::Setting(format!(
                        "{} can no longer be read as a scene, and what is in it would be lost; save under another name",
                        self.file.display()
                    ))
                })?;
                // A scene that needs something on top of its file is spelt out.
                (document, Self::parse(text, path, &[]).ok())
            }
        };
        let folder = absolute(path.parent().unwrap_or(Path::new("")));
        let writer = Writer { folder };
        let new = writer.sections(self)?;
        let old = old.map(|old| writer.sections(&old)).transpose()?;
        if !document.contains_key("format") {
            document.insert("format", value(FORMAT));
        }
        merge::into(&mut document, old.as_ref(), &new);
        let text = document.to_string();
        let first = like.and_then(|like| like.split_inclusive('\n').next());
        let crlf = first.is_some_and(|line| line.ends_with("\r\n"));
        Ok(if crlf {
            text.replace("\r\n", "\n").replace('\n', "\r\n")
        } else {
            text
        })
    }
}

/// What a scene says, table by table.
pub(super) struct Sections {
    /// `[[cloud]]`, `[[mirror]]`, `[[light]]`.
    pub(super) lists: [(&'static str, Vec<Table>); 3],
    /// `[environment]`, `[clip]`, `[camera]`, `[settings]`; empty ones are not there.
    pub(super) tables: [(&'static str, Table); 4],
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| {
        std::env::current_dir().map_or_else(|_| path.to_owned(), |folder| folder.join(path))
    })
}

/// Writes what has paths in it.
struct Writer {
    /// Of the scene file; absolute.
    folder: PathBuf,
}

impl Writer {
    fn sections(&self, scene: &Scene) -> Result<Sections> {
        let environment = scene.environment.as_ref();
        let environment = environment.map(|e| self.environment(e)).transpose()?;
        Ok(Sections {
            lists: [
                ("cloud", self.each(&scene.clouds, Self::cloud)?),
                ("mirror", self.each(&scene.mirrors, Self::mirror)?),
                ("light", scene.lights.iter().map(light_table).collect()),
            ],
            tables: [
                ("environment", environment.unwrap_or_default()),
                ("clip", scene.clip.map(clip_table).unwrap_or_default()),
                ("camera", camera_table(&scene.camera)),
                ("settings", settings_table(&scene.settings)),
            ],
        })
    }

    fn each<T>(
        &self,
        items: &[T],
        write: impl Fn(&Self, &T) -> Result<Table>,
    ) -> Result<Vec<Table>> {
        items.iter().map(|item| write(self, item)).collect()
    }

    /// Relative to the scene file where it lies beside or below it.
    fn path(&self, path: &Path) -> Result<Value> {
        let whole = absolute(path);
        let short = whole.strip_prefix(&self.folder).unwrap_or(&whole);
        let text = short.to_str().ok_or_else(|| {
            Error::Setting(format!(
                "{} cannot be named in a scene file, since its name is not UTF-8; rename it",
                path.display()
            ))
        })?;
        Ok(text.into())
    }

    fn cloud(&self, cloud: &SceneCloud) -> Result<Table> {
        let mut table = Table::new();
        match &cloud.source {
            CloudSource::File(path) => table.insert("path", Item::Value(self.path(path)?)),
            CloudSource::Generated {
                name,
                points,
                seed,
                mesh,
            } => {
                table.insert("generate", value(name.name()));
                table.insert("points", value(*points as i64));
                if let Some(mesh) = mesh {
                    table.insert("mesh", Item::Value(self.path(mesh)?));
                }
                table.insert("seed", value(*seed as i64))
            }
        };
        if let Some(axis) = cloud.up_axis {
            table.insert("up_axis", value(if axis == UpAxis::Y { "y" } else { "z" }));
        }
        match cloud.colour_bits {
            ColourBits::Auto => None,
            ColourBits::Eight => table.insert("colour_bits", value(8)),
            ColourBits::Sixteen => table.insert("colour_bits", value(16)),
        };
        if let Some(transform) = cloud.transform {
            let rows = transform.transpose().to_cols_array();
            table.insert("transform", value(Array::from_iter(rows)));
        }
        if (cloud.specular, cloud.shininess) != (0.0, 1.0) {
            let mut material = InlineTable::new();
            material.insert("specular", single(cloud.specular).into());
            material.insert("shininess", single(cloud.shininess).into());
            table.insert("material", value(material));
        }
        if cloud.colour != ColourBy::Auto {
            table.insert("colour", value(cloud.colour.name()));
        }
        if !cloud.visible {
            table.insert("visible", value(false));
        }
        if let Some(viewpoint) = cloud.viewpoint {
            table.insert("viewpoint", Item::Value(vector(viewpoint)));
        }
        if !cloud.mirrors.is_empty() {
            let rules: ArrayOfTables = cloud.mirrors.iter().map(rule_table).collect();
            table.insert("mirror", Item::ArrayOfTables(rules));
        }
        Ok(table)
    }

    fn mirror(&self, mirror: &MirrorShape) -> Result<Table> {
        let mut table = Table::new();
        let shape = match mirror {
            MirrorShape::Mesh { path } => {
                table.insert("shape", value("mesh"));
                table.insert("path", Item::Value(self.path(path)?));
                return Ok(table);
            }
            MirrorShape::Shape(shape) => shape,
        };
        let mut put = |key: &str, item: Value| {
            table.insert(key, Item::Value(item));
        };
        match shape {
            Shape::Plane {
                centre,
                normal,
                up,
                size,
            } => {
                put("shape", "plane".into());
                put("centre", vector(*centre));
                put("normal", vector(*normal));
                put("up", vector(*up));
                put("size", Array::from_iter(size.to_array()).into());
            }
            Shape::Sphere { centre, radius } => {
                put("shape", "sphere".into());
                put("centre", vector(*centre));
                put("radius", (*radius).into());
            }
            Shape::Paraboloid {
                vertex,
                axis,
                focal_length,
                rim_radius,
            } => {
                put("shape", "paraboloid".into());
                put("vertex", vector(*vertex));
                put("axis", vector(*axis));
                put("focal_length", (*focal_length).into());
                put("rim_radius", (*rim_radius).into());
            }
            Shape::Torus {
                centre,
                axis,
                major_radius,
                minor_radius,
            } => {
                put("shape", "torus".into());
                put("centre", vector(*centre));
                put("axis", vector(*axis));
                put("major_radius", (*major_radius).into());
                put("minor_radius", (*minor_radius).into());
            }
            Shape::Blob {
                centre,
                radius,
                amplitude,
            } => {
                put("shape", "blob".into());
                put("centre", vector(*centre));
                put("radius", (*radius).into());
                put("amplitude", (*amplitude).into());
            }
            Shape::Bumps { centre, radius } => {
                put("shape", "bumps".into());
                put("centre", vector(*centre));
                put("radius", (*radius).into());
            }
            // Only a file names a mesh.
            Shape::Mesh(_) => {
                return Err(Error::Setting(
                    "a mirror's mesh can be named in a scene file by its own file only".to_owned(),
                ));
            }
        }
        Ok(table)
    }

    fn environment(&self, environment: &SceneEnvironment) -> Result<Table> {
        let mut table = Table::new();
        match environment {
            SceneEnvironment::Gradient { zenith, horizon } if zenith == horizon => {
                table.insert("colour", Item::Value(colour(*zenith)));
            }
            SceneEnvironment::Gradient { zenith, horizon } => {
                table.insert("zenith", Item::Value(colour(*zenith)));
                table.insert("horizon", Item::Value(colour(*horizon)));
            }
            SceneEnvironment::Map { path } => {
                table.insert("map", Item::Value(self.path(path)?));
            }
        }
        Ok(table)
    }
}

fn rule_table(rule: &MirrorRule) -> Table {
    let mut table = Table::new();
    let (key, select): (&str, Value) = match &rule.select {
        Select::Property(name) => ("property", name.as_str().into()),
        Select::Classification(classes) => {
            let classes = classes.iter().map(|class| i64::from(*class));
            ("classification", Array::from_iter(classes).into())
        }
        Select::Box { min, max } => ("box", corners(*min, *max).into()),
        Select::NearPlane {
            point,
            normal,
            distance,
            within,
        } => {
            let mut plane = InlineTable::new();
            plane.insert("point", vector(*point));
            plane.insert("normal", vector(*normal));
            plane.insert("distance", (*distance).into());
            if let Some(Bounds { min, max }) = within {
                plane.insert("within", corners(*min, *max).into());
            }
            ("near_plane", plane.into())
        }
    };
    table.insert(key, Item::Value(select));
    if rule.reflectance != 1.0 {
        table.insert("reflectance", value(single(rule.reflectance)));
    }
    table
}

fn corners(min: DVec3, max: DVec3) -> InlineTable {
    let mut corners = InlineTable::new();
    corners.insert("min", vector(min));
    corners.insert("max", vector(max));
    corners
}

fn clip_table(clip: Bounds) -> Table {
    let mut table = Table::new();
    for (key, corner) in [("min", clip.min), ("max", clip.max)] {
        if corner.is_finite() {
            table.insert(key, Item::Value(vector(corner)));
        }
    }
    table
}

fn light_table(light: &SceneLight) -> Table {
    let mut table = Table::new();
    let kind = if light.target.is_some() {
        "spot"
    } else {
        "point"
    };
    table.insert("kind", value(kind));
    table.insert("position", Item::Value(vector(light.position)));
    if let Some(target) = light.target {
        table.insert("target", Item::Value(vector(target)));
    }
    table.insert("intensity", Item::Value(colour(light.intensity)));
    if light.target.is_some() {
        table.insert("inner_angle_degrees", value(degrees(light.inner_angle)));
        table.insert("outer_angle_degrees", value(degrees(light.outer_angle)));
    }
    table
}

fn camera_table(camera: &SceneCamera) -> Table {
    let mut table = Table::new();
    for (key, at) in [
        ("position", camera.position),
        ("target", camera.target),
        ("up", camera.up),
    ] {
        if let Some(at) = at {
            table.insert(key, Item::Value(vector(at)));
        }
    }
    for (key, number) in [
        ("fov_y_degrees", camera.fov_y_degrees),
        ("near", camera.near),
        ("far", camera.far),
    ] {
        if let Some(number) = number {
            table.insert(key, value(number));
        }
    }
    if let Some(size) = camera.size {
        let sides = size.to_array().map(i64::from);
        table.insert("size", value(Array::from_iter(sides)));
    }
    table
}

/// What differs from the defaults, a table for each group.
fn settings_table(settings: &Settings) -> Table {
    let mut table = Table::new();
    for (key, setting) in settings.changed() {
        let Some((group, name)) = key.split_once('.') else {
            continue;
        };
        let plain: Value = match setting {
            toml::Value::Boolean(truth) => truth.into(),
            toml::Value::Integer(number) => number.into(),
            toml::Value::Float(number) => number.into(),
            toml::Value::String(text) => text.into(),
            other => match other.to_string().parse() {
                Ok(parsed) => parsed,
                Err(_) => continue,
            },
        };
        let group = table.entry(group).or_insert(Item::Table(Table::new()));
        if let Some(group) = group.as_table_mut() {
            group.insert(name, Item::Value(plain));
        }
    }
    table
}

fn vector(v: DVec3) -> Value {
    Array::from_iter(v.to_array()).into()
}

fn colour(v: Vec3) -> Value {
    Array::from_iter(v.to_array().map(single)).into()
}

/// With the digits that a person typed, not with those of its neighbour in double precision.
fn single(v: f32) -> f64 {
    v.to_string().parse().unwrap_or_else(|_| f64::from(v))
}

/// The shortest degrees that are these radians.
fn degrees(radians: f64) -> f64 {
    let near = radians.to_degrees();
    let rounded = (near * 1e9).round() / 1e9;
    let candidates = [rounded, near, near.next_up(), near.next_down()];
    let exact = candidates.into_iter().find(|d| d.to_radians() == radians);
    exact.unwrap_or(near)
}
