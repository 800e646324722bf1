//! The layers of virtual lights and of their shadow maps.

use std::collections::BTreeSet;
use std::sync::Arc;

use catoptric::camera::Camera;
use catoptric::gbuffer::{Coverage, GBuffer};
use catoptric::gi::virtual_lights::{ShadowMaps, VirtualLight, VirtualLights};
use catoptric::gi::vpl::Vpl;
use catoptric::grid::Grid;
use catoptric::image::ImageSettings;
use catoptric::renderer::Products;
use glam::{DVec3, UVec2, Vec3, Vec4};

use super::*;
use crate::viewer::probe::Probe;
use crate::viewer::virtual_lights::{marks, nearest};

/// Far from zero, as scans are.
const ORIGIN: DVec3 = DVec3::new(432_000.0, 5_300_000.0, 600.0);

const SIZE: UVec2 = UVec2::new(200, 100);

fn light(position: Vec3, flux: Vec3) -> VirtualLight {
    let vpl = Vpl {
        position,
        softening: 0.0,
        normal: Vec3::Z,
        shininess: 0.0,
        flux,
        specular: 0.0,
        incident: flux,
        spacing: 0.01,
        mirrored: Vec3::Z,
        slice: 0,
        right: Vec3::X,
        pad0: 0,
        up: Vec3::Y,
        pad1: 0,
    };
    VirtualLight { vpl, bounce: 1 }
}

/// A black frame of a camera at the origin along -z, 100 pixels per unit of slope, that sees a wall so far away.
fn frame(depth: f32, lights: Vec<VirtualLight>, maps: Vec<ShadowMaps>) -> Products {
    let camera = Camera {
        position: ORIGIN,
        target: ORIGIN - DVec3::Z,
        up: DVec3::Y,
        fov_y_degrees: 2.0 * 0.5f64.atan().to_degrees(),
        near: 0.1,
        far: 100.0,
        size: SIZE,
    };
    let mut gbuffer = GBuffer::empty(camera.pinhole(ORIGIN).expect("a camera"));
    gbuffer.surface = Grid::new(SIZE, Vec3::Z.extend(depth));
    gbuffer.material = Grid::new(SIZE, Vec4::new(0.0, 0.0, 0.01, 1.0));
    Products {
        gbuffer,
        coverage: Coverage::default(),
        radiance: Grid::new(SIZE, Vec4::W),
        mirror: None,
        bounces: Vec::new(),
        search_heat: None,
        virtual_lights: Some(Arc::new(VirtualLights { lights, maps })),
        passes: Vec::new(),
        wall_ms: 0.0,
    }
}

fn line(probe: &Probe, name: &str) -> String {
    let mut lines = probe.lines.iter().filter(|(n, _)| *n == name);
    lines.next().map_or_else(String::new, |(_, v)| v.clone())
}

fn painted(buffer: Buffer, products: &Products) -> super::super::buffers::Painted {
    buffer.paint(products, &ImageSettings::default())
}

/// At 0.5 / 2 and 0.25 / 2 of slope, 100 pixels each, from the middle (100, 50): pixel (125, 37).
const RED: Vec3 = Vec3::new(0.5, 0.25, -2.0);
const RED_AT: UVec2 = UVec2::new(125, 37);

