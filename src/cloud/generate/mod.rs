//! Generated scenes: a coloured room with a mirror in it, and mirrors put into other scenes.
//!
//! `docs/SCENES.md` defines what is generated. Points are area-uniform over everything in the scene, and the same
//! for the same seed whatever the number of threads.

mod parametric;
mod radial;
mod room;
mod scene_file;
mod scenes;
mod shape;
mod surface;

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DVec3, Vec3};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use rayon::prelude::*;

pub use scene_file::{CloudSource, scene_toml};
pub use scenes::SceneName;
pub use shape::Shape;
pub use surface::{Surface, SurfacePoint};

use self::room::Wall;
use crate::cloud::{RawCloud, TriangleMesh, UpAxis};
use crate::error::{Error, Result};
use crate::job::Job;

/// Number of points of a generated scene where none is given.
pub const DEFAULT_POINTS: usize = 1_600_000;

/// Largest number of points that is generated.
pub const MAX_POINTS: usize = 200_000_000;

/// A room with mirrors, as points.
///
/// `points` of them in all, 1 to [`MAX_POINTS`], spread evenly by area over room and mirrors, each with normal,
/// linear albedo, mirror mark and radius (the spacing: the square root of the area per point). Metres, y up. The
/// same for the same `seed`, whatever the number of threads. `mesh` is the bunny, for `bunny` and `multi`.
///
/// # Errors
/// [`Error::Setting`] for a wrong number of points, or a mesh that is missing or of no use; [`Error::Cancelled`].
pub fn generate(
    name: SceneName,
    points: usize,
    seed: u64,
    mesh: Option<&TriangleMesh>,
    job: &Job,
) -> Result<RawCloud> {
    if !(1..=MAX_POINTS).contains(&points) {
        return Err(Error::Setting(format!(
            "points is {points}; it must be 1 to {MAX_POINTS}"
        )));
    }
    let mut parts = Vec::new();
    for wall in Wall::ALL {
        parts.push(Part {
            surface: wall.shape().surface()?,
            wall: Some(wall),
        });
    }
    for mirror in name.mirrors(mesh)? {
        parts.push(Part {
            surface: mirror.surface()?,
            wall: None,
        });
    }
    let format = format!("generated {name}, seed {seed}");
    sample(&parts, points, seed, job).map(|cloud| RawCloud {
        format,
        up_axis: Some(UpAxis::Y),
        ..cloud
    })
}

/// A mirror that is put into a scene, as points at the scene's `spacing` (its unit of length, above 0).
///
/// Each point has normal, black albedo, mirror mark and radius. The same for the same `seed`.
///
/// # Errors
/// [`Error::Setting`] for a wrong shape or spacing, or where the mirror would need more than [`MAX_POINTS`];
/// [`Error::Cancelled`].
pub fn sample_mirror(shape: &Shape, spacing: f64, seed: u64, job: &Job) -> Result<RawCloud> {
    let surface = shape.surface()?;
    let points = (surface.area() / (spacing * spacing)).ceil().max(1.0);
    if !(spacing > 0.0 && points <= MAX_POINTS as f64) {
        return Err(Error::Setting(format!(
            "a mirror of area {} at the cloud's spacing of {spacing} would need more than {MAX_POINTS} points; \
             make the mirror smaller or check the cloud's unit of length",
            surface.area()
        )));
    }
    let parts = [Part {
        surface,
        wall: None,
    }];
    sample(&parts, points as usize, seed, job).map(|cloud| RawCloud {
        format: "generated mirror".into(),
        ..cloud
    })
}

/// A surface of the scene: a wall, or a mirror.
struct Part {
    surface: Surface,
    wall: Option<Wall>,
}

/// Points that share one stream of random numbers.
const CHUNK: usize = 1 << 14;

fn sample(parts: &[Part], points: usize, seed: u64, job: &Job) -> Result<RawCloud> {
    let areas: Vec<f64> = parts.iter().map(|p| p.surface.area()).collect();
    let area: f64 = areas.iter().sum();
    let ends = shares(&areas, points);
    let mut positions = vec![DVec3::ZERO; points];
    let mut normals = vec![Vec3::ZERO; points];
    let mut albedo = vec![Vec3::ZERO; points];
    let mut mirror = vec![0.0; points];

    let done = AtomicU64::new(0);
    let columns = (
        positions.par_chunks_mut(CHUNK),
        normals.par_chunks_mut(CHUNK),
        albedo.par_chunks_mut(CHUNK),
        mirror.par_chunks_mut(CHUNK),
    );
    columns.into_par_iter().enumerate().try_for_each(
        |(chunk, (positions, normals, albedo, mirror))| {
            let mut rng = Pcg64::seed_from_u64(stream_seed(seed, chunk as u64));
            let rows = positions
                .iter_mut()
                .zip(normals)
                .zip(albedo)
                .zip(mirror)
                .enumerate();
            for (row, (((position, normal), albedo), mirror)) in rows {
                let part = ends.partition_point(|&end| end <= chunk * CHUNK + row);
                let Some(part) = parts.get(part) else {
                    continue;
                };
                let point = part.surface.sample(&mut rng);
                *position = point.position;
                *normal = point.normal.as_vec3();
                match part.wall {
                    Some(wall) => *albedo = wall.albedo(point.position),
                    None => *mirror = 1.0,
                }
            }
            let count = done.fetch_add(CHUNK as u64, Ordering::Relaxed) + CHUNK as u64;
            job.progress("generating points", count.min(points as u64), points as u64)
        },
    )?;

    let names = [
        "x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "mirror", "radius",
    ];
    Ok(RawCloud {
        positions,
        normals: Some(normals),
        albedo: Some(albedo),
        mirror: Some(mirror),
        radii: Some(vec![(area / points as f64).sqrt() as f32; points]),
        column_names: names.map(String::from).to_vec(),
        ..RawCloud::default()
    })
}

/// Where each surface's points end, when `points` are shared by area: whole numbers that add up, none off by one.
fn shares(areas: &[f64], points: usize) -> Vec<usize> {
    let area: f64 = areas.iter().sum();
    let mut sum = 0.0;
    let mut ends: Vec<usize> = areas
        .iter()
        .map(|a| {
            sum += a;
            (sum / area * points as f64).round() as usize
        })
        .collect();
    if let Some(last) = ends.last_mut() {
        *last = points;
    }
    ends
}

/// A seed for the random numbers of a chunk (SplitMix64's finaliser), so that neighbours have nothing in common.
fn stream_seed(seed: u64, chunk: u64) -> u64 {
    let mix = |x: u64| {
        let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    };
    mix(mix(seed.wrapping_add(0x9e37_79b9_7f4a_7c15)).wrapping_add(chunk))
}
