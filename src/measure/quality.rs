//! How well mirrors show what they ought to: measures of a mirrors' G-buffer and of pictures.
//!
//! Metres stand for the scene's unit.

use glam::{DVec3, UVec2, Vec4};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::flip::flip;
use super::percentiles::Percentiles;
use super::planes::{Planes, around, mean, part_of, srgb};
use super::ssim::ssim;
use crate::backend::cpu::Cpu;
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::image::{ImageSettings, shown};
use crate::reflect::MirrorGBuffer;

/// Pixel widths by which a place may be off and still count as the reference's.
pub const SAME_PLACE: f64 = 2.0;

/// The smallest mean square error that a PSNR tells from none: 120 dB.
const LEAST_ERROR: f64 = 1e-12;

/// What is seen in a mirror at a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Where it is, in the scene's frame.
    pub position: DVec3,
    /// Linear RGB, 0 to 1.
    pub albedo: DVec3,
}

/// What mirrors show, pixel by pixel, whoever found it; `None` where that is nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct MirrorPicture {
    /// Width and height, pixels.
    pub size: UVec2,
    /// A value per pixel, row by row from the top.
    pub pixels: Vec<Option<Seen>>,
}

/// What a mirror pixel ought to show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    /// The mirror's point, in the scene's frame.
    pub point: DVec3,
    /// What is seen there.
    pub seen: Seen,
    /// Whether that is no mirror again; only then its albedo counts.
    pub wall: bool,
}

/// What mirrors ought to show.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    size: UVec2,
    mirror: Vec<bool>,
    pixels: Vec<Option<Wanted>>,
    /// How wide a pixel's ray is where it ends, metres; 0 where no neighbour tells.
    footprint: Vec<f64>,
}

/// How well mirrors show what they ought to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct MirrorQuality {
    /// Pixels of mirrors.
    pub mirror_pixels: u64,
    /// Share of them that show something, 0 to 1.
    pub coverage: f64,
    /// Share of the pixels in which the reference shows something that show the same place, up to [`SAME_PLACE`], 0 to 1.
    pub recall: f64,
    /// Distance of what is shown from what ought to be, metres.
    pub position_m: Percentiles,
    /// The same in widths of the pixel's reflected ray there.
    pub position_px: Percentiles,
    /// Angle between them, seen from the mirror's point, degrees.
    pub angle_degrees: Percentiles,
    /// PSNR of sRGB of what is seen of walls, dB; nothing counts as black, and 120 is no difference.
    pub albedo_psnr: f64,
    /// SSIM of the same, at most 1.
    pub albedo_ssim: f64,
}

/// How like two pictures are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PictureQuality {
    /// Peak signal to noise ratio of sRGB, dB; 120 is no difference.
    pub psnr: f64,
    /// Structural similarity, at most 1.
    pub ssim: f64,
    /// Difference that a person would see, 0 to 1 [Andersson et al. 2020].
    pub flip: f64,
}

/// PSNR and SSIM of the albedo that mirrors show.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct AlbedoQuality {
    /// dB.
    pub psnr: f64,
    /// At most 1.
    pub ssim: f64,
}

impl MirrorPicture {
    /// What a mirrors' G-buffer shows; its positions are relative to `origin`.
    pub fn new(mirror: &MirrorGBuffer<Cpu>, origin: DVec3) -> Self {
        let pixels = (0..mirror.origin.values().len()).map(|i| seen(mirror, origin, i));
        Self {
            size: mirror.size(),
            pixels: pixels.collect(),
        }
    }

    fn at(&self, pixel: usize) -> Option<Seen> {
        self.pixels.get(pixel).copied().flatten()
    }
}

/// What the pixel `i` shows.
fn seen(mirror: &MirrorGBuffer<Cpu>, origin: DVec3, i: usize) -> Option<Seen> {
    let pixel = mirror.at(i)?;
    let of = |grid: &Grid<Vec4>| grid.values().get(i).copied().unwrap_or_default();
    let position = of(&mirror.origin) + of(&mirror.direction) * pixel.surface.w;
    Some(Seen {
        position: position.truncate().as_dvec3() + origin,
        albedo: pixel.albedo.truncate().as_dvec3(),
    })
}

impl Reference {
    /// From whether each pixel is a mirror, and what it ought to show.
    pub fn new(size: UVec2, mirror: Vec<bool>, pixels: Vec<Option<Wanted>>) -> Self {
        let footprint = (0..pixels.len())
            .into_par_iter()
            .map(|i| footprint(&pixels, size, i));
        Self {
            footprint: footprint.collect(),
            size,
            mirror,
            pixels,
        }
    }

