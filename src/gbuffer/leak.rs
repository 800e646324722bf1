//! Pass `leak`: empties single pixels through which the background shows between the points of a nearer surface, so that
//! pass `fill` closes them. CPU twin of `shaders/leak.wgsl`.

use rayon::prelude::*;

use super::average::Pixel;
use super::fill::{AGREE_SPACINGS, neighbours, vote};
use super::{GBuffer, column_row};
use crate::backend::cpu::Cpu;
use crate::job::Job;

/// Of a pixel's eight neighbours, so many must agree on a nearer surface: a gap between two things is wider.
pub const LEAK_NEIGHBOURS: usize = 7;

/// Whether column `x`, row `y` shows the background through a nearer surface.
fn leaks(gbuffer: &GBuffer<Cpu>, ring: u32, x: i32, y: i32) -> bool {
    let Some(own) = gbuffer.at(x, y) else {
        return false;
    };
    let depth = own.surface.w;
    let nearer = |&(dx, dy): &(i32, i32)| {
        gbuffer
            .at(x + dx, y + dy)
            .is_some_and(|p| p.surface.w < depth)
    };
    if super::fill::NEIGHBOURS.iter().filter(|n| nearer(n)).count() < LEAK_NEIGHBOURS {
        return false;
    }
    let seen = neighbours(gbuffer, ring, x, y);
    let (chosen, votes) = vote(seen.as_slice());
    votes >= LEAK_NEIGHBOURS && chosen.depth + AGREE_SPACINGS * chosen.pixel.material.z < depth
}

/// Empties every pixel that leaks, judged by its neighbours before ring `ring`: wider leaks close from their border.
pub(super) fn leak(gbuffer: &mut GBuffer<Cpu>, ring: u32, job: &Job) {
    let width = gbuffer.material.width();
    let leaking: Vec<(usize, Pixel)> = (0..gbuffer.material.values().len())
        .into_par_iter()
        .filter(|&i| {
            if job.is_cancelled() {
                return false;
            }
            let (x, y) = column_row(i, width);
            leaks(gbuffer, ring, x, y)
        })
        .map(|i| (i, Pixel::default()))
        .collect();
    gbuffer.put(leaking);
}
