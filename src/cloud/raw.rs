//! What a file or a generator gives, before the scene places it.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Which axis of a cloud points up; it chooses the default camera's up and never rotates data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// As graphics programs have it.
    Y,
    /// As scanners have it.
    Z,
}

impl UpAxis {
    /// The axis as a unit vector.
    pub fn vector(self) -> DVec3 {
        match self {
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }
}

/// What was dropped or repaired on the way from the file to the surfels. Nothing is lost silently.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Repairs {
    /// Points without finite coordinates, or farther from 0 than 1e15, dropped.
    pub not_finite: u64,
    /// Points that the file itself marks as withdrawn (LAS: withheld), dropped.
    pub withheld: u64,
    /// Zero or non-finite normals, estimated anew.
    pub normals: u64,
    /// Zero, negative or non-finite radii, estimated anew.
    pub radii: u64,
    /// Colour or material values that were not finite or out of range, clamped.
    pub values: u64,
}

impl Repairs {
    /// What was done, a sentence each; none where nothing was.
    pub fn sentences(&self) -> Vec<String> {
        let Self {
            not_finite,
            withheld,
            normals,
            radii,
            values,
        } = *self;
        let done = |count: u64, one: &str, many: &str, what: &str| {
            let (noun, verb) = if count == 1 {
                (one, "was")
            } else {
                (many, "were")
            };
            (count > 0).then(|| format!("{count} {noun} {verb} {what}"))
        };
        [
            done(
                not_finite,
                "point without finite coordinates up to 1e15",
                "points without finite coordinates up to 1e15",
                "dropped",
            ),
            done(
                withheld,
                "point that its file withholds",
                "points that their file withholds",
                "dropped",
            ),
            done(normals, "normal", "normals", "estimated anew"),
            done(radii, "radius", "radii", "estimated anew"),
            done(
                values,
                "value out of range",
                "values out of range",
                "clamped",
            ),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

impl std::ops::AddAssign for Repairs {
    fn add_assign(&mut self, other: Self) {
        self.not_finite += other.not_finite;
        self.withheld += other.withheld;
        self.normals += other.normals;
        self.radii += other.radii;
        self.values += other.values;
    }
}

/// A cloud as its file has it: every column that is there, as long as `positions`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawCloud {
    /// In the file's coordinates. May hold non-finite points; [`super::prepare`] drops and counts them.
    pub positions: Vec<DVec3>,
    /// Not necessarily unit length.
    pub normals: Option<Vec<Vec3>>,
    /// Linear RGB, 0 to 1.
    pub albedo: Option<Vec<Vec3>>,
    /// As the file has it; it colours a cloud without RGB.
    pub intensity: Option<Vec<f32>>,
    /// Mirror reflectance, 0 to 1.
    pub mirror: Option<Vec<f32>>,
    /// Specular reflectance, 0 to 1.
    pub specular: Option<Vec<f32>>,
    /// Phong exponent.
    pub shininess: Option<Vec<f32>>,
    /// Radius (local spacing), in the unit of `positions`.
    pub radii: Option<Vec<f32>>,
    /// The file's own columns that rules asked for, by name (`classification`, `intensity`, any PLY property).
    pub columns: BTreeMap<String, Vec<f32>>,
    /// Names of every column the file has, kept or not, for `info`.
    pub column_names: Vec<String>,
    /// Quantum of the file's coordinates (LAS: scale), where it has one.
    pub scale: Option<DVec3>,
    /// The up axis that the file states.
    pub up_axis: Option<UpAxis>,
    /// Format for people: "LAS 1.2, point format 3, LAZ".
    pub format: String,
    /// Unit of length that the file states ("US survey foot"), where it does.
    pub unit: Option<String>,
    /// Points dropped or repaired while reading.
    pub repairs: Repairs,
}

impl RawCloud {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }
}
