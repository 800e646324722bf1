//! From the document's tree to the plain data of a scene.

use std::path::Path;

use super::reader::{Field, Table};
use super::tree::{Node, Origins, Value};
use super::{FORMAT, Override, Scene, SceneCamera, keys, settings};
use crate::error::Result;

mod cloud;
mod mirror;
mod view;

/// Reads the scene that `document` holds, once `overrides` have taken their places in it.
pub(super) fn scene(document: Node, path: &Path, overrides: &[Override]) -> Result<Scene> {
    check_format(&document)?;
    for (index, given) in overrides.iter().enumerate() {
        // What a later one beats must be sound all the same: it is read as if it were the last of its key.
        let rest = overrides.get(index + 1..).unwrap_or_default();
        if rest.iter().any(|later| later.key() == given.key()) {
            let others = overrides.iter().filter(|other| other.key() != given.key());
            let alone = overridden(document.clone(), path, others.chain([given]));
            if let Err(refusal) = alone
                && given.is_blamed_by(&refusal)
            {
                return Err(refusal);
            }
        }
    }
    overridden(document, path, overrides.iter())
}

fn overridden<'a>(
    mut document: Node,
    path: &Path,
    overrides: impl Iterator<Item = &'a Override>,
) -> Result<Scene> {
    for given in overrides {
        given.apply(&mut document)?;
    }
    let root = Table::open(&document, "", keys::ROOT)?;
    let clouds = each(&root, "cloud", cloud::read)?;
    if clouds.is_empty() {
        return Err(document
            .origin
            .error("the scene has no cloud; add [[cloud]] with a path"));
    }
    Ok(Scene {
        file: path.to_owned(),
        clouds,
        mirrors: each(&root, "mirror", mirror::read)?,
        lights: each(&root, "light", view::light)?,
        environment: root.optional("environment", |field| view::environment(&field))?,
        clip: root.optional("clip", |field| cloud::clip(&field))?,
        camera: match root.get("camera") {
            Some(field) => view::camera(&field)?,
            None => SceneCamera::unstated(Origins::of_table(document.origin.clone())),
        },
        settings: settings::read(document.get("settings"))?,
    })
}

/// Refuses another version before any of its keys are found to be unknown.
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
    Ok(())
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
