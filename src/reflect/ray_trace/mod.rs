//! Pass `ray_trace`, the reference: what each mirror pixel shows is found by its reflected ray, cut with all surfels as the
//! same oriented discs that the camera splats. It shares no code with the search.
//!
//! On the CPU alone. Costs the building of a tree over all points, then about the same for every mirror pixel, whatever
//! the mirror's form.

mod blend;
mod leaf;
mod order;
mod tree;

use std::sync::Arc;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::{Eye, Surface};
use crate::backend::cpu::Cpu;
use crate::cloud::{Surfels, require_memory};
use crate::error::Result;
use crate::gbuffer::SplatSettings;
use crate::grid::Grid;
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

/// What the mirror pixels show, by their rays.
#[derive(Debug, Clone, PartialEq)]
pub struct Traced {
    /// Where each ray starts, the mirror's point, relative to the scene's origin; w is 1 where a ray was traced, else 0.
    pub origin: Grid<Vec4>,
    /// Unit direction of each ray.
    pub direction: Grid<Vec4>,
    /// Unit normal of what is seen, towards the mirror, and distance along the ray in the scene's unit; 0 where nothing is
    /// seen. The place seen is origin + direction x distance.
    pub surface: Grid<Vec4>,
    /// Linear RGB, 0 to 1, and mirror reflectance.
    pub albedo: Grid<Vec4>,
    /// Specular reflectance, shininess, radius (local spacing), and validity: 1 where something is seen, else 0.
    pub material: Grid<Vec4>,
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

    /// Traces the reflected ray of every pixel that shows a mirror (row `ray_trace`).
    ///
    /// The nearest disc decides whether a mirror or something else is seen; all discs of that class that the ray meets
    /// within the depth tolerance behind it are blended, as in a splatted pixel.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub fn trace(
        &self,
        surface: &Surface<Cpu>,
        timings: &mut Timings,
        job: &Job,
    ) -> Result<Traced> {
        job.progress("tracing rays", 0, 0)?;
        timings.time("ray_trace", || self.trace_rows(surface, job))
    }

    fn trace_rows(&self, surface: &Surface<Cpu>, job: &Job) -> Result<Traced> {
        let grid = || Grid::new(surface.size, Vec4::ZERO);
        let mut traced = Traced {
            origin: grid(),
            direction: grid(),
            surface: grid(),
            albedo: grid(),
            material: grid(),
        };
        let width = surface.size.x.max(1) as usize;
        let rows = (
            traced.origin.values_mut().par_chunks_mut(width),
            traced.direction.values_mut().par_chunks_mut(width),
            traced.surface.values_mut().par_chunks_mut(width),
            traced.albedo.values_mut().par_chunks_mut(width),
            traced.material.values_mut().par_chunks_mut(width),
        );
        rows.into_par_iter().enumerate().try_for_each_init(
            || Blender::new(&self.surfels, &self.splat, self.settings.self_hit),
            |blender, (row, (origins, directions, surfaces, albedos, materials))| {
                job.check()?;
                for column in 0..width {
                    let Some(leaving) = leaving(surface, row * width + column) else {
                        continue;
                    };
                    origins[column] = leaving.ray.origin.extend(1.0);
                    directions[column] = leaving.ray.direction.extend(0.0);
                    let seen = blender.trace(&self.tree, &leaving);
                    surfaces[column] = seen.surface;
                    albedos[column] = seen.albedo;
                    materials[column] = seen.material;
                }
                Ok(())
            },
        )?;
        Ok(traced)
    }
}

/// The ray that leaves the mirror at the pixel `index`; `None` where there is none.
fn leaving(surface: &Surface<Cpu>, index: usize) -> Option<Leaving> {
    let point = *surface.point.values().get(index)?;
    if point.w <= 0.0 {
        return None;
    }
    let eye = match &surface.eye {
        Eye::Point(eye) => *eye,
        Eye::PerPixel(eyes) => eyes.values().get(index)?.truncate(),
    };
    let origin = point.truncate();
    let normal = surface.normal.values().get(index)?.truncate();
    let view = (origin - eye).try_normalize()?;
    let direction = reflect(view, normal).try_normalize()?;
    Some(Leaving {
        ray: Ray { origin, direction },
        normal,
    })
}

/// A direction after a mirror of that unit normal.
fn reflect(direction: Vec3, normal: Vec3) -> Vec3 {
    direction - normal * (2.0 * direction.dot(normal))
}

#[cfg(test)]
mod tests;
