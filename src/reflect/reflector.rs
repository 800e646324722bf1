//! What the mirrors show, by the method of choice: the way from a G-buffer to the mirrors', written once for all backends.

use std::sync::Arc;

use glam::Vec3;

use super::cost::{Choice, Chosen, Work};
use super::doubt::empty_doubtful;
use super::ray_trace::{Pixels, RayTraceSettings, RayTracer};
use super::sscr::chart_class::CHART_CLASS;
use super::sscr::charts::{Chart, LEAST_PIXELS, charts};
use super::sscr::curvature::Axes;
use super::sscr::field::MirrorField;
use super::sscr::guided::Guide;
use super::sscr::heat::HeatSums;
use super::sscr::lhc::Labeller;
use super::sscr::prefix::{Budget, Prefix};
use super::sscr::root_find::SearchCounts;
use super::sscr::shorten::{TRIED, shorten};
use super::sscr::{Closing, Search};
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

/// The mirrors of a picture, ready for any method.
struct Mirrors<B: Backend> {
    surface: Surface<B>,
    /// The picture's x axis in the scene, unit length.
    right: Vec3,
    /// For the guided search.
    field: Option<MirrorField>,
}

/// A search's hits, and what they are worth.
struct Found<B: Backend> {
    hits: B::Hits,
    counts: SearchCounts,
    /// Points searched.
    searched: usize,
}

/// The guided search of a picture, fitted to its cloud.
struct Guided<'a> {
    field: &'a MirrorField,
    charts: Vec<Chart>,
    /// What the search of a few points came to.
    sample: SearchCounts,
}

