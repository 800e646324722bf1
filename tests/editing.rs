//! Editing scenes: shown anew without reading their files again.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use catoptric::Job;
use catoptric::cloud::generate::Shape;
use catoptric::cloud::{Bounds, ColourBy, MirrorRule, Select};
use catoptric::scene::{LoadedScene, MirrorShape, PointCache, Scene};
use glam::{DMat4, DVec3, Vec3};
use libtest_mimic::Trial;

use crate::scene::set;
use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim("editing::a_clip_box_is_exact", a_clip_box_is_exact),
        claim(
            "editing::a_hidden_cloud_is_not_read",
            a_hidden_cloud_is_not_read,
        ),
        claim(
            "editing::normals_turn_to_the_viewpoint_of_their_cloud",
            viewpoints,
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

/// Nine points at whole coordinates from 0 to 2, classes 2 and 6, and 40, which the standard does not name.
pub(crate) const GRID: &str = "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\nproperty float z\n\
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

pub(crate) fn load(scene: &Scene) -> LoadedScene {
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

fn viewpoints() {
    let (_folder, path) = grid_scene("");
    let up = |z: f64| {
        let viewpoint = set(&format!("cloud.0.viewpoint=[1,1,{z}]"));
        let loaded = load(&Scene::open(&path, &[viewpoint]).expect("a scene"));
        let normals = loaded.surfels.finishes.iter().map(|f| f.normal().z);
        normals.map(|z| z.signum()).sum::<f32>()
    };
    assert_eq!((up(5.0), up(-5.0)), (9.0, -9.0));
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
