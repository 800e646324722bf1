//! A display that nobody sees, with the program in it.

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use image::RgbImage;

/// Both end with this.
pub(super) struct Window {
    _alone: MutexGuard<'static, ()>,
    server: Child,
    program: Child,
    display: String,
    pub(super) folder: tempfile::TempDir,
}

impl Window {
    /// Opens what is made in a folder of its own.
    pub(super) fn open(make: impl FnOnce(&Path) -> PathBuf) -> Self {
        // Two servers that start together may take the same number.
        static ONE: Mutex<()> = Mutex::new(());
        let alone = ONE.lock().unwrap_or_else(PoisonError::into_inner);
        let folder = tempfile::tempdir().expect("a folder");
        let scene = make(folder.path());
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
        window.drive("search --sync --onlyvisible --name catoptric windowfocus");
        // Without a window manager nobody else says how large it is.
        window.resize(1280, 800);
        window
    }

    pub(super) fn drive(&self, what: &str) {
        let done = Command::new("xdotool")
            .args(what.split(' '))
            .env("DISPLAY", &self.display)
            .output()
            .expect("xdotool");
        assert!(done.status.success(), "xdotool {what}: {done:?}");
        std::thread::sleep(Duration::from_millis(100));
    }

    /// Does something with the window itself.
    pub(super) fn handle(&self, what: &str) {
        self.drive(&format!("search --name catoptric {what}"));
    }

    pub(super) fn resize(&mut self, width: u32, height: u32) {
        self.handle(&format!("windowmove 0 0 windowsize {width} {height}"));
    }

    /// Presses and lets go.
    pub(super) fn click(&self, x: u32, y: u32) {
        self.drive(&format!("mousemove {x} {y}"));
        self.drive("click 1");
    }

    /// Moves the mouse with the button held.
    pub(super) fn drag(&self, x: u32, y: u32) {
        self.drive(&format!("mousemove {x} {y} mousedown 1"));
        for _ in 0..5 {
            self.drive("mousemove_relative 12 4");
        }
        self.drive("mouseup 1");
    }

    pub(super) fn look(&self) -> RgbImage {
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

    /// Waits until it does nothing more.
    pub(super) fn wait_until_idle(&mut self) {
        let (start, mut before, mut quiet) = (Instant::now(), self.ticks(), 0);
        while quiet < 4 {
            assert!(
                start.elapsed() < Duration::from_secs(120),
                "it does not come to rest"
            );
            let ended = self.program.try_wait().expect("its state");
            assert!(ended.is_none(), "it ended: {ended:?}");
            std::thread::sleep(Duration::from_millis(100));
            let now = self.ticks();
            quiet = if now == before { quiet + 1 } else { 0 };
            before = now;
        }
    }

    /// The screen once nothing more is done, and it shows as many colours.
    pub(super) fn wait_for_rest(&mut self, least_colours: usize) -> RgbImage {
        let start = Instant::now();
        loop {
            self.wait_until_idle();
            let now = self.look();
            if colours(&now) >= least_colours {
                return now;
            }
            assert!(
                start.elapsed() < Duration::from_secs(60),
                "nothing is shown"
            );
        }
    }

    /// Waits until the screen is as it is to be: where others work, what is asked for takes its time.
    pub(super) fn wait_for(&mut self, what: &str, holds: impl Fn(&RgbImage) -> bool) {
        let start = Instant::now();
        while !holds(&self.look()) {
            let waited = start.elapsed();
            assert!(waited < Duration::from_secs(60), "{what} does not come");
        }
    }

    fn told(&self, file: &str) -> String {
        let path = Path::new("/proc").join(self.program.id().to_string());
        std::fs::read_to_string(path.join(file)).expect("what the system tells of it")
    }

    /// Time of all cores so far, clock ticks.
    pub(super) fn ticks(&self) -> u64 {
        let text = self.told("stat");
        let behind = text.rsplit(") ").next().expect("fields");
        let fields: Vec<&str> = behind.split(' ').collect();
        let ticks = [11, 12].map(|k| fields[k].parse::<u64>().expect("ticks"));
        ticks.iter().sum()
    }

    /// Resident memory, kilobytes.
    pub(super) fn memory(&self) -> u64 {
        let text = self.told("status");
        let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let number = line.and_then(|line| line.trim().split(' ').next());
        number.expect("a number").parse().expect("kilobytes")
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
