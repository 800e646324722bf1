//! Scenes that are written: read back as they were, over a person's own text.

use std::path::Path;

use catoptric::cloud::generate::Shape;
use catoptric::cloud::{Bounds, ColourBy};
use catoptric::scene::{CloudSource, MirrorShape, Scene};
use glam::{DVec2, DVec3, Vec3};
use libtest_mimic::Trial;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

use crate::editing::{GRID, load};
use crate::scene::{EVERY_KEY, parse};
use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "written::a_scene_that_is_written_is_read_back_whole",
            written_and_read_back,
        ),
        claim(
            "written::any_scene_that_is_written_is_read_back",
            any_scene_is_read_back,
        ),
        claim(
            "written::what_has_not_changed_keeps_its_comments",
            comments_stay,
        ),
        claim(
            "written::entries_keep_their_comments_wherever_they_go",
            entries_keep_their_comments,
        ),
        claim(
            "written::a_scene_that_needs_more_than_its_file_keeps_it",
            needs_more_than_its_file,
        ),
        claim(
            "written::a_scene_saved_elsewhere_names_the_same_files",
            saved_elsewhere,
        ),
    ]
}

/// All that a scene says, for comparison.
fn said(scene: &Scene) -> String {
    let mut scene = scene.clone();
    // Where the camera was written is not part of it.
    let camera = std::mem::replace(&mut scene.camera, parse(EVERY_KEY).expect("sound").camera);
    let camera = (
        camera.position,
        camera.target,
        camera.up,
        camera.fov_y_degrees,
        (camera.near, camera.far, camera.size),
    );
    format!("{scene:#?} {camera:?}")
}

fn written_and_read_back() {
    let clipped = format!("{EVERY_KEY}\n[clip]\nmin = [0, 0.25, -1]\n");
    let hidden = EVERY_KEY.replacen(
        "seed = 7",
        "seed = 7\ncolour = \"height\"\nvisible = false",
        1,
    );
    for text in [EVERY_KEY, &clipped, &hidden] {
        let scene = parse(text).expect("a sound scene");
        let path = Path::new("dir/room.toml");
        let alone = scene.to_toml(path, None).expect("a text");
        let read = Scene::parse(&alone, path, &[]).expect(&alone);
        assert_eq!(said(&read), said(&scene), "{alone}");
        assert_eq!(
            scene.to_toml(path, Some(text)).expect("a text"),
            *text,
            "nothing has changed"
        );
    }
    assert_ne!(
        said(&parse(EVERY_KEY).expect("sound")),
        said(&parse(&clipped).expect("sound")),
        "a clip box is seen"
    );
}

