//! The nearest neighbours of points, by a k-d tree; local spacing and normals come from them.

use std::num::NonZero;

use glam::Vec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use super::normals::fitted_normal;
use crate::error::{Error, Result};
use crate::job::Job;

/// Neighbours whose distance gives the spacing; fewer are noisy, more smooth it over edges.
pub const SPACING_NEIGHBOURS: usize = 8;

/// Points to which a plane is fitted for a normal, the point itself among them.
pub const NORMAL_NEIGHBOURS: usize = 16;

/// Points between two looks at the job.
const CHUNK: usize = 1 << 14;

/// What is wanted of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Want {
    pub(super) spacing: bool,
    pub(super) normal: bool,
}

/// Estimates what `wanted` says for every point of one cloud: the spacing into `radii` (0 where all neighbours are in
/// the same place), a normal of either sign into `normals` (zero where no plane fits).
///
/// The spacing is the square root of the area a point stands for: `r_k * sqrt(pi / k)`, since a disc of radius `r_k`
/// holds `k` of its neighbours. Results do not depend on the number of threads.
pub(super) fn estimate(
    positions: &[Vec3],
    wanted: impl Fn(usize) -> Want + Sync,
    radii: &mut [f32],
    normals: &mut [Vec3],
    job: &Job,
) -> Result<()> {
    job.progress("sorting points in space", 0, 0)?;
    let points: Vec<[f32; 3]> = positions.iter().map(Vec3::to_array).collect();
    let tree: ImmutableKdTree<f32, 3> = ImmutableKdTree::new_from_slice(&points)
        .map_err(|e| Error::NoPoints(format!("they cannot be sorted in space ({e})")))?;

    let done = std::sync::atomic::AtomicUsize::new(0);
    let chunks = radii
        .par_chunks_mut(CHUNK)
        .zip(normals.par_chunks_mut(CHUNK))
        .enumerate();
    chunks.try_for_each(|(chunk, (radii, normals))| {
        let first = chunk * CHUNK;
        let so_far = done.fetch_add(radii.len(), std::sync::atomic::Ordering::Relaxed);
        job.progress("finding neighbours", so_far as u64, positions.len() as u64)?;
        for (offset, (radius, normal)) in radii.iter_mut().zip(normals).enumerate() {
            let index = first + offset;
            let (want, Some(point)) = (wanted(index), points.get(index)) else {
                continue;
            };
            let count = match want {
                Want { normal: true, .. } => NORMAL_NEIGHBOURS,
                Want { spacing: true, .. } => SPACING_NEIGHBOURS + 1,
                Want { .. } => continue,
            };
            let count = NonZero::new(count).unwrap_or(NonZero::<usize>::MIN);
            let found = tree
                .query(point)
                .nearest_n::<SquaredEuclidean<f32>>(count)
                .execute();
            if want.spacing {
                // The nearest of all is the point itself.
                let neighbours = found.len().saturating_sub(1).min(SPACING_NEIGHBOURS);
                let farthest = found
                    .get(neighbours)
                    .map_or(0.0, |item| item.distance.sqrt());
                *radius = farthest * (std::f32::consts::PI / neighbours.max(1) as f32).sqrt();
            }
            if want.normal {
                let around = found
                    .iter()
                    .filter_map(|item| positions.get(item.item as usize).copied());
                *normal = fitted_normal(around);
            }
        }
        Ok(())
    })
}
