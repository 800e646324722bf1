//! Every setting of the program, assembled from the stages that own them.
//!
//! A group is declared with [`settings_group!`](crate::settings_group) beside its stage: the declaration makes the struct, its defaults,
//! its reading from TOML, its checks, and the description that `--help`, `--set` and the viewer list; so a new
//! setting cannot be forgotten anywhere.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// What a person needs to know of one setting.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// Dotted name, "splat.size".
    pub key: String,
    /// What it does: assumption, unit, cost, source.
    pub doc: String,
    /// Unit for people, or "".
    pub unit: &'static str,
    /// Smallest and largest value allowed, where it is a number.
    pub range: Option<(f64, f64)>,
    /// Names allowed, where it is a choice.
    pub choices: &'static [&'static str],
    /// The default, as TOML.
    pub default: toml::Value,
}

/// A value that a setting can have.
pub trait SettingValue: Serialize + Clone + PartialEq {
    /// The value as a number, where it is one.
    fn number(&self) -> Option<f64> {
        None
    }
    /// Names allowed, where it is a choice.
    fn choices() -> &'static [&'static str] {
        &[]
    }
}

impl SettingValue for f32 {
    fn number(&self) -> Option<f64> {
        Some(f64::from(*self))
    }
}
impl SettingValue for u32 {
    fn number(&self) -> Option<f64> {
        Some(f64::from(*self))
    }
}
impl SettingValue for bool {
    fn choices() -> &'static [&'static str] {
        &["true", "false"]
    }
}

/// A group of settings: a stage's own.
pub trait SettingsGroup {
    /// Describes every setting of the group.
    fn describe() -> Vec<Description>;
    /// The settings that differ from their defaults, by dotted name.
    fn changed(&self) -> Vec<(String, toml::Value)>;
    /// Refuses values outside their range.
    ///
    /// # Errors
    /// [`Error::Setting`] that names the key, the value and the range.
    fn check(&self) -> Result<()>;
}

/// A setting's value as TOML.
#[doc(hidden)]
pub fn as_toml<T: SettingValue>(value: &T) -> toml::Value {
    // f32 is written with the digits that a person typed, not with those of its f64 neighbour.
    match toml::Value::try_from(value) {
        Ok(toml::Value::Float(f)) => {
            toml::Value::Float((f as f32).to_string().parse().unwrap_or(f))
        }
        Ok(v) => v,
        Err(_) => toml::Value::String(String::new()),
    }
}

/// Refuses a value outside its range.
#[doc(hidden)]
pub fn check_range<T: SettingValue>(key: &str, value: &T, range: Option<(f64, f64)>) -> Result<()> {
    if let (Some((low, high)), Some(v)) = (range, value.number())
        && !(low..=high).contains(&v)
    {
        return Err(Error::Setting(format!(
            "{key} is {v}; it must be {low} to {high}"
        )));
    }
    Ok(())
}

