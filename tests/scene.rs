//! Scene files: what is read, and how what is wrong is refused.

use std::path::{Path, PathBuf};

use catoptric::Error;
use catoptric::cloud::generate::Shape;
use catoptric::cloud::{Bounds, Select, UpAxis};
use catoptric::scene::{CloudSource, MirrorShape, Override, Scene};
use glam::{DVec3, UVec2};
use libtest_mimic::Trial;

use crate::support::claim;

/// Every key of the format but those that exclude each other.
pub(crate) const EVERY_KEY: &str = r#"format = 1

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
near_plane = { point = [0, 0, 1], normal = [0, 0, 2], distance = 0.02, within = { min = [-1, -1, 0], max = [1, 1, 2] } }

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

[environment]
zenith = [0.2, 0.4, 1]
horizon = [1, 0.8, 0.6]

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

pub(crate) const CUBE: Bounds = Bounds {
    min: DVec3::NEG_ONE,
    max: DVec3::ONE,
};

pub(crate) const SMALL: &str = "format = 1\n[[cloud]]\ngenerate = \"sphere\"\n";

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
            "scene::the_scenes_of_the_repository_are_sound",
            the_scenes_of_the_repository_are_sound,
        ),
    ]
}

pub(crate) fn parse(text: &str) -> Result<Scene, Error> {
    Scene::parse(text, Path::new("dir/room.toml"), &[])
}

pub(crate) fn set(key_and_value: &str) -> Override {
    Override::parse(key_and_value, &format!("--set {key_and_value}")).expect("a key and a value")
}

pub(crate) fn with(text: &str, sets: &[&str]) -> Result<Scene, Error> {
    let overrides: Vec<Override> = sets.iter().map(|s| set(s)).collect();
    Scene::parse(text, Path::new("dir/room.toml"), &overrides)
}

pub(crate) fn sphere(radius: f64) -> MirrorShape {
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
            "its keys are centre, radius",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[[light]]\nkind = \"sun\"\n",
            5,
            "\"spot\"",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[[light]]\nkind = \"point\"\nposition = [0,0,0]\ntarget = [0,0,0]\n",
            7,
            "all directions",
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
            "format = 1\n[[cloud]]\npath = \"a\"\n[[light]]\nkind = \"spot\"\nposition = [0,0,0]\ntarget = [0,0,1]\nintensity = [1,1,1]\n\
             outer_angle_degrees = 81\n",
            9,
            "from 0 to 80 degrees",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\nbanana = 1\n",
            4,
            "its keys are path, generate",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[settings]\nbanana = 1\n",
            5,
            "info --settings",
        ),
        (
            "format = 1\n[[cloud]]\npath = \"a\"\n[environment]\ncolour = [1,1,1]\nmap = \"sky.exr\"\n",
            6,
            "both colour and map",
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

fn the_scenes_of_the_repository_are_sound() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("pointclouds");
    let mut read = 0;
    for entry in std::fs::read_dir(folder).expect("the folder") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|e| e == "toml") {
            let scene = Scene::open(&path, &[]).expect("a sound scene");
            assert_eq!(
                (scene.clouds.len(), scene.lights.len()),
                (1, 1),
                "{}",
                path.display()
            );
            read += 1;
        }
    }
    assert!(read >= 7, "only {read} scenes");
}
