//! What can be turned to make a picture faster or better: settings, and where their values lie.

use crate::error::{Error, Result};
use crate::settings::{Description, Settings};

/// What is turned unless told otherwise.
pub const USUAL_KEYS: &[&str] = &[
    "reflect.method",
    "sscr.search",
    "sscr.points_per_pixel",
    "sscr.max_steps",
    "sscr.seed_attempts",
    "sscr.step_attempts",
    "sscr.initial_step",
    "sscr.threshold",
];

/// Numbers are tried from this part of their default to as many times it.
const REACH: f64 = 8.0;

/// Where numbers are tried whose default is 0, which means by itself or none.
const AROUND_ZERO: (f64, f64) = (0.5, 32.0);

/// The first primes: the bases of the sequence.
const PRIMES: [u32; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];

/// A setting, and the values that are tried.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Knob {
    /// Dotted name.
    pub key: String,
    /// What it is unless it is turned.
    pub default: toml::Value,
    values: Values,
}

#[derive(Debug, Clone, PartialEq)]
enum Values {
    Names(Vec<toml::Value>),
    /// Between low and high, equal ratios equally likely.
    Numbers {
        low: f64,
        high: f64,
        whole: bool,
    },
}

impl Knob {
    /// The knobs of these keys; their defaults are the settings given.
    ///
    /// # Errors
    /// [`Error::Setting`] for a key that is no setting or has nothing to turn, or for too many.
    pub(super) fn of(keys: &[&str], settings: &Settings) -> Result<Vec<Self>> {
        if keys.len() > PRIMES.len() {
            return Err(Error::Setting(format!(
                "at most {} keys can be tuned at a time",
                PRIMES.len()
            )));
        }
        let described = Settings::describe();
        let changed = settings.changed();
        let of = |key: &&str| {
            let found = described.iter().find(|d| d.key == *key).ok_or_else(|| {
                Error::Setting(format!(
                    "there is no setting {key:?} to tune; catoptric info --settings lists them"
                ))
            })?;
            let now = changed
                .iter()
                .find(|(k, _)| k == key)
                .map(|(_, value)| value.clone());
            Self::new(found, now)
        };
        keys.iter().map(of).collect()
    }

    fn new(description: &Description, now: Option<toml::Value>) -> Result<Self> {
        let Description {
            key,
            choices,
            range,
            default,
            ..
        } = description;
        let default = now.unwrap_or_else(|| default.clone());
        let number = default
            .as_float()
            .or(default.as_integer().map(|i| i as f64));
        let values = match (range, number) {
            _ if !choices.is_empty() => Values::Names(
                (choices.iter())
                    .map(|name| match default {
                        toml::Value::Boolean(_) => toml::Value::Boolean(*name == "true"),
                        _ => toml::Value::String((*name).to_owned()),
                    })
                    .collect(),
            ),
            (Some((least, most)), Some(number)) => {
                let (low, high) = if number > 0.0 {
                    (number / REACH, number * REACH)
                } else {
                    AROUND_ZERO
                };
                Values::Numbers {
                    low: low.max(*least).max(1e-6),
                    high: high.min(*most),
                    whole: default.is_integer(),
                }
            }
            _ => {
                return Err(Error::Setting(format!(
                    "{key} is neither a number nor a choice, and cannot be tuned"
                )));
            }
        };
        Ok(Self {
            key: key.clone(),
            default,
            values,
        })
    }

    /// Every name that it can have; none of a number.
    pub(super) fn names(&self) -> &[toml::Value] {
        match &self.values {
            Values::Names(names) => names,
            Values::Numbers { .. } => &[],
        }
    }

    /// The value at `place`, 0 to below 1, of its span.
    fn at(&self, place: f64) -> toml::Value {
        match &self.values {
            Values::Names(names) => {
                let index = (place * names.len() as f64) as usize;
                names
                    .get(index)
                    .cloned()
                    .unwrap_or_else(|| self.default.clone())
            }
            Values::Numbers { low, high, whole } => written(low * (high / low).powf(place), *whole),
        }
    }

    /// A number `factor` times as large, within its span; `None` where that is no other number.
    pub(super) fn scaled(&self, value: &toml::Value, factor: f64) -> Option<toml::Value> {
        let Values::Numbers { low, high, whole } = &self.values else {
            return None;
        };
        let number = value.as_float().or(value.as_integer().map(|i| i as f64))?;
        let turned = written((number * factor).clamp(*low, *high), *whole);
        (number > 0.0 && turned != *value).then_some(turned)
    }
}

/// A number with three digits, or whole.
fn written(number: f64, whole: bool) -> toml::Value {
    if whole {
        return toml::Value::Integer(number.round() as i64);
    }
    let digits = (2.0 - number.abs().max(1e-9).log10().floor()).max(0.0) as usize;
    toml::Value::Float(format!("{number:.digits$}").parse().unwrap_or(number))
}

/// The settings number `index` of a sequence that fills the space of the knobs evenly: J. Halton, "On the efficiency of
/// certain quasi-random sequences of points", 1960.
pub(super) fn halton(knobs: &[Knob], index: u32) -> Vec<toml::Value> {
    knobs
        .iter()
        .zip(PRIMES)
        .map(|(knob, base)| knob.at(radical_inverse(index + 1, base)))
        .collect()
}

/// The digits of a number mirrored at the point.
fn radical_inverse(mut index: u32, base: u32) -> f64 {
    let (mut inverse, mut digit) = (0.0, 1.0);
    while index > 0 {
        digit /= f64::from(base);
        inverse += digit * f64::from(index % base);
        index /= base;
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_fills_the_space_and_stays_in_it() {
        let knobs = Knob::of(USUAL_KEYS, &Settings::default()).expect("settings");
        let all: Vec<_> = (0..64).map(|i| halton(&knobs, i)).collect();
        let steps: Vec<i64> = all.iter().filter_map(|c| c[3].as_integer()).collect();
        let (least, most) = (steps.iter().min(), steps.iter().max());
        assert!(
            least.is_some_and(|l| (3..6).contains(l)),
            "24 / 8 and more: {least:?}"
        );
        assert!(
            most.is_some_and(|m| (120..=192).contains(m)),
            "to 24 x 8: {most:?}"
        );
        for name in knobs[1].names() {
            let n = all.iter().filter(|c| &c[1] == name).count();
            assert!((28..=36).contains(&n), "half have {name}: {n}");
        }
    }

    #[test]
    fn what_cannot_be_turned_is_refused() {
        for key in ["splat.sise", "image.background"] {
            assert!(Knob::of(&[key], &Settings::default()).is_err(), "{key}");
        }
    }

    #[test]
    fn numbers_are_written_short() {
        assert_eq!(written(0.123_456, false).to_string(), "0.123");
        assert_eq!(written(23.6, true).to_string(), "24");
    }
}
