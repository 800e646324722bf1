//! A picture with a gizmo over it, driven by a pointer. One unit at the shape is 100 points of the window.

use catoptric::cloud::Bounds;
use catoptric::cloud::generate::Shape;
use eframe::egui::{PointerButton, Sense, Vec2, pos2};
use egui_kittest::Harness;
use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::*;
use crate::viewer::handles::tests::{any_handle, refusal};
use crate::viewer::screen::tests::ahead;

const MIDDLE: Pos2 = pos2(500.0, 350.0);

struct App {
    gizmo: Gizmo,
    of: &'static str,
    handle: Handle,
    screen: Screen,
    moves: Vec<Moved>,
    /// Drags and clicks that the picture was left with.
    turned: Vec2,
    clicks: usize,
}

fn app(handle: Handle, screen: Screen) -> Harness<'static, App> {
    let app = App {
        gizmo: Gizmo::default(),
        of: "one",
        handle,
        screen,
        moves: Vec::new(),
        turned: Vec2::ZERO,
        clicks: 0,
    };
    Harness::builder()
        .with_size(Vec2::new(1000.0, 700.0))
        .build_ui_state(
            |ui, app: &mut App| {
                let rect = app.screen.rect();
                let canvas = ui.interact(rect, Id::unique("canvas"), Sense::click_and_drag());
                let of = Id::unique(app.of);
                let moved = (app.gizmo).interact(ui, &canvas, &app.screen, of, &app.handle);
                if let Some(moved) = moved {
                    app.handle = moved.handle.clone();
                    app.moves.push(moved);
                }
                if !app.gizmo.is_active() {
                    app.turned += canvas.drag_delta();
                    app.clicks += usize::from(canvas.clicked());
                }
            },
            app,
        )
}

fn sphere(centre: DVec3, radius: f64) -> Handle {
    Handle::Mirror(Shape::Sphere { centre, radius })
}

fn ball() -> Harness<'static, App> {
    app(sphere(DVec3::ZERO, 0.7), ahead(DVec3::ZERO, DVec3::ZERO))
}

fn press(window: &mut Harness<'_, App>, from: Pos2) {
    window.hover_at(from);
    window.run_steps(2);
    window.drag_at(from);
    window.step();
}

fn release(window: &mut Harness<'_, App>, to: Pos2) {
    window.hover_at(to);
    window.step();
    window.drop_at(to);
    window.run_steps(2);
}

/// From and to are points of the window from the middle of the picture.
fn drag(window: &mut Harness<'_, App>, from: (f32, f32), to: (f32, f32)) {
    press(window, MIDDLE + Vec2::from(from));
    release(window, MIDDLE + Vec2::from(to));
}

fn centre(window: &Harness<'_, App>) -> DVec3 {
    window.state().handle.centre()
}

#[track_caller]
fn is_near(got: DVec3, expected: DVec3) {
    assert!(
        got.distance(expected) < 1e-4,
        "got {got}, expected {expected}"
    );
}

#[test]
fn an_arrow_moves_a_ball_along_its_axis_and_nowhere_else() {
    for (from, to, expected) in [
        ((60.0, 0.0), (160.0, 23.0), DVec3::X),
        ((0.0, -60.0), (40.0, -10.0), DVec3::Y * -0.5),
    ] {
        let mut window = ball();
        drag(&mut window, from, to);
        is_near(centre(&window), expected);
        assert_eq!(window.state().turned, Vec2::ZERO, "the camera stays");
        let moves = &window.state().moves;
        let finished: Vec<bool> = moves.iter().map(|m| m.finished).collect();
        assert_eq!(finished, [false, true], "one change");
    }
}

