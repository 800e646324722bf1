//! Charts: parts of a mirror of one curvature, each with what it can show and where on it a search starts.
//!
//! Where directions and pixels answer each other, a small map, turned to the chart's rays, tells for a direction the pixel
//! that reflects about that way. Where a chart may show a point several times, a [`BeamTree`] finds all places.

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use wide::f32x8;

use super::beam::Beam;
use super::beam_tree::BeamTree;
use super::field::MirrorField;
use super::real::{Real, dot};
use super::{LhcMap, Region};
use crate::cloud::require_memory;
use crate::error::Result;
use crate::job::Job;

/// Regions of fewer pixels join a neighbour.
pub const LEAST_PIXELS: u32 = 48;

/// Charts of fewer cells have no direction map: it would be larger than their trees, and hardly faster.
const LEAST_CELLS: usize = 256;

/// What a mirror pixel's part of its chart takes: its cell twice, and its share of the tree and of the map.
const BYTES: u64 = 64;

/// Cells of a direction map along each axis.
pub const MAP_SIDE: usize = 32;

/// Where searches on a chart start.
#[derive(Debug, Clone, PartialEq)]
pub enum Seeds {
    /// At the pixel that reflects in the direction of the point.
    Map(DirectionMap),
    /// In every tile whose beam may show the point.
    Tree(BeamTree),
}

/// Pixels by the direction of their reflected rays: stereographic around the cone's axis, so that the cone fills the map.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectionMap {
    right: Vec3,
    up: Vec3,
    axis: Vec3,
    /// Half the map's side over the projected radius of the cone.
    scale: f32,
    /// Place in the field, row by row.
    places: Vec<Vec2>,
}

/// A part of the mirrors.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// What it can show.
    pub beam: Beam,
    /// Where searches start.
    pub seeds: Seeds,
    /// Its cells.
    pub cells: u64,
    /// Where searches could start instead of in a tree's tiles, if the map then misses nothing.
    pub(super) shortcut: Option<DirectionMap>,
}

impl DirectionMap {
    /// The map of pixels with their directions; `None` where there is none.
    fn new(beam: &Beam, samples: &[(Vec2, Vec3)]) -> Option<Self> {
        let axis = beam.axis;
        let right = axis.any_orthonormal_vector();
        let half = MAP_SIDE as f32 * 0.5;
        // Tangent of half the cone's angle: the radius that the projection gives it.
        let radius = (beam.sine / (1.0 + beam.cosine).max(1e-3)).clamp(1e-6, 1e3);
        let mut map = Self {
            right,
            up: axis.cross(right),
            axis,
            scale: half / radius,
            places: vec![Vec2::NAN; MAP_SIDE * MAP_SIDE],
        };
        samples.first()?;
        for (place, direction) in samples {
            let cell = Self::cell(map.column_and_row(direction.to_array()));
            map.places[cell] = *place;
        }
        map.fill();
        Some(map)
    }

    /// The column and row of a direction, of any length but 0: from 0 to the map's side.
    #[inline(always)]
    fn column_and_row<T: Real>(&self, direction: [T; 3]) -> [T; 2] {
        let with = |axis: Vec3| dot(axis.to_array().map(T::of), direction);
        let along = with(self.axis) + dot(direction, direction).sqrt();
        let least = T::of(1e-6);
        let over = T::of(self.scale) / along.where_below(least, least, along);
        let middle = T::of(MAP_SIDE as f32 * 0.5);
        [
            with(self.right) * over + middle,
            with(self.up) * over + middle,
        ]
    }

    /// The cell of a column and a row; the nearest beside the map.
    #[inline(always)]
    fn cell([column, row]: [f32; 2]) -> usize {
        let inside = |v: f32| v.clamp(0.0, (MAP_SIDE - 1) as f32) as usize;
        inside(row) * MAP_SIDE + inside(column)
    }

    /// Axes of the map, unit vectors: right, up, and that of the cone.
    pub(crate) fn axes(&self) -> [Vec3; 3] {
        [self.right, self.up, self.axis]
    }

    /// Half the map's side over the projected radius of the cone.
    pub(crate) fn scale(&self) -> f32 {
        self.scale
    }

    /// Places in the field, row by row.
    pub(crate) fn places(&self) -> &[Vec2] {
        &self.places
    }

