//! The commands that measure: what they write, what they refuse, and that their figures are those of an independent program.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use catoptric::output::ExrImage;
use glam::DVec3;
use libtest_mimic::{Failed, Trial};
use serde_json::Value;

use crate::npz::Npz;
use crate::program::{done, json, names, program, refused, room, run, stderr};
use crate::support::{claim, folder};

pub(crate) fn tests() -> Vec<Trial> {
    let mut trials = vec![
        claim(
            "measured::compare_puts_settings_side_by_side",
            compare_puts_settings_side_by_side,
        ),
        claim(
            "measured::names_in_reports_are_only_names",
            names_in_reports_are_only_names,
        ),
        claim(
            "measured::compare_refuses_what_it_cannot_compare",
            compare_refuses,
        ),
        claim(
            "measured::a_sweep_goes_on_where_it_stopped",
            a_sweep_goes_on,
        ),
        claim("measured::a_sweep_refuses_before_it_runs", a_sweep_refuses),
        claim(
            "measured::experiments_are_swept_over",
            experiments_are_swept_over,
        ),
        claim(
            "measured::every_committed_experiment_is_sound",
            every_experiment_is_sound,
        ),
        claim(
            "measured::tune_prints_settings_to_paste",
            tune_prints_settings_to_paste,
        ),
        claim(
            "measured::tune_says_what_cannot_be_reached",
            tune_says_what_cannot_be_reached,
        ),
    ];
    #[cfg(unix)]
    trials.push(claim(
        "measured::an_interrupted_sweep_keeps_what_it_has",
        an_interrupted_sweep_keeps_what_it_has,
    ));
    trials.push(
        Trial::test(
            "measured::figures_against_a_truth_are_those_of_others",
            figures_are_those_of_others,
        )
        .with_ignored_flag(folder("CATOPTRIC_TRUTH").is_none()),
    );
    trials
}

fn compare_puts_settings_side_by_side() {
    let folder = room();
    let said = done(
        folder.path(),
        "compare room.toml --backend cpu --repeats 2 -o out",
    );
    let first: Vec<&str> = said
        .lines()
        .filter_map(|l| l.split_whitespace().next())
        .collect();
    assert_eq!(
        first,
        ["variant", "reference", "interleaved", "guided", "ray_trace"],
        "{said}"
    );

    let written = names(&folder.path().join("out"));
    for name in [
        "report.html",
        "compare.json",
        "2-guided-picture.png",
        "1-interleaved-steps__misses__residual.png",
    ] {
        assert!(
            written.iter().any(|n| n == name),
            "{name} is missing of {written:?}"
        );
    }
    let report = json(&folder.path().join("out/compare.json"));
    let variants = report["variants"].as_array().expect("variants");
    let of = |name: &str| {
        variants
            .iter()
            .find(|v| v["name"] == name)
            .expect("a variant")
    };
    let number = |v: &Value, path: &str| v.pointer(path).and_then(Value::as_f64).expect("a number");
    // Traced rays are the reference; the searches are near it, and neither is the other.
    assert!(number(of("ray_trace"), "/mirrors/albedo_psnr") >= 120.0);
    let [guided, interleaved] =
        ["guided", "interleaved"].map(|name| number(of(name), "/mirrors/albedo_psnr"));
    let black = number(&report, "/controls/black/psnr");
    assert!(
        guided > black + 5.0 && interleaved > black + 3.0 && guided < 100.0,
        "{guided} {interleaved} {black}"
    );
    for variant in variants {
        let [wall, least, most] =
            ["median", "min", "max"].map(|n| number(variant, &format!("/wall_ms/{n}")));
        assert!(0.0 < least && least <= wall && wall <= most, "{variant}");
        assert!(
            number(variant, "/peak_memory_bytes") > 1e6 && number(variant, "/cpu_ms/median") > 0.0
        );
    }
}

fn names_in_reports_are_only_names() {
    let folder = room();
    let scene = std::fs::read_to_string(folder.path().join("room.toml")).expect("a scene");
    std::fs::write(folder.path().join("<img src=x>.toml"), scene).expect("a scene");
    let mut command = program(
        folder.path(),
        "compare --backend cpu --repeats 1 -o out --variant <b>x</b>:splat.size=1.6",
    );
    let output = command
        .arg("<img src=x>.toml")
        .output()
        .expect("the program runs");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).expect("a page");
    assert!(
        !page.contains("<img src=x>") && !page.contains("<b>x"),
        "a name became HTML"
    );
    assert!(page.contains("&lt;img src=x&gt;") && page.contains("&lt;b&gt;x&lt;/b&gt;"));
    assert!(
        !page.contains("http://") && !page.contains("https://"),
        "nothing from the network"
    );
}

