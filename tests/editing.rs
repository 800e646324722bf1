//! Editing scenes: written and read back, and shown anew without reading their files again.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use catoptric::Job;
use catoptric::cloud::generate::Shape;
use catoptric::cloud::{Bounds, ColourBy, MirrorRule, Select};
use catoptric::scene::{CloudSource, LoadedScene, MirrorShape, PointCache, Scene};
use glam::{DMat4, DVec2, DVec3, Vec3};
use libtest_mimic::Trial;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

use crate::scene::{EVERY_KEY, parse, set};
use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "editing::a_scene_that_is_written_is_read_back_whole",
            written_and_read_back,
        ),
        claim(
            "editing::any_scene_that_is_written_is_read_back",
            any_scene_is_read_back,
        ),
        claim(
            "editing::what_has_not_changed_keeps_its_comments",
            comments_stay,
        ),
        claim(
            "editing::entries_keep_their_comments_wherever_they_go",
            entries_keep_their_comments,
        ),
        claim(
            "editing::a_scene_that_needs_more_than_its_file_keeps_it",
            needs_more_than_its_file,
        ),
        claim(
            "editing::a_scene_saved_elsewhere_names_the_same_files",
            saved_elsewhere,
        ),
        claim("editing::a_clip_box_is_exact", a_clip_box_is_exact),
        claim(
            "editing::a_hidden_cloud_is_not_read",
            a_hidden_cloud_is_not_read,
        ),
        claim(
            "editing::points_are_coloured_by_what_is_asked_for",
            coloured_by,
        ),
        claim(
            "editing::an_edit_shows_what_a_fresh_reading_shows",
            edits_are_as_fresh,
        ),
        claim(
            "editing::a_file_that_has_changed_is_read_again",
            changed_files,
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

/// Nine points at whole coordinates from 0 to 2, classes 2 and 6, and 40, which the standard does not name.
const GRID: &str = "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\nproperty float z\n\
                    property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar classification\nend_header\n\
                    0 0 0 255 0 0 2\n1 0 0 255 0 0 2\n2 0 0 255 0 0 2\n0 1 0 255 0 0 6\n1 1 0 255 0 0 6\n2 1 0 255 0 0 6\n\
                    0 2 0 255 0 0 40\n1 2 0 255 0 0 40\n2 2 0 255 0 0 40\n";

/// A scene of the nine points, in a folder of its own.
fn grid_scene(more: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("grid.ply"), GRID).expect("a cloud");
    let path = folder.path().join("scene.toml");
    let text = format!("format = 1\n[[cloud]]\npath = \"grid.ply\"\n{more}");
    std::fs::write(&path, text).expect("a scene");
    (folder, path)
}

fn load(scene: &Scene) -> LoadedScene {
    scene.load(&Job::default()).expect("points")
}

fn a_clip_box_is_exact() {
    let (_folder, path) =
        grid_scene("[[mirror]]\nshape = \"sphere\"\ncentre = [9, 9, 9]\nradius = 1\n");
    let points = |sets: &[&str]| {
        let sets: Vec<_> = sets.iter().map(|text| set(text)).collect();
        let loaded = load(&Scene::open(&path, &sets).expect("a scene"));
        let mirrors = loaded.facts.clouds[1].points;
        assert!(mirrors > 0, "mirrors stay whole");
        (loaded.facts.clouds[0].points, loaded)
    };
    assert_eq!(points(&[]).0, 9);
    let (count, loaded) = points(&["clip.min=1,1,-1", "clip.max=2,2,1"]);
    assert_eq!(count, 4, "borders are in the box");
    let sources: std::collections::BTreeSet<u32> = loaded.surfels.source.iter().copied().collect();
    let kept: Vec<u32> = sources.into_iter().take(4).collect();
    assert_eq!(kept, [4, 5, 7, 8], "points keep their places in the file");
    assert_eq!(points(&["clip.max=1.5,9,9"]).0, 6, "one side alone");
    let scene = Scene::open(&path, &[set("clip.min=5,5,5")]).expect("a scene");
    let lone = Scene {
        mirrors: Vec::new(),
        ..scene
    };
    let refusal = lone.load(&Job::default()).expect_err("nothing is left");
    let refusal = refusal.to_string();
    assert!(refusal.contains("clip box leaves none of 9"), "{refusal}");
    let wrong = Scene::open(&path, &[set("clip.min=1,1,1"), set("clip.max=0,2,2")]);
    let wrong = wrong.expect_err("nothing can be in it").to_string();
    assert!(wrong.contains("clip.max is below clip.min"), "{wrong}");
}

fn a_hidden_cloud_is_not_read() {
    let (_folder, path) = grid_scene("[[cloud]]\npath = \"missing.las\"\nvisible = false\n");
    assert_eq!(
        load(&Scene::open(&path, &[]).expect("a scene"))
            .facts
            .points,
        9
    );
    let seen = Scene::open(&path, &[set("cloud.1.visible=true")]).expect("a scene");
    let missing = seen.load(&Job::default()).expect_err("no such file");
    assert!(missing.to_string().contains("missing.las"), "{missing}");
    let none = Scene::open(&path, &[set("cloud.0.visible=false")]).expect("a scene");
    let none = none.load(&Job::default()).expect_err("nothing is shown");
    assert!(none.to_string().contains("make one visible"), "{none}");
}

