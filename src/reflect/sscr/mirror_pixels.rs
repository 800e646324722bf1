//! The mirrors of a picture, laid out for the search.

use rayon::prelude::*;

use super::Region;
use super::mirror_error::MirrorPoint;
use super::scalar::Scalar;
use crate::backend::cpu::Cpu;
use crate::cloud::require_memory;
use crate::error::Result;
use crate::gbuffer::disc::PixelRect;
use crate::reflect::{Eye, LabelledMirrors};

/// All that the search asks of a pixel, of f32 in one cache line: its steps jump about the picture.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct MirrorPixel<R: Scalar> {
    mirror: MirrorPoint<R>,
    /// 0 where there is no mirror.
    region: u32,
}

/// The mirrors of a picture, in the rectangle around all regions.
#[derive(Debug)]
pub(super) struct MirrorPixels<R: Scalar> {
    bounds: PixelRect,
    /// Row by row.
    pixels: Vec<MirrorPixel<R>>,
}

impl<R: Scalar> MirrorPixels<R> {
    /// Lays out the mirrors of a picture.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] where the picture is too large.
    pub(super) fn new(mirrors: &LabelledMirrors<'_, Cpu>) -> Result<Self> {
        let bounds = around(mirrors.regions);
        let width = bounds.x1.saturating_sub(bounds.x0) as usize;
        let height = bounds.y1.saturating_sub(bounds.y0) as usize;
        let memory = (width * height * size_of::<MirrorPixel<R>>()) as u64;
        require_memory("searching the mirrors", memory)?;
        let nothing = MirrorPixel {
            mirror: MirrorPoint::none(),
            region: 0,
        };
        let pixel = |i: usize| {
            let (x, y) = (
                bounds.x0 as usize + i % width,
                bounds.y0 as usize + i / width,
            );
            mirror_pixel(mirrors, x, y).unwrap_or(nothing)
        };
        Ok(Self {
            bounds,
            pixels: (0..width * height).into_par_iter().map(pixel).collect(),
        })
    }

    /// The mirror at a place of the picture; `None` outside of the region.
    #[inline]
    pub(super) fn at(&self, at: R::Vec2, region: u32) -> Option<&MirrorPoint<R>> {
        let b = self.bounds;
        let [x, y] = R::parts2(at);
        let edge = |cell: u32| R::of(cell as f32);
        if !(x >= edge(b.x0) && y >= edge(b.y0) && x < edge(b.x1) && y < edge(b.y1)) {
            return None;
        }
        let (column, row) = (x.cell() - b.x0, y.cell() - b.y0);
        let index = row as usize * (b.x1 - b.x0) as usize + column as usize;
        let pixel = self.pixels.get(index)?;
        (pixel.region == region).then_some(&pixel.mirror)
    }
}

/// The mirror in column `x`, row `y`; `None` where there is none.
fn mirror_pixel<R: Scalar>(
    mirrors: &LabelledMirrors<'_, Cpu>,
    x: usize,
    y: usize,
) -> Option<MirrorPixel<R>> {
    let surface = mirrors.surface;
    let region = *mirrors.labels.get(x, y)?;
    let point = surface.point.get(x, y)?;
    if region == 0 || point.w <= 0.0 {
        return None;
    }
    let normal = surface.normal.get(x, y)?;
    let eye = match &surface.eye {
        Eye::Point(eye) => *eye,
        Eye::PerPixel(eyes) => eyes.get(x, y)?.truncate(),
    };
    let mirror = MirrorPoint::new(
        R::of3(point.truncate()),
        R::of3(normal.truncate()),
        R::of(normal.w),
        R::of3(eye),
        R::of3(mirrors.right),
    );
    Some(MirrorPixel { mirror, region })
}

/// The smallest rectangle around all regions.
pub(crate) fn around(regions: &[Region]) -> PixelRect {
    let mut bounds = regions.iter().map(|region| region.bounds);
    let nothing = PixelRect {
        x0: 0,
        y0: 0,
        x1: 0,
        y1: 0,
    };
    let first = bounds.next().unwrap_or(nothing);
    bounds.fold(first, |a, b| PixelRect {
        x0: a.x0.min(b.x0),
        y0: a.y0.min(b.y0),
        x1: a.x1.max(b.x1),
        y1: a.y1.max(b.y1),
    })
}