fn any_scene_is_read_back() {
    let number = || prop_oneof![-1e7..1e7_f64, -1.0..1.0_f64, Just(0.0)];
    let point = move || [number(), number(), number()].prop_map(DVec3::from_array);
    let direction = || {
        ([-1.0..1.0_f64, -1.0..1.0, -1.0..1.0])
            .prop_map(DVec3::from_array)
            .prop_filter_map("a direction", DVec3::try_normalize)
    };
    let length = || prop_oneof![1e-6..1e6_f64, 0.01..10.0_f64];
    let plane = (point(), direction(), length(), length()).prop_map(|(centre, normal, x, y)| {
        Shape::Plane {
            centre,
            normal,
            up: normal.any_orthonormal_vector(),
            size: DVec2::new(x, y),
        }
    });
    let paraboloid =
        (point(), direction(), length(), length()).prop_map(|(vertex, axis, focal, rim)| {
            Shape::Paraboloid {
                vertex,
                axis,
                focal_length: focal,
                rim_radius: rim,
            }
        });
    let sphere = (point(), length()).prop_map(|(centre, radius)| Shape::Sphere { centre, radius });
    let mirrors = prop::collection::vec(prop_oneof![plane, paraboloid, sphere], 0..4);
    let clip = prop::option::of((point(), point()));
    let light = (0.1_f64..80.0, 0.0_f64..1.0, 0.0_f32..100.0);
    let everything = (mirrors, clip, light, 0_usize..5, any::<bool>());
    let mut runner = TestRunner::new(Config {
        failure_persistence: None,
        ..Config::with_cases(200)
    });
    let base = parse(EVERY_KEY).expect("a sound scene");
    let checked = runner.run(&everything, |(mirrors, clip, light, colour, visible)| {
        let mut scene = base.clone();
        scene.mirrors = mirrors.into_iter().map(MirrorShape::Shape).collect();
        scene.clip = clip.map(|(a, b)| Bounds {
            min: a.min(b),
            max: a.max(b),
        });
        let (outer, inner, intensity) = light;
        scene.lights[0].outer_angle = outer.to_radians();
        scene.lights[0].inner_angle = (outer * inner).to_radians();
        scene.lights[0].intensity = Vec3::splat(intensity);
        scene.clouds[1].colour = ColourBy::ALL[colour];
        scene.clouds[0].visible = visible;
        let path = Path::new("dir/room.toml");
        for like in [None, Some(EVERY_KEY)] {
            let text = scene.to_toml(path, like).expect("a text");
            let mut read = Scene::parse(&text, path, &[]).expect(&text);
            // Half angles may be off by the last bit: degrees do not reach every radian.
            let (light, own) = (&mut read.lights[0], &scene.lights[0]);
            prop_assert!((light.inner_angle - own.inner_angle).abs() < 1e-15);
            prop_assert!((light.outer_angle - own.outer_angle).abs() < 1e-15);
            (light.inner_angle, light.outer_angle) = (own.inner_angle, own.outer_angle);
            prop_assert_eq!(said(&read), said(&scene), "{}", text);
        }
        Ok(())
    });
    checked.expect("read back");
}

fn comments_stay() {
    let text = "# The hall.\nformat = 1\n\n# As scanned in May.\n[[cloud]]\ngenerate = \"sphere\" # a ball\n\
                points = 1000\n\n# The left mirror.\n[[mirror]]\nshape = \"sphere\"\ncentre = [0, 0, 1]\nradius = 1 # metres\n\n\
                # The right mirror.\n[[mirror]]\nshape = \"sphere\"\ncentre = [5, 0, 1]\nradius = 1\n\n[settings]\n# Large.\nsplat.size = 2\n";
    let path = Path::new("dir/room.toml");
    let mut scene = Scene::parse(text, path, &[]).expect("a sound scene");
    let MirrorShape::Shape(Shape::Sphere { radius, .. }) = &mut scene.mirrors[1] else {
        panic!("a ball");
    };
    *radius = 2.5;
    let written = scene.to_toml(path, Some(text)).expect("a text");
    for comment in [
        "# The hall.",
        "# As scanned in May.",
        "# a ball",
        "# The left mirror.",
        "radius = 1 # metres",
        "# The right mirror.",
        "radius = 2.5",
        "# Large.",
    ] {
        assert!(written.contains(comment), "{comment} is gone:\n{written}");
    }
    scene.mirrors.clear();
    let written = scene.to_toml(path, Some(text)).expect("a text");
    assert!(!written.contains("[[mirror]]"), "{written}");
    assert!(written.contains("# As scanned in May."), "{written}");
}

