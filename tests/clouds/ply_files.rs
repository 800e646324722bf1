//! PLY of every encoding and scalar type, and what we write ourselves.

use std::path::Path;

use catoptric::cloud::{RawCloud, ReadOptions, UpAxis, write_ply};
use catoptric::{Error, Job};
use glam::{DVec3, Vec3};
use libtest_mimic::{Failed, Trial};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use super::{demand, read_bytes};

pub(super) fn tests() -> Vec<Trial> {
    vec![
        Trial::test(
            "every_encoding_and_scalar_type_is_read",
            every_encoding_and_type,
        ),
        Trial::test("what_is_written_is_read_again", round_trip),
        Trial::test("colours_are_told_apart_by_type_and_range", colours),
        Trial::test(
            "lists_odd_names_and_other_elements_are_passed_over",
            lists_and_other_elements,
        ),
        Trial::test("ascii_numbers_may_be_nan_or_end_in_a_point", odd_numbers),
        Trial::test("a_cancelled_job_writes_no_more", cancelled),
    ]
}

/// How the records of a PLY file are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

pub(super) const ENCODINGS: [Encoding; 3] = [Encoding::Ascii, Encoding::Little, Encoding::Big];

/// Both names of every scalar type.
const TYPES: [&str; 16] = [
    "char", "uchar", "short", "ushort", "int", "uint", "float", "double", "int8", "uint8", "int16",
    "uint16", "int32", "uint32", "float32", "float64",
];

/// A PLY file, written by hand: properties as (type, name), a row of values each.
pub(super) fn ply(encoding: Encoding, properties: &[(&str, &str)], rows: &[Vec<f64>]) -> Vec<u8> {
    let format = match encoding {
        Encoding::Ascii => "ascii",
        Encoding::Little => "binary_little_endian",
        Encoding::Big => "binary_big_endian",
    };
    let mut bytes =
        format!("ply\nformat {format} 1.0\nelement vertex {}\n", rows.len()).into_bytes();
    for (scalar, name) in properties {
        bytes.extend(format!("property {scalar} {name}\n").bytes());
    }
    bytes.extend(b"end_header\n");
    for row in rows {
        for ((scalar, _), &value) in properties.iter().zip(row) {
            push(&mut bytes, encoding, scalar, value);
        }
        if encoding == Encoding::Ascii {
            bytes.push(b'\n');
        }
    }
    bytes
}

fn push(bytes: &mut Vec<u8>, encoding: Encoding, scalar: &str, value: f64) {
    let little = match scalar {
        "char" | "int8" => (value as i8).to_le_bytes().to_vec(),
        "uchar" | "uint8" => (value as u8).to_le_bytes().to_vec(),
        "short" | "int16" => (value as i16).to_le_bytes().to_vec(),
        "ushort" | "uint16" => (value as u16).to_le_bytes().to_vec(),
        "int" | "int32" => (value as i32).to_le_bytes().to_vec(),
        "uint" | "uint32" => (value as u32).to_le_bytes().to_vec(),
        "float" | "float32" => (value as f32).to_le_bytes().to_vec(),
        _ => value.to_le_bytes().to_vec(),
    };
    match encoding {
        Encoding::Ascii => bytes.extend(format!("{value} ").bytes()),
        Encoding::Little => bytes.extend(little),
        Encoding::Big => bytes.extend(little.into_iter().rev()),
    }
}

fn runner() -> TestRunner {
    let config = Config {
        cases: 64,
        failure_persistence: None,
        ..Config::default()
    };
    TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
}

