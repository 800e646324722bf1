//! One cloud in the scene's frame: moved, cleaned, its radii and normals found; what every edit of a scene keeps.

use glam::{DMat4, DVec3, Vec3};
use rayon::prelude::*;

use super::clean::{check_lengths, clean, drop_lost_points, move_directions, transform_fault};
use super::guard::require_memory;
use super::neighbours::{Want, estimate};
use super::tint::percentile;
use super::{Bounds, RawCloud, Repairs};
use crate::error::{Error, Result};
use crate::job::Job;

/// Scenes that reach no farther than this from 0 keep it as their origin; the files' unit.
const NEAR_ZERO: f64 = 10_000.0;

/// Memory that a point takes here at most, beside the raw cloud: neighbours, what they say.
const BYTES_PER_POINT: u64 = 96;

/// Strays have no neighbours near them; no estimated radius is larger than so many times the 99th percentile.
const STRAY_RADIUS: f32 = 4.0;

/// Radius where nothing is known: a single point, or all in one place.
pub(super) const LONE_RADIUS: f32 = 1e-3;

/// The points of a cloud in the scene's frame, with all that is slow to find out. How they look (colours, mirrors) is said
/// when they are [drawn](super::assemble), so that a scene can be edited without reading its files again.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudPoints {
    /// Columns of sound points only. Normals and radii are in `normals` and `radii`.
    pub(super) raw: RawCloud,
    /// Unit length; of either sign where `estimated`, and zero there where no plane fits.
    pub(super) normals: Vec<Vec3>,
    pub(super) estimated: Estimated,
    states_normals: bool,
    /// The local spacing, above 0.
    pub(super) radii: Vec<f32>,
    /// Index of each point in its file, where some were dropped.
    source: Option<Vec<u32>>,
    /// Points of the file.
    read: u32,
    pub(super) bounds: Bounds,
    pub(super) repairs: Repairs,
}

/// Which normals are estimated, and may have to be turned.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Estimated {
    None,
    All,
    Some(Vec<bool>),
}

impl Estimated {
    pub(super) fn at(&self, index: usize) -> bool {
        match self {
            Self::None => false,
            Self::All => true,
            Self::Some(which) => which.get(index).is_some_and(|which| *which),
        }
    }
}

impl CloudPoints {
    /// Places a cloud, drops points without finite coordinates, and estimates the radii and normals that it lacks. `name` is
    /// for messages. The result is the same for any number of threads.
    ///
    /// # Errors
    /// [`Error::Setting`] for a transform that mirrors, flattens or is not affine; [`Error::Memory`], [`Error::Cancelled`].
    pub fn new(
        mut raw: RawCloud,
        scene_from_cloud: Option<&DMat4>,
        name: &str,
        job: &Job,
    ) -> Result<Self> {
        check_lengths(&raw, name)?;
        let read = u32::try_from(raw.len()).map_err(|_| {
            Error::Setting(format!(
                "{name} has {} points, and 4294967295 can be drawn; use fewer",
                raw.len()
            ))
        })?;
        require_memory("preparing the points", u64::from(read) * BYTES_PER_POINT)?;
        if let Some(transform) = scene_from_cloud {
            if let Some(fault) = transform_fault(transform) {
                return Err(Error::Setting(format!("the transform of {name} {fault}")));
            }
            raw.positions
                .par_iter_mut()
                .for_each(|p| *p = transform.transform_point3(*p));
            move_directions(&mut raw, transform);
        }
        let source = drop_lost_points(&mut raw);
        let mut repairs = raw.repairs;
        clean(&mut raw, &mut repairs);
        let bounds = bounds_of(&raw.positions);
        let mut points = Self {
            states_normals: raw.normals.is_some(),
            normals: raw.normals.take().unwrap_or_default(),
            estimated: Estimated::None,
            radii: raw.radii.take().unwrap_or_default(),
            raw,
            source,
            read,
            bounds,
            repairs,
        };
        points.complete(job)?;
        Ok(points)
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.raw.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.raw.is_empty()
    }

    /// The box of all points, in the scene's frame; `min` is above `max` where there is none.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The up axis that the file states.
    pub fn up_axis(&self) -> Option<super::UpAxis> {
        self.raw.up_axis
    }

    /// Whether the file has normals.
    pub(super) fn states_normals(&self) -> bool {
        self.states_normals
    }

    /// Points of the file, the dropped ones among them.
    pub(super) fn read(&self) -> u32 {
        self.read
    }