#[test]
fn a_light_is_drawn_and_found_where_paper_has_it() {
    let green = light(Vec3::new(-1.0, 0.0, -2.0), Vec3::Y * 0.5);
    let products = frame(2.0, vec![green, light(RED, Vec3::X)], Vec::new());
    let picture = painted(Buffer::VirtualLights, &products).picture;
    let pixel = |x, y| picture.get(x, y).copied();
    assert_eq!(pixel(125, 37), Some([255, 0, 0, 255]));
    assert_eq!(pixel(50, 49), Some([0, 255, 0, 255]));
    assert_eq!(pixel(150, 80), Some([0, 0, 0, 255]), "no light is there");
    for near in [RED_AT, RED_AT + UVec2::new(20, 9)] {
        let probe = Probe::new(&products, ORIGIN, near, Buffer::VirtualLights);
        assert_eq!(line(&probe, "light"), "2 of 2");
        assert_eq!(line(&probe, "bounce"), "1");
        let at = "432000.5000  5300000.2500  598.0000";
        assert_eq!(line(&probe, "light at"), at, "at {near}");
        assert_eq!(line(&probe, "flux, W"), "1.00e0  0.00e0  0.00e0");
        assert!(
            probe.position.is_some(),
            "what the camera sees is told, too"
        );
    }
    let albedo = Probe::new(&products, ORIGIN, RED_AT, Buffer::Albedo);
    assert_eq!(line(&albedo, "light"), "", "in its layer alone");
}

#[test]
fn more_flux_is_a_larger_disc() {
    let left = light(Vec3::new(-1.0, 0.0, -2.0), Vec3::X * 0.25);
    let mut products = frame(2.0, vec![left, light(RED, Vec3::X)], Vec::new());
    // Large enough that both are above the least radius.
    let camera = Camera {
        position: ORIGIN,
        target: ORIGIN - DVec3::Z,
        up: DVec3::Y,
        fov_y_degrees: 60.0,
        near: 0.1,
        far: 100.0,
        size: SIZE * 10,
    };
    products.gbuffer = GBuffer::empty(camera.pinhole(ORIGIN).expect("a camera"));
    products.radiance = Grid::new(SIZE * 10, Vec4::W);
    let picture = painted(Buffer::VirtualLights, &products).picture;
    // Pixels at the edge count as far as they are covered.
    let of = |left: bool| {
        let pixels = picture.values().iter().enumerate();
        let half = pixels.filter(|(i, _)| (i % 2000 < 1000) == left);
        half.map(|(_, p)| f32::from(p[0])).sum::<f32>()
    };
    let ratio = of(false) / of(true);
    assert!((ratio - 4.0).abs() < 0.2, "areas are as fluxes, 4: {ratio}");
}

#[test]
fn a_light_behind_a_wall_is_faint_and_yields_to_one_before_it() {
    let behind = frame(1.0, vec![light(RED, Vec3::X)], Vec::new());
    let picture = painted(Buffer::VirtualLights, &behind).picture;
    let [red, ..] = picture.get(125, 37).copied().expect("a pixel");
    assert!((40..120).contains(&red), "{red} of 255");
    let before = light(RED * 0.4, Vec3::X);
    let both = frame(1.0, vec![light(RED, Vec3::X), before], Vec::new());
    let hidden: Vec<bool> = marks(&both).map(|mark| mark.hidden).collect();
    assert_eq!(hidden, [true, false]);
    assert_eq!(nearest(&both, RED_AT).map(|mark| mark.light), Some(1));
    let aside = frame(
        1.0,
        vec![light(Vec3::Z, Vec3::X), light(Vec3::X, Vec3::X)],
        Vec::new(),
    );
    assert_eq!(marks(&aside).count(), 0, "behind the camera, and beside it");
}

/// Two maps of 16 x 16: 2 everywhere, and nothing but 4 in the last row.
fn two_maps() -> Products {
    let mut distances = Grid::new(UVec2::new(16, 32), f32::INFINITY);
    distances.values_mut()[..256].fill(2.0);
    distances.values_mut()[31 * 16..].fill(4.0);
    let maps = ShadowMaps {
        bounce: 1,
        first_light: 1,
        distances,
    };
    let lights = [Vec3::ZERO, RED, Vec3::X].map(|at| light(at, Vec3::ONE));
    frame(2.0, lights.to_vec(), vec![maps])
}

