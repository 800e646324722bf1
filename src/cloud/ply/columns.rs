//! Which properties of the points are kept, and the cloud they become.

use glam::{DVec3, Vec3};
use ply_rs::ply::{PropertyType, ScalarType};

use super::body::{MAX_SLOTS, Row};
use super::header::Element;
use crate::cloud::colour::{Linearizer, channel_max};
use crate::cloud::read::Source;
use crate::cloud::rules::find_column;
use crate::cloud::{ColourBits, RawCloud, ReadOptions};
use crate::error::Result;

/// Coordinates take the first slots.
const COORDINATES: [&str; 3] = ["x", "y", "z"];

const NORMAL: [&str; 3] = ["nx", "ny", "nz"];

const MATERIAL: [&str; 5] = ["mirror", "specular", "shininess", "radius", "intensity"];

/// Names under which colours go; the first that is whole counts.
const COLOURS: [[&str; 3]; 3] = [
    ["red", "green", "blue"],
    ["r", "g", "b"],
    ["diffuse_red", "diffuse_green", "diffuse_blue"],
];

/// The kind of number in a slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Number {
    EightBits,
    Integer,
    Float,
}

/// Which property goes to which slot.
pub(super) struct Layout {
    /// The points; kept properties are renamed to their slot (one letter), the others to longer names.
    pub(super) element: Element,
    /// Property index and kind of number, by slot.
    slots: Vec<(usize, Number)>,
    /// Columns that every cloud may have, with their slots.
    known: Vec<(&'static str, usize)>,
    /// Columns that rules ask for, with their slots.
    extra: Vec<(String, usize)>,
}

impl Layout {
    /// Chooses what to keep of `points`.
    pub(super) fn new(
        source: &Source<'_>,
        points: &Element,
        options: &ReadOptions,
    ) -> Result<Self> {
        let numbers: Vec<Option<Number>> = points
            .def
            .properties
            .values()
            .map(|p| number(&p.data_type))
            .collect();
        let find = |name: &str| {
            let index = points
                .names
                .iter()
                .position(|n| n.eq_ignore_ascii_case(name))?;
            Some((index, numbers.get(index).copied().flatten()?))
        };
        let mut slots: Vec<(usize, Number)> = Vec::new();
        let mut slot_of = |property: (usize, Number)| {
            slots
                .iter()
                .position(|&kept| kept == property)
                .unwrap_or_else(|| {
                    slots.push(property);
                    slots.len() - 1
                })
        };

        // Coordinates first, then every known column that is whole, then what rules ask for.
        for name in COORDINATES {
            let property = find(name).ok_or_else(|| {
                source.error(format!(
                    "its points have no number `{name}`, so no place in space"
                ))
            })?;
            slot_of(property);
        }
        let mut known = Vec::new();
        let colours = COLOURS
            .iter()
            .find(|names| names.iter().all(|name| find(name).is_some()));
        let groups = MATERIAL
            .iter()
            .map(std::slice::from_ref)
            .chain([NORMAL.as_slice()]);
        for group in groups.chain(colours.map(|names| names.as_slice())) {
            let found: Option<Vec<_>> = group
                .iter()
                .map(|&name| Some((name, find(name)?)))
                .collect();
            for (name, property) in found.into_iter().flatten() {
                known.push((name, slot_of(property)));
            }
        }
        let mut extra = Vec::new();
        for name in &options.columns {
            if let Some(property) = find_column(&points.names, name).and_then(&find) {
                extra.push((name.clone(), slot_of(property)));
            }
        }
        if slots.len() > MAX_SLOTS {
            return Err(source.error(format!(
                "rules ask for more than {MAX_SLOTS} of its properties; ask for fewer"
            )));
        }
        let element =
            points.renamed(
                |property| match slots.iter().position(|&(kept, _)| kept == property) {
                    Some(slot) => char::from(slot as u8).to_string(),
                    None => format!("-{property}"),
                },
            );
        Ok(Self {
            element,
            slots,
            known,
            extra,
        })
    }

    /// Memory that a point takes while it is read. Columns are held twice while they become colours and normals.
    pub(super) fn bytes_per_point(&self) -> u64 {
        (size_of::<DVec3>() + 2 * size_of::<f32>() * (self.slots.len() + self.extra.len())) as u64
    }
}

/// The columns of the kept properties, as they grow.
pub(super) struct Columns {
    positions: Vec<DVec3>,
    /// By slot; those of the coordinates stay empty.
    values: Vec<Vec<f32>>,
}

impl Columns {
    /// Empty columns for `count` points.
    pub(super) fn with_capacity(layout: &Layout, count: usize) -> Self {
        let length = |slot: usize| if slot < COORDINATES.len() { 0 } else { count };
        let values = (0..layout.slots.len())
            .map(|slot| Vec::with_capacity(length(slot)))
            .collect();
        Self {
            positions: Vec::with_capacity(count),
            values,
        }
    }

