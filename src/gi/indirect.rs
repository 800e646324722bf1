//! Indirect light, written once for all backends: virtual point lights bounce by bounce, their maps, and what the pixels gather.
//! The patches of an environment come first, as bounce 0: their light is direct.

use glam::{UVec2, Vec3, Vec4};

use super::bounce::{Mapped, Met, area, reflected, thin};
use super::environment::Environment;
use super::gather::Gathered;
use super::indirect_filter::Window;
use super::ism::{IsmMaps, Slices};
use super::mirror_light::{MirrorPaths, by_mirrors, caustics};
use super::photons::PhotonMap;
use super::receivers::Receivers;
use super::virtual_lights::VirtualLights;
use super::vpl::{Arrival, LitMap, VPL_MAP_SIDE, Vpl, importance, vpls};
use super::{GiSettings, SpotLight};
use crate::backend::{Backend, Cloud};
use crate::camera::Pinhole;
use crate::error::Result;
use crate::gbuffer::{GBuffer, SplatSettings};
use crate::job::Job;

/// Rays by which the lights of a bounce together find where their light arrives next: more than there will be lights, which are
/// then drawn where much arrives.
const RAYS: usize = 1 << 13;

/// Rays by which each patch of an environment finds what it lights: most miss the scene.
const SKY_RAYS: u64 = 8;

/// Side of the map of a patch over that of other lights: from the sphere around it, the scene takes half of a map's width.
const SKY_SIDE: u32 = 2;

/// Discs in the map of a patch over those in other lights': a sky shines through every hole. At 1 a quarter of it comes through a
/// closed surface, at 1.5 a sixteenth, at 2 a twenty-eighth; more makes shadows larger than what casts them.
const SKY_DISCS: f32 = 2.0;

/// Lights to draw indirect light from, and the settings of all stages on the way.
pub struct IndirectSources<'a> {
    /// The scene's lights, each with its projection.
    pub lights: &'a [(SpotLight, Pinhole)],
    /// Light from everywhere.
    pub environment: Option<&'a Environment>,
    /// The scene's box, relative to its origin.
    pub bounds: (Vec3, Vec3),
    /// Whether the cloud has mirrors.
    pub has_mirrors: bool,
    /// How points are splatted into what a light sees.
    pub splat: &'a SplatSettings,
    /// How the light reaches the points.
    pub gi: &'a GiSettings,
    /// Whether the virtual lights are told.
    pub keeps_lights: bool,
}

/// The indirect light of a frame.
pub struct Indirect<B: Backend> {
    /// What arrives in every picture, merged and spread.
    pub light: Vec<Gathered<B>>,
    /// Where it came from, where that is to be told.
    pub lights: Option<VirtualLights>,
}

/// Finds the indirect light. Keeps the tree for light by way of mirrors between frames.
#[derive(Debug, Default)]
pub struct Illuminator {
    paths: Option<MirrorPaths>,
}

/// A picture that receives light, and what it has received.
struct Lit<B: Backend> {
    receivers: Receivers<B>,
    gathered: Gathered<B>,
}

