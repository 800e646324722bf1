use std::f64::consts::FRAC_PI_2;

use proptest::prelude::*;

use super::file::parse;
use super::*;

fn at(position: DVec3) -> Pose {
    Pose {
        position,
        target: position + DVec3::new(0.0, 0.0, -3.0),
        up: DVec3::Y,
        fov_y_degrees: 60.0,
    }
}

fn path(keyframes: &[(f64, DVec3)]) -> CameraPath {
    let mut path = CameraPath::default();
    for (time, position) in keyframes {
        path.put(*time, at(*position)).expect("a sound keyframe");
    }
    path
}

fn bent() -> [(f64, DVec3); 5] {
    [
        (0.0, DVec3::new(636_010.25, 848_900.5, 500.125)),
        (0.3, DVec3::new(636_018.1, 848_903.7, 501.3)),
        (4.0, DVec3::new(636_019.9, 848_911.3, 499.1)),
        (4.1, DVec3::new(636_019.9, 848_911.3, 499.1)),
        (9.0, DVec3::new(636_000.3, 848_940.9, 510.7)),
    ]
}

#[test]
fn a_path_passes_through_every_keyframe_to_the_last_digit() {
    let path = path(&bent());
    for keyframe in path.keyframes() {
        assert_eq!(path.pose(keyframe.time), Some(keyframe.pose));
        let before = path.pose(keyframe.time.next_down()).expect("a view");
        assert!(before.position.distance(keyframe.pose.position) < 1e-8);
    }
    assert_eq!(
        path.pose(-5.0),
        Some(path.keyframes()[0].pose),
        "before it begins"
    );
    assert_eq!(
        path.pose(99.0),
        Some(path.keyframes()[4].pose),
        "after its end"
    );
}

#[test]
fn what_moves_evenly_on_a_line_stays_even_and_straight() {
    let speed = DVec3::new(1.0, -2.0, 0.5);
    let times = [0.0, 0.2, 3.0, 3.5, 10.0];
    let path = path(&times.map(|time| (time, speed * time)));
    for k in 0..=1000 {
        let time = k as f64 / 100.0;
        let position = path.pose(time).expect("a view").position;
        assert!(
            position.distance(speed * time) < 1e-12,
            "at {time}: {position}"
        );
    }
}

#[test]
fn uneven_times_make_no_loops() {
    // Along a line, a slow step between two fast ones.
    let places = [
        (0.0, 0.0),
        (1.0, 1.0),
        (100.0, 1.01),
        (101.0, 100.0),
        (300.0, 100.0),
        (300.1, 101.0),
    ];
    let path = path(&places.map(|(time, x)| (time, DVec3::X * x)));
    let mut last = 0.0;
    for k in 0..=30_010 {
        let x = path.pose(k as f64 / 100.0).expect("a view").position.x;
        assert!(
            x >= last - 1e-12,
            "it goes back from {last} to {x} at {k}/100"
        );
        last = x;
    }
    // Off the line, no piece leaves the ball about its ends by more than half of its length.
    let path = super::tests::path(&bent());
    for ends in path.keyframes().windows(2) {
        let (from, to) = (ends[0].pose.position, ends[1].pose.position);
        for k in 0..=100 {
            let time = ends[0].time + (ends[1].time - ends[0].time) * f64::from(k) / 100.0;
            let position = path.pose(time).expect("a view").position;
            let off = position.distance(from.midpoint(to));
            assert!(off <= from.distance(to) + 1e-9, "{off} off at {time}");
        }
    }
}

#[test]
fn one_keyframe_is_a_still_and_two_are_a_line() {
    let one = path(&[(2.0, DVec3::X)]);
    assert_eq!(one.pose(0.0), Some(at(DVec3::X)));
    assert_eq!(one.pictures(25.0), Ok(1));
    let two = path(&[(0.0, DVec3::ZERO), (2.0, DVec3::new(4.0, 0.0, 8.0))]);
    let middle = two.pose(0.5).expect("a view").position;
    assert!(
        middle.distance(DVec3::new(1.0, 0.0, 2.0)) < 1e-12,
        "{middle}"
    );
    assert_eq!(CameraPath::default().pose(0.0), None);
}