    /// What a mirrors' G-buffer shows, taken as what ought to be; its positions are relative to `origin`.
    pub fn of(mirror: &MirrorGBuffer<Cpu>, origin: DVec3) -> Self {
        let wanted = |i: usize| {
            let at = mirror.origin.values().get(i).copied().unwrap_or_default();
            Some(Wanted {
                point: at.truncate().as_dvec3() + origin,
                seen: seen(mirror, origin, i)?,
                wall: mirror.at(i).is_some_and(|pixel| pixel.albedo.w <= 0.0),
            })
        };
        let points = mirror.origin.values();
        let pixels = (0..points.len()).map(wanted).collect();
        let of_mirror = points.iter().map(|point| point.w > 0.0).collect();
        Self::new(mirror.size(), of_mirror, pixels)
    }

    /// Width and height, pixels.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// Whether each pixel is one of a mirror.
    pub fn mirror(&self) -> &[bool] {
        &self.mirror
    }

    /// How well a picture shows what it ought to.
    ///
    /// # Errors
    /// [`Error::Setting`] where it has another size.
    pub fn quality(&self, picture: &MirrorPicture) -> Result<MirrorQuality> {
        same_size(self.size, picture.size)?;
        let mirror_pixels = self.mirror.iter().filter(|m| **m).count() as u64;
        let (mut covered, mut wanted_pixels, mut same) = (0u64, 0u64, 0u64);
        let (mut metres, mut widths, mut angles) = (Vec::new(), Vec::new(), Vec::new());
        for (i, _) in self.mirror.iter().enumerate().filter(|(_, m)| **m) {
            let seen = picture.at(i);
            covered += u64::from(seen.is_some());
            let Some(wanted) = self.pixels[i] else {
                continue;
            };
            wanted_pixels += 1;
            let Some(seen) = seen else { continue };
            let off = seen.position.distance(wanted.seen.position);
            metres.push(off);
            angles.push(angle(&wanted, seen.position));
            if self.footprint[i] > 0.0 {
                widths.push(off / self.footprint[i]);
                same += u64::from(off <= SAME_PLACE * self.footprint[i]);
            }
        }
        let albedo = self.albedo_quality(|i| picture.at(i).map(|seen| seen.albedo));
        Ok(MirrorQuality {
            mirror_pixels,
            coverage: covered as f64 / mirror_pixels.max(1) as f64,
            recall: same as f64 / wanted_pixels.max(1) as f64,
            position_m: Percentiles::of(metres),
            position_px: Percentiles::of(widths),
            angle_degrees: Percentiles::of(angles),
            albedo_psnr: albedo.psnr,
            albedo_ssim: albedo.ssim,
        })
    }

    /// PSNR of the albedo that the mirrors show, dB: of [`Reference::quality`] the one figure.
    ///
    /// # Errors
    /// [`Error::Setting`] where it has another size.
    pub fn albedo_psnr(&self, picture: &MirrorPicture) -> Result<f64> {
        same_size(self.size, picture.size)?;
        let of = self.walls(|i| picture.at(i).map(|seen| seen.albedo));
        Ok(of.map_or_else(Default::default, |(got, wanted, walls)| {
            psnr(&got, &wanted, &walls)
        }))
    }

    /// What the reference itself, moved to the right by one pixel, comes to: whatever is worse is off by more.
    pub fn moved(&self) -> AlbedoQuality {
        let width = self.size.x as usize;
        self.albedo_quality(|i| {
            let before = if i % width == 0 { i + width - 1 } else { i - 1 };
            self.wanted_albedo(before)
        })
    }

    /// What black mirrors come to.
    pub fn black(&self) -> AlbedoQuality {
        self.albedo_quality(|_| None)
    }

    fn wanted_albedo(&self, pixel: usize) -> Option<DVec3> {
        Some(self.pixels.get(pixel).copied().flatten()?.seen.albedo)
    }

    fn albedo_quality(&self, albedo: impl Fn(usize) -> Option<DVec3> + Sync) -> AlbedoQuality {
        let Some((got, wanted, walls)) = self.walls(albedo) else {
            return AlbedoQuality::default();
        };
        AlbedoQuality {
            psnr: psnr(&got, &wanted, &walls),
            ssim: mean(&ssim(&got, &wanted), &walls),
        }
    }

