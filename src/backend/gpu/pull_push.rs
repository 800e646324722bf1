//! Pass `pull_push` on the device, level by level. Twin: `src/gbuffer/pull_push.rs`.

use std::ops::Range;

use glam::{UVec2, Vec4};

use super::Gpu;
use super::buffers::GpuGrid;
use super::kernel::{Pass, Threads};
use super::layout::{gpu_layout, gpu_struct};
use super::shaders::{PULL, PULL_FINEST, PUSH};
use super::windows::{Need, rows_of, windows};
use crate::error::Result;
use crate::job::Job;
use crate::reflect::MirrorGBuffer;

gpu_struct! {
    /// A cell of the pyramid.
    pub(super) struct Cell {
        /// Unit normal, and distance.
        surface: Vec4,
        /// Linear RGB, and mirror reflectance.
        albedo: Vec4,
        /// Specular reflectance, shininess, radius; w is the cell's weight.
        material: Vec4,
        /// Relative to the scene's origin.
        position: Vec4,
    }
}

gpu_struct! {
    /// What one dispatch of `pull_finest` or `pull` works on.
    pub(super) struct PullParams {
        /// Of the level, cells.
        size: UVec2,
        /// Of the level below.
        below: UVec2,
        /// Rows of the level: first, and one past the last.
        rows: UVec2,
        /// Number of the level's first cell in its binding, row by row.
        first_cell: u32,
        /// As `first_cell`, of the level below.
        first_below: u32,
    }
}

gpu_struct! {
    /// What one dispatch of `push` works on.
    pub(super) struct PushParams {
        /// Of the picture, pixels.
        size: UVec2,
        /// First row, and one past the last.
        rows: UVec2,
        /// Number of the bindings' first pixel, row by row.
        first_pixel: u32,
        /// Number of the level's first cell in its binding, row by row.
        first_cell: u32,
        /// Of the level, cells.
        width: u32,
        /// Halvings.
        level: u32,
    }
}

/// What a cell needs: four of the level below.
const PULL_NEED: Need = Need {
    halo: 0,
    bytes: 4 * size_of::<Cell>() as u64,
    steps: 16,
};

/// What a pixel needs: a cell at most.
const PUSH_NEED: Need = Need {
    halo: 0,
    bytes: size_of::<Cell>() as u64,
    steps: 4,
};

/// Rows of the level below that make so many rows of a level.
fn rows_below(rows: &Range<u32>, below: UVec2) -> Range<u32> {
    2 * rows.start..(2 * rows.end).min(below.y)
}

impl Gpu {
    /// Pass `pull_push`.
    pub(super) fn run_pull_push(
        &mut self,
        mirror: &mut MirrorGBuffer<Self>,
        levels: u32,
        job: &Job,
    ) -> Result<()> {
        if levels == 0 {
            return job.check();
        }
        let size = mirror.origin.size();
        let finest = self.kernels.get(&self.device, &PULL_FINEST)?;
        let pull = self.kernels.get(&self.device, &PULL)?;
        let push = self.kernels.get(&self.device, &PUSH)?;
        let limits = &self.device.limits;
        let mut pass = Pass::new("pull_push", &self.device, &self.pool, self.stamps.as_ref());
        let (mut pyramid, mut below) = (Vec::<GpuGrid<Cell>>::new(), size);
        for _ in 0..levels {
            let half = UVec2::new(below.x.div_ceil(2), below.y.div_ceil(2));
            let level = GpuGrid::<Cell>::new(&self.pool, half)?;
            for window in windows(half, PULL_NEED, limits) {
                let cells = rows_of(half, &window.rows);
                let under = rows_of(below, &rows_below(&window.rows, below));
                let params = PullParams {
                    size: half,
                    below,
                    rows: UVec2::new(window.rows.start, window.rows.end),
                    first_cell: cells.start,
                    first_below: under.start,
                };
                let compute = match pyramid.last() {
                    None => pass
                        .compute(&finest, &params)
                        .read(mirror.origin.part(&under))
                        .read(mirror.direction.part(&under))
                        .read(mirror.surface.part(&under))
                        .read(mirror.albedo.part(&under))
                        .read(mirror.material.part(&under)),
                    Some(finer) => pass.compute(&pull, &params).read(finer.part(&under)),
                };
                compute
                    .write(level.part(&cells))
                    .dispatch(window.threads(half))?;
            }
            pyramid.push(level);
            below = half;
        }
        for (i, level) in pyramid.iter().enumerate() {
            let halvings = i as u32 + 1;
            for window in windows(size, PUSH_NEED, limits) {
                let rows = &window.rows;
                let last = (rows.end - 1) >> halvings;
                let cells = rows_of(level.size(), &(rows.start >> halvings..last + 1));
                let params = PushParams {
                    size,
                    rows: UVec2::new(rows.start, rows.end),
                    first_pixel: window.pixels.start,
                    first_cell: cells.start,
                    width: level.size().x,
                    level: halvings,
                };
                pass.compute(&push, &params)
                    .read(level.part(&cells))
                    .read(mirror.origin.part(&window.pixels))
                    .read(mirror.direction.part(&window.pixels))
                    .write(mirror.surface.part(&window.pixels))
                    .write(mirror.albedo.part(&window.pixels))
                    .write(mirror.material.part(&window.pixels))
                    .write(mirror.level.part(&window.pixels))
                    .dispatch(Threads::Pixels(UVec2::new(size.x, rows.end - rows.start)))?;
            }
        }
        pass.finish(&mut self.timings, job)
    }
}
