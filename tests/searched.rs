//! A search in the mirrors of analytic scenes, compared with all roots.

use catoptric::backend::cpu::Cpu;
use catoptric::cloud::Place;
use catoptric::gbuffer::GBuffer;
use catoptric::reflect::sscr::curvature::{Axes, LhcSettings, curvature};
use catoptric::reflect::sscr::distribute::distribute;
use catoptric::reflect::sscr::lhc::Labeller;
use catoptric::reflect::sscr::mirror_error::{MirrorPoint, mirror_error};
use catoptric::reflect::sscr::root_find::{Outcome, RootFindParams, RootFinder};
use catoptric::reflect::sscr::{Distribution, LhcMap};
use catoptric::reflect::{LabelledMirrors, Surface};
use glam::{DVec2, Vec2, Vec3};
use rayon::prelude::*;

use crate::analytic::{Oracle, View};
use crate::ideal::{cloud, regions, surface};
use crate::roots::{Quality, Root, Roots, quality};

/// An error function of the search.
pub(crate) type ErrorFunction = fn(&MirrorPoint, Vec3) -> Vec2;

/// Mirrors in which points are searched.
pub(crate) struct Mirrors {
    surface: Surface<Cpu>,
    lhc: LhcMap,
    right: Vec3,
}

/// The thesis's settings but for the threshold.
pub(crate) fn thesis(threshold: f32) -> RootFindParams {
    RootFindParams {
        seed_attempts: 6,
        step_attempts: 6,
        max_steps: 50,
        initial_step: 0.2,
        threshold,
        self_hit: 4.0,
    }
}

impl Mirrors {
    /// The exact mirrors of an analytic scene.
    pub(crate) fn exact(scene: &str, view: &View) -> Self {
        let surface = surface(view, &Oracle::named(scene).view(view), 0.0);
        let lhc = regions(view, &surface);
        Self {
            surface,
            lhc,
            right: Vec3::X,
        }
    }

    /// The mirrors of a splatted picture.
    pub(crate) fn splatted(gbuffer: &GBuffer<Cpu>, settings: &LhcSettings) -> Self {
        let surface = Surface::of(gbuffer);
        let cells = curvature(&surface, Axes::from(&gbuffer.pinhole), settings);
        Self {
            surface,
            lhc: Labeller::default().lhc(&cells).clone(),
            right: gbuffer.pinhole.right,
        }
    }

    /// How the search for each point ends, each in one region by the regions' weights.
    pub(crate) fn outcomes(
        &self,
        places: &[Place],
        params: RootFindParams,
        error: ErrorFunction,
    ) -> Vec<Outcome> {
        let finder = RootFinder::new(
            &LabelledMirrors::new(&self.surface, &self.lhc, self.right),
            params,
        );
        let finder = finder.expect("a small picture");
        let outcome = |(index, place): (usize, &Place)| {
            let index = index as u32;
            let region = distribute(&self.lhc.regions, Distribution::Weighted, index, 0);
            let region = region.expect("a mirror has regions");
            finder.find_by(error, index, place.position, region)
        };
        places.par_iter().enumerate().map(outcome).collect()
    }

    /// What the search for these points costs and finds.
    pub(crate) fn cost(&self, places: &[Place], params: RootFindParams) -> Cost {
        let outcomes = self.outcomes(places, params, mirror_error);
        let (mut hits, mut of_hits, mut steps) = (0, 0, 0);
        for outcome in &outcomes {
            match outcome {
                Outcome::Found(root) => {
                    hits += 1;
                    of_hits += root.steps;
                    steps += root.steps;
                }
                Outcome::Lost(end) => steps += end.steps,
            }
        }
        let points = outcomes.len() as f64;
        Cost {
            hit_rate: f64::from(hits) / points,
            steps: f64::from(steps) / points,
            steps_of_hits: f64::from(of_hits) / f64::from(hits.max(1)),
        }
    }
}

/// What a search costs and finds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cost {
    /// Part of the points that are found.
    pub(crate) hit_rate: f64,
    /// Mean number of steps of all points.
    pub(crate) steps: f64,
    /// Mean number of steps of those that are found.
    pub(crate) steps_of_hits: f64,
}

/// Points of a scene, each with all places where the mirrors show it.
pub(crate) struct Known {
    pub(crate) places: Vec<Place>,
    roots: Vec<Vec<Root>>,
}

impl Known {
    /// Random points of an analytic scene.
    pub(crate) fn new(scene: &str, view: &View, points: usize) -> Self {
        let name = scene.parse().expect("a scene");
        Self::of(scene, view, &cloud(name, points).places)
    }

    /// The roots of these points.
    pub(crate) fn of(scene: &str, view: &View, places: &[Place]) -> Self {
        let oracle = Oracle::named(scene);
        let hits = oracle.view(view);
        let roots = Roots::new(oracle, *view, &hits);
        let of = |place: &Place| roots.of(place.position.as_dvec3());
        Self {
            places: places.to_vec(),
            roots: places.par_iter().map(of).collect(),
        }
    }

    /// How well they are found by a search that tells all places where it finds a point.
    pub(crate) fn quality_by(&self, find: impl Fn(Vec3) -> Vec<DVec2> + Sync) -> Quality {
        let hits: Vec<Vec<DVec2>> = self.places.par_iter().map(|p| find(p.position)).collect();
        let found: Vec<_> = self.roots.iter().cloned().zip(hits).collect();
        quality(&found)
    }

    /// How well they are found.
    pub(crate) fn quality(
        &self,
        mirrors: &Mirrors,
        params: RootFindParams,
        error: ErrorFunction,
    ) -> Quality {
        let outcomes = mirrors.outcomes(&self.places, params, error);
        let hits = outcomes.iter().map(|outcome| match outcome {
            Outcome::Found(root) => vec![root.pixel.as_dvec2()],
            Outcome::Lost(_) => Vec::<DVec2>::new(),
        });
        let found: Vec<_> = self.roots.iter().cloned().zip(hits).collect();
        quality(&found)
    }
}