fn coloured_by() {
    let (_folder, path) = grid_scene("");
    let colours = |word: &str| {
        let scene = Scene::open(&path, &[set(&format!("cloud.0.colour={word}"))]);
        let loaded = scene.expect("a scene").load(&Job::default());
        loaded.map(|loaded| {
            let mut colours = vec![Vec3::ZERO; 9];
            for (finish, source) in loaded.surfels.finishes.iter().zip(&loaded.surfels.source) {
                colours[*source as usize] = finish.albedo();
            }
            colours
        })
    };
    let own = colours("rgb").expect("colours");
    assert!(own.iter().all(|c| c.abs_diff_eq(Vec3::X, 1e-4)), "{own:?}");
    assert_eq!(colours("auto").expect("colours"), own);
    let class = colours("class").expect("classes");
    assert!(class[0].x > class[0].z, "ground is brown: {}", class[0]);
    assert!(
        class[3].x > 2.0 * class[3].y,
        "houses are red: {}",
        class[3]
    );
    assert_eq!(
        (class[0], class[3]),
        (class[2], class[5]),
        "a class has one colour"
    );
    assert!(class[6] != class[0] && class[6] != class[3], "{}", class[6]);
    // All of one height.
    let height = colours("height").expect("heights");
    assert!(height.iter().all(|c| *c == height[0]), "{height:?}");
    let grey = colours("intensity").expect_err("none is there").to_string();
    assert!(
        grey.contains("no intensities") && grey.contains("auto"),
        "{grey}"
    );
}

/// What was done, step by step.
fn steps(scene: &Scene, cache: &mut PointCache) -> (LoadedScene, Vec<String>) {
    let steps = Arc::new(Mutex::new(Vec::new()));
    let heard = Arc::clone(&steps);
    let job = Job::with_listener(move |progress| {
        heard
            .lock()
            .expect("a list")
            .push(progress.step.to_string());
    });
    let loaded = scene.load_with(cache, &job).expect("points");
    let steps = steps.lock().expect("a list").clone();
    (loaded, steps)
}

fn reads(steps: &[String]) -> bool {
    let slow = ["reading", "generating points", "finding neighbours"];
    steps.iter().any(|step| slow.contains(&step.as_str()))
}

fn edits_are_as_fresh() {
    let (_folder, path) = grid_scene("[[cloud]]\ngenerate = \"sphere\"\npoints = 3000\n");
    let mut scene = Scene::open(&path, &[]).expect("a scene");
    let mut cache = PointCache::for_editing();
    let (_, first) = steps(&scene, &mut cache);
    assert!(reads(&first), "{first:?}");
    let ball = Shape::Sphere {
        centre: DVec3::new(1.0, 1.0, 1.0),
        radius: 0.5,
    };
    let everywhere = Select::Box {
        min: DVec3::splat(-0.5),
        max: DVec3::splat(1.5),
    };
    type Edit = Box<dyn Fn(&mut Scene)>;
    let edits: Vec<(&str, bool, Edit)> = vec![
        ("hide", false, Box::new(|s| s.clouds[0].visible = false)),
        ("show", false, Box::new(|s| s.clouds[0].visible = true)),
        (
            "colour",
            false,
            Box::new(|s| s.clouds[0].colour = ColourBy::Class),
        ),
        (
            "clip",
            false,
            Box::new(|s| {
                s.clip = Some(Bounds {
                    min: DVec3::splat(-1.0),
                    max: DVec3::ONE,
                });
            }),
        ),
        (
            "mark",
            false,
            Box::new(move |s| {
                s.clouds[1].mirrors.push(MirrorRule {
                    select: everywhere.clone(),
                    reflectance: 0.5,
                });
            }),
        ),
        // A new mirror is sampled, at a spacing that is known.
        (
            "mirror",
            true,
            Box::new(move |s| s.mirrors.push(MirrorShape::Shape(ball.clone()))),
        ),
        // A cloud that moves has another place, radii and normals.
        (
            "move",
            true,
            Box::new(|s| s.clouds[0].transform = Some(DMat4::from_translation(DVec3::X))),
        ),
    ];
    for (what, may_read, edit) in edits {
        edit(&mut scene);
        let (edited, done) = steps(&scene, &mut cache);
        let fresh = load(&scene);
        assert!(may_read || !reads(&done), "{what}: {done:?}");
        assert!(
            edited.surfels == fresh.surfels,
            "{what} shows something else"
        );
        assert_eq!(edited.camera, fresh.camera, "{what}");
    }
}

fn changed_files() {
    let (folder, path) = grid_scene("");
    let scene = Scene::open(&path, &[]).expect("a scene");
    let mut cache = PointCache::for_editing();
    assert_eq!(steps(&scene, &mut cache).0.facts.points, 9);
    let fewer = GRID
        .replace("vertex 9", "vertex 8")
        .replace("2 2 0 255 0 0 40\n", "");
    std::fs::write(folder.path().join("grid.ply"), fewer).expect("a cloud");
    let (loaded, done) = steps(&scene, &mut cache);
    assert_eq!(loaded.facts.points, 8);
    assert!(reads(&done), "{done:?}");
    let classes = &loaded.facts.clouds[0].classes;
    assert_eq!(classes.get(&6), Some(&3), "an editor is told of classes");
}
