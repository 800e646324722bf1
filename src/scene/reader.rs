//! Typed reading of a document's values; every refusal names the key, the value and what is allowed.

use std::path::PathBuf;

use glam::DVec3;

use super::keys;
use super::tree::{Node, Origin, Origins, Value};
use crate::error::Result;
use crate::gi::MAX_OUTER_DEGREES;

/// The numbers that a key takes, and how to say so.
pub(super) struct Allowed {
    low: f64,
    high: f64,
    says: &'static str,
}

/// Anywhere in space.
pub(super) const COORDINATE: Allowed = Allowed {
    low: -1e15,
    high: 1e15,
    says: "from -1e15 to 1e15",
};
/// A length that something must have.
pub(super) const LENGTH: Allowed = Allowed {
    low: f64::MIN_POSITIVE,
    high: 1e12,
    says: "above 0, at most 1e12",
};
/// A length or amount that may be missing.
pub(super) const AMOUNT: Allowed = Allowed {
    low: 0.0,
    high: 1e12,
    says: "from 0 to 1e12",
};
/// Radiance.
pub(super) const RADIANCE: Allowed = Allowed {
    low: 0.0,
    high: 1e9,
    says: "from 0 to 1e9",
};
/// A share of the whole.
pub(super) const FRACTION: Allowed = Allowed {
    low: 0.0,
    high: 1.0,
    says: "from 0 to 1",
};
/// Height of a blob's waves, relative to its radius.
pub(super) const AMPLITUDE: Allowed = Allowed {
    low: 0.0,
    high: 0.9,
    says: "from 0 to 0.9",
};
/// Exponent of a Phong lobe.
pub(super) const SHININESS: Allowed = Allowed {
    low: 0.0,
    high: 65_535.0,
    says: "from 0 to 65535",
};
/// Half angle of a spot light.
pub(super) const HALF_ANGLE: Allowed = Allowed {
    low: 0.0,
    high: MAX_OUTER_DEGREES as f64,
    says: "from 0 to 80 degrees",
};
/// Field of view.
pub(super) const FIELD_OF_VIEW: Allowed = Allowed {
    low: 0.1,
    high: 178.9,
    says: "from 0.1 to 178.9 degrees",
};

/// A table of the document whose keys are all known.
pub(super) struct Table<'a> {
    node: &'a Node,
    /// Dotted name: "cloud.0".
    pub(super) name: String,
}

/// A value of the document with its dotted name.
pub(super) struct Field<'a> {
    node: &'a Node,
    name: String,
}

impl<'a> Table<'a> {
    /// The table `node`, which is called `name` and has no keys but `known`.
    pub(super) fn open(node: &'a Node, name: impl Into<String>, known: &[&str]) -> Result<Self> {
        let name = name.into();
        let Value::Table(entries) = &node.value else {
            return Err(node
                .origin
                .error(format!("{name} must be a table, not {}", node.value.kind())));
        };
        if let Some(entry) = entries.iter().find(|e| !known.contains(&e.key.as_str())) {
            let place = if name.is_empty() {
                "the scene".to_owned()
            } else {
                name
            };
            let remedy = keys::nearest(&entry.key, known.iter().copied()).map_or_else(
                || format!("its keys are {}", known.join(", ")),
                keys::did_you_mean,
            );
            return Err(entry.origin.error(format!(
                "there is no key {:?} in {place}; {remedy}",
                entry.key
            )));
        }
        Ok(Self { node, name })
    }

    /// Where the table was written.
    pub(super) fn origin(&self) -> &'a Origin {
        &self.node.origin
    }

    /// Where the table and its keys were written.
    pub(super) fn origins(&self) -> Origins {
        Origins::of(self.node)
    }

    /// The value of `key`, where the table has it.
    pub(super) fn get(&self, key: &str) -> Option<Field<'a>> {
        let name = if self.name.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.name)
        };
        self.node.get(key).map(|node| Field { node, name })
    }

    /// The value of `key`, which the table must have; `example` says what to write.
    pub(super) fn required(&self, key: &str, example: &str) -> Result<Field<'a>> {
        self.get(key).ok_or_else(|| {
            self.origin().error(format!(
                "{} needs a {key}; write {key} = {example}",
                self.name
            ))
        })
    }

    /// The value of `key`, read by `read`, where the table has it.
    pub(super) fn optional<T>(
        &self,
        key: &str,
        read: impl FnOnce(Field<'a>) -> Result<T>,
    ) -> Result<Option<T>> {
        self.get(key).map(read).transpose()
    }
}

impl<'a> Field<'a> {
    /// That this value is wrong.
    pub(super) fn error<T>(&self, problem: impl std::fmt::Display) -> Result<T> {
        Err(self.node.origin.error(format!("{} {problem}", self.name)))
    }

    /// That this value must be `what`.
    pub(super) fn must_be<T>(&self, what: &str) -> Result<T> {
        let found = match &self.node.value {
            Value::String(s) => format!("{s:?}"),
            Value::Integer(_) | Value::Float(_) | Value::Boolean(_) | Value::Datetime(_) => {
                self.node.value.to_toml().to_string()
            }
            Value::Path(_) | Value::Array(_) | Value::Table(_) => self.node.value.kind().to_owned(),
        };
        self.error(format!("is {found}; it must be {what}"))
    }