fn compare_refuses() {
    let folder = room();
    let wrong = |arguments: &str, status: i32, part: &str| {
        let said = refused(folder.path(), arguments, status);
        assert!(said.contains(part), "{arguments} says {said:?}");
    };
    wrong("compare room.toml --variant fast", 2, "NAME:key=value");
    wrong(
        "compare room.toml --variant a:splat.sise=2",
        2,
        "splat.size",
    );
    wrong(
        "compare room.toml --variant a:camera.size=80x60",
        2,
        "sweep",
    );
    wrong(
        "compare room.toml --variant a:splat.size=2 --variant a:splat.size=3",
        2,
        "two variants",
    );
    wrong("compare room.toml --repeats 0", 2, "--repeats");
    wrong("compare room.toml --truth missing.npz", 1, "missing.npz");
    std::fs::write(folder.path().join("broken.npz"), b"PK\x05\x06 and more").expect("a file");
    wrong("compare room.toml --truth broken.npz", 1, "broken.npz");
    wrong("compare room.toml --truth room.toml", 1, ".npz");
    wrong("compare room.toml -o room.toml", 2, "folder");
    assert_eq!(names(folder.path()), ["broken.npz", "room.toml"]);
}

const SWEEP: &str = "sweep room.toml --backend cpu --vary sscr.search=interleaved,guided --vary camera.size=32x24,64x48 -o out";

fn lines(folder: &Path, name: &str) -> Vec<String> {
    let text = std::fs::read_to_string(folder.join("out").join(name)).expect("a file");
    assert!(text.ends_with('\n'), "{name} ends with a torn line");
    text.lines().map(str::to_owned).collect()
}

fn a_sweep_goes_on() {
    let folder = room();
    let run = |repeats: u32| done(folder.path(), &format!("{SWEEP} --repeats {repeats}"));
    run(1);
    let (rows, csv) = (
        lines(folder.path(), "sweep.jsonl"),
        lines(folder.path(), "sweep.csv"),
    );
    assert_eq!(
        (rows.len(), csv.len()),
        (5, 5),
        "a header and four combinations"
    );
    assert!(
        csv[0].starts_with("combination,round,sscr.search,camera.size,wall_ms,"),
        "{}",
        csv[0]
    );
    for row in &rows[1..] {
        let row: Value = serde_json::from_str(row).expect("JSON");
        assert!(
            row["version"] == env!("CARGO_PKG_VERSION") && row["backend"] == "cpu",
            "{row}"
        );
        assert!(
            row["quality"]["mirrors"]["albedo_psnr"].as_f64() > Some(5.0),
            "{row}"
        );
    }
    // Nothing is left to do; then one more round each.
    run(1);
    assert_eq!(lines(folder.path(), "sweep.jsonl"), rows);
    run(2);
    let more = lines(folder.path(), "sweep.jsonl");
    assert!(
        more.len() == 9 && more[..5] == rows[..],
        "{} lines",
        more.len()
    );
    // A torn line is run again, and no other.
    let path = folder.path().join("out/sweep.jsonl");
    let text = std::fs::read_to_string(&path).expect("text");
    std::fs::write(&path, &text[..text.len() - 30]).expect("torn");
    run(2);
    let again = lines(folder.path(), "sweep.jsonl");
    assert!(
        again.len() == 9 && again[..8] == more[..8] && again[8] != more[8],
        "one row is new"
    );
    assert_eq!(lines(folder.path(), "sweep.csv").len(), 9);
    let written = names(&folder.path().join("out"));
    assert!(
        written.iter().any(|n| n == "trade.svg") && written.iter().any(|n| n == "report.html"),
        "{written:?}"
    );

    let said = refused(folder.path(), &SWEEP.replace("64x48", "60x40"), 1);
    assert!(said.contains("another sweep"), "{said}");
    assert_eq!(lines(folder.path(), "sweep.jsonl"), again);
}

fn a_sweep_refuses() {
    let folder = room();
    for (arguments, part) in [
        ("sweep room.toml -o out", "--vary"),
        (
            "sweep room.toml -o out --vary sscr.serch=guided",
            "sscr.search",
        ),
        (
            "sweep room.toml -o out --vary splat.size=1,900",
            "splat.size",
        ),
        ("sweep room.toml -o out --vary splat.size=1,1", "twice"),
        ("sweep room.toml --vary splat.size=1,2", "--output"),
    ] {
        let said = refused(folder.path(), arguments, 2);
        assert!(said.contains(part), "{arguments} says {said:?}");
    }
    assert_eq!(names(folder.path()), ["room.toml"], "no folder is left");
}

