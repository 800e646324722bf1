//! Pass `visibility`: the attributes of all fragments within a tolerance of the nearest are summed. CPU twin of
//! `shaders/visibility.wgsl`.
//!
//! Sums are integers, so that their order cannot matter: a fragment's weight times attribute is scaled by a power of two
//! that depends on the pixel's number of fragments alone, and is large as it can be without overflow.

use bytemuck::{Pod, Zeroable};
use wide::{f32x4, i32x4};

use super::disc::{Disc, weight};
use super::tile::Tile;
use super::{EMPTY, depth_from_key, depth_key, same_class};
use crate::camera::Pinhole;
use crate::cloud::Finish;

/// Weighted sums of a pixel's visible fragments, in fixed point.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Sums {
    /// Weight; depth behind the nearest over the nearest's depth; specular; shininess (logarithmic, 0 to 1).
    pub depth: [i32; 4],
    /// Linear RGB; mirror reflectance.
    pub albedo: [i32; 4],
    /// Normal towards the viewer, scene's frame; radius over the nearest's depth, at most 1.
    pub normal: [i32; 4],
}

/// Scale of the sums of a pixel with `count` fragments: count times scale stays within 2^30.
pub fn scale(count: u32) -> f32 {
    let bits = 32 - count.leading_zeros();
    f32::from_bits((127 + 30 - bits.min(30)) << 23)
}

/// Attributes of a surfel as the viewer sees them, in the order of [`Sums`]. Seen from behind, a diffuse surfel turns its
/// normal, and a mirror is opaque and black.
pub(crate) fn attributes(finish: Finish, behind: bool) -> (f32x4, f32x4, f32x4) {
    let n = if behind {
        -finish.normal()
    } else {
        finish.normal()
    };
    let normal = f32x4::from([n.x, n.y, n.z, 0.0]);
    if behind && finish.mirror() > 0.0 {
        return (f32x4::from([1.0, 0.0, 0.0, 0.0]), f32x4::ZERO, normal);
    }
    let a = finish.albedo();
    (
        f32x4::from([1.0, 0.0, finish.specular(), finish.shininess_log()]),
        f32x4::from([a.x, a.y, a.z, finish.mirror()]),
        normal,
    )
}

/// Sums the visible fragments of `discs` in the pixels of the tile, after pass `depth`.
pub fn visibility(tile: &mut Tile, discs: &[Disc], pinhole: &Pinhole) {
    // Per pixel once, not per fragment: the scale, and the nearest's depth with its inverse.
    tile.prepare_fronts(|key, count| match depth_from_key(key) {
        Some(depth) => [scale(count), depth, 1.0 / depth],
        None => [0.0, 0.0, 0.0],
    });
    let Tile {
        area,
        keys,
        fronts,
        sums,
        ..
    } = tile;
    for disc in discs {
        let (depth_lanes, albedo_lanes, normal_lanes) = attributes(disc.finish, disc.behind);
        area.visit(disc, pinhole, |pixel, depth, distance| {
            let key = keys[pixel];
            let [scale, front, inverse_front] = fronts[pixel];
            let own = depth_key(depth, disc.class, false);
            let Some(depth) = depth_from_key(own) else {
                return;
            };
            if key == EMPTY || !same_class(key, own) || (depth - front).abs() > disc.tolerance {
                return;
            }
            let s = weight(distance * disc.inverse_half_squared) * scale;
            let behind = ((depth - front) * inverse_front).min(1.0);
            let radius = (disc.radius * inverse_front).min(1.0);
            let add = |sum: &mut [i32; 4], lanes: f32x4| {
                let scaled = (lanes * f32x4::splat(s)).fast_trunc_int();
                *sum = (i32x4::from(*sum) + scaled).into();
            };
            let sums = &mut sums[pixel];
            add(
                &mut sums.depth,
                depth_lanes + f32x4::from([0.0, behind, 0.0, 0.0]),
            );
            add(&mut sums.albedo, albedo_lanes);
            add(
                &mut sums.normal,
                normal_lanes + f32x4::from([0.0, 0.0, 0.0, radius]),
            );
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_is_the_largest_power_of_two_that_cannot_overflow() {
        for count in [1u32, 2, 3, 4, 7, 8, 1000, 1 << 20, (1 << 29) + 1, u32::MAX] {
            let sum = f64::from(count.min(1 << 30)) * f64::from(scale(count));
            assert!(sum <= f64::from(1 << 30), "{count} fragments sum to {sum}");
            assert!(
                count > 1 << 29 || sum > f64::from(1 << 28),
                "{count} fragments waste bits: {sum}"
            );
        }
    }
}