    /// Adds a point.
    pub(super) fn push(&mut self, row: &Row) {
        let &[x, y, z, ref others @ ..] = row;
        self.positions.push(DVec3::new(x, y, z));
        for (column, &value) in self.values.iter_mut().skip(COORDINATES.len()).zip(others) {
            column.push(value as f32);
        }
    }

    /// The cloud of these columns.
    pub(super) fn into_cloud(mut self, layout: &Layout, colour_bits: ColourBits) -> RawCloud {
        let mut cloud = RawCloud::default();
        for (name, slot) in &layout.extra {
            // A coordinate as a rule's column comes from the positions.
            let column = match slot {
                0 => self.positions.iter().map(|p| p.x as f32).collect(),
                1 => self.positions.iter().map(|p| p.y as f32).collect(),
                2 => self.positions.iter().map(|p| p.z as f32).collect(),
                _ => self.values.get(*slot).cloned().unwrap_or_default(),
            };
            cloud.columns.insert(name.clone(), column);
        }
        cloud.positions = std::mem::take(&mut self.positions);
        let slot_of = |wanted: &str| {
            layout
                .known
                .iter()
                .find(|(name, _)| *name == wanted)
                .map(|&(_, slot)| slot)
        };
        let number_of = |slot: usize| {
            layout
                .slots
                .get(slot)
                .map_or(Number::Float, |&(_, number)| number)
        };

        if let Some(columns) = self.take(NORMAL.map(slot_of)) {
            cloud.normals = Some(vectors(&columns).collect());
        }
        for names in COLOURS {
            let Some(columns) = self.take(names.map(slot_of)) else {
                continue;
            };
            let numbers = names.map(|name| slot_of(name).map_or(Number::Float, number_of));
            let (albedo, clamped) = albedo_of(&columns, numbers, colour_bits);
            cloud.albedo = Some(albedo);
            cloud.repairs.values += clamped;
        }
        let [mirror, specular, shininess, radius, intensity] =
            MATERIAL.map(|name| slot_of(name).map(|slot| (self.take_one(slot), number_of(slot))));
        cloud.mirror = mirror.map(|(column, number)| mirror_of(column, number));
        cloud.specular = specular.map(|(column, _)| column);
        cloud.shininess = shininess.map(|(column, _)| column);
        cloud.radii = radius.map(|(column, _)| column);
        cloud.intensity = intensity.map(|(column, _)| column);
        cloud
    }

    fn take_one(&mut self, slot: usize) -> Vec<f32> {
        self.values
            .get_mut(slot)
            .map(std::mem::take)
            .unwrap_or_default()
    }

    fn take(&mut self, slots: [Option<usize>; 3]) -> Option<[Vec<f32>; 3]> {
        let [Some(a), Some(b), Some(c)] = slots else {
            return None;
        };
        Some([a, b, c].map(|slot| self.take_one(slot)))
    }
}

fn number(data_type: &PropertyType) -> Option<Number> {
    match data_type {
        PropertyType::Scalar(ScalarType::Char | ScalarType::UChar) => Some(Number::EightBits),
        PropertyType::Scalar(
            ScalarType::Short | ScalarType::UShort | ScalarType::Int | ScalarType::UInt,
        ) => Some(Number::Integer),
        PropertyType::Scalar(ScalarType::Float | ScalarType::Double) => Some(Number::Float),
        PropertyType::List(..) => None,
    }
}

fn vectors([x, y, z]: &[Vec<f32>; 3]) -> impl Iterator<Item = Vec3> {
    x.iter()
        .zip(y)
        .zip(z)
        .map(|((&x, &y), &z)| Vec3::new(x, y, z))
}

/// Linear colours, and how many of them were out of range: integers are sRGB, floating point is linear.
fn albedo_of(columns: &[Vec<f32>; 3], numbers: [Number; 3], bits: ColourBits) -> (Vec<Vec3>, u64) {
    if numbers.contains(&Number::Float) {
        // What is out of range is left for `prepare`, which clamps and counts for every source of clouds.
        return (vectors(columns).collect(), 0);
    }
    let eight_bit_type = numbers == [Number::EightBits; 3];
    let linearizer = Linearizer::new(channel_max(
        bits,
        eight_bit_type,
        columns.iter().flatten().copied(),
    ));
    let mut clamped = 0;
    let albedo = vectors(columns).map(|srgb| {
        let (albedo, out_of_range) = linearizer.albedo(srgb);
        clamped += u64::from(out_of_range);
        albedo
    });
    (albedo.collect(), clamped)
}

/// A whole number is a mark: a mirror where it is not 0. Floating point is the reflectance itself.
fn mirror_of(mut column: Vec<f32>, number: Number) -> Vec<f32> {
    if number != Number::Float {
        for value in &mut column {
            *value = f32::from(*value != 0.0);
        }
    }
    column
}
