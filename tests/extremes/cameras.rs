//! Where the camera stands, and how much of the mirror it sees.

use catoptric::renderer::Products;
use glam::DVec3;
use libtest_mimic::Trial;

use super::{SMALL, Seen, each};
use crate::analytic::View;
use crate::forms::C;
use crate::rendered::{Opened, Way};
use crate::shown::position;
use crate::support::claim;

pub(super) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "extremes::a_mirror_of_four_pixels_shows_four_walls",
            a_mirror_of_four_pixels,
        ),
        claim(
            "extremes::a_mirror_that_fills_the_screen_is_one_region_and_shows_what_is_behind_the_eye",
            a_mirror_that_fills_the_screen,
        ),
        claim(
            "extremes::where_no_mirror_is_in_sight_nothing_is_searched",
            no_mirror_in_sight,
        ),
        claim(
            "extremes::a_pane_at_78_and_88_degrees_shows_what_it_ought_to",
            grazing,
        ),
        claim(
            "extremes::a_field_of_view_of_150_degrees_does_no_harm",
            wide_angle,
        ),
        claim(
            "extremes::rays_from_the_focus_leave_the_parabola_in_parallel",
            at_the_focus,
        ),
        claim(
            "extremes::the_parabola_turns_its_picture_over_before_the_focus_and_not_behind_it",
            before_and_behind_the_focus,
        ),
        claim(
            "extremes::from_inside_of_its_hole_the_torus_shows_the_room",
            inside_the_hole,
        ),
    ]
}

fn a_mirror_of_four_pixels() {
    let tiny = View {
        width: 8,
        height: 6,
        ..View::REFERENCE
    };
    for Seen {
        way,
        products,
        figures,
    } in each("sphere", 50_000, &tiny)
    {
        assert_eq!(products.coverage.mirror, 4, "{way:?}");
        assert_eq!(products.bounces[0].regions, 1, "{way:?}");
        assert_eq!(products.bounces[0].coverage_closed, 1.0, "{way:?}");
        // A splat of one pixel spans a wall: what is found there lies about as far away.
        assert!(figures.median < 0.3, "{way:?}: {figures:?}");
    }
}

fn a_mirror_that_fills_the_screen() {
    let near = View {
        position: DVec3::new(0.0, 0.0, -0.5),
        ..SMALL
    };
    for Seen {
        way,
        products,
        figures,
    } in each("sphere", 200_000, &near)
    {
        // Here and there the wall is seen between two points, which lie ten pixels apart.
        let mirror = products.coverage.mirror;
        assert!(mirror > 160 * 120 * 995 / 1000, "{way:?}: {mirror}");
        // Normals of points ten pixels apart are steps, which charts take for curvature: more cost, no harm.
        let regions = products.bounces[0].regions;
        let most = if way == Way::Guided { 64 } else { 1 };
        assert!((1..=most).contains(&regions), "{way:?}: {regions} regions");
        assert!(
            figures.coverage > 0.99 && figures.psnr > figures.black + 10.0,
            "{way:?}: {figures:?}"
        );
        // The centre looks back at the front wall, past the eye.
        let mirror = products.mirror.as_ref().expect("a mirror");
        let centre = position(mirror, 60 * 160 + 80).expect("it shows something");
        assert!(centre.distance(DVec3::Z) < 0.1, "{way:?}: {centre}");
    }
}

fn no_mirror_in_sight() {
    let away = View {
        target: DVec3::new(0.0, 0.0, 2.0),
        position: DVec3::new(0.0, 0.0, -0.4),
        ..SMALL
    };
    let mut opened = Opened::generated("sphere", 50_000, &away);
    for way in Way::ALL {
        let products = opened.by(way);
        assert!(products.mirror.is_none() && products.bounces.is_empty());
        assert_eq!(products.coverage.mirror, 0);
        assert_eq!(products.coverage.filled, 160 * 120, "the wall is seen");
        let passes: Vec<&str> = products.passes.iter().map(|p| p.name.as_str()).collect();
        let of_mirrors = ["lhc", "root_find", "ray_trace", "ray_trace_build"];
        assert!(
            !passes.iter().any(|p| of_mirrors.contains(p)),
            "{way:?} ran {passes:?}"
        );
    }
}

/// The scene "plane" from so many degrees off its normal.
pub(super) fn around_the_pane(degrees: f64) -> View {
    let angle = (20.0 + degrees).to_radians();
    View {
        position: C + DVec3::new(angle.sin(), 0.0, angle.cos()) * 0.9,
        target: C,
        fov_y_degrees: 50.0,
        ..SMALL
    }
}

