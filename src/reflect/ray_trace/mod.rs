//! Pass `ray_trace`, the reference: what each mirror pixel shows is found by its reflected ray, cut with all surfels as the
//! same oriented discs that the camera splats. It shares no code with the search.
//!
//! On the CPU alone. Costs the building of a tree over all points, then about the same for every mirror pixel, whatever
//! the mirror's form.

mod blend;
mod leaf;
mod tree;

use std::sync::Arc;

use rayon::prelude::*;

use super::{MirrorGBuffer, Surface};
use crate::backend::cpu::Cpu;
use crate::cloud::{Surfels, require_memory};
use crate::error::Result;
use crate::gbuffer::SplatSettings;
use crate::job::Job;
use crate::settings_group;
use crate::timing::Timings;
use blend::{Blender, Leaving};
use leaf::Ray;
use tree::Tree;

settings_group! {
    /// How reflected rays are traced.
    pub struct RayTraceSettings in "ray_trace" {
        /// Thickness of the mirror's own layer of points: a ray that leaves the mirror through a disc parallel to it (within
        /// 45 degrees), this near to where it starts along the disc's normal, passes. Less lets a mirror of noisy points
        /// show itself as black specks.
        self_hit: f32 = 2.0, 0.0..=100.0, "x radius";
    }
}

/// Whose rays are traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pixels {
    /// Those of every mirror pixel.
    All,
    /// Those of mirror pixels that show nothing.
    Empty,
}

/// Traces rays through a cloud. Built once for a cloud and a splat size, then used for any number of pictures.
#[derive(Debug)]
pub struct RayTracer {
    surfels: Arc<Surfels>,
    tree: Tree,
    splat: SplatSettings,
    settings: RayTraceSettings,
}

impl RayTracer {
    /// Builds the tree over all surfels (row `ray_trace_build`).
    ///
    /// # Errors
    /// [`crate::Error::Memory`] where the tree would not fit, [`crate::Error::Cancelled`].
    pub fn new(
        surfels: &Arc<Surfels>,
        splat: &SplatSettings,
        settings: &RayTraceSettings,
        timings: &mut Timings,
        job: &Job,
    ) -> Result<Self> {
        job.progress("building the rays' tree", 0, 0)?;
        require_memory("the tree for tracing rays", tree::memory(surfels.len()))?;
        let tree = timings.time("ray_trace_build", || Tree::new(surfels, splat));
        job.check()?;
        Ok(Self {
            surfels: Arc::clone(surfels),
            tree,
            splat: splat.clone(),
            settings: settings.clone(),
        })
    }

    /// What the tree takes, bytes; the surfels are shared.
    pub fn memory(&self) -> u64 {
        self.tree.memory()
    }

    /// Traces the rays of the `pixels` of `mirror`, the picture of the rays of `surface` (row `ray_trace`).
    ///
    /// The nearest disc decides whether a mirror or something else is seen; all discs of that class that the ray meets
    /// within the depth tolerance behind it are blended, as in a splatted pixel.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub fn trace(
        &self,
        surface: &Surface<Cpu>,
        mirror: &mut MirrorGBuffer<Cpu>,
        pixels: Pixels,
        timings: &mut Timings,
        job: &Job,
    ) -> Result<()> {
        job.progress("tracing rays", 0, 0)?;
        timings.time("ray_trace", || {
            self.trace_rows(surface, mirror, pixels, job)
        })
    }

    fn trace_rows(
        &self,
        surface: &Surface<Cpu>,
        mirror: &mut MirrorGBuffer<Cpu>,
        pixels: Pixels,
        job: &Job,
    ) -> Result<()> {
        let width = surface.size.x.max(1) as usize;
        let rays = (
            mirror.origin.values().par_chunks(width),
            mirror.direction.values().par_chunks(width),
            surface.normal.values().par_chunks(width),
        );
        let seen = (
            mirror.surface.values_mut().par_chunks_mut(width),
            mirror.albedo.values_mut().par_chunks_mut(width),
            mirror.material.values_mut().par_chunks_mut(width),
            mirror.count.values_mut().par_chunks_mut(width),
            mirror.level.values_mut().par_chunks_mut(width),
        );
        let rows = rays.into_par_iter().zip(seen.into_par_iter());
        rows.try_for_each_init(
            || Blender::new(&self.surfels, &self.splat, self.settings.self_hit),
            |blender, ((origins, directions, normals), seen)| {
                job.check()?;
                let (surfaces, albedos, materials, counts, levels) = seen;
                for column in 0..origins.len() {
                    let (origin, direction) = (origins[column], directions[column]);
                    let known = pixels == Pixels::Empty && materials[column].w > 0.0;
                    if origin.w <= 0.0 || known {
                        continue;
                    }
                    let leaving = Leaving {
                        ray: Ray {
                            origin: origin.truncate(),
                            direction: direction.truncate(),
                        },
                        normal: normals[column].truncate(),
                    };
                    let (pixel, count) = blender.trace(&self.tree, &leaving);
                    surfaces[column] = pixel.surface;
                    albedos[column] = pixel.albedo;
                    materials[column] = pixel.material;
                    counts[column] = count;
                    levels[column] = if count > 0 { BY_RAY } else { 0.0 };
                }
                Ok(())
            },
        )
    }
}

/// [`MirrorGBuffer::level`] of a pixel that a ray found.
const BY_RAY: f32 = -1.0;

#[cfg(test)]
mod tests;