#[test]
fn a_map_is_painted_by_distance_and_says_what_a_texel_shows() {
    // Two squares of 100 pixels side by side, a map of 99 in each.
    let products = two_maps();
    let painted = painted(Buffer::ShadowMaps, &products);
    assert_eq!(painted.scale, Some((2.0, 4.0)));
    let pixel = |x, y| painted.picture.get(x, y).copied();
    assert_eq!(pixel(50, 50), Some([68, 1, 84, 255]), "the least distance");
    assert_eq!(pixel(150, 50), Some([48, 48, 48, 255]), "nothing");
    assert_eq!(pixel(150, 98), Some([253, 231, 37, 255]), "the largest");
    assert_eq!(pixel(99, 50), Some([0, 0, 0, 255]), "between the maps");

    let probe = |x, y| Probe::new(&products, ORIGIN, UVec2::new(x, y), Buffer::ShadowMaps);
    let first = probe(52, 52);
    assert_eq!(line(&first, "light"), "2 of 3");
    assert_eq!(line(&first, "texel"), "8, 8 of 16 x 16");
    assert_eq!(line(&first, "distance"), "2.0000");
    // u = v = 1/16; (2u, 2v, 1 - 2u^2) / (1 + 2u^2) is (16, 16, 127) / 129; twice that from the light.
    let [x, y, z] = [
        0.5 + 32.0 / 129.0,
        0.25 + 32.0 / 129.0,
        -2.0 + 254.0 / 129.0,
    ];
    let shows = format!(
        "{:.4}  {:.4}  {:.4}",
        432_000.0 + x,
        5_300_000.0 + y,
        600.0 + z
    );
    assert_eq!(line(&first, "shows"), shows);
    assert_eq!(first.position, None, "the camera does not see it there");
    assert_eq!(line(&probe(150, 50), "light"), "3 of 3");
    assert_eq!(line(&probe(150, 50), "distance"), "nothing there");
    assert_eq!(probe(99, 50).lines, [], "between the maps");
}

#[test]
fn maps_that_no_picture_holds_are_no_trouble() {
    let distances = Grid::new(UVec2::new(1, 60_000), 1.0);
    let maps = ShadowMaps {
        bounce: 0,
        first_light: 0,
        distances,
    };
    let products = frame(1.0, Vec::new(), vec![maps]);
    let painted = painted(Buffer::ShadowMaps, &products);
    assert_eq!(painted.picture.size(), SIZE);
    for pixel in [UVec2::ZERO, SIZE - 1, SIZE, UVec2::MAX] {
        let probe = Probe::new(&products, ORIGIN, pixel, Buffer::ShadowMaps);
        assert_eq!(probe.lines, [], "no light has that map");
        let probe = Probe::new(&products, ORIGIN, pixel, Buffer::VirtualLights);
        assert_eq!(line(&probe, "light"), "", "there is none");
    }
}

fn colours(buffer: Buffer, viewer: &Viewer) -> usize {
    let shown = viewer.shown.as_ref().expect("a frame");
    let picture = painted(buffer, &shown.products).picture;
    picture.values().iter().collect::<BTreeSet<_>>().len()
}

fn with_lights(window: &mut Harness<'_, Viewer>, count: i64) {
    let settings = window.state().settings().clone();
    let settings = settings.with("gi.vpl_count", toml::Value::Integer(count));
    window
        .state_mut()
        .change(settings.expect("a count"), "gi.vpl_count");
}

