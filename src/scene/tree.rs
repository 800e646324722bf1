//! A TOML document as a tree in which every key and value knows where it was written, so that a message can say it.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{Error, Result};

/// Where a key or value was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Origin {
    /// In the scene file, at this line (from 1; `None` for the file as a whole).
    File {
        path: Arc<Path>,
        line: Option<usize>,
    },
    /// By the caller, in these words: "--set splat.size=2".
    Given(Arc<str>),
}

impl Origin {
    /// What is wrong with the key or value written here.
    pub(super) fn error(&self, problem: impl Into<String>) -> Error {
        match self {
            Self::File { path, line } => Error::Scene {
                path: path.to_path_buf(),
                line: *line,
                problem: problem.into(),
            },
            Self::Given(given) => Error::Override {
                given: given.to_string(),
                problem: problem.into(),
            },
        }
    }

    /// By a caller, in these words.
    pub(super) fn given(words: &str) -> Self {
        Self::Given(words.into())
    }

    /// The folder that paths written here are relative to: that of the file, or (empty) the current one.
    pub(super) fn folder(&self) -> &Path {
        match self {
            Self::File { path, .. } => path.parent().unwrap_or(Path::new("")),
            Self::Given(_) => Path::new(""),
        }
    }
}

/// Where a table and each of its keys were written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Origins {
    table: Origin,
    keys: Vec<(String, Origin)>,
}

impl Origins {
    /// Those of a table without keys.
    pub(super) fn of_table(table: Origin) -> Self {
        Self {
            table,
            keys: Vec::new(),
        }
    }

    /// Those of `node`, a table.
    pub(super) fn of(node: &Node) -> Self {
        let keys = match &node.value {
            Value::Table(entries) => entries
                .iter()
                .map(|entry| (entry.key.clone(), entry.node.origin.clone()))
                .collect(),
            _ => Vec::new(),
        };
        Self {
            table: node.origin.clone(),
            keys,
        }
    }

    /// Where the culprit among `suspects` was written: the first that the caller gave, or else the first that is
    /// written anywhere, or else their table.
    pub(super) fn to_blame(&self, suspects: &[&str]) -> &Origin {
        let mut written = suspects
            .iter()
            .filter_map(|suspect| self.keys.iter().find(|(key, _)| key == suspect))
            .map(|(_, origin)| origin);
        let first = written.clone().next();
        written
            .find(|origin| matches!(origin, Origin::Given(_)))
            .or(first)
            .unwrap_or(&self.table)
    }
}

/// A value and where it was written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node {
    pub(super) value: Value,
    pub(super) origin: Origin,
}

/// A TOML value, or a path that need not be text.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    String(String),
    Path(PathBuf),
    Integer(i64),
    Float(f64),
    Boolean(bool),
    Datetime(String),
    Array(Vec<Node>),
    Table(Vec<Entry>),
}

/// A key of a table with its value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    pub(super) key: String,
    /// Where the key was written.
    pub(super) origin: Origin,
    pub(super) node: Node,
}

impl Node {
    /// The document `text` of the file `path`.
    pub(super) fn parse_document(text: &str, path: &Path) -> Result<Self> {
        let lines = Lines::new(text, path);
        match DeTable::parse(text) {
            Ok(table) => table_node(table.get_ref(), lines.at(None), &|start| {
                lines.at(Some(start))
            }),
            Err(e) => Err(lines
                .at(e.span().map(|s| s.start))
                .error(one_line(e.message()))),
        }
    }

    /// One TOML value that the caller gave, or `None` where `text` is none.
    pub(super) fn parse_value(text: &str, origin: &Origin) -> Result<Option<Self>> {
        match DeValue::parse(text) {
            Ok(value) => node(&value, &|_| origin.clone()).map(Some),
            Err(_) => Ok(None),
        }
    }

