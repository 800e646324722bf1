//! Where the interleaved search of f32 and that of f64 part: the same mirrors and points, of which the numbers are f32, and
//! the same random places to start from.

use glam::{DVec2, Vec3};
use rayon::prelude::*;
use serde::Serialize;

use super::percentiles::Percentiles;
use crate::backend::cpu::Cpu;
use crate::cloud::{Place, require_memory};
use crate::error::Result;
use crate::gbuffer::GBuffer;
use crate::job::Job;
use crate::reflect::sscr::SscrSettings;
use crate::reflect::sscr::curvature::{Axes, curvature};
use crate::reflect::sscr::distribute::distribute;
use crate::reflect::sscr::lhc::Labeller;
use crate::reflect::sscr::root_find::{Outcome, RootFindParams, RootFinder};
use crate::reflect::{LabelledMirrors, Surface};
use crate::settings::Settings;

/// Hits farther apart than this are others, pixels: by as much may backends differ.
pub const SAME_HIT: f64 = 0.01;

/// Points a task.
const CHUNK: usize = 1 << 12;

/// Where a point was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundBy {
    /// Index of the surfel.
    pub point: u32,
    /// By f32, pixels; `None` where it was not.
    pub single: Option<DVec2>,
    /// By f64, pixels.
    pub double: Option<DVec2>,
}

/// How far both part.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Precision {
    /// Points searched.
    pub offered: u64,
    /// Those of them that f32 found.
    pub hit_f32: u64,
    /// Those that f64 found.
    pub hit_f64: u64,
    /// Share of the points that only one found, or both more than [`SAME_HIT`] apart.
    pub part: f64,
    /// Distance of the hits where both found one, pixels.
    pub apart_px: Percentiles,
}

impl FoundBy {
    /// Distance of both hits, pixels, where there are two.
    pub fn apart(&self) -> Option<f64> {
        Some(self.single?.distance(self.double?))
    }

    /// Whether both come to the same.
    pub fn agrees(&self) -> bool {
        match (self.single, self.double) {
            (None, None) => true,
            (Some(a), Some(b)) => a.distance(b) <= SAME_HIT,
            (Some(_), None) | (None, Some(_)) => false,
        }
    }
}

impl Precision {
    /// So many of the points searched, percent.
    pub fn percent(&self, points: u64) -> f64 {
        points as f64 / self.offered.max(1) as f64 * 100.0
    }

    /// Of so many points searched, of which these were found by either.
    pub fn of(offered: u64, found: &[FoundBy]) -> Self {
        let count = |of: &dyn Fn(&&FoundBy) -> bool| found.iter().filter(of).count() as u64;
        let other = count(&|f| !f.agrees());
        Self {
            offered,
            hit_f32: count(&|f| f.single.is_some()),
            hit_f64: count(&|f| f.double.is_some()),
            part: other as f64 / offered.max(1) as f64,
            apart_px: Percentiles::of(found.iter().filter_map(FoundBy::apart).collect()),
        }
    }
}

/// Searches all points in the mirrors of a picture by f32 and by f64: how many there were, and those that either found, in
/// the order of the points.
///
/// # Errors
/// [`crate::Error::Memory`] where the picture or the hits are too many, [`crate::Error::Cancelled`].
pub fn found_by_both(
    gbuffer: &GBuffer<Cpu>,
    places: &[Place],
    settings: &Settings,
    job: &Job,
) -> Result<(u64, Vec<FoundBy>)> {
    let surface = Surface::of(gbuffer);
    let axes = Axes::from(&gbuffer.pinhole);
    let cells = curvature(&surface, axes, &settings.lhc);
    let mut labeller = Labeller::default();
    let mirrors = LabelledMirrors::new(&surface, labeller.lhc(&cells), gbuffer.pinhole.right);
    found_in(&mirrors, places, &settings.sscr, job)
}

/// The same in mirrors that are labelled.
///
/// # Errors
/// As [`found_by_both`].
pub fn found_in(
    mirrors: &LabelledMirrors<'_, Cpu>,
    places: &[Place],
    settings: &SscrSettings,
    job: &Job,
) -> Result<(u64, Vec<FoundBy>)> {
    let params = RootFindParams::from(settings);
    let single = RootFinder::<f32>::with(mirrors, params)?;
    let double = RootFinder::<f64>::with(mirrors, params)?;
    let memory = (places.len() * size_of::<FoundBy>()) as u64;
    require_memory("comparing hits of f32 and f64", memory)?;

    let both = |point: u32, position: Vec3| {
        let region = distribute(mirrors.regions, settings.distribution, point, 0)?;
        let single = match single.find(point, position, region) {
            Outcome::Found(root) => Some(root.pixel.as_dvec2()),
            Outcome::Lost(_) => None,
        };
        let double = match double.find(point, position.as_dvec3(), region) {
            Outcome::Found(root) => Some(root.pixel),
            Outcome::Lost(_) => None,
        };
        Some(FoundBy {
            point,
            single,
            double,
        })
    };
    let chunks: Vec<(u64, Vec<FoundBy>)> = places
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(chunk, places)| {
            job.check()?;
            let first = (chunk * CHUNK) as u32;
            let all = (first..).zip(places);
            let (mut offered, mut found) = (0, Vec::new());
            for hit in all.filter_map(|(point, place)| both(point, place.position)) {
                offered += 1;
                if hit.single.is_some() || hit.double.is_some() {
                    found.push(hit);
                }
            }
            Ok((offered, found))
        })
        .collect::<Result<_>>()?;
    let offered = chunks.iter().map(|(offered, _)| offered).sum();
    Ok((
        offered,
        chunks.into_iter().flat_map(|(_, hits)| hits).collect(),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hits_of_one_alone_and_hits_apart_are_others() {
        let at = |x: f64| Some(DVec2::new(x, 0.0));
        let hit = |single, double| FoundBy {
            point: 0,
            single,
            double,
        };
        let found = [
            hit(at(1.0), at(1.0)),
            hit(at(1.0), at(1.005)),
            hit(at(1.0), at(3.0)),
            hit(at(1.0), None),
            hit(None, at(1.0)),
        ];
        let precision = Precision::of(10, &found);
        assert_eq!((precision.hit_f32, precision.hit_f64), (4, 4));
        assert_eq!((precision.part, precision.apart_px.max), (0.3, 2.0));
        assert_eq!(Precision::of(10, &found[..2]).part, 0.0, "negative control");
    }
}
