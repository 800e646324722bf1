//! `catoptric compare`.

use libtest_mimic::Trial;
use serde_json::Value;

use crate::program::{done, json, names, program, refused, room, stderr};
use crate::support::claim;

pub(super) fn tests() -> Vec<Trial> {
    vec![
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
            "measured::compare_tells_where_f32_and_f64_part",
            compare_tells_where_f32_and_f64_part,
        ),
    ]
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

fn compare_tells_where_f32_and_f64_part() {
    let folder = room();
    // Sums of such steps are exact in f32, so that no place lies on the edge of two pixels by rounding.
    let compare = "compare room.toml --backend cpu --repeats 1 --precision --set gi.vpl_count=0 --set sscr.initial_step=0.1875";
    let said = done(folder.path(), &format!("{compare} -o out"));
    assert!(
        said.contains("interleaved: f32 and f64 part for "),
        "{said}"
    );
    let report = json(&folder.path().join("out/compare.json"));
    let of = |name: &str| {
        let all = report["variants"].as_array().expect("variants");
        let variant = all.iter().find(|v| v["name"] == name);
        variant.expect("a variant")["precision"].clone()
    };
    let precision = of("interleaved");
    let number = |path: &str| precision.pointer(path).and_then(Value::as_f64);
    assert_eq!(
        number("/offered"),
        Some(20_000.0),
        "every point: {precision}"
    );
    let [single, double] = ["/hit_f32", "/hit_f64"].map(|p| number(p).expect("a count"));
    assert!(
        single > 2000.0 && (single / double - 1.0).abs() < 0.002,
        "{precision}"
    );
    let median = number("/apart_px/median").expect("a number");
    assert!(
        0.0 < median && median < 1e-3,
        "they are neither one search nor two others: {precision}"
    );
    assert!(
        of("guided").is_null() && of("ray_trace").is_null(),
        "only the interleaved search has it"
    );
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).expect("a page");
    assert!(page.contains("Where f32 and f64 part"));

    let guided = format!("{compare} --variant a:sscr.search=guided");
    assert!(refused(folder.path(), &guided, 2).contains("sscr.search=interleaved"));
}
