//! Whether points are spread evenly over a surface, and how many regions a mirror shows.

#![expect(clippy::expect_used, reason = "a test fails by panicking")]

use std::f64::consts::{PI, TAU};

use catoptric::cloud::generate::{SceneName, Shape};
use glam::{DMat2, DVec2, DVec3};
use libtest_mimic::Trial;
use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::analytic::{Hit, Kind, Oracle, View};
use crate::forms::C;
use crate::generate::claim;

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim(areas_are_those_of_the_books),
        claim(every_part_of_a_surface_gets_its_share),
        claim(bumps_show_some_two_hundred_regions),
    ]
}

/// The mirror of a scene that has one.
fn mirror_of(name: SceneName) -> Shape {
    let mirrors = name.mirrors(None).expect("a scene that needs no mesh");
    mirrors.into_iter().next().expect("a mirror")
}

fn areas_are_those_of_the_books() {
    let bowl = 8.0 * PI / 3.0 * 0.25f64.powi(2) * ((1.0 + 0.88f64.powi(2)).powf(1.5) - 1.0);
    let facets = |name: &str| {
        let oracle = Oracle::named(name);
        Cells::of_radial(|d| oracle.radius(d))
            .shares
            .iter()
            .sum::<f64>()
    };
    for (name, expected, tolerance) in [
        (SceneName::Sphere, 4.0 * PI * 0.44f64.powi(2), 1e-12),
        (SceneName::Parabola, bowl, 1e-12),
        (SceneName::Torus, 4.0 * PI * PI * 0.36 * 0.13, 1e-12),
        (SceneName::Plane, 0.64, 1e-12),
        // Facets between points of the surface: their area is a little small.
        (SceneName::Blob, facets("blob"), 1e-3),
        (SceneName::Bumps, facets("bumps"), 1e-3),
    ] {
        let area = mirror_of(name).area().expect("a sound mirror");
        assert!(
            (area / expected - 1.0).abs() < tolerance,
            "{name}: got {area}, expected {expected}"
        );
    }
}

fn every_part_of_a_surface_gets_its_share() {
    for name in [
        SceneName::Sphere,
        SceneName::Parabola,
        SceneName::Blob,
        SceneName::Torus,
        SceneName::Plane,
        SceneName::Bumps,
    ] {
        let surface = mirror_of(name).surface().expect("a sound mirror");
        let mut rng = Pcg64::seed_from_u64(7);
        let points: Vec<DVec3> = (0..200_000)
            .map(|_| surface.sample(&mut rng).position)
            .collect();
        let oracle = Oracle::named(name.name());
        let cells = match name {
            SceneName::Parabola => Cells::of_bowl(DVec3::new(0.0, 0.0, -1.3), 0.25, 0.44),
            SceneName::Torus => Cells::of_ring(C, 35f64.to_radians(), 0.36, 0.13),
            SceneName::Plane => Cells::of_square(C, 20f64.to_radians(), 0.8),
            _ => Cells::of_radial(|d| oracle.radius(d)),
        };
        let excess = chi_square_excess(&cells, &points);
        assert!(
            excess < 5.0,
            "{name}: chi-square is {excess} standard deviations above its mean"
        );
        // Negative control: a tenth of the points repeat 500 others.
        let skewed = points
            .iter()
            .enumerate()
            .map(|(i, &p)| if i % 10 == 0 { points[i / 400] } else { p });
        let excess = chi_square_excess(&cells, &skewed.collect::<Vec<_>>());
        assert!(
            excess > 5.0,
            "{name}: repeated points must be seen, got {excess}"
        );
    }
}

/// Counts the regions of 8 pixels or more in which the view normal bends the same way.
fn bumps_show_some_two_hundred_regions() {
    let count = |name: &str| {
        let view = View::REFERENCE;
        regions(&Oracle::named(name).view(&view), view.width)
    };
    let (bumps, sphere) = (count("bumps"), count("sphere"));
    assert!(
        (150..=300).contains(&bumps),
        "the bumps show {bumps} regions"
    );
    assert_eq!(sphere, 1, "a sphere is one region");
}

/// A surface cut into cells: the area of each, and the cell that a point is in.
struct Cells {
    shares: Vec<f64>,
    cell_of: Box<dyn Fn(DVec3) -> usize>,
}

/// Cells across and around.
const ROWS: usize = 8;
const COLUMNS: usize = 16;

/// The cell at fractions `row` and `column`, 0 to 1.
fn cell(row: f64, column: f64) -> usize {
    let index = |part: f64, count: usize| ((part * count as f64) as usize).min(count - 1);
    index(row, ROWS) * COLUMNS + index(column, COLUMNS)
}

/// Angle of (x, y) as a fraction of the full turn.
fn turn(x: f64, y: f64) -> f64 {
    (y.atan2(x) / TAU).rem_euclid(1.0)
}

/// Shares that depend on the row only, from the share of all up to a row's end.
fn by_rows(up_to: impl Fn(f64) -> f64) -> Vec<f64> {
    let end = |i: usize| up_to(i as f64 / ROWS as f64);
    (0..ROWS * COLUMNS)
        .map(|i| (end(i / COLUMNS + 1) - end(i / COLUMNS)) / COLUMNS as f64)
        .collect()
}

