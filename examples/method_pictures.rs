//! Makes the pictures of `docs/METHOD.md`: `cargo run --release --example method_pictures [FOLDER]` (docs/pictures).
//!
//! Each is a row of panels, one a variant of a pass. It is also an example of the library: scenes from text, settings
//! changed in code, and the buffers of a frame looked at one by one.

use std::error::Error;
use std::path::Path;

use catoptric::Job;
use catoptric::image::{picture, srgb_from_linear};
use catoptric::reflect::sscr::Search;
use catoptric::reflect::sscr::curvature::{
    Axes, CONCAVE, CONVEX, PLANAR, X_CLASS, X_STEP, Y_CLASS, Y_SHIFT, Y_STEP, curvature,
};
use catoptric::reflect::{Method, Surface};
use catoptric::renderer::{BackendChoice, Products, Renderer};
use catoptric::scene::{LoadedScene, Scene};
use catoptric::settings::Settings;
use glam::Vec3;
use image::codecs::png::{self, CompressionType, PngEncoder};
use image::imageops::FilterType;
use image::{ImageEncoder, RgbImage};

type Outcome<T> = Result<T, Box<dyn Error>>;
type Panels = Vec<RgbImage>;
type Row = fn() -> Outcome<Panels>;

/// Side of a panel, pixels.
const SIDE: u32 = 240;
/// Between panels, pixels.
const GAP: u32 = 4;
/// Where nothing is shown.
const NOTHING: [u8; 3] = [255, 0, 255];

fn main() -> Outcome<()> {
    let folder = std::env::args().nth(1);
    let folder = Path::new(folder.as_deref().unwrap_or("docs/pictures"));
    std::fs::create_dir_all(folder)?;
    let rows: [(&str, Row); 10] = [
        ("splat", splats),
        ("fill", fillings),
        ("smooth", smoothings),
        ("light", lights),
        ("edl", edges),
        ("lhc", regions),
        ("root_find", searches),
        ("guided", guided),
        ("accumulate", accumulations),
        ("ray_trace", methods),
    ];
    for (name, panels) in rows {
        write(&folder.join(format!("method_{name}.png")), &panels()?)?;
    }
    Ok(())
}

/// A scene on the processor.
struct Stage {
    settings: Settings,
    loaded: LoadedScene,
    renderer: Renderer,
}

impl Stage {
    /// A generated scene, seen with a field of view of so many degrees; lit or not.
    fn new(name: &str, points: usize, fov: f32, lit: bool) -> Outcome<Self> {
        let light = "[[light]]\nkind = \"spot\"\nposition = [-0.6, 0.9, 0.2]\ntarget = [1, -1, -3]\n\
                     intensity = [6, 6, 6]\n";
        let text = format!(
            "format = 1\n[[cloud]]\ngenerate = \"{name}\"\npoints = {points}\n\
             [[cloud.mirror]]\nproperty = \"mirror\"\n{}[camera]\nposition = [0, 0, 0.9]\n\
             target = [0, 0, -1.1]\nfov_y_degrees = {fov}\nsize = [{SIDE}, {SIDE}]\n\
             [settings.image]\nexposure = 4\n",
            if lit { light } else { "" }
        );
        let mut scene = Scene::parse(&text, Path::new("pictures.toml"), &[])?;
        scene.settings.sscr.search = Search::Interleaved;
        scene.settings.gi.vpl_count = 0;
        let loaded = scene.load(&Job::default())?;
        let renderer = Renderer::new(&BackendChoice::Cpu, &loaded.surfels)?;
        Ok(Self {
            settings: scene.settings,
            loaded,
            renderer,
        })
    }

    /// A frame with some settings changed.
    fn render(&mut self, change: impl FnOnce(&mut Settings)) -> Outcome<Products> {
        let mut settings = self.settings.clone();
        change(&mut settings);
        let plan = self.loaded.plan(&settings);
        let view = self.loaded.view()?;
        let job = Job::default();
        Ok(self.renderer.render(&view, &plan, &settings, &job)?)
    }

    /// What such a frame looks like.
    fn photo(&mut self, change: impl FnOnce(&mut Settings)) -> Outcome<RgbImage> {
        let products = self.render(change)?;
        let shown = picture(&products.radiance, &self.settings.image);
        let shows = |i: usize| products.gbuffer.material.values()[i].w > 0.0;
        Ok(panel(|i| {
            let [r, g, b, _] = shown.values()[i];
            if shows(i) { [r, g, b] } else { NOTHING }
        }))
    }

    /// What the mirrors of such a frame show: albedo.
    fn mirrors(&mut self, change: impl FnOnce(&mut Settings)) -> Outcome<RgbImage> {
        Ok(reflected(&self.render(change)?))
    }
}

/// A panel from the colour of each pixel.
fn panel(colour: impl Fn(usize) -> [u8; 3]) -> RgbImage {
    RgbImage::from_fn(SIDE, SIDE, |x, y| {
        image::Rgb(colour((y * SIDE + x) as usize))
    })
}

