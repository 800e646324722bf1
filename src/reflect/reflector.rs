//! What the mirrors show, by the method of choice: the way from a G-buffer to the mirrors', written once for all backends.

use std::sync::Arc;

use super::ray_trace::{RayTraceSettings, RayTracer};
use super::sscr::curvature::Axes;
use super::sscr::lhc::Labeller;
use super::sscr::root_find::SearchCounts;
use super::{LabelledMirrors, Method, MirrorGBuffer, Surface};
use crate::backend::{Backend, Cloud};
use crate::cloud::Surfels;
use crate::error::Result;
use crate::gbuffer::{GBuffer, SplatSettings};
use crate::job::Job;
use crate::measure::BounceReport;
use crate::settings::Settings;

/// Finds what mirrors show. Keeps working memory and the rays' tree between frames.
#[derive(Debug, Default)]
pub struct Reflector {
    labeller: Labeller,
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
    /// [`crate::Error::Memory`] where the rays' tree would not fit, what the backend meets, [`crate::Error::Cancelled`].
    pub fn reflect<B: Backend>(
        &mut self,
        backend: &mut B,
        cloud: &Cloud<B>,
        gbuffer: &GBuffer<B>,
        diagonal: f32,
        settings: &Settings,
        job: &Job,
    ) -> Result<(MirrorGBuffer<B>, BounceReport)> {
        job.progress("reflecting", 0, 0)?;
        let surface = backend.surface(gbuffer, job)?;
        let mut mirror = backend.reflected_rays(&surface, job)?;

        // Regions: both methods note them.
        let axes = Axes::from(&gbuffer.pinhole);
        let cells = backend.curvature(&surface, axes, &settings.lhc, job)?;
        let cells = backend.take(cells)?;
        let labeller = &mut self.labeller;
        let lhc = (backend.timings()).time("lhc", || labeller.lhc(&cells));
        let regions = lhc.regions.len() as u64;
        mirror.region = backend.write(lhc.labels.size(), lhc.labels.values())?;
        job.check()?;

        let (mut counts, mut searched) = (SearchCounts::default(), None);
        match settings.reflect.method {
            Method::RayTrace => {
                mirror = self.trace(backend, surface, mirror, cloud, settings, job)?;
            }
            Method::Sscr => {
                let mirrors = LabelledMirrors {
                    surface: &surface,
                    labels: &mirror.region,
                    regions: &lhc.regions,
                    right: gbuffer.pinhole.right,
                };
                let found =
                    backend.root_find(&cloud.points, &mirrors, &settings.sscr, diagonal, job)?;
                counts = found.1;
                backend.accumulate(&found.0, &cloud.points, &mut mirror, &settings.sscr, job)?;
                let coverage = backend.mirror_coverage(&mirror, job)?;
                backend.pull_push(&mut mirror, settings.sscr.pull_levels, job)?;
                searched = Some(coverage);
            }
        }
        let closed = backend.mirror_coverage(&mirror, job)?;
        let report = BounceReport::new(1, regions, counts, searched.unwrap_or(closed), closed);
        Ok((mirror, report))
    }

    /// Traces the reflected rays, with a tree that is built where there is none for this cloud.
    fn trace<B: Backend>(
        &mut self,
        backend: &mut B,
        surface: Surface<B>,
        mirror: MirrorGBuffer<B>,
        cloud: &Cloud<B>,
        settings: &Settings,
        job: &Job,
    ) -> Result<MirrorGBuffer<B>> {
        let surface = surface.take(backend)?;
        let mut traced = mirror.take(backend)?;
        let kept = self.tracer.take().filter(|t| {
            Arc::ptr_eq(&t.surfels, &cloud.surfels)
                && t.splat == settings.splat
                && t.settings == settings.ray_trace
        });
        let timings = backend.timings();
        let tracer = match kept {
            Some(tracer) => tracer,
            None => Tracer {
                surfels: Arc::clone(&cloud.surfels),
                splat: settings.splat.clone(),
                settings: settings.ray_trace.clone(),
                tracer: RayTracer::new(
                    &cloud.surfels,
                    &settings.splat,
                    &settings.ray_trace,
                    timings,
                    job,
                )?,
            },
        };
        let tracer = self.tracer.insert(tracer);
        tracer.tracer.trace(&surface, &mut traced, timings, job)?;
        traced.put(backend)
    }
}
