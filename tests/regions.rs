//! The regions of homogeneous curvature of mirrors, seen by the oracle (without noise) and splatted.

use std::ops::RangeInclusive;

use catoptric::backend::Backend;
use catoptric::backend::cpu::Cpu;
use catoptric::camera::Camera;
use catoptric::cloud::generate::SceneName;
use catoptric::gbuffer::SplatSettings;
use catoptric::grid::Grid;
use catoptric::reflect::sscr::LhcMap;
use catoptric::reflect::sscr::curvature::{Axes, LhcSettings, curvature};
use catoptric::reflect::sscr::lhc::Labeller;
use catoptric::reflect::{Eye, Surface};
use glam::{DVec3, UVec2, Vec3, Vec4};
use libtest_mimic::Trial;
use rayon::prelude::*;

use crate::analytic::{Kind, Oracle, View};
use crate::forms::C;
use crate::ideal::{SPACING, cloud};

/// What a ray from the camera meets of a mirror's front: point and unit normal.
type Seen = Option<(DVec3, DVec3)>;

pub fn tests() -> Vec<Trial> {
    let mut trials = Vec::new();
    // Bounds of the number of regions and of the largest one's share; ideal, then splatted.
    let scenes = [
        ("sphere", SceneName::Sphere, 1..=1, 1.0, 1..=5, 0.999),
        ("parabola", SceneName::Parabola, 1..=1, 1.0, 1..=5, 0.999),
        ("plane", SceneName::Plane, 1..=1, 1.0, 1..=1, 1.0),
        ("torus", SceneName::Torus, 1..=12, 0.99, 1..=200, 0.95),
        ("blob", SceneName::Blob, 2..=20, 0.9, 2..=200, 0.9),
        ("bumps", SceneName::Bumps, 200..=700, 0.0, 200..=800, 0.0),
    ];
    for (scene, name, ideal, ideal_share, splatted, splatted_share) in scenes {
        let test = move || {
            Figures::ideal(scene).assert(scene, ideal, ideal_share);
            Ok(())
        };
        trials.push(Trial::test(
            format!("regions::{scene}_seen_by_the_oracle"),
            test,
        ));
        let test = move || {
            Figures::splatted(name).assert(&format!("{scene}, splatted"), splatted, splatted_share);
            Ok(())
        };
        trials.push(Trial::test(format!("regions::{scene}_splatted"), test));
    }
    let mut add = |name: &str, test: fn()| {
        let test = move || {
            test();
            Ok(())
        };
        trials.push(Trial::test(format!("regions::{name}"), test));
    };
    add("two_balls_that_touch_are_two_regions", two_balls_that_touch);
    add(
        "one_ball_before_another_is_two_regions",
        one_ball_before_another,
    );
    add("a_pane_seen_at_78_and_88_degrees_is_one_region", || {
        for (degrees, axes) in [(78.0, screen()), (88.0, screen()), (88.0, Axes::Way)] {
            let front = |_, ray| tilted_pane(ray, degrees);
            let map = labelled(&View::REFERENCE, front, axes);
            let pixels = map.labels.values().iter().filter(|&&l| l > 0).count();
            let regions = map.regions.len();
            assert_eq!(regions, 1, "{degrees} degrees, {axes:?}: {pixels} pixels");
            assert!(
                pixels > 1000,
                "{degrees} degrees: {pixels} pixels are too few"
            );
        }
    });
    add("a_ball_that_fills_the_screen_is_one_region", || {
        let near = View {
            position: DVec3::new(0.0, 0.0, -0.62),
            ..View::REFERENCE
        };
        let map = labelled(&near, oracle_front("sphere"), screen());
        assert_eq!(map.regions.len(), 1);
        assert_eq!(map.regions[0].pixels, 480_000);
    });
    add("a_ball_of_a_few_pixels_is_one_region", || {
        let far = View {
            width: 16,
            height: 12,
            ..View::REFERENCE
        };
        let map = labelled(&far, oracle_front("sphere"), screen());
        assert_eq!(map.regions.len(), 1, "{:?}", map.labels);
    });
    trials
}

/// Axes of the reference camera.
fn screen() -> Axes {
    Axes::Screen {
        right: Vec3::X,
        down: Vec3::NEG_Y,
    }
}

/// The mirrors that a view shows.
fn surface(view: &View, front: impl Fn(DVec3, DVec3) -> Seen + Sync) -> Surface<Cpu> {
    let size = UVec2::new(view.width as u32, view.height as u32);
    let pixel = |i: usize| {
        let ray = view.direction(i % view.width, i / view.width);
        match front(view.position, ray) {
            Some((p, n)) => (p.as_vec3().extend(1.0), n.as_vec3().extend(SPACING)),
            None => (Vec4::ZERO, Vec4::ZERO),
        }
    };
    let pixels = (0..view.width * view.height).into_par_iter().map(pixel);
    let (points, normals) = pixels.unzip();
    Surface {
        size,
        point: Grid::from_vec(size, points).unwrap(),
        normal: Grid::from_vec(size, normals).unwrap(),
        eye: Eye::Point(view.position.as_vec3()),
    }
}

/// The LHC map of mirrors, by the default settings.
fn label(surface: &Surface<Cpu>, axes: Axes) -> LhcMap {
    let map = curvature(surface, axes, &LhcSettings::default());
    Labeller::default().lhc(&map).clone()
}

