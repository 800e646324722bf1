//! Scene files and what is given on top of them: what is read, and how what is wrong is refused.

use std::path::{Path, PathBuf};

use catoptric::Error;
use catoptric::cloud::generate::Shape;
use catoptric::cloud::{Bounds, Select, UpAxis};
use catoptric::scene::{CloudSource, MirrorShape, Override, Scene, default_camera};
use glam::{DVec3, UVec2, Vec2};
use libtest_mimic::Trial;
use proptest::prelude::*;
use proptest::strategy::ValueTree as _;
use proptest::test_runner::TestRunner;

use crate::support::claim;

/// Every key of the format but those that exclude each other.
const EVERY_KEY: &str = r#"format = 1

[[cloud]]
path = "hall.laz"
up_axis = "z"
colour_bits = 8
transform = [2, 0, 0, 1,  0, 2, 0, 2,  0, 0, 2, 3,  0, 0, 0, 1]
material = { specular = 0.25, shininess = 40 }
[[cloud.mirror]]
property = "mirror"
reflectance = 0.5
[[cloud.mirror]]
classification = [7, 8]
[[cloud.mirror]]
box = { min = [0, 0, 0], max = [1, 1, 1] }
[[cloud.mirror]]
near_plane = { point = [0, 0, 1], normal = [0, 0, 2], distance = 0.02 }

[[cloud]]
generate = "multi"
points = 1000
seed = 7
mesh = "bunny.ply"

[[mirror]]
shape = "plane"
centre = [0, 0, -1]
normal = [0, 0, 1]
up = [0, 1, 0.5]
size = [0.8, 0.6]
[[mirror]]
shape = "sphere"
centre = [0, 0, -1.1]
radius = 0.44
[[mirror]]
shape = "paraboloid"
vertex = [0, 0, -1.3]
axis = [0, 0, 1]
focal_length = 0.25
rim_radius = 0.44
[[mirror]]
shape = "torus"
centre = [0, 0, -1.1]
axis = [0, -0.6, 0.8]
major_radius = 0.36
minor_radius = 0.13
[[mirror]]
shape = "blob"
centre = [0, 0, -1.1]
radius = 0.4
amplitude = 0.25
[[mirror]]
shape = "bumps"
centre = [0, 0, -1.1]
radius = 0.42
[[mirror]]
shape = "mesh"
path = "bunny.ply"

[[light]]
kind = "spot"
position = [-0.6, 0.9, 0.2]
target = [1, -1, -3]
intensity = [6, 6, 6]
inner_angle_degrees = 25
outer_angle_degrees = 35

[camera]
position = [0, 0, 0.9]
target = [0, 0, -1]
up = [0, 1, 0]
fov_y_degrees = 60
near = 0.05
far = 10
size = [800, 600]

[settings]
splat.size = 2.0
[settings.image]
exposure = 4
tone_map = "aces"
"#;

const CUBE: Bounds = Bounds {
    min: DVec3::NEG_ONE,
    max: DVec3::ONE,
};

const SMALL: &str = "format = 1\n[[cloud]]\ngenerate = \"sphere\"\n";

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "scene::every_documented_key_is_read",
            every_documented_key_is_read,
        ),
        claim(
            "scene::every_setting_is_accepted_in_the_file_and_on_top",
            every_setting_is_accepted,
        ),
        claim(
            "scene::paths_start_from_the_scene_file",
            paths_start_from_the_scene_file,
        ),
        claim(
            "scene::wrong_files_are_refused_with_line_and_remedy",
            wrong_files_are_refused,
        ),
        claim(
            "scene::what_is_given_on_top_beats_the_file",
            what_is_given_on_top_beats_the_file,
        ),
        claim(
            "scene::every_notation_of_a_value_is_understood",
            every_notation_is_understood,
        ),
        claim(
            "scene::wrong_overrides_name_the_nearest_right_key",
            wrong_overrides_are_refused,
        ),
        claim(
            "scene::every_table_has_keys_that_can_be_overridden",
            every_table_can_be_overridden,
        ),
        claim(
            "scene::a_mesh_goes_to_the_cloud_that_needs_one",
            a_mesh_goes_where_it_is_needed,
        ),
        claim(
            "scene::damaged_scene_files_never_panic",
            damaged_scene_files_never_panic,
        ),
        claim(
            "scene::hostile_scene_files_are_sentences",
            hostile_scene_files_are_sentences,
        ),
        claim(
            "scene::a_fitted_view_shows_all_of_the_bounds",
            a_fitted_view_shows_all,
        ),
        claim(
            "scene::a_partial_camera_is_completed",
            a_partial_camera_is_completed,
        ),
        claim(
            "scene::a_camera_that_cannot_see_is_refused_at_its_line",
            a_blind_camera_is_refused,
        ),
    ]
}