    /// The places that reflect about in eight directions, of any length but 0.
    #[inline(always)]
    pub(super) fn places_towards(&self, directions: [f32x8; 3]) -> impl Fn(usize) -> Vec2 {
        let [column, row] = self.column_and_row(directions).map(|v| v.to_array());
        move |lane| {
            let cell = Self::cell([column[lane], row[lane]]);
            self.places.get(cell).copied().unwrap_or(Vec2::ZERO)
        }
    }

    /// Empty cells take the place of the nearest that is not, ring by ring.
    fn fill(&mut self) {
        let mut front: Vec<usize> = (0..self.places.len())
            .filter(|&i| !self.places[i].is_nan())
            .collect();
        while !front.is_empty() {
            let mut next = Vec::new();
            for i in front {
                let (x, y) = ((i % MAP_SIDE) as isize, (i / MAP_SIDE) as isize);
                for (dx, dy) in [(1, 0), (0, 1), (-1, 0), (0, -1)] {
                    let (x, y) = (x + dx, y + dy);
                    let side = MAP_SIDE as isize;
                    if x < 0 || y < 0 || x >= side || y >= side {
                        continue;
                    }
                    let neighbour = (y * side + x) as usize;
                    if self.places[neighbour].is_nan() {
                        self.places[neighbour] = self.places[i];
                        next.push(neighbour);
                    }
                }
            }
            front = next;
        }
    }
}

impl Chart {
    fn new(field: &MirrorField, lhc: &LhcMap, label: u32, region: &Region) -> Option<Self> {
        let first = field.place_of_pixel(region.bounds.x0, region.bounds.y0);
        let (x0, y0) = (first.x as u32, first.y as u32);
        let (width, height) = (
            region.bounds.x1 - region.bounds.x0,
            region.bounds.y1 - region.bounds.y0,
        );
        let of_chart = |x: u32, y: u32| {
            lhc.labels.get(
                (x - x0 + region.bounds.x0) as usize,
                (y - y0 + region.bounds.y0) as usize,
            ) == Some(&label)
        };
        let cells: Vec<(u32, u32)> = (y0..y0 + height)
            .flat_map(|y| (x0..x0 + width).map(move |x| (x, y)))
            .filter(|&(x, y)| of_chart(x, y) && field.is_whole(x, y))
            .collect();
        let beam = Beam::around(cells.iter().flat_map(|&(x, y)| corners(field, x, y)));
        let shortcut = if cells.len() >= LEAST_CELLS {
            let sample = |&(x, y): &(u32, u32)| {
                let place = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                Some((place, field.texel(x, y)?.1))
            };
            let samples: Vec<(Vec2, Vec3)> = cells.iter().filter_map(sample).collect();
            DirectionMap::new(&beam, &samples)
        } else {
            None
        };
        Some(Self {
            beam,
            seeds: Seeds::Tree(BeamTree::new(field, &cells)?),
            cells: cells.len() as u64,
            shortcut,
        })
    }
}

/// Mirror points and rays of the four corners of a cell.
pub(super) fn corners(
    field: &MirrorField,
    x: u32,
    y: u32,
) -> impl Iterator<Item = (Vec3, Vec3)> + Clone + '_ {
    [(0, 0), (1, 0), (0, 1), (1, 1)]
        .into_iter()
        .filter_map(move |(dx, dy)| field.texel(x + dx, y + dy))
}

/// The charts of a picture: one a region that has a cell of the field.
///
/// # Errors
/// [`crate::Error::Memory`] where the mirrors are too large, [`crate::Error::Cancelled`].
pub fn charts(field: &MirrorField, lhc: &LhcMap, job: &Job) -> Result<Vec<Chart>> {
    let pixels: u64 = lhc.regions.iter().map(|r| u64::from(r.pixels)).sum();
    require_memory("the charts of the mirrors", pixels * BYTES)?;
    let charts = (lhc.regions.par_iter().enumerate())
        .map(|(k, region)| {
            if job.is_cancelled() {
                return None;
            }
            Chart::new(field, lhc, k as u32 + 1, region)
        })
        .collect::<Vec<_>>();
    job.check()?;
    Ok(charts.into_iter().flatten().collect())
}
