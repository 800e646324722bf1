//! Stage `mirror_light`: light that goes on from mirrors. Rays against the cloud's discs, by the tree of the reference method
//! over a thinner cloud; on the processor for both backends.

use std::sync::Arc;

use glam::{UVec2, Vec3, Vec4};

use super::bounce::{cosine_direction, world_from_vpl};
use super::vpl::{Arrival, LitMap, Vpl, radical_inverse};
use crate::backend::Backend;
use crate::backend::cpu::Cpu;
use crate::cloud::{Place, Surfels};
use crate::error::Result;
use crate::gbuffer::SplatSettings;
use crate::grid::Grid;
use crate::job::Job;
use crate::reflect::ray_trace::{Pixels, RayTraceSettings, RayTracer};
use crate::reflect::{Eye, MirrorGBuffer, Surface};
use crate::timing::Timings;

/// Discs in the tree, at most: a fair sample of the cloud, each as much larger as they are fewer.
const DISCS: usize = 1 << 19;

/// Half width of a disc over the spacing of the discs: at 1 a ray passes a surface of random points in 4 of 100 cases, and
/// silhouettes hardly grow.
const DISC: f32 = 1.0;

/// Photons by way of mirrors, of all lights of a bounce together.
const PHOTONS: usize = 1 << 14;

/// Rays are traced in rows of so many.
const ROW: usize = 64;

/// Mirrors that a ray of light may meet one after the other.
const MIRRORS: usize = 4;

/// A ray of light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leg {
    pub(super) origin: Vec3,
    /// Of the surface that it leaves.
    pub(super) normal: Vec3,
    pub(super) spacing: f32,
    /// Unit vector.
    pub(super) direction: Vec3,
    /// W per channel.
    pub(super) flux: Vec3,
}

impl Leg {
    /// What a mirror makes of a ray that meets it.
    pub(super) fn reflected(position: Vec3, normal: Vec3, direction: Vec3, flux: Vec3) -> Self {
        Self {
            origin: position,
            normal,
            spacing: 0.0,
            direction: direction - normal * (2.0 * normal.dot(direction)),
            flux,
        }
    }
}

/// Where a ray ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Landing {
    pub(super) arrival: Arrival,
    /// Mirror reflectance of what it meets; the albedo is that of its other part.
    mirror: f32,
}

/// Follows light by way of mirrors.
#[derive(Debug)]
pub(super) struct MirrorPaths {
    /// The cloud for which it was made.
    cloud: Arc<Surfels>,
    tracer: RayTracer,
}

impl MirrorPaths {
    /// A tree over a cloud.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] where it would not fit, [`crate::Error::Cancelled`].
    pub(super) fn new(cloud: &Arc<Surfels>, timings: &mut Timings, job: &Job) -> Result<Self> {
        let splat = SplatSettings {
            size: DISC,
            ..SplatSettings::default()
        };
        let thinner = thinned(cloud);
        let settings = RayTraceSettings::default();
        // The tree's own row is part of this stage's.
        let mut own = Timings::default();
        let tracer = timings.time("mirror_light", || {
            RayTracer::new(&thinner, &splat, &settings, &mut own, job)
        })?;
        Ok(Self {
            cloud: Arc::clone(cloud),
            tracer,
        })
    }

    /// Whether it was made for this cloud.
    pub(super) fn is_for(&self, cloud: &Arc<Surfels>) -> bool {
        Arc::ptr_eq(&self.cloud, cloud)
    }

    /// Where each ray ends, itself; `None` where it leaves the scene.
    fn meet(&self, legs: &[Leg], job: &Job) -> Result<Vec<Option<Landing>>> {
        let size = UVec2::new(ROW as u32, legs.len().div_ceil(ROW) as u32);
        let mut surface = Surface::<Cpu> {
            size,
            point: Grid::new(size, Vec4::ZERO),
            normal: Grid::new(size, Vec4::ZERO),
            eye: Eye::Point(Vec3::ZERO),
        };
        let mut seen = MirrorGBuffer::empty(size);
        for (i, leg) in legs.iter().enumerate() {
            surface.point.values_mut()[i] = leg.origin.extend(1.0);
            surface.normal.values_mut()[i] = leg.normal.extend(leg.spacing);
            seen.origin.values_mut()[i] = leg.origin.extend(1.0);
            seen.direction.values_mut()[i] = leg.direction.extend(0.0);
        }
        self.tracer.trace(
            &surface,
            &mut seen,
            Pixels::All,
            &mut Timings::default(),
            job,
        )?;
        let landing = |(i, leg): (usize, &Leg)| {
            let pixel = seen.at(i)?;
            Some(Landing {
                arrival: Arrival {
                    position: leg.origin + leg.direction * pixel.surface.w,
                    normal: pixel.surface.truncate(),
                    albedo: pixel.albedo.truncate(),
                    specular: pixel.material.x,
                    shininess: pixel.material.y,
                    spacing: pixel.material.z,
                    direction: leg.direction,
                    incident: leg.flux,
                },
                mirror: pixel.albedo.w,
            })
        };
        Ok(legs.iter().enumerate().map(landing).collect())
    }

