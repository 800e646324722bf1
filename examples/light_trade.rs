//! What the settings of indirect light trade: `cargo run --release --example light_trade -- DIR [SETTING]` renders the sphere
//! scene with the values of one setting after the other, writes a plot of error against time for each, and prints the figures as
//! CSV. The plots of docs/METHOD.md are made by it.
//!
//! Error is that of 16 x 16 blocks of the indirect light over its mean, on walls of one colour: against the light of the same
//! program with 4096 lights that every pixel gathers, and against the independent renderer where `CATOPTRIC_TRUTH` names its
//! folder. Time is that of all passes of indirect light over that of the camera's G-buffer in the same frame. Each figure is the
//! median of three clouds of the same scene, so that no luck with the points chooses a setting.

#![expect(
    clippy::print_stdout,
    reason = "an example that reports its figures, and may fail by panic"
)]

use std::error::Error;
use std::path::{Path, PathBuf};

use catoptric::Job;
use catoptric::frame::View;
use catoptric::gi::GiSettings;
use catoptric::plan::Plan;
use catoptric::renderer::{BackendChoice, Products, Renderer};
use catoptric::scene::{LoadedScene, Override, Scene};
use catoptric::settings::Settings;
use glam::Vec3;
use plotters::prelude::*;

const SIZE: (usize, usize) = (800, 600);

/// Side of the blocks in which pictures are compared, pixels.
const BLOCK: usize = 16;

/// Seeds of the clouds of which the median counts.
const SEEDS: [&str; 3] = ["1", "2", "3"];

/// Passes that make the camera's G-buffer.
const CAMERA: [&str; 7] = [
    "sort",
    "depth",
    "visibility",
    "average",
    "coverage",
    "fill",
    "smooth",
];

/// Passes of indirect light.
const LIGHT: [&str; 10] = [
    "receivers",
    "mirror_receivers",
    "settle",
    "vpl",
    "ism",
    "gather",
    "indirect_filter",
    "mirror_light",
    "photons",
    "add_indirect",
];

/// A setting, and the values that it takes while the others stay as they are.
struct Knob {
    name: &'static str,
    values: &'static [u32],
    set: fn(&mut GiSettings) -> &mut u32,
    /// Lights at which it is turned.
    lights: u32,
}

const KNOBS: [Knob; 5] = [
    Knob {
        name: "vpl_count",
        values: &[16, 32, 64, 128, 256, 512, 1024, 2048, 4096],
        set: |gi| &mut gi.vpl_count,
        lights: 256,
    },
    Knob {
        name: "interleave",
        values: &[1, 2, 3, 4, 6, 8],
        set: |gi| &mut gi.interleave,
        lights: 256,
    },
    Knob {
        name: "interleave",
        values: &[1, 2, 4, 8],
        set: |gi| &mut gi.interleave,
        lights: 1024,
    },
    Knob {
        name: "ism_size",
        values: &[16, 32, 64, 128, 256],
        set: |gi| &mut gi.ism_size,
        lights: 1024,
    },
    Knob {
        name: "ism_points",
        values: &[500, 1000, 2000, 4000, 8000, 16000],
        set: |gi| &mut gi.ism_points,
        lights: 1024,
    },
];

/// Indirect light of the scene, and what it takes.
struct Room {
    loaded: LoadedScene,
    view: View,
    renderer: Renderer,
    settings: Settings,
    direct: Vec<Vec3>,
    /// Pixels that are compared: walls of one colour, not the picture's diagonals, which look along edges of the room.
    counts: Vec<bool>,
}

impl Room {
    fn open(seed: &str) -> Result<Self, Box<dyn Error>> {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("pointclouds/sphere.toml");
        let seed = Override::new("cloud.0.seed", seed, "the example")?;
        let scene = Scene::open(&file, &[seed])?;
        let loaded = scene.load(&Job::default())?;
        let mut room = Self {
            view: loaded.view()?,
            renderer: Renderer::new(&BackendChoice::Cpu, &loaded.surfels)?,
            settings: scene.settings,
            loaded,
            direct: Vec::new(),
            counts: Vec::new(),
        };
        let products = room.render(&GiSettings {
            vpl_count: 0,
            ..room.settings.gi.clone()
        })?;
        let seen = &products.gbuffer;
        let counts = |i: usize| {
            let (x, y) = (i % SIZE.0, i / SIZE.0);
            let diagonal = (x as f64 - 399.5).abs() == (y as f64 - 299.5).abs();
            let floor = seen.surface.values()[i].y > 0.5;
            seen.albedo.values()[i].w <= 0.0 && !floor && !diagonal
        };
        room.counts = (0..SIZE.0 * SIZE.1).map(counts).collect();
        room.direct = colours(&products);
        // Builds what later frames keep.
        room.render(&GiSettings {
            vpl_count: 16,
            ..room.settings.gi.clone()
        })?;
        Ok(room)
    }

