//! Pass `depth`: the nearest fragment of every pixel, and how many there are. CPU twin of `shaders/depth.wgsl`.

use super::depth_key;
use super::disc::{Disc, RIM};
use super::tile::Tile;
use crate::camera::Pinhole;

/// Offers every fragment of `discs` to the pixels of the tile. `COUNT` also counts the fragments of each pixel, of which
/// the `visibility` pass derives the scale of its sums, and lets rims yield; shadow maps do without, since a leak in them
/// would be a speckle of light.
pub fn depth<const COUNT: bool>(tile: &mut Tile, discs: &[Disc], pinhole: &Pinhole) {
    let Tile {
        area, keys, counts, ..
    } = tile;
    for disc in discs {
        let rim = RIM * disc.half_squared;
        area.visit(disc, pinhole, |pixel, depth, distance| {
            let key = depth_key(depth, disc.class, COUNT && distance > rim);
            keys[pixel] = keys[pixel].min(key);
            if COUNT {
                counts[pixel] += 1;
            }
        });
    }
}
