//! The nearest neighbours of points, by a k-d tree; local spacing and normals come from them.

use std::num::NonZero;
use std::sync::atomic::{AtomicU64, Ordering};

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

/// Bits of each axis in the curve through space.
const CURVE_BITS: u32 = 16;

/// What is wanted of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Want {
    pub(super) spacing: bool,
    pub(super) normal: bool,
}

/// What its neighbours say of a point.
#[derive(Clone, Copy)]
struct Estimate {
    spacing: f32,
    normal: Vec3,
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
    // Along a curve through space, what one query has read the next one needs.
    job.progress("sorting points in space", 0, 0)?;
    let order = along_curve(positions);
    let points: Vec<[f32; 3]> = order
        .par_iter()
        .map(|&i| positions[i as usize].to_array())
        .collect();
    let tree: ImmutableKdTree<f32, 3> = ImmutableKdTree::new_from_slice(&points)
        .map_err(|e| Error::NoPoints(format!("they cannot be sorted in space ({e})")))?;

    let done = AtomicU64::new(0);
    let chunks = order
        .par_chunks(CHUNK)
        .zip(points.par_chunks(CHUNK))
        .map(|(indices, queries)| {
            let so_far = done.fetch_add(indices.len() as u64, Ordering::Relaxed);
            job.progress("finding neighbours", so_far, order.len() as u64)?;
            let one = |(&index, point)| estimate_one(&tree, &points, point, wanted(index as usize));
            Ok(indices.iter().zip(queries).map(one).collect())
        });
    let estimates: Vec<Vec<Estimate>> = chunks.collect::<Result<_>>()?;

    for (index, estimate) in order.into_iter().zip(estimates.into_iter().flatten()) {
        let index = index as usize;
        let want = wanted(index);
        if want.spacing {
            radii[index] = estimate.spacing;
        }
        if want.normal {
            normals[index] = estimate.normal;
        }
    }
    Ok(())
}

/// `points` are those of the tree, in its order of items.
fn estimate_one(
    tree: &ImmutableKdTree<f32, 3>,
    points: &[[f32; 3]],
    point: &[f32; 3],
    want: Want,
) -> Estimate {
    let count = match want {
        Want { normal: true, .. } => NORMAL_NEIGHBOURS,
        Want { spacing: true, .. } => SPACING_NEIGHBOURS + 1,
        Want { .. } => {
            return Estimate {
                spacing: 0.0,
                normal: Vec3::ZERO,
            };
        }
    };
    let count = NonZero::new(count).unwrap_or(NonZero::<usize>::MIN);
    let found = tree
        .query(point)
        .nearest_n::<SquaredEuclidean<f32>>(count)
        .execute();

    // The nearest of all is the point itself.
    let neighbours = found.len().saturating_sub(1).min(SPACING_NEIGHBOURS);
    let farthest = found
        .get(neighbours)
        .map_or(0.0, |item| item.distance.sqrt());
    let spacing = farthest * (std::f32::consts::PI / neighbours.max(1) as f32).sqrt();
    let normal = match want.normal {
        true => fitted_normal(
            found
                .iter()
                .map(|item| Vec3::from(points[item.item as usize])),
        ),
        false => Vec3::ZERO,
    };
    Estimate { spacing, normal }
}

/// Indices of the points along Morton's curve through their box.
fn along_curve(positions: &[Vec3]) -> Vec<u32> {
    let none = || (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let grow = |(min, max): (Vec3, Vec3), (low, high): (Vec3, Vec3)| (min.min(low), max.max(high));
    let (min, max) = positions.par_iter().map(|&p| (p, p)).reduce(none, grow);
    let cells = (1_u32 << CURVE_BITS) as f32;
    let scale = cells / (max - min).max_element().max(f32::MIN_POSITIVE);
    let key = |(index, &p): (usize, &Vec3)| {
        // A cast of what is too large saturates.
        let [x, y, z] = ((p - min) * scale)
            .to_array()
            .map(|cell| spread((cell as u32).min((1 << CURVE_BITS) - 1)));
        (x | y << 1 | z << 2, index as u32)
    };
    let mut keys: Vec<(u64, u32)> = positions.par_iter().enumerate().map(key).collect();
    keys.par_sort_unstable();
    keys.into_par_iter().map(|(_, index)| index).collect()
}

/// The low 16 bits, with two zeros between one and the next.
fn spread(cell: u32) -> u64 {
    let mut bits = u64::from(cell & 0xffff);
    bits = (bits | bits << 16) & 0x0000_ff00_00ff;
    bits = (bits | bits << 8) & 0x00f0_0f00_f00f;
    bits = (bits | bits << 4) & 0x0c30_c30c_30c3;
    (bits | bits << 2) & 0x2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread_by_three() {
        for bit in 0..CURVE_BITS {
            assert_eq!(spread(1 << bit), 1 << (3 * bit), "bit {bit}");
        }
        assert_eq!(spread(0xffff).count_ones(), 16);
    }

    #[test]
    fn the_curve_visits_every_point_once() {
        let positions: Vec<Vec3> = (0..1000)
            .map(|i| Vec3::new((i * 37 % 100) as f32, (i % 7) as f32, 0.0))
            .collect();
        let mut order = along_curve(&positions);
        order.sort_unstable();
        assert!(order.into_iter().eq(0..1000), "a permutation");
    }
}
