//! Cameras that a scene does not give, or gives in part.

use catoptric::Error;
use catoptric::cloud::{Bounds, UpAxis};
use catoptric::scene::default_camera;
use glam::{DVec3, UVec2, Vec2};
use libtest_mimic::Trial;

use crate::scene::{CUBE, SMALL, parse, with};
use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "cameras::a_fitted_view_shows_all_of_the_bounds",
            a_fitted_view_shows_all,
        ),
        claim(
            "cameras::a_fitted_view_is_centred_and_tight",
            a_fitted_view_is_centred_and_tight,
        ),
        claim(
            "cameras::a_partial_camera_is_completed",
            a_partial_camera_is_completed,
        ),
        claim(
            "cameras::a_camera_that_cannot_see_is_refused_at_its_line",
            a_blind_camera_is_refused,
        ),
        claim(
            "cameras::each_rule_blames_its_own_key",
            each_rule_blames_its_own_key,
        ),
    ]
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

fn a_fitted_view_is_centred_and_tight() {
    let bounds = Bounds {
        min: DVec3::new(636_000.0, 848_900.0, 400.0),
        max: DVec3::new(637_200.0, 849_500.0, 520.0),
    };
    for size in [UVec2::new(800, 600), UVec2::new(600, 800)] {
        let camera = default_camera(bounds, UpAxis::Z, size);
        let pinhole = camera.pinhole(camera.position).expect("a sound camera");
        let (mut low, mut high) = (Vec2::MAX, Vec2::MIN);
        for i in 0..8 {
            let pick = |bit: usize, axis: usize| {
                if i & bit == 0 {
                    bounds.min[axis]
                } else {
                    bounds.max[axis]
                }
            };
            let corner = DVec3::new(pick(1, 0), pick(2, 1), pick(4, 2)) - camera.position;
            let pixel = pinhole.pixel_from_view(pinhole.view_from_world(corner.as_vec3()));
            (low, high) = (low.min(pixel), high.max(pixel));
        }
        let free = (low, size.as_vec2() - high);
        assert!(
            (free.0 - free.1).abs().max_element() < 2.0,
            "free before and after: {free:?}"
        );
        assert!(
            free.0.min_element() < 0.04 * size.max_element() as f32,
            "free: {free:?} of {size}"
        );
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
        matches!(refusal, Err(Error::Scene { line: Some(6), .. })),
        "got {refusal:?}"
    );
    let refusal = with(&text, &["camera.up=0,1,0"])
        .expect("well-formed")
        .camera(bounds, UpAxis::Y);
    assert!(
        matches!(refusal, Err(Error::Scene { line: Some(6), .. })),
        "what is given on top has no part in it, got {refusal:?}"
    );
}

fn each_rule_blames_its_own_key() {
    let text = format!(
        "{SMALL}[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nnear = 0.1\nfar = 10\n"
    );
    for (sets, culprit) in [
        (["camera.near=20", "camera.size=80x60"], 0),
        (["camera.size=80x60", "camera.far=0.05"], 1),
        (["camera.up=0,0,1", "camera.fov_y_degrees=50"], 0),
        (["camera.fov_y_degrees=50", "camera.target=0,0,9"], 1),
        (["camera.position=0,0,0", "camera.size=80x60"], 0),
        (["camera.position=0,7,0", "camera.size=80x60"], 0),
    ] {
        let refusal = with(&text, &sets)
            .expect("well-formed")
            .camera(CUBE, UpAxis::Y);
        match refusal {
            Err(Error::Override { given, .. }) => {
                assert_eq!(given, format!("--set {}", sets[culprit]));
            }
            other => panic!("{sets:?} gave {other:?}"),
        }
    }
}
