//! What comes from outside while it runs: pipes, terminals, interrupts.

use std::process::{Command, Stdio};

use libtest_mimic::Trial;

use crate::program::{ROOM, names, program, refused, room, stderr};
use crate::support::claim;

pub(super) fn tests() -> Vec<Trial> {
    vec![
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
