//! `catoptric info`: what is in a scene or a cloud, and what would run; or every setting there is.

use std::io::Write as _;

use catoptric::cloud::{Bounds, CloudFacts, Facts, Repairs};
use catoptric::plan::{Plan, Row, State};
use catoptric::scene::{LoadedScene, Scene};
use catoptric::settings::{Description, Settings};
use catoptric::text::printable;
use glam::DVec3;
use serde_json::json;

use super::args::{InfoArgs, SceneArgs, ViewArgs};
use super::terminal;

/// Prints to stdout.
pub(super) fn info(args: &InfoArgs) -> anyhow::Result<()> {
    let text = match &args.scene {
        Some(scene) => of_scene(scene, args.json)?,
        None if args.json => serde_json::to_string_pretty(&settings_as_json())?,
        None => settings_as_text(),
    };
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}", text.trim_end())?;
    out.flush()?;
    Ok(())
}

fn of_scene(args: &SceneArgs, as_json: bool) -> anyhow::Result<String> {
    let (job, progress) = terminal::job()?;
    let scene = Scene::open(&args.path, &args.overrides(&ViewArgs::default())?)?;
    let loaded = scene.load(&job)?;
    drop(progress);
    let plan = loaded.plan(&scene.settings);
    if as_json {
        Ok(serde_json::to_string_pretty(&as_json_value(
            &scene, &loaded, &plan,
        ))?)
    } else {
        Ok(as_text(&scene, &loaded, &plan))
    }
}

fn as_json_value(scene: &Scene, loaded: &LoadedScene, plan: &Plan) -> serde_json::Value {
    let camera = &loaded.camera;
    let changed: std::collections::BTreeMap<String, toml::Value> =
        scene.settings.changed().into_iter().collect();
    json!({
        "format": 1,
        "version": env!("CARGO_PKG_VERSION"),
        "scene": scene.file.display().to_string(),
        "facts": loaded.facts,
        "up_axis": loaded.up_axis,
        "lights": scene.lights.len(),
        "camera": {
            "position": camera.position,
            "target": camera.target,
            "up": camera.up,
            "fov_y_degrees": camera.fov_y_degrees,
            "near": camera.near,
            "far": camera.far,
            "size": camera.size,
        },
        "settings": changed,
        "plan": plan,
    })
}

fn as_text(scene: &Scene, loaded: &LoadedScene, plan: &Plan) -> String {
    let Facts {
        points,
        bounds,
        spacing,
        origin,
        repairs,
        mirror_points,
        has_specular,
        clouds,
    } = &loaded.facts;
    let mut lines = vec![printable(&scene.file.display().to_string())];
    for cloud in clouds {
        lines.push(String::new());
        lines.extend(of_cloud(cloud));
    }
    let camera = &loaded.camera;
    let decimals = decimals_of(*bounds);
    let at = |p: DVec3| rounded(p, decimals).to_string();
    lines.push(String::new());
    lines.extend([
        row(
            "points",
            &format!("{points}, of which {mirror_points} mirror"),
        ),
        row(
            "bounds",
            &format!("{} to {}", at(bounds.min), at(bounds.max)),
        ),
        row("size", &at(bounds.size())),
        row("spacing", &format!("{spacing:.4} (median)")),
        row("origin", &at(*origin)),
        row(
            "specular",
            if *has_specular { "some points" } else { "none" },
        ),
        row("repairs", &of_repairs(repairs)),
        row("lights", &scene.lights.len().to_string()),
        row("up axis", &format!("{:?}", loaded.up_axis).to_lowercase()),
        row(
            "camera",
            &format!(
                "at {} to {}, {} degrees, {}x{} pixels",
                at(camera.position),
                at(camera.target),
                camera.fov_y_degrees,
                camera.size.x,
                camera.size.y
            ),
        ),
        row(
            "planes",
            &format!("near {:.6}, far {:.6}", camera.near, camera.far),
        ),
    ]);
    for (key, value) in scene.settings.changed() {
        lines.push(row("setting", &format!("{key} = {value}")));
    }
    lines.extend([String::new(), "what runs".to_owned()]);
    lines.extend(plan.rows.iter().map(of_stage));
    lines.join("\n")
}