#[test]
fn large_coordinates_keep_their_digits() {
    let origin = DVec3::new(6_360_000.0, 8_490_000.0, 4000.0);
    let near = bent().map(|(time, p)| (time, p - DVec3::new(636_000.0, 848_900.0, 500.0)));
    let far = near.map(|(time, p)| (time, p + origin));
    let (near, far) = (path(&near), path(&far));
    for k in 0..=90 {
        let time = f64::from(k) / 10.0;
        let [a, b] = [&near, &far].map(|path| path.pose(time).expect("a view").position);
        // Two units in the last place of what is stored, 2^-30 each.
        assert!((b - origin).distance(a) < 4e-9, "{a} and {b} at {time}");
    }
}

#[test]
fn a_path_over_the_target_never_looks_along_its_up() {
    let mut path = CameraPath::default();
    for (time, x) in [(0.0, -2.0), (1.0, 2.0)] {
        let pose = Pose {
            position: DVec3::new(x, 1.0, 0.0),
            target: DVec3::ZERO,
            ..at(DVec3::ZERO)
        };
        path.put(time, pose).expect("a sound keyframe");
    }
    let above = path.pose(0.5).expect("a view");
    assert!(above.position.distance(DVec3::Y) < 1e-12);
    assert_eq!(above.check(), Ok(()));
    let down = (above.target - above.position).normalize();
    assert!(down.y < -0.99, "it still looks down: {down}");
}

fn turntable() -> CameraPath {
    let from = Pose {
        position: DVec3::new(636_000.0, 2.0, 3.0),
        target: DVec3::new(636_000.0, 0.5, -1.0),
        ..at(DVec3::ZERO)
    };
    let mut path = CameraPath::default();
    let pivot = DVec3::new(636_000.0, 0.0, 0.0);
    path.turntable = Some(Turntable {
        seconds: 4.0,
        ..Turntable::new(from, pivot)
    });
    path
}

#[test]
fn a_turntable_keeps_radius_and_height() {
    let path = turntable();
    let turn = path.turntable.expect("a turntable");
    for k in 0..400 {
        let pose = path.pose(f64::from(k) / 100.0).expect("a view");
        let [eye, aim] = [pose.position, pose.target].map(|p| p - turn.pivot);
        assert!((eye.y - 2.0).abs() < 1e-9 && (eye.with_y(0.0).length() - 3.0).abs() < 1e-9);
        assert!((aim.y - 0.5).abs() < 1e-9 && (aim.with_y(0.0).length() - 1.0).abs() < 1e-9);
    }
    for time in [0.0, 4.0] {
        assert_eq!(path.pose(time), Some(turn.from), "begun and closed exactly");
    }
    // Seen from above, anticlockwise: from +z to +x, a quarter of the circle in a quarter of the time.
    let quarter = path.pose(1.0).expect("a view").position - turn.pivot;
    assert!(
        quarter.distance(DVec3::new(3.0, 2.0, 0.0)) < 1e-9,
        "{quarter}"
    );
}

#[test]
fn a_turntable_has_as_many_pictures_as_asked_and_none_twice() {
    let path = turntable();
    let count = path.pictures(2.5).expect("pictures");
    assert_eq!(count, 10);
    let directions: Vec<DVec3> = (0..count)
        .map(|picture| {
            let pose = path.pose(path.time_of(picture, 2.5)).expect("a view");
            (pose.position - DVec3::new(636_000.0, 2.0, 0.0)).normalize()
        })
        .collect();
    for k in 0..count {
        let angle = directions[k].angle_between(directions[(k + 1) % count]);
        assert!(
            (angle - FRAC_PI_2 * 0.4).abs() < 1e-6,
            "{angle} after picture {k}"
        );
    }
}

