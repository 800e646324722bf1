//! Screen-space curved reflections [Preiner 2010, chapters 3 to 5]: the mirrors on screen are labelled into regions of
//! homogeneous curvature, and for every point of the cloud the pixel that shows it is searched by root finding.

pub mod accumulate;
pub mod beam;
pub mod beam_tree;
pub mod chart_class;
pub mod charts;
pub mod curvature;
pub mod distribute;
pub mod field;
pub mod guided;
pub mod heat;
pub mod lhc;
pub mod mirror_error;
mod mirror_pixels;
pub mod newton;
mod outcome;
pub mod prefix;
mod random;
pub mod real;
pub mod root_find;
pub mod scalar;
mod settings;
pub mod shorten;

use crate::gbuffer::disc::PixelRect;
use crate::grid::Grid;

pub(crate) use mirror_pixels::around;
pub use settings::{
    Closing, Distribution, OF_GUIDED, OF_INTERLEAVED, Search, Splatting, SscrSettings, Visibility,
};

/// A region of homogeneous curvature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// The smallest rectangle around it.
    pub bounds: PixelRect,
    /// Its pixels.
    pub pixels: u32,
    /// Its share of all regions' pixels.
    pub weight: f32,
    /// The weights of this and all larger regions together; 1 for the last.
    pub accumulated_weight: f32,
}

/// The labelled homogeneous curvature map: which region each pixel belongs to.
#[derive(Debug, Clone, PartialEq)]
pub struct LhcMap {
    /// Region of each pixel, counted from 1; 0 where there is none.
    pub labels: Grid<u32>,
    /// The regions, largest first; region k is `regions[k - 1]`.
    pub regions: Vec<Region>,
}
