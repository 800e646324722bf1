//! Other programs read what is written, and the documentation tells them all of it.

use std::path::{Path, PathBuf};
use std::process::Command;

use catoptric::image::Background;
use catoptric::output::{ExrImage, write_picture};
use glam::{DVec3, UVec2, Vec4};
use libtest_mimic::{Failed, Trial};

/// The tests of this file. Those of other programs are ignored where these are not installed.
pub(crate) fn tests() -> Vec<Trial> {
    let openexr = python("import OpenEXR, numpy").is_ok();
    let truth = std::env::var_os("CATOPTRIC_TRUTH").map(PathBuf::from);
    let compared = truth.clone();
    vec![
        Trial::test(
            "openexr_reads_names_values_and_attributes",
            openexr_reads_ours,
        )
        .with_ignored_flag(!openexr),
        Trial::test("the_comparison_with_the_truth_reads_pictures", move || {
            the_comparison_reads_pictures(compared.as_deref().unwrap_or(Path::new("")))
        })
        .with_ignored_flag(!openexr || truth.is_none()),
        Trial::test(
            "every_channel_and_key_is_documented",
            everything_is_documented,
        ),
        Trial::test(
            "a_picture_is_the_same_for_any_number_of_threads",
            one_picture_for_any_threads,
        ),
    ]
}

/// What a Python program prints, or what it says on failing.
fn python(program: &str) -> Result<String, Failed> {
    let run = Command::new("python3").args(["-c", program]).output()?;
    if run.status.success() {
        Ok(String::from_utf8(run.stdout)?)
    } else {
        Err(String::from_utf8_lossy(&run.stderr).into_owned().into())
    }
}

fn demand(holds: bool, otherwise: impl Into<String>) -> Result<(), Failed> {
    if holds {
        Ok(())
    } else {
        Err(otherwise.into().into())
    }
}

fn openexr_reads_ours() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("out.exr");
    let mut image = ExrImage::new(UVec2::new(3, 2));
    image.channels.insert(
        "normal.X".to_owned(),
        (0u8..6).map(|p| f32::from(p) / 3.0).collect(),
    );
    image.channels.insert("valid.V".to_owned(), vec![1.0; 6]);
    image.set_origin(DVec3::new(636_001.123_456_789, 0.0, -1.0));
    image.write(&path)?;
    let read = python(&format!(
        "import OpenEXR
with OpenEXR.File({path:?}, separate_channels=True) as f:
    c, h = f.channels(), f.header()
    print(sorted(c), c['normal.X'].pixels.dtype, h['compression'], h['lineOrder'])
    print([[round(float(v) * 3, 5) for v in row] for row in c['normal.X'].pixels])
    print(*(h['origin' + axis].item() for axis in 'XYZ'))"
    ))?;
    let expected =
        "['normal.X', 'valid.V'] float32 Compression.ZIP_COMPRESSION LineOrder.INCREASING_Y
[[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]
636001.123456789 0.0 -1.0
";
    demand(read == expected, format!("got\n{read}expected\n{expected}"))
}

/// A flat picture: its mean is known, and it is far from the truth.
fn the_comparison_reads_pictures(truth: &Path) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("out.exr");
    let flat = catoptric::grid::Grid::new(UVec2::new(800, 600), Vec4::new(0.25, 0.25, 0.25, 1.0));
    write_picture(&path, &flat, &Default::default())?;
    let run = Command::new("python3")
        .arg(truth.join("compare.py"))
        .args(["image", "sphere"])
        .arg(&path)
        .args(["--ref", "direct1", "--json"])
        .output()?;
    let printed = String::from_utf8_lossy(&run.stdout);
    let scores: serde_json::Value = serde_json::from_str(&printed)
        .map_err(|e| format!("{e}: {printed}{}", String::from_utf8_lossy(&run.stderr)))?;
    demand(
        scores["nonfinite_px"] == 0,
        format!("broken pixels: {printed}"),
    )?;
    let (mean, psnr) = (&scores["all"]["mean_cand"], &scores["all"]["psnr"]);
    demand(
        mean.as_f64() == Some(0.25),
        format!("read a mean of {mean}, not 0.25"),
    )?;
    demand(
        psnr.as_f64() < Some(20.0),
        format!("a flat picture scores {psnr} dB: nothing is compared"),
    )
}

fn everything_is_documented() -> Result<(), Failed> {
    use catoptric::backend::cpu::Cpu;
    use catoptric::camera::Camera;
    use catoptric::gbuffer::GBuffer;

    let documentation = include_str!("../docs/OUTPUTS.md");
    let camera = Camera {
        position: DVec3::ZERO,
        target: DVec3::X,
        up: DVec3::Z,
        fov_y_degrees: 60.0,
        near: 0.1,
        far: 10.0,
        size: UVec2::ONE,
    };
    let gbuffer = GBuffer::<Cpu>::empty(camera.pinhole(DVec3::ZERO)?);
    let buffers = catoptric::output::camera_gbuffer(&gbuffer, DVec3::ZERO);
    let described = serde_json::to_value(catoptric::output::CameraDescription::new(
        &camera,
        DVec3::ZERO,
    )?)?;
    let keys = described
        .as_object()
        .into_iter()
        .flatten()
        .map(|(key, _)| key.clone());
    let names = buffers
        .channels
        .keys()
        .chain(buffers.numbers.keys())
        .cloned()
        .chain(keys);
    let missing: Vec<String> = names
        .filter(|name| !documentation.contains(name.as_str()))
        .collect();
    demand(
        missing.is_empty(),
        format!("docs/OUTPUTS.md does not name {missing:?}"),
    )
}

fn one_picture_for_any_threads() -> Result<(), Failed> {
    let size = UVec2::new(317, 211);
    let values =
        (0..size.element_product()).map(|i| Vec4::new(i as f32 * 1e-5, 0.3, 1.0, (i % 5) as f32));
    let radiance = catoptric::grid::Grid::from_vec(size, values.collect()).ok_or("a grid")?;
    let folder = tempfile::tempdir()?;
    for extension in ["png", "exr"] {
        let mut files = Vec::new();
        for threads in [1, 2, 3] {
            let path = folder.path().join(format!("{threads}.{extension}"));
            let settings = catoptric::image::ImageSettings {
                background: Background::Transparent,
                ..Default::default()
            };
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()?;
            pool.install(|| write_picture(&path, &radiance, &settings))?;
            files.push(std::fs::read(&path)?);
        }
        demand(
            files.windows(2).all(|pair| pair[0] == pair[1]),
            format!("{extension} files differ"),
        )?;
    }
    Ok(())
}
