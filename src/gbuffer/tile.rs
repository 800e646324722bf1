//! A tile of the picture while its passes run: everything they touch, small enough for a core's cache.

use wide::f32x4;

use super::EMPTY;
use super::disc::{Disc, PixelRect};
use super::visibility::Sums;
use crate::camera::Pinhole;

/// Pixels that one step of [`Area::visit`] tests together.
const LANES: usize = 4;

/// The pixels of a tile.
#[derive(Debug, Clone, Copy)]
pub struct Area {
    /// The tile's pixels in the picture.
    pub rect: PixelRect,
    /// Values per row: the width, rounded up so that four pixels tested together never leave the row.
    pub stride: usize,
}

/// A tile's working memory; reused from tile to tile.
#[derive(Debug)]
pub struct Tile {
    /// The tile's pixels.
    pub area: Area,
    /// Depth keys, by `area.stride`.
    pub keys: Vec<u32>,
    /// Fragments per pixel.
    pub counts: Vec<u32>,
    /// Scale of the sums, nearest depth and its inverse.
    pub fronts: Vec<[f32; 3]>,
    /// Sums of the visible fragments.
    pub sums: Vec<Sums>,
}

impl Area {
    /// The area of a tile.
    pub fn new(rect: PixelRect) -> Self {
        let width = (rect.x1 - rect.x0) as usize;
        Self {
            rect,
            stride: width.next_multiple_of(LANES) + LANES,
        }
    }

    /// Values in all.
    pub fn values(&self) -> usize {
        self.stride * (self.rect.y1 - self.rect.y0) as usize
    }

    /// Calls `fragment(pixel, depth, squared distance from the centre)` for every pixel of the tile that the disc covers;
    /// `pixel` indexes the tile's values.
    #[inline(always)]
    pub fn visit(&self, disc: &Disc, pinhole: &Pinhole, mut fragment: impl FnMut(usize, f32, f32)) {
        let (b, t) = (disc.bounds, self.rect);
        let (x0, x1) = (b.x0.max(t.x0), b.x1.min(t.x1));
        for y in b.y0.max(t.y0)..b.y1.min(t.y1) {
            let row = (y - t.y0) as usize * self.stride;
            let mut x = x0;
            while x < x1 {
                let first = x as f32 + 0.5;
                let columns = f32x4::from([first, first + 1.0, first + 2.0, first + 3.0]);
                let (depth, distance, mut covered) =
                    disc.fragments(columns, y as f32 + 0.5, pinhole);
                // Columns past the end belong to other tiles.
                covered &= (1u32 << (x1 - x).min(LANES as u32)) - 1;
                if covered != 0 {
                    let (depth, distance) = (depth.to_array(), distance.to_array());
                    let pixel = row + (x - t.x0) as usize;
                    while covered != 0 {
                        let lane = covered.trailing_zeros() as usize & (LANES - 1);
                        fragment(pixel + lane, depth[lane], distance[lane]);
                        covered &= covered - 1;
                    }
                }
                x += LANES as u32;
            }
        }
    }
}

impl Tile {
    /// Working memory for nothing yet.
    pub fn new() -> Self {
        let area = Area {
            rect: PixelRect {
                x0: 0,
                y0: 0,
                x1: 0,
                y1: 0,
            },
            stride: 0,
        };
        Self {
            area,
            keys: Vec::new(),
            counts: Vec::new(),
            fronts: Vec::new(),
            sums: Vec::new(),
        }
    }

    /// An empty tile over `rect`.
    pub fn reset(&mut self, rect: PixelRect) {
        self.area = Area::new(rect);
        refill(&mut self.keys, self.area.values(), EMPTY);
    }

    /// Readies the tile for counting and summing.
    pub fn expect_sums(&mut self) {
        refill(&mut self.counts, self.area.values(), 0);
        refill(&mut self.sums, self.area.values(), Sums::default());
    }

    /// Computes per pixel what [`super::visibility`] needs of the nearest fragment.
    pub fn prepare_fronts(&mut self, front: impl Fn(u32, u32) -> [f32; 3]) {
        self.fronts.clear();
        self.fronts.extend(
            self.keys
                .iter()
                .zip(&self.counts)
                .map(|(&key, &count)| front(key, count)),
        );
    }

    /// Rows of the tile: where each starts in a strip of the picture (all columns, the tile's rows), and its values.
    pub fn rows(
        &self,
        picture_width: usize,
    ) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> + use<> {
        let Area { rect, stride } = self.area;
        (0..(rect.y1 - rect.y0) as usize).map(move |row| {
            let first = row * stride;
            (
                row * picture_width + rect.x0 as usize,
                first..first + (rect.x1 - rect.x0) as usize,
            )
        })
    }
}

impl Default for Tile {
    fn default() -> Self {
        Self::new()
    }
}

fn refill<T: Clone>(values: &mut Vec<T>, len: usize, value: T) {
    values.clear();
    values.resize(len, value);
}
