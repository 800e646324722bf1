//! The viewer: the real program in a window of a display that nobody sees.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use image::RgbImage;
use libtest_mimic::Trial;

use screen::Window;

use crate::support::{claim, folder, gpu_is_missing};

mod screen;
mod stored;

/// Programs that drive a window.
const TOOLS: [&str; 3] = ["Xvfb", "xdotool", "import"];

pub(crate) fn tests() -> Vec<Trial> {
    let on_path = |tool: &str| {
        let path = std::env::var_os("PATH").unwrap_or_default();
        std::env::split_paths(&path).any(|folder| folder.join(tool).is_file())
    };
    let missing = !TOOLS.into_iter().all(on_path) || gpu_is_missing();
    let no_scans = folder("CATOPTRIC_SCANS").is_none();
    let driven: [(&str, fn(), bool); 5] = [
        (
            "window::a_scene_is_shown_and_turned",
            a_scene_is_shown_and_turned,
            false,
        ),
        ("window::a_scan_is_shown", a_scan_is_shown, no_scans),
        (
            "window::it_survives_what_happens_to_it",
            it_survives_what_happens_to_it,
            false,
        ),
        (
            "window::reloading_does_not_grow",
            reloading_does_not_grow,
            false,
        ),
        (
            "window::at_rest_it_costs_nothing",
            at_rest_it_costs_nothing,
            false,
        ),
    ];
    let mut trials: Vec<Trial> = driven
        .into_iter()
        .map(|(name, check, lacks)| claim(name, check).with_ignored_flag(missing || lacks))
        .collect();
    if cfg!(target_os = "linux") {
        trials.push(claim(
            "window::without_a_display_it_says_so",
            without_a_display_it_says_so,
        ));
    }
    trials
}

/// Colours that a picture of a scene has, at least.
const PICTURE: usize = 500;

const WHOLE: [u32; 2] = [1280, 800];

/// A ball that reflects its room.
fn sphere(folder: &Path, points: usize) -> PathBuf {
    let scene = folder.join("scene.toml");
    let text = format!(
        "format = 1\n[[cloud]]\ngenerate = \"sphere\"\npoints = {points}\n[[light]]\nkind = \"point\"\n\
         position = [0.5, 0.6, 0.4]\nintensity = [4, 4, 4]\n[camera]\nposition = [0, 0, 0.9]\n\
         target = [0, 0, -1]\n[settings.gi]\nvpl_count = 0\n"
    );
    std::fs::write(&scene, text).expect("a scene");
    scene
}

/// Share of the pixels that differ.
fn differ(a: &RgbImage, b: &RgbImage) -> f64 {
    let pairs = a.pixels().zip(b.pixels());
    pairs.filter(|(a, b)| a != b).count() as f64 / a.pixels().len() as f64
}

fn a_scene_is_shown_and_turned() {
    let mut window = Window::open(|folder| sphere(folder, 100_000));
    window.drive("mousemove 640 420");
    let still = window.wait_for_rest(PICTURE);
    stored::demand("sphere", &still, WHOLE);

    // Another layer, below the first in the box of layers, is another picture than the stored one.
    window.click(1100, 62);
    window.wait_for("the box of layers", |now| differ(&still, now) > 0.02);
    window.click(1055, 111);
    window.drive("mousemove 640 420");
    window.wait_for("the layer", |now| differ(&still, now) > 0.2);
    let layer = window.wait_for_rest(0);
    let share = stored::from_stored("sphere", &layer, WHOLE);
    assert!(share > 3.0 * stored::TOLERANCE, "{share} of the layer");
    stored::demand("layer", &layer, WHOLE);
    window.click(1100, 62);
    window.wait_for("the box of layers", |now| differ(&layer, now) > 0.02);
    window.click(1055, 88);
    window.drive("mousemove 640 420");
    window.wait_for("the picture", |now| differ(&layer, now) > 0.2);
    let still = window.wait_for_rest(PICTURE);
    stored::demand("sphere", &still, WHOLE);

    // Help comes and goes, and leaves the picture as it was.
    window.drive("key F1");
    let help = window.wait_for_rest(0);
    assert!(differ(&still, &help) > 0.05, "F1 shows something");
    window.drive("key F1");
    let again = window.wait_for_rest(PICTURE);
    let share = differ(&still, &again);
    assert!(share < 1e-3, "{share} of it is another");

    // A drag turns the camera: that is another one, too.
    window.drag(640, 420);
    let turned = window.wait_for_rest(PICTURE);
    let share = differ(&still, &turned);
    assert!(share > 0.05, "only {share} is another");
    let share = stored::from_stored("sphere", &turned, WHOLE);
    assert!(share > 3.0 * stored::TOLERANCE, "{share} of the turned one");
}

