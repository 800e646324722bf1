//! From the document's tree to the plain data of a scene.

use std::path::Path;

use glam::{DMat4, DVec2, DVec3, UVec2, Vec3};

use super::reader::{
    AMOUNT, AMPLITUDE, COORDINATE, FIELD_OF_VIEW, FRACTION, Field, HALF_ANGLE, LENGTH, SHININESS,
    Table,
};
use super::tree::{Node, Value};
use super::{
    CloudSource, ColourBits, DEFAULT_POINTS, DEFAULT_SEED, FORMAT, GeneratedName, MAX_POINTS,
    MirrorRule, MirrorShape, Override, Scene, SceneCamera, SceneCloud, SceneLight, Select, keys,
    settings,
};
use crate::camera::MAX_SIZE;
use crate::cloud::UpAxis;
use crate::error::{Error, Result};

/// Reads the scene that `document` holds, once `overrides` have taken their places in it.
pub(super) fn scene(mut document: Node, path: &Path, overrides: &[Override]) -> Result<Scene> {
    check_format(&document)?;
    for given in overrides {
        given.apply(&mut document)?;
    }
    let root = Table::open(&document, "", keys::ROOT)?;
    let clouds = each(&root, "cloud", cloud)?;
    if clouds.is_empty() {
        return Err(document
            .origin
            .error("the scene has no cloud; add [[cloud]] with a path"));
    }
    Ok(Scene {
        file: path.to_owned(),
        clouds,
        mirrors: each(&root, "mirror", mirror)?,
        lights: each(&root, "light", light)?,
        camera: match root.get("camera") {
            Some(field) => camera(&field)?,
            None => SceneCamera::unstated(document.origin.clone()),
        },
        settings: settings::read(document.get("settings"))?,
    })
}

/// Refuses another version, and tables of later versions, before any of their keys are found to be unknown.
fn check_format(document: &Node) -> Result<()> {
    let Some(format) = document.get("format") else {
        return Err(document
            .origin
            .error("the scene has no format; begin it with format = 1"));
    };
    if format.value != Value::Integer(FORMAT) {
        return Err(format.origin.error(format!(
            "format is {}; this version reads scenes of format = {FORMAT}",
            format.value.to_toml()
        )));
    }
    match document.get("environment") {
        Some(environment) => Err(environment
            .origin
            .error("an [environment] is not lit by this version; remove it, and light the scene by [[light]] kind = \"spot\"")),
        None => Ok(()),
    }
}

fn each<T>(root: &Table<'_>, key: &str, read: impl Fn(&Field<'_>) -> Result<T>) -> Result<Vec<T>> {
    match root.get(key) {
        Some(list) => list
            .tables(&format!("[[{key}]]"))?
            .iter()
            .map(read)
            .collect(),
        None => Ok(Vec::new()),
    }
}

fn cloud(field: &Field<'_>) -> Result<SceneCloud> {
    let table = field.table(keys::CLOUD)?;
    let material = table.optional("material", |m| m.table(keys::MATERIAL))?;
    let of_material = |key, allowed, default| match &material {
        Some(m) => Ok::<_, Error>(
            m.optional(key, |f| f.number(allowed))?
                .map_or(default, |v| v as f32),
        ),
        None => Ok(default),
    };
    Ok(SceneCloud {
        source: source(&table)?,
        up_axis: table.optional("up_axis", |f| {
            Ok(if f.choice(&["y", "z"])? == "y" {
                UpAxis::Y
            } else {
                UpAxis::Z
            })
        })?,
        colour_bits: table
            .optional("colour_bits", colour_bits)?
            .unwrap_or_default(),
        transform: table.optional("transform", transform)?,
        specular: of_material("specular", &FRACTION, 0.0)?,
        shininess: of_material("shininess", &SHININESS, 1.0)?,
        mirrors: each(&table, "mirror", rule)?,
    })
}