    /// The value of `key`, where this is a table that has it.
    pub(super) fn get(&self, key: &str) -> Option<&Self> {
        match &self.value {
            Value::Table(entries) => entries.iter().find(|e| e.key == key).map(|e| &e.node),
            _ => None,
        }
    }
}

impl Value {
    /// What a person would call it.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::String(_) | Self::Path(_) => "a string",
            Self::Integer(_) => "a whole number",
            Self::Float(_) => "a number",
            Self::Boolean(_) => "true or false",
            Self::Datetime(_) => "a date",
            Self::Array(_) => "an array",
            Self::Table(_) => "a table",
        }
    }

    /// The value as plain TOML.
    pub(super) fn to_toml(&self) -> toml::Value {
        match self {
            Self::String(s) | Self::Datetime(s) => toml::Value::String(s.clone()),
            Self::Path(p) => toml::Value::String(p.display().to_string()),
            Self::Integer(i) => toml::Value::Integer(*i),
            Self::Float(f) => toml::Value::Float(*f),
            Self::Boolean(b) => toml::Value::Boolean(*b),
            Self::Array(nodes) => {
                toml::Value::Array(nodes.iter().map(|n| n.value.to_toml()).collect())
            }
            Self::Table(entries) => toml::Value::Table(
                entries
                    .iter()
                    .map(|e| (e.key.clone(), e.node.value.to_toml()))
                    .collect(),
            ),
        }
    }
}

/// Line numbers of a text, from byte offsets.
struct Lines {
    path: Arc<Path>,
    starts: Vec<usize>,
}

impl Lines {
    fn new(text: &str, path: &Path) -> Self {
        let starts = std::iter::once(0)
            .chain(text.match_indices('\n').map(|(i, _)| i + 1))
            .collect();
        Self {
            path: path.into(),
            starts,
        }
    }

    fn at(&self, offset: Option<usize>) -> Origin {
        let line = offset.map(|o| self.starts.partition_point(|&start| start <= o));
        Origin::File {
            path: self.path.clone(),
            line,
        }
    }
}

fn node(value: &Spanned<DeValue<'_>>, at: &dyn Fn(usize) -> Origin) -> Result<Node> {
    let origin = at(value.span().start);
    let value = match value.get_ref() {
        DeValue::String(s) => Value::String(s.to_string()),
        DeValue::Integer(i) => match i64::from_str_radix(i.as_str(), i.radix()) {
            Ok(i) => Value::Integer(i),
            Err(_) => {
                return Err(origin.error(format!(
                    "{i} is too large a number; numbers have at most 63 bits"
                )));
            }
        },
        DeValue::Float(f) => match f.as_str().parse() {
            Ok(f) => Value::Float(f),
            Err(_) => return Err(origin.error(format!("{f} is no number"))),
        },
        DeValue::Boolean(b) => Value::Boolean(*b),
        DeValue::Datetime(d) => Value::Datetime(d.to_string()),
        DeValue::Array(values) => {
            Value::Array(values.iter().map(|v| node(v, at)).collect::<Result<_>>()?)
        }
        DeValue::Table(table) => return table_node(table, origin, at),
    };
    Ok(Node { value, origin })
}

fn table_node(table: &DeTable<'_>, origin: Origin, at: &dyn Fn(usize) -> Origin) -> Result<Node> {
    let mut entries = Vec::with_capacity(table.len());
    for (key, value) in table {
        entries.push(Entry {
            key: key.get_ref().to_string(),
            origin: at(key.span().start),
            node: node(value, at)?,
        });
    }
    // In the order of the file, so that the first mistake in it is the one reported.
    entries.sort_by(|a, b| match (&a.origin, &b.origin) {
        (Origin::File { line: a, .. }, Origin::File { line: b, .. }) => a.cmp(b),
        _ => Ordering::Equal,
    });
    Ok(Node {
        value: Value::Table(entries),
        origin,
    })
}

fn one_line(message: &str) -> String {
    message.lines().collect::<Vec<_>>().join(", ")
}
