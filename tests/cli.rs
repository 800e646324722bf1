//! The program itself: exit status, messages, files.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use libtest_mimic::Trial;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::claim;

/// A small room, 64 x 48 pixels.
const ROOM: &str = r#"format = 1
[[cloud]]
generate = "sphere"
points = 20000
[[cloud.mirror]]
property = "mirror"
[[light]]
kind = "spot"
position = [-0.6, 0.9, 0.2]
target = [1, -1, -3]
intensity = [6, 6, 6]
[camera]
position = [0, 0, 0.9]
size = [64, 48]
"#;

pub(crate) fn tests() -> Vec<Trial> {
    let scans = std::env::var_os("CATOPTRIC_SCANS").map(PathBuf::from);
    let no_scans = scans.is_none();
    vec![
        claim(
            "cli::help_tells_units_defaults_and_where_the_settings_are",
            help_tells_what_there_is,
        ),
        claim(
            "cli::a_scene_becomes_every_kind_of_file",
            a_scene_becomes_files,
        ),
        claim("cli::the_same_scene_gives_the_same_bytes", the_same_bytes),
        claim("cli::flags_beat_set_which_beats_the_file", flags_beat_set),
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
        claim("cli::a_picture_can_go_to_stdout", a_picture_to_stdout),
        claim(
            "cli::a_picture_without_a_name_is_called_after_its_scene",
            an_unnamed_picture,
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
            "cli::generate_writes_a_scene_that_renders",
            generate_writes_a_scene,
        ),
        claim("cli::mirrors_are_put_into_a_cloud", mirrors_are_put_in),
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
        Trial::test("cli::scans_render_without_a_scene", move || {
            scans_render(scans.as_deref().unwrap_or(Path::new("")));
            Ok(())
        })
        .with_ignored_flag(no_scans),
    ]
}

/// A folder with the small room in it.
fn room() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("room.toml"), ROOM).expect("a scene");
    folder
}

fn program(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_catoptric"));
    command
        .current_dir(folder)
        .args(arguments.split_whitespace())
        .stdin(Stdio::null());
    command
}

fn run(folder: &Path, arguments: &str) -> Output {
    program(folder, arguments)
        .output()
        .expect("the program runs")
}

