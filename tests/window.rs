//! The viewer: the real program in a window of a display that nobody sees.

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use image::RgbImage;
use libtest_mimic::Trial;

use crate::support::{claim, gpu_is_missing};

/// Programs that drive a window.
const TOOLS: [&str; 3] = ["Xvfb", "xdotool", "import"];

pub(crate) fn tests() -> Vec<Trial> {
    let on_path = |tool: &str| {
        let path = std::env::var_os("PATH").unwrap_or_default();
        std::env::split_paths(&path).any(|folder| folder.join(tool).is_file())
    };
    let missing = !TOOLS.into_iter().all(on_path) || gpu_is_missing();
    let driven = [
        claim(
            "window::a_scene_is_shown_and_turned",
            a_scene_is_shown_and_turned,
        ),
        claim("window::at_rest_it_costs_nothing", at_rest_it_costs_nothing),
    ];
    let mut trials: Vec<Trial> = driven
        .into_iter()
        .map(|trial| trial.with_ignored_flag(missing))
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

/// A display with the program in it; both end with this.
struct Window {
    _alone: MutexGuard<'static, ()>,
    server: Child,
    program: Child,
    display: String,
    folder: tempfile::TempDir,
}

impl Window {
    fn open(points: usize) -> Self {
        // Two servers that start together may take the same number.
        static ONE: Mutex<()> = Mutex::new(());
        let alone = ONE.lock().unwrap_or_else(PoisonError::into_inner);
        let folder = tempfile::tempdir().expect("a folder");
        let scene = folder.path().join("scene.toml");
        let text = format!(
            "format = 1\n[[cloud]]\ngenerate = \"sphere\"\npoints = {points}\n[[light]]\nkind = \"spot\"\n\
             position = [0.95, 0.6, 0]\ntarget = [-1, -0.6, 0]\nintensity = [9, 9, 9]\n[camera]\nposition = [0, 0, 0.9]\n\
             target = [0, 0, -1]\n[settings.gi]\nvpl_count = 0\n"
        );
        std::fs::write(&scene, text).expect("a scene");
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb");
        let mut number = String::new();
        let output = server.stdout.take().expect("its output");
        BufReader::new(output)
            .read_line(&mut number)
            .expect("a number");
        let display = format!(":{}", number.trim());
        let program = Command::new(env!("CARGO_BIN_EXE_catoptric"))
            .args(["view", "--backend", "cpu"])
            .arg(&scene)
            .env("DISPLAY", &display)
            .env_remove("WAYLAND_DISPLAY")
            .env("XDG_RUNTIME_DIR", folder.path())
            .env("XDG_DATA_HOME", folder.path())
            .spawn()
            .expect("the program");
        let mut window = Self {
            _alone: alone,
            server,
            program,
            display,
            folder,
        };
        window.drive("search --sync --name catoptric windowfocus");
        window.wait_for_rest(PICTURE);
        window
    }

    fn drive(&self, what: &str) {
        let done = Command::new("xdotool")
            .args(what.split(' '))
            .env("DISPLAY", &self.display)
            .output()
            .expect("xdotool");
        assert!(done.status.success(), "xdotool {what}: {done:?}");
        std::thread::sleep(Duration::from_millis(150));
    }

    fn look(&self) -> RgbImage {
        let path: PathBuf = self.folder.path().join("screen.png");
        let done = Command::new("import")
            .args(["-window", "root"])
            .arg(&path)
            .env("DISPLAY", &self.display)
            .status()
            .expect("import");
        assert!(done.success(), "a picture of the screen");
        image::open(path).expect("a picture").into_rgb8()
    }

    /// Waits until three looks one after the other are the same, and show as many colours.
    fn wait_for_rest(&mut self, least_colours: usize) -> RgbImage {
        let start = Instant::now();
        let (mut before, mut same) = (self.look(), 0);
        loop {
            assert!(
                start.elapsed() < Duration::from_secs(120),
                "it does not come to rest"
            );
            let ended = self.program.try_wait().expect("its state");
            assert!(ended.is_none(), "it ended: {ended:?}");
            std::thread::sleep(Duration::from_millis(600));
            let now = self.look();
            same = if now == before { same + 1 } else { 0 };
            if same >= 2 && colours(&now) >= least_colours {
                return now;
            }
            before = now;
        }
    }

    /// Time of all cores so far, clock ticks.
    fn ticks(&self) -> u64 {
        let stat = Path::new("/proc")
            .join(self.program.id().to_string())
            .join("stat");
        let text = std::fs::read_to_string(stat).expect("its times");
        let fields: Vec<&str> = text
            .rsplit(") ")
            .next()
            .expect("fields")
            .split(' ')
            .collect();
        [11, 12]
            .map(|k| fields[k].parse::<u64>().expect("ticks"))
            .iter()
            .sum()
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        for child in [&mut self.program, &mut self.server] {
            // It may have ended by itself.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// How many colours the middle of the screen has.
fn colours(screen: &RgbImage) -> usize {
    let middle = image::imageops::crop_imm(screen, 480, 200, 320, 400).to_image();
    let all: std::collections::BTreeSet<[u8; 3]> = middle.pixels().map(|p| p.0).collect();
    all.len()
}

/// Share of the pixels that differ.
fn differ(a: &RgbImage, b: &RgbImage) -> f64 {
    let pairs = a.pixels().zip(b.pixels());
    pairs.filter(|(a, b)| a != b).count() as f64 / a.pixels().len() as f64
}

fn a_scene_is_shown_and_turned() {
    let mut window = Window::open(200_000);
    window.drive("mousemove 640 420");
    let still = window.wait_for_rest(PICTURE);

    // Help comes and goes, and leaves the picture as it was.
    window.drive("key F1");
    let help = window.wait_for_rest(0);
    assert!(differ(&still, &help) > 0.05, "F1 shows something");
    window.drive("key F1");
    let again = window.wait_for_rest(PICTURE);
    assert!(
        differ(&still, &again) < 1e-3,
        "{} of it is another",
        differ(&still, &again)
    );

    // A drag turns the camera.
    window.drive("mousedown 1");
    for _ in 0..5 {
        window.drive("mousemove_relative 12 4");
    }
    window.drive("mouseup 1");
    let turned = window.wait_for_rest(PICTURE);
    assert!(
        differ(&still, &turned) > 0.05,
        "only {} is another",
        differ(&still, &turned)
    );
}

fn at_rest_it_costs_nothing() {
    let window = Window::open(50_000);
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
