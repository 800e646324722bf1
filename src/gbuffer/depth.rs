//! Pass `depth`: the nearest fragment of every pixel, and how many there are. CPU twin of `shaders/depth.wgsl`.

use super::depth_key;
use super::disc::Disc;
use super::tile::Tile;
use crate::camera::Pinhole;

/// Offers every fragment of `discs` to the pixels of the tile. `COUNT` also counts the fragments of each pixel, of which
/// the `visibility` pass derives the scale of its sums; shadow maps do without.
pub fn depth<const COUNT: bool>(tile: &mut Tile, discs: &[Disc], pinhole: &Pinhole) {
    let Tile {
        area, keys, counts, ..
    } = tile;
    for disc in discs {
        area.visit(disc, pinhole, |pixel, depth, _| {
            let key = depth_key(depth, disc.mirror);
            keys[pixel] = keys[pixel].min(key);
            if COUNT {
                counts[pixel] += 1;
            }
        });
    }
}
