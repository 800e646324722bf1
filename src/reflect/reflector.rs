//! What the mirrors show, by the method of choice: the way from a G-buffer to the mirrors', written once for all backends.

use std::sync::Arc;

use super::ray_trace::{RayTraceSettings, RayTracer};
use super::sscr::Search;
use super::sscr::chart_class::CHART_CLASS;
use super::sscr::charts::{LEAST_PIXELS, charts};
use super::sscr::curvature::Axes;
use super::sscr::guided::{Guide, TRIED, shorten};
use super::sscr::heat::HeatSums;
use super::sscr::lhc::Labeller;
use super::sscr::prefix::Prefix;
use super::sscr::root_find::SearchCounts;
use super::{LabelledMirrors, Method, MirrorGBuffer, Surface};
use crate::backend::{Backend, Cloud};
use crate::cloud::Surfels;
use crate::error::Result;
use crate::gbuffer::{GBuffer, SplatSettings};
use crate::grid::Grid;
use crate::job::Job;
use crate::measure::BounceReport;
use crate::settings::Settings;

/// Finds what mirrors show. Keeps working memory and the rays' tree between frames.
#[derive(Debug, Default)]
pub struct Reflector {
    labeller: Labeller,
    tracer: Option<Tracer>,
    prefix: Option<(Arc<Surfels>, Prefix)>,
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

        // Regions: every method notes them.
        let axes = Axes::from(&gbuffer.pinhole);
        let cells = backend.curvature(&surface, axes, &settings.lhc, job)?;
        let cells = backend.take(cells)?;
        let labeller = &mut self.labeller;
        let mut field = None;
        let lhc = match settings.sscr.search {
            Search::Interleaved => backend.timings().time("lhc", || labeller.lhc(&cells)),
            Search::Guided => {
                let (smooth, classes) = backend.mirror_field(&surface, &cells, job)?;
                field = Some(smooth);
                let class = |cell| cell & CHART_CLASS;
                (backend.timings()).time("lhc", || {
                    labeller.label_merged(&classes, class, LEAST_PIXELS)
                })
            }
        };
        let regions = lhc.regions.len() as u64;
        mirror.region = backend.write(lhc.labels.size(), lhc.labels.values())?;

        let (mut counts, mut searched) = (SearchCounts::default(), None);
        match settings.reflect.method {
            Method::RayTrace => {
                mirror = self.trace(backend, surface, mirror, cloud, settings, job)?;
            }
            Method::Sscr => {
                let points = cloud.surfels.len();
                let (hits, counted, of_points) = match &field {
                    None => {
                        let mirrors = LabelledMirrors {
                            surface: &surface,
                            labels: &mirror.region,
                            regions: &lhc.regions,
                            right: gbuffer.pinhole.right,
                        };
                        let sscr = &settings.sscr;
                        let (hits, counted) =
                            backend.root_find(&cloud.points, &mirrors, sscr, diagonal, job)?;
                        (hits, counted, points)
                    }
                    Some(field) => {
                        let prefix = Self::prefix(&mut self.prefix, &cloud.surfels);
                        let places = &cloud.surfels.places;
                        let timings = backend.timings();
                        let mut charts = timings.time("charts", || charts(field, lhc, job))?;
                        timings.time("charts", || {
                            shorten(&mut charts, field, places, &prefix.sample(TRIED, places));
                        });
                        let guide = Guide {
                            field,
                            charts: &charts,
                            self_hit: settings.sscr.self_hit,
                            splat_size: settings.splat.size,
                        };
                        let mirror_pixels = lhc.regions.iter().map(|r| u64::from(r.pixels)).sum();
                        let budget = settings.sscr.budget(mirror_pixels);
                        backend.guided(&cloud.points, &guide, prefix, budget, job)?
                    }
                };
                counts = counted;
                let splatting = settings.sscr.splatting(&settings.splat, of_points, points);
                backend.accumulate(&hits, &cloud.points, &mut mirror, &splatting, job)?;
                let coverage = backend.mirror_coverage(&mirror, job)?;
                backend.pull_push(&mut mirror, settings.sscr.pull_levels, job)?;
                searched = Some(coverage);
            }
        }
        let closed = backend.mirror_coverage(&mirror, job)?;
        let report = BounceReport::new(1, regions, counts, searched.unwrap_or(closed), closed);
        Ok((mirror, report))
    }

    /// Where the searches end, to look at.
    ///
    /// # Errors
    /// What the backend meets, [`crate::Error::Cancelled`].
    pub fn search_heat<B: Backend>(
        &mut self,
        backend: &mut B,
        cloud: &Cloud<B>,
        gbuffer: &GBuffer<B>,
        settings: &Settings,
        job: &Job,
    ) -> Result<Grid<HeatSums>> {
        let surface = backend.surface(gbuffer, job)?;
        let axes = Axes::from(&gbuffer.pinhole);
        let cells = backend.curvature(&surface, axes, &settings.lhc, job)?;
        let cells = backend.take(cells)?;
        let labeller = &mut self.labeller;
        let lhc = (backend.timings()).time("lhc", || labeller.lhc(&cells));
        let mirrors = LabelledMirrors {
            surface: &surface,
            labels: &backend.write(lhc.labels.size(), lhc.labels.values())?,
            regions: &lhc.regions,
            right: gbuffer.pinhole.right,
        };
        backend.search_heat(&cloud.points, &mirrors, &settings.sscr, job)
    }

    /// The order in which the points of a cloud are searched, begun anew for another cloud.
    fn prefix<'a>(
        kept: &'a mut Option<(Arc<Surfels>, Prefix)>,
        surfels: &Arc<Surfels>,
    ) -> &'a mut Prefix {
        if !kept
            .as_ref()
            .is_some_and(|(of, _)| Arc::ptr_eq(of, surfels))
        {
            *kept = None;
        }
        &mut kept
            .get_or_insert_with(|| (Arc::clone(surfels), Prefix::default()))
            .1
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
