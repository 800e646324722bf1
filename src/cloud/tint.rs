//! Albedo of clouds: their own, or by intensity, height or class.

use std::borrow::Cow;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::rules::{CLASSIFICATION, column_of};
use super::{RawCloud, UpAxis};
use crate::error::Result;

/// What gives the points of a cloud their albedo.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColourBy {
    /// Their own colours; without any, their intensity; without that, their height.
    #[default]
    Auto,
    /// Their own colours.
    Rgb,
    /// Grey by intensity, stretched between the 2nd and 98th percentile.
    Intensity,
    /// From low and dark to high and light.
    Height,
    /// A colour for each class (`classification`), those of the LAS standard in colours that map makers use.
    Class,
}

impl ColourBy {
    /// Every choice, in the order of the words.
    pub const ALL: [Self; 5] = [
        Self::Auto,
        Self::Rgb,
        Self::Intensity,
        Self::Height,
        Self::Class,
    ];

    /// The word of scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Rgb => "rgb",
            Self::Intensity => "intensity",
            Self::Height => "height",
            Self::Class => "class",
        }
    }

    /// The column that a reader must keep for it.
    pub fn column(self) -> Option<&'static str> {
        (self == Self::Class).then_some(CLASSIFICATION)
    }
}

/// What lies below the first or above the second of these parts of all values is drawn as they are.
const STRETCH: [f64; 2] = [0.02, 0.98];

/// Linear albedo from the lowest to the highest points: dark and blue to light and warm, ever lighter.
const HEIGHT_COLOURS: [Vec3; 5] = [
    Vec3::new(0.04, 0.08, 0.30),
    Vec3::new(0.05, 0.30, 0.36),
    Vec3::new(0.22, 0.48, 0.18),
    Vec3::new(0.72, 0.58, 0.24),
    Vec3::new(0.90, 0.87, 0.82),
];

/// Albedo of points that cannot be told apart.
const PLAIN: Vec3 = Vec3::splat(0.8);

/// Linear albedo of the LAS standard's classes 0 to 18: never classified, unclassified, ground, low, middle and high
/// vegetation, building, noise, key point, water, rail, road, overlap, wires (guard, conductor), tower, insulator, bridge,
/// high noise.
const CLASS_COLOURS: [Vec3; 19] = [
    Vec3::new(0.35, 0.35, 0.35),
    Vec3::new(0.50, 0.50, 0.50),
    Vec3::new(0.36, 0.20, 0.08),
    Vec3::new(0.30, 0.55, 0.12),
    Vec3::new(0.10, 0.42, 0.08),
    Vec3::new(0.02, 0.24, 0.05),
    Vec3::new(0.70, 0.14, 0.08),
    Vec3::new(0.80, 0.05, 0.55),
    Vec3::new(0.85, 0.80, 0.25),
    Vec3::new(0.04, 0.20, 0.75),
    Vec3::new(0.30, 0.08, 0.45),
    Vec3::new(0.14, 0.14, 0.16),
    Vec3::new(0.70, 0.70, 0.55),
    Vec3::new(0.85, 0.65, 0.05),
    Vec3::new(0.90, 0.45, 0.02),
    Vec3::new(0.25, 0.30, 0.60),
    Vec3::new(0.10, 0.60, 0.60),
    Vec3::new(0.50, 0.40, 0.30),
    Vec3::new(0.90, 0.10, 0.35),
];

/// The albedo of every point of a cloud, whose positions are in the scene's frame.
///
/// # Errors
/// [`crate::Error::Cloud`] where the cloud lacks the column that was asked for.
pub(super) fn albedo_by<'a>(
    by: ColourBy,
    raw: &'a RawCloud,
    name: &str,
) -> Result<Cow<'a, [Vec3]>> {
    let height = || by_height(&raw.positions, raw.up_axis.unwrap_or(UpAxis::Z).vector());
    let own = raw.albedo.as_deref();
    Ok(match by {
        ColourBy::Auto => match own {
            Some(own) => own.into(),
            None => {
                let grey = raw.intensity.as_deref().and_then(by_intensity);
                grey.unwrap_or_else(height).into()
            }
        },
        ColourBy::Rgb => match own {
            Some(own) => own.into(),
            None => return Err(lacks(name, "colours")),
        },
        ColourBy::Intensity => match raw.intensity.as_deref() {
            // All of one intensity are of one grey.
            Some(values) => by_intensity(values)
                .unwrap_or_else(|| vec![PLAIN; values.len()])
                .into(),
            None => return Err(lacks(name, "intensities")),
        },
        ColourBy::Height => height().into(),
        ColourBy::Class => {
            let classes = column_of(raw, CLASSIFICATION, "colour = \"class\"", name)?;
            classes.par_iter().map(|&class| of_class(class)).collect()
        }
    })
}

