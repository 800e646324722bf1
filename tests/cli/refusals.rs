//! What is refused, and what is dropped: exit status and messages.

use std::process::Command;

use libtest_mimic::Trial;

use crate::program::{json, names, refused, room, run, stderr};
use crate::support::claim;

pub(super) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "cli::wrong_usage_ends_with_2_and_a_remedy",
            wrong_usage_ends_with_2,
        ),
        claim(
            "cli::failures_end_with_1_and_leave_nothing",
            failures_end_with_1,
        ),
        claim(
            "cli::outputs_are_refused_before_any_work",
            outputs_are_refused_first,
        ),
        claim(
            "cli::what_is_dropped_or_changed_is_said",
            what_is_dropped_is_said,
        ),
        claim(
            "cli::a_cloud_beyond_all_measure_has_no_points",
            a_cloud_beyond_all_measure,
        ),
    ]
}

fn wrong_usage_ends_with_2() {
    let folder = room();
    for (arguments, says) in [
        ("", "--help"),
        ("rendr", "render"),
        ("render", "SCENE|CLOUD"),
        ("render room.toml --sise 3x3", "--size"),
        ("render room.toml --set splat.sise=2", "\"splat.size\""),
        ("render room.toml --set splat.size=huge", "0.1 to 16"),
        (
            "render room.toml --set light.1.intensity=1,1,1",
            "light.0 only",
        ),
        ("render room.toml --set splat.size", "key=value"),
        ("render room.toml --size 0x3", "from 1 to 32768"),
        ("render room.toml --size wide", "[width, height]"),
        ("render room.toml --eye 1,2", "[x, y, z]"),
        (
            "render room.toml --eye 0,0,0.9 --target 0,0,0.9",
            "camera.target",
        ),
        ("render room.toml --fov 180", "178.9"),
        ("render room.toml --background red", "#rrggbb"),
        ("render room.toml --mesh a.ply", "bunny"),
        ("render room.toml --backend tpu", "cpu"),
        (
            "render room.toml --backend cpu --adapter A",
            "leave one out",
        ),
        ("info", "name a scene or a point cloud"),
        ("info --json", "name a scene or a point cloud"),
        (
            "render room.toml --set camera.near=20 --set camera.far=10 --size 80x60",
            "camera.near=20: camera.near",
        ),
        (
            "render room.toml --set light.0.inner_angle_degrees=40 --set light.0.outer_angle_degrees=30",
            "light.0.outer_angle_degrees",
        ),
        (
            "render room.toml --set light.0.outer_angle_degrees=85",
            "from 0 to 80",
        ),
        (
            "render room.toml --set camera.size=0x0 --size 80x60",
            "--set camera.size=0x0",
        ),
        (
            "render room.toml --set environment.colour=1,1,1 --set environment.map=sky.exr",
            "both colour and map",
        ),
        ("generate sphre", "sphere"),
        ("generate bunny", "mesh"),
        ("generate sphere --points 0", "1 to"),
        ("generate sphere --points many", "many"),
    ] {
        let said = refused(folder.path(), arguments, 2);
        assert!(
            said.contains(says),
            "{arguments} says {said:?}, and not {says:?}"
        );
    }
    let output = Command::new(env!("CARGO_BIN_EXE_catoptric"))
        .current_dir(folder.path())
        .args(["render", "room.toml", "-o", ""])
        .output()
        .expect("it runs");
    assert_eq!(
        (output.status.code(), stderr(&output).as_str()),
        (
            Some(2),
            "catoptric: a value is required for '--output <FILE>' but none was supplied; see catoptric --help\n"
        )
    );
    assert_eq!(names(folder.path()), ["room.toml"], "nothing is written");
}

fn failures_end_with_1() {
    let folder = room();
    let write =
        |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
    write(
        "unknown.toml",
        "format = 1\n[[cloud]]\npath = \"a.ply\"\ncolor = 3\n",
    );
    write(
        "missing.toml",
        "format = 1\n[[cloud]]\npath = \"nowhere.ply\"\n",
    );
    write("empty.ply", "");
    write(
        "broken.ply",
        "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n",
    );
    write("notes.txt", "these are no points");
    let before = names(folder.path());
    for (arguments, says) in [
        ("render unknown.toml -o a.png", "unknown.toml:4"),
        ("render missing.toml -o a.png", "nowhere.ply"),
        ("render nowhere.toml -o a.png", "nowhere.toml"),
        ("render empty.ply -o a.png", "empty"),
        ("render broken.ply -o a.png", "broken.ply"),
        ("render notes.txt -o a.png", "PLY"),
        ("render . -o a.png", "folder"),
        ("info broken.ply", "broken.ply"),
        ("info missing.toml --json", "nowhere.ply"),
        ("generate bunny --mesh notes.txt", "notes.txt"),
    ] {
        let said = refused(folder.path(), arguments, 1);
        assert!(
            said.contains(says),
            "{arguments} says {said:?}, and not {says:?}"
        );
    }
    assert_eq!(names(folder.path()), before, "nothing is left behind");
}