fn parse(text: &str) -> Result<Scene, Error> {
    Scene::parse(text, Path::new("dir/room.toml"), &[])
}

fn set(key_and_value: &str) -> Override {
    Override::parse(key_and_value, &format!("--set {key_and_value}")).expect("a key and a value")
}

fn with(text: &str, sets: &[&str]) -> Result<Scene, Error> {
    let overrides: Vec<Override> = sets.iter().map(|s| set(s)).collect();
    Scene::parse(text, Path::new("dir/room.toml"), &overrides)
}

fn sphere(radius: f64) -> MirrorShape {
    MirrorShape::Shape(Shape::Sphere {
        centre: DVec3::new(0.0, 0.0, -1.1),
        radius,
    })
}

fn every_documented_key_is_read() {
    let scene = parse(EVERY_KEY).expect("a sound scene");
    assert_eq!(
        (scene.clouds.len(), scene.mirrors.len(), scene.lights.len()),
        (2, 7, 1)
    );
    let hall = &scene.clouds[0];
    assert_eq!(hall.up_axis, Some(UpAxis::Z));
    assert_eq!((hall.specular, hall.shininess), (0.25, 40.0));
    let transform = hall.transform.expect("a transform");
    assert_eq!(
        transform.transform_point3(DVec3::ONE),
        DVec3::new(3.0, 4.0, 5.0),
        "rows, then columns"
    );
    assert_eq!(hall.mirrors.len(), 4);
    assert_eq!(hall.mirrors[0].reflectance, 0.5);
    let Select::NearPlane { normal, .. } = hall.mirrors[3].select else {
        panic!("got {:?}", hall.mirrors[3])
    };
    assert_eq!(normal, DVec3::Z, "normals become unit vectors");
    assert_eq!(scene.mirrors[1], sphere(0.44));
    assert!((scene.lights[0].outer_angle - 35f64.to_radians()).abs() < 1e-12);
    let camera = scene.camera(CUBE, UpAxis::Y).expect("a camera");
    assert_eq!(
        (camera.position, camera.near, camera.far),
        (DVec3::new(0.0, 0.0, 0.9), 0.05, 10.0)
    );
    assert_eq!(camera.size, UVec2::new(800, 600));
    assert_eq!(
        (scene.settings.splat.size, scene.settings.image.exposure),
        (2.0, 4.0)
    );
}

fn every_setting_is_accepted() {
    for description in catoptric::settings::Settings::describe() {
        let line = format!("{} = {}", description.key, description.default);
        parse(&format!("{SMALL}[settings]\n{line}\n"))
            .unwrap_or_else(|e| panic!("{line} in the file: {e}"));
        with(SMALL, &[&line.replace(" = ", "=")]).unwrap_or_else(|e| panic!("{line} on top: {e}"));
    }
}

fn paths_start_from_the_scene_file() {
    let scene = parse(EVERY_KEY).expect("a sound scene");
    assert_eq!(
        scene.clouds[0].source,
        CloudSource::File(PathBuf::from("dir/hall.laz"))
    );
    let scene = with(EVERY_KEY, &["cloud.0.path=other.ply"]).expect("a sound scene");
    assert_eq!(
        scene.clouds[0].source,
        CloudSource::File(PathBuf::from("other.ply")),
        "what the caller gives starts here"
    );
    let scene = Scene::open(Path::new("dir/scan.laz"), &[]).expect("a cloud is a scene");
    assert_eq!(
        scene.clouds[0].source,
        CloudSource::File(PathBuf::from("dir/scan.laz"))
    );
}

