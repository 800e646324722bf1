//! What is given on top of a scene file: `--set` and flags.

use std::path::Path;

use catoptric::Error;
use catoptric::cloud::UpAxis;
use catoptric::scene::{CloudSource, Override, Scene};
use glam::{DVec3, UVec2};
use libtest_mimic::Trial;

use crate::scene::{EVERY_KEY, SMALL, sphere, with};
use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "overrides::what_is_given_on_top_beats_the_file",
            what_is_given_on_top_beats_the_file,
        ),
        claim(
            "overrides::every_notation_of_a_value_is_understood",
            every_notation_is_understood,
        ),
        claim(
            "overrides::wrong_overrides_name_the_nearest_right_key",
            wrong_overrides_are_refused,
        ),
        claim(
            "overrides::what_is_beaten_must_be_sound_too",
            what_is_beaten_must_be_sound,
        ),
        claim(
            "overrides::two_angles_blame_the_one_that_was_given",
            two_angles_blame_the_given,
        ),
        claim(
            "overrides::every_table_has_keys_that_can_be_overridden",
            every_table_can_be_overridden,
        ),
        claim(
            "overrides::a_mesh_goes_to_the_cloud_that_needs_one",
            a_mesh_goes_where_it_is_needed,
        ),
    ]
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
        ("camera=3", "docs/SCENE_FILES.md"),
        ("format=2", "docs/SCENE_FILES.md"),
        ("cloud=[]", "docs/SCENE_FILES.md"),
        (".=1", "docs/SCENE_FILES.md"),
        ("cloud..path=1", "did you mean"),
        ("banana=1", "docs/SCENE_FILES.md"),
        ("environment.colour=1,1", "[red, green, blue]"),
        ("cloud.00.points=9", "cloud.0 only"),
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

fn what_is_beaten_must_be_sound() {
    for sets in [
        ["camera.size=0x0", "camera.size=80x60"],
        ["settings.splat.size=99", "splat.size=2"],
    ] {
        match with(SMALL, &sets) {
            Err(Error::Override { given, .. }) => assert_eq!(given, format!("--set {}", sets[0])),
            other => panic!("{sets:?} gave {other:?}"),
        }
    }
    with(SMALL, &["camera.size=40x30", "camera.size=80x60"]).expect("both are sound");
}

fn two_angles_blame_the_given() {
    let lit = format!(
        "{SMALL}[[light]]\nkind = \"spot\"\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nintensity = [1, 1, 1]\n\
         inner_angle_degrees = 25\nouter_angle_degrees = 35\n"
    );
    for given in [
        "light.0.inner_angle_degrees=40",
        "light.0.outer_angle_degrees=20",
    ] {
        match with(&lit, &[given]) {
            Err(Error::Override { given: words, .. }) => {
                assert_eq!(words, format!("--set {given}"));
            }
            other => panic!("{given} gave {other:?}"),
        }
    }
    let narrow = lit.replace("inner_angle_degrees = 25", "inner_angle_degrees = 45");
    assert!(
        matches!(with(&narrow, &[]), Err(Error::Scene { line: Some(10), .. })),
        "the file's own line is blamed"
    );
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
        "environment.horizon=0.5,0.5,0.5",
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