impl Illuminator {
    /// The indirect light that arrives in every picture of `receivers`.
    ///
    /// # Errors
    /// What the backend meets, [`crate::Error::Cancelled`].
    pub fn indirect<B: Backend>(
        &mut self,
        backend: &mut B,
        cloud: &Cloud<B>,
        sources: &IndirectSources<'_>,
        receivers: Vec<Receivers<B>>,
        job: &Job,
    ) -> Result<Indirect<B>> {
        let gi = sources.gi;
        let paths = self.paths(backend, cloud, sources, job)?;
        let mut lit = Vec::new();
        for receivers in receivers {
            let gathered = Gathered {
                irradiance: dark(backend, receivers.size)?,
                residual: dark(backend, receivers.size)?,
            };
            lit.push(Lit {
                receivers,
                gathered,
            });
        }

        // The first lights, and what they reflect: no later light reflects more.
        let maps = lit_maps(backend, cloud, sources, job)?;
        let mut lights = (backend.timings()).time("vpl", || vpls(&maps, gi.vpl_count));
        let mut share = lights.first().map_or(0.0, |vpl| importance(vpl.flux));
        let slices = Slices::of(cloud.surfels.len(), gi.ism_size, gi.ism_points);
        let scene_area = area(&cloud.surfels);
        let mut photons = match paths {
            Some(paths) if gi.caustics => caustics(paths, &maps, backend, job)?,
            _ => Vec::new(),
        };
        drop(maps);

        let mut walk = Walk {
            slices,
            paths,
            gi,
            number: 0,
            bounce: 0,
            kept: sources.keeps_lights.then(VirtualLights::default),
        };
        if let Some(environment) = sources.environment {
            let mut sky = (backend.timings()).time("environment", || {
                environment.vpls(sources.bounds, gi.vpl_count)
            });
            let rays = if gi.bounces > 0 { SKY_RAYS } else { 0 };
            walk.slices.side *= SKY_SIDE;
            walk.slices.thinning *= SKY_DISCS;
            let arrived = walk.send(backend, cloud, &mut sky, &mut lit, rays, job)?;
            walk.slices = slices;
            if let Some(paths) = paths.filter(|_| gi.caustics) {
                photons.extend(by_mirrors(paths, &sky, backend, job)?);
            }
            // As many lights again as the lamps have.
            share += reflected(&arrived) / gi.vpl_count.max(1) as f32;
            lights = mixed(lights, thin(&arrived, share, scene_area));
        }
        for bounce in 1..=gi.bounces {
            job.progress(
                "indirect light",
                u64::from(bounce) - 1,
                u64::from(gi.bounces),
            )?;
            let last = bounce == gi.bounces;
            let rays = if last {
                0
            } else {
                (RAYS / lights.len().max(1)).max(1) as u64
            };
            walk.bounce = bounce;
            let arrived = walk.send(backend, cloud, &mut lights, &mut lit, rays, job)?;
            if let Some(paths) = paths.filter(|_| gi.mirror_light) {
                photons.extend(by_mirrors(paths, &lights, backend, job)?);
            }
            lights = thin(&arrived, share, scene_area);
        }

        let map = PhotonMap::new(&photons, &cloud.surfels, scene_area);
        let mut done = Vec::new();
        for Lit {
            receivers,
            gathered,
        } in lit
        {
            let mut light = merged(backend, &receivers, gathered, gi, job)?;
            if !map.photons.is_empty() {
                backend.photons(&receivers, &map, &mut light.irradiance, job)?;
            }
            done.push(light);
        }
        Ok(Indirect {
            light: done,
            lights: walk.kept,
        })
    }

    /// The tree for light by way of mirrors, where it is wanted.
    fn paths<B: Backend>(
        &mut self,
        backend: &mut B,
        cloud: &Cloud<B>,
        sources: &IndirectSources<'_>,
        job: &Job,
    ) -> Result<Option<&MirrorPaths>> {
        let wanted = sources.has_mirrors && (sources.gi.mirror_light || sources.gi.caustics);
        if !wanted {
            return Ok(None);
        }
        let kept = (self.paths.take()).filter(|paths| paths.is_for(&cloud.surfels));
        let paths = match kept {
            Some(paths) => paths,
            None => MirrorPaths::new(&cloud.surfels, backend.timings(), job)?,
        };
        Ok(Some(self.paths.insert(paths)))
    }
}

/// The way of light from bounce to bounce.
struct Walk<'a> {
    slices: Slices,
    paths: Option<&'a MirrorPaths>,
    gi: &'a GiSettings,
    /// Lights so far.
    number: u64,
    /// Of the lights that are sent.
    bounce: u32,
    /// The lights, where they are told.
    kept: Option<VirtualLights>,
}

impl Walk<'_> {
    /// Lets all pictures gather what `lights` send, and says where that arrives next, by so many rays a light.
    fn send<B: Backend>(
        &mut self,
        backend: &mut B,
        cloud: &Cloud<B>,
        lights: &mut [Vpl],
        lit: &mut [Lit<B>],
        rays: u64,
        job: &Job,
    ) -> Result<Vec<Arrival>> {
        let n = self.gi.interleave;
        let mut arrived = Vec::new();
        for batch in lights.chunks_mut(self.slices.batch()) {
            for vpl in batch.iter_mut() {
                vpl.slice = self.slices.first(self.number);
                self.number += 1;
            }
            let isms = backend.ism(&cloud.points, batch, self.slices, job)?;
            if let Some(kept) = &mut self.kept {
                kept.keep(backend, self.bounce, batch, &isms)?;
            }
            let shares = brighter(batch, n);
            for lit in lit.iter_mut() {
                let (receivers, gathered) = (&lit.receivers, &mut lit.gathered);
                backend.gather(receivers, &shares, &isms, n, gathered, job)?;
            }
            if rays > 0 {
                arrived.extend(self.next(backend, cloud, batch, &isms, rays, job)?);
            }
        }
        Ok(arrived)
    }

    /// Where the light of a batch arrives next, mirrors passed.
    fn next<B: Backend>(
        &self,
        backend: &mut B,
        cloud: &Cloud<B>,
        batch: &[Vpl],
        isms: &IsmMaps<B>,
        rays: u64,
        job: &Job,
    ) -> Result<Vec<Arrival>> {
        let (surfels, scale) = (&cloud.surfels, self.gi.albedo_scale);
        let keys = backend.read(&isms.keys)?;
        let texels = (isms.slices.side * isms.slices.side) as usize;
        let each = 1.0 / rays as f32;
        let (mut arrivals, mut legs) = (Vec::new(), Vec::new());
        let lights = batch.iter().zip(keys.chunks(texels)).zip(self.number..);
        for ((vpl, map), number) in lights {
            let mapped = Mapped {
                surfels,
                vpl,
                map,
                slices: &isms.slices,
            };
            for ray in number * rays..(number + 1) * rays {
                match mapped.meet(ray, scale) {
                    Some(Met::Surface(mut arrival)) => {
                        arrival.incident *= each;
                        arrivals.push(arrival);
                    }
                    Some(Met::Mirror(mut leg)) => {
                        leg.flux *= each;
                        legs.push(leg);
                    }
                    None => {}
                }
            }
        }
        drop(keys);
        let wanted = self.gi.mirror_light && !legs.is_empty();
        if let Some(paths) = self.paths.filter(|_| wanted) {
            let landed = backend
                .timings()
                .time("mirror_light", || paths.follow(&legs, job))?;
            arrivals.extend(landed.into_iter().map(|mut arrival| {
                arrival.albedo *= scale;
                arrival
            }));
        }
        Ok(arrivals)
    }
}

