//! Clouds of one point and of many mirrors, far from 0, and pictures of huge and tiny regions.

use std::fmt::Write as _;
use std::path::Path;

use catoptric::grid::Grid;
use catoptric::reflect::sscr::Distribution;
use catoptric::reflect::sscr::curvature::{PLANAR, Y_SHIFT};
use catoptric::reflect::sscr::distribute::distribute;
use catoptric::reflect::sscr::lhc::Labeller;
use catoptric::renderer::Products;
use glam::{DVec3, UVec2, Vec3, Vec4};
use libtest_mimic::Trial;

use super::SMALL;
use crate::analytic::View;
use crate::rendered::{Opened, Way, camera, generated};
use crate::support::claim;

pub(super) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "extremes::five_thousand_kilometres_away_everything_looks_the_same",
            far_away,
        ),
        claim(
            "extremes::ten_thousand_regions_are_told_apart_and_searched",
            ten_thousand_regions,
        ),
        claim("extremes::one_point_is_a_picture", one_point),
        claim(
            "extremes::one_mirror_point_is_black_where_there_is_nothing_else",
            one_mirror_point,
        ),
        claim(
            "extremes::a_pane_shows_the_only_point_where_the_mirrored_camera_sees_it",
            a_pane_and_one_point,
        ),
        claim(
            "extremes::of_regions_a_million_to_one_both_get_their_share",
            a_million_to_one,
        ),
    ]
}

/// Part of the pixels whose radiance differs visibly; `moved` pixels apart.
fn differing(a: &Products, b: &Products, moved: usize) -> f64 {
    let (a, b) = (a.radiance.values(), b.radiance.values());
    let pairs = a[moved..].iter().zip(b);
    let wrong = pairs.filter(|(a, b)| (**a - **b).abs().max_element() > 1.0 / 255.0);
    wrong.count() as f64 / a.len() as f64
}

fn far_away() {
    let offset = DVec3::splat(5e6);
    let moved = View {
        position: SMALL.position + offset,
        target: SMALL.target + offset,
        ..SMALL
    };
    let here = generated("sphere", 100_000, &SMALL);
    let there = generated("sphere", 100_000, &moved)
        .replace(
            "points = 100000",
            "points = 100000\ntransform = [1, 0, 0, 5e6, 0, 1, 0, 5e6, 0, 0, 1, 5e6, 0, 0, 0, 1]",
        )
        .replace("[-0.6, 0.9, 0.2]", "[4999999.4, 5000000.9, 5000000.2]")
        .replace(
            "target = [1, -1, -3]",
            "target = [5000001, 4999999, 4999997]",
        );
    let [mut here, mut there] = [here, there].map(|text| Opened::new(&text, Path::new("")));
    assert_eq!(here.loaded.surfels.origin, DVec3::ZERO);
    let origin = there.loaded.surfels.origin;
    assert!(origin.distance(offset) < 10.0, "{origin}");
    for way in Way::ALL {
        let (a, b) = (here.by(way), there.by(way));
        let (wrong, control) = (differing(&a, &b, 0), differing(&a, &b, 1));
        println!("{way:?}: {wrong:.5} differ, {control:.3} one pixel apart");
        println!("{:?}\n{:?}", a.bounces[0], b.bounces[0]);
        assert!(
            wrong < 0.001 && control > 0.02,
            "{way:?}: {wrong} differ, {control} one pixel apart"
        );
        assert!((a.bounces[0].hit_rate - b.bounces[0].hit_rate).abs() < 1e-3);
    }
}

/// A cloud as PLY: position, normal, linear colour, mirror reflectance and radius of each point.
struct Cloud(Vec<(Vec3, Vec3, Vec3, f32, f32)>);

