//! Reading `[settings]`: each setting is checked by itself, so that a refusal names its line.

use serde::Deserialize;

use super::keys;
use super::tree::{Node, Origin, Value};
use crate::error::{Error, Result};
use crate::settings::{Description, Settings};

/// The settings that the table `node` holds; all others have their defaults.
pub(super) fn read(node: Option<&Node>) -> Result<Settings> {
    let Some(node) = node else {
        return Ok(Settings::default());
    };
    let described = Settings::describe();
    let mut all = toml::Table::new();
    read_group(node, "", &described, &mut all)?;
    let settings = Settings::deserialize(toml::Value::Table(all))
        .map_err(|e| node.origin.error(first_line(&e)))?;
    settings
        .check()
        .map(|()| settings)
        .map_err(|e| relocated(e, &node.origin))
}

fn read_group(
    node: &Node,
    group: &str,
    described: &[Description],
    all: &mut toml::Table,
) -> Result<()> {
    let Value::Table(entries) = &node.value else {
        let name = if group.is_empty() { "settings" } else { group };
        return Err(node
            .origin
            .error(format!("{name} must be a table, not {}", node.value.kind())));
    };
    for entry in entries {
        let key = if group.is_empty() {
            entry.key.clone()
        } else {
            format!("{group}.{}", entry.key)
        };
        if described.iter().any(|d| {
            d.key
                .strip_prefix(&key)
                .is_some_and(|rest| rest.starts_with('.'))
        }) {
            let mut table = toml::Table::new();
            read_group(&entry.node, &key, described, &mut table)?;
            all.insert(entry.key.clone(), toml::Value::Table(table));
        } else if let Some(description) = described.iter().find(|d| d.key == key) {
            all.insert(entry.key.clone(), checked(&entry.node, description)?);
        } else {
            let remedy = keys::nearest(&key, described.iter().map(|d| d.key.as_str())).map_or_else(
                || "catoptric info --settings lists them".to_owned(),
                keys::did_you_mean,
            );
            return Err(entry
                .origin
                .error(format!("there is no setting {key:?}; {remedy}")));
        }
    }
    Ok(())
}

/// The value of one setting, once it alone makes settings that hold.
fn checked(node: &Node, description: &Description) -> Result<toml::Value> {
    let value = node.value.to_toml();
    let alone = description
        .key
        .rsplit('.')
        .fold(value.clone(), |inner, key| {
            toml::Value::Table(toml::Table::from_iter([(key.to_owned(), inner)]))
        });
    match Settings::deserialize(alone) {
        Ok(settings) => settings
            .check()
            .map(|()| value)
            .map_err(|e| relocated(e, &node.origin)),
        Err(e) => Err(node
            .origin
            .error(wrong_value(&value, description, &first_line(&e)))),
    }
}

fn wrong_value(value: &toml::Value, description: &Description, cause: &str) -> String {
    let Description {
        key,
        choices,
        range,
        default,
        ..
    } = description;
    if !choices.is_empty() {
        let must = format!(
            "{key} is {value}; it must be one of {}",
            keys::alternatives(choices)
        );
        let meant = value
            .as_str()
            .and_then(|given| keys::nearest(given, choices.iter().copied()));
        return match meant {
            Some(meant) => format!("{must}; {}", keys::did_you_mean(meant)),
            None => must,
        };
    }
    match (range, default) {
        (Some((low, high)), toml::Value::Integer(_)) => {
            format!("{key} is {value}; it must be a whole number from {low} to {high}")
        }
        (Some((low, high)), _) => {
            format!("{key} is {value}; it must be a number from {low} to {high}")
        }
        (None, _) => format!("{key}: {cause}"),
    }
}

/// The refusal of a setting, with the place where it was written.
fn relocated(error: Error, origin: &Origin) -> Error {
    match error {
        Error::Setting(problem) => origin.error(problem),
        other => other,
    }
}

fn first_line(error: &toml::de::Error) -> String {
    error
        .message()
        .lines()
        .next()
        .unwrap_or("is wrong")
        .to_owned()
}