/// Lights of two lists, evenly mixed, so that runs hold both in proportion.
fn mixed(a: Vec<Vpl>, b: Vec<Vpl>) -> Vec<Vpl> {
    let placed = |vpls: Vec<Vpl>| {
        let count = vpls.len() as f64;
        let place = move |(i, vpl)| ((i as f64 + 0.5) / count, vpl);
        vpls.into_iter().enumerate().map(place)
    };
    let mut all: Vec<(f64, Vpl)> = placed(a).chain(placed(b)).collect();
    all.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    all.into_iter().map(|(_, vpl)| vpl).collect()
}

/// Lights as each of n x n pixels sees its part of them.
fn brighter(vpls: &[Vpl], interleave: u32) -> Vec<Vpl> {
    let parts = (interleave * interleave) as f32;
    let brighter = |vpl: &Vpl| Vpl {
        flux: vpl.flux * parts,
        incident: vpl.incident * parts,
        ..*vpl
    };
    vpls.iter().map(brighter).collect()
}

fn dark<B: Backend>(backend: &mut B, size: UVec2) -> Result<B::Grid<Vec4>> {
    backend.write(size, &vec![Vec4::ZERO; size.x as usize * size.y as usize])
}

/// What interleaved pixels gathered together, and what bounding left out, spread over the surface around.
fn merged<B: Backend>(
    backend: &mut B,
    receivers: &Receivers<B>,
    gathered: Gathered<B>,
    gi: &GiSettings,
    job: &Job,
) -> Result<Gathered<B>> {
    let Gathered {
        mut irradiance,
        mut residual,
    } = gathered;
    let merging = Window::of(gi.interleave * gi.filter, 1);
    if merging.width > 1 {
        irradiance = backend.indirect_filter(receivers, &irradiance, merging, job)?;
        residual = backend.indirect_filter(receivers, &residual, merging, job)?;
    }
    for window in Window::spreading(gi.interleave * gi.filter) {
        residual = backend.indirect_filter(receivers, &residual, window, job)?;
    }
    Ok(Gathered {
        irradiance,
        residual,
    })
}

/// What every light sees, in main memory.
fn lit_maps<B: Backend>(
    backend: &mut B,
    cloud: &Cloud<B>,
    sources: &IndirectSources<'_>,
    job: &Job,
) -> Result<Vec<LitMap>> {
    let mut maps = Vec::new();
    for (light, pinhole) in sources.lights {
        let gbuffer = backend.splat(&cloud.points, pinhole, sources.splat, job)?;
        let mut albedo = backend.take(gbuffer.albedo)?;
        for value in albedo.values_mut() {
            *value *= Vec3::splat(sources.gi.albedo_scale).extend(1.0);
        }
        maps.push(LitMap {
            light: *light,
            gbuffer: GBuffer {
                pinhole: gbuffer.pinhole,
                surface: backend.take(gbuffer.surface)?,
                albedo,
                material: backend.take(gbuffer.material)?,
            },
        });
    }
    Ok(maps)
}

/// The projection of the map from which a light's virtual lights are drawn.
pub fn vpl_pinhole(light: &SpotLight, reach: f32) -> Pinhole {
    light.pinhole(VPL_MAP_SIDE, reach)
}