/// Runs what must succeed; gives stdout.
fn done(folder: &Path, arguments: &str) -> String {
    let output = run(folder, arguments);
    assert_eq!(
        output.status.code(),
        Some(0),
        "{arguments}: {}",
        stderr(&output)
    );
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Runs what must be refused with `status`; gives the sentence.
fn refused(folder: &Path, arguments: &str, status: i32) -> String {
    let output = run(folder, arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(status), "{arguments}: {said}");
    assert!(
        said.starts_with("catoptric: ") && said.trim_end().lines().count() == 1,
        "{arguments} says {said:?}"
    );
    said
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> = entries
        .map(|e| {
            e.expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    names
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).expect("the file")).expect("JSON")
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
    ] {
        assert!(help.contains(word), "render --help lacks {word:?}");
    }
    assert!(
        done(folder.path(), "--help").contains("Exit status"),
        "--help tells the exit status"
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

fn a_scene_becomes_files() {
    let folder = room();
    let at = |name: &str| folder.path().join(name);
    done(
        folder.path(),
        "render room.toml --backend cpu -o a.png --gbuffer g.exr --camera-json c.json --report r.json",
    );
    done(folder.path(), "render room.toml --backend cpu -o a.exr");
    assert_eq!(
        names(folder.path()),
        ["a.exr", "a.png", "c.json", "g.exr", "r.json", "room.toml"],
        "and nothing else"
    );
    let image = image::open(at("a.png")).expect("a picture").to_rgb8();
    assert_eq!(image.dimensions(), (64, 48), "the size of the scene");
    assert!(
        image.pixels().any(|p| p.0.iter().any(|&c| c > 64)),
        "the picture shows something"
    );
    let report = json(&at("r.json"));
    assert_eq!(
        (&report["format"], &report["backend"]),
        (&Value::from(1), &Value::from("cpu")),
        "{report}"
    );
    assert_eq!(
        (&report["points"], &report["size"]),
        (&Value::from(20_000), &serde_json::json!([64, 48])),
        "{report}"
    );
    assert!(
        report["gbuffer"]["coverage_filled"].as_f64() > Some(0.99),
        "{report}"
    );
    assert_eq!(
        json(&at("c.json"))["size"],
        serde_json::json!([64, 48]),
        "the camera has the picture's size"
    );
}

fn the_same_bytes() {
    let folder = room();
    for name in ["a.png", "b.png"] {
        done(
            folder.path(),
            &format!("render room.toml --backend cpu -o {name}"),
        );
    }
    done(
        folder.path(),
        "render room.toml --backend cpu -o c.png --set splat.size=2",
    );
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).expect("a picture");
    assert!(
        bytes("a.png") == bytes("b.png"),
        "two runs of one scene differ"
    );
    assert!(
        bytes("a.png") != bytes("c.png"),
        "another setting makes another picture"
    );
}

fn flags_beat_set() {
    let folder = room();
    let size = |arguments: &str| {
        done(
            folder.path(),
            &format!("render room.toml --backend cpu --report r.json {arguments}"),
        );
        let report = json(&folder.path().join("r.json"));
        (report["size"][0].as_u64(), report["settings"].clone())
    };
    assert_eq!(size("").0, Some(64), "the file");
    assert_eq!(
        size("--set camera.size=32x24").0,
        Some(32),
        "--set beats the file"
    );
    assert_eq!(
        size("--size 16x12 --set camera.size=32x24").0,
        Some(16),
        "a flag beats --set"
    );
    let settings =
        size("--background #102030 --set image.background=transparent --set splat.fill=1").1;
    assert_eq!(settings["image.background"], "#102030", "{settings}");
    assert_eq!(settings["splat.fill"], 1, "{settings}");
    done(
        folder.path(),
        "render room.toml --backend cpu -o a.png --eye -0.5,0,0.9 --target 0,0,-1 --up 0,1,0 --fov 70",
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
        ("info", "--settings"),
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
        ("render scene.toml --report ./scene.toml", 2, "overwrite"),
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

fn a_picture_to_stdout() {
    let folder = room();
    let output = run(
        folder.path(),
        "render room.toml --backend cpu -o /dev/stdout",
    );
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(
        output.stdout.starts_with(b"\x89PNG"),
        "{} bytes",
        output.stdout.len()
    );
    assert_eq!(names(folder.path()), ["room.toml"], "no file beside it");
}

fn an_unnamed_picture() {
    let folder = room();
    let output = run(folder.path(), "render room.toml --backend cpu");
    assert_eq!(
        names(folder.path()),
        ["room.png", "room.toml"],
        "{}",
        stderr(&output)
    );
    assert!(
        stderr(&output).contains("room.png"),
        "it says so: {}",
        stderr(&output)
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

fn generate_writes_a_scene() {
    let folder = room();
    done(
        folder.path(),
        "generate plane -o deep/er --points 5000 --seed 3",
    );
    let made = folder.path().join("deep/er");
    assert_eq!(
        names(&made),
        ["plane.ply", "plane.toml"],
        "points and scene"
    );
    let first = std::fs::read(made.join("plane.ply")).expect("points");
    let info: Value = serde_json::from_str(&done(&made, "info plane.toml --json")).expect("JSON");
    assert_eq!(
        (&info["facts"]["points"], &info["lights"]),
        (&Value::from(5000), &Value::from(1)),
        "{info}"
    );
    done(
        &made,
        "render plane.toml --backend cpu --size 64x48 -o plane.png",
    );
    done(
        folder.path(),
        "generate plane -o deep/er --points 5000 --seed 4",
    );
    assert!(
        std::fs::read(made.join("plane.ply")).expect("points") != first,
        "another seed makes other points"
    );
}

fn mirrors_are_put_in() {
    let folder = room();
    let scene =
        format!("{ROOM}[[mirror]]\nshape = \"sphere\"\ncentre = [0.6, 0, -2]\nradius = 0.3\n");
    std::fs::write(folder.path().join("two.toml"), scene).expect("a scene");
    let mirrors = |name: &str| {
        let info: Value =
            serde_json::from_str(&done(folder.path(), &format!("info {name} --json")))
                .expect("JSON");
        info["facts"]["mirror_points"].as_f64().expect("a count")
    };
    let (one, two) = (mirrors("room.toml"), mirrors("two.toml"));
    // Points are spread by area, so spheres compare by the squares of their radii.
    let expected = one * (1.0 + (0.3f64 / 0.44).powi(2));
    assert!(
        (two / expected - 1.0).abs() < 0.05,
        "{one} mirror points became {two}, not {expected}"
    );
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

fn scans_render(scans: &Path) {
    let folder = room();
    for (name, points) in [
        ("autzen_trim_110k_8bitrgb.laz", 110_000),
        ("simple1_4_pdrf7_16bitrgb.las", 22_600),
        ("bunny_mesh.ply", 117_570),
    ] {
        let path = scans.join(name);
        let arguments = format!(
            "render {} --backend cpu --size 160x120 -o a.png --report r.json",
            path.display()
        );
        done(folder.path(), &arguments);
        let report = json(&folder.path().join("r.json"));
        assert_eq!(report["points"], points, "{name}");
        let coverage = report["gbuffer"]["coverage_filled"]
            .as_f64()
            .expect("a share");
        assert!(coverage > 0.1, "{name} covers {coverage} of the picture");
    }
}
