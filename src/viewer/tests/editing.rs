//! Scenes that are changed by hand.

use catoptric::cloud::{Bounds, ColourBy, Select};
use catoptric::scene::{MirrorShape, Scene};
use glam::{DVec3, UVec2};

use super::*;
use crate::viewer::document::Document;
use crate::viewer::editing::{Kind, Selected};
use crate::viewer::handles::Handle;
use crate::viewer::letters::{Export, Pick};

/// At rest, showing the document.
fn shows_document(viewer: &Viewer) -> bool {
    let same = |scene: &Scene| Document::of(scene).has_points_of(viewer.document());
    viewer.opened.as_ref().is_some_and(|o| same(&o.scene)) && is_at_rest(viewer)
}

fn points(viewer: &Viewer) -> u64 {
    viewer.opened.as_ref().expect("a scene").loaded.facts.points
}

fn picture(window: &mut Harness<'_, Viewer>, path: &Path) -> Vec<u8> {
    let viewer = window.state_mut();
    let camera = catoptric::camera::Camera {
        size: UVec2::new(120, 80),
        ..viewer.camera()
    };
    let export = Export {
        camera,
        settings: viewer.settings().clone(),
        picture: Some(path.to_owned()),
        gbuffer: None,
        mirror_gbuffer: None,
        camera_json: None,
    };
    viewer.messages.clear();
    viewer.export(export);
    until(window, "the file", |v| {
        v.messages.iter().any(|(_, m)| m.contains("wrote"))
    });
    std::fs::read(path).expect("a picture")
}

/// What the command line of the window renders.
fn same_without_a_window(window: &Harness<'_, Viewer>, output: &Path) -> Vec<u8> {
    let viewer = window.state();
    let camera = catoptric::camera::Camera {
        size: UVec2::new(120, 80),
        ..viewer.camera()
    };
    let words = viewer.command_line(&camera, "out.png".as_ref());
    rendered(words[1].as_ref(), &overrides(&words), output)
}

#[test]
fn a_mirror_is_inserted_moved_taken_back_and_saved() {
    let (mut window, folder) = opened("inserted");
    let before = points(window.state());
    window.state_mut().navigator.pivot = DVec3::new(-0.5, -0.5, -0.5);
    window.state_mut().insert(Kind::Sphere);
    until(&mut window, "the mirror", shows_document);
    assert!(points(window.state()) > before, "it has points of its own");
    assert_eq!(window.state().selected, Some(Selected::Mirror(0)));

    let (_, handle) = window.state().selected_handle().expect("a ball");
    let Some(MirrorShape::Shape(ball)) = handle.mirror() else {
        panic!("a ball");
    };
    let moved = ball.scaled_and_shifted(1.0, DVec3::ZERO, DVec3::X * 0.25);
    let moved = Handle::of_mirror(&MirrorShape::Shape(moved)).expect("a ball");
    window.state_mut().move_selected(moved.clone(), false);
    assert!(
        shows_document(window.state()),
        "a drag under way changes no scene"
    );
    window.state_mut().move_selected(moved.clone(), true);
    until(&mut window, "the moved mirror", shows_document);
    assert_eq!(
        window.state().selected_handle(),
        Some((Selected::Mirror(0), moved))
    );
    window.state_mut().undo();
    until(&mut window, "the first place", shows_document);
    assert_eq!(
        window.state().selected_handle(),
        Some((Selected::Mirror(0), handle))
    );
    window.state_mut().undo();
    until(&mut window, "no mirror", shows_document);
    assert_eq!(points(window.state()), before);
    window.state_mut().redo();
    window.state_mut().redo();
    until(&mut window, "the moved mirror again", shows_document);

    // No option puts a mirror into a scene; a saved one has it.
    assert!(window.state().must_be_saved() && window.state().is_edited());
    let path = folder.join("saved.toml");
    window.state_mut().save_scene(path.clone(), true, false);
    let saved = |v: &Viewer| v.opened.as_ref().is_some_and(|o| o.opening.path == path);
    until(&mut window, "the scene's file", saved);
    assert!(!window.state().must_be_saved() && !window.state().is_edited());
    let exported = picture(&mut window, &folder.join("viewer.png"));
    let same = same_without_a_window(&window, &folder.join("same.png"));
    assert!(exported == same, "byte for byte");
    let without = rendered(&folder.join("scene.toml"), &[], &folder.join("without.png"));
    assert!(exported != without, "the mirror is seen");

    // Another file that is there already stays as it is unless it may be replaced.
    let path = folder.join("scene.toml");
    window.state_mut().messages.clear();
    window.state_mut().save_scene(path.clone(), true, false);
    until(&mut window, "a refusal", |v| {
        v.messages.iter().any(|(failed, _)| *failed)
    });
}

