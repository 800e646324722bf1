//! How the cost of reflections grows with points, mirror pixels and regions: `cargo run --release --example search_growth -- DIR`
//! writes three plots and prints the figures as CSV. The pictures of docs/METHOD.md are made by it.
//!
//! Balls in a room, seen exactly; both searches and traced rays, all cores, medians of three runs after one.

#![expect(
    clippy::print_stdout,
    reason = "an example that reports its figures, and may fail by panic"
)]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use catoptric::Job;
use catoptric::backend::Backend;
use catoptric::backend::cpu::Cpu;
use catoptric::cloud::generate::{SceneName, generate};
use catoptric::cloud::{Surfels, prepare};
use catoptric::gbuffer::SplatSettings;
use catoptric::grid::Grid;
use catoptric::reflect::ray_trace::{Pixels, RayTraceSettings, RayTracer};
use catoptric::reflect::sscr::chart_class::{CHART_CLASS, chart_class};
use catoptric::reflect::sscr::charts::{LEAST_PIXELS, charts};
use catoptric::reflect::sscr::curvature::{Axes, LhcSettings, curvature};
use catoptric::reflect::sscr::field::MirrorField;
use catoptric::reflect::sscr::guided::Guide;
use catoptric::reflect::sscr::lhc::Labeller;
use catoptric::reflect::sscr::prefix::{Budget, Prefix};
use catoptric::reflect::sscr::shorten::{TRIED, shorten};
use catoptric::reflect::sscr::{SscrSettings, root_find};
use catoptric::reflect::{Eye, LabelledMirrors, MirrorGBuffer, Surface};
use catoptric::timing::Timings;
use glam::{DVec3, UVec2, Vec3, Vec4};
use plotters::prelude::*;

const SIZE: UVec2 = UVec2::new(800, 600);
const EYE: Vec3 = Vec3::new(0.0, 0.0, 0.9);
const SCREEN: Axes = Axes::Screen {
    right: Vec3::X,
    down: Vec3::NEG_Y,
};
const METHODS: [&str; 3] = ["interleaved", "guided", "ray_trace, with its tree"];

/// `per_side` x `per_side` balls that fill a part of the picture's height, 2 m before the eye.
fn balls(per_side: u32, part: f32) -> Surface<Cpu> {
    let slope = 30f32.to_radians().tan();
    let pitch = 2.0 * slope * 2.0 * part / per_side as f32;
    let radius = 0.48 * pitch;
    let (mut point, mut normal) = (Grid::new(SIZE, Vec4::ZERO), Grid::new(SIZE, Vec4::ZERO));
    for i in 0..(SIZE.x * SIZE.y) as usize {
        let (x, y) = ((i as u32 % SIZE.x) as f32, (i as u32 / SIZE.x) as f32);
        let scale = 2.0 * slope / SIZE.y as f32;
        let ray = Vec3::new((x + 0.5 - 400.0) * scale, (300.0 - y - 0.5) * scale, -1.0);
        // The nearest ball's column and row.
        let cell = |v: f32| ((2.0 * v / pitch + per_side as f32 * 0.5).floor() + 0.5) * pitch;
        let middle = per_side as f32 * 0.5 * pitch;
        let centre = EYE + Vec3::new(cell(ray.x) - middle, cell(ray.y) - middle, -2.0);
        let inside = (centre - EYE).truncate().abs().max_element() < middle;
        let (a, b) = (ray.length_squared(), ray.dot(centre - EYE));
        let under = b * b - a * ((centre - EYE).length_squared() - radius * radius);
        if inside && under > 0.0 {
            let at = EYE + ray * ((b - under.sqrt()) / a);
            point.values_mut()[i] = at.extend(1.0);
            normal.values_mut()[i] = ((at - centre) / radius).extend(0.005);
        }
    }
    let eye = Eye::Point(EYE);
    Surface {
        size: SIZE,
        point,
        normal,
        eye,
    }
}

/// The room's points.
fn room(points: usize) -> Result<Arc<Surfels>, Box<dyn Error>> {
    let job = Job::default();
    let cloud = generate(SceneName::Plane, points, 1, None, &job)?;
    Ok(Arc::new(
        prepare(vec![cloud.into()], DVec3::ZERO, &job)?.surfels,
    ))
}

