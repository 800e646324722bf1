//! Camera paths: keyframes, preview, turntable, numbered pictures.

use catoptric::camera::Camera;
use glam::{DVec3, UVec2};

use super::super::path::CameraPath;
use super::super::take::Take;
use super::*;

/// Presses K here, and after a turn.
fn two_keyframes(window: &mut Harness<'_, Viewer>) {
    window.key_press(Key::K);
    window.run_steps(2);
    window.state_mut().navigator.orbit(0.6, 0.2);
    window.key_press(Key::K);
    window.run_steps(2);
}

/// A keyframe's place.
fn place(viewer: &Viewer, index: usize) -> DVec3 {
    viewer.film.path.keyframes()[index].pose.position
}

#[test]
fn a_key_adds_keyframes_and_the_slider_looks_between_them() {
    let (mut window, _) = opened("keyframes");
    two_keyframes(&mut window);
    let viewer = window.state();
    let times: Vec<f64> = viewer
        .film
        .path
        .keyframes()
        .iter()
        .map(|k| k.time)
        .collect();
    assert_eq!(times, [0.0, 2.0], "two seconds apart");
    let (first, second) = (place(viewer, 0), place(viewer, 1));
    assert!(first.distance(second) > 0.1);
    window.state_mut().scrub(0.5);
    window.run_steps(2);
    let expected = first.lerp(second, 0.25);
    let position = window.state().navigator.position;
    assert!(position.distance(expected) < 1e-9, "{position}");
    until(&mut window, "all of the view between", is_at_rest);

    // The window of the path has the rows, and their buttons work.
    window
        .get_all_by_label("Go to")
        .last()
        .expect("two rows")
        .click();
    window.run_steps(3);
    assert!(window.state().navigator.position.distance(second) < 1e-9);
    window
        .get_all_by_label("Remove")
        .next()
        .expect("two rows")
        .click();
    window.run_steps(3);
    assert_eq!(window.state().film.path.keyframes().len(), 1);
    window.state_mut().navigator.orbit(0.1, 0.0);
    window.get_by_label("Replace").click();
    window.run_steps(3);
    let viewer = window.state();
    assert!(place(viewer, 0).distance(viewer.navigator.position) < 1e-12);
    assert!(place(viewer, 0).distance(second) > 1e-3, "it is another");
}

#[test]
fn a_key_that_is_typed_adds_nothing() {
    let (mut window, _) = opened("typed");
    window.get_by_role(egui::accesskit::Role::TextInput).focus();
    window.run_steps(2);
    window.key_press(Key::K);
    window.run_steps(2);
    assert!(window.state().film.path.is_empty());
}

#[test]
fn a_preview_goes_to_the_last_keyframe_and_rests_there() {
    let (mut window, _) = opened("plays");
    two_keyframes(&mut window);
    window.state_mut().film.path.set_time(1, 0.4);
    let (first, last) = (place(window.state(), 0), place(window.state(), 1));
    window.get_by_label("Play").click();
    window.step();
    let mut seen = Vec::new();
    until(&mut window, "the preview", |v| v.film.is_playing());
    while window.state().film.is_playing() {
        seen.push(window.state().navigator.position);
        window.step();
        std::thread::sleep(Duration::from_millis(10));
    }
    let between = |p: &DVec3| p.distance(first) > 1e-6 && p.distance(last) > 1e-6;
    assert!(seen.iter().any(between), "views on the way: {seen:?}");
    assert!(window.state().navigator.position.distance(last) < 1e-9);
    until(&mut window, "all of the last view", is_at_rest);
}

#[test]
fn whoever_moves_the_camera_or_presses_escape_stops_the_preview() {
    let (mut window, _) = opened("stops");
    two_keyframes(&mut window);
    window.state_mut().film.path.set_time(1, 1000.0);
    let play = |window: &mut Harness<'_, Viewer>| {
        window.state_mut().begin_playing();
        window.run_steps(3);
        assert!(window.state().film.is_playing());
    };
    play(&mut window);
    let middle = Pos2::new(620.0, 500.0);
    window.drag_at(middle);
    window.step();
    window.hover_at(middle + egui::Vec2::new(40.0, 0.0));
    window.run_steps(2);
    window.drop_at(middle + egui::Vec2::new(40.0, 0.0));
    window.run_steps(2);
    assert!(!window.state().film.is_playing(), "a drag");
    play(&mut window);
    window.key_press(Key::Escape);
    window.run_steps(2);
    assert!(!window.state().film.is_playing(), "Esc");
    play(&mut window);
    window.key_press(Key::F);
    window.run_steps(2);
    assert!(!window.state().film.is_playing(), "another view");
    until(&mut window, "all of that view", is_at_rest);
}

