//! Pass `chart_class`: how a mirror is curved in each pixel, whichever way it is turned: convex, concave, a saddle or flat.
//!
//! From the second fundamental form: with the slopes P_x, P_y of the mirror's points and N_x, N_y of its normals per pixel,
//! L = N_x . P_x, M = (N_x . P_y + N_y . P_x) / 2, N = N_y . P_y. A negative determinant L N - M^2 is a saddle; else the sign
//! of the trace of the form over the metric tells convex from concave. Unlike the classes of pass `curvature` this does not
//! change when the picture is turned, so that a boundary is one whichever way it runs.

use glam::{Vec3, Vec4Swizzles};
use rayon::prelude::*;

use super::curvature::{X_STEP, Y_STEP};
use crate::backend::cpu::Cpu;
use crate::grid::Grid;
use crate::reflect::Surface;

/// Curved outwards in every direction.
pub const CHART_CONVEX: u8 = 1;
/// Curved inwards in every direction.
pub const CHART_CONCAVE: u8 = 2;
/// Curved outwards one way and inwards the other.
pub const CHART_SADDLE: u8 = 3;
/// Not curved, as far as the noise of the normals tells.
pub const CHART_FLAT: u8 = 4;
/// Bits of the class.
pub const CHART_CLASS: u8 = 0b111;

/// Pixels to each side over which slopes are measured, where the mirror goes that far.
const REACH: usize = 2;

/// The slope of a normal that counts, in multiples of its noise.
const NOISES: f32 = 5.0;

/// Pixels between which noise is measured: farther apart than smoothing (`splat.smooth`) ties them to each other.
const LAG: usize = 5;

/// The class of every mirror pixel, with the steps of `curvature` ([`X_STEP`], [`Y_STEP`]); 0 where there is no mirror.
pub fn chart_class(surface: &Surface<Cpu>, curvature: &Grid<u8>) -> Grid<u8> {
    let flat = NOISES * noise(surface, curvature);
    let mut classes = Grid::new(surface.size, 0u8);
    let width = classes.width().max(1);
    let rows = classes.values_mut().par_chunks_mut(width).enumerate();
    rows.for_each(|(y, row)| {
        for (x, class) in row.iter_mut().enumerate() {
            let cell = curvature.get(x, y).copied().unwrap_or(0);
            if cell != 0 {
                *class = class_of(surface, curvature, x, y, flat) | cell & (X_STEP | Y_STEP);
            }
        }
    });
    classes
}

/// Standard deviation of the normals' components from pixel to pixel: from second differences, which smooth curvature hardly
/// touches, of every few pixels; their median, so that edges do not count.
fn noise(surface: &Surface<Cpu>, curvature: &Grid<u8>) -> f32 {
    let width = surface.size.x as usize;
    let normals = surface.normal.values();
    let cells = curvature.values();
    let same = |i: usize| cells[i] != 0 && cells[i] & X_STEP == 0;
    let mut differences: Vec<f32> = (LAG..normals.len().saturating_sub(LAG))
        .into_par_iter()
        .filter(|&i| i % 3 == 0 && i % width >= LAG && i % width + LAG < width)
        .filter(|&i| cells[i - LAG] != 0 && (i + 1 - LAG..=i + LAG).all(same))
        .map(|i| {
            let bend = normals[i - LAG] - normals[i] * 2.0 + normals[i + LAG];
            bend.xyz().length()
        })
        .collect();
    if differences.is_empty() {
        return 0.0;
    }
    let middle = differences.len() / 2;
    let (_, median, _) = differences.select_nth_unstable_by(middle, f32::total_cmp);
    // The variance of a second difference is 1 + 4 + 1 times that of a normal.
    *median / 6f32.sqrt()
}

/// How far from a pixel the mirror goes without a step, up to [`REACH`] pixels: back, and forth, along x or y.
fn reaches(curvature: &Grid<u8>, x: usize, y: usize, along_x: bool) -> (usize, usize) {
    let step = if along_x { X_STEP } else { Y_STEP };
    let at = |k: isize| {
        let (dx, dy) = if along_x { (k, 0) } else { (0, k) };
        let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
        curvature.get(x, y).copied().filter(|&c| c != 0)
    };
    let joins = |k: isize| at(k).is_some_and(|c| c & step == 0);
    let reach = REACH as isize;
    let back = (0..reach).take_while(|k| joins(-k) && at(-k - 1).is_some());
    let forth = (1..=reach).take_while(|k| joins(*k));
    (back.count(), forth.count())
}

fn class_of(surface: &Surface<Cpu>, curvature: &Grid<u8>, x: usize, y: usize, flat: f32) -> u8 {
    // Slopes of points and normals along x and y, and how far apart they were measured.
    let slope = |along_x: bool| {
        let (back, forth) = reaches(curvature, x, y, along_x);
        let at = |forwards: isize| {
            let (dx, dy) = if along_x {
                (forwards, 0)
            } else {
                (0, forwards)
            };
            let (x, y) = (x.saturating_add_signed(dx), y.saturating_add_signed(dy));
            let point = surface.point.get(x, y).copied().unwrap_or_default();
            let normal = surface.normal.get(x, y).copied().unwrap_or_default();
            (point.xyz(), normal.xyz())
        };
        let span = (back + forth).max(1) as f32;
        let (first, last) = (at(-(back as isize)), at(forth as isize));
        ((last.0 - first.0) / span, (last.1 - first.1) / span, span)
    };
    let (px, nx, x_span) = slope(true);
    let (py, ny, y_span) = slope(false);
    let (nx, ny) = (quiet(nx, flat / x_span), quiet(ny, flat / y_span));
    if nx == Vec3::ZERO && ny == Vec3::ZERO {
        return CHART_FLAT;
    }
    let (l, n) = (nx.dot(px), ny.dot(py));
    let m = 0.5 * (nx.dot(py) + ny.dot(px));
    // A cylinder is neither: where the smaller curvature drowns in noise, the larger decides.
    let drowned =
        flat / x_span.min(y_span) * nx.length().max(ny.length()) * px.length() * py.length();
    if l * n - m * m < -drowned {
        return CHART_SADDLE;
    }
    let (e, f, g) = (px.dot(px), px.dot(py), py.dot(py));
    if l * g - 2.0 * m * f + n * e >= 0.0 {
        CHART_CONVEX
    } else {
        CHART_CONCAVE
    }
}

/// A slope, or none where it is no more than noise.
fn quiet(slope: Vec3, flat: f32) -> Vec3 {
    if slope.length() > flat {
        slope
    } else {
        Vec3::ZERO
    }
}
