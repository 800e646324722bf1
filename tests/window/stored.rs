//! Pictures of the window that people have looked at, and whether it still looks the same.

use std::path::{Path, PathBuf};

use image::{Rgb, RgbImage};

/// Share of the pixels that may differ: letters are not smoothed alike everywhere.
pub(super) const TOLERANCE: f64 = 0.01;

/// Channels that differ by less are the same.
const STEP: u8 = 24;

/// A quarter of the width and height, without what is never the same twice: times and memory on the right, and the status.
fn still(screen: &RgbImage, [width, height]: [u32; 2]) -> RgbImage {
    let mut kept = image::imageops::crop_imm(screen, 0, 0, width, height).to_image();
    for (x, y, pixel) in kept.enumerate_pixels_mut() {
        if y + 28 > height || (x + 350 > width && y > 76) {
            *pixel = Rgb([0; 3]);
        }
    }
    image::imageops::thumbnail(&kept, width / 4, height / 4)
}

/// Share of the pixels that differ.
fn unlike(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let differs = |(a, b): (&Rgb<u8>, &Rgb<u8>)| {
        let mut channels = a.0.iter().zip(b.0);
        channels.any(|(a, b)| a.abs_diff(b) >= STEP)
    };
    let pairs = a.pixels().zip(b.pixels());
    pairs.filter(|pair| differs(*pair)).count() as f64 / a.pixels().len() as f64
}

/// How far two windows of this size are apart.
pub(super) fn apart(a: &RgbImage, b: &RgbImage, size: [u32; 2]) -> f64 {
    unlike(&still(a, size), &still(b, size))
}

/// How far a window of this size is from the stored picture of that name.
pub(super) fn from_stored(name: &str, screen: &RgbImage, size: [u32; 2]) -> f64 {
    let path = place(name);
    let stored = image::open(&path);
    let stored = stored.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    unlike(&stored.into_rgb8(), &still(screen, size))
}

fn place(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/window");
    folder.join(format!("{name}.png"))
}

/// The window looks as it is stored; with CATOPTRIC_RENEW=1 it is stored as it looks.
pub(super) fn demand(name: &str, screen: &RgbImage, size: [u32; 2]) {
    if std::env::var_os("CATOPTRIC_RENEW").is_some_and(|value| value == "1") {
        still(screen, size).save(place(name)).expect("a picture");
    }
    let share = from_stored(name, screen, size);
    if share > TOLERANCE {
        let seen = std::env::temp_dir().join(format!("catoptric-window-{name}.png"));
        screen.save(&seen).expect("a picture");
        panic!(
            "{share:.4} of {name} is another: see {}; where that is right, CATOPTRIC_RENEW=1 stores it",
            seen.display()
        );
    }
}