#[test]
fn what_options_can_say_needs_no_saving() {
    let (mut window, folder) = opened("options");
    window.state_mut().edit("look", |document| {
        document.clouds[0].colour = ColourBy::Height;
        document.clip = Some(Bounds {
            min: DVec3::new(-0.5, -2.0, -9.0),
            max: DVec3::new(2.0, 2.0, 9.0),
        });
    });
    until(&mut window, "the part", shows_document);
    assert!(window.state().is_edited() && !window.state().must_be_saved());
    let exported = picture(&mut window, &folder.join("viewer.png"));
    let same = same_without_a_window(&window, &folder.join("same.png"));
    assert!(exported == same, "byte for byte");
}

#[test]
fn an_edit_that_cannot_be_shown_is_taken_back() {
    let (mut window, _) = opened("refused");
    window.state_mut().edit("cloud 0", |document| {
        document.clouds[0].colour = ColourBy::Class;
    });
    until(&mut window, "a sentence", |v| !v.messages.is_empty());
    let viewer = window.state();
    assert!(
        viewer.messages[0].1.contains("classification"),
        "{:?}",
        viewer.messages
    );
    assert_eq!(viewer.document().clouds[0].colour, ColourBy::Auto);
    assert!(!viewer.history.can_undo(), "there is nothing to take back");
    until(&mut window, "the picture as it was", shows_document);
}

#[test]
fn quick_edits_end_with_the_last() {
    let (mut window, _) = opened("quick");
    window.state_mut().insert(Kind::Torus);
    for k in 0..20 {
        let (_, handle) = window.state().selected_handle().expect("a ring");
        let Some(MirrorShape::Shape(ring)) = handle.mirror() else {
            panic!("a ring");
        };
        let ring = ring.scaled_and_shifted(1.0, DVec3::ZERO, DVec3::X * 0.01);
        let ring = Handle::of_mirror(&MirrorShape::Shape(ring)).expect("a ring");
        window.state_mut().move_selected(ring, true);
        if k % 3 == 0 {
            window.step();
        }
    }
    let last = window.state().document().clone();
    until(&mut window, "the last place", shows_document);
    assert_eq!(window.state().document(), &last);
    assert!(
        window.state().messages.is_empty(),
        "{:?}",
        window.state().messages
    );
}

