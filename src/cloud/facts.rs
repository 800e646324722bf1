//! What is known of a scene's points before anything is drawn; plans and `info` are made of it.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Serialize;

use super::{Repairs, UpAxis};

/// What is known of all points of a scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Facts {
    /// Number of points that are drawn.
    pub points: u64,
    /// Their box, in the scene's frame.
    pub bounds: Bounds,
    /// Median of the local spacing, in the files' unit.
    pub spacing: f64,
    /// What positions of surfels are relative to, in the scene's frame.
    pub origin: DVec3,
    /// Points dropped or repaired, in reading and since.
    pub repairs: Repairs,
    /// Number of points that are mirrors.
    pub mirror_points: u64,
    /// Whether any point has a specular part.
    pub has_specular: bool,
    /// One by one, in the scene's order.
    pub clouds: Vec<CloudFacts>,
}

/// What is known of one cloud.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CloudFacts {
    /// As the scene calls it.
    pub name: String,
    /// Format for people.
    pub format: String,
    /// Number of its points that are drawn.
    pub points: u64,
    /// Whether it came with colours.
    pub has_colour: bool,
    /// Whether it came with normals.
    pub has_normals: bool,
    /// Whether it came with intensities.
    pub has_intensity: bool,
    /// How many of its points are of which class, where classes were read: for a rule, a colouring or an editor.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub classes: BTreeMap<u8, u64>,
    /// Names of every column of its file.
    pub column_names: Vec<String>,
    /// Unit of length that the file states.
    pub unit: Option<String>,
    /// The up axis that the file states.
    pub up_axis: Option<UpAxis>,
}

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bounds {
    /// Smallest corner.
    pub min: DVec3,
    /// Largest corner.
    pub max: DVec3,
}

impl Bounds {
    /// The box of `points`; `min` is above `max` where there are none.
    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        let none = Self {
            min: DVec3::INFINITY,
            max: DVec3::NEG_INFINITY,
        };
        points.into_iter().fold(none, |b, p| Self {
            min: b.min.min(p),
            max: b.max.max(p),
        })
    }

    /// The smallest box that holds both.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// What is in both.
    pub fn intersection(self, other: Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        }
    }

    /// Whether nothing is in it, not even a point.
    pub fn is_empty(self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// Whether a point is in it, borders included.
    pub fn contains(self, point: DVec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// Whether all of another box is in it; an empty one is.
    pub fn contains_box(self, other: Self) -> bool {
        other.is_empty() || (self.contains(other.min) && self.contains(other.max))
    }

    /// Its centre.
    pub fn centre(self) -> DVec3 {
        self.min.midpoint(self.max)
    }

    /// Its edges' lengths.
    pub fn size(self) -> DVec3 {
        self.max - self.min
    }
}
