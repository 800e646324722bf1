//! Pass `fill`: closes small holes from the planes of their neighbours. CPU twin of `shaders/fill.wgsl`.
//!
//! Random points leave one pixel in a thousand empty. A hole takes the surface that most of its neighbours agree on,
//! extended to its own ray: on a plane the filled depth is exact. Each run closes one ring of pixels.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::average::Pixel;
use super::leak::leak;
use super::{GBuffer, SplatSettings, column_row};
use crate::backend::cpu::Cpu;
use crate::error::Result;
use crate::job::Job;

/// Neighbours that must show something, of eight (at the picture's border in proportion): a hole is enclosed, so that
/// silhouettes do not grow.
pub const MIN_NEIGHBOURS: usize = 5;

/// Two neighbours agree where their planes meet the hole's ray within this many spacings.
pub const AGREE_SPACINGS: f32 = 4.0;

/// The eight neighbours, row by row.
pub const NEIGHBOURS: [(i32, i32); 8] = [
    (-1, -1),
    (0, -1),
    (1, -1),
    (-1, 0),
    (1, 0),
    (-1, 1),
    (0, 1),
    (1, 1),
];

/// Depth at which the plane of a pixel (its `normal`, its ray `direction` scaled to 1 along the axis, its `depth`) meets
/// the ray `towards`. Where the plane is seen too flatly, the pixel's own depth.
pub fn plane_depth(normal: Vec3, direction: Vec3, depth: f32, towards: Vec3) -> f32 {
    let dot = |a: Vec3, b: Vec3| a.x * b.x + a.y * b.y + a.z * b.z;
    let (from, to) = (dot(normal, direction), dot(normal, towards));
    let met = from / to * depth;
    if met > 0.5 * depth && met < 2.0 * depth {
        met
    } else {
        depth
    }
}

/// A neighbour of a pixel, and the depth at which its plane meets the pixel's ray.
#[derive(Debug, Clone, Copy, Default)]
pub struct Neighbour {
    /// What it shows.
    pub pixel: Pixel,
    /// Along the axis, on the ray of the pixel whose neighbour it is.
    pub depth: f32,
}

/// The neighbours of a pixel that show something.
#[derive(Debug, Clone, Copy, Default)]
pub struct Neighbours {
    all: [Neighbour; 8],
    count: usize,
}

impl Neighbours {
    /// Those that show something, row by row.
    pub fn as_slice(&self) -> &[Neighbour] {
        &self.all[..self.count]
    }

    /// Adds one; there are eight at most.
    pub(super) fn push(&mut self, neighbour: Neighbour) {
        self.all[self.count] = neighbour;
        self.count += 1;
    }
}

/// The pixel at column and row `at`, as the one at `of` takes it for its neighbour.
pub(super) fn neighbour(
    gbuffer: &GBuffer<Cpu>,
    pixel: Pixel,
    at: (i32, i32),
    of: (i32, i32),
) -> Neighbour {
    let depth = plane_depth(
        pixel.surface.truncate(),
        gbuffer.direction(at.0, at.1),
        pixel.surface.w,
        gbuffer.direction(of.0, of.1),
    );
    Neighbour { pixel, depth }
}

/// The neighbours of column `x`, row `y` that were valid before ring `ring`.
pub fn neighbours(gbuffer: &GBuffer<Cpu>, ring: u32, x: i32, y: i32) -> Neighbours {
    let mut seen = Neighbours::default();
    for (dx, dy) in NEIGHBOURS {
        let at = (x + dx, y + dy);
        if let Some(pixel) = (gbuffer.at(at.0, at.1)).filter(|p| p.material.w <= ring as f32) {
            seen.push(neighbour(gbuffer, pixel, at, (x, y)));
        }
    }
    seen
}

/// Whether two neighbours show one surface.
fn agree(a: &Neighbour, b: &Neighbour) -> bool {
    (a.pixel.albedo.w > 0.0) == (b.pixel.albedo.w > 0.0)
        && (a.depth - b.depth).abs() <= AGREE_SPACINGS * a.pixel.material.z
}

/// The neighbour on whose surface most agree (the nearer where two have as many), and their number.
pub fn vote(seen: &[Neighbour]) -> (Neighbour, usize) {
    let mut best = (
        Neighbour {
            depth: f32::INFINITY,
            ..Neighbour::default()
        },
        0,
    );
    for candidate in seen {
        let votes = seen.iter().filter(|other| agree(candidate, other)).count();
        if votes > best.1 || (votes == best.1 && candidate.depth < best.0.depth) {
            best = (*candidate, votes);
        }
    }
    best
}

/// What fills the empty pixel at column `x`, row `y` from pixels that are valid before ring `ring`; `None` where it stays
/// empty.
fn fill_pixel(gbuffer: &GBuffer<Cpu>, ring: u32, x: i32, y: i32) -> Option<Pixel> {
    let seen = neighbours(gbuffer, ring, x, y);
    let seen = seen.as_slice();
    let inside = |x: i32, y: i32| gbuffer.material.get(x as usize, y as usize).is_some();
    let existing = NEIGHBOURS
        .iter()
        .filter(|(dx, dy)| inside(x + dx, y + dy))
        .count();
    if seen.len() * 8 < MIN_NEIGHBOURS * existing {
        return None;
    }
    let (chosen, votes) = vote(seen);
    let (mut normal, mut depth, mut albedo, mut material) =
        (Vec3::ZERO, 0.0, Vec4::ZERO, Vec4::ZERO);
    for voter in seen.iter().filter(|other| agree(&chosen, other)) {
        normal += voter.pixel.surface.truncate();
        depth += voter.depth;
        albedo += voter.pixel.albedo;
        material += voter.pixel.material;
    }
    let inverse = 1.0 / votes as f32;
    let length = (normal.x * normal.x + normal.y * normal.y + normal.z * normal.z).sqrt();
    let normal = if length > 1e-6 {
        normal / length
    } else {
        chosen.pixel.surface.truncate()
    };
    Some(Pixel {
        surface: normal.extend(depth * inverse),
        albedo: albedo * inverse,
        material: (material * inverse).truncate().extend(1.0 + ring as f32),
    })
}

/// Empties leaks and fills holes, ring by ring.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn fill(gbuffer: &mut GBuffer<Cpu>, settings: &SplatSettings, job: &Job) -> Result<()> {
    let width = gbuffer.material.width();
    for ring in 1..=settings.fill {
        leak(gbuffer, job);
        job.check()?;
        let filled: Vec<(usize, Pixel)> = (gbuffer.material.values().par_iter().enumerate())
            .filter(|(_, m)| m.w == 0.0 && !job.is_cancelled())
            .filter_map(|(i, _)| {
                let (x, y) = column_row(i, width);
                fill_pixel(gbuffer, ring, x, y).map(|p| (i, p))
            })
            .collect();
        gbuffer.put(filled);
    }
    job.check()
}
