//! `catoptric compare --truth`, whose figures are those of others.

use std::path::Path;
use std::process::Command;

use catoptric::output::ExrImage;
use glam::DVec3;
use libtest_mimic::{Failed, Trial};
use serde_json::Value;

use crate::npz::Npz;
use crate::program::{done, json};
use crate::support::folder;

pub(super) fn tests() -> Vec<Trial> {
    let trial = Trial::test(
        "measured::figures_against_a_truth_are_those_of_others",
        figures_are_those_of_others,
    );
    vec![trial.with_ignored_flag(folder("CATOPTRIC_TRUTH").is_none())]
}

/// What the program says of a mirrors' buffer against the truth, what compare.py says of it, and what follows from the
/// definitions, agree to four digits; another buffer's figures do not.
fn figures_are_those_of_others() -> Result<(), Failed> {
    let truth = folder("CATOPTRIC_TRUTH").ok_or("no truth")?;
    let at = tempfile::tempdir()?;
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("pointclouds/sphere.toml");
    let scene = scene.to_str().ok_or("a path of another kind")?;
    let npz = truth.join("sphere_aov.npz");
    let npz = npz.to_str().ok_or("a path of another kind")?;
    let searches =
        ["guided", "interleaved"].map(|s| format!("{s}:reflect.method=sscr,sscr.search={s}"));
    let variants = searches
        .iter()
        .map(|v| format!(" --variant {v}"))
        .collect::<String>();
    done(
        at.path(),
        &format!("compare {scene} --backend cpu --repeats 1 --truth {npz} -o out{variants}"),
    );
    let report = json(&at.path().join("out/compare.json"));
    let ours = |variant: usize, path: &str| {
        let value = report["variants"][variant]["truths"][0]["mirrors"].pointer(path);
        value.and_then(Value::as_f64).ok_or(format!("no {path}"))
    };
    done(
        at.path(),
        &format!("render {scene} --backend cpu --mirror-gbuffer m.exr --set reflect.method=sscr"),
    );

    let (coverage, median, psnr) = by_definition(&at.path().join("m.exr"), Path::new(npz))?;
    for (path, other) in [
        ("/coverage", coverage),
        ("/position_m/median", median),
        ("/albedo_psnr", psnr),
    ] {
        same(path, ours(1, path)?, other)?;
        assert!(
            same(path, ours(2, path)?, other).is_err(),
            "the other search has another {path}"
        );
    }
    let Some([gbuf, albedo]) = by_compare_py(&truth, &at.path().join("m.exr")) else {
        println!("compare.py cannot run here; compared with the definitions alone");
        return Ok(());
    };
    for (path, other) in [
        ("/coverage", &gbuf["coverage"]),
        ("/position_m/median", &gbuf["all"]["pos_m"]["median"]),
        ("/position_m/p90", &gbuf["all"]["pos_m"]["p90"]),
        ("/position_m/p99", &gbuf["all"]["pos_m"]["p99"]),
        ("/position_m/max", &gbuf["all"]["pos_m"]["max"]),
        ("/angle_degrees/median", &gbuf["all"]["angle_deg"]["median"]),
        ("/angle_degrees/p99", &gbuf["all"]["angle_deg"]["p99"]),
        ("/albedo_psnr", &albedo["candidate"]["psnr"]),
        ("/albedo_ssim", &albedo["candidate"]["ssim"]),
    ] {
        same(path, ours(1, path)?, other.as_f64().ok_or("no number")?)?;
    }
    Ok(())
}

/// Whether two figures agree to four digits.
fn same(what: &str, ours: f64, other: f64) -> Result<(), Failed> {
    println!("{what}: {ours} and {other}");
    if (ours - other).abs() > 5e-5 * other.abs() {
        return Err(format!("{what} is {ours}, and by another way {other}").into());
    }
    Ok(())
}

/// What compare.py says of a mirrors' buffer, `gbuf` and `albedo`; `None` where Python or its libraries are missing.
fn by_compare_py(truth: &Path, buffer: &Path) -> Option<[Value; 2]> {
    let of = |mode: &str| {
        let output = Command::new("python3")
            .arg(truth.join("compare.py"))
            .args([mode, "sphere"])
            .arg(buffer)
            .arg("--json")
            .output()
            .ok()?;
        serde_json::from_slice(&output.stdout).ok()
    };
    Some([of("gbuf")?, of("albedo")?])
}

/// Coverage, median distance and PSNR of albedo, with other readers and by the definitions alone.
fn by_definition(buffer: &Path, truth: &Path) -> Result<(f64, f64, f64), Failed> {
    let shown = ExrImage::decode(&std::fs::read(buffer)?)?;
    let channel = |name: &str| &shown.channels[name];
    let vector = |layer: &str, letters: [&str; 3], i: usize| {
        DVec3::from(letters.map(|l| f64::from(channel(&format!("{layer}.{l}"))[i])))
    };
    let truth = Npz::open(truth)?;
    let (mirror, ids) = (truth.bytes("mirror")?, truth.bytes("Qid")?);
    let (places, albedo) = (truth.vectors("Q")?, truth.vectors("Qalb")?);
    let (mut distances, mut squares, mut walls, mut pixels) = (Vec::new(), 0.0, 0u32, 0u32);
    for i in (0..mirror.len()).filter(|&i| mirror[i] > 0) {
        pixels += 1;
        let valid = channel("valid.V")[i] > 0.0;
        if valid {
            distances.push(vector("reflected_position", ["X", "Y", "Z"], i).distance(places[i]));
        }
        if ids[i] < 10 {
            let got = if valid {
                vector("reflected_albedo", ["R", "G", "B"], i)
            } else {
                DVec3::ZERO
            };
            squares += (crate::shown::srgb(got) - crate::shown::srgb(albedo[i])).length_squared();
            walls += 3;
        }
    }
    distances.sort_by(f64::total_cmp);
    let n = distances.len();
    let median = f64::midpoint(distances[(n - 1) / 2], distances[n / 2]);
    Ok((
        n as f64 / f64::from(pixels),
        median,
        -10.0 * (squares / f64::from(walls)).log10(),
    ))
}
