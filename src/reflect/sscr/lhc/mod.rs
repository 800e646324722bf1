//! The labelled homogeneous curvature map: a mirror's pixels, cut where its curvature changes sign and where it breaks off
//! [Preiner 2010, sections 3.5.2 and 4.4].
//!
//! Four steps, each linear in the pixels and on one core: curvature is smoothed and contour pixels are suppressed
//! (`suppress`), what is left is labelled by tracing contours (`trace`), suppressed pixels join a neighbour's region
//! (`fill`), and the regions are put in order (`regions`).

mod fill;
mod merge;
mod regions;
mod suppress;
mod trace;

use glam::UVec2;

use super::LhcMap;
use crate::gbuffer::disc::PixelRect;
use crate::grid::Grid;

/// A suppressed pixel: the border of a region, left out while labelling [Preiner 2010, figure 4.4].
pub const SUPPRESSED: u8 = 1 << 6;

/// A region while it grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Tally {
    pixels: u32,
    bounds: PixelRect,
}

impl Tally {
    const EMPTY: Self = Self {
        pixels: 0,
        bounds: PixelRect {
            x0: u32::MAX,
            y0: u32::MAX,
            x1: 0,
            y1: 0,
        },
    };

    /// Adds the pixels `x0` to `x1` (exclusive) of row `y`.
    fn add(&mut self, x0: usize, x1: usize, y: usize) {
        self.pixels += (x1 - x0) as u32;
        let b = &mut self.bounds;
        b.x0 = b.x0.min(x0 as u32);
        b.x1 = b.x1.max(x1 as u32);
        b.y0 = b.y0.min(y as u32);
        b.y1 = b.y1.max(y as u32 + 1);
    }
}

/// Labels regions. Keeps its working memory: from the second picture of a size on, it allocates nothing.
#[derive(Debug)]
pub struct Labeller {
    cells: Grid<u8>,
    links: Vec<u8>,
    tallies: Vec<Tally>,
    queue: Vec<usize>,
    order: regions::Order,
    map: LhcMap,
}

impl Default for Labeller {
    fn default() -> Self {
        Self {
            cells: Grid::new(UVec2::ZERO, 0),
            links: Vec::new(),
            tallies: Vec::new(),
            queue: Vec::new(),
            order: regions::Order::default(),
            map: LhcMap {
                labels: Grid::new(UVec2::ZERO, 0),
                regions: Vec::new(),
            },
        }
    }
}

impl Labeller {
    /// The regions of the last picture.
    pub fn map(&self) -> &LhcMap {
        &self.map
    }

    /// The LHC map of a curvature map ([`super::curvature::curvature`]).
    ///
    /// Every mirror pixel gets a label, but those from which no way leads, within the mirror and over no depth step, to
    /// 2 x 2 pixels of one region: no search could start there.
    pub fn lhc(&mut self, curvature: &Grid<u8>) -> &LhcMap {
        self.start(curvature.size());
        suppress::suppress(curvature, &mut self.cells);
        // Suppressed pixels alone tell regions apart [Preiner 2010, section 4.4.1].
        let class = |cell: u8| u8::from(cell != 0 && cell & SUPPRESSED == 0);
        trace::link(&self.cells, class, &mut self.links);
        self.trace();
        fill::Filling {
            cells: &self.cells,
            labels: &mut self.map.labels,
            tallies: &mut self.tallies,
            queue: &mut self.queue,
        }
        .fill();
        regions::put_in_order(&self.tallies, &mut self.order, &mut self.map);
        &self.map
    }

    /// The 4-connected regions of one class.
    ///
    /// `class` says the class of a cell, 0 for none. Two cells of one class are still told apart where the right or the
    /// lower one says that the mirror breaks off ([`super::curvature::X_STEP`], [`super::curvature::Y_STEP`]).
    pub fn label(&mut self, cells: &Grid<u8>, class: impl Fn(u8) -> u8) -> &LhcMap {
        self.start(cells.size());
        trace::link(cells, class, &mut self.links);
        self.trace();
        regions::put_in_order(&self.tallies, &mut self.order, &mut self.map);
        &self.map
    }

    /// Like [`Labeller::label`]; regions of fewer than `least` pixels then join a neighbour.
    pub fn label_merged(
        &mut self,
        cells: &Grid<u8>,
        class: impl Fn(u8) -> u8,
        least: u32,
    ) -> &LhcMap {
        self.start(cells.size());
        trace::link(cells, class, &mut self.links);
        self.trace();
        merge::merge(cells, &mut self.map.labels, &mut self.tallies, least);
        regions::put_in_order(&self.tallies, &mut self.order, &mut self.map);
        &self.map
    }

    /// Makes room for a picture.
    fn start(&mut self, size: UVec2) {
        if self.map.labels.size() == size {
            self.map.labels.values_mut().fill(0);
        } else {
            self.map.labels = Grid::new(size, 0);
            self.cells = Grid::new(size, 0);
            self.links = vec![0; self.cells.values().len()];
        }
        self.tallies.clear();
    }

    fn trace(&mut self) {
        trace::trace(&mut self.links, &mut self.map.labels, &mut self.tallies);
    }
}

#[cfg(test)]
mod tests;