impl Guided<'_> {
    /// Mirror pixels that can be searched: cells of charts.
    fn mirror_pixels(&self) -> u64 {
        self.charts.iter().map(|chart| chart.cells).sum()
    }
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
        let (mirrors, mut mirror) = self.label(backend, gbuffer, settings, job)?;
        let guided = match (&mirrors.field, settings.reflect.method) {
            (Some(field), Method::Sscr | Method::Auto) => {
                Some(self.chart(backend, cloud, field, settings, job)?)
            }
            (None, _) | (_, Method::RayTrace) => None,
        };
        let choice = Self::choose(cloud, guided.as_ref(), settings);

        let found = match (choice.method, &guided) {
            (Chosen::RayTrace, _) => None,
            (Chosen::Guided, Some(guided)) => {
                Some(self.search_guided(backend, cloud, guided, settings, job)?)
            }
            (Chosen::Guided | Chosen::Interleaved, _) => {
                let labelled = LabelledMirrors {
                    surface: &mirrors.surface,
                    labels: &mirror.region,
                    regions: &self.labeller.map().regions,
                    right: mirrors.right,
                };
                let (sscr, points) = (&settings.sscr, &cloud.points);
                let (hits, counts) = backend.root_find(points, &labelled, sscr, diagonal, job)?;
                Some(Found {
                    hits,
                    counts,
                    searched: cloud.surfels.len(),
                })
            }
        };
        let (mut counts, mut coverage) = (SearchCounts::default(), None);
        match found {
            None => {
                let all = Pixels::All;
                mirror = self.trace(backend, mirrors.surface, mirror, all, cloud, settings, job)?;
            }
            Some(found) => {
                counts = found.counts;
                let sscr = &settings.sscr;
                let splatting = sscr.splatting(
                    choice.method == Chosen::Guided,
                    &settings.splat,
                    found.searched,
                    cloud.surfels.len(),
                );
                backend.accumulate(&found.hits, &cloud.points, &mut mirror, &splatting, job)?;
                coverage = Some(backend.mirror_coverage(&mirror, job)?);
                match sscr.closing {
                    Closing::None => {}
                    Closing::PullPush => backend.pull_push(&mut mirror, sscr.pull_levels, job)?,
                    Closing::Rays => {
                        let (surface, empty) = (mirrors.surface, Pixels::Empty);
                        mirror =
                            self.trace(backend, surface, mirror, empty, cloud, settings, job)?;
                    }
                }
            }
        }
        let closed = backend.mirror_coverage(&mirror, job)?;
        let report = BounceReport {
            method: choice.method.name(),
            reason: choice.reason,
            ..BounceReport::new(
                1,
                self.labeller.map().regions.len() as u64,
                counts,
                coverage.unwrap_or(closed),
                closed,
            )
        };
        Ok((mirror, report))
    }

    /// The mirrors that a G-buffer shows, their rays, and their regions, which every method notes.
    fn label<B: Backend>(
        &mut self,
        backend: &mut B,
        gbuffer: &GBuffer<B>,
        settings: &Settings,
        job: &Job,
    ) -> Result<(Mirrors<B>, MirrorGBuffer<B>)> {
        let surface = backend.surface(gbuffer, job)?;
        let mut mirror = backend.reflected_rays(&surface, job)?;
        let axes = Axes::from(&gbuffer.pinhole);
        let cells = backend.curvature(&surface, axes, &settings.lhc, job)?;
        let cells = backend.take(cells)?;
        let labeller = &mut self.labeller;
        let guided = match settings.reflect.method {
            Method::Auto => true,
            Method::Sscr => settings.sscr.search == Search::Guided,
            Method::RayTrace => false,
        };
        let mut field = None;
        let lhc = if guided {
            let (smooth, classes) = backend.mirror_field(&surface, &cells, job)?;
            field = Some(smooth);
            let class = |cell| cell & CHART_CLASS;
            (backend.timings()).time("lhc", || {
                labeller.label_merged(&classes, class, LEAST_PIXELS)
            })
        } else {
            backend.timings().time("lhc", || labeller.lhc(&cells))
        };
        mirror.region = backend.write(lhc.labels.size(), lhc.labels.values())?;
        job.check()?;
        let mirrors = Mirrors {
            surface,
            right: gbuffer.pinhole.right,
            field,
        };
        Ok((mirrors, mirror))
    }

    /// The charts of the mirrors, and how a few points fare on them.
    fn chart<'a, B: Backend>(
        &mut self,
        backend: &mut B,
        cloud: &Cloud<B>,
        field: &'a MirrorField,
        settings: &Settings,
        job: &Job,
    ) -> Result<Guided<'a>> {
        let surfels = &cloud.surfels;
        let sample = Self::prefix(&mut self.prefix, surfels).sample(TRIED, &surfels.places);
        let lhc = self.labeller.map();
        backend.timings().time("charts", || {
            let mut charts = charts(field, lhc, job)?;
            shorten(&mut charts, field, &surfels.places, &sample, job)?;
            let guide = guide(field, &charts, settings);
            let (_, sample) = guide.search(surfels, &sample, job)?;
            Ok(Guided {
                field,
                charts,
                sample,
            })
        })
    }

    /// The method to take, and why.
    fn choose<B: Backend>(
        cloud: &Cloud<B>,
        guided: Option<&Guided<'_>>,
        settings: &Settings,
    ) -> Choice {
        let asked = |method| Choice {
            method,
            reason: "asked for".into(),
        };
        match (settings.reflect.method, guided) {
            (Method::RayTrace, _) => asked(Chosen::RayTrace),
            (Method::Sscr | Method::Auto, None) => asked(Chosen::Interleaved),
            (Method::Sscr, Some(_)) => asked(Chosen::Guided),
            (Method::Auto, Some(guided)) => {
                let points = cloud.surfels.len();
                let mirror_pixels = guided.mirror_pixels();
                let work = Work {
                    points,
                    budget: settings.sscr.budget(mirror_pixels),
                    mirror_pixels,
                    charts: guided.charts.len(),
                    sample: guided.sample,
                    needs_tree: settings.sscr.closing == Closing::Rays,
                };
                work.choose()
            }
        }
    }

    /// The guided search of as many points as the mirrors need.
    fn search_guided<B: Backend>(
        &mut self,
        backend: &mut B,
        cloud: &Cloud<B>,
        guided: &Guided<'_>,
        settings: &Settings,
        job: &Job,
    ) -> Result<Found<B>> {
        let guide = guide(guided.field, &guided.charts, settings);
        let budget = if guided.charts.is_empty() {
            Budget::Points(0)
        } else {
            settings.sscr.budget(guided.mirror_pixels())
        };
        let prefix = Self::prefix(&mut self.prefix, &cloud.surfels);
        let (hits, counts, searched) =
            backend.guided(&cloud.points, &guide, prefix, budget, job)?;
        Ok(Found {
            hits,
            counts,
            searched,
        })
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

    /// Traces the rays of these pixels, with a tree that is built where there is none for this cloud; of empty ones also
    /// those of doubtful pixels.
    #[expect(
        clippy::too_many_arguments,
        reason = "what is traced, where, and with what"
    )]
    fn trace<B: Backend>(
        &mut self,
        backend: &mut B,
        surface: Surface<B>,
        mirror: MirrorGBuffer<B>,
        pixels: Pixels,
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
        if pixels == Pixels::Empty {
            empty_doubtful(&mut traced);
        }
        tracer
            .tracer
            .trace(&surface, &mut traced, pixels, timings, job)?;
        traced.put(backend)
    }
}

/// The guided search on these charts.
fn guide<'a>(field: &'a MirrorField, charts: &'a [Chart], settings: &Settings) -> Guide<'a> {
    Guide {
        field,
        charts,
        self_hit: settings.sscr.self_hit,
        splat_size: settings.splat.size,
    }
}