/// Decimals that show a millionth of the box, 0 to 9.
fn decimals_of(bounds: Bounds) -> i32 {
    let size = bounds.size().max_element();
    if size > 0.0 {
        (6 - size.log10().ceil() as i32).clamp(0, 9)
    } else {
        6
    }
}

fn rounded(p: DVec3, decimals: i32) -> DVec3 {
    let scale = 10f64.powi(decimals);
    // The sum makes -0 a 0.
    (p * scale).round() / scale + 0.0
}

fn of_cloud(cloud: &CloudFacts) -> Vec<String> {
    let have = [
        (cloud.has_colour, "colour"),
        (cloud.has_normals, "normals"),
        (cloud.has_intensity, "intensity"),
    ];
    let has: Vec<&str> = have
        .iter()
        .filter(|(has, _)| *has)
        .map(|(_, name)| *name)
        .collect();
    let has = if has.is_empty() {
        "positions only".to_owned()
    } else {
        has.join(", ")
    };
    let mut lines = vec![
        row("cloud", &printable(&cloud.name)),
        row("format", &printable(&cloud.format)),
        row("points", &cloud.points.to_string()),
        row("has", &has),
    ];
    if !cloud.column_names.is_empty() {
        lines.push(row("fields", &printable(&cloud.column_names.join(", "))));
    }
    if let Some(unit) = &cloud.unit {
        lines.push(row("unit", &printable(unit)));
    }
    lines
}

fn of_repairs(repairs: &Repairs) -> String {
    let done = repairs.sentences();
    if done.is_empty() {
        "none needed".into()
    } else {
        done.join("; ")
    }
}

fn of_stage(stage: &Row) -> String {
    let name = serde_json::to_value(stage.stage)
        .ok()
        .and_then(|v| v.as_str().map(str::to_owned))
        .unwrap_or_default();
    let (state, reason) = match &stage.state {
        State::Run(reason) => ("runs", reason),
        State::IfMirrorSeen(reason) => ("runs if a mirror is seen", reason),
        State::Skip(reason) => ("skipped", reason),
    };
    row(&name, &format!("{state}: {reason}"))
}

fn row(name: &str, value: &str) -> String {
    format!("  {name:<12} {value}")
}

fn settings_as_text() -> String {
    let lines: Vec<String> = Settings::describe()
        .iter()
        .map(|d| format!("{} = {}\n    {}{}\n", d.key, d.default, d.doc, range_of(d)))
        .collect();
    lines.join("\n")
}

fn range_of(description: &Description) -> String {
    let unit = if description.unit.is_empty() {
        String::new()
    } else {
        format!(" {}", description.unit)
    };
    match (description.range, description.choices) {
        (Some((low, high)), _) => format!("\n    {low} to {high}{unit}"),
        (None, choices) if !choices.is_empty() => format!("\n    one of: {}", choices.join(", ")),
        (None, _) => String::new(),
    }
}

fn settings_as_json() -> Vec<serde_json::Value> {
    let as_json = |d: Description| {
        json!({
            "key": d.key, "doc": d.doc, "unit": d.unit, "range": d.range, "choices": d.choices, "default": d.default,
        })
    };
    Settings::describe().into_iter().map(as_json).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_shown_to_a_millionth_of_the_box() {
        let around = |size: f64| Bounds {
            min: DVec3::splat(1.0 / 3.0),
            max: DVec3::splat(1.0 / 3.0 + size),
        };
        for (size, expected) in [
            (2000.0, "[0.33, -0.33, 0]"),
            (2.0, "[0.33333, -0.33333, 0]"),
            (1e9, "[0, 0, 0]"),
            (0.0, "[0.333333, -0.333333, 0]"),
        ] {
            let p = DVec3::new(1.0 / 3.0, -1.0 / 3.0, -1e-12);
            let got = rounded(p, decimals_of(around(size))).to_string();
            assert_eq!(got, expected, "in a box of {size}");
        }
    }
}
