//! Charts whose direction maps find what their trees find do without the trees.

use glam::Vec3;
use rayon::prelude::*;

use super::charts::{Chart, Seeds};
use super::field::MirrorField;
use super::guided::{CHUNK, SAME_ROOT, Work};
use crate::cloud::Place;
use crate::error::Result;
use crate::job::Job;

/// Points on which shortcuts are tried.
pub const TRIED: usize = 2048;

/// Places of the tried points that must be known before a shortcut is judged.
const LEAST_TRIED: u32 = 24;

/// Share of a tree's places that a map must find.
const FOUND_BY_MAP: f32 = 0.985;

/// Lets charts go without their trees where the direction maps alone find what the trees do, as the points `sample` tell.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn shorten(
    charts: &mut [Chart],
    field: &MirrorField,
    places: &[Place],
    sample: &[u32],
    job: &Job,
) -> Result<()> {
    let positions: Vec<Vec3> = (sample.iter().take(TRIED))
        .filter_map(|&index| places.get(index as usize).map(|p| p.position))
        .collect();
    charts.par_iter_mut().try_for_each(|chart| {
        job.check()?;
        let Some(map) = chart.shortcut.take().map(Seeds::Map) else {
            return Ok(());
        };
        let (mut by_tree, mut by_map) = (0, 0);
        let [mut tree, mut shortcut] = [Work::default(), Work::default()];
        for chunk in positions.chunks(CHUNK) {
            tree.find(field, [(&chart.beam, &chart.seeds)].into_iter(), chunk);
            shortcut.find(field, [(&chart.beam, &map)].into_iter(), chunk);
            for (all, known) in tree.roots.iter().zip(&shortcut.roots) {
                by_tree += all.len() as u32;
                let near = |a: f32| a < SAME_ROOT * SAME_ROOT;
                let same =
                    (all.iter()).any(|a| known.iter().any(|b| near(a.at.distance_squared(b.at))));
                by_map += u32::from(same);
            }
        }
        if by_tree >= LEAST_TRIED && by_map as f32 >= FOUND_BY_MAP * by_tree as f32 {
            chart.seeds = map;
        }
        Ok(())
    })
}