fn wrong_files_are_refused() {
    let cases: &[(&str, usize, &str)] = &[
        ("format = 1\n[[cloud]]\npth = \"a.ply\"\n", 3, "\"path\""),
        (
            "format = 1\n\n[[clouds]]\npath = \"a.ply\"\n",
            3,
            "\"cloud\"",
        ),
        ("format = 1\n[[cloud]]\npath = 7\n", 3, "a path in quotes"),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\ngenerate = \"sphere\"\n",
            4,
            "remove one",
        ),
        (
            "format = 1\n[[cloud]]\nup_axis = \"z\"\n",
            2,
            "needs a path",
        ),
        (
            "format = 1\n[[cloud]]\ngenerate = \"sphre\"\n",
            3,
            "did you mean \"sphere\"",
        ),
        ("format = 1\n[[cloud]]\ngenerate = \"bunny\"\n", 3, "--mesh"),
        (
            "format = 1\n[[cloud]]\ngenerate = \"sphere\"\npoints = -4\n",
            4,
            "from 1 to",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\npoints = 4\n",
            4,
            "generated",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\nup_axis = \"x\"\n",
            4,
            "\"y\" or \"z\"",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\ntransform = [1, 2]\n",
            4,
            "16 numbers",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\ntransform = [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n",
            4,
            "mirrors",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\ntransform = [1,0,0,0, 1,0,0,0, 0,0,1,0, 0,0,0,1]\n",
            4,
            "singular",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[[cloud.mirror]]\nreflectance = 1\n",
            4,
            "\"property\"",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[[cloud.mirror]]\nproperty = \"m\"\nreflectance = 1.5\n",
            6,
            "from 0 to 1",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\nmaterial = { specular = nan }\n",
            4,
            "from 0 to 1",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[[mirror]]\nshape = \"spere\"\n",
            5,
            "\"sphere\"",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[[mirror]]\nshape = \"sphere\"\ncentre = [0,0,0]\nradius = -1\n",
            7,
            "above 0",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[[mirror]]\nshape = \"sphere\"\naxis = [0,0,1]\n",
            6,
            "\"radius\"",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[[light]]\nkind = \"point\"\n",
            5,
            "\"spot\"",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[[light]]\nkind = \"spot\"\nposition = [0,0,0]\ntarget = [0,0,0]\n",
            7,
            "points at",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[[light]]\nkind = \"spot\"\nposition = [0,0]\n",
            6,
            "[x, y, z]",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[environment]\ncolour = [1,1,1]\n",
            4,
            "remove it",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[camera]\nposition = [0, inf, 0]\n",
            5,
            "from -1e15",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[camera]\nsize = [0, 600]\n",
            5,
            "from 1 to 32768",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[camera]\nfov = 60\n",
            5,
            "\"fov_y_degrees\"",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[settings]\nsplat.size = -2\n",
            5,
            "0.1 to 16",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[settings]\nsplat.sise = 2\n",
            5,
            "\"splat.size\"",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[settings.splat]\n\nfill = 1.5\n",
            6,
            "a whole number",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[settings.image]\ntone_map = \"acse\"\n",
            5,
            "\"aces\"",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[settings.image]\nbackground = \"red\"\n",
            5,
            "#rrggbb",
        ),
        ("format = 2\n", 1, "format = 1"),
        ("format = 1\n[[cloud]]\npath = \"a\n", 3, ""),
        (
            "format = 1\n[[cloud]]\ngenerate = \"sphere\"\nseed = 99999999999999999999\n",
            4,
            "63 bits",
        ),
    ];
    for (text, line, says) in cases {
        match parse(text) {
            Err(Error::Scene {
                line: got, problem, ..
            }) => {
                assert_eq!(got, Some(*line), "of {text:?}, which says {problem:?}");
                assert!(
                    problem.contains(says),
                    "{text:?} says {problem:?}, and not {says:?}"
                );
                assert!(!problem.contains('\n'), "{problem:?} is one line");
            }
            other => panic!("{text:?} gave {other:?}"),
        }
    }
    for text in ["", "format = 1\n"] {
        assert!(
            matches!(parse(text), Err(Error::Scene { line: None, .. })),
            "{text:?} gave {:?}",
            parse(text)
        );
    }
}

fn what_is_given_on_top_beats_the_file() {
    let scene = with(
        EVERY_KEY,
        &[
            "splat.size=3",
            "settings.image.exposure=2",
            "camera.size=640x480",
            "light.0.intensity=1,2,3",
            "cloud.1.seed=9",
            "cloud.0.material.specular=0.5",
            "cloud.0.mirror.0.reflectance=0.1",
            "mirror.1.radius=0.3",
            "splat.size=4",
        ],
    )
    .expect("a sound scene");
    assert_eq!(
        scene.settings.splat.size, 4.0,
        "the later beats the earlier"
    );
    assert_eq!(scene.settings.image.exposure, 2.0);
    assert_eq!(scene.camera.size, Some(UVec2::new(640, 480)));
    assert_eq!(scene.lights[0].intensity.to_array(), [1.0, 2.0, 3.0]);
    assert!(matches!(
        scene.clouds[1].source,
        CloudSource::Generated {
            seed: 9,
            points: 1000,
            ..
        }
    ));
    assert_eq!(
        (scene.clouds[0].specular, scene.clouds[0].shininess),
        (0.5, 40.0)
    );
    assert_eq!(scene.clouds[0].mirrors[0].reflectance, 0.1);
    assert_eq!(scene.mirrors[1], sphere(0.3));
}

