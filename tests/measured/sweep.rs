//! `catoptric sweep`.

use std::path::Path;
#[cfg(unix)]
use std::process::Command;
#[cfg(unix)]
use std::time::{Duration, Instant};

use libtest_mimic::Trial;
use serde_json::Value;

#[cfg(unix)]
use crate::program::program;
use crate::program::{done, names, refused, room};
use crate::support::claim;

pub(super) fn tests() -> Vec<Trial> {
    vec![
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
        #[cfg(unix)]
        claim(
            "measured::an_interrupted_sweep_keeps_what_it_has",
            an_interrupted_sweep_keeps_what_it_has,
        ),
    ]
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