#[test]
fn pictures_are_taken_from_the_first_keyframe_to_the_last() {
    let path = path(&[(1.0, DVec3::ZERO), (3.0, DVec3::X)]);
    assert_eq!(path.pictures(25.0), Ok(51));
    assert!((path.time_of(0, 25.0) - 1.0).abs() < 1e-12);
    assert!((path.time_of(50, 25.0) - 3.0).abs() < 1e-12);
    for rate in [0.0, -1.0, 1e9, f64::NAN, f64::INFINITY] {
        assert!(path.pictures(rate).is_err(), "{rate} pictures a second");
    }
    let long = super::tests::path(&[(0.0, DVec3::ZERO), (MAX_SECONDS, DVec3::X)]);
    assert!(long.pictures(25.0).is_err(), "two million pictures");
}

#[test]
fn keyframes_are_in_the_order_of_time() {
    let mut path = path(&[(0.0, DVec3::X), (2.0, DVec3::Y), (4.0, DVec3::Z)]);
    path.set_time(0, 3.0);
    let order = |path: &CameraPath| -> Vec<DVec3> {
        path.keyframes().iter().map(|k| k.pose.position).collect()
    };
    assert_eq!(order(&path), [DVec3::Y, DVec3::X, DVec3::Z]);
    // Where another one is, and where no time is, it does not go.
    for time in [4.0, f64::NAN, -1.0, 1e9] {
        path.set_time(0, time);
        assert_eq!(order(&path), [DVec3::Y, DVec3::X, DVec3::Z], "{time}");
    }
    path.put(3.0, at(DVec3::ONE)).expect("a keyframe");
    assert_eq!(
        order(&path),
        [DVec3::Y, DVec3::ONE, DVec3::Z],
        "in its place"
    );
    assert_eq!(path.add(at(DVec3::X)), Ok(6.0), "behind the last");
    path.remove(1);
    path.remove(99);
    assert_eq!(path.keyframes().len(), 3);
}

#[test]
fn there_are_not_more_keyframes_than_may_be() {
    let mut path = CameraPath::default();
    for _ in 0..MAX_KEYFRAMES {
        path.add(at(DVec3::X)).expect("a keyframe");
    }
    assert!(path.add(at(DVec3::X)).is_err());
    let text = text(&path).expect("TOML");
    assert!(parse(&text).is_ok());
    let more = format!(
        "{text}\n[[keyframe]]\ntime = 9e3\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nfov_y_degrees = 60\n"
    );
    let refusal = parse(&more).expect_err("one too many");
    assert!(refusal.contains("1000 are the most"), "{refusal}");
}

#[test]
fn a_path_is_read_as_it_was_written() {
    let mut written = turntable();
    for (time, position) in bent() {
        written.put(time, at(position)).expect("a keyframe");
    }
    let read = parse(&text(&written).expect("TOML")).expect("a path");
    assert_eq!(read, written);
}

#[test]
fn what_is_no_path_is_refused_in_a_sentence() {
    let keyframe = |what: &str| {
        let all = "time = 1.0\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nfov_y_degrees = 60.0";
        let (key, _) = what.split_once(" =").expect("a key");
        let lines = all
            .lines()
            .map(|line| if line.starts_with(key) { what } else { line });
        let lines: Vec<&str> = lines.collect();
        format!("format = 1\n[[keyframe]]\n{}\n", lines.join("\n"))
    };
    assert!(parse(&keyframe("time = 1.0")).is_ok());
    for (text, told) in [
        (String::new(), "format"),
        ("format = 2".into(), "reads format 1"),
        ("format = 1".into(), "neither"),
        ("format = 1\nspeed = 3".into(), "line 2"),
        ("keyframe = [1, 2".into(), "line 1"),
        (keyframe("time = nan"), "keyframe 1"),
        (keyframe("time = -1.0"), "keyframe 1"),
        (keyframe("time = 1e300"), "keyframe 1"),
        (keyframe("time = \"now\""), "line 3"),
        (keyframe("position = [0, 0, inf]"), "finite"),
        (keyframe("position = [0, 0, 1e13]"), "at most 1e12"),
        (keyframe("position = [0, 0]"), "line 4"),
        (keyframe("target = [0, 0, 1]"), "must differ"),
        (keyframe("up = [0, 0, 0]"), "up"),
        (keyframe("up = [0, 0, 2]"), "up"),
        (keyframe("fov_y_degrees = 180.0"), "fov_y_degrees"),
        (keyframe("fov_y_degrees = 0.0"), "fov_y_degrees"),
        (
            keyframe("time = 1.0") + keyframe("time = 0.5").trim_start_matches("format = 1\n"),
            "keyframe 2",
        ),
        (
            "format = 1\n[turntable]\nseconds = 0.0\nclockwise = false\npivot = [0, 0, 0]\nposition = [0, 0, 1]\n\
             target = [0, 0, 0]\nup = [0, 1, 0]\nfov_y_degrees = 60.0"
                .into(),
            "turntable",
        ),
    ] {
        let refusal = parse(&text).expect_err(&text);
        assert!(
            refusal.contains(told) && !refusal.contains('\n'),
            "{text}: {refusal}"
        );
    }
}