fn every_encoding_and_type() -> Result<(), Failed> {
    // Values that every type holds; types of the coordinates and of a column that a rule asks for.
    let values = vec(vec((0..128_i32).prop_map(f64::from), 4), 0..20);
    let types = (0..TYPES.len(), 0..TYPES.len(), 0..TYPES.len());
    runner().run(
        &(values, types, 0..ENCODINGS.len()),
        |(rows, (xy, z, extra), encoding)| {
            let properties = [
                (TYPES[extra], "Label"),
                (TYPES[xy], "x"),
                (TYPES[xy], "y"),
                (TYPES[z], "z"),
            ];
            let bytes = ply(ENCODINGS[encoding], &properties, &rows);
            let options = ReadOptions {
                columns: vec!["label".to_owned(), "none".to_owned()],
                ..Default::default()
            };
            let cloud =
                read_bytes(&bytes, &options).map_err(|e| TestCaseError::fail(e.to_string()))?;
            let expected: Vec<DVec3> = rows
                .iter()
                .map(|row| DVec3::new(row[1], row[2], row[3]))
                .collect();
            prop_assert_eq!(cloud.positions, expected);
            let labels: Vec<f32> = rows.iter().map(|row| row[0] as f32).collect();
            prop_assert_eq!(&cloud.columns["label"], &labels);
            prop_assert_eq!(
                cloud.columns.len(),
                1,
                "a column that is not there is not made up"
            );
            Ok(())
        },
    )?;
    Ok(())
}

fn written(cloud: &RawCloud) -> catoptric::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write_ply(&mut bytes, Path::new("out.ply"), cloud, &Job::default())?;
    Ok(bytes)
}

fn round_trip() -> Result<(), Failed> {
    let point = (vec(-1e6..1e6_f64, 3), vec(0.0..1.0_f32, 11));
    let present = vec(any::<bool>(), 7);
    let up = prop_oneof![Just(None), Just(Some(UpAxis::Y)), Just(Some(UpAxis::Z))];
    runner().run(
        &(vec(point, 1..50), present, up),
        |(points, present, up_axis)| {
            let vectors = |on: bool, at: usize| {
                on.then(|| {
                    points
                        .iter()
                        .map(|(_, v)| Vec3::from_slice(&v[at..]))
                        .collect()
                })
            };
            let scalars = |on: bool, at: usize| {
                on.then(|| points.iter().map(|(_, v)| v[at]).collect::<Vec<f32>>())
            };
            let cloud = RawCloud {
                positions: points.iter().map(|(p, _)| DVec3::from_slice(p)).collect(),
                normals: vectors(present[0], 0),
                albedo: vectors(present[1], 3),
                mirror: scalars(present[2], 6),
                specular: scalars(present[3], 7),
                shininess: scalars(present[4], 8),
                radii: scalars(present[5], 9),
                intensity: scalars(present[6], 10),
                columns: scalars(true, 2)
                    .into_iter()
                    .map(|column| ("height above".to_owned(), column))
                    .collect(),
                up_axis,
                ..RawCloud::default()
            };
            let options = ReadOptions {
                columns: vec!["height_above".to_owned()],
                ..ReadOptions::default()
            };
            let read = written(&cloud)
                .and_then(|bytes| read_bytes(&bytes, &options))
                .map_err(|e| TestCaseError::fail(e.to_string()))?;
            prop_assert_eq!(
                &read.columns["height_above"],
                &cloud.columns["height above"]
            );
            let expected = RawCloud {
                columns: read.columns.clone(),
                column_names: read.column_names.clone(),
                format: "PLY, binary little endian".to_owned(),
                positions: read.positions.clone(),
                ..cloud.clone()
            };
            prop_assert_eq!(&read, &expected);
            let size = cloud
                .positions
                .iter()
                .copied()
                .reduce(DVec3::max)
                .unwrap_or_default()
                - cloud
                    .positions
                    .iter()
                    .copied()
                    .reduce(DVec3::min)
                    .unwrap_or_default();
            for (got, expected) in read.positions.iter().zip(&cloud.positions) {
                let off = (*got - *expected).abs().max_element();
                prop_assert!(
                    off <= 1e-7 * size.max_element(),
                    "{} became {}",
                    expected,
                    got
                );
            }
            Ok(())
        },
    )?;
    Ok(())
}