fn outputs_are_refused_first() {
    let folder = room();
    // Were the cloud looked at, it would be the one complained of.
    let scene = "format = 1\n[[cloud]]\npath = \"points.exr\"\n";
    std::fs::write(folder.path().join("scene.toml"), scene).expect("a scene");
    for (arguments, status, says) in [
        ("render scene.toml -o a.jpg", 2, ".png or .exr"),
        ("render scene.toml -o a", 2, ".png or .exr"),
        ("render scene.toml -o a.png --gbuffer g.png", 2, ".exr"),
        ("render scene.toml -o a.png --report r.png", 2, ".json"),
        (
            "render scene.toml -o a.exr --gbuffer ./a.exr",
            2,
            "both write",
        ),
        (
            "render scene.toml --report r.json --camera-json ../$/r.json",
            2,
            "both write",
        ),
        ("render scene.toml -o points.exr", 2, "overwrite"),
        ("render scene.toml --report ./scene.toml", 2, ".json"),
        ("render scene.toml --report r.txt", 2, ".json"),
        ("render scene.toml -o nowhere/a.png", 1, "nowhere/a.png"),
    ] {
        let name = folder
            .path()
            .file_name()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        let said = refused(folder.path(), &arguments.replace('$', &name), status);
        assert!(
            said.contains(says),
            "{arguments} says {said:?}, and not {says:?}"
        );
    }
    assert_eq!(
        names(folder.path()),
        ["room.toml", "scene.toml"],
        "nothing is written"
    );
    assert_eq!(
        std::fs::read_to_string(folder.path().join("scene.toml")).expect("the scene"),
        scene,
        "nor overwritten"
    );
}

/// An ascii cloud of these points.
fn write_points(folder: &std::path::Path, name: &str, properties: &str, points: &[&str]) {
    let text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         {properties}end_header\n{}\n",
        points.len(),
        points.join("\n")
    );
    std::fs::write(folder.join(name), text).expect("a cloud");
}

fn what_is_dropped_is_said() {
    let folder = room();
    let arguments =
        |cloud: &str| format!("render {cloud} --backend cpu --size 16x12 -o a.png --report a.json");
    let normals = "property float nx\nproperty float ny\nproperty float nz\n";
    write_points(
        folder.path(),
        "holes.ply",
        normals,
        &[
            "0 0 0 0 0 1",
            "nan 0 0 0 0 1",
            "1e300 0 0 0 0 1",
            "0 inf 0 0 0 1",
            "1 0 0 0 0 0",
            "0 1 0 0 0 1",
        ],
    );
    let output = run(folder.path(), &arguments("holes.ply"));
    assert_eq!(
        (output.status.code(), stderr(&output).as_str()),
        (
            Some(0),
            "catoptric: 3 points without finite coordinates up to 1e15 were dropped; 1 normal was estimated anew\n"
        )
    );
    let report = json(&folder.path().join("a.json"));
    assert_eq!(report["repairs"]["not_finite"], 3, "{report}");
    assert_eq!(report["repairs"]["normals"], 1, "{report}");

    // What a file does not have is no repair.
    write_points(folder.path(), "bare.ply", "", &["0 0 0", "1 0 0", "0 1 0"]);
    let output = run(folder.path(), &arguments("bare.ply"));
    assert_eq!(
        (output.status.code(), stderr(&output).as_str()),
        (Some(0), "")
    );
    let report = json(&folder.path().join("a.json"));
    assert_eq!(report["repairs"]["normals"], 0, "{report}");
}

fn a_cloud_beyond_all_measure() {
    let folder = room();
    for far in ["1e300", "1e38", "nan"] {
        write_points(
            folder.path(),
            "far.ply",
            "",
            &[&format!("{far} 0 0"), &format!("-{far} 0 0")],
        );
        let said = refused(folder.path(), "render far.ply -o a.png --size 80x60", 1);
        assert!(
            said.contains("no points left") && said.contains("2 have no finite coordinates"),
            "{said}"
        );
    }
}
