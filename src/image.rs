//! Radiance becomes a picture: exposure, tone mapping, background.
//!
//! The curves: E. Reinhard, M. Stark, P. Shirley, J. Ferwerda, "Photographic tone reproduction for digital images",
//! 2002, eq. 3; K. Narkowicz, "ACES filmic tone mapping curve", 2016; IEC 61966-2-1 (sRGB).

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use crate::grid::Grid;
use crate::{setting_choice, settings_group};

setting_choice! {
    /// How radiance above 1 is brought into a picture.
    pub enum ToneMap {
        /// Clipped at 1.
        None = "none",
        /// x / (1 + x) of the luminance [Reinhard et al. 2002].
        Reinhard = "reinhard",
        /// Filmic curve of the Academy Color Encoding System, in Narkowicz's fit.
        Aces = "aces",
    }
}

settings_group! {
    /// How radiance becomes a picture.
    pub struct ImageSettings in "image" {
        /// Factor on radiance before tone mapping.
        exposure: f32 = 1.0, 0.0..=1e9, "x";
        /// How radiance above 1 is brought into the picture.
        tone_map: ToneMap = ToneMap::None;
        /// Colour where nothing is seen: "auto" (the environment, black where there is none), "transparent" or "#rrggbb".
        background: Background = Background::Auto;
        /// Strength of eye-dome lighting in scenes without light; 0 turns it off.
        edl_strength: f32 = 1.0, 0.0..=100.0, "";
        /// Distance of the neighbours that eye-dome lighting compares.
        edl_radius: f32 = 1.4, 0.5..=16.0, "pixels";
        /// Pictures with a longer side are made in parts of at most this size, each with regions and a search of its own.
        part_size: u32 = 4096, 256..=32768, "pixels";
    }
}

/// What is shown where nothing is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Background {
    /// The environment; black where there is none.
    Auto,
    /// Alpha 0.
    Transparent,
    /// sRGB.
    Colour([u8; 3]),
}

impl TryFrom<String> for Background {
    type Error = String;
    fn try_from(text: String) -> Result<Self, String> {
        match text.as_str() {
            "auto" => return Ok(Self::Auto),
            "transparent" => return Ok(Self::Transparent),
            _ => {}
        }
        let hex = text
            .strip_prefix('#')
            .filter(|h| h.len() == 6 && h.bytes().all(|b| b.is_ascii_hexdigit()))
            .and_then(|h| u32::from_str_radix(h, 16).ok());
        hex.map(|h| Self::Colour([(h >> 16) as u8, (h >> 8) as u8, h as u8]))
            .ok_or_else(|| {
                format!("{text:?} is no background; write \"auto\", \"transparent\" or \"#rrggbb\"")
            })
    }
}

impl From<Background> for String {
    fn from(b: Background) -> Self {
        match b {
            Background::Auto => "auto".into(),
            Background::Transparent => "transparent".into(),
            Background::Colour([r, g, b]) => format!("#{r:02x}{g:02x}{b:02x}"),
        }
    }
}

impl crate::settings::SettingValue for Background {}

impl Background {
    /// Linear RGB, premultiplied: black where transparent, and where there is no environment.
    pub fn linear(self) -> Vec3 {
        match self {
            Self::Auto | Self::Transparent => Vec3::ZERO,
            Self::Colour(srgb) => {
                Vec3::from(srgb.map(|value| linear_from_srgb(f32::from(value) / 255.0)))
            }
        }
    }
}

/// Radiance above this is as good as infinite: every tone map takes it to white without overflow.
const BRIGHTEST: f32 = 1e9;

/// Luminance of linear RGB with the primaries of sRGB [IEC 61966-2-1].
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// The picture of radiance (W/sr/m2, alpha 1 where something is seen, else 0): sRGB of 8 bits and alpha, straight.
///
/// The same size as `radiance`. Where nothing is seen there is the background. What is not a number is black.
pub fn picture(radiance: &Grid<Vec4>, settings: &ImageSettings) -> Grid<[u8; 4]> {
    let background = match settings.background {
        Background::Auto => [0, 0, 0, 255],
        Background::Transparent => [0; 4],
        Background::Colour([r, g, b]) => [r, g, b, 255],
    };
    let mut picture = Grid::new(radiance.size(), background);
    picture
        .values_mut()
        .par_iter_mut()
        .zip(radiance.values())
        .filter(|(_, seen)| seen.w > 0.0)
        .for_each(|(pixel, seen)| {
            let shown = tone_mapped(seen.truncate() * settings.exposure, settings.tone_map);
            let [r, g, b] = shown.to_array().map(srgb_from_linear);
            *pixel = [r, g, b, 255];
        });
    picture
}

/// The linear RGB that a display is asked to show of a pixel's radiance (alpha 1 where something is seen, else 0), or of
/// the background where nothing is seen; above 1 it clips.
pub fn shown(radiance: Vec4, settings: &ImageSettings) -> Vec3 {
    if radiance.w > 0.0 {
        tone_mapped(radiance.truncate() * settings.exposure, settings.tone_map)
    } else {
        settings.background.linear()
    }
}