fn source(table: &Table<'_>) -> Result<CloudSource> {
    let (path, generate) = (table.get("path"), table.get("generate"));
    let generate = match (path, generate) {
        (Some(_), Some(generate)) => {
            return generate.error("stands beside a path; a cloud is read from a file or generated, so remove one of the two");
        }
        (None, None) => {
            let problem = format!(
                "{} needs a path = \"FILE\" or generate = \"sphere\"",
                table.name
            );
            return Err(table.origin().error(problem));
        }
        (Some(path), None) => {
            for key in ["points", "seed", "mesh"] {
                if let Some(field) = table.get(key) {
                    return field.error("is for generated clouds; remove it, or the path");
                }
            }
            return Ok(CloudSource::File(path.path()?));
        }
        (None, Some(generate)) => generate,
    };
    let text = generate.choice(&GeneratedName::ALL.map(|(text, _)| text))?;
    let name = GeneratedName::ALL
        .iter()
        .find(|(t, _)| *t == text)
        .map_or(GeneratedName::Sphere, |(_, name)| *name);
    let mesh = table.get("mesh");
    match (&mesh, name) {
        (None, GeneratedName::Bunny) => {
            return generate.error(
                "is \"bunny\", which needs a mesh; write mesh = \"FILE.ply\" or give --mesh FILE",
            );
        }
        (Some(mesh), name) if name != GeneratedName::Bunny && name != GeneratedName::Multi => {
            return mesh.error(format!(
                "is for generate = \"bunny\" or \"multi\"; {text:?} has none, so remove it"
            ));
        }
        _ => {}
    }
    let points = table.optional("points", |f| f.whole(1, MAX_POINTS as i64))?;
    Ok(CloudSource::Generated {
        name,
        points: points.map_or(DEFAULT_POINTS, |p| p as usize),
        seed: table
            .optional("seed", |f| f.whole(0, i64::MAX))?
            .map_or(DEFAULT_SEED, |s| s as u64),
        mesh: mesh.map(|m| m.path()).transpose()?,
    })
}

fn colour_bits(field: Field<'_>) -> Result<ColourBits> {
    match (field.whole(8, 16), field.text()) {
        (Ok(8), _) => Ok(ColourBits::Eight),
        (Ok(16), _) => Ok(ColourBits::Sixteen),
        (_, Ok("auto")) => Ok(ColourBits::Auto),
        _ => field.must_be("8, 16 or \"auto\""),
    }
}

fn transform(field: Field<'_>) -> Result<DMat4> {
    let what = "16 numbers, row by row";
    let rows = field.list(what)?;
    let numbers = if rows.len() == 4 {
        let rows: Vec<[f64; 4]> = rows
            .iter()
            .map(|r| r.numbers(what, &COORDINATE))
            .collect::<Result<_>>()?;
        rows.into_iter().flatten().collect()
    } else {
        field.numbers::<16>(what, &COORDINATE)?.to_vec()
    };
    let Ok(numbers) = <[f64; 16]>::try_from(numbers) else {
        return field.must_be(what);
    };
    let scene_from_cloud = DMat4::from_cols_array(&numbers).transpose();
    if scene_from_cloud.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
        return field.error("must have 0, 0, 0, 1 as its last row; it moves, turns and scales");
    }
    // The volume of the unit cube against that of a cube with the same edge lengths.
    let axes = [
        scene_from_cloud.x_axis,
        scene_from_cloud.y_axis,
        scene_from_cloud.z_axis,
    ]
    .map(|a| a.truncate());
    let volume = axes[0].cross(axes[1]).dot(axes[2]);
    let largest = axes[0].length() * axes[1].length() * axes[2].length();
    if !volume.is_finite() || volume.abs() <= 1e-9 * largest || volume == 0.0 {
        return field.error("is singular; its first three columns must span space");
    }
    if volume < 0.0 {
        return field.error(
            "mirrors the cloud (negative determinant); only motions and scalings are allowed",
        );
    }
    Ok(scene_from_cloud)
}