/// Declares a group of settings.
///
/// ```text
/// settings_group! {
///     /// How points become a G-buffer.
///     pub struct SplatSettings in "splat" {
///         /// Half width of a splat.
///         size: f32 = 1.5, 0.5..=8.0, "x radius";
///         /// Whether holes are filled.
///         fill: bool = true;
///     }
/// }
/// ```
#[macro_export]
macro_rules! settings_group {
    (
        $(#[doc = $group_doc:literal])*
        pub struct $name:ident in $group:literal {
            $(
                $(#[doc = $doc:literal])*
                $field:ident : $type:ty = $default:expr $(, $low:literal ..= $high:literal, $unit:literal)? ;
            )*
        }
    ) => {
        $(#[doc = $group_doc])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $(
                $(#[doc = $doc])*
                pub $field: $type,
            )*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl $crate::settings::SettingsGroup for $name {
            fn describe() -> Vec<$crate::settings::Description> {
                let default = Self::default();
                vec![$({
                    #[allow(unused_mut, unused_assignments, reason = "only some settings have a range")]
                    let (mut range, mut unit) = (None, "");
                    $( range = Some(($low as f64, $high as f64)); unit = $unit; )?
                    $crate::settings::Description {
                        key: concat!($group, ".", stringify!($field)).into(),
                        doc: [$($doc.trim()),*].join(" "),
                        unit,
                        range,
                        choices: <$type as $crate::settings::SettingValue>::choices(),
                        default: $crate::settings::as_toml(&default.$field),
                    }
                }),*]
            }

            fn changed(&self) -> Vec<(String, toml::Value)> {
                let default = Self::default();
                let mut changed = Vec::new();
                $(
                    if self.$field != default.$field {
                        changed.push((
                            concat!($group, ".", stringify!($field)).into(),
                            $crate::settings::as_toml(&self.$field),
                        ));
                    }
                )*
                changed
            }

            fn check(&self) -> $crate::error::Result<()> {
                $(
                    #[allow(unused_mut, unused_assignments, reason = "only some settings have a range")]
                    let mut range: Option<(f64, f64)> = None;
                    $( range = Some(($low as f64, $high as f64)); )?
                    $crate::settings::check_range(concat!($group, ".", stringify!($field)), &self.$field, range)?;
                )*
                Ok(())
            }
        }
    };
}

/// Declares an enum that is a setting: its names in TOML are those given.
#[macro_export]
macro_rules! setting_choice {
    (
        $(#[doc = $enum_doc:literal])*
        pub enum $name:ident { $( $(#[doc = $doc:literal])* $variant:ident = $text:literal ),* $(,)? }
    ) => {
        $(#[doc = $enum_doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $name { $( $(#[doc = $doc])* #[serde(rename = $text)] $variant ),* }

        impl $crate::settings::SettingValue for $name {
            fn choices() -> &'static [&'static str] {
                &[$($text),*]
            }
        }
    };
}

macro_rules! settings {
    ($($(#[doc = $doc:literal])* $field:ident : $type:ty;)*) => {
        /// Every setting. Each group belongs to the stage that it is named after.
        #[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct Settings { $($(#[doc = $doc])* pub $field: $type,)* }

        impl Settings {
            /// Describes every setting there is, group by group.
            pub fn describe() -> Vec<Description> {
                let mut all = Vec::new();
                $( all.extend(<$type>::describe()); )*
                all
            }

            /// The settings that differ from their defaults, by dotted name.
            pub fn changed(&self) -> Vec<(String, toml::Value)> {
                let mut all = Vec::new();
                $( all.extend(self.$field.changed()); )*
                all
            }

            /// Refuses values outside their range.
            ///
            /// # Errors
            /// [`Error::Setting`] that names the key, the value and the range.
            pub fn check(&self) -> Result<()> {
                $( self.$field.check()?; )*
                Ok(())
            }
        }
    };
}

impl Settings {
    /// The value of the setting of this dotted name, if there is such a setting.
    pub fn value(&self, key: &str) -> Option<toml::Value> {
        let (group, name) = key.split_once('.')?;
        let all = toml::Value::try_from(self).ok()?;
        let value = all.get(group)?.get(name)?;
        // f32 is written with the digits that a person typed, not with those of its f64 neighbour.
        Some(match value {
            toml::Value::Float(f) => {
                toml::Value::Float((*f as f32).to_string().parse().unwrap_or(*f))
            }
            other => other.clone(),
        })
    }

    /// These settings, but for one.
    ///
    /// # Errors
    /// [`Error::Setting`] where there is no such setting, or it cannot have the value.
    pub fn with(&self, key: &str, value: toml::Value) -> Result<Self> {
        let unknown = || Error::Setting(format!("there is no setting {key:?}"));
        let refused = |e: &dyn std::fmt::Display| Error::Setting(format!("{key}: {e}"));
        let (group, name) = key.split_once('.').ok_or_else(unknown)?;
        let mut all = toml::Value::try_from(self).map_err(|e| refused(&e))?;
        let place = all.get_mut(group).and_then(|g| g.get_mut(name));
        *place.ok_or_else(unknown)? = value;
        let changed: Self = all
            .try_into()
            .map_err(|e: toml::de::Error| refused(&e.message()))?;
        changed.check()?;
        Ok(changed)
    }
}

settings! {
    /// How points become a G-buffer.
    splat: crate::gbuffer::SplatSettings;
    /// How the light reaches the points.
    gi: crate::gi::GiSettings;
    /// What mirrors show.
    reflect: crate::reflect::ReflectSettings;
    /// How mirrors are cut into regions of homogeneous curvature.
    lhc: crate::reflect::sscr::curvature::LhcSettings;
    /// How mirrors are searched for what they show.
    sscr: crate::reflect::sscr::SscrSettings;
    /// How reflected rays are traced.
    ray_trace: crate::reflect::ray_trace::RayTraceSettings;
    /// How radiance becomes a picture.
    image: crate::image::ImageSettings;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_setting_is_read_and_changed_by_its_name() {
        let settings = Settings::default();
        for setting in Settings::describe() {
            let key = &setting.key;
            let value = settings.value(key);
            assert_eq!(value.as_ref(), Some(&setting.default), "{key}");
            let other = match (&setting.default, setting.range) {
                (toml::Value::Boolean(b), _) => toml::Value::Boolean(!b),
                (toml::Value::Integer(_), Some((low, high))) => {
                    toml::Value::Integer(((low + high) / 2.0) as i64)
                }
                (toml::Value::Float(_), Some((low, high))) => {
                    toml::Value::Float(f64::from((low * 0.25 + high * 0.75) as f32))
                }
                _ => continue,
            };
            let changed = settings.with(key, other.clone()).expect(key);
            let read = changed.value(key).and_then(|v| v.as_float());
            let wanted = other.as_float();
            assert!(
                changed.value(key) == Some(other)
                    || (read.zip(wanted)).is_some_and(|(a, b)| (a - b).abs() <= 1e-6 * b.abs()),
                "{key}: {read:?} for {wanted:?}"
            );
        }
    }

    #[test]
    fn what_a_setting_cannot_be_is_refused() {
        let settings = Settings::default();
        for (key, value) in [
            ("splat.size", toml::Value::Float(1e9)),
            ("splat.size", toml::Value::String("large".into())),
            ("splat.colour", toml::Value::Float(1.0)),
            ("size", toml::Value::Float(1.0)),
        ] {
            let refused = settings.with(key, value).expect_err("no such value");
            assert!(refused.to_string().contains(key), "{refused}");
        }
    }
}