impl Cloud {
    /// Opens it in a scene, with what else the scene says.
    fn open(&self, rest: &str) -> Opened {
        let mut ply = format!("ply\nformat ascii 1.0\nelement vertex {}\n", self.0.len());
        let columns = "x y z nx ny nz red green blue mirror radius";
        for name in columns.split(' ') {
            writeln!(ply, "property float {name}").expect("a string");
        }
        ply.push_str("end_header\n");
        for (p, n, c, mirror, radius) in &self.0 {
            let numbers = [p.to_array(), n.to_array(), c.to_array()].concat();
            for number in numbers.iter().chain([mirror, radius]) {
                write!(ply, "{number} ").expect("a string");
            }
            ply.push('\n');
        }
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("cloud.ply"), ply).expect("a file");
        let text = format!("format = 1\n[[cloud]]\npath = \"cloud.ply\"\n{rest}");
        Opened::new(&text, folder.path())
    }
}

/// Small mirrors, 100 x 100, each 3 x 3 points that bulge; before them, behind the eye, a wall.
fn ten_thousand_regions() {
    const PITCH: f32 = 0.03; // metres; 6 pixels
    let mut points = Vec::new();
    for i in 0..90_000 {
        let (patch, point) = (i / 9, i % 9);
        let centre = Vec3::new(
            (patch % 100) as f32 - 49.5,
            (patch / 100) as f32 - 49.5,
            0.0,
        );
        let within = Vec3::new((point % 3) as f32 - 1.0, (point / 3) as f32 - 1.0, 0.0);
        let normal = (within * 0.3 + Vec3::Z).normalize();
        let position = centre * PITCH + within * 0.003;
        points.push((position, normal, Vec3::ZERO, 1.0, 0.003));
    }
    for i in 0..40_000 {
        let at = Vec3::new((i % 200) as f32 - 99.5, (i / 200) as f32 - 99.5, 0.0) * 0.12;
        let colour = Vec3::new(0.5, (at.x / 24.0) + 0.5, (at.y / 24.0) + 0.5);
        points.push((at + Vec3::Z * 6.0, Vec3::NEG_Z, colour, 0.0, 0.12));
    }
    let eye = DVec3::new(0.0025, 0.0025, 3.0);
    let view = View {
        position: eye,
        target: eye.with_z(0.0),
        up: DVec3::Y,
        fov_y_degrees: 2.0 * (1.6f64 / 3.0).atan().to_degrees(),
        width: 640,
        height: 640,
    };
    let rest = format!(
        "[[cloud.mirror]]\nproperty = \"mirror\"\n{}[settings.splat]\nfill = 0\n",
        camera(&view)
    );
    let mut opened = Cloud(points).open(&rest);
    for way in Way::ALL {
        let products = opened.by(way);
        let bounce = &products.bounces[0];
        println!("{way:?}: {bounce:?}, {:?}", products.passes);
        assert_eq!(bounce.regions, 10_000, "{way:?}");
        let mirror = products.mirror.as_ref().expect("mirrors");
        let mut shows = vec![false; 10_001];
        for (i, &region) in mirror.region.values().iter().enumerate() {
            shows[region as usize] |= mirror.at(i).is_some();
        }
        let showing = shows[1..].iter().filter(|s| **s).count();
        // The search gives each mirror four points of the wall to look for.
        let least = if way == Way::RayTrace { 9_500 } else { 5_000 };
        assert!(showing >= least, "{way:?}: {showing} show something");
    }
}

/// A view of the origin from 2 m in front of it.
const FACING: View = View {
    position: DVec3::new(0.0, 0.0, 2.0),
    target: DVec3::ZERO,
    width: 64,
    height: 48,
    ..View::REFERENCE
};

fn one_point() {
    let cloud = Cloud(vec![(Vec3::ZERO, Vec3::Z, Vec3::ONE, 0.0, 0.1)]);
    let mut opened = cloud.open(&camera(&FACING));
    for way in Way::ALL {
        let products = opened.by(way);
        // A disc of 15 cm around the centre, of pixels of 4.8 cm.
        let seen = products.coverage.filled;
        assert!((20..=50).contains(&seen), "{seen} pixels");
        assert!(products.mirror.is_none(), "there is no mirror");
        let centre = products.radiance.get(32, 24).expect("a pixel");
        assert!(centre.min_element() > 0.9, "{centre}");
        assert_eq!(products.radiance.get(0, 0), Some(&Vec4::ZERO));
    }
}

