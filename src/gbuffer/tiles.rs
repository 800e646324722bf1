//! Sorts surfels into square tiles of the picture, so that all three passes of a tile stay in a core's cache.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::UVec2;
use rayon::prelude::*;

use super::disc::PixelRect;

/// Side of a tile, pixels: its sums (48 bytes a pixel) and discs fit into the second-level cache.
const TILE: u32 = 32;

/// Surfels a task.
const CHUNK: usize = 1 << 15;

/// Which surfels each tile of a picture may show. Kept between frames: it allocates only when it grows.
#[derive(Debug, Default)]
pub(crate) struct Tiles {
    /// Side of a tile, pixels.
    pub(crate) side: u32,
    /// Tiles per row and column.
    pub(crate) count: UVec2,
    /// First entry of each tile, and the end of the last.
    starts: Vec<u32>,
    /// Surfel indices, tile by tile, ascending.
    entries: Vec<AtomicU32>,
    /// Tile rectangle of each surfel, one byte a bound; see `pack`.
    rects: Vec<u32>,
    /// Entries of each chunk in each tile, then where they go.
    cursors: Vec<u32>,
}

/// A rectangle of tiles in 32 bits: first column, first row, last column, last row.
fn pack(r: PixelRect, shift: u32) -> u32 {
    r.x0 >> shift | (r.y0 >> shift) << 8 | ((r.x1 - 1) >> shift) << 16 | ((r.y1 - 1) >> shift) << 24
}

/// No tile at all: a first column behind the last.
const NOWHERE: u32 = 0xff;

/// Calls `visit` with each tile of a rectangle of tiles, in a picture of so many columns of tiles.
#[inline(always)]
fn for_tiles(rect: u32, columns: u32, mut visit: impl FnMut(usize)) {
    if rect == NOWHERE {
        return;
    }
    let (x0, y0, x1, y1) = (rect & 0xff, rect >> 8 & 0xff, rect >> 16 & 0xff, rect >> 24);
    for y in y0..=y1 {
        for x in x0..=x1 {
            visit((y * columns + x) as usize);
        }
    }
}

impl Tiles {
    /// Sorts surfels 0 to `count` into the tiles that `bounds` says they may cover.
    pub(crate) fn sort(
        &mut self,
        size: UVec2,
        count: usize,
        bounds: impl Fn(usize) -> Option<PixelRect> + Sync,
    ) {
        // Tile coordinates fit into a byte.
        let mut side = TILE;
        while size.max_element().div_ceil(side) > 0xff {
            side *= 2;
        }
        // A surfel that covers many tiles is an entry in each: large splats of many points get larger tiles.
        let budget = count as u64 * 8 + (1 << 22);
        while !self.try_sort(size, side, count, budget, &bounds) {
            side *= 2;
        }
    }

    fn try_sort(
        &mut self,
        size: UVec2,
        side: u32,
        count: usize,
        budget: u64,
        bounds: &(impl Fn(usize) -> Option<PixelRect> + Sync),
    ) -> bool {
        self.side = side;
        self.count = UVec2::new(size.x.div_ceil(side), size.y.div_ceil(side));
        let tiles = (self.count.x * self.count.y) as usize;
        let columns = self.count.x;
        let shift = side.trailing_zeros();

        // Count.
        self.rects.clear();
        self.rects.resize(count, NOWHERE);
        self.cursors.clear();
        self.cursors.resize(count.div_ceil(CHUNK) * tiles, 0);
        self.rects
            .par_chunks_mut(CHUNK)
            .zip(self.cursors.par_chunks_mut(tiles))
            .enumerate()
            .for_each(|(chunk, (rects, counts))| {
                for (i, slot) in rects.iter_mut().enumerate() {
                    if let Some(rect) = bounds(chunk * CHUNK + i) {
                        *slot = pack(rect, shift);
                        for_tiles(*slot, columns, |tile| counts[tile] += 1);
                    }
                }
            });

        // Where each chunk's entries go: tile by tile, within a tile chunk by chunk.
        let total: u64 = self.cursors.par_iter().map(|&n| u64::from(n)).sum();
        if total > budget && tiles > 1 {
            return false;
        }
        self.starts.clear();
        let mut next = 0;
        for tile in 0..tiles {
            self.starts.push(next);
            for cursor in self.cursors.iter_mut().skip(tile).step_by(tiles) {
                next += std::mem::replace(cursor, next);
            }
        }
        self.starts.push(next);

        // Place.
        if self.entries.len() < next as usize {
            self.entries
                .resize_with(next as usize, || AtomicU32::new(0));
        }
        let entries = &self.entries;
        self.rects
            .par_chunks(CHUNK)
            .zip(self.cursors.par_chunks_mut(tiles))
            .enumerate()
            .for_each(|(chunk, (rects, cursors))| {
                for (i, &rect) in rects.iter().enumerate() {
                    for_tiles(rect, columns, |tile| {
                        // Every slot is written once: atomics only make the shared slice safe to write.
                        let slot = cursors[tile] as usize;
                        entries[slot].store((chunk * CHUNK + i) as u32, Ordering::Relaxed);
                        cursors[tile] += 1;
                    });
                }
            });
        true
    }

    /// Surfels that may show in a tile, ascending.
    pub(crate) fn entries(&self, tile: usize) -> impl Iterator<Item = u32> + '_ {
        let range = match (self.starts.get(tile), self.starts.get(tile + 1)) {
            (Some(&start), Some(&end)) => start as usize..end as usize,
            _ => 0..0,
        };
        self.entries[range]
            .iter()
            .map(|e| e.load(Ordering::Relaxed))
    }
}