impl Cells {
    /// A surface around `C` whose distance is a function of the direction, by the area of fine facets.
    fn of_radial(radius: impl Fn(DVec3) -> f64) -> Self {
        const FINE: usize = 48;
        let point = |row: f64, column: f64| {
            let z = 2.0 * row - 1.0;
            let (sin, cos) = (TAU * column).sin_cos();
            let across = (1.0 - z * z).max(0.0).sqrt();
            let d = DVec3::new(across * cos, across * sin, z);
            d * radius(d)
        };
        let mut shares = vec![0.0; ROWS * COLUMNS];
        let (rows, columns) = (ROWS * FINE, COLUMNS * FINE);
        for row in 0..rows {
            for column in 0..columns {
                let at =
                    |r: usize, c: usize| point(r as f64 / rows as f64, c as f64 / columns as f64);
                let [a, b, c, d] = [
                    at(row, column),
                    at(row, column + 1),
                    at(row + 1, column + 1),
                    at(row + 1, column),
                ];
                let area = ((b - a).cross(c - a).length() + (c - a).cross(d - a).length()) / 2.0;
                shares[row / FINE * COLUMNS + column / FINE] += area;
            }
        }
        let cell_of = |p: DVec3| {
            let d = (p - C).normalize();
            cell((d.z + 1.0) / 2.0, turn(d.x, d.y))
        };
        Self {
            shares,
            cell_of: Box::new(cell_of),
        }
    }

    /// A paraboloid along z, in rings of equal width.
    fn of_bowl(vertex: DVec3, focal_length: f64, rim: f64) -> Self {
        let up_to =
            move |part: f64| (1.0 + (part * rim / (2.0 * focal_length)).powi(2)).powf(1.5) - 1.0;
        let cell_of = move |p: DVec3| {
            let q = p - vertex;
            cell(q.x.hypot(q.y) / rim, turn(q.x, q.y))
        };
        Self {
            shares: by_rows(up_to),
            cell_of: Box::new(cell_of),
        }
    }

    /// A torus whose axis is z, tilted by `tilt` about x; rows are strips of equal angle around the tube.
    fn of_ring(centre: DVec3, tilt: f64, major: f64, minor: f64) -> Self {
        let up_to = move |part: f64| major * TAU * part + minor * (TAU * part).sin();
        let (sin, cos) = tilt.sin_cos();
        let cell_of = move |p: DVec3| {
            let q = p - centre;
            let (u, v, w) = (q.x, q.y * cos + q.z * sin, q.z * cos - q.y * sin);
            cell(turn(u.hypot(v) - major, w), turn(u, v))
        };
        Self {
            shares: by_rows(up_to),
            cell_of: Box::new(cell_of),
        }
    }

    /// An upright square, turned by `angle` about y.
    fn of_square(centre: DVec3, angle: f64, side: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let cell_of = move |p: DVec3| {
            let q = p - centre;
            cell(q.y / side + 0.5, (q.x * cos - q.z * sin) / side + 0.5)
        };
        Self {
            shares: by_rows(|part| part),
            cell_of: Box::new(cell_of),
        }
    }
}

/// How far the chi-square of the points over the cells lies above its mean, in standard deviations.
fn chi_square_excess(cells: &Cells, points: &[DVec3]) -> f64 {
    let mut counts = vec![0.0; cells.shares.len()];
    for &p in points {
        counts[(cells.cell_of)(p)] += 1.0;
    }
    let area: f64 = cells.shares.iter().sum();
    let term = |(count, share): (f64, &f64)| {
        let expected = share / area * points.len() as f64;
        (count - expected).powi(2) / expected
    };
    let chi_square: f64 = counts.into_iter().zip(&cells.shares).map(term).sum();
    let freedom = (cells.shares.len() - 1) as f64;
    (chi_square - freedom) / (2.0 * freedom).sqrt()
}

/// Number of regions of 8 pixels or more on the mirrors of a picture from the reference camera: pixels that share an
/// edge, lie within 10 cm in depth (a ball's rim falls 6 cm from one pixel to the next), and agree in the signs of determinant and trace of the screen-space derivative of
/// the normal.
fn regions(picture: &[Hit], width: usize) -> usize {
    let seen = |i: usize| picture.get(i).filter(|h| matches!(h.kind, Kind::Mirror(_)));
    let together = |a: usize, b: usize| match (seen(a), seen(b)) {
        (Some(a), Some(b)) => (a.t - b.t).abs() < 0.1,
        _ => false,
    };
    let class = |i: usize| {
        seen(i)?;
        // Differences over the neighbours that hang together with the pixel; the camera's x and y are the scene's.
        let slope = |before: usize, after: usize| {
            let (a, b) = (
                if together(before, i) { before } else { i },
                if together(after, i) { after } else { i },
            );
            let steps = f64::from(u8::from(a != i) + u8::from(b != i)).max(1.0);
            match (seen(a), seen(b)) {
                (Some(a), Some(b)) => {
                    DVec2::new(b.normal.x - a.normal.x, b.normal.y - a.normal.y) / steps
                }
                _ => DVec2::ZERO,
            }
        };
        let jacobian = DMat2::from_cols(slope(i - 1, i + 1), slope(i + width, i - width));
        let trace = jacobian.x_axis.x + jacobian.y_axis.y;
        Some(if jacobian.determinant() < 0.0 {
            0
        } else {
            1 + u8::from(trace < 0.0)
        })
    };
    let classes: Vec<Option<u8>> = (0..picture.len()).map(class).collect();
    let mut visited = vec![false; picture.len()];
    let mut count = 0;
    for start in 0..picture.len() {
        if classes[start].is_none() || std::mem::replace(&mut visited[start], true) {
            continue;
        }
        let (mut open, mut size) = (vec![start], 0);
        while let Some(i) = open.pop() {
            size += 1;
            for n in [i - 1, i + 1, i - width, i + width] {
                if classes[n] == classes[i]
                    && together(n, i)
                    && !std::mem::replace(&mut visited[n], true)
                {
                    open.push(n);
                }
            }
        }
        count += usize::from(size >= 8);
    }
    count
}