fn rule(field: &Field<'_>) -> Result<MirrorRule> {
    let table = field.table(keys::RULE)?;
    let kinds: Vec<&str> = keys::SELECTIONS
        .iter()
        .copied()
        .filter(|k| table.get(k).is_some())
        .collect();
    let one_of = keys::alternatives(keys::SELECTIONS);
    let select = match kinds.as_slice() {
        ["property"] => {
            Select::Property(table.required("property", "\"mirror\"")?.text()?.to_owned())
        }
        ["classification"] => {
            let classes = table
                .required("classification", "[7]")?
                .list("a list of classes, as in [7]")?;
            Select::Classification(
                classes
                    .iter()
                    .map(|c| c.whole(0, 255).map(|c| c as u8))
                    .collect::<Result<_>>()?,
            )
        }
        ["box"] => {
            let corners = table.required("box", "{ min, max }")?.table(keys::BOX)?;
            let min = corners.required("min", "[x, y, z]")?.point()?;
            let max_field = corners.required("max", "[x, y, z]")?;
            let max = max_field.point()?;
            if min.cmpgt(max).any() {
                return max_field.error("is below min; max must be at least min on every axis");
            }
            Select::Box { min, max }
        }
        ["near_plane"] => {
            let plane = table
                .required("near_plane", "{ point, normal, distance }")?
                .table(keys::NEAR_PLANE)?;
            Select::NearPlane {
                point: plane.required("point", "[x, y, z]")?.point()?,
                normal: plane.required("normal", "[x, y, z]")?.direction()?,
                distance: plane.required("distance", "0.02")?.number(&LENGTH)?,
            }
        }
        [] => {
            return Err(table.origin().error(format!(
                "{} must say which points are mirrors, by {one_of}",
                table.name
            )));
        }
        _ => {
            let problem = format!(
                "{} has several of {one_of}; write a [[cloud.mirror]] for each, they add up",
                table.name
            );
            return Err(table.origin().error(problem));
        }
    };
    let reflectance = table
        .optional("reflectance", |f| f.number(&FRACTION))?
        .unwrap_or(1.0) as f32;
    Ok(MirrorRule {
        select,
        reflectance,
    })
}

fn mirror(field: &Field<'_>) -> Result<MirrorShape> {
    // The shape decides which keys there are.
    let all: Vec<&str> = keys::SHAPES
        .iter()
        .flat_map(|(_, keys)| keys.iter().copied())
        .chain(["shape"])
        .collect();
    let names: Vec<&'static str> = keys::SHAPES.iter().map(|(name, _)| *name).collect();
    let shape = field
        .table(&all)?
        .required("shape", "\"sphere\"")?
        .choice(&names)?;
    let own = keys::SHAPES
        .iter()
        .find(|(name, _)| *name == shape)
        .map_or(&[][..], |(_, keys)| keys);
    let known: Vec<&str> = own.iter().copied().chain(["shape"]).collect();
    let table = field.table(&known)?;

    let point = |key| table.required(key, "[x, y, z]")?.point();
    let direction = |key| table.required(key, "[x, y, z]")?.direction();
    let length = |key| table.required(key, "0.5")?.number(&LENGTH);
    Ok(match shape {
        "plane" => {
            let normal = direction("normal")?;
            let up = match table.get("up") {
                Some(up) if up.direction()?.cross(normal).length() < 1e-6 => {
                    return up.error("points along the normal; it must lie across it");
                }
                Some(up) => up.direction()?,
                None => {
                    if normal.y.abs() < 0.9 {
                        DVec3::Y
                    } else {
                        DVec3::Z
                    }
                }
            };
            let size = table
                .required("size", "[width, height]")?
                .numbers("[width, height]", &LENGTH)?;
            let up = up.reject_from_normalized(normal).normalize_or(up);
            MirrorShape::Plane {
                centre: point("centre")?,
                normal,
                up,
                size: DVec2::from_array(size),
            }
        }
        "sphere" => MirrorShape::Sphere {
            centre: point("centre")?,
            radius: length("radius")?,
        },
        "paraboloid" => MirrorShape::Paraboloid {
            vertex: point("vertex")?,
            axis: direction("axis")?,
            focal_length: length("focal_length")?,
            rim_radius: length("rim_radius")?,
        },
        "torus" => {
            let (major_radius, minor_radius) = (length("major_radius")?, length("minor_radius")?);
            if minor_radius >= major_radius {
                return table
                    .required("minor_radius", "0.1")?
                    .error("must be less than major_radius");
            }
            MirrorShape::Torus {
                centre: point("centre")?,
                axis: direction("axis")?,
                major_radius,
                minor_radius,
            }
        }
        "blob" => MirrorShape::Blob {
            centre: point("centre")?,
            radius: length("radius")?,
            amplitude: table
                .optional("amplitude", |f| f.number(&AMPLITUDE))?
                .unwrap_or(0.25),
        },
        "bumps" => MirrorShape::Bumps {
            centre: point("centre")?,
            radius: length("radius")?,
        },
        _ => MirrorShape::Mesh {
            path: table.required("path", "\"FILE.ply\"")?.path()?,
        },
    })
}

