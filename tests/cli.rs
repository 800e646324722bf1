//! The program's manners: exit status, messages, help, interrupts.

use std::process::{Command, Stdio};

use libtest_mimic::Trial;
use serde_json::Value;

use crate::program::{ROOM, done, json, names, program, refused, room, run, stderr};
use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "cli::help_tells_units_defaults_and_where_the_settings_are",
            help_tells_what_there_is,
        ),
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
        claim(
            "cli::generate_asks_for_its_folder_first_and_says_what_it_wrote",
            generate_asks_first,
        ),
        claim("cli::info_counts_and_plans", info_counts_and_plans),
        claim("cli::info_lists_every_setting", info_lists_every_setting),
        claim(
            "cli::a_reader_that_leaves_is_no_failure",
            a_reader_that_leaves,
        ),
        claim(
            "cli::names_cannot_steer_the_terminal",
            names_cannot_steer_the_terminal,
        ),
        claim(
            "cli::a_pipe_in_place_of_a_file_does_not_hang",
            a_pipe_does_not_hang,
        )
        .with_ignored_flag(cfg!(not(unix))),
        claim(
            "cli::an_interrupt_cancels_and_writes_nothing",
            an_interrupt_cancels,
        )
        .with_ignored_flag(cfg!(not(unix))),
    ]
}

fn help_tells_what_there_is() {
    let folder = room();
    let help = done(folder.path(), "render --help");
    for word in [
        "info --settings",
        "W/sr/m2",
        "degrees",
        "pixels",
        "default",
        "Examples",
        "#rrggbb",
        "--camera-json",
        "--search-heat",
    ] {
        assert!(help.contains(word), "render --help lacks {word:?}");
    }
    assert!(
        done(folder.path(), "--help").contains("Exit status"),
        "--help tells the exit status"
    );
    assert!(
        done(folder.path(), "--help").contains("No light is"),
        "--help tells that no light is chosen"
    );
    assert!(
        done(folder.path(), "generate --help").contains("1600000"),
        "generate --help tells the default"
    );
    assert_eq!(
        done(folder.path(), "--version").trim(),
        concat!("catoptric ", env!("CARGO_PKG_VERSION")),
        "the version"
    );
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

fn generate_asks_first() {
    let folder = room();
    for place in ["room.toml", "room.toml/in"] {
        let said = refused(
            folder.path(),
            &format!("generate sphere -o {place} --points 4000000"),
            2,
        );
        assert!(
            said.contains("room.toml is a file") && said.contains("another place"),
            "{said}"
        );
    }
    let output = run(folder.path(), "generate sphere -o a/b --points 100");
    assert_eq!(
        (output.status.code(), stderr(&output).as_str()),
        (
            Some(0),
            "catoptric: wrote a/b/sphere.ply and a/b/sphere.toml\n"
        )
    );
    assert_eq!(
        names(&folder.path().join("a/b")),
        ["sphere.ply", "sphere.toml"]
    );
}

fn info_counts_and_plans() {
    let folder = room();
    let text = done(folder.path(), "info room.toml");
    for word in [
        "20000",
        "mirror",
        "[-1, -1, -3] to [1, 1, 1]",
        "what runs",
        "splat",
        "shade",
        "skipped",
        "up axis      y",
    ] {
        assert!(text.contains(word), "info lacks {word:?}: {text}");
    }
    let info: Value = serde_json::from_str(&done(
        folder.path(),
        "info room.toml --json --set splat.size=2",
    ))
    .expect("JSON");
    assert_eq!(info["facts"]["points"], 20_000, "{info}");
    assert_eq!(info["settings"]["splat.size"], 2.0, "{info}");
    assert_eq!(info["plan"][0]["stage"], "splat", "{info}");
    assert!(
        info["facts"]["mirror_points"].as_u64() > Some(500),
        "{info}"
    );
}

fn info_lists_every_setting() {
    let folder = room();
    let text = done(folder.path(), "info --settings");
    let listed: Value =
        serde_json::from_str(&done(folder.path(), "info --settings --json")).expect("JSON");
    let described = catoptric::settings::Settings::describe();
    assert_eq!(
        listed.as_array().map(Vec::len),
        Some(described.len()),
        "{listed}"
    );
    for description in described {
        assert!(
            text.contains(&format!("{} = {}", description.key, description.default)),
            "{} is missing",
            description.key
        );
        assert!(
            text.contains(&description.doc),
            "the doc of {} is missing",
            description.key
        );
    }
}

fn a_reader_that_leaves() {
    let folder = room();
    for arguments in ["info --settings", "info room.toml", "render --help"] {
        let mut child = program(folder.path(), arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it runs");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(
            (output.status.code(), stderr(&output).as_str()),
            (Some(0), ""),
            "{arguments}"
        );
    }
}

fn names_cannot_steer_the_terminal() {
    let folder = room();
    let steering = "a\u{1b}[2Jb\u{202e}.toml";
    let output = Command::new(env!("CARGO_BIN_EXE_catoptric"))
        .arg("info")
        .arg(folder.path().join(steering))
        .output()
        .expect("it runs");
    let said = stderr(&output);
    assert!(
        said.contains("\\u{1b}[2J") && !said.contains('\u{1b}') && !said.contains('\u{202e}'),
        "{said:?}"
    );
    let scene = ROOM.replace("points = 20000", "\"\\u001b[31m\" = 1");
    std::fs::write(folder.path().join("red.toml"), scene).expect("a scene");
    let said = refused(folder.path(), "info red.toml", 1);
    assert!(!said.contains('\u{1b}'), "{said:?}");
}

fn a_pipe_does_not_hang() {
    let folder = room();
    for name in ["pipe.toml", "pipe.ply"] {
        let made = Command::new("mkfifo")
            .arg(folder.path().join(name))
            .status()
            .expect("mkfifo runs");
        assert!(made.success(), "a pipe");
        refused(folder.path(), &format!("render {name} -o a.png"), 1);
    }
}

fn an_interrupt_cancels() {
    let folder = room();
    let arguments =
        "render room.toml --backend cpu -o a.png --set cloud.0.points=8000000 --size 6000x4000";
    // On a busy machine the program may not yet listen; then it is ended by the signal, and is given more time.
    for delay_ms in [200, 800, 3200] {
        let child = program(folder.path(), arguments)
            .stderr(Stdio::piped())
            .spawn()
            .expect("it runs");
        std::thread::sleep(std::time::Duration::from_millis(delay_ms));
        let interrupt = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status()
            .expect("kill runs");
        assert!(
            interrupt.success(),
            "the program still ran when it was interrupted"
        );
        let output = child.wait_with_output().expect("it ends");
        assert_eq!(
            names(folder.path()),
            ["room.toml"],
            "nothing is left behind"
        );
        if let Some(status) = output.status.code() {
            assert_eq!(status, 1, "{}", stderr(&output));
            assert!(
                stderr(&output).contains("cancelled; nothing was written"),
                "{}",
                stderr(&output)
            );
            return;
        }
    }
    panic!("it never listened");
}
