//! The mirrors of analytic scenes as the guided search takes them.

use catoptric::Job;
use catoptric::backend::cpu::Cpu;
use catoptric::cloud::Surfels;
use catoptric::reflect::Surface;
use catoptric::reflect::sscr::chart_class::{CHART_CLASS, chart_class};
use catoptric::reflect::sscr::charts::{Chart, LEAST_PIXELS, charts};
use catoptric::reflect::sscr::curvature::{Axes, LhcSettings, curvature};
use catoptric::reflect::sscr::field::MirrorField;
use catoptric::reflect::sscr::guided::Guide;
use catoptric::reflect::sscr::lhc::Labeller;
use catoptric::reflect::sscr::shorten::shorten;
use glam::{DVec2, Vec3};

/// Mirrors with their charts.
pub(crate) struct Charted {
    pub(crate) field: MirrorField,
    pub(crate) charts: Vec<Chart>,
}

impl Charted {
    /// The charts of mirrors seen along these axes, fitted to a cloud.
    pub(crate) fn new(surface: &Surface<Cpu>, axes: Axes, surfels: &Surfels) -> Self {
        let cells = curvature(surface, axes, &LhcSettings::default());
        let classes = chart_class(surface, &cells);
        let mut labeller = Labeller::default();
        let lhc = labeller.label_merged(&classes, |c| c & CHART_CLASS, LEAST_PIXELS);
        let field = MirrorField::new(surface, &cells).expect("a small picture");
        let mut charts = charts(&field, lhc, &Job::default()).expect("no cancellation");
        let sample: Vec<u32> = (0..surfels.len() as u32).collect();
        shorten(
            &mut charts,
            &field,
            &surfels.places,
            &sample,
            &Job::default(),
        )
        .expect("no cancellation");
        Self { field, charts }
    }

    pub(crate) fn guide(&self) -> Guide<'_> {
        Guide {
            field: &self.field,
            charts: &self.charts,
            self_hit: 5.0,
            splat_size: 1.5,
        }
    }

    /// Every pixel that shows a point.
    pub(crate) fn find(&self, point: Vec3) -> Vec<DVec2> {
        let roots = self.guide().find(point);
        (roots.iter())
            .map(|root| self.field.pixel_of_place(root.at).as_dvec2())
            .collect()
    }
}