/// Milliseconds: the median of three runs after one.
fn median(mut work: impl FnMut() -> Result<(), Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    work()?;
    let mut times = Vec::new();
    for _ in 0..3 {
        let start = Instant::now();
        work()?;
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    Ok(times[1])
}

/// What each method takes to find what the mirrors show, and the number of regions.
fn costs(surface: &Surface<Cpu>, surfels: &Arc<Surfels>) -> Result<[f64; 3], Box<dyn Error>> {
    let job = Job::default();
    let interleaved = median(|| {
        let cells = curvature(surface, SCREEN, &LhcSettings::default());
        let mut labeller = Labeller::default();
        let mirrors = LabelledMirrors::new(surface, labeller.lhc(&cells), Vec3::X);
        root_find::root_find(surfels, &mirrors, &SscrSettings::default(), 5.0, &job)?;
        Ok(())
    })?;
    let guided = median(|| {
        let cells = curvature(surface, SCREEN, &LhcSettings::default());
        let classes = chart_class(surface, &cells);
        let mut labeller = Labeller::default();
        let lhc = labeller.label_merged(&classes, |c| c & CHART_CLASS, LEAST_PIXELS);
        let field = MirrorField::new(surface, &cells)?;
        let mut charts = charts(&field, lhc, &job)?;
        let mut prefix = Prefix::default();
        let sample = prefix.sample(TRIED, &surfels.places);
        shorten(&mut charts, &field, &surfels.places, &sample, &job)?;
        let guide = Guide {
            field: &field,
            charts: &charts,
            self_hit: 5.0,
            splat_size: 1.5,
        };
        let budget = Budget::Enough {
            mirror_pixels: surface.pixels(),
        };
        Cpu::default().guided(surfels, &guide, &mut prefix, budget, &job)?;
        Ok(())
    })?;
    let traced = median(|| {
        let mut timings = Timings::default();
        let (splat, rays) = (SplatSettings::default(), RayTraceSettings::default());
        let tracer = RayTracer::new(surfels, &splat, &rays, &mut timings, &job)?;
        let mut mirror = MirrorGBuffer::of(surface);
        tracer.trace(surface, &mut mirror, Pixels::All, &mut timings, &job)?;
        Ok(())
    })?;
    Ok([interleaved, guided, traced])
}

/// A row of a plot: where on its x axis, and what each method takes.
type Row = (f64, [f64; 3]);

fn plot(path: &Path, x_label: &str, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let path = path.with_extension("svg");
    let area = SVGBackend::new(&path, (560, 360)).into_drawing_area();
    area.fill(&WHITE)?;
    let range = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values.fold((f64::INFINITY, 0f64), |(a, b), v| (a.min(v), b.max(v)));
        low * 0.8..high * 1.25
    };
    let x = range(&mut rows.iter().map(|r| r.0));
    let y = range(&mut rows.iter().flat_map(|r| r.1));
    let mut chart = ChartBuilder::on(&area)
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(60)
        .build_cartesian_2d(x.log_scale(), y.log_scale())?;
    chart
        .configure_mesh()
        .x_desc(x_label)
        .y_desc("milliseconds")
        .draw()?;
    for (k, name) in METHODS.iter().enumerate() {
        let colour = [
            RGBColor(200, 80, 40),
            RGBColor(30, 90, 180),
            RGBColor(40, 130, 70),
        ][k];
        let points = rows.iter().map(|r| (r.0, r.1[k]));
        chart
            .draw_series(LineSeries::new(points, colour.stroke_width(2)).point_size(3))?
            .label(*name)
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 16, y)], colour));
    }
    chart
        .configure_series_labels()
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    area.present()?;
    println!("{x_label},{}", METHODS.join(","));
    for (x, [a, b, c]) in rows {
        println!("{x},{a:.1},{b:.1},{c:.1}");
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os()
        .nth(1)
        .map_or_else(PathBuf::new, PathBuf::from);
    let mut rows = Vec::new();
    for points in [100_000, 300_000, 1_000_000, 3_000_000, 10_000_000] {
        rows.push((points as f64, costs(&balls(1, 0.44), &room(points)?)?));
    }
    plot(&folder.join("growth_points"), "points", &rows)?;

    let surfels = room(1_600_000)?;
    rows.clear();
    for part in [0.12, 0.25, 0.5, 1.0, 1.4] {
        let surface = balls(1, part);
        let share = 100.0 * surface.pixels() as f64 / f64::from(SIZE.x * SIZE.y);
        rows.push((share, costs(&surface, &surfels)?));
    }
    plot(
        &folder.join("growth_pixels"),
        "mirror pixels, % of 800 x 600",
        &rows,
    )?;

    rows.clear();
    for per_side in [1, 2, 4, 8, 16, 32] {
        let regions = f64::from(per_side * per_side);
        rows.push((regions, costs(&balls(per_side, 0.9), &surfels)?));
    }
    plot(&folder.join("growth_regions"), "balls (regions)", &rows)
}