    fn render(&mut self, gi: &GiSettings) -> Result<Products, Box<dyn Error>> {
        let settings = Settings {
            gi: gi.clone(),
            ..self.settings.clone()
        };
        let plan: Plan = self.loaded.plan(&settings);
        Ok((self.renderer).render(&self.view, &plan, &settings, &Job::default())?)
    }

    /// Indirect light, and its time over that of the camera's G-buffer.
    fn light(&mut self, gi: &GiSettings) -> Result<(Vec<Vec3>, f64), Box<dyn Error>> {
        let products = self.render(gi)?;
        let of = |names: &[&str]| -> f64 {
            let passes = products.passes.iter();
            let named = passes.filter(|p| names.contains(&p.name.as_str()));
            named.map(|p| p.wall_ms).sum()
        };
        let all = colours(&products);
        let light = all.iter().zip(&self.direct).map(|(a, d)| *a - *d).collect();
        Ok((light, of(&LIGHT) / of(&CAMERA)))
    }

    /// Mean error of blocks over the mean.
    fn error(&self, got: &[Vec3], expected: &[Vec3]) -> f64 {
        let (columns, rows) = (SIZE.0 / BLOCK, SIZE.1 / BLOCK);
        let mut sums = vec![(Vec3::ZERO, 0usize); columns * rows];
        let (mut all, mut counted) = (0.0, 0);
        for i in (0..got.len()).filter(|&i| self.counts[i]) {
            all += f64::from(expected[i].element_sum());
            counted += 1;
            let (x, y) = (i % SIZE.0 / BLOCK, i / SIZE.0 / BLOCK);
            if let Some(block) = sums.get_mut(y * columns + x) {
                block.0 += got[i] - expected[i];
                block.1 += 1;
            }
        }
        sums.retain(|(_, count)| *count > BLOCK * BLOCK / 2);
        let off = |(sum, count): &(Vec3, usize)| f64::from(sum.abs().element_sum()) / *count as f64;
        let off: f64 = sums.iter().map(off).sum::<f64>() / sums.len() as f64;
        off / (all / f64::from(counted))
    }
}

fn colours(products: &Products) -> Vec<Vec3> {
    let radiance = products.radiance.values().iter();
    radiance.map(|v| v.truncate()).collect()
}

fn picture(path: &Path) -> Result<Vec<Vec3>, Box<dyn Error>> {
    let image = exr::prelude::read_first_rgba_layer_from_file(
        path,
        |_, _| vec![Vec3::ZERO; SIZE.0 * SIZE.1],
        |pixels, at, (r, g, b, _): (f32, f32, f32, f32)| {
            pixels[at.y() * SIZE.0 + at.x()] = Vec3::new(r, g, b);
        },
    )?;
    Ok(image.layer_data.channel_data.pixels)
}

/// What the independent renderer says of indirect light, where it is at hand.
fn truth() -> Result<Option<Vec<Vec3>>, Box<dyn Error>> {
    let Some(folder) = std::env::var_os("CATOPTRIC_TRUTH").map(PathBuf::from) else {
        return Ok(None);
    };
    let all = picture(&folder.join("sphere_gi.exr"))?;
    let direct = picture(&folder.join("sphere_direct4.exr"))?;
    Ok(Some(
        all.iter().zip(&direct).map(|(a, d)| *a - *d).collect(),
    ))
}

/// A value of a setting: its time, and its errors in percent.
struct Point {
    value: u32,
    time: f64,
    errors: Vec<f64>,
}

const REFERENCES: [&str; 2] = ["the same with 4096 lights, n = 1", "independent renderer"];