#[test]
fn one_click_turns_about_the_pivot() {
    let (mut window, _) = opened("turntable");
    window.state_mut().panels.show_path();
    window.run_steps(3);
    let (pivot, reach) = {
        let navigator = &window.state().navigator;
        (navigator.pivot, navigator.reach())
    };
    let before = window.state().navigator.position;
    window.get_by_label("Turntable").click();
    window.run_steps(3);
    assert!(window.state().film.is_playing(), "it turns at once");
    window.state_mut().film.pause();
    let (start, end) = window.state().film.path.span();
    window.state_mut().scrub(start + (end - start) / 2.0);
    window.run_steps(2);
    let position = window.state().navigator.position;
    assert!((position.distance(pivot) - reach).abs() < 1e-9);
    assert!((position - pivot).dot(before - pivot) < 0.0, "the far side");
    window.state_mut().add_keyframe();
    window.run_steps(2);
    let path = &window.state().film.path;
    assert!(path.turntable.is_none() && path.keyframes().len() == 1);
}

fn take(viewer: &Viewer, folder: &Path, rate: f64) -> Take {
    Take {
        path: viewer.film.path.clone(),
        rate,
        size: UVec2::new(72, 48),
        settings: viewer.settings().clone(),
        stem: folder.join("walk").display().to_string(),
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> = entries
        .map(|entry| {
            entry
                .expect("a file")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    names
}

#[test]
fn pictures_of_a_path_are_what_the_command_line_renders() {
    let (mut window, folder) = opened("film");
    let out = tempfile::tempdir().expect("a folder");
    two_keyframes(&mut window);
    let take = take(window.state(), out.path(), 1.0);
    assert_eq!(take.count(), Ok(3));
    window.state_mut().begin_film(take.clone());
    until(&mut window, "the pictures", |v| v.film.rendering.is_none());
    let (failed, message) = window.state().messages.last().expect("a message").clone();
    assert!(!failed && message.contains("wrote 3 pictures"), "{message}");
    assert_eq!(
        names(out.path()),
        [
            "walk-0000.png",
            "walk-0001.png",
            "walk-0002.png",
            "walk.path.toml"
        ]
    );

    let viewer = window.state();
    let scene = viewer.opened.clone().expect("a scene");
    let mut pictures = Vec::new();
    for picture in 0..3 {
        let written = std::fs::read(take.file(picture)).expect("a picture");
        let camera = take.camera(picture, &scene).expect("a camera");
        let words = viewer.command_line(&camera, "out.png".as_ref());
        let overrides: Vec<Override> = (words.windows(2).filter(|w| w[0] == "--set"))
            .map(|w| Override::parse(&w[1], &w[1]).expect("a setting"))
            .collect();
        let rendered = render(&words[1], &overrides, &folder.join("same.png"));
        assert!(written == rendered, "picture {picture}, byte for byte");
        assert!(!pictures.contains(&written), "each is another");
        pictures.push(written);
    }

    // The path beside them is the one that was followed.
    window.state_mut().film.path = CameraPath::default();
    window.state_mut().open(take.path_file());
    until(&mut window, "the path", |v| !v.film.path.is_empty());
    assert_eq!(window.state().film.path, take.path);
}

fn render(scene: &str, overrides: &[Override], path: &Path) -> Vec<u8> {
    let scene = Scene::open(scene.as_ref(), overrides).expect("the scene");
    let (loaded, job) = (scene.load(&Job::default()).expect("points"), Job::default());
    let mut renderer = Renderer::new(&BackendChoice::Cpu, &loaded.surfels).expect("a CPU");
    let (view, plan) = (loaded.view().expect("a view"), loaded.plan(&scene.settings));
    let products = renderer
        .render(&view, &plan, &scene.settings, &job)
        .expect("a frame");
    write_picture(path, &products.radiance, &scene.settings.image).expect("a file");
    std::fs::read(path).expect("a picture")
}

#[test]
fn whoever_stops_the_pictures_has_whole_ones_and_can_look_around_meanwhile() {
    let (mut window, _) = opened("stopped");
    let out = tempfile::tempdir().expect("a folder");
    two_keyframes(&mut window);
    window.state_mut().film.path.set_time(1, 400.0);
    let take = take(window.state(), out.path(), 25.0);
    window.state_mut().begin_film(take);
    let under_way = |v: &Viewer| v.film.rendering.is_some_and(|(done, _)| done >= 2);
    until(&mut window, "two pictures", under_way);

    // A view that is asked for is drawn between the pictures.
    window.state_mut().navigator.orbit(0.2, 0.0);
    window.state_mut().touch();
    let position = window.state().navigator.position;
    until(&mut window, "the view", |v| {
        let shown = v.shown.as_ref().map(|s| &s.request);
        shown.is_some_and(|s| s.camera.position == position && s.detail == Detail::FULL)
    });
    assert!(window.state().film.rendering.is_some(), "pictures go on");

    window.get_by_label("Stop").click();
    until(&mut window, "the end", |v| v.film.rendering.is_none());
    let (failed, message) = window.state().messages.last().expect("a message").clone();
    assert!(!failed && message.starts_with("stopped"), "{message}");
    let (pictures, others): (Vec<String>, Vec<String>) = names(out.path())
        .into_iter()
        .partition(|name| name.ends_with(".png"));
    assert_eq!(others, ["walk.path.toml"], "nothing is left behind");
    let told = format!("stopped; {} of 10001 pictures", pictures.len());
    assert!(message.starts_with(&told), "{message}, not {told}");
    for (k, name) in pictures.iter().enumerate() {
        assert_eq!(*name, format!("walk-{k:05}.png"));
        let picture = image::open(out.path().join(name)).expect("a whole picture");
        assert_eq!((picture.width(), picture.height()), (72, 48));
    }

    // Once more, from the start: another scene ends them, too.
    let take = super::film::take(window.state(), out.path(), 25.0);
    window.state_mut().begin_film(take);
    window.state_mut().reload();
    until(&mut window, "the end", |v| v.film.rendering.is_none());
    until(&mut window, "the scene", is_at_rest);
}

#[test]
fn pictures_that_cannot_be_written_are_a_sentence() {
    let (mut window, folder) = opened("unwritable");
    two_keyframes(&mut window);
    let missing = folder.join("missing");
    let take = take(window.state(), &missing, 1.0);
    window.state_mut().begin_film(take);
    until(&mut window, "the end", |v| v.film.rendering.is_none());
    let (failed, message) = window.state().messages.last().expect("a message");
    assert!(
        *failed && message.contains("make it first") && message.contains("0 of 3"),
        "{message}"
    );
    assert!(!missing.exists());
}

#[test]
fn the_form_tells_what_will_be_written() {
    let (mut window, _) = opened("form");
    two_keyframes(&mut window);
    window.get_by_label("Render pictures...").click();
    window.run_steps(4);
    window.get_by_label("51 pictures, and the path:");
    window.get_by_label("scene-0000.png to scene-0050.png");
    window.get_by_label("scene.path.toml");
}

#[test]
fn a_path_stays_with_its_scene() {
    let (mut window, folder) = opened("stays");
    two_keyframes(&mut window);
    let path = window.state().film.path.clone();
    let other = folder.join("other.toml");
    std::fs::write(&other, SCENE).expect("a scene");
    window.state_mut().open(other);
    until(&mut window, "the other scene", is_at_rest);
    until(&mut window, "no path", |v| v.film.path.is_empty());
    window.state_mut().open(folder.join("scene.toml"));
    until(&mut window, "the path", |v| v.film.path == path);
}

#[test]
fn a_file_that_is_no_path_leaves_the_path_as_it_is() {
    let (mut window, folder) = opened("broken");
    two_keyframes(&mut window);
    let path = window.state().film.path.clone();
    let broken = folder.join("broken.path.toml");
    std::fs::write(&broken, "format = 1\n[[keyframe]]\ntime = nan\n").expect("a file");
    window.state_mut().open(broken);
    until(&mut window, "a message", |v| !v.messages.is_empty());
    let (failed, message) = &window.state().messages[0];
    assert!(*failed && message.contains("broken.path.toml"), "{message}");
    assert_eq!(window.state().film.path, path);
}

#[test]
fn planes_fit_the_scene_from_every_picture_as_from_the_window() {
    let (mut window, folder) = opened("planes");
    two_keyframes(&mut window);
    let viewer = window.state();
    let take = take(viewer, &folder, 1.0);
    let opened = viewer.opened.clone().expect("a scene");
    let last = take.camera(2, &opened).expect("a camera");
    let here = Camera {
        size: take.size,
        ..viewer.camera()
    };
    assert!((last.near - here.near).abs() < 1e-9 && (last.far - here.far).abs() < 1e-9);
    let first = take.camera(0, &opened).expect("a camera");
    assert!((first.far - last.far).abs() > 1e-3, "they differ by view");
}
