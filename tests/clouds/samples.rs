//! Real files of other programs.

use std::path::{Path, PathBuf};

use catoptric::Job;
use catoptric::cloud::{ColourBits, ReadOptions, UpAxis, prepare, read_cloud};
use glam::{DVec3, Vec3};
use libtest_mimic::{Failed, Trial};

use super::{demand, read};

type Test = fn(&Path) -> Result<(), Failed>;

pub(super) fn tests() -> Vec<Trial> {
    let folder = std::env::var_os("CATOPTRIC_SCANS").map(PathBuf::from);
    let tests: [(&str, Test); 6] = [
        ("autzen_is_in_feet_with_8_bits_in_16", autzen),
        ("autzen_keeps_its_digits_as_surfels", autzen_surfels),
        ("simple_las_has_true_16_bits", simple),
        ("simple_las_agrees_with_its_bytes", simple_bytes),
        ("copc_is_read_as_laz", copc),
        ("the_bunny_is_read_without_its_faces", bunny),
    ];
    let trials = tests.into_iter().map(|(name, test)| {
        let folder = folder.clone();
        let run = move || test(folder.as_deref().unwrap_or(Path::new("")));
        Trial::test(name, run)
    });
    trials
        .map(|trial| trial.with_ignored_flag(folder.is_none()))
        .collect()
}

/// The box that the header of a LAS file states.
fn stated_bounds(path: &Path) -> Result<(DVec3, DVec3), Failed> {
    let bytes = std::fs::read(path)?;
    let number = |at: usize| f64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]));
    let [max_x, min_x, max_y, min_y, max_z, min_z] = std::array::from_fn(|i| number(179 + 8 * i));
    Ok((
        DVec3::new(min_x, min_y, min_z),
        DVec3::new(max_x, max_y, max_z),
    ))
}

fn demand_stated_bounds(path: &Path, positions: &[DVec3]) -> Result<(), Failed> {
    let (min, max) = stated_bounds(path)?;
    let least = positions
        .iter()
        .copied()
        .reduce(DVec3::min)
        .unwrap_or_default();
    let most = positions
        .iter()
        .copied()
        .reduce(DVec3::max)
        .unwrap_or_default();
    let off = (least - min).abs().max((most - max).abs()).max_element();
    demand(
        off < 1e-6,
        format!("box {least} to {most}, the header says {min} to {max}"),
    )
}

fn autzen(folder: &Path) -> Result<(), Failed> {
    let path = folder.join("autzen_trim_110k_8bitrgb.laz");
    let options = ReadOptions {
        columns: vec!["Classification".to_owned()],
        ..ReadOptions::default()
    };
    let cloud = read_cloud(&path, &options, &Job::default())?;
    demand(cloud.len() == 110_000, format!("{} points", cloud.len()))?;
    demand_stated_bounds(&path, &cloud.positions)?;
    demand(
        cloud.unit.as_deref() == Some("foot"),
        format!("unit {:?}", cloud.unit),
    )?;
    demand(
        cloud.format == "LAS 1.2, point format 3, LAZ",
        cloud.format.clone(),
    )?;
    demand(
        cloud.scale == Some(DVec3::splat(0.01)),
        format!("scale {:?}", cloud.scale),
    )?;
    demand(cloud.up_axis == Some(UpAxis::Z), "z is up")?;
    let classes = &cloud.columns["Classification"];
    demand(
        classes.iter().all(|&c| c == 1.0 || c == 2.0),
        "classes 1 and 2",
    )?;

    // The brightest channel is 236 of 255; read as 16 bits all is black.
    let brightest = |cloud: &catoptric::cloud::RawCloud| {
        let albedo = cloud.albedo.iter().flatten();
        albedo.map(|rgb| rgb.max_element()).fold(0.0, f32::max)
    };
    let expected = ((236.0_f32 / 255.0 + 0.055) / 1.055).powf(2.4);
    demand(
        (brightest(&cloud) - expected).abs() < 1e-4,
        format!("brightest {}", brightest(&cloud)),
    )?;
    let options = ReadOptions {
        colour_bits: ColourBits::Sixteen,
        ..ReadOptions::default()
    };
    let dark = read_cloud(&path, &options, &Job::default())?;
    demand(
        brightest(&dark) < 1e-3,
        format!("overruled: brightest {}", brightest(&dark)),
    )
}

