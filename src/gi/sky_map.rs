//! Pictures of the sky all around: equirectangular, columns by azimuth, rows by elevation from the zenith down.

use std::f64::consts::PI;
use std::path::Path;

use exr::math::Vec2 as ExrVec2;
use exr::meta::MetaData;
use exr::prelude::read_first_rgba_layer_from_file;
use glam::{DVec3, Vec2, Vec3};

use crate::cloud::require_memory;
use crate::error::{Error, Result};

/// Radiance above this is as good as infinite; sums of it stay numbers.
const BRIGHTEST: f32 = 1e9;

/// Radiance all around.
#[derive(Debug, Clone, PartialEq)]
pub struct SkyMap {
    width: usize,
    height: usize,
    /// Row by row from the zenith, W/sr/m2.
    texels: Vec<Vec3>,
}

impl SkyMap {
    /// A map of whole rows of `width` texels; `None` where they are not whole, or there is none.
    pub fn new(width: usize, texels: Vec<Vec3>) -> Option<Self> {
        let height = texels.len().checked_div(width)?;
        (height > 0 && width * height == texels.len()).then_some(Self {
            width,
            height,
            texels,
        })
    }

    /// Reads the first layer of an OpenEXR file: R, G and B as radiance. What is no number or below 0 is black.
    ///
    /// # Errors
    /// [`Error::Read`] where the file cannot be read, [`Error::Scene`] where it is no picture in colour, [`Error::Memory`].
    pub fn read(path: &Path) -> Result<Self> {
        let wrong = |problem: String| Error::Scene {
            path: path.into(),
            line: None,
            problem,
        };
        let broken = |error: exr::error::Error| match error {
            exr::error::Error::Io(source) => Error::Read {
                path: path.into(),
                source,
            },
            other => wrong(format!(
                "is no OpenEXR picture with channels R, G and B ({other})"
            )),
        };
        let kind = std::fs::metadata(path).map_err(|source| Error::Read {
            path: path.into(),
            source,
        })?;
        if !kind.is_file() {
            return Err(wrong("is not a file".into()));
        }
        let meta = MetaData::read_from_file(path, false).map_err(broken)?;
        let size = meta.headers.first().map_or(ExrVec2(0, 0), |h| h.layer_size);
        let pixels = size.width() as u64 * size.height() as u64;
        require_memory("the map of the environment", pixels * 48)?;

        let image = read_first_rgba_layer_from_file(
            path,
            |size, _| (size.width(), vec![Vec3::ZERO; size.area()]),
            |(width, texels), at, (r, g, b, _): (f32, f32, f32, f32)| {
                let sound = |v: f32| {
                    if v.is_nan() {
                        0.0
                    } else {
                        v.clamp(0.0, BRIGHTEST)
                    }
                };
                if let Some(texel) = texels.get_mut(at.y() * *width + at.x()) {
                    *texel = Vec3::new(sound(r), sound(g), sound(b));
                }
            },
        )
        .map_err(broken)?;
        let (width, texels) = image.layer_data.channel_data.pixels;
        Self::new(width, texels).ok_or_else(|| wrong("holds no pixels".into()))
    }

    /// The radiance at a place (0 to 1 across, 0 to 1 down from the zenith), bilinear; columns go around.
    pub fn at(&self, place: Vec2) -> Vec3 {
        let x = place.x.rem_euclid(1.0) * self.width as f32 - 0.5;
        let y = (place.y * self.height as f32 - 0.5).clamp(0.0, (self.height - 1) as f32);
        let (column, row) = (x.floor(), y as usize);
        let columns = [0, 1].map(|k| (column as i64 + k).rem_euclid(self.width as i64) as usize);
        let along = |row: usize| {
            let [left, right] = columns.map(|column| self.texels[row * self.width + column]);
            left.lerp(right, x - column)
        };
        along(row).lerp(along((row + 1).min(self.height - 1)), y - row as f32)
    }

    /// The map in `height` rows and twice as many columns, each the mean over the directions that it stands for; the map
    /// itself where it is no larger.
    pub(super) fn reduced(&self, height: usize) -> Self {
        let height = height.min(self.height).max(1);
        let width = (2 * height).min(self.width);
        if (width, height) == (self.width, self.height) {
            return self.clone();
        }
        let mut sums = vec![(DVec3::ZERO, 0.0f64); width * height];
        for (i, texel) in self.texels.iter().enumerate() {
            let (x, y) = (i % self.width, i / self.width);
            let solid_angle = (PI * (y as f64 + 0.5) / self.height as f64).sin();
            let sum = &mut sums[y * height / self.height * width + x * width / self.width];
            sum.0 += texel.as_dvec3() * solid_angle;
            sum.1 += solid_angle;
        }
        let texels = sums
            .into_iter()
            .map(|(sum, weight)| (sum / weight).as_vec3());
        Self {
            width,
            height,
            texels: texels.collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reducing_keeps_the_light() {
        // A small sun.
        let (width, height) = (64, 32);
        let mut texels = vec![Vec3::ONE; width * height];
        texels[10 * width + 33] = Vec3::splat(1000.0);
        let map = SkyMap::new(width, texels).expect("a map");
        let power = |map: &SkyMap| -> f64 {
            let rows = map.texels.chunks(map.width).enumerate();
            let row = |(y, row): (usize, &[Vec3])| {
                let edge = |y: usize| (PI * y as f64 / map.height as f64).cos();
                let sum: f64 = row.iter().map(|t| f64::from(t.x)).sum();
                sum / map.width as f64 * (edge(y) - edge(y + 1))
            };
            rows.map(row).sum()
        };
        let (before, after) = (power(&map), power(&map.reduced(8)));
        assert!(
            (after / before - 1.0).abs() < 0.01,
            "{before} became {after}"
        );
        assert_eq!(map.reduced(8).texels.len(), 128, "16 columns of 8 rows");
        assert_eq!(map.reduced(100), map, "no map grows");
    }

    #[test]
    fn columns_go_around_and_rows_end() {
        let map = SkyMap::new(2, [1.0, 3.0].map(Vec3::splat).to_vec()).expect("a map");
        for (x, expected) in [(0.25, 1.0), (0.75, 3.0), (0.0, 2.0), (1.0, 2.0), (0.5, 2.0)] {
            for y in [0.0, 0.5, 1.0] {
                let got = map.at(Vec2::new(x, y)).x;
                assert!((got - expected).abs() < 1e-6, "at {x}, {y}: {got}");
            }
        }
        assert_eq!(SkyMap::new(2, vec![Vec3::ONE; 3]), None, "half a row");
        assert_eq!(SkyMap::new(0, Vec::new()), None, "no texel");
    }
}