fn entries_keep_their_comments() {
    let text = "format = 1\r\n# The hall.\r\n[[cloud]]\r\npath = \"hall.laz\" # May\r\nvisible = true # for now\r\n\r\n\
                # The garden.\r\n[[cloud]]\r\npath = \"garden.laz\"\r\n\r\n# The roof.\r\n[[cloud]]\r\npath = \"roof.laz\" # June\r\n\r\n\
                # [[light]] is to come.\r\n[camera]\r\nposition = [1, 2, 3] # the door\r\n";
    let path = Path::new("dir/room.toml");
    let mut scene = Scene::parse(text, path, &[]).expect("a sound scene");
    assert_eq!(scene.to_toml(path, Some(text)).expect("a text"), text);
    scene.clouds[0].visible = false;
    scene.clouds.remove(1);
    scene.camera.position = Some(DVec3::new(4.0, 5.0, 6.0));
    let written = scene.to_toml(path, Some(text)).expect("a text");
    let at = |what: &str| {
        written
            .find(what)
            .unwrap_or_else(|| panic!("no {what} in\n{written}"))
    };
    assert!(at("# The hall.") < at("hall.laz") && at("# May") < at("# The roof."));
    assert!(at("visible = false # for now") < at("# The roof."));
    assert!(at("# The roof.") < at("roof.laz\" # June"));
    assert!(at("# [[light]] is to come.") < at("[camera]"));
    assert!(at("[4.0, 5.0, 6.0] # the door") > at("[camera]"));
    at("# The garden.");
    assert!(!written.contains("garden.laz"), "{written}");
    assert_eq!(
        written.matches('\n').count(),
        written.matches("\r\n").count(),
        "line ends stay"
    );
    let read = Scene::parse(&written, path, &[]).expect(&written);
    assert_eq!(said(&read), said(&scene), "{written}");
    // In one line, and nothing has changed.
    let short = "format = 1\ncloud = [{ path = \"a.ply\" }] # all\n";
    let same = Scene::parse(short, path, &[]).expect("a sound scene");
    assert_eq!(same.to_toml(path, Some(short)).expect("a text"), short);
}

fn needs_more_than_its_file() {
    let text = "# A bunny of my own.\nformat = 1\n[[cloud]]\ngenerate = \"bunny\"\n[[light]] # mine\nkind = \"point\"\n\
                position = [0, 1, 0]\nintensity = [1, 1, 1]\n";
    let path = Path::new("dir/room.toml");
    let mesh = catoptric::scene::Override::mesh(Path::new("dir/bunny.ply"), "--mesh dir/bunny.ply");
    let scene = Scene::parse(text, path, &[mesh]).expect("with a mesh");
    let written = scene.to_toml(path, Some(text)).expect("a text");
    assert!(written.contains("# A bunny of my own."), "{written}");
    let read = Scene::parse(&written, path, &[]).expect(&written);
    assert_eq!((read.clouds.len(), read.lights.len()), (1, 1));
    for broken in ["format = 1\n[[cloud", "title = \"a camera path\"\n"] {
        let refusal = scene.to_toml(path, Some(broken)).expect_err("no scene");
        assert!(refusal.to_string().contains("another name"), "{refusal}");
    }
}

fn saved_elsewhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let below = folder.path().join("scans");
    std::fs::create_dir(&below).expect("a folder");
    let cloud = below.join("small.ply");
    std::fs::write(&cloud, GRID).expect("a cloud");
    let scene = Scene::open(&cloud, &[]).expect("a scene of a cloud");
    for (path, named) in [
        (
            folder.path().join("hall.toml"),
            "\"scans/small.ply\"".to_owned(),
        ),
        (below.join("hall.toml"), "\"small.ply\"".to_owned()),
    ] {
        let read = scene.save(&path).expect("a file");
        let text = std::fs::read_to_string(&path).expect("a text");
        assert!(text.contains(&named), "{text}");
        assert_eq!(read.clouds[0].source, CloudSource::File(cloud.clone()));
        assert_eq!(load(&read).facts.points, 9);
    }
    // A second saving of what was edited since keeps a person's comment.
    let path = below.join("hall.toml");
    let text = std::fs::read_to_string(&path).expect("a text");
    std::fs::write(&path, format!("# Mine.\n{text}")).expect("a file");
    let mut scene = Scene::open(&path, &[]).expect("a scene");
    scene.clouds[0].colour = ColourBy::Height;
    scene.save(&path).expect("a file");
    let text = std::fs::read_to_string(&path).expect("a text");
    assert!(
        text.starts_with("# Mine.") && text.contains("height"),
        "{text}"
    );
}