/// Exposed radiance, brought towards 0 to 1.
fn tone_mapped(exposed: Vec3, tone_map: ToneMap) -> Vec3 {
    let light = exposed.map(|v| {
        if v.is_nan() {
            0.0
        } else {
            v.clamp(0.0, BRIGHTEST)
        }
    });
    match tone_map {
        ToneMap::None => light,
        ToneMap::Reinhard => light / (1.0 + light.dot(LUMINANCE)),
        ToneMap::Aces => light.map(|x| x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)),
    }
}

/// 8-bit sRGB of a linear value, clipped to 0 to 1 [IEC 61966-2-1].
pub fn srgb_from_linear(linear: f32) -> u8 {
    let x = linear.clamp(0.0, 1.0);
    let encoded = if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    };
    (encoded * 255.0 + 0.5) as u8
}

/// The linear value of an sRGB value, both 0 to 1 [IEC 61966-2-1].
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    fn of(radiance: Vec4, settings: &ImageSettings) -> [u8; 4] {
        picture(&Grid::new(UVec2::ONE, radiance), settings).values()[0]
    }

    #[test]
    fn pixels_are_srgb_of_exposed_radiance() {
        let settings = ImageSettings {
            exposure: 4.0,
            ..ImageSettings::default()
        };
        for step in 0..=3000 {
            let radiance = step as f32 / 10_000.0;
            let exposed = (f64::from(radiance) * 4.0).clamp(0.0, 1.0);
            let encoded = if exposed <= 0.0031308 {
                12.92 * exposed
            } else {
                1.055 * exposed.powf(1.0 / 2.4) - 0.055
            };
            let (got, exact) = (
                of(Vec4::new(radiance, 0.0, 0.0, 1.0), &settings)[0],
                encoded * 255.0 + 0.5,
            );
            // Where the exact value lies on a step, the last bit of f32 decides.
            let near_step = (exact - exact.round()).abs() < 1e-4;
            assert!(
                got == exact as u8 || near_step,
                "radiance {radiance}: got {got}, expected {exact}"
            );
        }
    }

    #[test]
    fn every_8_bit_value_survives_the_way_to_linear_and_back() {
        for value in 0..=255 {
            let linear = linear_from_srgb(f32::from(value) / 255.0);
            assert_eq!(srgb_from_linear(linear), value);
        }
    }

    #[test]
    fn no_radiance_gives_a_broken_pixel() {
        let white = [255, 255, 255, 255];
        let brightest = [
            (ToneMap::None, white),
            (ToneMap::Reinhard, white),
            (ToneMap::Aces, white),
        ];
        for (tone_map, expected) in brightest {
            let settings = ImageSettings {
                tone_map,
                ..ImageSettings::default()
            };
            assert_eq!(
                of(
                    Vec4::new(f32::INFINITY, f32::INFINITY, f32::INFINITY, 1.0),
                    &settings
                ),
                expected,
                "{tone_map:?}"
            );
            assert_eq!(
                of(Vec4::new(f32::NAN, -1.0, f32::NEG_INFINITY, 1.0), &settings),
                [0, 0, 0, 255],
                "{tone_map:?}"
            );
        }
    }

    #[test]
    fn tone_maps_follow_their_curves() {
        let reinhard = tone_mapped(Vec3::ONE, ToneMap::Reinhard);
        assert!(
            (reinhard - Vec3::splat(0.5)).length() < 1e-6,
            "luminance 1 becomes 1/2, got {reinhard}"
        );
        let aces = tone_mapped(Vec3::ONE, ToneMap::Aces).x;
        assert!((aces - 2.54 / 3.16).abs() < 1e-6, "got {aces}");
        assert_eq!(tone_mapped(Vec3::ONE, ToneMap::None), Vec3::ONE);
    }

    #[test]
    fn what_is_empty_shows_the_background() {
        let of_background = |background| ImageSettings {
            background,
            ..ImageSettings::default()
        };
        let empty = Vec4::new(0.5, 0.5, 0.5, 0.0);
        assert_eq!(of(empty, &of_background(Background::Transparent)), [0; 4]);
        assert_eq!(of(empty, &of_background(Background::Auto)), [0, 0, 0, 255]);
        assert_eq!(
            of(empty, &of_background(Background::Colour([1, 2, 3]))),
            [1, 2, 3, 255]
        );
    }

    #[test]
    fn backgrounds_are_read_as_they_are_written() {
        for text in ["auto", "transparent", "#0a0b0c"] {
            let background = Background::try_from(text.to_owned()).expect("a background");
            assert_eq!(String::from(background), text);
        }
        for text in ["", "#", "#12345", "#+12345", "#1234567", "#gggggg", "red"] {
            assert!(
                Background::try_from(text.to_owned()).is_err(),
                "{text:?} must be refused"
            );
        }
    }
}