#[test]
fn a_region_that_is_clicked_on_becomes_a_mirror() {
    let (mut window, folder) = opened("region");
    let marked = |v: &Viewer| {
        v.opened
            .as_ref()
            .expect("a scene")
            .loaded
            .facts
            .mirror_points
    };
    let before = marked(window.state());
    // The wall behind the ball: its picture is flat and looks along z.
    let shown = window.state().shown.clone().expect("a frame");
    let gbuffer = &shown.products.gbuffer;
    let size = gbuffer.surface.size();
    let wall = (0..size.x * size.y).find(|&i| {
        let (surface, albedo) = (
            gbuffer.surface.values()[i as usize],
            gbuffer.albedo.values()[i as usize],
        );
        let valid = gbuffer.material.values()[i as usize].w > 0.0;
        valid && albedo.w == 0.0 && surface.z > 0.99 && i % size.x > size.x / 4
    });
    let wall = wall.expect("a wall");
    window.state_mut().picking = Some(0);
    let pick = |window: &Harness<'_, Viewer>, pixel: UVec2| {
        let shown = window.state().shown.clone().expect("a frame");
        window.state().worker.pick(Pick { shown, pixel });
    };
    pick(&window, UVec2::new(wall % size.x, wall / size.x));
    until(&mut window, "the mirror", |v| {
        marked(v) > before && shows_document(v)
    });
    let viewer = window.state();
    let select = &viewer.document().clouds[0]
        .mirrors
        .last()
        .expect("a rule")
        .select;
    let Select::NearPlane {
        point,
        normal,
        within: Some(within),
        ..
    } = select
    else {
        panic!("a flat region: {select:?}");
    };
    assert!(normal.z.abs() > 0.999, "{normal}");
    let surfels = &viewer.opened.as_ref().expect("a scene").loaded.surfels;
    let on_wall = |p: DVec3| (p.z - point.z).abs() < 0.1 && within.contains(p);
    let (mut near, mut missed) = (0, 0);
    for (place, finish) in surfels.places.iter().zip(&surfels.finishes) {
        let p = place.position.as_dvec3();
        if on_wall(p) && finish.normal().z > 0.9 {
            near += 1;
            missed += u64::from(finish.mirror() == 0.0);
        }
    }
    assert!(
        near > 100 && missed * 50 < near,
        "{missed} of {near} points are no mirror"
    );
    // It is the same scene once it is saved, last bits of its normal and all.
    let path = folder.join("region.toml");
    window.state_mut().save_scene(path.clone(), true, false);
    let saved = |v: &Viewer| v.opened.as_ref().is_some_and(|o| o.opening.path == path);
    until(&mut window, "the scene's file", saved);
    assert!(!window.state().is_edited() && !window.state().must_be_saved());
    // Where nothing is seen there is no region.
    window.state_mut().picking = Some(0);
    pick(&window, UVec2::MAX);
    until(&mut window, "a sentence", |v| {
        v.messages.iter().any(|(_, m)| m.contains("no point"))
    });
}

#[test]
fn a_cloud_is_added_hidden_and_removed() {
    let (mut window, folder) = opened("added");
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n\
               0 0 0\n0.1 0 0\n0 0.1 0\n";
    let path = folder.join("three.ply");
    std::fs::write(&path, ply).expect("a cloud");
    let before = points(window.state());
    window.state_mut().add_cloud(path);
    until(&mut window, "both", shows_document);
    assert_eq!(points(window.state()), before + 3);
    window
        .state_mut()
        .edit("cloud 0", |document| document.clouds[0].visible = false);
    until(&mut window, "the second alone", shows_document);
    assert_eq!(points(window.state()), 3);
    window
        .state_mut()
        .edit("cloud 1", |document| document.clouds[1].visible = false);
    until(&mut window, "a sentence", |v| !v.messages.is_empty());
    assert!(window.state().document().clouds[1].visible, "one stays");
}

#[test]
fn the_tree_of_the_scene_has_letters_for_all_that_it_says() {
    let (mut window, _) = opened("tree");
    window.get_by_label("Scene").click();
    window.run_steps(3);
    window.state_mut().insert(Kind::Paraboloid);
    until(&mut window, "the mirror", shows_document);
    for label in ["Insert", "Save scene..."] {
        window.get_by_label(label).click();
        // A letter that no font has is a panic here.
        window.run_steps(4);
        assert!(
            window.query_by_label_contains("focal length").is_some(),
            "{label}"
        );
    }
    let pressed = Modifiers::NONE;
    window.key_press_modifiers(pressed, Key::Delete);
    until(&mut window, "no mirror", |v| {
        v.document().mirrors.is_empty()
    });
}

