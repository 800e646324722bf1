//! The program's manners: exit status, messages, help, interrupts.

use std::process::{Command, Stdio};

use libtest_mimic::Trial;
use serde_json::Value;

use crate::program::{ROOM, done, names, program, refused, room, stderr};
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