fn every_notation_is_understood() {
    let size = |text: &str| {
        with(SMALL, &[&format!("camera.size={text}")])
            .expect(text)
            .camera
            .size
    };
    assert_eq!(size("800x600"), size("[800, 600]"));
    assert_eq!(size("800, 600"), size("[800, 600]"));
    let background = |text: &str| {
        with(SMALL, &[&format!("image.background={text}")])
            .expect(text)
            .settings
            .image
            .background
    };
    assert_eq!(background("#ff8000"), background("\"#ff8000\""));
    assert_eq!(background("transparent"), background("'transparent'"));
    let up = with(SMALL, &["cloud.0.up_axis=z"])
        .expect("a bare word")
        .clouds[0]
        .up_axis;
    assert_eq!(up, Some(UpAxis::Z));
    let eye = with(SMALL, &["camera.position=-1,0.5,1e3"])
        .expect("a bare array")
        .camera
        .position;
    assert_eq!(eye, Some(DVec3::new(-1.0, 0.5, 1000.0)));
}

fn wrong_overrides_are_refused() {
    let cases = [
        ("splat.sise=2", "\"splat.size\""),
        ("exposure=2", "\"image.exposure\""),
        ("camera.fov=60", "\"camera.fov_y_degrees\""),
        ("cloud.0.pth=a", "\"cloud.0.path\""),
        ("cloud.1.seed=4", "cloud.0 only"),
        ("light.0.intensity=1,1,1", "no light"),
        ("splat.size=big", "a number from 0.1 to 16"),
        ("splat.size=nan", "0.1 to 16"),
        ("camera.position=1,2", "[x, y, z]"),
        ("camera.size=0x600", "from 1 to 32768"),
        ("camera.position=99999999999999999999,0,0", "63 bits"),
        ("camera=3", "did you mean"),
        ("format=2", "did you mean"),
        ("cloud=[]", "did you mean"),
        (".=1", "did you mean"),
        ("cloud..path=1", "did you mean"),
        ("cloud.99999999999999999999.path=a", "cloud.0 only"),
    ];
    for (given, says) in cases {
        let refusal = Override::parse(given, &format!("--set {given}"))
            .and_then(|o| Scene::parse(SMALL, Path::new("room.toml"), &[o]));
        match refusal {
            Err(Error::Override {
                given: words,
                problem,
            }) => {
                assert_eq!(words, format!("--set {given}"));
                assert!(
                    problem.contains(says),
                    "{given:?} says {problem:?}, and not {says:?}"
                );
            }
            other => panic!("{given:?} gave {other:?}"),
        }
    }
    for given in ["splat.size", "=2", ""] {
        assert!(
            matches!(Override::parse(given, given), Err(Error::Override { .. })),
            "{given:?} is no key=value"
        );
    }
}

fn every_table_can_be_overridden() {
    for key_and_value in [
        "cloud.0.transform=[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]",
        "cloud.0.colour_bits=auto",
        "cloud.0.mirror.1.classification=9",
        "cloud.0.mirror.1.classification=[9]",
        "cloud.0.mirror.2.box.max=2,2,2",
        "cloud.0.mirror.3.near_plane.distance=0.5",
        "cloud.1.generate=multi",
        "cloud.1.mesh=\"rabbit.ply\"",
        "mirror.0.up=1,0,0",
        "mirror.2.focal_length=0.5",
        "mirror.3.minor_radius=0.1",
        "mirror.4.amplitude=0.1",
        "mirror.6.path=rabbit.ply",
        "light.0.kind=spot",
        "light.0.outer_angle_degrees=40",
        "camera.up=0,0,1",
        "camera.near=0.1",
    ] {
        let read = with(EVERY_KEY, &[key_and_value]);
        if key_and_value == "cloud.0.mirror.1.classification=9" {
            assert!(read.is_err(), "one class is no list of classes");
        } else {
            read.unwrap_or_else(|e| panic!("{key_and_value}: {e}"));
        }
    }
}