/// The sRGB of linear colours.
fn encoded(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(srgb_from_linear)
}

/// A colour of its own for each number, none for 0.
fn of_number(number: u32) -> [u8; 3] {
    let hue = number as f32 * 0.618_034;
    let wave = |shift: f32| 0.5 + 0.4 * ((hue + shift) * std::f32::consts::TAU).cos();
    let colour = [wave(0.0), wave(1.0 / 3.0), wave(2.0 / 3.0)];
    if number == 0 {
        [255; 3]
    } else {
        colour.map(|c| (c * 255.0) as u8)
    }
}

/// The albedo of what the mirrors show.
fn reflected(products: &Products) -> RgbImage {
    panel(|i| {
        let Some(mirror) = &products.mirror else {
            return [255; 3];
        };
        match mirror.at(i) {
            Some(seen) => encoded(seen.albedo.truncate()),
            None if mirror.origin.values()[i].w > 0.0 => NOTHING,
            None => [255; 3],
        }
    })
}

/// The normals of a frame, as colours.
fn normals(products: &Products) -> RgbImage {
    let gbuffer = &products.gbuffer;
    panel(|i| {
        let normal = gbuffer.surface.values()[i].truncate();
        if gbuffer.material.values()[i].w > 0.0 {
            (normal * 0.5 + 0.5).to_array().map(|c| (c * 255.0) as u8)
        } else {
            NOTHING
        }
    })
}

/// Normals of small splats, of splats of the usual size, and the depth of these.
fn splats() -> Outcome<Panels> {
    let mut stage = Stage::new("torus", 100_000, 34.0, false)?;
    let bare = |size: f32| {
        move |s: &mut Settings| {
            (s.splat.size, s.splat.fill, s.splat.smooth) = (size, 0, 0.0);
        }
    };
    let usual = stage.render(bare(1.5))?;
    let depth = panel(|i| {
        let depth = usual.gbuffer.surface.values()[i].w;
        [(255.0 * (2.4 - depth) / 1.4).clamp(0.0, 255.0) as u8; 3]
    });
    let small = stage.render(bare(0.7))?;
    Ok(vec![normals(&small), normals(&usual), depth])
}

/// Holes, the same filled, and in which ring.
fn fillings() -> Outcome<Panels> {
    let mut stage = Stage::new("torus", 400_000, 34.0, false)?;
    let mut filled = |fill: u32| {
        stage.render(|s| {
            (s.splat.size, s.splat.fill, s.splat.smooth) = (1.0, fill, 0.0);
        })
    };
    let (holes, filled) = (filled(0)?, filled(3)?);
    let rings = panel(|i| match filled.gbuffer.material.values()[i].w as u32 {
        0 => NOTHING,
        1 => [225; 3],
        ring => of_number(ring),
    });
    Ok(vec![normals(&holes), normals(&filled), rings])
}

/// Reflections in a mirror as splatted, smoothed, and smoothed too much: a part of the picture, three times as large.
fn smoothings() -> Outcome<Panels> {
    let mut stage = Stage::new("blob", 1_600_000, 30.0, false)?;
    let mut traced = |smooth: f32| {
        let shown = stage.mirrors(|s| {
            (s.reflect.method, s.splat.smooth) = (Method::RayTrace, smooth);
        })?;
        let part = image::imageops::crop_imm(&shown, 60, 70, SIDE / 3, SIDE / 3).to_image();
        Ok(image::imageops::resize(
            &part,
            SIDE,
            SIDE,
            FilterType::Nearest,
        ))
    };
    [0.0, 1.5, 6.0].into_iter().map(&mut traced).collect()
}

/// The albedo, and the light on it with a usual and with a coarse map.
fn lights() -> Outcome<Panels> {
    let mut stage = Stage::new("sphere", 400_000, 70.0, true)?;
    let products = stage.render(|_| ())?;
    let albedo = panel(|i| encoded(products.gbuffer.albedo.values()[i].truncate()));
    Ok(vec![
        albedo,
        stage.photo(|_| ())?,
        stage.photo(|s| s.gi.light_map_size = 64)?,
    ])
}

/// Without light: albedo alone, and with eye-dome lighting of two widths.
fn edges() -> Outcome<Panels> {
    let mut stage = Stage::new("multi", 400_000, 60.0, false)?;
    stage.settings.image.exposure = 1.0;
    Ok(vec![
        stage.photo(|s| s.image.edl_strength = 0.0)?,
        stage.photo(|_| ())?,
        stage.photo(|s| s.image.edl_radius = 4.0)?,
    ])
}