    /// Where a point stands in its file.
    pub(super) fn source_of(&self, index: usize) -> u32 {
        let of_file = self.source.as_ref().and_then(|source| source.get(index));
        of_file.copied().unwrap_or(index as u32)
    }

    /// Memory that all columns take, bytes.
    pub fn bytes(&self) -> u64 {
        let raw = &self.raw;
        let scalars = [&raw.intensity, &raw.mirror, &raw.specular, &raw.shininess];
        let scalars = scalars.into_iter().flatten().chain(raw.columns.values());
        let per_point = size_of::<DVec3>()
            + size_of::<Vec3>()
            + size_of::<f32>()
            + raw.albedo.as_ref().map_or(0, |_| size_of::<Vec3>())
            + scalars.count() * size_of::<f32>();
        (self.len() * (per_point + size_of::<u32>())) as u64
    }

    /// Estimates the radii and normals that the file lacks or states wrongly.
    fn complete(&mut self, job: &Job) -> Result<()> {
        let count = self.len();
        let (has_radii, has_normals) = (!self.radii.is_empty(), !self.normals.is_empty());
        self.radii.resize(count, 0.0);
        self.normals.resize(count, Vec3::ZERO);
        let lacks_radius: Vec<bool> = self.radii.par_iter().map(|r| !(*r > 0.0)).collect();
        let lacks_normal: Vec<bool> = (self.normals.par_iter())
            .map(|normal| *normal == Vec3::ZERO)
            .collect();
        let lacking = |column: &[bool]| column.par_iter().filter(|lacks| **lacks).count() as u64;
        let (spacings, fits) = (lacking(&lacks_radius), lacking(&lacks_normal));
        self.repairs.radii = if has_radii { spacings } else { 0 };
        self.repairs.normals = if has_normals { fits } else { 0 };
        if spacings + fits == 0 {
            return Ok(());
        }
        let want = |index: usize| Want {
            spacing: lacks_radius.get(index).is_some_and(|lacks| *lacks),
            normal: lacks_normal.get(index).is_some_and(|lacks| *lacks),
        };
        let origin = origin_of(self.bounds, self.raw.scale);
        let positions: Vec<Vec3> = (self.raw.positions.par_iter())
            .map(|&p| (p - origin).as_vec3())
            .collect();
        estimate(&positions, want, &mut self.radii, &mut self.normals, job)?;
        bound_radii(&mut self.radii, self.bounds, want);
        self.estimated = match fits {
            0 => Estimated::None,
            fits if fits == count as u64 => Estimated::All,
            _ => Estimated::Some(lacks_normal),
        };
        Ok(())
    }
}

/// Exactly 0 where the scene is near 0, else the centre of its box, rounded to a multiple of the files' quantum.
pub(super) fn origin_of(bounds: Bounds, scale: Option<DVec3>) -> DVec3 {
    if bounds.min.abs().max(bounds.max.abs()).max_element() <= NEAR_ZERO {
        return DVec3::ZERO;
    }
    let scale = scale.unwrap_or(DVec3::ONE);
    let origin = (bounds.centre() / scale).round() * scale;
    if origin.is_finite() {
        origin
    } else {
        DVec3::ZERO
    }
}

fn bounds_of(positions: &[DVec3]) -> Bounds {
    let none = || Bounds::of([]);
    positions
        .par_chunks(1 << 14)
        .map(|chunk| Bounds::of(chunk.iter().copied()))
        .reduce(none, Bounds::union)
}

/// Estimated radii of strays and of points in one place come into the range of the others.
fn bound_radii(radii: &mut [f32], bounds: Bounds, want: impl Fn(usize) -> Want + Sync) {
    let estimated = |index: &usize| want(*index).spacing;
    let mut known: Vec<f32> = (0..radii.len())
        .filter(estimated)
        .map(|i| radii[i])
        .filter(|&r| r > 0.0)
        .collect();
    let typical = percentile(&mut known, 0.5).unwrap_or_else(|| {
        // Too few points, or all in one place.
        let share = (bounds.size().length() / (radii.len() as f64).sqrt()) as f32;
        if share > 0.0 { share } else { LONE_RADIUS }
    });
    let largest = percentile(&mut known, 0.99).map_or(typical, |radius| radius * STRAY_RADIUS);
    radii
        .par_iter_mut()
        .enumerate()
        .filter(|(index, _)| estimated(index))
        .for_each(|(_, radius)| {
            *radius = if *radius > 0.0 {
                radius.min(largest)
            } else {
                typical
            };
        });
}