#[test]
fn lights_and_maps_come_when_their_layer_is_chosen_and_stay_while_the_camera_moves() {
    let (mut window, _) = opened("vpls");
    let told = |v: &Viewer| {
        let products = v.shown.as_ref().map(|s| Arc::clone(&s.products));
        products.and_then(|p| p.virtual_lights.clone())
    };
    window.state_mut().set_buffer(Buffer::VirtualLights);
    until(&mut window, "a frame", |v| {
        v.shown
            .as_ref()
            .is_some_and(|s| s.request.buffer == v.buffer)
            && is_at_rest(v)
    });
    window.run_steps(2);
    let reason = "There are no virtual lights: gi.vpl_count is 0.";
    assert!(
        window.query_by_label(reason).is_some(),
        "why there are none"
    );

    with_lights(&mut window, 24);
    until(&mut window, "lights", |v| {
        told(v).is_some() && is_at_rest(v)
    });
    window.run_steps(2);
    assert!(
        window.query_by_label_contains("by bounce").is_some(),
        "how many"
    );
    assert!(colours(Buffer::VirtualLights, window.state()) > 2);

    window.hover_at(Pos2::new(520.0, 350.0));
    window.run_steps(2);
    let v = window.state();
    let shown = v.shown.as_ref().expect("a frame");
    let probe = v.probe.as_ref().expect("what is under the cursor");
    let (x, y) = probe.lines[0]
        .1
        .split_once(", ")
        .map(|(x, y)| (x.parse(), y.parse()))
        .expect("a pixel");
    let pixel = UVec2::new(x.expect("a column"), y.expect("a row"));
    let pinhole = &shown.products.gbuffer.pinhole;
    let lights = &shown
        .products
        .virtual_lights
        .as_ref()
        .expect("lights")
        .lights;
    let away = |light: &VirtualLight| {
        let view = pinhole.view_from_world(light.vpl.position);
        let place = pinhole.pixel_from_view(view);
        let seen = view.z > 0.0 && place.cmpge(glam::Vec2::ZERO).all();
        let seen = seen && place.cmplt(pinhole.size.as_vec2()).all();
        seen.then(|| place.distance(pixel.as_vec2() + 0.5))
    };
    let number: usize = line(probe, "light")
        .split(' ')
        .next()
        .expect("a number")
        .parse()
        .expect("a number");
    let found = away(&lights[number - 1]).expect("in the picture");
    let least = lights.iter().filter_map(away).fold(f32::INFINITY, f32::min);
    // Up to the difference of two discs.
    assert!(
        found < least + 0.007 * pinhole.size.y as f32,
        "{found} pixels away, another {least}"
    );

    window.state_mut().navigator.orbit(0.3, 0.0);
    window.state_mut().touch();
    until(&mut window, "a quick frame", |v| {
        v.shown.as_ref().is_some_and(|s| !s.request.whole)
    });
    assert!(told(window.state()).is_some(), "while the camera moves");
    until(&mut window, "all of the new view", is_at_rest);

    window.state_mut().set_buffer(Buffer::ShadowMaps);
    window.run_steps(2);
    assert!(
        window.state().under_way.is_none(),
        "they have come with the lights"
    );
    assert!(colours(Buffer::ShadowMaps, window.state()) > 2);
    let camera = window.state().camera();
    window.drag_at(Pos2::new(520.0, 350.0));
    window.step();
    window.hover_at(Pos2::new(560.0, 380.0));
    window.step();
    window.drop_at(Pos2::new(560.0, 380.0));
    window.run_steps(2);
    assert_eq!(
        window.state().camera(),
        camera,
        "maps are not looked around in"
    );

    with_lights(&mut window, 0);
    until(&mut window, "no lights", |v| {
        told(v).is_none() && is_at_rest(v)
    });
    assert_eq!(colours(Buffer::ShadowMaps, window.state()), 1, "black");
}

#[test]
fn two_settings_are_compared_by_their_lights() {
    let (mut window, _) = opened("vpls-compared");
    with_lights(&mut window, 24);
    let fewer = window.state().settings().clone();
    let fewer = fewer
        .with("gi.vpl_count", toml::Value::Integer(8))
        .expect("a count");
    until(&mut window, "a picture", is_at_rest);
    window.state_mut().compare_with("fewer", fewer);
    window.state_mut().set_buffer(Buffer::ShadowMaps);
    let compared = |v: &Viewer| {
        let second = v.second.as_ref().filter(|s| s.texture.is_some());
        let told = second.and_then(|s| s.shown.as_ref()?.products.virtual_lights.clone());
        told.is_some_and(|told| told.lights.iter().filter(|l| l.bounce == 1).count() == 8)
    };
    until(&mut window, "both", compared);
}
