//! From raw clouds to surfels: placing, cleaning, colours, mirrors, radii, normals, order.

use glam::{DMat4, DVec3, Vec3};
use rayon::prelude::*;

use super::guard::require_memory;
use super::neighbours::{Want, estimate};
use super::normals::towards;
use super::placed::{Placed, place};
use super::shuffle::shuffled;
use super::tint::percentile;
use super::{Bounds, Facts, Finish, MirrorRule, Place, RawCloud, Repairs, Surfel, Surfels};
use crate::error::{Error, Result};
use crate::job::Job;

/// Scenes that reach no farther than this from 0 keep it as their origin; the files' unit.
const NEAR_ZERO: f64 = 10_000.0;

/// Memory that a point takes here at most, beside the raw cloud: neighbours, surfels, their order.
const BYTES_PER_POINT: u64 = 144;

/// Strays have no neighbours near them; no estimated radius is larger than so many times the 99th percentile.
const STRAY_RADIUS: f32 = 4.0;

/// Radius where nothing is known: a single point, or all in one place.
const LONE_RADIUS: f32 = 1e-3;

/// A cloud as the scene wants it.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedCloud {
    /// As read or generated.
    pub raw: RawCloud,
    /// From the cloud's frame to the scene's; must neither mirror nor flatten.
    pub transform: Option<DMat4>,
    /// For points whose file says nothing else.
    pub material: Material,
    /// Which points are mirrors.
    pub mirrors: Vec<MirrorRule>,
    /// For messages and reports.
    pub name: String,
}

/// The specular part of points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Specular reflectance, 0 to 1.
    pub specular: f32,
    /// Exponent of the normalised Phong lobe.
    pub shininess: f32,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            specular: 0.0,
            shininess: 1.0,
        }
    }
}

/// Surfels, ready to be drawn, and what is known of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// In shuffled order.
    pub surfels: Surfels,
    /// Counts, bounds, repairs.
    pub facts: Facts,
}

/// Makes surfels of the clouds of a scene.
///
/// Places them, drops points without finite coordinates, chooses the origin, colours clouds without colours (by
/// intensity, else by height), finds mirrors, estimates missing radii and normals (turned towards `viewpoint`, in the
/// scene's frame), and shuffles. What was dropped and repaired is counted in [`Facts::repairs`]. The result is the
/// same for any number of threads.
///
/// # Errors
/// [`Error::Setting`] for a transform that mirrors, flattens or is not affine; [`Error::Cloud`] for a rule whose column
/// a cloud lacks; [`Error::NoPoints`], [`Error::Memory`], [`Error::Cancelled`].
pub fn prepare(clouds: Vec<PlacedCloud>, viewpoint: DVec3, job: &Job) -> Result<Prepared> {
    let read: u64 = clouds.iter().map(|cloud| cloud.raw.len() as u64).sum();
    if u32::try_from(read).is_err() {
        return Err(Error::Setting(format!(
            "the scene has {read} points, and 4294967295 can be drawn; use fewer"
        )));
    }
    require_memory("preparing the points", read * BYTES_PER_POINT)?;

    // Place and clean each cloud, then see where all of them are.
    let scale = clouds
        .iter()
        .filter_map(|cloud| cloud.raw.scale)
        .reduce(DVec3::max);
    let mut placed = Vec::new();
    let mut first = 0;
    for cloud in clouds {
        job.progress("placing points", u64::from(first), read)?;
        let count = cloud.raw.len() as u32;
        placed.push(place(cloud, first)?);
        first += count;
    }
    let repairs = placed.iter().fold(Repairs::default(), |mut sum, cloud| {
        sum += cloud.repairs;
        sum
    });
    let bounds = placed
        .iter()
        .map(|cloud| cloud.bounds)
        .reduce(Bounds::union);
    let points: usize = placed.iter().map(|cloud| cloud.positions.len()).sum();
    let bounds = bounds
        .filter(|_| points > 0)
        .ok_or_else(|| no_points(repairs))?;
    let origin = origin_of(bounds, scale);

    // Surfels cloud by cloud: spacing and normals are those of a cloud by itself.
    let mut all = Surfels {
        places: Vec::new(),
        finishes: Vec::new(),
        source: Vec::new(),
        origin,
    };
    let mut facts = Facts {
        points: points as u64,
        bounds,
        spacing: 0.0,
        origin,
        repairs,
        mirror_points: 0,
        has_specular: false,
        clouds: Vec::new(),
    };
    let viewpoint = (viewpoint - origin).as_vec3();
    for mut cloud in placed {
        facts.clouds.push(cloud.facts.clone());
        facts.repairs += surfels_of(&mut cloud, viewpoint, &mut all, job)?;
    }
    facts.mirror_points = all
        .finishes
        .par_iter()
        .filter(|finish| finish.mirror() > 0.0)
        .count() as u64;
    facts.has_specular = all
        .finishes
        .par_iter()
        .any(|finish| finish.specular() > 0.0);
    let mut radii: Vec<f32> = all.places.par_iter().map(|place| place.radius).collect();
    facts.spacing = f64::from(percentile(&mut radii, 0.5).unwrap_or(LONE_RADIUS));

    job.progress("shuffling", 0, 0)?;
    Ok(Prepared {
        surfels: shuffled(all),
        facts,
    })
}

