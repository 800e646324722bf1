//! Numerical stability: the interleaved search of f32 beside one of f64 on the same mirrors, at the extremes of scenes. The
//! table of docs/MEASURING.md is what this prints: `cargo test --release --test tests -- extremes::f32 --nocapture`.

use std::path::Path;

use catoptric::Job;
use catoptric::backend::cpu::Cpu;
use catoptric::grid::Grid;
use catoptric::measure::precision::{FoundBy, Precision, found_in};
use catoptric::reflect::sscr::curvature::{Axes, curvature};
use catoptric::reflect::sscr::lhc::Labeller;
use catoptric::reflect::sscr::{LhcMap, SscrSettings};
use catoptric::reflect::{Eye, LabelledMirrors, Surface};
use glam::{DVec3, Vec3, Vec4};
use libtest_mimic::Trial;
use rayon::prelude::*;

use super::SMALL;
use super::cameras::{around_the_pane, into_the_parabola};
use crate::analytic::{Oracle, View};
use crate::rendered::{Opened, Way, generated};
use crate::roots::{Quality, Roots, quality};
use crate::support::claim;

pub(super) fn tests() -> Vec<Trial> {
    vec![claim(
        "extremes::f32_and_f64_find_the_same_up_to_chance",
        f32_and_f64_find_the_same,
    )]
}

/// Points of which all roots are looked for.
const KNOWN: usize = 400;

/// A scene at an extreme.
struct Extreme {
    name: String,
    scene: &'static str,
    points: usize,
    view: View,
    /// The whole scene is scaled, then moved along all axes.
    scale: f64,
    offset: f64,
    /// Added to coordinates before they become f32: what an origin saves them from.
    without_origin: f32,
    /// Nearest and farthest that the camera sees.
    near_far: Option<[f64; 2]>,
    splat_size: f32,
}

impl Extreme {
    fn new(name: &str, scene: &'static str, view: View) -> Self {
        Self {
            name: name.to_owned(),
            scene,
            points: 100_000,
            view,
            scale: 1.0,
            offset: 0.0,
            without_origin: 0.0,
            near_far: None,
            splat_size: 1.5,
        }
    }

    /// The text of the scene.
    fn text(&self) -> String {
        let (s, o) = (self.scale, self.offset);
        let place = |at: DVec3| at * s + DVec3::splat(o);
        let view = View {
            position: place(self.view.position),
            target: place(self.view.target),
            ..self.view
        };
        let text = generated(self.scene, self.points, &view);
        let points = format!("points = {}", self.points);
        let transform = format!(
            "{points}\ntransform = [{s:e}, 0, 0, {o:e}, 0, {s:e}, 0, {o:e}, 0, 0, {s:e}, {o:e}, 0, 0, 0, 1]"
        );
        let [near, far] = self.near_far.unwrap_or([0.05 * s, 10.0 * s]);
        // Light does not matter to the search.
        let dark = text.replace("[6, 6, 6]", "[0, 0, 0]");
        dark.replace(&points, &transform).replace(
            "[camera]\n",
            &format!("[camera]\nnear = {near:e}\nfar = {far:e}\n"),
        )
    }

    /// Searches by f32 and by f64.
    fn measure(&self) -> Row {
        let mut opened = Opened::new(&self.text(), Path::new(""));
        opened.settings.gi.vpl_count = 0;
        opened.settings.splat.size = self.splat_size;
        let products = opened.by(Way::Interleaved);
        let settings = &opened.settings;
        let mut surface = Surface::of(&products.gbuffer);
        let cells = curvature(
            &surface,
            Axes::from(&products.gbuffer.pinhole),
            &settings.lhc,
        );
        let lhc: LhcMap = Labeller::default().lhc(&cells).clone();
        let mut places = opened.loaded.surfels.places.clone();
        if self.without_origin != 0.0 {
            let moved = Vec3::splat(self.without_origin);
            surface = shifted(surface, moved);
            for place in &mut places {
                place.position += moved;
            }
        }
        let right = products.gbuffer.pinhole.right;
        let mirrors = LabelledMirrors::new(&surface, &lhc, right);
        let search = |settings: &SscrSettings| {
            let both = found_in(&mirrors, &places, settings, &Job::default());
            both.expect("no cancellation")
        };
        let (offered, found) = search(&settings.sscr);
        let (_, by_sixteenths) = search(&SscrSettings {
            initial_step: 3.0 / 16.0,
            ..settings.sscr.clone()
        });

        let hits = Oracle::named(self.scene).view(&self.view);
        let roots = Roots::new(Oracle::named(self.scene), self.view, &hits);
        let surfels = &opened.loaded.surfels;
        // Whichever points they are: the cloud is shuffled.
        let known: Vec<(&FoundBy, _)> = (found.par_iter().take(KNOWN))
            .map(|f| {
                let at = surfels.places[f.point as usize].position.as_dvec3() + surfels.origin;
                (f, roots.of((at - DVec3::splat(self.offset)) / self.scale))
            })
            .collect();
        let [single, double] = [
            |f: &FoundBy| f.single.into_iter().collect(),
            |f: &FoundBy| f.double.into_iter().collect::<Vec<_>>(),
        ]
        .map(|hit| {
            let of: Vec<_> = known.iter().map(|(f, r)| (r.clone(), hit(f))).collect();
            quality(&of)
        });
        Row {
            pixels: products.coverage.mirror,
            precision: Precision::of(offered, &found),
            by_sixteenths: Precision::of(offered, &by_sixteenths),
            single,
            double,
        }
    }
}

