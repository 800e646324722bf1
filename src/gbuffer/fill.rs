//! Pass `fill`: closes small holes from the planes of their neighbours. CPU twin of `shaders/fill.wgsl`.
//!
//! Random points leave one pixel in a thousand empty. A hole takes the surface that most of its neighbours agree on,
//! extended to its own ray: on a plane the filled depth is exact. Each run closes one ring of pixels.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::average::Pixel;
use super::{Coverage, GBuffer, SplatSettings, column_row};
use crate::backend::cpu::Cpu;

/// Neighbours that must show something: a hole is enclosed by at least these many of its eight, so that silhouettes do
/// not grow.
pub const MIN_NEIGHBOURS: usize = 5;

/// Two neighbours agree where their planes meet the hole's ray within this many spacings.
pub const AGREE_SPACINGS: f32 = 4.0;

/// The eight neighbours, row by row.
const NEIGHBOURS: [(i32, i32); 8] = [
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

/// What fills the empty pixel at column `x`, row `y` from pixels that are valid before ring `ring`; `None` where it stays
/// empty.
fn fill_pixel(gbuffer: &GBuffer<Cpu>, ring: u32, x: i32, y: i32) -> Option<Pixel> {
    let towards = gbuffer.direction(x, y);

    // Each neighbour's plane on this pixel's ray.
    let mut seen = [(Pixel::default(), 0f32); 8];
    let mut count = 0;
    for (dx, dy) in NEIGHBOURS {
        let (u, v) = (x + dx, y + dy);
        let Some(neighbour) = gbuffer.at(u, v).filter(|p| p.material.w <= ring as f32) else {
            continue;
        };
        let normal = neighbour.surface.truncate();
        let depth = plane_depth(
            normal,
            gbuffer.direction(u, v),
            neighbour.surface.w,
            towards,
        );
        seen[count] = (neighbour, depth);
        count += 1;
    }
    if count < MIN_NEIGHBOURS {
        return None;
    }
    let seen = &seen[..count];

    // The surface on which most neighbours agree; the nearer where two have as many.
    let agree = |a: &(Pixel, f32), b: &(Pixel, f32)| {
        (a.0.albedo.w > 0.0) == (b.0.albedo.w > 0.0)
            && (a.1 - b.1).abs() <= AGREE_SPACINGS * a.0.material.z
    };
    let mut best = (0, f32::INFINITY, 0);
    for (i, candidate) in seen.iter().enumerate() {
        let votes = seen.iter().filter(|other| agree(candidate, other)).count();
        if votes > best.0 || (votes == best.0 && candidate.1 < best.1) {
            best = (votes, candidate.1, i);
        }
    }
    let chosen = seen[best.2];

    // Their mean.
    let (mut normal, mut depth, mut albedo, mut material) =
        (Vec3::ZERO, 0.0, Vec4::ZERO, Vec4::ZERO);
    for voter in seen.iter().filter(|other| agree(&chosen, other)) {
        normal += voter.0.surface.truncate();
        depth += voter.1;
        albedo += voter.0.albedo;
        material += voter.0.material;
    }
    let inverse = 1.0 / best.0 as f32;
    let length = (normal.x * normal.x + normal.y * normal.y + normal.z * normal.z).sqrt();
    let normal = if length > 1e-6 {
        normal / length
    } else {
        chosen.0.surface.truncate()
    };
    Some(Pixel {
        surface: normal.extend(depth * inverse),
        albedo: albedo * inverse,
        material: (material * inverse).truncate().extend(1.0 + ring as f32),
    })
}

/// Fills holes ring by ring, and counts what is covered.
pub fn fill(gbuffer: &mut GBuffer<Cpu>, settings: &SplatSettings) -> Coverage {
    let width = gbuffer.material.width();
    let valid =
        |g: &GBuffer<Cpu>| g.material.values().par_iter().filter(|m| m.w > 0.0).count() as u64;
    let pixels = gbuffer.material.values().len() as u64;
    let splatted = valid(gbuffer);
    if splatted < pixels {
        for ring in 1..=settings.fill {
            let filled: Vec<(usize, Pixel)> = (gbuffer.material.values().par_iter().enumerate())
                .filter(|(_, m)| m.w == 0.0)
                .filter_map(|(i, _)| {
                    let (x, y) = column_row(i, width);
                    fill_pixel(gbuffer, ring, x, y).map(|p| (i, p))
                })
                .collect();
            gbuffer.put(filled);
        }
    }
    let mirror = gbuffer
        .albedo
        .values()
        .par_iter()
        .filter(|a| a.w > 0.0)
        .count() as u64;
    Coverage {
        pixels,
        splatted,
        filled: valid(gbuffer),
        mirror,
    }
}
