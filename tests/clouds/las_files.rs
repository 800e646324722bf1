//! LAS and LAZ of every version and point format.

use std::io::Cursor;

use catoptric::cloud::ReadOptions;
use glam::DVec3;
use las::point::Format;
use las::{Builder, Color, Point, Transform, Vector, Writer};
use libtest_mimic::{Failed, Trial};

use super::{demand, read_bytes};

pub(super) fn tests() -> Vec<Trial> {
    vec![
        Trial::test(
            "las_and_laz_of_all_point_formats_are_read_alike",
            all_point_formats,
        ),
        Trial::test("withheld_points_are_dropped_and_counted", withheld_points),
        Trial::test("columns_of_extra_bytes_are_found_by_name", extra_bytes),
    ]
}

/// A file of `points`, in the version that its format needs first.
pub(super) fn las_bytes(format: u8, compressed: bool, points: &[Point]) -> Result<Vec<u8>, Failed> {
    let mut builder = Builder::from(if format >= 6 { (1, 4) } else { (1, 3) });
    builder.point_format = Format::new(format)?;
    builder.point_format.is_compressed = compressed;
    let transform = |offset| Transform {
        scale: 0.001,
        offset,
    };
    builder.transforms = Vector {
        x: transform(636_000.0),
        y: transform(-1e6),
        z: transform(0.0),
    };
    write(builder, points)
}

fn write(builder: Builder, points: &[Point]) -> Result<Vec<u8>, Failed> {
    let mut writer = Writer::new(Cursor::new(Vec::new()), builder.into_header()?)?;
    for point in points {
        writer.write_point(point.clone())?;
    }
    writer.close()?;
    Ok(writer.into_inner()?.into_inner())
}

/// Points of a format; some more than one chunk of a LAZ file would be slow, 3000 are a part of one.
pub(super) fn points(format: u8, count: u16) -> Result<Vec<Point>, Failed> {
    let format = Format::new(format)?;
    let point = |i: u16| Point {
        x: 636_000.0 + f64::from(i % 55),
        y: -1e6 + f64::from(i / 55) + f64::from(i) * 0.001,
        z: f64::from(i % 7) * 0.5,
        intensity: i,
        classification: las::point::Classification::new((i % 10) as u8).unwrap_or_default(),
        gps_time: format.has_gps_time.then(|| f64::from(i)),
        color: format.has_color.then(|| Color::new(i, 2 * i, 300)),
        nir: format.has_nir.then_some(7),
        waveform: format.has_waveform.then(Default::default),
        ..Point::default()
    };
    Ok((0..count).map(point).collect())
}

fn all_point_formats() -> Result<(), Failed> {
    let options = ReadOptions {
        columns: vec!["classification".to_owned()],
        ..ReadOptions::default()
    };
    for format in 0..=10 {
        let points = points(format, 3000)?;
        let plain = read_bytes(&las_bytes(format, false, &points)?, &options)?;
        let packed = read_bytes(&las_bytes(format, true, &points)?, &options)?;
        demand(packed.format.ends_with("LAZ"), packed.format.clone())?;
        demand(
            plain.positions == packed.positions,
            format!("format {format}: positions differ"),
        )?;
        demand(
            plain.albedo == packed.albedo,
            format!("format {format}: colours differ"),
        )?;
        demand(
            plain.intensity == packed.intensity,
            format!("format {format}: intensities differ"),
        )?;

        demand(
            plain.len() == points.len(),
            format!("format {format}: {} points", plain.len()),
        )?;
        for (index, (got, point)) in plain.positions.iter().zip(&points).enumerate() {
            let expected = DVec3::new(point.x, point.y, point.z);
            let off = (*got - expected).abs().max_element();
            demand(
                off < 1e-9 + 1e-3 / 2.0,
                format!("format {format}, point {index}: {got}, expected {expected}"),
            )?;
        }
        let classes = &plain.columns["classification"];
        let class_of = |i: usize| (i % 10) as f32;
        demand(
            classes.iter().enumerate().all(|(i, &c)| c == class_of(i)),
            format!("format {format}: classes"),
        )?;
        demand(
            plain.albedo.is_some() == points[0].color.is_some(),
            format!("format {format}: colours"),
        )?;
    }
    Ok(())
}

fn withheld_points() -> Result<(), Failed> {
    for format in [1, 7] {
        let mut points = points(format, 10)?;
        points[3].is_withheld = true;
        points[9].is_withheld = true;
        let cloud = read_bytes(&las_bytes(format, false, &points)?, &ReadOptions::default())?;
        demand(
            cloud.len() == 8,
            format!("format {format}: {} points", cloud.len()),
        )?;
        demand(
            cloud.repairs.withheld == 2,
            format!("format {format}: {:?}", cloud.repairs),
        )?;
        let intensity = cloud.intensity.unwrap_or_default();
        demand(
            intensity == [0.0, 1.0, 2.0, 4.0, 5.0, 6.0, 7.0, 8.0],
            format!("{intensity:?}"),
        )?;
    }
    Ok(())
}

fn extra_bytes() -> Result<(), Failed> {
    let mut builder = Builder::from((1, 4));
    builder.point_format = Format::new(6)?;
    builder.point_format.extra_bytes = 3;
    let mut data = vec![0; 2 * 192];
    for (column, (code, name)) in [(1_u8, "glass"), (4, "height above")]
        .into_iter()
        .enumerate()
    {
        data[192 * column + 2] = code;
        data[192 * column + 4..][..name.len()].copy_from_slice(name.as_bytes());
    }
    data[192 + 3] = 1 << 3;
    data[192 + 112..][..8].copy_from_slice(&0.5_f64.to_le_bytes());
    builder.vlrs.push(las::Vlr {
        user_id: "LASF_Spec".into(),
        record_id: 4,
        data,
        ..las::Vlr::default()
    });
    let mut points = points(6, 4)?;
    for (index, point) in points.iter_mut().enumerate() {
        point.extra_bytes = vec![index as u8, 254 - index as u8, 255];
    }
    let columns = ["glass", "height above"].map(str::to_owned).to_vec();
    let options = ReadOptions {
        columns,
        ..ReadOptions::default()
    };
    let cloud = read_bytes(&write(builder, &points)?, &options)?;
    demand(
        cloud.columns["glass"] == [0.0, 1.0, 2.0, 3.0],
        format!("{:?}", cloud.columns),
    )?;
    demand(
        cloud.columns["height above"] == [-1.0, -1.5, -2.0, -2.5],
        format!("{:?}", cloud.columns),
    )?;
    demand(
        cloud.column_names.contains(&"height above".to_owned()),
        format!("{:?}", cloud.column_names),
    )
}
