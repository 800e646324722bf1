//! What the program does at its limits: too little memory, no adapter, and interrupts.

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use libtest_mimic::Trial;
use tempfile::TempDir;

use crate::program::{done, json, names, program, refused, room, run, stderr};
use crate::support::{claim, gpu_is_missing};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim("limits::a_huge_picture_is_a_sentence", || {
            huge_is_refused("cpu");
        }),
        claim("limits::a_huge_picture_is_a_sentence_on_the_gpu", || {
            huge_is_refused("gpu");
        })
        .with_ignored_flag(gpu_is_missing()),
        claim(
            "limits::a_limit_of_the_shell_is_a_sentence_and_no_crash",
            a_limit_of_the_shell_is_kept,
        )
        .with_ignored_flag(cfg!(not(target_os = "linux"))),
        claim(
            "limits::a_missing_adapter_is_noticed_before_the_clouds_are_read",
            a_missing_adapter_comes_first,
        ),
        claim(
            "limits::what_the_plan_skips_does_not_run",
            what_the_plan_skips_does_not_run,
        ),
        claim(
            "limits::an_interrupt_while_splatting_leaves_nothing",
            interrupted_while_splatting,
        )
        .with_ignored_flag(cfg!(not(unix))),
        claim(
            "limits::an_interrupt_while_writing_leaves_nothing",
            interrupted_while_writing,
        )
        .with_ignored_flag(cfg!(not(unix))),
    ]
}

fn huge_is_refused(backend: &str) {
    let folder = room();
    let arguments = format!("render room.toml --backend {backend} -o a.png --size 32768x32768");
    let output = run(folder.path(), &arguments);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("32768 x 32768 pixels needs") && said.contains("smaller picture"),
        "{said}"
    );
    assert_eq!(names(folder.path()), ["room.toml"], "nothing is written");
}

/// Runs the program within 4 GB of address space.
fn within_4_gb(folder: &Path, arguments: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_catoptric");
    Command::new("sh")
        .args([
            "-c",
            &format!("ulimit -v 4000000 && exec {program} {arguments}"),
        ])
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .expect("a shell")
}

fn a_limit_of_the_shell_is_kept() {
    let folder = room();
    let arguments = "render room.toml --backend cpu -o a.png --gbuffer g.exr --size";
    let output = within_4_gb(folder.path(), &format!("{arguments} 8000x6000"));
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("8000 x 6000 pixels needs"), "{said}");
    assert_eq!(names(folder.path()), ["room.toml"], "nothing is written");

    let output = within_4_gb(folder.path(), &format!("{arguments} 1600x1200"));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(names(folder.path()), ["a.png", "g.exr", "room.toml"]);
}

fn a_missing_adapter_comes_first() {
    let folder = room();
    std::fs::write(folder.path().join("broken.ply"), "ply\nno header\n").expect("a file");
    let arguments = "render broken.ply --backend gpu --adapter none-such -o a.png";
    let said = refused(folder.path(), arguments, 1);
    assert!(
        said.contains("adapter") && !said.contains("broken.ply"),
        "{said}"
    );
}

fn what_the_plan_skips_does_not_run() {
    let folder = room();
    let fills = |rings: u32| {
        let arguments = format!(
            "render room.toml --backend cpu -o a.png --report r.json --set splat.fill={rings}"
        );
        done(folder.path(), &arguments);
        let report = json(&folder.path().join("r.json"));
        let names = report["passes"].as_array().expect("passes").iter();
        let ran: Vec<_> = names.filter_map(|pass| pass["name"].as_str()).collect();
        assert!(ran.contains(&"coverage"), "{ran:?}");
        ran.contains(&"fill")
    };
    assert!(fills(1), "one ring is filled");
    assert!(!fills(0), "no ring is filled");
}

/// Interrupts a running program; it must say that nothing was written, soon, and be right.
fn assert_interrupted(folder: &TempDir, child: Child) {
    let interrupt = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .expect("kill runs");
    assert!(interrupt.success(), "the program still ran");
    let start = Instant::now();
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("cancelled; nothing was written"),
        "{}",
        stderr(&output)
    );
    assert_eq!(names(folder.path()), ["room.toml"], "nothing is written");
    let took = start.elapsed();
    assert!(
        took < Duration::from_secs(4),
        "it went on for {took:?} after the interrupt"
    );
}

fn start(folder: &TempDir, arguments: &str) -> Child {
    program(folder.path(), arguments)
        .stderr(Stdio::piped())
        .spawn()
        .expect("it runs")
}

fn interrupted_while_splatting() {
    let folder = room();
    // Loading takes a tenth of a second, splatting 20,000 discs of 700 pixels many.
    let child = start(
        &folder,
        "render room.toml --backend cpu -o a.png --size 3000x2250 --set splat.size=16",
    );
    std::thread::sleep(Duration::from_millis(1500));
    assert_interrupted(&folder, child);
}

fn interrupted_while_writing() {
    let folder = room();
    let child = start(
        &folder,
        "render room.toml --backend cpu -o a.png --gbuffer g.exr --size 3000x2250 --set splat.size=1",
    );
    // The picture is being written once a temporary file has a length: what asks whether it could be is empty.
    let begun = || {
        let entries = std::fs::read_dir(folder.path()).expect("a folder");
        entries.flatten().any(|entry| {
            let part = entry.path().extension().is_some_and(|e| e == "part");
            part && entry.metadata().is_ok_and(|m| m.len() > 0)
        })
    };
    let start = Instant::now();
    while !begun() {
        assert!(
            start.elapsed() < Duration::from_secs(120),
            "nothing is written"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
    assert_interrupted(&folder, child);
}
