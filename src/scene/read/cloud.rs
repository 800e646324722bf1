//! Reading `[[cloud]]`: where points come from, where they go, and which of them are mirrors.

use glam::{DMat4, DVec3};

use super::each;
use crate::cloud::generate::{DEFAULT_POINTS, MAX_POINTS, SceneName};
use crate::cloud::{Bounds, ColourBits, ColourBy, MirrorRule, Select, UpAxis, transform_fault};
use crate::error::{Error, Result};
use crate::scene::reader::{COORDINATE, FRACTION, Field, LENGTH, SHININESS, Table};
use crate::scene::{CloudSource, DEFAULT_SEED, SceneCloud, keys};

/// One `[[cloud]]`.
pub(super) fn read(field: &Field<'_>) -> Result<SceneCloud> {
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
        colour: table.optional("colour", colour)?.unwrap_or_default(),
        visible: table.optional("visible", |f| f.truth())?.unwrap_or(true),
        viewpoint: table.optional("viewpoint", |f| f.point())?,
    })
}

/// A box of which both corners are given.
fn corners(field: &Field<'_>) -> Result<Bounds> {
    let corners = field.table(keys::BOX)?;
    let min = corners.required("min", "[x, y, z]")?.point()?;
    let max_field = corners.required("max", "[x, y, z]")?;
    let max = max_field.point()?;
    if min.cmpgt(max).any() {
        return max_field.error("is below min; max must be at least min on every axis");
    }
    Ok(Bounds { min, max })
}

/// The `[clip]`: sides that are not given are infinite.
pub(in crate::scene) fn clip(field: &Field<'_>) -> Result<Bounds> {
    let table = field.table(keys::BOX)?;
    let min = table.optional("min", |f| f.point())?;
    let max = table.optional("max", |f| f.point())?;
    let bounds = Bounds {
        min: min.unwrap_or(DVec3::NEG_INFINITY),
        max: max.unwrap_or(DVec3::INFINITY),
    };
    if bounds.is_empty() {
        let origins = table.origins();
        return Err(origins.to_blame(&["max", "min"]).error(format!(
            "{}.max is below {}.min; max must be at least min on every axis",
            table.name, table.name
        )));
    }
    Ok(bounds)
}

fn colour(field: Field<'_>) -> Result<ColourBy> {
    let word = field.choice(&ColourBy::ALL.map(ColourBy::name))?;
    let named = ColourBy::ALL.into_iter().find(|by| by.name() == word);
    Ok(named.unwrap_or_default())
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
    let text = generate.choice(&SceneName::ALL.map(SceneName::name))?;
    let name: SceneName = text.parse()?;
    let mesh = table.get("mesh");
    match (&mesh, name) {
        (None, SceneName::Bunny) => {
            return generate.error(
                "is \"bunny\", which needs a mesh; write mesh = \"FILE.ply\" or give --mesh FILE",
            );
        }
        (Some(mesh), name) if name != SceneName::Bunny && name != SceneName::Multi => {
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
    if let Some(fault) = transform_fault(&scene_from_cloud) {
        return field.error(fault);
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
            let Bounds { min, max } = corners(&table.required("box", "{ min, max }")?)?;
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
                within: plane.optional("within", |f| corners(&f))?,
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
