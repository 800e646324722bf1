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

/// Pixels that a search for the nearer surface goes in each direction; cost grows with it.
pub const LEAK_REACH: i32 = 4;

/// Widest gap that points of a surface leave between their discs, in their spacings. An empty circle 2 x 1.43 spacings
/// wider is needed for it: one pixel in three million shows the middle of a gap of 1.5.
pub const LEAK_SPACINGS: f32 = 2.0;

/// A nearer pixel in one direction.
#[derive(Debug, Clone, Copy)]
struct Edge {
    /// Steps to it, from 1.
    steps: i32,
    /// Its surface's spacing, pixels.
    spacing: f32,
}

/// The first pixel from column `x`, row `y` along `step` that is nearer than `depth` by more than the tolerance, and how
/// far it is.
fn edge(
    gbuffer: &GBuffer<Cpu>,
    (x, y): (i32, i32),
    step: (i32, i32),
    depth: f32,
) -> Option<(Pixel, Edge)> {
    (1..=LEAK_REACH).find_map(|steps| {
        let pixel = gbuffer.at(x + steps * step.0, y + steps * step.1)?;
        let (its_depth, radius) = (pixel.surface.w, pixel.material.z);
        let spacing = radius * gbuffer.pinhole.focal / its_depth;
        (its_depth + AGREE_SPACINGS * radius < depth).then_some((pixel, Edge { steps, spacing }))
    })
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
    let mut edges = [None; 8];
    let mut seen = Neighbours::default();
    for (i, step) in NEIGHBOURS.into_iter().enumerate() {
        if let Some((pixel, edge)) = edge(gbuffer, (x, y), step, depth) {
            let at = (x + edge.steps * step.0, y + edge.steps * step.1);
            seen.push(neighbour(gbuffer, pixel, at, (x, y)));
            edges[i] = Some(edge);
        }
        // Few pixels have nearer ones all around: only they are worth the vote.
        if seen.as_slice().len() + NEIGHBOURS.len() < LEAK_NEIGHBOURS + i + 1 {
            return false;
        }
    }
    let direct = edges.iter().flatten().filter(|e| e.steps == 1).count();
    // Opposite directions are as far from either end.
    let all_narrow = (0..4).all(|i| {
        (edges[i].zip(edges[7 - i])).is_some_and(|(a, b)| narrow(a, b, NEIGHBOURS[i]))
    });
    if direct < LEAK_NEIGHBOURS && !all_narrow {
        return false;
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