fn a_mesh_goes_where_it_is_needed() {
    let mesh = [Override::mesh(Path::new("rabbit.ply"), "--mesh rabbit.ply")];
    let bunny = "format = 1\n[[cloud]]\npath = \"a.ply\"\n[[cloud]]\ngenerate = \"bunny\"\n";
    let scene = Scene::parse(bunny, Path::new("room.toml"), &mesh).expect("a sound scene");
    assert!(
        matches!(&scene.clouds[1].source, CloudSource::Generated { mesh: Some(m), .. } if m == Path::new("rabbit.ply"))
    );
    assert!(matches!(
        Scene::parse(SMALL, Path::new("room.toml"), &mesh),
        Err(Error::Override { .. })
    ));
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

fn a_fitted_view_shows_all() {
    let boxes = [
        (DVec3::NEG_ONE, DVec3::ONE),
        (
            DVec3::new(636_000.0, 848_900.0, 400.0),
            DVec3::new(638_000.0, 850_500.0, 520.0),
        ),
        (DVec3::ZERO, DVec3::new(0.0, 0.0, 9.0)),
        (DVec3::ONE, DVec3::ONE),
    ];
    for (min, max) in boxes {
        let bounds = Bounds { min, max };
        for up in [UpAxis::Y, UpAxis::Z] {
            for size in [UVec2::new(800, 600), UVec2::new(100, 900), UVec2::new(1, 1)] {
                let camera = default_camera(bounds, up, size);
                let pinhole = camera.pinhole(camera.position).expect("a sound camera");
                for i in 0..8 {
                    let pick = |bit: usize, axis: usize| {
                        if i & bit == 0 {
                            bounds.min[axis]
                        } else {
                            bounds.max[axis]
                        }
                    };
                    let corner = DVec3::new(pick(1, 0), pick(2, 1), pick(4, 2)) - camera.position;
                    let view = pinhole.view_from_world(corner.as_vec3());
                    let pixel = pinhole.pixel_from_view(view);
                    assert!(
                        view.z >= pinhole.near && view.z <= pinhole.far,
                        "{view} of {bounds:?} in {camera:?}"
                    );
                    assert!(
                        pixel.cmpge(Vec2::ZERO).all() && pixel.cmple(size.as_vec2()).all(),
                        "{pixel} in {camera:?}"
                    );
                }
                assert!(
                    (camera.position - camera.target).dot(up.vector()) > 0.0,
                    "it looks down: {camera:?}"
                );
            }
        }
    }
}

fn a_partial_camera_is_completed() {
    let bounds = Bounds {
        min: DVec3::new(-1.0, -1.0, -3.0),
        max: DVec3::ONE,
    };
    let camera = |text: &str| {
        let scene = parse(&format!("{SMALL}[camera]\n{text}\n")).expect(text);
        scene.camera(bounds, UpAxis::Y).expect(text)
    };
    let eye_only = camera("position = [0, 0, 0.9]");
    assert_eq!(
        eye_only.target,
        DVec3::new(0.0, 0.0, -1.0),
        "the middle of the bounds"
    );
    assert!(eye_only.near < 0.05 && eye_only.far > 3.9, "{eye_only:?}");
    assert_eq!(camera("target = [0, 0, 0]").target, DVec3::ZERO);
    let from_above = camera("position = [0, 5, -1]");
    assert!(
        from_above.pinhole(DVec3::ZERO).is_ok(),
        "looking down along the up axis: {from_above:?}"
    );
    assert!(
        camera("position = [0, 0, -1]").pinhole(DVec3::ZERO).is_ok(),
        "in the very middle"
    );
    assert!(
        camera("position = [0, 0, 9]\ntarget = [0, 0, 20]").far > 0.0,
        "everything behind the eye"
    );
    assert!(camera("near = 100").far > 100.0);
    assert!(camera("far = 0.001").near < 0.001);
}

fn a_blind_camera_is_refused() {
    let bounds = CUBE;
    let text = format!("{SMALL}[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 0]\n");
    let refusal = parse(&text).expect("well-formed").camera(bounds, UpAxis::Y);
    assert!(
        matches!(refusal, Err(Error::Scene { line: Some(4), .. })),
        "got {refusal:?}"
    );
    let refusal = with(&text, &["camera.up=0,1,0"])
        .expect("well-formed")
        .camera(bounds, UpAxis::Y);
    assert!(
        matches!(refusal, Err(Error::Override { .. })),
        "got {refusal:?}"
    );
}