fn no_points(repairs: Repairs) -> Error {
    Error::NoPoints(match (repairs.not_finite, repairs.withheld) {
        (0, 0) => "name a cloud that has some".to_owned(),
        (lost, withheld) => {
            format!(
                "{lost} have no finite coordinates up to 1e15 and {withheld} are withheld by their file"
            )
        }
    })
}

/// Exactly 0 where the scene is near 0, else the centre of its box, rounded to a multiple of the files' quantum.
fn origin_of(bounds: Bounds, scale: Option<DVec3>) -> DVec3 {
    if bounds.min.abs().max(bounds.max.abs()).max_element() <= NEAR_ZERO {
        return DVec3::ZERO;
    }
    let scale = scale.unwrap_or(DVec3::ONE);
    (bounds.centre() / scale).round() * scale
}

/// Adds the surfels of one cloud to `all`; gives the repairs.
fn surfels_of(
    cloud: &mut Placed,
    viewpoint: Vec3,
    all: &mut Surfels,
    job: &Job,
) -> Result<Repairs> {
    let origin = all.origin;
    let positions: Vec<Vec3> = cloud
        .positions
        .par_iter()
        .map(|&p| (p - origin).as_vec3())
        .collect();
    let mut repairs = Repairs::default();

    // What the file gives stays, where it is sound; the rest is estimated.
    let given_radii = cloud.radii.take();
    let given_normals = cloud.normals.take();
    let mut radii = given_radii
        .clone()
        .unwrap_or_else(|| vec![0.0; positions.len()]);
    let mut normals = given_normals
        .clone()
        .unwrap_or_else(|| vec![Vec3::ZERO; positions.len()]);
    let want = |index: usize| Want {
        spacing: !given_radii.as_ref().is_some_and(|radii| radii[index] > 0.0),
        normal: !given_normals
            .as_ref()
            .is_some_and(|normals| normals[index] != Vec3::ZERO),
    };
    let missing = (0..positions.len()).into_par_iter().map(want);
    let wanted = |pick: fn(&Want) -> bool| missing.clone().filter(pick).count() as u64;
    let (spacings, fits) = (wanted(|want| want.spacing), wanted(|want| want.normal));
    repairs.radii = if given_radii.is_some() { spacings } else { 0 };
    repairs.normals = if given_normals.is_some() { fits } else { 0 };
    if spacings + fits > 0 {
        estimate(&positions, want, &mut radii, &mut normals, job)?;
        bound_radii(&mut radii, cloud.bounds, want);
        normals
            .par_iter_mut()
            .enumerate()
            .filter(|(index, _)| want(*index).normal)
            .for_each(|(index, normal)| {
                *normal = towards(viewpoint, positions[index], *normal);
            });
    }

    job.progress("packing", 0, 0)?;
    let value = |column: &Option<Vec<f32>>, index: usize, default: f32| {
        column.as_ref().map_or(default, |c| c[index])
    };
    let (places, finishes): (Vec<Place>, Vec<Finish>) = (0..positions.len())
        .into_par_iter()
        .map(|index| {
            let surfel = Surfel {
                position: positions[index],
                radius: radii[index],
                normal: normals[index],
                albedo: cloud.albedo[index],
                mirror: value(&cloud.mirror, index, 0.0),
                specular: value(&cloud.specular, index, cloud.material.specular),
                shininess: value(&cloud.shininess, index, cloud.material.shininess),
            };
            (
                Place {
                    position: surfel.position,
                    radius: surfel.radius,
                },
                Finish::pack(&surfel),
            )
        })
        .unzip();
    all.places.extend(places);
    all.finishes.extend(finishes);
    all.source.append(&mut cloud.source);
    Ok(repairs)
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
