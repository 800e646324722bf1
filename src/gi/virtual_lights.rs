//! What a frame tells of its virtual lights and of their shadow maps, where it is asked to.
//!
//! All lights are told, and of each bounce the maps of the first ones: any run of lights that follow one another covers the lit
//! surface evenly, so these are a fair sample.

use glam::{UVec2, Vec3};

use super::GiSettings;
use super::bounce::world_from_vpl;
use super::ism::{IsmMaps, direction_of, ism_distance};
use super::vpl::Vpl;
use crate::backend::Backend;
use crate::error::Result;
use crate::gbuffer::EMPTY;
use crate::grid::Grid;

/// Texels of the maps that are kept of each bounce, but one map at least: 32 maps of 64 x 64.
const KEPT_TEXELS: u32 = 1 << 17;

/// A virtual light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VirtualLight {
    /// Where it is, and what it sends.
    pub vpl: Vpl,
    /// How often its light was reflected, it included; 0 is a patch of the environment.
    pub bounce: u32,
}

/// The shadow maps of the first lights of a bounce.
#[derive(Debug, Clone, PartialEq)]
pub struct ShadowMaps {
    /// That of the lights.
    pub bounce: u32,
    /// Number of the first map's light; those of the others follow.
    pub first_light: usize,
    /// One map under the other, each as high as wide: distances from its light, infinite where a map shows nothing.
    pub distances: Grid<f32>,
}

/// The virtual lights of a frame, in the order in which they shine: bounce by bounce.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct VirtualLights {
    /// All lights.
    pub lights: Vec<VirtualLight>,
    /// Maps of each bounce.
    pub maps: Vec<ShadowMaps>,
}

impl VirtualLight {
    /// Where a texel of its map shows a surface at this distance, relative to the scene's origin; `side` is the map's.
    pub fn shown_at(&self, column: u32, row: u32, side: u32, distance: f32) -> Vec3 {
        let towards = world_from_vpl(&self.vpl, direction_of(column, row, side.max(1)));
        self.vpl.position + towards * distance
    }
}

impl ShadowMaps {
    /// Of a map, texels.
    pub fn side(&self) -> usize {
        self.distances.width()
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.distances.height() / self.side().max(1)
    }

    /// The distances of a map, row by row.
    pub fn map(&self, index: usize) -> Option<&[f32]> {
        let texels = self.side() * self.side();
        self.distances
            .values()
            .chunks_exact(texels.max(1))
            .nth(index)
    }
}

impl VirtualLights {
    /// Keeps a batch of lights; of the first batch of a bounce, the first maps.
    pub(super) fn keep<B: Backend>(
        &mut self,
        backend: &mut B,
        bounce: u32,
        batch: &[Vpl],
        isms: &IsmMaps<B>,
    ) -> Result<()> {
        let first_light = self.lights.len();
        let lights = batch.iter().map(|&vpl| VirtualLight { vpl, bounce });
        self.lights.extend(lights);
        let is_first = self.maps.last().is_none_or(|maps| maps.bounce != bounce);
        if !is_first {
            return Ok(());
        }
        let side = isms.slices.side;
        let texels = side * side;
        let count = (KEPT_TEXELS / texels.max(1)).clamp(1, batch.len().max(1) as u32);
        let keys = backend.read(&isms.keys)?;
        let distance = |&key: &u32| {
            if key == EMPTY {
                f32::INFINITY
            } else {
                ism_distance(key)
            }
        };
        let kept = keys.iter().take((count * texels) as usize);
        let distances =
            Grid::from_vec(UVec2::new(side, side * count), kept.map(distance).collect());
        self.maps.extend(distances.map(|distances| ShadowMaps {
            bounce,
            first_light,
            distances,
        }));
        Ok(())
    }

    /// Bytes that they take at most: bounces, but that of the environment, have the lights of the lamps and as many again.
    pub(crate) fn most_bytes(gi: &GiSettings) -> u64 {
        let bounces = u64::from(gi.bounces) + 1;
        let lights = 2 * bounces * u64::from(gi.vpl_count) * size_of::<VirtualLight>() as u64;
        // Maps of an environment are twice as wide.
        let texels = u64::from(KEPT_TEXELS).max(u64::from(gi.ism_size).pow(2) * 4);
        lights + bounces * texels * size_of::<f32>() as u64
    }
}