    /// The table, which has no keys but `known`.
    pub(super) fn table(&self, known: &[&str]) -> Result<Table<'a>> {
        Table::open(self.node, self.name.clone(), known)
    }

    /// The tables of an array of tables; `header` is how the file says one: "[[cloud]]".
    pub(super) fn tables(&self, header: &str) -> Result<Vec<Self>> {
        match &self.node.value {
            Value::Array(nodes) => Ok(self.elements(nodes)),
            _ => self.must_be(&format!("a list of tables; write {header}")),
        }
    }

    /// A number.
    pub(super) fn number(&self, allowed: &Allowed) -> Result<f64> {
        let number = match self.node.value {
            Value::Integer(i) => i as f64,
            Value::Float(f) => f,
            _ => return self.must_be(&format!("a number {}", allowed.says)),
        };
        if (allowed.low..=allowed.high).contains(&number) {
            Ok(number)
        } else {
            self.must_be(&format!("a number {}", allowed.says))
        }
    }

    /// A whole number from `low` to `high`.
    pub(super) fn whole(&self, low: i64, high: i64) -> Result<i64> {
        match self.node.value {
            Value::Integer(i) if (low..=high).contains(&i) => Ok(i),
            _ => self.must_be(&format!("a whole number from {low} to {high}")),
        }
    }

    /// True or false.
    pub(super) fn truth(&self) -> Result<bool> {
        match self.node.value {
            Value::Boolean(truth) => Ok(truth),
            _ => self.must_be("true or false"),
        }
    }

    /// A string.
    pub(super) fn text(&self) -> Result<&'a str> {
        match &self.node.value {
            Value::String(s) => Ok(s),
            _ => self.must_be("a string in quotes"),
        }
    }

    /// One of `names`.
    pub(super) fn choice(&self, names: &[&'static str]) -> Result<&'static str> {
        let one_of = || format!("one of {}", keys::alternatives(names));
        let Value::String(text) = &self.node.value else {
            return self.must_be(&one_of());
        };
        match names.iter().find(|n| **n == text.as_str()) {
            Some(name) => Ok(name),
            None => {
                let advice = keys::nearest(text, names.iter().copied())
                    .map_or(String::new(), |nearest| {
                        format!("; {}", keys::did_you_mean(nearest))
                    });
                self.error(format!("is {text:?}; it must be {}{advice}", one_of()))
            }
        }
    }

    /// A path, taken from the folder of the scene file, or from the current one where the caller gave it.
    pub(super) fn path(&self) -> Result<PathBuf> {
        let path = match &self.node.value {
            Value::String(s) => s.into(),
            Value::Path(p) => p.clone(),
            _ => return self.must_be("a path in quotes"),
        };
        if path.as_os_str().is_empty() {
            return self.error("is empty; write the path of a file");
        }
        Ok(self.node.origin.folder().join(path))
    }

    /// Exactly `COUNT` numbers; `what` says which: "[x, y, z]".
    pub(super) fn numbers<const COUNT: usize>(
        &self,
        what: &str,
        allowed: &Allowed,
    ) -> Result<[f64; COUNT]> {
        let mut numbers = [0.0; COUNT];
        match &self.node.value {
            Value::Array(nodes) if nodes.len() == COUNT => {
                for (number, element) in numbers.iter_mut().zip(self.elements(nodes)) {
                    *number = element.number(allowed)?;
                }
                Ok(numbers)
            }
            Value::Array(nodes) => {
                self.error(format!("has {} numbers; it must be {what}", nodes.len()))
            }
            _ => self.must_be(what),
        }
    }

    /// A point.
    pub(super) fn point(&self) -> Result<DVec3> {
        self.numbers("[x, y, z]", &COORDINATE)
            .map(DVec3::from_array)
    }

    /// A direction as a unit vector; one that is of unit length, but for rounding, stays as it is.
    pub(super) fn direction(&self) -> Result<DVec3> {
        let point = self.point()?;
        if (point.length_squared() - 1.0).abs() < 4.0 * f64::EPSILON {
            return Ok(point);
        }
        match point.try_normalize() {
            Some(direction) => Ok(direction),
            None => self.error("is [0, 0, 0]; it must point somewhere"),
        }
    }

    /// A list of at least one value.
    pub(super) fn list(&self, what: &str) -> Result<Vec<Self>> {
        match &self.node.value {
            Value::Array(nodes) if !nodes.is_empty() => Ok(self.elements(nodes)),
            _ => self.must_be(what),
        }
    }

    fn elements(&self, nodes: &'a [Node]) -> Vec<Self> {
        nodes
            .iter()
            .enumerate()
            .map(|(i, node)| Field {
                node,
                name: format!("{}.{i}", self.name),
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentence_and_documentation_tell_the_one_limit_of_spots() {
        let limit = format!("0 to {MAX_OUTER_DEGREES}");
        assert!(HALF_ANGLE.says.contains(&limit), "{}", HALF_ANGLE.says);
        let documentation = include_str!("../../docs/SCENE_FILES.md");
        assert!(
            documentation.contains(&format!("half angles, {limit}:")),
            "docs/SCENE_FILES.md does not say {limit}"
        );
    }
}