/// The LHC map of what a view shows.
fn labelled(view: &View, front: impl Fn(DVec3, DVec3) -> Seen + Sync, axes: Axes) -> LhcMap {
    label(&surface(view, front), axes)
}

/// The fronts of a reference scene's mirrors.
fn oracle_front(scene: &str) -> impl Fn(DVec3, DVec3) -> Seen + Sync {
    let oracle = Oracle::named(scene);
    move |origin, ray| {
        let hit = oracle.cast(origin, ray);
        matches!(hit.kind, Kind::Mirror(_)).then_some((hit.position, hit.normal))
    }
}

/// How a mirror falls into regions.
#[derive(Debug)]
struct Figures {
    raw: usize,
    from_8_pixels: usize,
    from_64_pixels: usize,
    largest_share: f32,
    unlabelled_share: f32,
}

impl Figures {
    fn of(map: &LhcMap, mirror_pixels: u64) -> Self {
        let labelled = map.labels.values().iter().filter(|&&l| l > 0).count();
        let from = |pixels| map.regions.iter().filter(|r| r.pixels >= pixels).count();
        Self {
            raw: map.regions.len(),
            from_8_pixels: from(8),
            from_64_pixels: from(64),
            largest_share: map.regions.first().map_or(0.0, |r| r.weight),
            unlabelled_share: 1.0 - labelled as f32 / mirror_pixels as f32,
        }
    }

    /// Of a reference scene as the oracle sees it.
    fn ideal(scene: &str) -> Self {
        let surface = surface(&View::REFERENCE, oracle_front(scene));
        Self::of(&label(&surface, screen()), surface.pixels())
    }

    /// Of a reference scene of 1.6 million points, splatted.
    fn splatted(scene: SceneName) -> Self {
        let camera = Camera {
            position: View::REFERENCE.position,
            target: View::REFERENCE.target,
            up: View::REFERENCE.up,
            fov_y_degrees: View::REFERENCE.fov_y_degrees,
            near: 0.05,
            far: 10.0,
            size: UVec2::new(800, 600),
        };
        let (pinhole, settings) = (
            camera.pinhole(DVec3::ZERO).unwrap(),
            SplatSettings::default(),
        );
        let mut cpu = Cpu::default();
        let points = cpu.upload(&cloud(scene, 1_600_000)).unwrap();
        let mut gbuffer = cpu.splat(&points, &pinhole, &settings).unwrap();
        cpu.fill(&mut gbuffer, &settings).unwrap();
        cpu.smooth(&mut gbuffer, &settings).unwrap();
        let surface = Surface::of(&gbuffer);
        Self::of(&label(&surface, Axes::from(&pinhole)), surface.pixels())
    }

    /// Reports the figures, and holds the number of regions and the share of the largest within bounds.
    fn assert(&self, scene: &str, raw: RangeInclusive<usize>, largest_share: f32) {
        println!(
            "regions of {scene}: {} raw, {} from 8 pixels, {} from 64, the largest {:.1} % of the mirror",
            self.raw,
            self.from_8_pixels,
            self.from_64_pixels,
            100.0 * self.largest_share
        );
        assert!(raw.contains(&self.raw), "{scene}: {self:?}");
        assert!(self.largest_share >= largest_share, "{scene}: {self:?}");
        assert!(self.unlabelled_share <= 0.005, "{scene}: {self:?}");
    }
}

/// Where a ray meets a ball.
fn ball(origin: DVec3, ray: DVec3, centre: DVec3, radius: f64) -> Option<(f64, DVec3, DVec3)> {
    let (a, b) = (ray.length_squared(), ray.dot(centre - origin));
    let under = b * b - a * ((centre - origin).length_squared() - radius * radius);
    let t = (under > 0.0).then(|| (b - under.sqrt()) / a)?;
    let point = origin + ray * t;
    Some((t, point, (point - centre) / radius))
}

/// The nearer of two balls.
fn balls(origin: DVec3, ray: DVec3, centres: [DVec3; 2], radius: f64) -> Seen {
    let met = centres
        .into_iter()
        .filter_map(|c| ball(origin, ray, c, radius));
    met.min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, p, n)| (p, n))
}

fn two_balls_that_touch() {
    for apart in [DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0).normalize()] {
        let centres = [C - apart * 0.25, C + apart * 0.25];
        let front = |origin, ray| balls(origin, ray, centres, 0.25);
        let map = labelled(&View::REFERENCE, front, screen());
        assert_eq!(
            map.regions.len(),
            2,
            "apart along {apart}: {:?}",
            map.regions
        );
    }
}

fn one_ball_before_another() {
    let centres = [C, C + DVec3::new(0.2, 0.1, -0.6)];
    let front = |origin, ray| balls(origin, ray, centres, 0.25);
    let map = labelled(&View::REFERENCE, front, screen());
    assert_eq!(map.regions.len(), 2, "{:?}", map.regions);
}

/// A pane of 0.8 x 0.8 m, so many degrees from facing the reference camera.
fn tilted_pane(ray: DVec3, degrees: f64) -> Seen {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let normal = DVec3::new(sin, 0.0, cos);
    let origin = View::REFERENCE.position;
    let t = (C - origin).dot(normal) / ray.dot(normal);
    let point = origin + ray * t;
    let across = (point - C).dot(DVec3::new(cos, 0.0, -sin));
    let on_front = t > 0.0 && ray.dot(normal) < 0.0;
    let on_pane = across.abs() <= 0.4 && (point.y - C.y).abs() <= 0.4;
    (on_front && on_pane).then_some((point, normal))
}
