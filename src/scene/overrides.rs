//! Keys and values given on top of a scene file: `--set` and the flags of the command line.

use std::path::Path;

use super::keys;
use super::tree::{Entry, Node, Origin, Value};
use crate::error::{Error, Result};

/// A key and a value that take the place of what the scene file says. Later ones beat earlier ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    key: String,
    node: Node,
}

/// The key of the mesh of every cloud that is generated from one.
const MESH_OF_EVERY_CLOUD: &str = "cloud.*.mesh";

impl Override {
    /// Reads `key=value`, where the value is TOML, a bare word (a string), `1,2,3` (an array) or `800x600` (a size).
    ///
    /// `given` is how the caller's user wrote it, for messages: "--set splat.size=2".
    ///
    /// # Errors
    /// [`Error::Override`] where there is no `=` or no key.
    pub fn parse(key_and_value: &str, given: &str) -> Result<Self> {
        match key_and_value.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() => {
                Self::new(key.trim(), value.trim(), given)
            }
            _ => Err(Error::Override {
                given: given.into(),
                problem: "write key=value, as in splat.size=2".into(),
            }),
        }
    }

    /// The value `text`, in the notation of [`Override::parse`], for the dotted key `key`.
    ///
    /// # Errors
    /// [`Error::Override`] where the value is a number that nothing can hold.
    pub fn new(key: &str, text: &str, given: &str) -> Result<Self> {
        let origin = Origin::Given(given.into());
        Ok(Self {
            key: key.into(),
            node: value(key, text, &origin)?,
        })
    }

    /// The triangle mesh (PLY) for every cloud that is generated from one.
    pub fn mesh(path: &Path, given: &str) -> Self {
        let origin = Origin::Given(given.into());
        Self {
            key: MESH_OF_EVERY_CLOUD.into(),
            node: Node {
                value: Value::Path(path.into()),
                origin,
            },
        }
    }

    /// The dotted key, without the group of settings.
    pub(super) fn key(&self) -> &str {
        self.key.strip_prefix("settings.").unwrap_or(&self.key)
    }

    /// Whether `refusal` names what the caller wrote here.
    pub(super) fn is_blamed_by(&self, refusal: &Error) -> bool {
        matches!(
            (refusal, &self.node.origin),
            (Error::Override { given, .. }, Origin::Given(words)) if **given == **words
        )
    }

    /// Puts the value into the document.
    pub(super) fn apply(&self, document: &mut Node) -> Result<()> {
        if self.key == MESH_OF_EVERY_CLOUD {
            return self.apply_mesh(document);
        }
        let key = self.key();
        let (pattern, _) = keys::pattern_of(key);
        if !keys::patterns().contains(&pattern) {
            let remedy = keys::nearest_key(key).map_or_else(
                || {
                    "catoptric info --settings lists the settings, docs/SCENE_FILES.md the other keys"
                        .to_owned()
                },
                |nearest| keys::did_you_mean(&nearest),
            );
            return Err(self
                .node
                .origin
                .error(format!("there is no key {key:?}; {remedy}")));
        }
        let scene_key = [
            "camera.",
            "clip.",
            "cloud.",
            "environment.",
            "light.",
            "mirror.",
        ]
        .iter()
        .any(|table| key.starts_with(table));
        let segments = if scene_key { None } else { Some("settings") }
            .into_iter()
            .chain(key.split('.'));
        self.put(document, &segments.collect::<Vec<_>>(), "")
    }

    fn put(&self, node: &mut Node, segments: &[&str], so_far: &str) -> Result<()> {
        let Some((segment, rest)) = segments.split_first() else {
            *node = self.node.clone();
            return Ok(());
        };
        let here = if so_far.is_empty() {
            (*segment).to_owned()
        } else {
            format!("{so_far}.{segment}")
        };
        match &mut node.value {
            Value::Table(entries) => {
                let position = entries.iter().position(|e| e.key == *segment);
                if position.is_none() && rest.first().is_some_and(|next| index(next).is_some()) {
                    return Err(self
                        .node
                        .origin
                        .error(format!("the scene has no {here}; add one to its file")));
                }
                let entry = match position.and_then(|p| entries.get_mut(p)) {
                    Some(entry) => entry,
                    None => {
                        let origin = self.node.origin.clone();
                        let node = Node {
                            value: Value::Table(Vec::new()),
                            origin: origin.clone(),
                        };
                        entries.push_mut(Entry {
                            key: (*segment).to_owned(),
                            origin,
                            node,
                        })
                    }
                };
                if rest.is_empty() {
                    entry.origin = self.node.origin.clone();
                }
                self.put(&mut entry.node, rest, &here)
            }
            Value::Array(nodes) => {
                let count = nodes.len();
                match index(segment).and_then(|i| nodes.get_mut(i)) {
                    Some(node) => self.put(node, rest, &here),
                    None => Err(self.node.origin.error(match count {
                        0 => format!("the scene has no {so_far}"),
                        1 => format!("there is no {here}; the scene has {so_far}.0 only"),
                        _ => format!(
                            "there is no {here}; the scene has {so_far}.0 to {so_far}.{}",
                            count - 1
                        ),
                    })),
                }
            }
            // The file has something else where a table belongs, and reading it will say so.
            _ => Ok(()),
        }
    }

    fn apply_mesh(&self, document: &mut Node) -> Result<()> {
        let takes_mesh = |cloud: &Node| matches!(cloud.get("generate").map(|g| &g.value), Some(Value::String(name)) if name == "bunny" || name == "multi");
        let clouds = match document.get("cloud").map(|c| &c.value) {
            Some(Value::Array(clouds)) => clouds
                .iter()
                .enumerate()
                .filter(|(_, c)| takes_mesh(c))
                .map(|(i, _)| i)
                .collect(),
            _ => Vec::new(),
        };
        if clouds.is_empty() {
            let problem = "no cloud of the scene is generated from a mesh; that is for generate = \"bunny\" or \"multi\"";
            return Err(self.node.origin.error(problem));
        }
        for index in clouds {
            self.put(document, &["cloud", &index.to_string(), "mesh"], "")?;
        }
        Ok(())
    }
}

/// The index that a segment of a key writes: digits, without needless zeros.
fn index(segment: &str) -> Option<usize> {
    let index = segment.parse::<usize>().ok()?;
    (index.to_string() == segment).then_some(index)
}

fn value(key: &str, text: &str, origin: &Origin) -> Result<Node> {
    let array = |parts: &[&str]| -> Result<Node> {
        let nodes = parts
            .iter()
            .map(|p| word(p.trim(), origin))
            .collect::<Result<_>>()?;
        Ok(Node {
            value: Value::Array(nodes),
            origin: origin.clone(),
        })
    };
    // A size comes first: 0x600 would be a number in TOML.
    let digits = |s: &str| !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit());
    if key.ends_with("size")
        && let Some((width, height)) = text.split_once('x')
        && digits(width)
        && digits(height)
    {
        return array(&[width, height]);
    }
    match Node::parse_value(text, origin)? {
        Some(node) => Ok(node),
        None if text.contains(',') => array(&text.split(',').collect::<Vec<_>>()),
        None => word(text, origin),
    }
}

/// A TOML value, or else a bare word.
fn word(text: &str, origin: &Origin) -> Result<Node> {
    let string = || Node {
        value: Value::String(text.to_owned()),
        origin: origin.clone(),
    };
    Ok(Node::parse_value(text, origin)?.unwrap_or_else(string))
}