fn grazing() {
    // At 88 degrees few points are found: closing by 4 levels leaves a part of the pane empty.
    for (degrees, points, least) in [(78.0, 100_000, 0.99), (88.0, 200_000, 0.8)] {
        for Seen {
            way,
            products,
            figures,
        } in each("plane", points, &around_the_pane(degrees))
        {
            // Noise that a tilted pane's few rows cannot tell from curvature cuts it into a few charts, which cost little.
            let regions = products.bounces[0].regions;
            let most = if way == Way::Guided { 8 } else { 1 };
            assert!(
                (1..=most).contains(&regions),
                "{degrees}, {way:?}: {regions} regions"
            );
            let least = if way == Way::RayTrace { 0.99 } else { least };
            assert!(figures.coverage > least, "{degrees}, {way:?}: {figures:?}");
            // Normals of a plane have no noise, and what is seen lies on walls.
            assert!(figures.median < 1e-4, "{degrees}, {way:?}: {figures:?}");
            assert!(
                figures.psnr > figures.moved,
                "{degrees}, {way:?}: {figures:?}"
            );
        }
    }
}

fn wide_angle() {
    let centred = View {
        position: DVec3::new(0.0, 0.0, -0.3),
        fov_y_degrees: 150.0,
        ..SMALL
    };
    let in_the_corner = View {
        target: centred.position + DVec3::new(-1.5, -1.2, -0.6),
        ..centred
    };
    for view in [centred, in_the_corner] {
        for Seen {
            way,
            products,
            figures,
        } in each("sphere", 200_000, &view)
        {
            let mirror = products.coverage.mirror;
            assert!(mirror > 300, "{way:?}: {mirror} pixels");
            assert!(
                figures.coverage > 0.98 && figures.median < 0.04 && figures.psnr > figures.moved,
                "{way:?}: {figures:?}"
            );
        }
    }
}

/// The parabola's focus.
const FOCUS: DVec3 = DVec3::new(0.0, 0.0, -1.05);

/// Into the parabola, from so far before its focus.
pub(super) fn into_the_parabola(before_focus: f64) -> View {
    View {
        position: FOCUS + DVec3::Z * before_focus,
        target: DVec3::new(0.0, 0.0, -1.3),
        fov_y_degrees: 70.0,
        ..SMALL
    }
}

fn at_the_focus() {
    for Seen {
        way,
        products,
        figures,
    } in each("parabola", 200_000, &into_the_parabola(0.0))
    {
        let mirror = products.mirror.as_ref().expect("a mirror");
        let mut off: Vec<f64> = (0..mirror.origin.values().len())
            .filter_map(|i| {
                let from = mirror.origin.values()[i].truncate().as_dvec3();
                // What it shows lies straight before the mirror, on the front wall.
                Some(position(mirror, i)?.distance(from.with_z(1.0)))
            })
            .collect();
        off.sort_by(f64::total_cmp);
        let (shown, median) = (off.len(), off[off.len() / 2]);
        println!("{way:?}: half of {shown} pixels within {median:.4} m of straight on");
        assert!(median < 0.04, "{way:?}: {median}");
        // Only what lies straight before the mirror is shown, a point for every sixth pixel.
        let least = if way == Way::RayTrace { 0.99 } else { 0.8 };
        assert!(figures.coverage > least, "{way:?}: {figures:?}");
    }
}

/// The mean of x of what the right half of the mirror shows.
fn to_the_right(products: &Products) -> f64 {
    let mirror = products.mirror.as_ref().expect("a mirror");
    let shown: Vec<f64> = (0..mirror.origin.values().len())
        .filter(|&i| mirror.origin.values()[i].x > 0.02)
        .filter_map(|i| Some(position(mirror, i)?.x))
        .collect();
    shown.iter().sum::<f64>() / shown.len() as f64
}

fn before_and_behind_the_focus() {
    for (before, turned_over) in [(0.5, true), (0.15, true), (-0.08, false)] {
        for Seen {
            way,
            products,
            figures,
        } in each("parabola", 200_000, &into_the_parabola(before))
        {
            let right = to_the_right(&products);
            assert_eq!(
                right < 0.0,
                turned_over,
                "{before} m before the focus, {way:?}: the right half shows x = {right}"
            );
            assert!(
                figures.coverage > 0.8 && figures.psnr > figures.black + 5.0,
                "{before} m before the focus, {way:?}: {figures:?}"
            );
        }
    }
}

fn inside_the_hole() {
    let inside = View {
        position: C,
        target: C + DVec3::X,
        fov_y_degrees: 90.0,
        ..SMALL
    };
    for Seen {
        way,
        products,
        figures,
    } in each("torus", 200_000, &inside)
    {
        assert!(products.coverage.mirror > 4000, "{way:?}");
        assert!(
            figures.coverage > 0.9 && figures.psnr > figures.black + 3.0,
            "{way:?}: {figures:?}"
        );
    }
}