#[test]
fn an_arrow_towards_the_side_of_the_eye_moves_as_perspective_says() {
    // Seen from (3, 0, 4), the axis x is aslant: the point t of it is seen at 500 * 0.8 t / (5 - 0.6 t) points.
    let camera = catoptric::camera::Camera {
        position: DVec3::new(3.0, 0.0, 4.0),
        target: DVec3::ZERO,
        up: DVec3::Y,
        fov_y_degrees: 2.0 * (300.0f64 / 500.0).atan().to_degrees(),
        near: 0.1,
        far: 100.0,
        size: glam::UVec2::new(800, 600),
    };
    let rect = ahead(DVec3::ZERO, DVec3::ZERO).rect();
    let pinhole = camera.pinhole(DVec3::ZERO).expect("a camera");
    let screen = Screen::new(&pinhole, DVec3::ZERO, rect);
    let mut window = app(sphere(DVec3::ZERO, 0.7), screen);
    let at = |t: f32| (500.0 * 0.8 * t / (5.0 - 0.6 * t), 0.0);
    drag(&mut window, at(0.5), at(2.5));
    is_near(centre(&window), DVec3::X * 2.0);
}

#[test]
fn with_ctrl_it_goes_in_round_steps() {
    let mut window = ball();
    press(&mut window, MIDDLE + Vec2::new(60.0, 0.0));
    window.hover_at(MIDDLE + Vec2::new(183.0, 0.0));
    window.step();
    is_near(centre(&window), DVec3::X * 1.23);
    window.event(Event::ModifiersChanged(Modifiers::COMMAND));
    window.run_steps(1);
    is_near(centre(&window), DVec3::X * 1.2);
}

#[test]
fn the_square_across_an_axis_and_the_disc_move_in_planes() {
    let mut window = ball();
    drag(&mut window, (32.0, -32.0), (132.0, 18.0));
    is_near(centre(&window), DVec3::new(1.0, -0.5, 0.0));
    let mut window = ball();
    drag(&mut window, (2.0, 1.0), (-48.0, -99.0));
    is_near(centre(&window), DVec3::new(-0.5, 1.0, 0.0));
}

#[test]
fn millions_of_metres_from_zero_it_moves_the_same() {
    let far = DVec3::new(432_100.25, 5_300_200.5, 612.125);
    let screen = ahead(far, far - DVec3::new(10.0, 20.0, 1.0));
    let mut window = app(sphere(far, 0.7), screen);
    drag(&mut window, (60.0, 0.0), (110.0, 0.0));
    is_near(centre(&window), far + DVec3::X * 0.5);
}

#[test]
fn the_ring_about_the_view_turns_a_plane_by_what_the_pointer_turns() {
    let plane = Handle::Mirror(Shape::Plane {
        centre: DVec3::ZERO,
        normal: DVec3::Z,
        up: DVec3::Y,
        size: DVec2::ONE,
    });
    let mut window = app(plane, ahead(DVec3::ZERO, DVec3::ZERO));
    window.key_press(Key::R);
    window.run_steps(2);
    drag(&mut window, (104.0, 0.0), (0.0, -50.0));
    // From the right to the top is a quarter, and takes up to the left.
    let [right, up, normal] = window.state().handle.axes();
    is_near(normal, DVec3::Z);
    is_near(up, DVec3::NEG_X);
    is_near(right, DVec3::Y);
}

#[test]
fn a_ring_seen_from_its_edge_is_rolled() {
    let plane = Handle::Mirror(Shape::Plane {
        centre: DVec3::ZERO,
        normal: DVec3::Z,
        up: DVec3::Y,
        size: DVec2::ONE,
    });
    let mut window = app(plane, ahead(DVec3::ZERO, DVec3::ZERO));
    window.key_press(Key::R);
    window.run_steps(2);
    // The ring about y is a level line. A sixth of a half turn from its front, it is at (0.42, 0, 0.7275) and goes along
    // (0.7275, 0, -0.42) in a unit of angle: seen from 4.2725, that is 80.3 points.
    let (x, depth) = (0.42f32, 5.0 - 0.7275f32);
    let from = 500.0 * x / depth;
    let an_angle = 500.0 * (0.7275 * depth - x * x) / (depth * depth);
    let to = from + an_angle * std::f32::consts::FRAC_PI_6;
    drag(&mut window, (from, 0.0), (to, 0.0));
    let normal = window.state().handle.axes()[2];
    assert!(
        normal.distance(DVec3::new(0.5, 0.0, 0.75f64.sqrt())) < 1e-3,
        "{normal}"
    );
}