#[test]
fn what_somebody_else_writes_into_the_file_is_not_lost() {
    let (mut window, folder) = opened("outside");
    let path = folder.join("scene.toml");
    let write = |points: u32, mtime: u64| {
        let text = SCENE.replace("30000", &points.to_string());
        std::fs::write(&path, format!("{text}\n# {points}\n")).expect("a scene");
        // Clocks of file systems may be coarse.
        let file = std::fs::File::options()
            .write(true)
            .open(&path)
            .expect("a scene");
        let at = std::time::UNIX_EPOCH + Duration::from_secs(mtime);
        file.set_modified(at).expect("a time");
    };
    write(20_000, 1_000_000);
    window.state_mut().reload();
    until(&mut window, "fewer points", |v| {
        points(v) == 20_000 && shows_document(v)
    });
    assert!(!window.state().is_edited(), "the tree is that of the file");

    // An edit on top of an old state of the file is not written over the new one.
    write(10_000, 2_000_000);
    window.state_mut().edit("clip box", |document| {
        document.clip = Some(Bounds {
            min: DVec3::splat(-9.0),
            max: DVec3::splat(9.0),
        });
    });
    until(&mut window, "the edit", shows_document);
    window.state_mut().save_scene(path.clone(), false, true);
    until(&mut window, "a refusal", |v| {
        v.messages
            .iter()
            .any(|(failed, m)| *failed && m.contains("reload"))
    });
    assert!(
        std::fs::read_to_string(&path)
            .expect("a scene")
            .contains("# 10000")
    );
    window.state_mut().reload();
    until(&mut window, "the edit again", |v| {
        v.loading.is_none() && shows_document(v)
    });
    assert!(window.state().document().clip.is_some(), "edits stay");
    window.state_mut().messages.clear();
    window.state_mut().save_scene(path.clone(), false, true);
    until(&mut window, "the file", |v| {
        v.messages.iter().any(|(_, m)| m.contains("wrote"))
    });
    let text = std::fs::read_to_string(&path).expect("a scene");
    assert!(
        text.contains("# 10000") && text.contains("[clip]"),
        "{text}"
    );
}

#[test]
fn a_setting_that_changes_while_another_file_opens_does_not_stop_it() {
    let (mut window, folder) = opened("other");
    let other = folder.join("other.toml");
    std::fs::write(&other, SCENE.replace("30000", "40000")).expect("a scene");
    window.state_mut().open(other.clone());
    let settings = window
        .state()
        .settings()
        .with("splat.size", toml::Value::Float(2.0));
    window
        .state_mut()
        .change(settings.expect("a size"), "splat.size");
    let opened = |v: &Viewer| v.opened.as_ref().is_some_and(|o| o.opening.path == other);
    until(&mut window, "the other file", opened);
    until(&mut window, "its picture", shows_document);
    assert_eq!(points(window.state()), 40_000);
}

#[test]
fn a_scene_that_is_saved_before_an_edit_is_loaded_is_the_one_that_was_saved() {
    let (mut window, folder) = opened("order");
    let path = folder.join("before.toml");
    let state = window.state_mut();
    state.insert(Kind::Sphere);
    state.save_scene(path.clone(), false, false);
    state.edit_once("clip", |document| {
        document.clip = Some(Bounds {
            min: DVec3::splat(-0.5),
            max: DVec3::splat(9.0),
        });
    });
    let saved = |v: &Viewer| v.opened.as_ref().is_some_and(|o| o.opening.path == path);
    until(&mut window, "both", |v| saved(v) && shows_document(v));
    let written = Scene::open(&path, &[]).expect("a scene");
    assert_eq!((written.mirrors.len(), written.clip), (1, None));
    assert!(window.state().is_edited(), "the clip box came later");
    window.state_mut().undo();
    until(&mut window, "what was saved", shows_document);
    assert!(!window.state().is_edited());
    window.state_mut().undo();
    until(&mut window, "no mirror", shows_document);
    let loaded = &window.state().opened.as_ref().expect("a scene").loaded;
    assert_eq!(loaded.facts.points, 30_000, "what is shown follows");
}

