//! Whether points are spread evenly over a surface, and how many regions a mirror shows.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2, DVec3};

use crate::analytic::{C, Hit, Kind};

/// A surface cut into cells: the area of each, and the cell that a point is in.
pub struct Cells {
    pub shares: Vec<f64>,
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
    pub fn of_radial(radius: impl Fn(DVec3) -> f64) -> Self {
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
    pub fn of_bowl(vertex: DVec3, focal_length: f64, rim: f64) -> Self {
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
    pub fn of_ring(centre: DVec3, tilt: f64, major: f64, minor: f64) -> Self {
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
    pub fn of_square(centre: DVec3, angle: f64, side: f64) -> Self {
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
pub fn chi_square_excess(cells: &Cells, points: &[DVec3]) -> f64 {
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
pub fn regions(picture: &[Hit], width: usize) -> usize {
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