#[test]
fn knobs_pull_lengths_and_the_ring_makes_all_larger() {
    let mut window = ball();
    window.key_press(Key::T);
    window.run_steps(2);
    drag(&mut window, (70.0, 0.0), (100.0, 7.0));
    let radius = |w: &Harness<'_, App>| match &w.state().handle {
        Handle::Mirror(Shape::Sphere { centre, radius }) if *centre == DVec3::ZERO => *radius,
        other => panic!("{other:?} is not where it was"),
    };
    assert!((radius(&window) - 1.0).abs() < 1e-4, "{}", radius(&window));
    drag(&mut window, (0.0, 104.0), (0.0, 52.0));
    assert!((radius(&window) - 0.5).abs() < 1e-4, "{}", radius(&window));
}

#[test]
fn a_side_of_a_box_follows_the_pointer() {
    let bounds = Bounds {
        min: DVec3::new(-1.0, -1.0, -0.01),
        max: DVec3::new(1.0, 1.0, 0.01),
    };
    let mut window = app(Handle::Box(bounds), ahead(DVec3::ZERO, DVec3::ZERO));
    window.key_press(Key::T);
    window.run_steps(2);
    drag(&mut window, (-100.0, 0.0), (-150.0, 0.0));
    let Handle::Box(after) = window.state().handle else {
        panic!("a box");
    };
    is_near(after.min, DVec3::new(-1.5, -1.0, -0.01));
    assert_eq!(after.max, bounds.max);
}

#[test]
fn drags_that_begin_elsewhere_belong_to_the_picture() {
    let mut window = ball();
    drag(&mut window, (-200.0, 100.0), (0.0, 0.0));
    let state = window.state();
    assert!(state.moves.is_empty(), "{:?}", state.moves);
    assert!(state.turned.length() > 100.0, "{}", state.turned);
}

#[test]
fn a_click_on_an_arrow_changes_nothing_and_is_not_the_pictures() {
    let mut window = ball();
    press(&mut window, MIDDLE + Vec2::new(60.0, 0.0));
    assert!(window.state().gizmo.is_active());
    window.drop_at(MIDDLE + Vec2::new(60.0, 0.0));
    window.run_steps(2);
    assert_eq!(window.state().clicks, 0, "the release is its own, too");
    assert!(!window.state().gizmo.is_active());
    assert!(window.state().moves.is_empty());
    press(&mut window, MIDDLE + Vec2::new(-60.0, 0.0));
    window.drop_at(MIDDLE + Vec2::new(-60.0, 0.0));
    window.run_steps(2);
    assert_eq!(window.state().clicks, 1, "elsewhere it is the picture's");
}

#[test]
fn escape_takes_a_drag_back() {
    let mut window = ball();
    press(&mut window, MIDDLE + Vec2::new(60.0, 0.0));
    window.hover_at(MIDDLE + Vec2::new(160.0, 0.0));
    window.step();
    is_near(centre(&window), DVec3::X);
    window.key_press(Key::Escape);
    window.run_steps(2);
    assert_eq!(centre(&window), DVec3::ZERO);
    window.hover_at(MIDDLE + Vec2::new(190.0, 0.0));
    window.run_steps(2);
    assert_eq!(centre(&window), DVec3::ZERO, "it is let go");
    assert!(window.state().moves.last().is_some_and(|m| m.finished));
}

#[test]
fn a_drag_ends_when_another_shape_is_chosen() {
    let mut window = ball();
    press(&mut window, MIDDLE + Vec2::new(60.0, 0.0));
    window.state_mut().of = "another";
    window.state_mut().handle = sphere(DVec3::Y * 0.1, 0.2);
    release(&mut window, MIDDLE + Vec2::new(190.0, 0.0));
    assert_eq!(centre(&window), DVec3::Y * 0.1);
}

#[test]
fn keys_choose_what_it_does_and_those_with_ctrl_do_not() {
    let mut window = ball();
    window.key_press_modifiers(Modifiers::COMMAND, Key::T);
    window.run_steps(2);
    assert_eq!(window.state().gizmo.mode, Mode::Move);
    for mode in [Mode::Turn, Mode::Scale, Mode::Move] {
        window.key_press(mode.key());
        window.run_steps(2);
        assert_eq!(window.state().gizmo.mode, mode);
    }
    assert!(!window.state().gizmo.own_axes);
    window.key_press(Key::G);
    window.run_steps(2);
    assert!(window.state().gizmo.own_axes, "a second press");
    let gizmo = Gizmo {
        mode: Mode::Turn,
        ..Gizmo::default()
    };
    assert_eq!(
        gizmo.mode_for(&window.state().handle),
        Mode::Move,
        "a ball is not turned"
    );
}

