//! Pass `leak`: empties gaps through which the background shows between the points of a nearer surface, so that pass
//! `fill` closes them. CPU twin of `shaders/leak.wgsl`.
//!
//! A surface of random points leaves gaps of up to about [`LEAK_SPACINGS`]. What is wider, in any of four axes, is a
//! hole of the surface itself and stays.

use rayon::prelude::*;

use super::average::Pixel;
use super::fill::{AGREE_SPACINGS, NEIGHBOURS, Neighbours, neighbour, vote};
use super::{GBuffer, column_row};
use crate::backend::cpu::Cpu;
use crate::job::Job;

/// In so many of the eight directions there must be one nearer surface: a gap between two things has fewer.
pub const LEAK_NEIGHBOURS: usize = 7;

/// Pixels that a search for the nearer surface goes in each direction: gaps as wide as that are found as a whole. Cost
/// grows with it, and wider ones are not closed in three rings.
pub const LEAK_REACH: i32 = 4;

/// Widest gap that points of a surface leave between their discs, in their spacings. The middle of one needs a circle
/// 2.43 spacings in radius without any point: of random points, one place in a hundred million.
pub const LEAK_SPACINGS: f32 = 2.0;

/// A nearer pixel in one direction.
#[derive(Debug, Clone, Copy)]
struct Edge {
    /// Steps to it, from 1.
    steps: i32,
    /// Its surface's spacing, pixels.
    spacing: f32,
}

/// The first pixel from column `x`, row `y` along `step` that is nearer than `depth` by more than the tolerance.
fn edge(gbuffer: &GBuffer<Cpu>, (x, y): (i32, i32), step: (i32, i32), depth: f32) -> Option<Edge> {
    for steps in 1..=LEAK_REACH {
        let u = usize::try_from(x + steps * step.0).ok()?;
        let v = usize::try_from(y + steps * step.1).ok()?;
        // Empty pixels have depth 0.
        let its_depth = gbuffer.surface.get(u, v)?.w;
        if its_depth > 0.0 && its_depth < depth {
            let radius = gbuffer.material.get(u, v)?.z;
            if its_depth + AGREE_SPACINGS * radius < depth {
                let spacing = radius * gbuffer.pinhole.focal / its_depth;
                return Some(Edge { steps, spacing });
            }
        }
    }
    None
}

/// Whether the gap between two edges, in opposite directions along `step`, is one that points leave.
fn narrow(a: Edge, b: Edge, step: (i32, i32)) -> bool {
    let length = ((step.0 * step.0 + step.1 * step.1) as f32).sqrt();
    let width = (a.steps + b.steps - 1) as f32 * length;
    a.steps + b.steps == 2 || width <= LEAK_SPACINGS * a.spacing.min(b.spacing)
}

/// Whether column `x`, row `y` shows the background through a nearer surface.
fn leaks(gbuffer: &GBuffer<Cpu>, x: i32, y: i32) -> bool {
    let Some(own) = gbuffer.at(x, y) else {
        return false;
    };
    let depth = own.surface.w;
    // Few pixels have nearer ones all around: only they are worth the vote.
    let mut edges = [None; 8];
    let mut missing = 0;
    for (found, step) in edges.iter_mut().zip(NEIGHBOURS) {
        *found = edge(gbuffer, (x, y), step, depth);
        missing += usize::from(found.is_none());
        if missing + LEAK_NEIGHBOURS > NEIGHBOURS.len() {
            return false;
        }
    }
    let direct = edges.iter().flatten().filter(|e| e.steps == 1).count();
    // Opposite directions are as far from either end.
    let all_narrow = (0..4)
        .all(|i| (edges[i].zip(edges[7 - i])).is_some_and(|(a, b)| narrow(a, b, NEIGHBOURS[i])));
    if direct < LEAK_NEIGHBOURS && !all_narrow {
        return false;
    }
    let mut seen = Neighbours::default();
    for (edge, step) in edges.iter().zip(NEIGHBOURS) {
        let Some(Edge { steps, .. }) = edge else {
            continue;
        };
        let at = (x + steps * step.0, y + steps * step.1);
        if let Some(pixel) = gbuffer.at(at.0, at.1) {
            seen.push(neighbour(gbuffer, pixel, at, (x, y)));
        }
    }
    let (chosen, votes) = vote(seen.as_slice());
    votes >= LEAK_NEIGHBOURS && chosen.depth + AGREE_SPACINGS * chosen.pixel.material.z < depth
}

/// Empties every pixel that leaks. Repeated with each ring, since what `fill` closes may uncover more.
pub(super) fn leak(gbuffer: &mut GBuffer<Cpu>, job: &Job) {
    let width = gbuffer.material.width();
    let leaking: Vec<(usize, Pixel)> = (0..gbuffer.material.values().len())
        .into_par_iter()
        .filter(|&i| {
            if job.is_cancelled() {
                return false;
            }
            let (x, y) = column_row(i, width);
            leaks(gbuffer, x, y)
        })
        .map(|i| (i, Pixel::default()))
        .collect();
    gbuffer.put(leaking);
}
