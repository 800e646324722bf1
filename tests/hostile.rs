//! Scene files that are damaged, by accident or on purpose.

use catoptric::scene::Scene;
use libtest_mimic::Trial;
use proptest::prelude::*;
use proptest::strategy::ValueTree as _;
use proptest::test_runner::TestRunner;

use crate::scene::{EVERY_KEY, parse};
use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "hostile::damaged_scene_files_never_panic",
            damaged_scene_files_never_panic,
        ),
        claim(
            "hostile::hostile_scene_files_are_sentences",
            hostile_scene_files_are_sentences,
        ),
    ]
}

/// Cuts, repeats and swaps pieces of a sound scene, and puts other pieces in.
fn damaged_scene_files_never_panic() {
    let pieces = [
        "[",
        "]",
        "[[",
        "]]",
        "=",
        "\"",
        "'''",
        ".",
        "\n",
        "nan",
        "-inf",
        "1e400",
        "-1",
        "0",
        "{",
        "}",
        ",",
        "\u{0}",
        "\u{1b}",
        "1979-05-27",
        "9223372036854775808",
        "0xff",
        "[[cloud]]\n",
        "[settings]\n",
        "format = 1\n",
        "\u{feff}",
        "é",
    ];
    let edit = (
        0..EVERY_KEY.len(),
        0..40usize,
        0..pieces.len(),
        any::<bool>(),
    );
    let mut sentences = 0;
    let mut runner = TestRunner::deterministic();
    let edits = proptest::collection::vec(edit, 1..4);
    for _ in 0..2000 {
        let edits = edits.new_tree(&mut runner).expect("edits").current();
        let mut text = EVERY_KEY.as_bytes().to_vec();
        for (at, cut, piece, keep) in edits {
            let at = at.min(text.len());
            let end = if keep { at } else { (at + cut).min(text.len()) };
            text.splice(at..end, pieces[piece].bytes());
        }
        let text = String::from_utf8_lossy(&text);
        if let Err(e) = parse(&text) {
            sentences += 1;
            let message = e.to_string();
            assert!(
                !message.is_empty() && !message.contains('\n'),
                "{message:?}"
            );
        }
    }
    assert!(
        sentences > 1000,
        "only {sentences} of 2000 damaged files were refused"
    );
}

fn hostile_scene_files_are_sentences() {
    let deep = format!("format = 1\na = {}", "[".repeat(200_000));
    let dotted = format!("format = 1\n{}a = 1", "a.".repeat(100_000));
    let tables = format!("format = 1\n[{}a]\n", "a.".repeat(100_000));
    let inline = format!("format = 1\nx = {}", "{ a = ".repeat(100_000));
    for text in [deep, dotted, tables, inline] {
        let refusal = parse(&text).expect_err("no scene");
        assert!(
            refusal.to_string().len() < 400,
            "a message of {} bytes",
            refusal.to_string().len()
        );
    }
    for path in [".", "/dev/null", "missing.toml", "/dev/zero"] {
        let copy = std::env::temp_dir().join("catoptric-hostile.toml");
        let _ = std::fs::remove_file(&copy);
        #[cfg(unix)]
        std::os::unix::fs::symlink(path, &copy).expect("a link");
        assert!(Scene::open(&copy, &[]).is_err(), "{path} is no scene");
        let _ = std::fs::remove_file(&copy);
    }
}
