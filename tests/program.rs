//! Runs the program in a folder of its own.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// A small room, 64 x 48 pixels.
pub(crate) const ROOM: &str = r#"format = 1
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

/// A folder with the small room in it.
pub(crate) fn room() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("room.toml"), ROOM).expect("a scene");
    folder
}

pub(crate) fn program(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_catoptric"));
    command
        .current_dir(folder)
        .args(arguments.split_whitespace())
        // Without it graphics drivers complain on stderr.
        .env("XDG_RUNTIME_DIR", folder)
        .stdin(Stdio::null());
    command
}

pub(crate) fn run(folder: &Path, arguments: &str) -> Output {
    program(folder, arguments)
        .output()
        .expect("the program runs")
}

/// Runs what must succeed; gives stdout.
pub(crate) fn done(folder: &Path, arguments: &str) -> String {
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
pub(crate) fn refused(folder: &Path, arguments: &str, status: i32) -> String {
    let output = run(folder, arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(status), "{arguments}: {said}");
    assert!(
        said.starts_with("catoptric: ") && said.trim_end().lines().count() == 1,
        "{arguments} says {said:?}"
    );
    said
}

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub(crate) fn names(folder: &Path) -> Vec<String> {
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

pub(crate) fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).expect("the file")).expect("JSON")
}