fn one_mirror_point() {
    let cloud = Cloud(vec![(Vec3::ZERO, Vec3::Z, Vec3::ZERO, 1.0, 0.1)]);
    let rest = format!(
        "[[cloud.mirror]]\nproperty = \"mirror\"\n{}",
        camera(&FACING)
    );
    let mut opened = cloud.open(&rest);
    for way in Way::ALL {
        let products = opened.by(way);
        let bounce = &products.bounces[0];
        assert!(products.coverage.mirror >= 20, "{:?}", products.coverage);
        assert_eq!((bounce.regions, bounce.hits), (1, 0), "{way:?}");
        assert_eq!(bounce.coverage_closed, 0.0, "{way:?}");
        assert_eq!(products.radiance.get(32, 24), Some(&Vec4::W), "{way:?}");
    }
}

fn a_pane_and_one_point() {
    let point = Vec3::new(0.5, 0.0, 0.5);
    let colour = Vec3::new(1.0, 0.5, 0.25);
    let rest = format!(
        "[[mirror]]\nshape = \"plane\"\ncentre = [0, 0, -1]\nnormal = [0, 0, 1]\nsize = [1, 1]\n{}",
        camera(&FACING)
    );
    let mut opened = Cloud(vec![(point, Vec3::NEG_Z, colour, 0.0, 0.1)]).open(&rest);
    // The mirrored point is 0.5 to the right and 4.5 m away.
    let expected = 32.0 + 0.5 / 4.5 / 30f32.to_radians().tan() * 24.0;
    for way in Way::ALL {
        opened.settings.sscr.pull_levels = 0;
        let products = opened.by(way);
        let mirror = products.mirror.as_ref().expect("a mirror");
        let columns: Vec<f32> = (0..64 * 48)
            .filter(|&i| mirror.at(i).is_some_and(|p| p.albedo.w == 0.0))
            .map(|i| (i % 64) as f32 + 0.5)
            .collect();
        println!("{way:?}: {:?}, columns {columns:?}", products.bounces[0]);
        let middle = columns.iter().sum::<f32>() / columns.len() as f32;
        assert!(
            !columns.is_empty() && (middle - expected).abs() < 1.0,
            "{way:?}: columns {columns:?}, expected {expected}"
        );
    }
}

/// Regions of 4 million pixels and of 4.
fn a_million_to_one() {
    let size = UVec2::new(2048, 2048);
    let mut cells = Grid::new(size, 0);
    for (i, cell) in cells.values_mut().iter_mut().enumerate() {
        let (x, y) = (i % 2048, i / 2048);
        let large = x >= 8;
        let small = x < 2 && y < 2;
        if large || small {
            *cell = PLANAR | PLANAR << Y_SHIFT;
        }
    }
    let map = Labeller::default().lhc(&cells).clone();
    let pixels: Vec<u32> = map.regions.iter().map(|r| r.pixels).collect();
    assert_eq!(pixels, [2040 * 2048, 4]);
    let last = map.regions[1];
    assert_eq!(last.accumulated_weight, 1.0);
    assert!(
        last.weight > 0.9e-6 && last.weight < 1e-6,
        "{}",
        last.weight
    );
    // Of 4 million points 4 are for the small region by weight, and half of them by turns.
    let share = |distribution| {
        let small = |i: &u32| distribute(&map.regions, distribution, *i, 0) == Some(2);
        (0..1u32 << 22).filter(small).count()
    };
    assert_eq!(share(Distribution::Weighted), 4);
    assert_eq!(share(Distribution::Uniform), 1 << 21);
}