/// The curvature map of the blob, and the regions of blob and bumps.
fn regions() -> Outcome<Panels> {
    let labelled = |name: &str| -> Outcome<(Products, RgbImage)> {
        let products = Stage::new(name, 1_600_000, 31.0, true)?.render(|_| ())?;
        let labels = products.mirror.as_ref().map(|m| m.region.values());
        let labels = labels.ok_or("no mirror is seen")?;
        let coloured = panel(|i| of_number(labels[i]));
        Ok((products, coloured))
    };
    let (blob, blob_regions) = labelled("blob")?;
    let (_, bumps_regions) = labelled("bumps")?;
    let surface = Surface::of(&blob.gbuffer);
    let axes = Axes::from(&blob.gbuffer.pinhole);
    let cells = curvature(&surface, axes, &Settings::default().lhc);
    let bend = |class: u8| match class {
        CONCAVE => 40,
        PLANAR => 128,
        CONVEX => 216,
        _ => 255,
    };
    let bends = panel(|i| {
        let cell = cells.values()[i];
        if cell & (X_STEP | Y_STEP) != 0 {
            return [0; 3];
        }
        let (x, y) = (cell & X_CLASS, (cell & Y_CLASS) >> Y_SHIFT);
        [bend(x), bend(y), if cell == 0 { 255 } else { 96 }]
    });
    Ok(vec![bends, blob_regions, bumps_regions])
}

/// How many points are found in each pixel of sphere, torus and blob, each grey for twice as many as the one before: black 1, white 32 and more.
fn searches() -> Outcome<Panels> {
    let counts = |name: &str| -> Outcome<RgbImage> {
        let mut stage = Stage::new(name, 1_600_000, 31.0, true)?;
        let products = stage.render(|s| (s.sscr.max_splat, s.sscr.pull_levels) = (1.0, 0))?;
        let mirror = products.mirror.as_ref().ok_or("no mirror is seen")?;
        let searched = |i: usize| mirror.origin.values()[i].w > 0.0;
        Ok(panel(|i| match mirror.count.values()[i] {
            0 if searched(i) => NOTHING,
            0 => [255; 3],
            count => [(count.ilog2() * 48).min(240) as u8; 3],
        }))
    };
    ["sphere", "torus", "blob"]
        .into_iter()
        .map(counts)
        .collect()
}

/// What was found, where from holes are filled, and the filled.
fn accumulations() -> Outcome<Panels> {
    let mut stage = Stage::new("torus", 1_600_000, 31.0, true)?;
    let closed = stage.render(|_| ())?;
    let mirror = closed.mirror.as_ref().ok_or("no mirror is seen")?;
    let levels = panel(|i| match (mirror.at(i), mirror.level.values()[i] as u32) {
        (None, _) => [255; 3],
        (Some(_), 0) => [225; 3],
        (Some(_), level) => of_number(level),
    });
    let found = stage.mirrors(|s| s.sscr.pull_levels = 0)?;
    Ok(vec![found, levels, reflected(&closed)])
}

/// The charts of a dented ball, what it shows by the guided search before closing, and how that differs from traced rays.
fn guided() -> Outcome<Panels> {
    let mut stage = Stage::new("blob", 1_600_000, 31.0, true)?;
    let products = stage.render(|s| {
        s.sscr.search = Search::Guided;
        s.sscr.pull_levels = 0;
    })?;
    let mirror = products.mirror.as_ref().ok_or("no mirror is seen")?;
    let charts = panel(|i| of_number(mirror.region.values()[i]));
    let searched = reflected(&products);
    let traced = stage.mirrors(|s| s.reflect.method = Method::RayTrace)?;
    let difference = difference(&searched, &traced);
    Ok(vec![charts, searched, difference])
}

/// How far two panels are apart in each channel.
fn difference(a: &RgbImage, b: &RgbImage) -> RgbImage {
    RgbImage::from_fn(SIDE, SIDE, |x, y| {
        let (a, b) = (a.get_pixel(x, y).0, b.get_pixel(x, y).0);
        image::Rgb([0, 1, 2].map(|c| a[c].abs_diff(b[c])))
    })
}

/// The search, the traced reference, and their difference.
fn methods() -> Outcome<Panels> {
    let mut stage = Stage::new("torus", 1_600_000, 31.0, true)?;
    let searched = stage.mirrors(|_| ())?;
    let traced = stage.mirrors(|s| s.reflect.method = Method::RayTrace)?;
    let difference = difference(&searched, &traced);
    Ok(vec![searched, traced, difference])
}

/// Writes panels side by side.
fn write(path: &Path, panels: &[RgbImage]) -> Outcome<()> {
    let width = panels.len() as u32 * (SIDE + GAP) - GAP;
    let mut row = RgbImage::from_pixel(width, SIDE, image::Rgb([255; 3]));
    for (k, panel) in panels.iter().enumerate() {
        image::imageops::replace(&mut row, panel, i64::from(k as u32 * (SIDE + GAP)), 0);
    }
    let file = std::io::BufWriter::new(std::fs::File::create(path)?);
    let encoder =
        PngEncoder::new_with_quality(file, CompressionType::Best, png::FilterType::Adaptive);
    encoder.write_image(&row, width, SIDE, image::ExtendedColorType::Rgb8)?;
    Ok(())
}
