//! Pass `photons`: light that came by way of mirrors, where it landed [Jensen 1996]. CPU twin of `shaders/photons.wgsl`.
//!
//! A photon spreads its flux over the surface around it: flux x k / Z with k = 1 - d^2 / h^2, as far as normals agree. Z is the
//! sum of area x k over a sample of the cloud's own surfels, so that every photon gives off exactly what it carries: at edges,
//! on curved and on noisy surfaces too. h makes so many photons reach a point on average.

use std::f32::consts::PI;

use bytemuck::{Pod, Zeroable};
use glam::{UVec3, Vec3, Vec4};
use rayon::prelude::*;

use super::receivers::Receivers;
use super::vpl::Arrival;
use crate::backend::cpu::Cpu;
use crate::cloud::Surfels;
use crate::error::Result;
use crate::grid::Grid;
use crate::job::Job;

/// Photons that reach a point on average: their noise is a quarter, and their blur a third of a metre in a small room.
const REACHING: f32 = 20.0;

/// Surfels that stand for the surface where photons are weighed.
const SAMPLE: usize = 1 << 15;

/// Cubes along the longest side of the photons' box, at most.
const MAX_CELLS: f32 = 24.0;

/// A photon that landed. Same layout on the GPU (`shaders/photons.wgsl`).
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Photon {
    /// Relative to the scene's origin.
    pub position: Vec3,
    /// 0.
    pub pad0: f32,
    /// Unit vector, on the side from which the light came.
    pub normal: Vec3,
    /// 0.
    pub pad1: f32,
    /// Irradiance where it landed, W/m2 per channel.
    pub irradiance: Vec3,
    /// 0.
    pub pad2: f32,
}

/// Photons, sorted into cubes as wide as they reach.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PhotonMap {
    /// How far a photon reaches.
    pub radius: f32,
    /// Smallest corner of the cubes.
    pub corner: Vec3,
    /// Side of a cube.
    pub cell: f32,
    /// Cubes along each axis.
    pub cells: UVec3,
    /// First photon of each cube, and the end of the last.
    pub starts: Vec<u32>,
    /// The photons, cube by cube.
    pub photons: Vec<Photon>,
}