#[test]
fn what_is_no_file_is_not_waited_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let missing = read(&folder.path().join("a.path.toml")).expect_err("no file");
    assert!(missing.contains("a.path.toml"), "{missing}");
    assert!(read(folder.path()).is_err(), "a folder");
    let large = folder.path().join("large.path.toml");
    let file = std::fs::File::create(&large).expect("a file");
    file.set_len(1 << 40).expect("a hole");
    assert!(
        read(&large).expect_err("too large").contains("4 MiB"),
        "a hole"
    );
    assert!(is_path_file("b/Hall.PATH.toml".as_ref()) && !is_path_file("path.toml".as_ref()));
}

/// Any number, often one that breaks something.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -10.0..10.0,
        1 => any::<f64>(),
        1 => proptest::num::f64::ANY,
        1 => prop::sample::select(vec![0.0, -0.0, 1e-320, 1e12, -1e12, f64::MAX, f64::NAN, f64::INFINITY]),
    ]
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(number())
}

/// A float as TOML writes it.
fn float(x: f64) -> String {
    toml::Value::Float(x).to_string()
}

fn floats(v: [f64; 3]) -> String {
    format!("[{}]", v.map(float).join(", "))
}

proptest! {
    #[test]
    fn any_numbers_are_a_sound_path_or_a_sentence(
        keyframes in prop::collection::vec((0.0..2.0f64, number(), vector(), vector(), vector(), number()), 0..6),
        turntable in prop::option::of((number(), any::<bool>(), vector())),
        times in prop::collection::vec(number(), 8),
    ) {
        let (mut text, mut time) = ("format = 1\n".to_owned(), 0.0);
        if let Some((seconds, clockwise, pivot)) = turntable {
            text += &format!(
                "[turntable]\nseconds = {}\nclockwise = {clockwise}\npivot = {}\nposition = [1.0, 2.0, 3.0]\n\
                 target = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\nfov_y_degrees = 60.0\n",
                float(seconds), floats(pivot),
            );
        }
        for (step, odd, position, target, up, fov) in keyframes {
            // Mostly in order.
            time = if odd.abs() < 9.0 { time + step } else { odd };
            text += &format!(
                "[[keyframe]]\ntime = {}\nposition = {}\ntarget = {}\nup = {}\nfov_y_degrees = {}\n",
                float(time), floats(position), floats(target), floats(up), float(fov),
            );
        }
        match parse(&text) {
            Err(refusal) => prop_assert!(!refusal.is_empty() && !refusal.contains('\n')),
            Ok(path) => {
                for time in times {
                    let pose = path.pose(time);
                    prop_assert!(pose.is_none_or(|pose| pose.check().is_ok()), "{time}: {pose:?}");
                }
                if let Ok(count) = path.pictures(25.0) {
                    prop_assert!((1..=MAX_PICTURES).contains(&count));
                    prop_assert!(path.time_of(count - 1, 25.0) <= path.span().1);
                }
                let again = super::text(&path).and_then(|text| parse(&text));
                prop_assert_eq!(again, Ok(path));
            }
        }
    }

    #[test]
    fn any_text_is_a_path_or_a_sentence(text in "(format = 1\n)?(\\[\\[keyframe\\]\\]\n)?.{0,60}") {
        if let Err(refusal) = parse(&text) {
            prop_assert!(!refusal.contains('\n'), "{refusal}");
        }
    }
}
