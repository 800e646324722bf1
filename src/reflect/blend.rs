//! The mirrors' picture over the points' own: weighted by the reflectance of each mirror pixel [Preiner 2010, section 4.7].

use glam::Vec4;
use rayon::prelude::*;

use super::MirrorGBuffer;
use crate::backend::cpu::Cpu;
use crate::error::Result;
use crate::gbuffer::GBuffer;
use crate::grid::Grid;
use crate::job::Job;

/// Adds what the mirrors show to `radiance`, which holds the points' own part. Without light (`shown` is `None`) mirrors
/// show albedo, as everything else does; where they see nothing they are black.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn blend(
    radiance: &mut Grid<Vec4>,
    gbuffer: &GBuffer<Cpu>,
    mirror: &MirrorGBuffer<Cpu>,
    shown: Option<&Grid<Vec4>>,
    job: &Job,
) -> Result<()> {
    let pixels = radiance
        .values_mut()
        .par_iter_mut()
        .zip(gbuffer.albedo.values())
        .enumerate();
    pixels
        .filter(|(_, (_, own))| own.w > 0.0)
        .for_each(|(i, (radiance, own))| {
            let reflected = match shown {
                Some(shown) => shown.values().get(i).copied().unwrap_or_default(),
                // Unlit, the own part is not yet weighted.
                None => {
                    let keep = 1.0 - own.w;
                    *radiance *= Vec4::new(keep, keep, keep, 1.0);
                    mirror
                        .at(i)
                        .map_or(Vec4::ZERO, |seen| seen.albedo * (1.0 - seen.albedo.w))
                }
            };
            *radiance += (reflected * own.w).truncate().extend(0.0);
        });
    job.check()
}
