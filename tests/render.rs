//! The program renders: which files it writes, and what is in them.

use std::path::{Path, PathBuf};

use catoptric::output::ExrImage;
use libtest_mimic::Trial;
use serde_json::Value;

use crate::program::{ROOM, done, json, names, refused, room, run, stderr};
use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    let scans = std::env::var_os("CATOPTRIC_SCANS").map(PathBuf::from);
    let no_scans = scans.is_none();
    vec![
        claim(
            "render::a_scene_becomes_every_kind_of_file",
            a_scene_becomes_files,
        ),
        claim(
            "render::the_same_scene_gives_the_same_bytes",
            the_same_bytes,
        ),
        claim(
            "render::flags_beat_set_which_beats_the_file",
            flags_beat_set,
        ),
        claim(
            "render::the_heat_of_the_search_is_layers_or_a_picture_and_changes_nothing",
            the_heat_of_the_search,
        ),
        claim("render::a_picture_can_go_to_stdout", a_picture_to_stdout),
        claim(
            "render::a_picture_without_a_name_is_called_after_its_scene",
            an_unnamed_picture,
        ),
        claim(
            "render::generate_writes_a_scene_that_renders",
            generate_writes_a_scene,
        ),
        claim("render::mirrors_are_put_into_a_cloud", mirrors_are_put_in),
        Trial::test("render::scans_render_without_a_scene", move || {
            scans_render(scans.as_deref().unwrap_or(Path::new("")));
            Ok(())
        })
        .with_ignored_flag(no_scans),
    ]
}

fn the_heat_of_the_search() {
    let folder = room();
    let at = |name: &str| folder.path().join(name);
    let render = "render room.toml --backend cpu --set sscr.search=interleaved";
    done(folder.path(), &format!("{render} -o plain.png"));
    done(
        folder.path(),
        &format!("{render} -o a.png --search-heat h.exr --report r.json"),
    );
    done(folder.path(), &format!("{render} --search-heat h.png"));
    assert_eq!(
        names(folder.path()),
        [
            "a.png",
            "h.exr",
            "h.png",
            "plain.png",
            "r.json",
            "room.toml"
        ],
        "and nothing else"
    );
    let bytes = |name: &str| std::fs::read(at(name)).expect("a picture");
    assert_eq!(
        bytes("a.png"),
        bytes("plain.png"),
        "the picture is the same"
    );

    let heat = ExrImage::decode(&bytes("h.exr")).expect("layers");
    let of = |name: &str| &heat.channels[name];
    assert_eq!(heat.channels.len(), 4, "{:?}", heat.channels.keys());
    let sum = |name: &str| of(name).iter().map(|&v| f64::from(v)).sum::<f64>();
    let report = json(&at("r.json"));
    let hit = report["sscr"][0]["points_hit"].as_f64();
    assert_eq!(Some(sum("count.V")), hit, "every point found: {report}");
    assert!(sum("misses.V") > 100.0, "{} misses", sum("misses.V"));
    for (i, &found) in of("count.V").iter().enumerate() {
        let (steps, residual) = (of("steps.V")[i], of("residual.V")[i]);
        assert!((0.0..=24.0).contains(&steps), "{steps} steps");
        assert!(residual >= 0.0 && (found > 0.0 || residual + steps == 0.0));
    }
    let picture = image::open(at("h.png")).expect("a picture").to_rgb8();
    assert_eq!(picture.dimensions(), (192, 48), "three side by side");
    for panel in 0..3 {
        let part = |x: u32| x / 64 == panel;
        let lit = picture
            .enumerate_pixels()
            .filter(|p| part(p.0) && p.2.0 != [0; 3]);
        assert!(lit.count() > 100, "panel {panel} shows the ball");
    }
    for (arguments, status, says) in [
        (
            "--set reflect.method=ray_trace --search-heat h.exr",
            2,
            "sscr",
        ),
        (
            "--set sscr.search=guided --search-heat h.exr",
            2,
            "interleaved",
        ),
        ("--search-heat h.jpg", 2, ".png or .exr"),
        ("-o h.exr --search-heat h.exr", 2, "both write"),
    ] {
        let said = refused(folder.path(), &format!("{render} {arguments}"), status);
        assert!(said.contains(says), "{arguments}: {said}");
    }
}

fn a_scene_becomes_files() {
    let folder = room();
    let at = |name: &str| folder.path().join(name);
    done(
        folder.path(),
        "render room.toml --backend cpu -o a.png --gbuffer g.exr --camera-json c.json --report r.json",
    );
    done(folder.path(), "render room.toml --backend cpu -o a.exr");
    assert_eq!(
        names(folder.path()),
        ["a.exr", "a.png", "c.json", "g.exr", "r.json", "room.toml"],
        "and nothing else"
    );
    let image = image::open(at("a.png")).expect("a picture").to_rgb8();
    assert_eq!(image.dimensions(), (64, 48), "the size of the scene");
    assert!(
        image.pixels().any(|p| p.0.iter().any(|&c| c > 64)),
        "the picture shows something"
    );
    let report = json(&at("r.json"));
    assert_eq!(
        (&report["format"], &report["backend"]),
        (&Value::from(1), &Value::from("cpu")),
        "{report}"
    );
    assert_eq!(
        (&report["points"], &report["size"]),
        (&Value::from(20_000), &serde_json::json!([64, 48])),
        "{report}"
    );
    assert!(
        report["gbuffer"]["coverage_filled"].as_f64() > Some(0.99),
        "{report}"
    );
    assert_eq!(
        json(&at("c.json"))["size"],
        serde_json::json!([64, 48]),
        "the camera has the picture's size"
    );
}