fn light(field: &Field<'_>) -> Result<SceneLight> {
    let table = field.table(keys::LIGHT)?;
    let kind = table.required("kind", "\"spot\"")?;
    if kind.choice(&["spot", "point"])? == "point" {
        return kind.error(
            "is \"point\", which this version does not light; the kinds there are: \"spot\"",
        );
    }
    let position = table.required("position", "[x, y, z]")?.point()?;
    let target_field = table.required("target", "[x, y, z]")?;
    let target = target_field.point()?;
    if (target - position).try_normalize().is_none() {
        return target_field.error("is the light's position; it must be what the light points at");
    }
    let intensity = table
        .required("intensity", "[6, 6, 6]")?
        .numbers("[red, green, blue]", &AMOUNT)?;
    let outer_field = table.get("outer_angle_degrees");
    let outer = outer_field
        .as_ref()
        .map(|f| f.number(&HALF_ANGLE))
        .transpose()?;
    let inner = table.optional("inner_angle_degrees", |f| f.number(&HALF_ANGLE))?;
    // One angle alone sets the other, so that it cannot contradict a default.
    let (inner, outer) = match (inner, outer) {
        (Some(inner), Some(outer)) => (inner, outer),
        (Some(inner), None) => (inner, inner.max(35.0)),
        (None, Some(outer)) => (outer.min(25.0), outer),
        (None, None) => (25.0, 35.0),
    };
    if let Some(field) = outer_field
        && (outer < inner || outer == 0.0)
    {
        return field.error(format!(
            "is {outer}; it must be above 0 and at least the inner angle, which is {inner}"
        ));
    }
    Ok(SceneLight {
        position,
        target,
        intensity: Vec3::from_array(intensity.map(|i| i as f32)),
        inner_angle: inner.to_radians(),
        outer_angle: outer.to_radians(),
    })
}

fn camera(field: &Field<'_>) -> Result<SceneCamera> {
    let table = field.table(keys::CAMERA)?;
    let point = |key| table.optional(key, |f| f.point());
    let length = |key| table.optional(key, |f| f.number(&LENGTH));
    let size = |f: Field<'_>| {
        let sides = f.list("[width, height]")?;
        let sides: Vec<i64> = sides
            .iter()
            .map(|s| s.whole(1, i64::from(MAX_SIZE)))
            .collect::<Result<_>>()?;
        match sides.as_slice() {
            [width, height] => Ok(UVec2::new(*width as u32, *height as u32)),
            _ => f.must_be("[width, height]"),
        }
    };
    Ok(SceneCamera {
        position: point("position")?,
        target: point("target")?,
        up: table.optional("up", |f| f.direction())?,
        fov_y_degrees: table.optional("fov_y_degrees", |f| f.number(&FIELD_OF_VIEW))?,
        near: length("near")?,
        far: length("far")?,
        size: table.optional("size", size)?,
        origin: table.last_origin().clone(),
    })
}
