//! The layer of shadow maps: what virtual lights see, map by map, as one picture.

use catoptric::gi::virtual_lights::{ShadowMaps, VirtualLights};
use catoptric::grid::Grid;
use catoptric::output::heat_colour;
use catoptric::renderer::Products;
use glam::{DVec3, UVec2};

use super::buffers::Painted;
use super::probe::global;
use super::virtual_lights::about;

/// Where a map shows nothing.
const NOTHING: [u8; 3] = [48, 48, 48];

/// Squares of fewer pixels have no gap between them.
const GAPLESS: u32 = 8;

/// How maps lie in a picture: squares of one size, row by row, as large as they can be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Sheet {
    columns: u32,
    /// Side of a square and of the map in it, pixels.
    square: u32,
    inner: u32,
}

impl Sheet {
    fn new(size: UVec2, maps: usize) -> Self {
        let maps = u32::try_from(maps).unwrap_or(u32::MAX).max(1);
        let side = |columns: u32| (size.x / columns).min(size.y / maps.div_ceil(columns));
        // As many as there are pixels across at most.
        let columns = (1..=maps.min(size.x.max(1))).max_by_key(|&columns| side(columns));
        let columns = columns.unwrap_or(1);
        let square = side(columns).max(1);
        Self {
            columns,
            square,
            inner: if square < GAPLESS { square } else { square - 1 },
        }
    }

    /// The top left of a map.
    fn corner(&self, index: u32) -> UVec2 {
        UVec2::new(index % self.columns, index / self.columns) * self.square
    }

    /// The map in which a pixel lies, and where in it.
    fn find(&self, pixel: UVec2) -> Option<(usize, UVec2)> {
        let (place, within) = (pixel / self.square, pixel % self.square);
        let index = place.y as usize * self.columns as usize + place.x as usize;
        let inside = place.x < self.columns && within.cmplt(UVec2::splat(self.inner)).all();
        inside.then_some((index, within))
    }

    /// The texels of `side` that a pixel of a map covers: the first and one past the last, one at least.
    fn texels(&self, pixel: u32, side: u32) -> (u32, u32) {
        let first = pixel * side / self.inner;
        (first, ((pixel + 1) * side / self.inner).max(first + 1))
    }

    /// The texel of `side` in the middle of a pixel.
    fn texel(&self, pixel: u32, side: u32) -> u32 {
        (2 * pixel + 1) * side / (2 * self.inner)
    }
}

/// All maps: the bounce they are of, and their number there.
fn maps(told: &VirtualLights) -> impl Iterator<Item = (&ShadowMaps, usize)> {
    (told.maps.iter()).flat_map(|maps| (0..maps.count()).map(move |index| (maps, index)))
}

/// All maps in the colours of their distances.
pub(super) fn paint(products: &Products) -> Painted {
    let size = products.gbuffer.surface.size();
    let mut picture = Grid::new(size, [0, 0, 0, 255]);
    let Some(told) = &products.virtual_lights else {
        return Painted {
            picture,
            scale: None,
        };
    };
    let distances = told.maps.iter().flat_map(|maps| maps.distances.values());
    let (low, high) = (distances.filter(|d| d.is_finite()))
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), &d| {
            (low.min(d), high.max(d))
        });
    let width = if high > low { high - low } else { 1.0 };
    let sheet = Sheet::new(size, maps(told).count());
    for ((maps, index), number) in maps(told).zip(0..) {
        let (Some(map), side) = (maps.map(index), maps.side() as u32) else {
            continue;
        };
        let corner = sheet.corner(number);
        for y in 0..sheet.inner {
            for x in 0..sheet.inner {
                let at = corner + UVec2::new(x, y);
                if at.cmpge(size).any() {
                    continue;
                }
                let seen = mean(map, side, sheet.texels(x, side), sheet.texels(y, side));
                let [r, g, b] = seen.map_or(NOTHING, |d| heat_colour((d - low) / width));
                let i = at.y as usize * size.x as usize + at.x as usize;
                if let Some(pixel) = picture.values_mut().get_mut(i) {
                    *pixel = [r, g, b, 255];
                }
            }
        }
    }
    Painted {
        picture,
        scale: (low <= high).then_some((low, high)),
    }
}

/// Of the texels that show something.
fn mean(map: &[f32], side: u32, columns: (u32, u32), rows: (u32, u32)) -> Option<f32> {
    let (mut sum, mut count) = (0.0, 0.0);
    for row in rows.0..rows.1 {
        for column in columns.0..columns.1 {
            let distance = map.get((row * side + column) as usize);
            if let Some(distance) = distance.filter(|d| d.is_finite()) {
                sum += distance;
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// What a pixel of the sheet shows.
pub(super) fn probe(
    products: &Products,
    origin: DVec3,
    pixel: UVec2,
) -> Vec<(&'static str, String)> {
    found(products, origin, pixel).unwrap_or_default()
}

fn found(products: &Products, origin: DVec3, pixel: UVec2) -> Option<Vec<(&'static str, String)>> {
    let told = products.virtual_lights.as_deref()?;
    let size = products.gbuffer.surface.size();
    let sheet = Sheet::new(size, maps(told).count());
    let (number, within) = sheet.find(pixel)?;
    let (maps, index) = maps(told).nth(number)?;
    let side = maps.side() as u32;
    let (column, row) = (sheet.texel(within.x, side), sheet.texel(within.y, side));
    let distance = *maps.map(index)?.get((row * side + column) as usize)?;
    let light = told.lights.get(maps.first_light + index)?;
    let mut lines = about(told, maps.first_light + index, origin);
    lines.push(("texel", format!("{column}, {row} of {side} x {side}")));
    if distance.is_finite() {
        let at = light.shown_at(column, row, side, distance);
        lines.push(("distance", format!("{distance:.4}")));
        lines.push(("shows", global(origin + at.as_dvec3())));
    } else {
        lines.push(("distance", "nothing there".to_owned()));
    }
    Some(lines)
}