fn a_scan_is_shown() {
    let scans = folder("CATOPTRIC_SCANS").expect("the folder of scans");
    let scan = scans.join("autzen_trim_110k_8bitrgb.laz");
    let mut window = Window::open(|_| scan);
    window.drive("mousemove 640 420");
    let still = window.wait_for_rest(PICTURE);
    stored::demand("scan", &still, WHOLE);
    window.drag(640, 420);
    let turned = window.wait_for_rest(PICTURE);
    let share = stored::from_stored("scan", &turned, WHOLE);
    assert!(share > 3.0 * stored::TOLERANCE, "{share} of the turned one");
}

fn it_survives_what_happens_to_it() {
    let mut window = Window::open(|folder| sphere(folder, 50_000));
    window.drive("mousemove 640 420");
    let before = window.wait_for_rest(PICTURE);

    // Put away, and back again.
    window.handle("windowunmap");
    window.wait_until_idle();
    window.handle("windowmap windowfocus");
    window.drive("mousemove 640 421");
    let again = window.wait_for_rest(PICTURE);
    let share = stored::apart(&before, &again, WHOLE);
    let alike = stored::TOLERANCE;
    assert!(share < alike, "{share} is another after it was away");

    // As small as it may be, small, and as large as it was.
    window.resize(640, 420);
    window.wait_for_rest(0);
    window.resize(1024, 700);
    let small = window.wait_for_rest(PICTURE);
    stored::demand("small", &small, [1024, 700]);
    window.resize(1280, 800);
    let again = window.wait_for_rest(PICTURE);
    let share = stored::apart(&before, &again, WHOLE);
    assert!(share < alike, "{share} is another in its old size");

    // Its file is gone: that is said, and what was read stays.
    std::fs::remove_file(window.folder.path().join("scene.toml")).expect("the scene");
    window.drive("key ctrl+r");
    let said = window.wait_for_rest(PICTURE);
    let share = differ(&again, &said);
    assert!((0.005..0.3).contains(&share), "{share} is a message");
    window.drag(640, 300);
    let turned = window.wait_for_rest(PICTURE);
    assert!(differ(&said, &turned) > 0.05, "the camera still turns");
}

fn reloading_does_not_grow() {
    let mut window = Window::open(|folder| sphere(folder, 30_000));
    window.resize(640, 420);
    window.wait_for_rest(0);
    let mut memory = Vec::new();
    for _ in 0..30 {
        window.drive("key ctrl+r");
        window.wait_until_idle();
        memory.push(window.memory());
    }
    println!("kB after each reload: {memory:?}");
    let (fifth, last) = (memory[4], memory[29]);
    assert!(last * 10 < fifth * 11, "{fifth} kB, then {last} kB");
}

fn at_rest_it_costs_nothing() {
    let mut window = Window::open(|folder| sphere(folder, 50_000));
    window.wait_for_rest(PICTURE);
    std::thread::sleep(Duration::from_secs(1));
    let before = window.ticks();
    std::thread::sleep(Duration::from_secs(3));
    let spent = window.ticks() - before;
    // A tick is a hundredth of a second.
    assert!(spent <= 6, "{spent} ticks in three seconds of rest");
}

fn without_a_display_it_says_so() {
    let done = Command::new(env!("CARGO_BIN_EXE_catoptric"))
        .arg("view")
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .expect("the program");
    let said = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(1), "{said}");
    assert!(
        said.contains("no display") && said.contains("catoptric render"),
        "{said}"
    );
}