fn autzen_surfels(folder: &Path) -> Result<(), Failed> {
    let raw = read(&folder.join("autzen_trim_110k_8bitrgb.laz"))?;
    let positions = raw.positions.clone();
    let viewpoint = DVec3::new(636_600.0, 848_600.0, 1_500.0);
    let prepared = prepare(vec![raw.into()], viewpoint, &Job::default())?;
    let (surfels, facts) = (&prepared.surfels, &prepared.facts);
    demand(
        surfels.len() == 110_000,
        format!("{} surfels", surfels.len()),
    )?;

    // The origin is a multiple of the quantum, and every point is where its file has it to 1/100 of a foot.
    let multiple = facts.origin / 0.01;
    demand(
        (multiple - multiple.round()).abs().max_element() < 1e-6,
        format!("origin {}", facts.origin),
    )?;
    let moved = surfels
        .places
        .iter()
        .zip(&surfels.source)
        .map(|(place, &source)| {
            (place.position.as_dvec3() + facts.origin - positions[source as usize])
                .abs()
                .max_element()
        });
    let moved = moved.fold(0.0, f64::max);
    demand(moved < 1e-4, format!("a point moved by {moved} ft"))?;
    demand(
        (1.0..6.0).contains(&facts.spacing),
        format!("spacing {} ft", facts.spacing),
    )?;

    // From above, what the ground and most of the trees show is their upper side.
    let up = surfels
        .finishes
        .iter()
        .filter(|finish| finish.normal().z > 0.0)
        .count();
    demand(up > 100_000, format!("{up} normals point up"))
}

fn simple(folder: &Path) -> Result<(), Failed> {
    let path = folder.join("simple1_4_pdrf7_16bitrgb.las");
    let cloud = read(&path)?;
    demand(cloud.len() == 22_600, format!("{} points", cloud.len()))?;
    demand_stated_bounds(&path, &cloud.positions)?;
    demand(
        cloud.format == "LAS 1.4, point format 7",
        cloud.format.clone(),
    )?;
    demand(
        cloud.intensity.is_none(),
        "intensities of 0 throughout were never measured",
    )?;
    demand(
        cloud.unit.is_none(),
        format!("degrees are no unit of length: {:?}", cloud.unit),
    )?;
    let first = cloud
        .albedo
        .as_ref()
        .and_then(|albedo| albedo.first().copied())
        .unwrap_or_default();
    let expected = Vec3::new(25_600.0, 26_624.0, 26_880.0) / 65_535.0;
    let expected = expected.map(|v| ((v + 0.055) / 1.055).powf(2.4));
    demand(
        (first - expected).abs().max_element() < 1e-5,
        format!("first colour {first}, expected {expected}"),
    )
}

/// Every coordinate, against the file's bytes read here by hand.
fn simple_bytes(folder: &Path) -> Result<(), Failed> {
    let path = folder.join("simple1_4_pdrf7_16bitrgb.las");
    let (cloud, bytes) = (read(&path)?, std::fs::read(&path)?);
    let number = |at: usize| f64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]));
    let whole = |at: usize| f64::from(i32::from_le_bytes(std::array::from_fn(|i| bytes[at + i])));
    let start = u32::from_le_bytes(std::array::from_fn(|i| bytes[96 + i])) as usize;
    for (index, position) in cloud.positions.iter().enumerate() {
        let record = start + 36 * index;
        let expected: [f64; 3] = std::array::from_fn(|i| {
            whole(record + 4 * i) * number(131 + 8 * i) + number(155 + 8 * i)
        });
        demand(
            position.to_array() == expected,
            format!("point {index}: {position}, expected {expected:?}"),
        )?;
    }
    Ok(())
}

fn copc(folder: &Path) -> Result<(), Failed> {
    let path = folder.join("simple_with_page_1065.copc.laz");
    let cloud = read(&path)?;
    demand(cloud.len() == 1_065, format!("{} points", cloud.len()))?;
    demand_stated_bounds(&path, &cloud.positions)?;
    demand(
        cloud.unit.as_deref() == Some("metre"),
        format!("unit {:?}, heights apart", cloud.unit),
    )?;
    demand(
        cloud.albedo.is_some() && cloud.intensity.is_some(),
        "colours and intensities",
    )
}

fn bunny(folder: &Path) -> Result<(), Failed> {
    let cloud = read(&folder.join("bunny_mesh.ply"))?;
    demand(cloud.len() == 117_570, format!("{} points", cloud.len()))?;
    let normals = cloud.normals.as_deref().unwrap_or_default();
    demand(normals.len() == cloud.len(), "a normal each")?;
    let unit = normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-3);
    demand(unit, "unit normals")?;
    let least = cloud
        .positions
        .iter()
        .map(|p| p.y)
        .fold(f64::INFINITY, f64::min);
    let most = cloud
        .positions
        .iter()
        .map(|p| p.y)
        .fold(f64::NEG_INFINITY, f64::max);
    demand(
        (most - least - 0.85).abs() < 0.01,
        format!("{} m high", most - least),
    )
}