#[test]
fn other_buttons_take_nothing() {
    let mut window = ball();
    let at = MIDDLE + Vec2::new(60.0, 0.0);
    window.hover_at(at);
    window.run_steps(2);
    assert!(window.state().gizmo.is_hovered());
    window.event(Event::PointerButton {
        pos: at,
        button: PointerButton::Secondary,
        pressed: true,
        modifiers: Modifiers::NONE,
    });
    window.step();
    window.hover_at(at + Vec2::new(50.0, 0.0));
    window.run_steps(2);
    assert_eq!(centre(&window), DVec3::ZERO);
}

#[test]
fn buttons_choose_modes_too() {
    use egui_kittest::kittest::Queryable as _;
    let plane = Handle::Mirror(Shape::Plane {
        centre: DVec3::ZERO,
        normal: DVec3::Z,
        up: DVec3::Y,
        size: DVec2::ONE,
    });
    let show = move |ui: &mut Ui, gizmo: &mut Gizmo| gizmo.buttons(ui, &plane);
    let mut window = Harness::new_ui_state(show, Gizmo::default());
    window.get_by_label("Scale").click();
    window.run_steps(2);
    assert_eq!(window.state().mode, Mode::Scale);
}

/// Every part of the gizmo, of every shape, from everywhere, to everywhere.
fn any_view() -> impl Strategy<Value = (Handle, DVec3, f64)> {
    let direction = prop::array::uniform3(-1.0..1.0f64);
    (any_handle(), direction, -3.0..3.0f64).prop_map(|(handle, direction, distance)| {
        let direction = DVec3::from_array(direction).normalize_or(DVec3::X);
        (handle, direction, 10f64.powf(distance))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(160))]

    #[test]
    fn wherever_the_pointer_goes_a_scene_can_hold_what_comes(
        (handle, direction, distance) in any_view(),
        to in prop::array::uniform2(-2000.0..3000.0f64),
        mode in 0..3usize,
        own in any::<bool>(),
        in_steps in any::<bool>(),
    ) {
        let centre = handle.centre();
        let camera = catoptric::camera::Camera {
            position: centre + direction * distance,
            target: centre,
            up: direction.any_orthonormal_vector(),
            fov_y_degrees: 60.0,
            near: distance * 1e-3,
            far: distance * 1e3,
            size: glam::UVec2::new(800, 600),
        };
        let rect = eframe::egui::Rect::from_min_size(Pos2::ZERO, Vec2::new(800.0, 600.0));
        // At the ends of the world no camera can look at what is near.
        let Ok(pinhole) = camera.pinhole(centre) else { return Ok(()) };
        let screen = Screen::new(&pinhole, centre, rect);
        let to = DVec2::from_array(to);
        for (grip, outline) in grips::grips(&screen, &handle, Mode::ALL[mode], own) {
            let places = match &outline {
                grips::Outline::Arrow([_, at]) | grips::Outline::Knob([_, at]) => vec![*at],
                grips::Outline::Square(corners) => corners.to_vec(),
                grips::Outline::Disc(at, _) => vec![*at],
                grips::Outline::Circle(at, radius) => vec![*at + Vec2::X * *radius],
                grips::Outline::Ring(parts) => parts.iter().flatten().take(3).copied().collect(),
            };
            for at in places {
                let Some(grasp) = Grasp::new(grip, &handle, own, &screen, place(at)) else {
                    continue;
                };
                let Some(drag) = grasp.drag(&screen, to, in_steps) else { continue };
                let dragged = handle.dragged(&drag);
                prop_assert_eq!(refusal(&dragged), None, "{:?} by {:?}", dragged, drag);
                prop_assert!(!grasp.says(&drag, &dragged).contains("NaN"));
            }
        }
    }
}
