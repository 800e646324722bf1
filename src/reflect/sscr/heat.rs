//! Pass `search_heat`: where the searches of all points end, pixel by pixel: how many found and how many lost their point
//! there, after how many steps, and how well. To look at, and only where asked for: it runs the search once more.
//!
//! Sums are integers, so that neither threads nor backends matter.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use bytemuck::{Pod, Zeroable};
use glam::Vec2;
use rayon::prelude::*;

use super::distribute::distribute;
use super::root_find::{Outcome, RootFindParams, RootFinder};
use super::{Search, SscrSettings};
use crate::backend::cpu::Cpu;
use crate::cloud::{Surfels, require_memory};
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::job::Job;
use crate::reflect::{LabelledMirrors, Method};
use crate::settings::Settings;

/// Fixed-point units of a residual of 1.
pub const RESIDUAL_SCALE: f32 = 16_777_216.0;

/// Residuals above this count as this.
pub const MAX_RESIDUAL: f32 = 64.0;

/// Points a task.
const CHUNK: usize = 1 << 12;

/// The searches that ended in a pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct HeatSums {
    /// Steps of those that found their point.
    pub steps: u64,
    /// Their residuals, in [`RESIDUAL_SCALE`]ths.
    pub residual: u64,
    /// How many found their point.
    pub found: u32,
    /// How many lost it; those that found no place in the region to start from are in no pixel.
    pub lost: u32,
}

impl HeatSums {
    /// Steps of a search that found its point, on average; 0 where none did.
    pub fn mean_steps(&self) -> f32 {
        self.steps as f32 / self.found.max(1) as f32
    }

    /// Length of the error where a point was found, on average; 0 where none was.
    pub fn mean_residual(&self) -> f32 {
        self.residual as f32 / RESIDUAL_SCALE / self.found.max(1) as f32
    }
}

/// The same, while threads add to it.
#[derive(Debug, Default)]
struct Sums {
    steps: AtomicU64,
    residual: AtomicU64,
    found: AtomicU32,
    lost: AtomicU32,
}

impl Sums {
    fn add(&self, outcome: &Outcome) {
        match outcome {
            Outcome::Found(root) => {
                let residual = (root.residual.min(MAX_RESIDUAL) * RESIDUAL_SCALE) as u64;
                self.steps.fetch_add(root.steps.into(), Ordering::Relaxed);
                self.residual.fetch_add(residual, Ordering::Relaxed);
                self.found.fetch_add(1, Ordering::Relaxed);
            }
            Outcome::Lost(_) => {
                self.lost.fetch_add(1, Ordering::Relaxed);
            }
        }
    }

    fn into_sums(self) -> HeatSums {
        HeatSums {
            steps: self.steps.into_inner(),
            residual: self.residual.into_inner(),
            found: self.found.into_inner(),
            lost: self.lost.into_inner(),
        }
    }
}

/// That the search runs that there is to look at.
///
/// # Errors
/// [`Error::Setting`] where it does not.
pub fn require_search(settings: &Settings) -> Result<()> {
    match (settings.reflect.method, settings.sscr.search) {
        (Method::Sscr, Search::Interleaved) => Ok(()),
        (Method::Auto | Method::RayTrace, _) | (Method::Sscr, Search::Guided) => Err(Error::Setting(
            "the heat is that of the interleaved search; set reflect.method to \"sscr\" and sscr.search to \"interleaved\"".into(),
        )),
    }
}

/// Where the searches of [`super::root_find::root_find`] end.
///
/// # Errors
/// [`Error::Memory`] where the picture is too large, [`Error::Cancelled`].
pub fn search_heat(
    surfels: &Surfels,
    mirrors: &LabelledMirrors<'_, Cpu>,
    settings: &SscrSettings,
    job: &Job,
) -> Result<Grid<HeatSums>> {
    let size = mirrors.surface.size;
    let finder = RootFinder::new(mirrors, RootFindParams::from(settings))?;
    let pixels = size.x as usize * size.y as usize;
    require_memory(
        "the heat of the search",
        (pixels * 2 * size_of::<Sums>()) as u64,
    )?;
    let sums: Vec<Sums> = (0..pixels).map(|_| Sums::default()).collect();
    let sums_at = |at: Vec2| sums.get(at.y as usize * size.x as usize + at.x as usize);
    for pass in 0..settings.passes {
        let chunks = surfels.places.par_chunks(CHUNK).enumerate();
        chunks.try_for_each(|(chunk, places)| {
            job.check()?;
            for (index, place) in ((chunk * CHUNK) as u32..).zip(places) {
                let region = distribute(mirrors.regions, settings.distribution, index, pass);
                let Some(region) = region else { continue };
                let outcome = finder.find(index, place.position, region);
                if let Some(sums) = outcome.pixel().and_then(sums_at) {
                    sums.add(&outcome);
                }
            }
            Ok(())
        })?;
    }
    let heat = sums.into_iter().map(Sums::into_sums).collect();
    Grid::from_vec(size, heat).ok_or_else(|| Error::Setting("the picture is empty".into()))
}