fn plot(path: &Path, title: &str, points: &[Point]) -> Result<(), Box<dyn Error>> {
    let area = SVGBackend::new(path, (560, 360)).into_drawing_area();
    area.fill(&WHITE)?;
    let times = points.iter().map(|p| p.time);
    let most = times.fold(0f64, f64::max);
    let errors = points.iter().flat_map(|p| &p.errors);
    let worst = errors.fold(0f64, |worst, e| worst.max(*e));
    let mut chart = ChartBuilder::on(&area)
        .caption(title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(50)
        .build_cartesian_2d(0.0..most * 1.08, 0.0..worst * 1.15)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .label_style(("sans-serif", 14))
        .x_desc("time of indirect light / time of the camera's G-buffer")
        .y_desc("error of blocks, %")
        .draw()?;
    for (k, name) in REFERENCES.iter().enumerate() {
        let colour = [RGBColor(30, 90, 180), RGBColor(200, 80, 40)][k];
        let of = |p: &Point| Some((p.time, *p.errors.get(k)?, p.value));
        let known: Vec<_> = points.iter().filter_map(of).collect();
        if known.is_empty() {
            continue;
        }
        let above = [-0.03, 0.07][k];
        let line = known.iter().map(|(time, error, _)| (*time, *error));
        chart
            .draw_series(LineSeries::new(line, colour.stroke_width(2)).point_size(3))?
            .label(*name)
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 16, y)], colour));
        chart.draw_series(known.iter().map(|(time, error, value)| {
            // One series' values above it, the other's below.
            let place = (*time, *error + worst * above);
            Text::new(value.to_string(), place, ("sans-serif", 13).into_font())
        }))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .label_font(("sans-serif", 14))
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    area.present()?;
    Ok(())
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// What these settings come to: medians of all clouds.
fn measure(
    rooms: &mut [Room],
    references: &[Vec<Vec3>],
    gi: &GiSettings,
    value: u32,
) -> Result<Point, Box<dyn Error>> {
    let (mut times, mut errors) = (Vec::new(), Vec::new());
    for room in rooms {
        let (light, time) = room.light(gi)?;
        let error = |reference| 100.0 * room.error(&light, reference);
        errors.push(references.iter().map(|r| error(r)).collect::<Vec<_>>());
        times.push(time);
    }
    let error = |k: usize| median(errors.iter().map(|e| e[k]));
    Ok(Point {
        value,
        time: median(times.into_iter()),
        errors: (0..references.len()).map(error).collect(),
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let folder = args.next().map_or_else(PathBuf::new, PathBuf::from);
    let only = args.next();
    let mut rooms = (SEEDS.iter().map(|seed| Room::open(seed))).collect::<Result<Vec<_>, _>>()?;
    let defaults = GiSettings::default();
    let (converged, _) = rooms[0].light(&GiSettings {
        vpl_count: 4096,
        interleave: 1,
        ism_size: 128,
        ism_points: 8000,
        ..defaults.clone()
    })?;
    let references: Vec<_> = [Some(converged), truth()?].into_iter().flatten().collect();
    println!("setting,lights,value,time,error against converged,error against truth");
    for knob in KNOBS
        .iter()
        .filter(|k| only.as_ref().is_none_or(|o| o == k.name))
    {
        let mut points = Vec::new();
        for &value in knob.values {
            let mut gi = GiSettings {
                vpl_count: knob.lights,
                ..defaults.clone()
            };
            *(knob.set)(&mut gi) = value;
            let point = measure(&mut rooms, &references, &gi, value)?;
            let errors = point.errors.iter().map(|e| format!("{e:.2}"));
            println!(
                "{},{},{value},{:.3},{}",
                knob.name,
                gi.vpl_count,
                point.time,
                errors.collect::<Vec<_>>().join(",")
            );
            points.push(point);
        }
        let name = format!("light_{}_{}", knob.name, knob.lights);
        let title = if knob.name == "vpl_count" {
            "gi.vpl_count".to_owned()
        } else {
            format!("gi.{}, with {} lights", knob.name, knob.lights)
        };
        plot(&folder.join(name).with_extension("svg"), &title, &points)?;
    }
    Ok(())
}
