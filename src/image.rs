//! Radiance becomes a picture: exposure, tone mapping, background.

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
        /// Colour where nothing is seen: "transparent" or "#rrggbb".
        background: Background = Background::Colour([0, 0, 0]);
        /// Strength of eye-dome lighting in scenes without light; 0 turns it off.
        edl_strength: f32 = 1.0, 0.0..=100.0, "";
        /// Distance of the neighbours that eye-dome lighting compares.
        edl_radius: f32 = 1.4, 0.5..=16.0, "pixels";
    }
}

/// What is shown where nothing is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Background {
    /// Alpha 0.
    Transparent,
    /// sRGB.
    Colour([u8; 3]),
}

impl TryFrom<String> for Background {
    type Error = String;
    fn try_from(text: String) -> Result<Self, String> {
        if text == "transparent" {
            return Ok(Self::Transparent);
        }
        let hex = text
            .strip_prefix('#')
            .filter(|h| h.len() == 6)
            .and_then(|h| u32::from_str_radix(h, 16).ok());
        hex.map(|h| Self::Colour([(h >> 16) as u8, (h >> 8) as u8, h as u8]))
            .ok_or_else(|| {
                format!("{text:?} is no background; write \"transparent\" or \"#rrggbb\"")
            })
    }
}

impl From<Background> for String {
    fn from(b: Background) -> Self {
        match b {
            Background::Transparent => "transparent".into(),
            Background::Colour([r, g, b]) => format!("#{r:02x}{g:02x}{b:02x}"),
        }
    }
}

impl crate::settings::SettingValue for Background {}