    /// The part of the picture around what mirrors show of walls, as sRGB: as it is, as it ought to be, and which pixels
    /// count; `None` where they show no wall.
    fn walls(
        &self,
        albedo: impl Fn(usize) -> Option<DVec3> + Sync,
    ) -> Option<(Planes, Planes, Vec<bool>)> {
        let walls: Vec<bool> = (self.pixels.iter().zip(&self.mirror))
            .map(|(wanted, mirror)| *mirror && wanted.is_some_and(|w| w.wall))
            .collect();
        let part = around(&walls, self.size)?;
        let of_walls = |albedo: &(dyn Fn(usize) -> Option<DVec3> + Sync)| {
            let pixel = |i: usize| match albedo(i) {
                Some(albedo) if walls[i] => srgb(albedo),
                _ => DVec3::ZERO,
            };
            Planes::new(self.size, pixel).part(part)
        };
        let (got, wanted) = (of_walls(&albedo), of_walls(&|i| self.wanted_albedo(i)));
        Some((got, wanted, part_of(&walls, self.size, part)))
    }
}

/// Angle between a place and where it ought to be, seen from the mirror's point, degrees.
fn angle(wanted: &Wanted, position: DVec3) -> f64 {
    let towards = |at: DVec3| (at - wanted.point) / (at - wanted.point).length().max(1e-12);
    let chord = towards(position).distance(towards(wanted.seen.position));
    2.0 * (chord / 2.0).min(1.0).asin().to_degrees()
}

/// How wide the reflected ray of pixel `i` is where it ends: the root mean square of how far the rays of its neighbours
/// beside and below pass, at the same length. What they meet does not matter, so that edges in the mirror do not.
fn footprint(pixels: &[Option<Wanted>], size: UVec2, i: usize) -> f64 {
    let Some(Some(wanted)) = pixels.get(i) else {
        return 0.0;
    };
    let length = wanted.point.distance(wanted.seen.position);
    let (x, width) = (i % size.x as usize, size.x as usize);
    let passes = |there: bool, index: usize| {
        let other = (*pixels.get(index).filter(|_| there)?)?;
        let towards = (other.seen.position - other.point).try_normalize()?;
        Some((other.point + towards * length).distance(wanted.seen.position))
    };
    let beside = passes(x + 1 < width, i + 1).or_else(|| passes(x > 0, i.wrapping_sub(1)));
    let below = passes(true, i + width).or_else(|| passes(i >= width, i.wrapping_sub(width)));
    match (beside, below) {
        (Some(beside), Some(below)) => ((beside * beside + below * below) / 2.0).sqrt(),
        (one, other) => one.or(other).unwrap_or_default(),
    }
}

/// The picture that a display shows of radiance: sRGB, 0 to 1, not rounded to 8 bits.
pub fn displayed(radiance: &Grid<Vec4>, settings: &ImageSettings) -> Planes {
    Planes::new(radiance.size(), |i| {
        let radiance = radiance.values().get(i).copied().unwrap_or_default();
        srgb(shown(radiance, settings).as_dvec3())
    })
}

/// How like two pictures of a display are, over the pixels of `mask`; all 0 where there is none.
///
/// # Errors
/// [`Error::Setting`] where they have different sizes.
pub fn picture_quality(
    picture: &Planes,
    reference: &Planes,
    mask: &[bool],
) -> Result<PictureQuality> {
    same_size(reference.size, picture.size)?;
    let Some(part) = around(mask, reference.size) else {
        return Ok(PictureQuality::default());
    };
    let inside = part_of(mask, reference.size, part);
    let (got, wanted) = (picture.part(part), reference.part(part));
    Ok(PictureQuality {
        psnr: psnr(&got, &wanted, &inside),
        ssim: mean(&ssim(&got, &wanted), &inside),
        flip: mean(&flip(&wanted, &got), &inside),
    })
}

/// Peak signal to noise ratio over the pixels of `mask`, dB.
fn psnr(a: &Planes, b: &Planes, mask: &[bool]) -> f64 {
    let squares: Vec<f64> = (0..mask.len())
        .map(|i| (a.at(i) - b.at(i)).length_squared() / 3.0)
        .collect();
    -10.0 * mean(&squares, mask).max(LEAST_ERROR).log10()
}

fn same_size(reference: UVec2, picture: UVec2) -> Result<()> {
    if reference == picture {
        return Ok(());
    }
    Err(Error::Setting(format!(
        "the reference is {}x{} pixels and the picture {}x{}; render it with camera.size={}x{}",
        reference.x, reference.y, picture.x, picture.y, reference.x, reference.y
    )))
}
