//! The columns of LAS points, as chunks of records come in.

use glam::{DVec3, Vec3};
use las::{Header, PointData};

use super::extra::{ExtraColumn, extra_columns};
use crate::cloud::colour::{Linearizer, channel_max};
use crate::cloud::rules::find_column;
use crate::cloud::{ColourBits, RawCloud, ReadOptions};

/// The standard columns that a rule can ask for.
const STANDARD: [&str; 9] = [
    "intensity",
    "return_number",
    "number_of_returns",
    "classification",
    "scan_angle",
    "user_data",
    "point_source_id",
    "gps_time",
    "nir",
];

/// The columns that are kept, as they grow.
pub(super) struct Columns {
    positions: Vec<DVec3>,
    intensity: Vec<u16>,
    colours: Option<Vec<[u16; 3]>>,
    asked: Vec<Asked>,
    names: Vec<String>,
    withheld: u64,
    /// Whether bit 7 of the classification byte withdraws a point: LAS 1.0 knows no such mark.
    knows_withheld: bool,
}

struct Asked {
    name: String,
    column: AskedColumn,
    values: Vec<f32>,
}

enum AskedColumn {
    Standard(&'static str),
    Extra(ExtraColumn),
}

impl Columns {
    /// Empty columns for the points of a file.
    pub(super) fn new(header: &Header, options: &ReadOptions) -> Self {
        let format = header.point_format();
        let extras = extra_columns(header);
        let standard = STANDARD.iter().copied().filter(|name| match *name {
            "gps_time" => format.has_gps_time,
            "nir" => format.has_nir,
            _ => true,
        });
        let mut names: Vec<String> = ["x", "y", "z"]
            .into_iter()
            .chain(standard)
            .map(str::to_owned)
            .collect();
        if format.has_color {
            names.extend(["red", "green", "blue"].map(str::to_owned));
        }
        names.extend(extras.iter().map(|extra| extra.name.clone()));

        let mut asked = Vec::new();
        for name in &options.columns {
            let Some(found) = find_column(&names, name) else {
                continue;
            };
            let column = match STANDARD.iter().find(|&&standard| standard == found) {
                Some(standard) => AskedColumn::Standard(standard),
                None => match extras.iter().find(|extra| extra.name == found) {
                    Some(extra) => AskedColumn::Extra(extra.clone()),
                    None => continue,
                },
            };
            asked.push(Asked {
                name: name.clone(),
                column,
                values: Vec::new(),
            });
        }
        Self {
            positions: Vec::new(),
            intensity: Vec::new(),
            colours: format.has_color.then(Vec::new),
            asked,
            names,
            withheld: 0,
            knows_withheld: header.version().minor >= 1,
        }
    }

    /// Memory that a point takes while it is read. Integers are held beside what they become for a moment.
    pub(super) fn bytes_per_point(&self) -> u64 {
        let colour = if self.colours.is_some() {
            size_of::<[u16; 3]>() + size_of::<Vec3>()
        } else {
            0
        };
        let asked = self.asked.len() * size_of::<f32>();
        (size_of::<DVec3>() + size_of::<u16>() + size_of::<f32>() + colour + asked) as u64
    }

    /// Adds the points of a chunk, but for those that the file has withdrawn.
    pub(super) fn push(&mut self, points: &PointData) {
        let extended = points.format().is_extended;
        let records = points.raw_bytes().chunks_exact(points.record_len().max(1));
        let kept: Vec<bool> = records
            .map(|record| match extended {
                true => record.get(15).is_none_or(|flags| flags & 0b100 == 0),
                false => {
                    !self.knows_withheld || record.get(15).is_none_or(|flags| flags & 0x80 == 0)
                }
            })
            .collect();
        self.withheld += kept.iter().filter(|&&kept| !kept).count() as u64;

        let places = points
            .x()
            .zip(points.y())
            .zip(points.z())
            .map(|((x, y), z)| DVec3::new(x, y, z));
        self.positions.extend(only(&kept, places));
        self.intensity.extend(only(&kept, points.intensity()));
        if let (Some(colours), Some(rgb)) = (&mut self.colours, points.rgb()) {
            colours.extend(only(&kept, rgb.map(|(r, g, b)| [r, g, b])));
        }
        for asked in &mut self.asked {
            asked.push(points, &kept);
        }
    }

    /// The cloud of these columns. Colours and intensities that are 0 throughout were never measured.
    pub(super) fn into_cloud(self, bits: ColourBits) -> RawCloud {
        let measured = |colours: &Vec<[u16; 3]>| colours.iter().flatten().any(|&value| value > 0);
        let mut cloud = RawCloud {
            positions: self.positions,
            column_names: self.names,
            ..RawCloud::default()
        };
        if let Some(colours) = self.colours.filter(measured) {
            let values = colours.iter().flatten().map(|&value| f32::from(value));
            let linearizer = Linearizer::new(channel_max(bits, false, values));
            let mut albedo = Vec::with_capacity(colours.len());
            for srgb in colours {
                let (linear, clamped) = linearizer.albedo(Vec3::from(srgb.map(f32::from)));
                cloud.repairs.values += u64::from(clamped);
                albedo.push(linear);
            }
            cloud.albedo = Some(albedo);
        }
        if self.intensity.iter().any(|&value| value > 0) {
            cloud.intensity = Some(self.intensity.into_iter().map(f32::from).collect());
        }
        cloud.columns = self
            .asked
            .into_iter()
            .map(|asked| (asked.name, asked.values))
            .collect();
        cloud.repairs.withheld = self.withheld;
        cloud
    }
}

impl Asked {
    fn push(&mut self, points: &PointData, kept: &[bool]) {
        let values = &mut self.values;
        match &self.column {
            AskedColumn::Standard("return_number") => {
                values.extend(only(kept, points.return_number().map(f32::from)));
            }
            AskedColumn::Standard("number_of_returns") => {
                values.extend(only(kept, points.number_of_returns().map(f32::from)));
            }
            AskedColumn::Standard("classification") => {
                values.extend(only(kept, points.classification().map(f32::from)));
            }
            AskedColumn::Standard("scan_angle") => {
                values.extend(only(kept, points.scan_angle_degrees()));
            }
            AskedColumn::Standard("user_data") => {
                values.extend(only(kept, points.user_data().map(f32::from)));
            }
            AskedColumn::Standard("point_source_id") => {
                values.extend(only(kept, points.point_source_id().map(f32::from)));
            }
            AskedColumn::Standard("gps_time") => {
                values.extend(
                    points
                        .gps_time()
                        .into_iter()
                        .flat_map(|times| only(kept, times.map(|t| t as f32))),
                );
            }
            AskedColumn::Standard("nir") => {
                values.extend(
                    points
                        .nir()
                        .into_iter()
                        .flat_map(|nir| only(kept, nir.map(f32::from))),
                );
            }
            AskedColumn::Standard(_) => {
                values.extend(only(kept, points.intensity().map(f32::from)));
            }
            AskedColumn::Extra(extra) => {
                let records = points.raw_bytes().chunks_exact(points.record_len().max(1));
                values.extend(only(kept, records.map(|record| extra.value(record))));
            }
        }
    }
}

fn only<T>(kept: &[bool], values: impl Iterator<Item = T>) -> impl Iterator<Item = T> {
    values
        .zip(kept)
        .filter_map(|(value, &kept)| kept.then_some(value))
}