/// A surface elsewhere, as f32 has it there.
fn shifted(surface: Surface<Cpu>, by: Vec3) -> Surface<Cpu> {
    let Eye::Point(eye) = surface.eye else {
        panic!("the camera is a point");
    };
    let moved = |p: &Vec4| {
        if p.w > 0.0 {
            (p.truncate() + by).extend(p.w)
        } else {
            *p
        }
    };
    let points = surface.point.values().iter().map(moved).collect();
    Surface {
        point: Grid::from_vec(surface.size, points).expect("as many"),
        eye: Eye::Point(eye + by),
        ..surface
    }
}

/// What was found at an extreme.
struct Row {
    pixels: u64,
    precision: Precision,
    /// With steps that f32 adds up exactly.
    by_sixteenths: Precision,
    single: Quality,
    double: Quality,
}

/// All extremes, from mirrors of a few pixels to splats of eight radii.
fn extremes() -> Vec<Extreme> {
    let of = Extreme::new;
    let sized = |height: usize| View {
        width: height / 3 * 4,
        height,
        ..SMALL
    };
    let mut all = Vec::new();
    for height in [6, 24, 120, 480] {
        let size = format!("picture of {} x {height}", height / 3 * 4);
        all.push(of(&size, "sphere", sized(height)));
    }
    let close = View {
        position: DVec3::new(0.0, 0.0, -0.5),
        ..SMALL
    };
    all.push(of("mirror that fills the picture", "sphere", close));
    for degrees in [45.0, 78.0, 88.0, 89.0] {
        let name = format!("pane at {degrees} degrees");
        all.push(of(&name, "plane", around_the_pane(degrees)));
    }
    for before in [0.5, 0.15, 0.01, 0.0, -0.08] {
        let name = format!("bowl, eye {before} m before its focus");
        all.push(of(&name, "parabola", into_the_parabola(before)));
    }
    for fov_y_degrees in [5.0, 120.0, 150.0, 170.0] {
        let view = View {
            fov_y_degrees,
            position: if fov_y_degrees > 90.0 {
                DVec3::new(0.0, 0.0, -0.4)
            } else {
                SMALL.position
            },
            ..SMALL
        };
        all.push(of(
            &format!("field of view of {fov_y_degrees} degrees"),
            "sphere",
            view,
        ));
    }
    for offset in [1.0, 1e2, 5e3, 1e5, 1e7] {
        all.push(Extreme {
            offset,
            ..of(&format!("{offset} m from 0"), "sphere", SMALL)
        });
    }
    for without_origin in [5e3, 1e5, 1e6] {
        let name = format!("{without_origin} m from 0, without an origin");
        all.push(Extreme {
            without_origin,
            ..of(&name, "sphere", SMALL)
        });
    }
    for scale in [1e-3, 1e3] {
        all.push(Extreme {
            scale,
            ..of(&format!("scene of {scale} times its size"), "sphere", SMALL)
        });
    }
    for [near, far] in [[0.4, 4.0], [1e-3, 1e3], [1e-6, 1e6]] {
        all.push(Extreme {
            near_far: Some([near, far]),
            ..of(&format!("near {near:e}, far {far:e}"), "sphere", SMALL)
        });
    }
    for splat_size in [0.5, 4.0, 8.0] {
        all.push(Extreme {
            splat_size,
            ..of(&format!("splats of {splat_size} radii"), "sphere", SMALL)
        });
    }
    all
}

fn f32_and_f64_find_the_same() {
    println!(
        "| extreme | mirror, px | hits f32, f64, % | off by f32, px: median, 95 % | by f64 | part, % | by sixteenths, % | apart, px: median, 99 %, worst |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let mut rows = Vec::new();
    for extreme in extremes() {
        let row = extreme.measure();
        let (p, s, d) = (&row.precision, &row.single, &row.double);
        println!(
            "| {} | {} | {:.2}, {:.2} | {:.3}, {:.3} | {:.3}, {:.3} | {:.3} | {:.4} | {:.1e}, {:.1e}, {:.2} |",
            extreme.name,
            row.pixels,
            p.percent(p.hit_f32),
            p.percent(p.hit_f64),
            s.median,
            s.p95,
            d.median,
            d.p95,
            p.part * 100.0,
            row.by_sixteenths.part * 100.0,
            p.apart_px.median,
            p.apart_px.p99,
            p.apart_px.max
        );
        rows.push((extreme, row));
    }
    for (Extreme { name, .. }, row) in &rows {
        let (p, s, d) = (&row.precision, &row.single, &row.double);
        assert!(
            p.offered == 100_000 && p.hit_f64 > 0,
            "{name}: nothing to tell"
        );
        // A place that ought to lie on the edge of two pixels falls to either: another search, no worse.
        assert!(p.part < 0.12, "{name}: {p:?}");
        let many = p.hit_f64 as f64;
        assert!(
            (p.hit_f32 as f64 - many).abs() < 0.02 * many + 10.0,
            "{name}: {p:?}"
        );
        // Elsewhere only what is as good as zero decides otherwise.
        let exact = &row.by_sixteenths;
        assert!(exact.part < 1e-3, "{name}: {exact:?}");
        assert!(exact.apart_px.p99 < 1e-3, "{name}: {exact:?}");
        let worse = s.median / d.median.max(1e-3);
        assert!(
            s.median.is_nan() || worse < 1.2,
            "{name}: f32 is {s:?}, f64 {d:?}"
        );
    }
    // Negative control: it is seen where numbers are too coarse.
    let median = |part: &str| {
        let mut all = rows.iter().filter(|(e, _)| e.name.contains(part));
        all.next().expect("a row").1.single.median
    };
    let (with, without) = (
        median("10000000 m from 0"),
        median("1000000 m from 0, without"),
    );
    assert!(
        without > 1.3 * with,
        "{with} px off with an origin and {without} without"
    );
}
