//! The window, driven without a display: what a person does, and what comes of it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use catoptric::renderer::{BackendChoice, Renderer};
use catoptric::scene::{Override, Scene};
use catoptric::settings::Settings;
use catoptric::{Job, output::write_picture};
use eframe::egui::{self, Key, Modifiers, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;

use super::Start;
use super::app::Viewer;
use super::buffers::Buffer;
use super::pace::Detail;

mod device;
mod editing;
mod film;
mod lights;
mod room;
mod tooltips;

const SCENE: &str = r#"
    format = 1
    [[cloud]]
    generate = "sphere"
    points = 30000
    [[light]]
    kind = "spot"
    position = [0.95, 0.6, 0]
    target = [-1, -0.6, 0]
    intensity = [9, 9, 9]
    [camera]
    position = [0, 0, 0.9]
    target = [0, 0, -1]
    size = [160, 120]
    [settings.gi]
    vpl_count = 0
"#;

/// A folder with a scene in it.
fn folder(name: &str) -> PathBuf {
    let folder =
        std::env::temp_dir().join(format!("catoptric-viewer-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("scene.toml"), SCENE).expect("a scene");
    folder
}

fn window(path: Option<&Path>) -> Harness<'static, Viewer> {
    let start = Start {
        path: path.map(Path::to_owned),
        choice: BackendChoice::Cpu,
        ..Start::default()
    };
    Harness::builder()
        .with_size(egui::Vec2::new(1024.0, 700.0))
        .build_eframe(|context| Viewer::new(&context.egui_ctx, None, start).expect("a thread"))
}

/// Runs the window until something holds.
fn until(window: &mut Harness<'_, Viewer>, what: &str, holds: impl Fn(&Viewer) -> bool) {
    let start = Instant::now();
    while !holds(window.state()) {
        let v = window.state();
        assert!(
            start.elapsed() < Duration::from_secs(60),
            "{what} did not come: {:?} {:?}",
            v.messages,
            v.shown.as_ref().map(|s| &s.request)
        );
        std::thread::sleep(Duration::from_millis(5));
        window.step();
    }
}

fn is_at_rest(viewer: &Viewer) -> bool {
    let full = |s: &super::letters::Shown| {
        s.request.detail == Detail::FULL && s.request.settings == *viewer.settings()
    };
    viewer.shown.as_ref().is_some_and(full) && !viewer.is_busy()
}

fn opened(name: &str) -> (Harness<'static, Viewer>, PathBuf) {
    let folder = folder(name);
    let mut window = window(Some(&folder.join("scene.toml")));
    until(&mut window, "a picture", is_at_rest);
    (window, folder)
}

#[test]
fn a_window_without_a_scene_asks_for_one() {
    let mut window = window(None);
    window.run_steps(3);
    assert!(
        window.query_by_label("Open...").is_some(),
        "a button to open a file"
    );
}

#[test]
fn a_scene_is_opened_and_drawn_in_full_once_the_camera_rests() {
    let (window, _) = opened("opens");
    let viewer = window.state();
    let shown = viewer.shown.as_ref().expect("a frame");
    assert!(shown.products.mirror.is_some(), "the camera sees the ball");
    assert_eq!(shown.products.gbuffer.surface.size(), viewer.like.size);
    assert!(
        viewer.texture.is_some() && viewer.messages.is_empty(),
        "{:?}",
        viewer.messages
    );
}

#[test]
fn what_cannot_be_opened_is_said_and_the_scene_stays() {
    let (mut window, folder) = opened("missing");
    window.state_mut().open(folder.join("nothing.ply"));
    until(&mut window, "a message", |v| !v.messages.is_empty());
    let viewer = window.state();
    let (failed, message) = &viewer.messages[0];
    assert!(*failed && message.contains("nothing.ply"), "{message}");
    assert!(viewer.opened.is_some() && viewer.loading.is_none());
    let words = viewer.command_line(&viewer.camera(), "out.png".as_ref());
    assert!(words[1].ends_with("scene.toml"), "what is open: {words:?}");
}

#[test]
fn every_menu_opens_and_has_letters_for_its_entries() {
    for (menu, entry) in [("File", "Reload"), ("Edit", "Undo"), ("View", "Light")] {
        let (mut window, _) = opened("menus");
        window.get_by_label(menu).click();
        // A letter that no font has is a panic here.
        window.run_steps(4);
        let found = window.query_all_by_label_contains(entry).count();
        assert!(found > 0, "{menu} has no {entry}");
    }
}

#[test]
fn every_setting_has_a_control() {
    let (mut window, _) = opened("controls");
    for setting in Settings::describe() {
        let (_, name) = setting.key.split_once('.').expect("a group");
        window.state_mut().panels.filter_to(&setting.key);
        window.run_steps(4);
        let label = name.replace('_', " ");
        let rows = window.query_all_by_label(&label).count();
        assert!(rows >= 1, "{} has no row", setting.key);
    }
}

#[test]
fn a_setting_is_undone_and_redone_by_keys() {
    let (mut window, _) = opened("undo");
    let before = window.state().settings().splat.size;
    window.key_press(Key::Plus);
    until(&mut window, "larger points", |v| {
        v.settings().splat.size > before
    });
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    until(&mut window, "the old size", |v| {
        v.settings().splat.size == before
    });
    window.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    until(&mut window, "the new size", |v| {
        v.settings().splat.size > before
    });
}

#[test]
fn a_drag_turns_the_camera_about_the_pivot() {
    let (mut window, _) = opened("drag");
    let before = window.state().navigator;
    let middle = Pos2::new(520.0, 350.0);
    window.drag_at(middle);
    window.step();
    window.hover_at(middle + egui::Vec2::new(60.0, 20.0));
    window.step();
    window.drop_at(middle + egui::Vec2::new(60.0, 20.0));
    window.run_steps(2);
    let after = window.state().navigator;
    assert!(after.position.distance(before.position) > 0.05, "it moved");
    assert!(
        (after.reach() - before.reach()).abs() < 1e-9,
        "about the pivot"
    );
    until(&mut window, "all of the new view", is_at_rest);
}

#[test]
fn every_layer_is_painted() {
    let (mut window, _) = opened("layers");
    let mut pictures = Vec::new();
    let in_every_frame = |b: &Buffer| b.comes_with(Buffer::Picture);
    for buffer in Buffer::ALL.into_iter().filter(in_every_frame) {
        window.state_mut().set_buffer(buffer);
        window.run_steps(2);
        let shown = window.state().shown.clone().expect("a frame");
        let painted = buffer
            .paint(&shown.products, &shown.request.settings.image)
            .picture;
        let colours: std::collections::BTreeSet<[u8; 4]> =
            painted.values().iter().copied().collect();
        let one_colour = matches!(buffer, Buffer::Specular);
        assert!(
            colours.len() > 1 || one_colour,
            "{} is one colour",
            buffer.name()
        );
        pictures.push(painted);
    }
    assert_ne!(pictures[0].values(), pictures[1].values(), "light shows");
}

/// What a command line says on top of the scene.
fn overrides(words: &[String]) -> Vec<Override> {
    (words.windows(2).filter(|w| w[0] == "--set"))
        .map(|w| Override::parse(&w[1], &w[1]).expect("a setting"))
        .collect()
}

/// The picture that `catoptric render` writes, byte for byte.
fn rendered(scene: &Path, overrides: &[Override], output: &Path) -> Vec<u8> {
    let scene = Scene::open(scene, overrides).expect("the scene");
    let (loaded, job) = (scene.load(&Job::default()).expect("points"), Job::default());
    let mut renderer = Renderer::new(&BackendChoice::Cpu, &loaded.surfels).expect("a CPU");
    let (view, plan) = (loaded.view().expect("a view"), loaded.plan(&scene.settings));
    let products = renderer
        .render(&view, &plan, &scene.settings, &job)
        .expect("a frame");
    write_picture(output, &products.radiance, &scene.settings.image).expect("a file");
    std::fs::read(output).expect("a picture")
}

#[test]
fn what_is_exported_is_what_the_command_line_renders() {
    let (mut window, folder) = opened("export");
    window.state_mut().navigator.orbit(0.3, -0.1);
    let settings = Settings::default().with("splat.size", toml::Value::Float(1.8));
    let settings = settings.and_then(|s| s.with("gi.vpl_count", toml::Value::Integer(0)));
    window
        .state_mut()
        .change(settings.expect("a size"), "splat.size");
    let camera = catoptric::camera::Camera {
        size: glam::UVec2::new(200, 90),
        ..window.state().camera()
    };
    let picture = folder.join("viewer.png");
    let export = super::letters::Export {
        camera,
        settings: window.state().settings().clone(),
        picture: Some(picture.clone()),
        gbuffer: None,
        mirror_gbuffer: None,
        camera_json: None,
    };
    window.state_mut().export(export);
    until(&mut window, "the file", |v| {
        v.messages.iter().any(|(_, m)| m.contains("wrote"))
    });

    let words = window.state().command_line(&camera, "out.png".as_ref());
    let overrides = overrides(&words);
    let render = |overrides: &[Override], name: &str| {
        rendered(words[1].as_ref(), overrides, &folder.join(name))
    };
    let exported = std::fs::read(picture).expect("a picture");
    assert!(exported == render(&overrides, "same.png"), "byte for byte");
    let other = [
        overrides,
        vec![Override::parse("splat.size=1.9", "").expect("a size")],
    ]
    .concat();
    assert!(
        exported != render(&other, "other.png"),
        "another size is another picture"
    );
}

#[test]
fn where_no_mirror_is_seen_its_buffer_is_written_empty() {
    let (mut window, folder) = opened("empty");
    window.state_mut().navigator.look(std::f64::consts::PI, 0.0);
    let path = folder.join("mirror.exr");
    let export = super::letters::Export {
        camera: window.state().camera(),
        settings: window.state().settings().clone(),
        picture: None,
        gbuffer: None,
        mirror_gbuffer: Some(path.clone()),
        camera_json: None,
    };
    window.state_mut().export(export);
    let wrote = |v: &Viewer| v.messages.iter().any(|(_, m)| m.contains("wrote"));
    until(&mut window, "the file", wrote);
    let bytes = std::fs::read(path).expect("a file");
    let image = catoptric::output::ExrImage::decode(&bytes).expect("a picture");
    assert!(image.channels["valid.V"].iter().all(|v| *v == 0.0));
}

#[test]
fn a_hundred_quick_changes_end_with_the_last() {
    let (mut window, _) = opened("changes");
    for k in 0..100 {
        let value = toml::Value::Float(1.0 + 0.01 * f64::from(k));
        let settings = window
            .state()
            .settings()
            .with("splat.size", value)
            .expect("a size");
        window.state_mut().change(settings, "splat.size");
        window.step();
    }
    until(&mut window, "the last picture", is_at_rest);
    assert!((window.state().settings().splat.size - 1.99).abs() < 1e-6);
    assert!(
        window.state().messages.is_empty(),
        "{:?}",
        window.state().messages
    );
}

#[test]
fn reloading_again_and_again_keeps_camera_and_settings() {
    let (mut window, folder) = opened("reload");
    window.state_mut().navigator.orbit(0.2, 0.1);
    let camera = window.state().camera();
    for _ in 0..5 {
        window.state_mut().reload();
        until(&mut window, "the scene", |v| v.loading.is_none());
    }
    assert_eq!(window.state().camera(), camera);
    std::fs::remove_file(folder.join("scene.toml")).expect("the scene's file");
    window.state_mut().reload();
    until(&mut window, "a message", |v| !v.messages.is_empty());
    assert!(window.state().opened.is_some(), "what was read stays");
}

#[test]
fn traced_rays_tell_how_good_the_mirrors_are() {
    let (mut window, _) = opened("traced");
    let same = window.state().settings().clone();
    window.state_mut().compare_with("the same", same.clone());
    let compared = |v: &Viewer| v.second.as_ref().is_some_and(|s| s.texture.is_some());
    until(&mut window, "the same again", compared);
    let albedo = |v: &Viewer| {
        let lines = v.second.iter().flat_map(|s| &s.lines);
        let albedo = lines
            .filter(|(name, _)| *name == "albedo")
            .map(|(_, value)| value.clone());
        albedo.collect::<String>()
    };
    assert_eq!(albedo(window.state()), "120.0 dB", "no difference");
    let traced = same.with("reflect.method", toml::Value::String("ray_trace".into()));
    window
        .state_mut()
        .compare_with("traced rays", traced.expect("a method"));
    until(&mut window, "traced rays", compared);
    let found = albedo(window.state());
    let decibels: f64 = found.trim_end_matches(" dB").parse().expect(&found);
    assert!((10.0..60.0).contains(&decibels), "{found}");
}