fn the_same_bytes() {
    let folder = room();
    for name in ["a.png", "b.png"] {
        done(
            folder.path(),
            &format!("render room.toml --backend cpu -o {name}"),
        );
    }
    done(
        folder.path(),
        "render room.toml --backend cpu -o c.png --set splat.size=2",
    );
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).expect("a picture");
    assert!(
        bytes("a.png") == bytes("b.png"),
        "two runs of one scene differ"
    );
    assert!(
        bytes("a.png") != bytes("c.png"),
        "another setting makes another picture"
    );
}

fn flags_beat_set() {
    let folder = room();
    let size = |arguments: &str| {
        done(
            folder.path(),
            &format!("render room.toml --backend cpu --report r.json {arguments}"),
        );
        let report = json(&folder.path().join("r.json"));
        (report["size"][0].as_u64(), report["settings"].clone())
    };
    assert_eq!(size("").0, Some(64), "the file");
    assert_eq!(
        size("--set camera.size=32x24").0,
        Some(32),
        "--set beats the file"
    );
    assert_eq!(
        size("--size 16x12 --set camera.size=32x24").0,
        Some(16),
        "a flag beats --set"
    );
    let settings =
        size("--background #102030 --set image.background=transparent --set splat.fill=1").1;
    assert_eq!(settings["image.background"], "#102030", "{settings}");
    assert_eq!(settings["splat.fill"], 1, "{settings}");
    done(
        folder.path(),
        "render room.toml --backend cpu -o a.png --eye -0.5,0,0.9 --target 0,0,-1 --up 0,1,0 --fov 70",
    );
}

fn a_picture_to_stdout() {
    let folder = room();
    let output = run(
        folder.path(),
        "render room.toml --backend cpu -o /dev/stdout",
    );
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(
        output.stdout.starts_with(b"\x89PNG"),
        "{} bytes",
        output.stdout.len()
    );
    assert_eq!(names(folder.path()), ["room.toml"], "no file beside it");
}

fn an_unnamed_picture() {
    let folder = room();
    let output = run(folder.path(), "render room.toml --backend cpu");
    assert_eq!(
        names(folder.path()),
        ["room.png", "room.toml"],
        "{}",
        stderr(&output)
    );
    assert!(
        stderr(&output).contains("room.png"),
        "it says so: {}",
        stderr(&output)
    );
}

fn generate_writes_a_scene() {
    let folder = room();
    done(
        folder.path(),
        "generate plane -o deep/er --points 5000 --seed 3",
    );
    let made = folder.path().join("deep/er");
    assert_eq!(
        names(&made),
        ["plane.ply", "plane.toml"],
        "points and scene"
    );
    let first = std::fs::read(made.join("plane.ply")).expect("points");
    let info: Value = serde_json::from_str(&done(&made, "info plane.toml --json")).expect("JSON");
    assert_eq!(
        (&info["facts"]["points"], &info["lights"]),
        (&Value::from(5000), &Value::from(1)),
        "{info}"
    );
    done(
        &made,
        "render plane.toml --backend cpu --size 64x48 -o plane.png",
    );
    done(
        folder.path(),
        "generate plane -o deep/er --points 5000 --seed 4",
    );
    assert!(
        std::fs::read(made.join("plane.ply")).expect("points") != first,
        "another seed makes other points"
    );
}

fn mirrors_are_put_in() {
    let folder = room();
    let scene =
        format!("{ROOM}[[mirror]]\nshape = \"sphere\"\ncentre = [0.6, 0, -2]\nradius = 0.3\n");
    std::fs::write(folder.path().join("two.toml"), scene).expect("a scene");
    let mirrors = |name: &str| {
        let info: Value =
            serde_json::from_str(&done(folder.path(), &format!("info {name} --json")))
                .expect("JSON");
        info["facts"]["mirror_points"].as_f64().expect("a count")
    };
    let (one, two) = (mirrors("room.toml"), mirrors("two.toml"));
    // Points are spread by area, so spheres compare by the squares of their radii.
    let expected = one * (1.0 + (0.3f64 / 0.44).powi(2));
    assert!(
        (two / expected - 1.0).abs() < 0.05,
        "{one} mirror points became {two}, not {expected}"
    );
}

fn scans_render(scans: &Path) {
    let folder = room();
    for (name, points) in [
        ("autzen_trim_110k_8bitrgb.laz", 110_000),
        ("simple1_4_pdrf7_16bitrgb.las", 22_600),
        ("bunny_mesh.ply", 117_570),
    ] {
        let path = scans.join(name);
        let arguments = format!(
            "render {} --backend cpu --size 160x120 -o a.png --report r.json",
            path.display()
        );
        done(folder.path(), &arguments);
        let report = json(&folder.path().join("r.json"));
        assert_eq!(report["points"], points, "{name}");
        let coverage = report["gbuffer"]["coverage_filled"]
            .as_f64()
            .expect("a share");
        assert!(coverage > 0.1, "{name} covers {coverage} of the picture");
    }
}
