//! Pass `gather`: what the virtual point lights send to every pixel, as far as their maps let them. CPU twin of
//! `shaders/gather.wgsl`.
//!
//! Irradiance of a diffuse light at a receiver: flux / pi x cos cos / (d^2 + s), where s is the area that the light stands for,
//! over pi: what is near is bounded as the disc is that it stands for, without a limit of someone's choice. What that leaves
//! out, flux / pi x cos cos (1 / d^2 - 1 / (d^2 + s)), is added up beside it, to be spread over the surface around
//! [Kollig and Keller 2004]. Interleaved n x n, each pixel of a block takes another n^2-th part of the lights, n^2 times as bright
//! [Keller and Heidrich 2001]: a contiguous part, which as a run of low-discrepancy numbers covers the lit surface evenly.

use std::f32::consts::PI;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::ism::{BIAS, BIAS_SPACINGS, BIAS_TEXELS, IsmMaps, Slices, ism_distance, texel_of};
use super::receivers::Receivers;
use super::vpl::{Vpl, luminance};
use crate::backend::Backend;
use crate::backend::cpu::Cpu;
use crate::error::Result;
use crate::gbuffer::EMPTY;
use crate::job::Job;

/// Rows of a task, at least.
const ROWS: usize = 8;

/// The lights of part `part` of `parts` of `count`: first and one past the last.
pub fn part_of(count: u32, part: u32, parts: u32) -> (u32, u32) {
    let bound = |part: u32| (u64::from(count) * u64::from(part) / u64::from(parts)) as u32;
    (bound(part), bound(part + 1))
}

/// What one pixel gathers.
struct Gatherer {
    position: Vec3,
    spacing: f32,
    normal: Vec3,
    specular: f32,
    view: Vec3,
    shininess: f32,
    index: usize,
    sum: Vec4,
    residual: Vec3,
}

/// What pixels have gathered.
pub struct Gathered<B: Backend> {
    /// Irradiance, rgb in W/m2; w is the luminance of what specular lobes turn towards the eye.
    pub irradiance: B::Grid<Vec4>,
    /// The irradiance that bounding leaves out, rgb; w is 0.
    pub residual: B::Grid<Vec4>,
}

/// Share of the softening that bounds what is left out, in its turn: nearer than an eighth of a light's radius counts as at it.
pub const RESIDUAL_SOFTENING: f32 = 1.0 / 64.0;

fn dot(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

impl Gatherer {
    /// Adds what one light sends. Rgb is irradiance; w is the luminance of what the specular lobe turns towards the eye.
    #[inline(always)]
    fn add(&mut self, vpl: &Vpl, map: &[u32], slices: &Slices) {
        let to = self.position - vpl.position;
        let along = dot(to, vpl.normal);
        let facing = -dot(to, self.normal);
        if !(along > 0.0 && facing > 0.0) {
            return;
        }
        let distance_squared = dot(to, to);
        let distance = distance_squared.sqrt();
        let across = Vec3::new(dot(to, vpl.right), dot(to, vpl.up), along);
        let (column, row) = texel_of(across, distance, slices.side);
        let cosine = facing / distance;
        let key = map[(row * slices.side + column) as usize];
        if key != EMPTY {
            let slope = (1.0 / (cosine * cosine) - 1.0).max(0.0).sqrt();
            let shown = ism_distance(key);
            let limit = shown * (1.0 + BIAS + BIAS_TEXELS * slope / slices.side as f32)
                + BIAS_SPACINGS * slices.thinning * self.spacing;
            if distance > limit {
                return;
            }
        }
        let facing_both = along * cosine / (distance * PI);
        let bounded = 1.0 / (distance_squared + vpl.softening);
        let left_out = 1.0 / (distance_squared + vpl.softening * RESIDUAL_SOFTENING) - bounded;
        let mut flux = vpl.flux;
        if vpl.specular > 0.0 {
            flux = vpl.flux_towards(to / distance);
        }
        let irradiance = flux * (facing_both * bounded);
        let mut glossy = 0.0;
        if self.specular > 0.0 {
            let mirrored = self.normal * (2.0 * cosine) + to / distance;
            let base = dot(mirrored, self.view).max(0.0);
            let lobe = base.powf(self.shininess) * (self.shininess + 2.0) / (2.0 * PI);
            glossy = self.specular * lobe * luminance(irradiance);
        }
        self.sum += irradiance.extend(glossy);
        self.residual += flux * (facing_both * left_out);
    }
}

/// Adds what a batch of lights sends to what was gathered; `interleave` is n, and the lights are n^2 times as bright. Sums run on
/// from what is there, so that it makes no difference how lights are cut into batches of whole parts.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn gather(
    receivers: &Receivers<Cpu>,
    vpls: &[Vpl],
    maps: &IsmMaps<Cpu>,
    interleave: u32,
    gathered: &mut Gathered<Cpu>,
    job: &Job,
) -> Result<()> {
    let n = interleave.max(1) as usize;
    let width = receivers.size.x as usize;
    let block = width * ROWS.next_multiple_of(n);
    let texels = (maps.slices.side * maps.slices.side) as usize;
    let parts = (n * n) as u32;
    let inputs = (
        receivers.position.values().par_chunks(block),
        receivers.normal.values().par_chunks(block),
        receivers.view.values().par_chunks(block),
        gathered.irradiance.values_mut().par_chunks_mut(block),
        gathered.residual.values_mut().par_chunks_mut(block),
    );
    inputs.into_par_iter().for_each_init(
        Vec::new,
        |gatherers: &mut Vec<Gatherer>, (positions, normals, views, sums, residuals)| {
            for part in 0..parts {
                if job.is_cancelled() {
                    return;
                }
                let (column, row) = (part as usize % n, part as usize / n);
                // Rows of a block start at a multiple of n.
                let pixels = (row..positions.len().div_ceil(width))
                    .step_by(n)
                    .flat_map(|y| (column..width).step_by(n).map(move |x| y * width + x));
                gatherers.clear();
                gatherers.extend(
                    pixels
                        .filter(|&i| positions[i].w > 0.0)
                        .map(|index| Gatherer {
                            position: positions[index].truncate(),
                            spacing: positions[index].w,
                            normal: normals[index].truncate(),
                            specular: normals[index].w,
                            view: views[index].truncate(),
                            shininess: views[index].w,
                            index,
                            sum: sums[index],
                            residual: residuals[index].truncate(),
                        }),
                );
                let (first, end) = part_of(vpls.len() as u32, part, parts);
                let (first, end) = (first as usize, end as usize);
                let own = maps.keys.values()[first * texels..end * texels].chunks(texels);
                for (vpl, map) in vpls[first..end].iter().zip(own) {
                    for gatherer in gatherers.iter_mut() {
                        gatherer.add(vpl, map, &maps.slices);
                    }
                }
                for gatherer in gatherers.iter() {
                    sums[gatherer.index] = gatherer.sum;
                    residuals[gatherer.index] = gatherer.residual.extend(0.0);
                }
            }
        },
    );
    job.check()
}