fn dot(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// How much of a photon's peak reaches a point, 0 to 1.
#[inline(always)]
fn kernel(photon: &Photon, position: Vec3, normal: Vec3, inverse_square: f32) -> f32 {
    let between = position - photon.position;
    let near = 1.0 - dot(between, between) * inverse_square;
    let facing = dot(normal, photon.normal);
    if near > 0.0 && facing > 0.0 {
        near * facing
    } else {
        0.0
    }
}

impl PhotonMap {
    /// A map of what landed on surfaces of `area` in all.
    pub(super) fn new(arrivals: &[Arrival], surfels: &Surfels, area: f32) -> Self {
        if arrivals.is_empty() {
            return Self::default();
        }
        let spacing = arrivals.iter().map(|a| a.spacing).fold(0.0, f32::max);
        let radius = (REACHING * area / (PI * arrivals.len() as f32))
            .sqrt()
            .max(2.0 * spacing)
            .max(f32::MIN_POSITIVE);
        let photon = |a: &Arrival| Photon {
            position: a.position,
            normal: a.normal,
            irradiance: a.incident,
            ..Photon::zeroed()
        };
        let mut map = Self::sorted(radius, arrivals.iter().map(photon).collect());
        map.weigh(surfels);
        map
    }

    /// Photons that reach so far, as they are.
    pub fn sorted(radius: f32, photons: Vec<Photon>) -> Self {
        let positions = || photons.iter().map(|p| p.position);
        let corner = positions().fold(Vec3::INFINITY, Vec3::min);
        let size = positions().fold(Vec3::NEG_INFINITY, Vec3::max) - corner;
        let cell = radius.max(size.max_element() / (MAX_CELLS - 1.0));
        let mut map = Self {
            radius,
            corner,
            cell,
            cells: (size / cell).as_uvec3() + 1,
            ..Self::default()
        };
        map.sort(photons);
        map
    }

    fn cell_of(&self, position: Vec3) -> Option<UVec3> {
        let at = ((position - self.corner) / self.cell).floor();
        let inside = at.cmpge(Vec3::ZERO).all() && at.cmplt(self.cells.as_vec3()).all();
        inside.then(|| at.as_uvec3())
    }

    fn number(&self, cell: UVec3) -> usize {
        ((cell.z * self.cells.y + cell.y) * self.cells.x + cell.x) as usize
    }

    fn sort(&mut self, photons: Vec<Photon>) {
        let mut sorted: Vec<(usize, Photon)> = photons
            .into_iter()
            .map(|p| {
                let cell = self.cell_of(p.position).unwrap_or(UVec3::ZERO);
                (self.number(cell), p)
            })
            .collect();
        sorted.sort_by_key(|(cell, _)| *cell);
        let count = self.cells.element_product() as usize;
        self.starts = (0..=count)
            .map(|cell| sorted.partition_point(|(c, _)| *c < cell) as u32)
            .collect();
        self.photons = sorted.into_iter().map(|(_, p)| p).collect();
    }

    /// Photons that may reach a point, by number, always in the same order.
    fn near(&self, position: Vec3) -> impl Iterator<Item = usize> + '_ {
        let at = ((position - self.corner) / self.cell).floor();
        let last = self.cells.as_vec3() - 1.0;
        let low = (at - 1.0).max(Vec3::ZERO).as_uvec3();
        let high = (at + 1.0).min(last);
        let nothing = high.cmplt(low.as_vec3()).any() || !at.is_finite();
        let high = high.max(Vec3::ZERO).as_uvec3();
        let rows = (low.z..=high.z).flat_map(move |z| (low.y..=high.y).map(move |y| (y, z)));
        rows.filter(move |_| !nothing).flat_map(move |(y, z)| {
            let start = |x: u32| self.starts[self.number(UVec3::new(x, y, z))] as usize;
            let end = self.starts[self.number(UVec3::new(high.x, y, z)) + 1] as usize;
            start(low.x)..end
        })
    }

    /// Turns flux into irradiance.
    fn weigh(&mut self, surfels: &Surfels) {
        let count = surfels.len().min(SAMPLE);
        let share = surfels.len() as f32 / count.max(1) as f32;
        let inverse_square = 1.0 / (self.radius * self.radius);
        let mut weights = vec![0.0f64; self.photons.len()];
        for i in 0..count {
            let (place, finish) = (&surfels.places[i], &surfels.finishes[i]);
            if finish.mirror() > 0.0 {
                continue;
            }
            for p in self.near(place.position) {
                // Both sides of a surfel are one surface.
                let photon = &self.photons[p];
                let n = finish.normal();
                let normal = if dot(n, photon.normal) < 0.0 { -n } else { n };
                let k = kernel(photon, place.position, normal, inverse_square);
                weights[p] += f64::from(k * place.radius * place.radius * share);
            }
        }
        // Where the sample has nothing, the surface is a plane as large as the photon reaches.
        let plane = 0.5 * PI * self.radius * self.radius;
        for (photon, weight) in self.photons.iter_mut().zip(weights) {
            photon.irradiance /= (weight as f32).max(0.05 * plane);
        }
    }
}

/// Adds what photons give to `irradiance`.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn photons(
    receivers: &Receivers<Cpu>,
    map: &PhotonMap,
    irradiance: &mut Grid<Vec4>,
    job: &Job,
) -> Result<()> {
    let inverse_square = 1.0 / (map.radius * map.radius);
    irradiance
        .values_mut()
        .par_iter_mut()
        .zip(receivers.position.values())
        .zip(receivers.normal.values())
        .for_each(|((sum, position), normal)| {
            if !(position.w > 0.0) || job.is_cancelled() {
                return;
            }
            let (position, normal) = (position.truncate(), normal.truncate());
            let mut arrived = sum.truncate();
            for p in map.near(position) {
                let photon = &map.photons[p];
                arrived += photon.irradiance * kernel(photon, position, normal, inverse_square);
            }
            *sum = arrived.extend(sum.w);
        });
    job.check()
}
