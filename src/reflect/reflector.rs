//! What the mirrors show, by the method of choice: the way from the camera's G-buffer to the mirrors'.
//!
//! Mirrors run on the processor, whichever backend runs the rest.

use std::sync::Arc;

use super::ray_trace::{RayTraceSettings, RayTracer};
use super::sscr::accumulate::Accumulator;
use super::sscr::curvature::{Axes, curvature};
use super::sscr::distribute::distribute;
use super::sscr::lhc::Labeller;
use super::sscr::root_find::{RootFindParams, RootFinder, SearchCounts};
use super::{Hit, Method, MirrorGBuffer, Surface};
use crate::backend::cpu::Cpu;
use crate::cloud::Surfels;
use crate::error::Result;
use crate::gbuffer::pull_push::pull_push;
use crate::gbuffer::{GBuffer, SplatSettings};
use crate::job::Job;
use crate::measure::BounceReport;
use crate::settings::Settings;
use crate::timing::Timings;

/// Finds what mirrors show. Keeps working memory and the rays' tree between frames.
#[derive(Debug, Default)]
pub struct Reflector {
    labeller: Labeller,
    accumulator: Accumulator,
    tracer: Option<Tracer>,
}

/// A tree over a cloud, and what it was built for.
#[derive(Debug)]
struct Tracer {
    surfels: Arc<Surfels>,
    splat: SplatSettings,
    settings: RayTraceSettings,
    tracer: RayTracer,
}

impl Reflector {
    /// What the mirrors in a G-buffer show, after closing. `diagonal` is that of the scene's box.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] where the rays' tree would not fit, [`crate::Error::Cancelled`].
    pub fn reflect(
        &mut self,
        gbuffer: &GBuffer<Cpu>,
        surfels: &Arc<Surfels>,
        diagonal: f32,
        settings: &Settings,
        timings: &mut Timings,
        job: &Job,
    ) -> Result<(MirrorGBuffer<Cpu>, BounceReport)> {
        job.progress("reflecting", 0, 0)?;
        let surface = timings.time("surface", || Surface::of(gbuffer));
        let mut mirror = timings.time("reflected_rays", || MirrorGBuffer::of(&surface));

        // Regions: both methods note them.
        let cells = timings.time("curvature", || {
            curvature(&surface, Axes::from(&gbuffer.pinhole), &settings.lhc)
        });
        let regions = timings.time("lhc", || {
            let lhc = self.labeller.lhc(&cells);
            mirror
                .region
                .values_mut()
                .copy_from_slice(lhc.labels.values());
            lhc.regions.len() as u64
        });
        job.check()?;

        let (counts, hits) = match settings.reflect.method {
            Method::RayTrace => {
                self.trace(&surface, &mut mirror, surfels, settings, timings, job)?;
                (SearchCounts::default(), 0)
            }
            Method::Sscr => {
                let (hits, counts) =
                    self.search(&surface, gbuffer, surfels, settings, timings, job)?;
                timings.time("accumulate", || {
                    self.accumulator.accumulate(
                        &hits,
                        surfels,
                        &mut mirror,
                        &settings.sscr,
                        diagonal,
                    );
                });
                (counts, hits.len() as u64)
            }
        };
        job.check()?;
        let (mirrors, covered) = (surface.pixels(), mirror.covered());
        if settings.reflect.method == Method::Sscr {
            timings.time("pull_push", || {
                pull_push(&mut mirror, settings.sscr.pull_levels);
            });
        }
        let share = |part: u64, whole: u64| {
            if whole > 0 {
                part as f64 / whole as f64
            } else {
                0.0
            }
        };
        let report = BounceReport {
            bounce: 1,
            regions,
            points_offered: counts.offered,
            points_hit: counts.hit,
            hit_rate: share(counts.hit, counts.offered),
            hits,
            mean_steps: share(counts.steps, counts.offered),
            coverage: share(covered, mirrors),
            coverage_closed: share(mirror.covered(), mirrors),
        };
        Ok((mirror, report))
    }

    /// Searches every point in the region that it is given, once a pass.
    fn search(
        &self,
        surface: &Surface<Cpu>,
        gbuffer: &GBuffer<Cpu>,
        surfels: &Surfels,
        settings: &Settings,
        timings: &mut Timings,
        job: &Job,
    ) -> Result<(Vec<Hit>, SearchCounts)> {
        let lhc = self.labeller.map();
        let params = RootFindParams::from(&settings.sscr);
        let finder = timings.time("root_find", || {
            RootFinder::new(surface, lhc, gbuffer.pinhole.right, params)
        })?;
        let (mut hits, mut counts) = (Vec::new(), SearchCounts::default());
        for pass in 0..settings.sscr.passes {
            let region =
                |point: u32| distribute(&lhc.regions, settings.sscr.distribution, point, pass);
            let (found, counted) =
                timings.time("root_find", || finder.search(&surfels.places, region, job))?;
            hits.extend(found);
            counts.offered += counted.offered;
            counts.hit += counted.hit;
            counts.steps += counted.steps;
        }
        Ok((hits, counts))
    }

    /// Traces the reflected rays, with a tree that is built where there is none for this cloud.
    fn trace(
        &mut self,
        surface: &Surface<Cpu>,
        mirror: &mut MirrorGBuffer<Cpu>,
        surfels: &Arc<Surfels>,
        settings: &Settings,
        timings: &mut Timings,
        job: &Job,
    ) -> Result<()> {
        let kept = self.tracer.take().filter(|t| {
            Arc::ptr_eq(&t.surfels, surfels)
                && t.splat == settings.splat
                && t.settings == settings.ray_trace
        });
        let tracer = match kept {
            Some(tracer) => tracer,
            None => Tracer {
                surfels: Arc::clone(surfels),
                splat: settings.splat.clone(),
                settings: settings.ray_trace.clone(),
                tracer: RayTracer::new(
                    surfels,
                    &settings.splat,
                    &settings.ray_trace,
                    timings,
                    job,
                )?,
            },
        };
        let tracer = self.tracer.insert(tracer);
        tracer.tracer.trace(surface, mirror, timings, job)
    }
}
