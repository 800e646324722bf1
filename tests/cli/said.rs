//! What the program says when it is asked.

use libtest_mimic::Trial;
use serde_json::Value;

use crate::program::{done, names, refused, room, run, stderr};
use crate::support::claim;

pub(super) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "cli::help_tells_units_defaults_and_where_the_settings_are",
            help_tells_what_there_is,
        ),
        claim(
            "cli::generate_asks_for_its_folder_first_and_says_what_it_wrote",
            generate_asks_first,
        ),
        claim("cli::info_counts_and_plans", info_counts_and_plans),
        claim("cli::info_lists_every_setting", info_lists_every_setting),
    ]
}

fn help_tells_what_there_is() {
    let folder = room();
    let help = done(folder.path(), "render --help");
    for word in [
        "info --settings",
        "W/sr/m2",
        "degrees",
        "pixels",
        "default",
        "Examples",
        "#rrggbb",
        "--camera-json",
        "--search-heat",
    ] {
        assert!(help.contains(word), "render --help lacks {word:?}");
    }
    assert!(
        done(folder.path(), "--help").contains("Exit status"),
        "--help tells the exit status"
    );
    assert!(
        done(folder.path(), "--help").contains("No light is"),
        "--help tells that no light is chosen"
    );
    assert!(
        done(folder.path(), "generate --help").contains("1600000"),
        "generate --help tells the default"
    );
    assert_eq!(
        done(folder.path(), "--version").trim(),
        concat!("catoptric ", env!("CARGO_PKG_VERSION")),
        "the version"
    );
}

fn generate_asks_first() {
    let folder = room();
    for place in ["room.toml", "room.toml/in"] {
        let said = refused(
            folder.path(),
            &format!("generate sphere -o {place} --points 4000000"),
            2,
        );
        assert!(
            said.contains("room.toml is a file") && said.contains("another place"),
            "{said}"
        );
    }
    let output = run(folder.path(), "generate sphere -o a/b --points 100");
    assert_eq!(
        (output.status.code(), stderr(&output).as_str()),
        (
            Some(0),
            "catoptric: wrote a/b/sphere.ply and a/b/sphere.toml\n"
        )
    );
    assert_eq!(
        names(&folder.path().join("a/b")),
        ["sphere.ply", "sphere.toml"]
    );
}

fn info_counts_and_plans() {
    let folder = room();
    let text = done(folder.path(), "info room.toml");
    for word in [
        "20000",
        "mirror",
        "[-1, -1, -3] to [1, 1, 1]",
        "what runs",
        "splat",
        "shade",
        "skipped",
        "up axis      y",
    ] {
        assert!(text.contains(word), "info lacks {word:?}: {text}");
    }
    let info: Value = serde_json::from_str(&done(
        folder.path(),
        "info room.toml --json --set splat.size=2",
    ))
    .expect("JSON");
    assert_eq!(info["facts"]["points"], 20_000, "{info}");
    assert_eq!(info["settings"]["splat.size"], 2.0, "{info}");
    assert_eq!(info["plan"][0]["stage"], "splat", "{info}");
    assert!(
        info["facts"]["mirror_points"].as_u64() > Some(500),
        "{info}"
    );
}

fn info_lists_every_setting() {
    let folder = room();
    let text = done(folder.path(), "info --settings");
    let listed: Value =
        serde_json::from_str(&done(folder.path(), "info --settings --json")).expect("JSON");
    let described = catoptric::settings::Settings::describe();
    assert_eq!(
        listed.as_array().map(Vec::len),
        Some(described.len()),
        "{listed}"
    );
    for description in described {
        assert!(
            text.contains(&format!("{} = {}", description.key, description.default)),
            "{} is missing",
            description.key
        );
        assert!(
            text.contains(&description.doc),
            "the doc of {} is missing",
            description.key
        );
    }
}
