//! `catoptric tune`.

use libtest_mimic::Trial;

use crate::program::{done, refused, room, run, stderr};
use crate::support::claim;

pub(super) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "measured::tune_prints_settings_to_paste",
            tune_prints_settings_to_paste,
        ),
        claim(
            "measured::tune_says_what_cannot_be_reached",
            tune_says_what_cannot_be_reached,
        ),
    ]
}

fn tune_prints_settings_to_paste() {
    let folder = room();
    let text = done(
        folder.path(),
        "tune room.toml --backend cpu --budget-ms 10000 --candidates 6 --keys sscr.points_per_pixel,sscr.pull_levels,sscr.max_steps",
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
    assert!(
        sscr.get("max_steps").is_none() && !text.contains("max_steps"),
        "it does nothing for the guided search, and is not tried: {text}"
    );
    // It is a part of a scene, and as such sound.
    let scene = std::fs::read_to_string(folder.path().join("room.toml")).expect("a scene");
    std::fs::write(folder.path().join("tuned.toml"), scene + &text).expect("a scene");
    done(folder.path(), "info tuned.toml");
}

fn tune_says_what_cannot_be_reached() {
    let folder = room();
    let tune =
        "tune room.toml --backend cpu --candidates 4 --keys sscr.pull_levels --set gi.vpl_count=0";
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