#[test]
fn a_comparison_is_made_anew_when_points_change() {
    let (mut window, _) = opened("compared");
    let settings = window.state().settings().clone();
    window.state_mut().compare_with("the same", settings);
    let compared = |v: &Viewer| v.second.as_ref().is_some_and(|s| s.texture.is_some());
    until(&mut window, "the comparison", compared);
    window.state_mut().edit_once("colour", |document| {
        document.clouds[0].colour = ColourBy::Height;
    });
    until(&mut window, "the colours", shows_document);
    until(&mut window, "the comparison again", compared);
    let viewer = window.state();
    let pair = (
        viewer.shown.as_ref(),
        viewer.second.as_ref().and_then(|s| s.shown.as_ref()),
    );
    let (Some(shown), Some(second)) = pair else {
        panic!("two frames");
    };
    let same = shown.products.gbuffer.albedo == second.products.gbuffer.albedo;
    assert!(same, "both are of the same points");
}

#[test]
fn what_was_given_up_does_not_come_back_by_undo() {
    let (mut window, _) = opened("given-up");
    let before = window.state().document().clone();
    let state = window.state_mut();
    for kind in [Kind::Sphere, Kind::Torus, Kind::Plane] {
        state.insert(kind);
    }
    state.cancel();
    until(&mut window, "the scene as it was", shows_document);
    let viewer = window.state();
    assert_eq!(viewer.document(), &before);
    assert!(!viewer.history.can_undo() && !viewer.history.can_redo());
}

#[test]
fn an_edit_while_the_file_is_read_anew_is_kept() {
    let (mut window, folder) = opened("reload-edit");
    let path = folder.join("scene.toml");
    std::fs::write(&path, SCENE.replace("30000", "20000")).expect("a scene");
    let state = window.state_mut();
    state.reload();
    state.insert(Kind::Sphere);
    until(&mut window, "both", shows_document);
    let viewer = window.state();
    assert_eq!(viewer.document().mirrors.len(), 1);
    let base = &viewer.opened.as_ref().expect("a scene").base;
    let text = format!("{:?}", base.clouds[0].source);
    assert!(text.contains("20000"), "the file was read: {text}");
}

#[test]
fn mirrors_of_points_without_normals_look_the_same_without_a_window() {
    let folder = folder("turned");
    let mut ply = "ply\nformat ascii 1.0\nelement vertex 1600\nproperty float x\nproperty float y\nproperty float z\nend_header\n".to_owned();
    for i in 0..1600 {
        // A mirror, and a wall in front of it.
        let z = if i < 800 { 0.0 } else { 1.5 };
        let (x, y) = (f64::from(i % 40) * 0.05, f64::from(i / 40 % 20) * 0.1);
        ply += &format!("{x} {y} {z}\n");
    }
    std::fs::write(folder.join("flat.ply"), ply).expect("a cloud");
    let path = folder.join("flat.toml");
    let text = "format = 1\n[[cloud]]\npath = \"flat.ply\"\n[[cloud.mirror]]\nbox = { min = [-1, -1, -0.1], max = [9, 9, 0.1] }\n\
                [camera]\nposition = [1, 1, 4]\ntarget = [1, 1, 0]\nup = [0, 1, 0]\n";
    std::fs::write(&path, text).expect("a scene");
    let mut window = window(Some(&path));
    until(&mut window, "a picture", is_at_rest);
    // From behind the mirror, where normals still look to the first eye.
    window.state_mut().navigator.orbit(2.6, 0.0);
    window.state_mut().touch();
    until(&mut window, "the other side", is_at_rest);
    let exported = picture(&mut window, &folder.join("viewer.png"));
    let same = same_without_a_window(&window, &folder.join("same.png"));
    assert!(exported == same, "byte for byte");
    let words = window
        .state()
        .command_line(&window.state().camera(), "out.png".as_ref());
    assert!(
        words.join(" ").contains("cloud.0.viewpoint=[1,1,4]"),
        "{words:?}"
    );
}