fn lacks(name: &str, what: &str) -> crate::Error {
    let problem =
        format!("its points have no {what} to be coloured by; use colour = \"auto\" or \"height\"");
    crate::Error::cloud(std::path::Path::new(name), problem)
}

/// Classes beyond the standard's are told apart by their hue.
pub(super) fn of_class(class: f32) -> Vec3 {
    let class = class as usize;
    CLASS_COLOURS.get(class).copied().unwrap_or_else(|| {
        let turn = (class as f32 * GOLDEN).fract() * std::f32::consts::TAU;
        let third = std::f32::consts::TAU / 3.0;
        Vec3::new(turn, turn - third, turn + third).map(|angle| 0.45 + 0.35 * angle.cos())
    })
}

/// Hues that follow one another at this part of the circle are far apart.
const GOLDEN: f32 = 0.618_034;

/// Grey by intensity, stretched between the 2nd and 98th percentile; `None` where these are the same.
fn by_intensity(intensity: &[f32]) -> Option<Vec<Vec3>> {
    let stretched = stretch(intensity.to_vec())?;
    Some(
        intensity
            .par_iter()
            .map(|&value| Vec3::splat(stretched(value)))
            .collect(),
    )
}

/// Colours by height along `up`, stretched in the same way; plain grey where all points are of one height.
fn by_height(positions: &[DVec3], up: DVec3) -> Vec<Vec3> {
    // Heights relative to the first point keep their digits in single precision.
    let base = positions.first().copied().unwrap_or_default();
    let heights: Vec<f32> = positions
        .par_iter()
        .map(|&p| (p - base).dot(up) as f32)
        .collect();
    match stretch(heights.clone()) {
        Some(stretched) => heights
            .par_iter()
            .map(|&height| ramp(stretched(height)))
            .collect(),
        None => vec![PLAIN; positions.len()],
    }
}

fn stretch(mut values: Vec<f32>) -> Option<impl Fn(f32) -> f32> {
    values.retain(|value| value.is_finite());
    let [low, high] = STRETCH.map(|part| percentile(&mut values, part));
    let (low, high) = (low?, high?);
    (high > low).then_some(move |value: f32| ((value - low) / (high - low)).clamp(0.0, 1.0))
}

/// The value below which the `part` of all values lies; reorders them.
pub(super) fn percentile(values: &mut [f32], part: f64) -> Option<f32> {
    let last = values.len().checked_sub(1)?;
    let index = ((last as f64 * part).round() as usize).min(last);
    Some(*values.select_nth_unstable_by(index, f32::total_cmp).1)
}

fn ramp(part: f32) -> Vec3 {
    let place = part * (HEIGHT_COLOURS.len() - 1) as f32;
    let below = (place as usize).min(HEIGHT_COLOURS.len() - 2);
    HEIGHT_COLOURS[below].lerp(HEIGHT_COLOURS[below + 1], place - below as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intensity_is_stretched_between_percentiles_whatever_the_outliers() {
        let mut intensity: Vec<f32> = (0..=1000).map(|i| 100.0 + i as f32).collect();
        intensity[0] = 60_000.0;
        let albedo = by_intensity(&intensity).unwrap();
        assert_eq!(albedo[0], Vec3::ONE);
        assert!(
            (albedo[500].x - 0.5).abs() < 0.01,
            "the middle is grey: {}",
            albedo[500]
        );
        assert_eq!(
            by_intensity(&[5.0; 10]),
            None,
            "equal intensities say nothing"
        );
    }

    #[test]
    fn height_runs_from_dark_to_light() {
        let positions: Vec<DVec3> = (0..100)
            .map(|i| DVec3::new(1e6, f64::from(i), 0.0))
            .collect();
        let albedo = by_height(&positions, DVec3::Y);
        assert_eq!(albedo[0], HEIGHT_COLOURS[0]);
        assert_eq!(albedo[99], HEIGHT_COLOURS[4]);
        assert_eq!(
            by_height(&positions, DVec3::Z),
            vec![PLAIN; 100],
            "all of one height"
        );
    }
}