    /// Where rays that leave mirrors end, in their order, after all mirrors that they meet.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub(super) fn follow(&self, legs: &[Leg], job: &Job) -> Result<Vec<Arrival>> {
        let mut ended = Vec::new();
        let mut open: Vec<(usize, Leg)> = legs.iter().copied().enumerate().collect();
        for _ in 0..MIRRORS {
            if open.is_empty() {
                break;
            }
            let rays: Vec<Leg> = open.iter().map(|(_, leg)| *leg).collect();
            let met = self.meet(&rays, job)?;
            let mut further = Vec::new();
            for ((number, _), landing) in open.iter().zip(met) {
                match landing {
                    Some(l) if l.mirror > 0.0 => further.push((*number, l.reflected())),
                    Some(l) => ended.push((*number, l.arrival)),
                    None => {}
                }
            }
            open = further;
        }
        ended.sort_by_key(|(number, _)| *number);
        Ok(ended.into_iter().map(|(_, arrival)| arrival).collect())
    }

    /// The rays that leave the mirrors which `legs` meet.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub(super) fn mirrored(&self, legs: &[Leg], job: &Job) -> Result<Vec<Leg>> {
        let met = self.meet(legs, job)?;
        Ok(met
            .into_iter()
            .flatten()
            .filter(|landing| landing.mirror > 0.0)
            .map(|landing| landing.reflected())
            .collect())
    }
}

impl Landing {
    fn reflected(&self) -> Leg {
        let Arrival {
            position,
            normal,
            direction,
            incident,
            ..
        } = self.arrival;
        Leg {
            spacing: self.arrival.spacing,
            ..Leg::reflected(position, normal, direction, incident * self.mirror)
        }
    }
}

/// The first [`DISCS`] surfels, larger by as much as they are fewer.
fn thinned(cloud: &Arc<Surfels>) -> Arc<Surfels> {
    if cloud.len() <= DISCS {
        return Arc::clone(cloud);
    }
    let larger = (cloud.len() as f32 / DISCS as f32).sqrt();
    let place = |p: &Place| Place {
        radius: p.radius * larger,
        ..*p
    };
    Arc::new(Surfels {
        places: cloud.places[..DISCS].iter().map(place).collect(),
        finishes: cloud.finishes[..DISCS].to_vec(),
        source: cloud.source[..DISCS].to_vec(),
        origin: cloud.origin,
    })
}

/// Where light of `lights` lands by way of mirrors: as many rays of each as [`PHOTONS`] allow.
pub(super) fn by_mirrors<B: Backend>(
    paths: &MirrorPaths,
    lights: &[Vpl],
    backend: &mut B,
    job: &Job,
) -> Result<Vec<Arrival>> {
    let each = (PHOTONS / lights.len().max(1)).max(1) as u64;
    let mut legs = Vec::new();
    for (vpl, v) in lights.iter().zip(0u64..) {
        for k in 0..each {
            let number = v * each + k + 1;
            let d = cosine_direction(radical_inverse(number, 2), radical_inverse(number, 3));
            let direction = world_from_vpl(vpl, d);
            legs.push(Leg {
                origin: vpl.position,
                normal: vpl.normal,
                spacing: vpl.spacing,
                direction,
                flux: vpl.flux_towards(direction) / each as f32,
            });
        }
    }
    backend.timings().time("mirror_light", || {
        let mirrored = paths.mirrored(&legs, job)?;
        paths.follow(&mirrored, job)
    })
}

/// Where the lights' own light lands by way of mirrors.
pub(super) fn caustics<B: Backend>(
    paths: &MirrorPaths,
    maps: &[LitMap],
    backend: &mut B,
    job: &Job,
) -> Result<Vec<Arrival>> {
    backend.timings().time("mirror_light", || {
        let legs: Vec<Leg> = maps.iter().flat_map(LitMap::mirrored).collect();
        paths.follow(&legs, job)
    })
}