fn colours() -> Result<(), Failed> {
    let half = ((128.0_f32 / 255.0 + 0.055) / 1.055).powf(2.4);
    let cases: [(&str, [f64; 3], Vec3); 6] = [
        ("uchar", [0.0, 128.0, 255.0], Vec3::new(0.0, half, 1.0)),
        ("ushort", [0.0, 128.0, 255.0], Vec3::new(0.0, half, 1.0)),
        (
            "ushort",
            [0.0, 32_896.0, 65_535.0],
            Vec3::new(0.0, half, 1.0),
        ),
        ("uint", [0.0, 32_896.0, 65_535.0], Vec3::new(0.0, half, 1.0)),
        ("float", [0.0, 0.5, 1.0], Vec3::new(0.0, 0.5, 1.0)),
        ("double", [0.0, 0.25, 1.0], Vec3::new(0.0, 0.25, 1.0)),
    ];
    for names in [
        ["red", "green", "blue"],
        ["r", "g", "b"],
        ["diffuse_red", "diffuse_green", "diffuse_blue"],
    ] {
        for (scalar, values, expected) in cases {
            let [r, g, b] = names.map(|name| (scalar, name));
            let properties = [("float", "x"), ("float", "y"), ("float", "z"), r, g, b];
            let row = [vec![0.0; 3], values.to_vec()].concat();
            let cloud = read_bytes(
                &ply(Encoding::Big, &properties, &[row]),
                &ReadOptions::default(),
            )?;
            let got = cloud.albedo.as_ref().map_or(Vec3::NAN, |albedo| albedo[0]);
            let off = (got - expected).abs().max_element();
            demand(
                off < 1e-5,
                format!("{scalar} {values:?}: {got}, expected {expected}"),
            )?;
        }
    }
    Ok(())
}

fn lists_and_other_elements() -> Result<(), Failed> {
    let ascii = "ply\r\nformat ascii 1.0\r\ncomment Gr\u{e4}\u{df}e, Z up\r\nelement camera 2\r\n\
        property list uchar float matrix\r\nproperty int id\r\nelement vertex 2\r\nproperty list uchar int seen by\r\n\
        property float x\r\nproperty float y\r\nproperty float z\r\nproperty uchar mirror\r\n\
        property float scalar_Illuminance_(PCV)\r\nelement face 1\r\nproperty list uchar int vertex_indices\r\n\
        end_header\r\n3 1 2 3 7\r\n0 8\r\n\r\n2 5 6 1 2 3 0 0.5\r\n0 4 5 6 9 0.25\r\n3 0 1 1\r\n";
    let mut latin = ascii.as_bytes().to_vec();
    if let Some(at) = latin.windows(2).position(|pair| pair == [0xc3, 0xa4]) {
        latin.splice(at..at + 2, [0xe4]);
    }
    let options = ReadOptions {
        columns: vec!["illuminance_(pcv)".to_owned()],
        ..ReadOptions::default()
    };
    let cloud = read_bytes(&latin, &options)?;
    demand(
        cloud.positions == [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)],
        format!("{:?}", cloud.positions),
    )?;
    demand(
        cloud.mirror.as_deref() == Some(&[0.0, 1.0]),
        format!("{:?}", cloud.mirror),
    )?;
    demand(cloud.up_axis == Some(UpAxis::Z), "the comment says z up")?;
    demand(
        cloud.columns["illuminance_(pcv)"] == [0.5, 0.25],
        format!("{:?}", cloud.columns),
    )
}

fn odd_numbers() -> Result<(), Failed> {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty double z\n\
        end_header\nnan 1. .5\n  +1e2 -inf 0\n\n1 2 123456789.123456789";
    let cloud = read_bytes(text.as_bytes(), &ReadOptions::default())?;
    let [first, second, third] = cloud.positions[..] else {
        return Err("three points".into());
    };
    demand(
        first.x.is_nan() && first.y == 1.0 && first.z == 0.5,
        format!("{first}"),
    )?;
    demand(
        second == DVec3::new(100.0, f64::NEG_INFINITY, 0.0),
        format!("{second}"),
    )?;
    demand(
        third.z == 123_456_789.123_456_79,
        format!("{third}: doubles keep their digits"),
    )
}

fn cancelled() -> Result<(), Failed> {
    let cloud = RawCloud {
        positions: vec![DVec3::ZERO; 1000],
        ..RawCloud::default()
    };
    let job = Job::default();
    job.cancel();
    let outcome = write_ply(&mut Vec::new(), Path::new("out.ply"), &cloud, &job);
    demand(
        matches!(outcome, Err(Error::Cancelled)),
        format!("{outcome:?}"),
    )
}