fn experiments_are_swept_over() {
    let folder = room();
    let at = folder.path();
    std::fs::create_dir(at.join("docs")).expect("a folder");
    let text = "title = \"Two <sizes>\"\nscene = \"../room.toml\"\nset = [\"sscr.search=interleaved\"]\nvary = [\"splat.size=1.5,2\"]\nrepeats = 1\n";
    std::fs::write(at.join("docs/e.toml"), text).expect("a file");
    done(at, "sweep docs/e.toml --backend cpu -o out");
    assert_eq!(lines(at, "sweep.csv").len(), 3);
    let page = std::fs::read_to_string(at.join("out/report.html")).expect("a page");
    assert!(page.contains("<title>Two &lt;sizes&gt;</title>"));
    std::fs::write(at.join("docs/e.toml"), text.replace("repeats", "repeets")).expect("a file");
    let said = refused(at, "sweep docs/e.toml --backend cpu -o other", 1);
    assert!(
        said.contains("e.toml:5") && said.contains("repeets"),
        "{said}"
    );
}

fn every_experiment_is_sound() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut number = 0;
    for name in names(&root.join("docs/experiments"))
        .iter()
        .filter(|n| n.ends_with(".toml"))
    {
        // The folder is a file, so that it ends after everything else was checked.
        let given = format!("sweep docs/experiments/{name} -o Cargo.toml");
        let said = refused(root, &given, 2);
        assert!(said.contains("is a file"), "{name}: {said}");
        let given = format!("sweep docs/experiments/{name} --vary splat.size=900 -o Cargo.toml");
        let said = refused(root, &given, 2);
        assert!(said.contains("splat.size"), "{name}: {said}");
        number += 1;
    }
    assert_eq!(number, 9, "the thesis's figures 5.3 to 5.11");
}

fn tune_prints_settings_to_paste() {
    let folder = room();
    let text = done(
        folder.path(),
        "tune room.toml --backend cpu --budget-ms 10000 --candidates 6 --keys sscr.points_per_pixel,sscr.pull_levels",
    );
    let table: toml::Table = toml::from_str(&text).expect("TOML");
    let sscr = &table["settings"]["sscr"];
    assert!(
        sscr["points_per_pixel"].as_float().is_some() && sscr["pull_levels"].as_integer().is_some(),
        "{text}"
    );
    assert!(
        text.starts_with("# Expect ") && text.contains("# Tried"),
        "{text}"
    );
    // It is a part of a scene, and as such sound.
    let scene = std::fs::read_to_string(folder.path().join("room.toml")).expect("a scene");
    std::fs::write(folder.path().join("tuned.toml"), scene + &text).expect("a scene");
    done(folder.path(), "info tuned.toml");
}

fn tune_says_what_cannot_be_reached() {
    let folder = room();
    let tune = "tune room.toml --backend cpu --candidates 4 --keys sscr.pull_levels";
    for (goal, part) in [
        (
            "--budget-ms 0.001",
            "0.001 ms was not reached; the best was ",
        ),
        ("--quality 119", "119 dB was not reached"),
    ] {
        let output = run(folder.path(), &format!("{tune} {goal}"));
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).contains(part), "{}", stderr(&output));
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(
            toml::from_str::<toml::Table>(&text).is_ok_and(|t| t.contains_key("settings")),
            "{text}"
        );
    }
    for wrong in [
        "",
        "--budget-ms -1",
        "--budget-ms 1 --quality 2",
        "--quality 30 --keys sscr.nothing",
        "--quality nan",
    ] {
        refused(folder.path(), &format!("tune room.toml {wrong}"), 2);
    }
}

#[cfg(unix)]
fn an_interrupted_sweep_keeps_what_it_has() {
    let folder = room();
    let command = format!("{SWEEP} --repeats");
    let mut child = program(folder.path(), &format!("{command} 900"))
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the program runs");
    let csv = folder.path().join("out/sweep.csv");
    let start = Instant::now();
    while std::fs::read_to_string(&csv).map_or(0, |t| t.lines().count()) < 4 {
        assert!(start.elapsed() < Duration::from_secs(120), "no rows appear");
        std::thread::sleep(Duration::from_millis(20));
    }
    let interrupted = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(interrupted.is_ok_and(|s| s.success()));
    assert_eq!(child.wait().expect("it ends").code(), Some(1));
    let rows = lines(folder.path(), "sweep.jsonl");
    assert!(
        rows.len() >= 4
            && rows
                .iter()
                .all(|r| serde_json::from_str::<Value>(r).is_ok())
    );
    assert_eq!(lines(folder.path(), "sweep.csv").len(), rows.len());
    done(folder.path(), &format!("{command} 1"));
    let after = lines(folder.path(), "sweep.jsonl");
    assert_eq!(after[..rows.len()], rows[..], "what was there stays");
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
