//! Light from everywhere: answers known on paper, what is shown where nothing is seen, and both backends alike.

#[path = "environment/contact.rs"]
mod contact;

use std::f32::consts::PI;
use std::f64::consts::PI as PI64;
use std::path::Path;
use std::sync::Arc;

use catoptric::backend::Backend;
use catoptric::backend::cpu::Cpu;
use catoptric::camera::Camera;
use catoptric::cloud::{Finish, Place, Surfel, Surfels};
use catoptric::error::Error;
use catoptric::frame::View;
use catoptric::gbuffer::EMPTY;
use catoptric::gi::environment::{Environment, Sky};
use catoptric::gi::gather::Gathered;
use catoptric::gi::ism::{IsmMaps, Slices};
use catoptric::gi::receivers::Receivers;
use catoptric::grid::Grid;
use catoptric::job::Job;
use catoptric::output::ExrImage;
use catoptric::plan::{Plan, SceneFacts};
use catoptric::renderer::{BackendChoice, Products, Renderer};
use catoptric::scene::{Override, Scene};
use catoptric::settings::Settings;
use glam::{DVec3, UVec2, Vec3, Vec4};
use libtest_mimic::{Failed, Trial};

use crate::support::{claim, gpu_is_missing};

const SIZE: UVec2 = UVec2::new(96, 72);

/// Radiance of the even sky.
const SKY: f32 = 0.8;

/// Of all surfaces.
const ALBEDO: f32 = 0.5;

pub(crate) fn tests() -> Vec<Trial> {
    let on_gpu = |name: &'static str, test: fn(&BackendChoice)| {
        let test = move || {
            test(&BackendChoice::Gpu(None));
            Ok(())
        };
        Trial::test(name, test).with_ignored_flag(gpu_is_missing())
    };
    vec![
        claim("environment::a_plane_shows_its_albedo_on_cpu", || {
            a_plane_shows_its_albedo(&BackendChoice::Cpu);
        }),
        on_gpu(
            "environment::a_plane_shows_its_albedo_on_gpu",
            a_plane_shows_its_albedo,
        ),
        claim("environment::a_bowl_sees_half_of_the_sky_on_cpu", || {
            a_bowl_sees_half_of_the_sky(&BackendChoice::Cpu);
        }),
        on_gpu(
            "environment::a_bowl_sees_half_of_the_sky_on_gpu",
            a_bowl_sees_half_of_the_sky,
        ),
        claim(
            "environment::a_closed_ball_is_dark_inside",
            a_closed_ball_is_dark_inside,
        ),
        claim(
            "environment::contact_shadows_of_things_an_eighth_of_the_scene_wide_are_dark",
            contact::contact_shadows_of_things_an_eighth_of_the_scene_wide_are_dark,
        ),
        claim(
            "environment::nothing_shows_the_sky_unless_a_background_is_asked_for",
            nothing_shows_the_sky_unless_a_background_is_asked_for,
        ),
        claim(
            "environment::a_map_is_read_from_the_folder_of_the_scene",
            a_map_is_read_from_the_folder_of_the_scene,
        ),
        claim(
            "environment::refusals_name_file_and_line",
            refusals_name_file_and_line,
        ),
        Trial::test("environment::both_backends_agree", both_backends_agree)
            .with_ignored_flag(gpu_is_missing()),
    ]
}

/// Surfels at positions with normals, in an order that makes slices samples.
fn surfels(mut all: Vec<(DVec3, DVec3)>, spacing: f64) -> Arc<Surfels> {
    let mut state = 3u64;
    for i in (1..all.len()).rev() {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        all.swap(i, ((state >> 33) % (i as u64 + 1)) as usize);
    }
    let place = |(position, _): &(DVec3, DVec3)| Place {
        position: position.as_vec3(),
        radius: spacing as f32,
    };
    let finish = |(position, normal): &(DVec3, DVec3)| {
        Finish::pack(&Surfel {
            position: position.as_vec3(),
            radius: spacing as f32,
            normal: normal.as_vec3(),
            albedo: Vec3::splat(ALBEDO),
            mirror: 0.0,
            specular: 0.0,
            shininess: 0.0,
        })
    };
    Arc::new(Surfels {
        places: all.iter().map(place).collect(),
        finishes: all.iter().map(finish).collect(),
        source: (0..all.len() as u32).collect(),
        origin: DVec3::ZERO,
    })
}

/// The inside of the part of the unit ball up to this height.
fn ball(top: f64) -> Arc<Surfels> {
    let count = 100_000;
    let golden = PI64 * (3.0 - 5f64.sqrt());
    let point = |i: usize| {
        let z = -1.0 + (top + 1.0) * (i as f64 + 0.5) / f64::from(count);
        let (sin, cos) = (golden * i as f64).sin_cos();
        let level = (1.0 - z * z).sqrt();
        let out = DVec3::new(level * cos, level * sin, z);
        (out, -out)
    };
    let area = 2.0 * PI64 * (top + 1.0);
    let points = (0..count as usize).map(point).collect();
    surfels(points, (area / f64::from(count)).sqrt())
}

fn even() -> Arc<Environment> {
    let sky = Sky::Gradient {
        zenith: Vec3::splat(SKY),
        horizon: Vec3::splat(SKY),
    };
    Arc::new(Environment::new(sky, Vec3::Z))
}

fn view(eye: DVec3, target: DVec3, bounds: (Vec3, Vec3)) -> View {
    let camera = Camera {
        position: eye,
        target,
        up: DVec3::Y,
        fov_y_degrees: 50.0,
        near: 0.01,
        far: 100.0,
        size: SIZE,
    };
    View {
        pinhole: camera.pinhole(DVec3::ZERO).expect("a sound camera"),
        lights: Vec::new(),
        environment: Some(even()),
        bounds,
    }
}

fn render(
    surfels: &Arc<Surfels>,
    view: &View,
    (bounces, interleave): (u32, u32),
    choice: &BackendChoice,
) -> Products {
    let facts = SceneFacts {
        points: surfels.len() as u64,
        mirror_points: 0,
        lights: 0,
        environment: true,
    };
    let mut settings = Settings::default();
    settings.gi.bounces = bounces;
    settings.gi.interleave = interleave;
    let plan = Plan::new(&facts, &settings);
    let mut renderer = Renderer::new(choice, surfels).expect("a backend");
    renderer
        .render(view, &plan, &settings, &Job::default())
        .expect("a picture")
}

/// Mean, and the largest deviation from it, of the pixels that show a surface.
fn shown(products: &Products) -> (f32, f32) {
    let pixels = products.radiance.values().iter();
    let seen = pixels.zip(products.gbuffer.material.values());
    let values: Vec<f32> = seen.filter(|(_, m)| m.w > 0.0).map(|(v, _)| v.x).collect();
    assert!(values.len() > 1000, "{} pixels", values.len());
    let mean = values.iter().sum::<f32>() / values.len() as f32;
    let worst = values.iter().map(|v| (v - mean).abs()).fold(0.0, f32::max);
    (mean, worst)
}

fn a_plane_shows_its_albedo(choice: &BackendChoice) {
    let side = 200;
    let at = |i: i32| f64::from(i) / f64::from(side) * 2.0 - 1.0;
    let points = (0..side * side).map(|i| (DVec3::new(at(i % side), at(i / side), 0.0), DVec3::Z));
    let plane = surfels(points.collect(), 2.0 / f64::from(side));
    let bounds = (Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 0.0));
    let view = view(DVec3::new(0.0, -0.5, 2.2), DVec3::ZERO, bounds);
    for bounces_and_interleave in [(0, 1), (0, 4), (3, 4)] {
        let (mean, worst) = shown(&render(&plane, &view, bounces_and_interleave, choice));
        println!("{bounces_and_interleave:?}: {mean}, off by {worst}");
        let expected = ALBEDO * SKY;
        assert!((mean / expected - 1.0).abs() < 0.02, "got {mean}");
        // Interleaved pixels at the plane's edges lack neighbours that have gathered the rest.
        let off = if bounces_and_interleave.1 == 1 {
            0.02
        } else {
            0.25
        };
        assert!(worst / expected < off, "a pixel is off by {worst}");
    }
}

/// From every point of half a ball, its opening takes half of the cosine-weighted sky: radiance albedo L / 2, and with all
/// bounces albedo L / 2 / (1 - albedo / 2).
fn a_bowl_sees_half_of_the_sky(choice: &BackendChoice) {
    let bowl = ball(0.0);
    let bounds = (Vec3::NEG_ONE, Vec3::new(1.0, 1.0, 0.0));
    let view = view(
        DVec3::new(0.0, 0.0, 0.4),
        DVec3::new(0.0, 0.0, -1.0),
        bounds,
    );
    for (bounces, expected) in [
        (0, ALBEDO * SKY * 0.5),
        (12, ALBEDO * SKY * 0.5 / (1.0 - ALBEDO * 0.5)),
    ] {
        let (mean, worst) = shown(&render(&bowl, &view, (bounces, 4), choice));
        println!("{bounces} bounces: {mean} for {expected}, off by {worst}");
        assert!(
            (mean / expected - 1.0).abs() < 0.05,
            "{bounces} bounces: got {mean}, expected {expected}"
        );
    }
}

fn a_closed_ball_is_dark_inside() {
    let ball = ball(1.0);
    let view = view(DVec3::Z * 0.5, DVec3::NEG_Z, (Vec3::NEG_ONE, Vec3::ONE));
    let (bounced, _) = shown(&render(&ball, &view, (5, 4), &BackendChoice::Cpu));
    let products = render(&ball, &view, (0, 4), &BackendChoice::Cpu);
    let (mean, _) = shown(&products);
    println!("{mean}, with bounces {bounced}, of {}", ALBEDO * SKY);
    assert!(mean < 0.05 * ALBEDO * SKY, "light leaks in: {mean}");

    // The negative control: the same lights through maps that show nothing.
    let lights = even().vpls(view.bounds, 256);
    let slices = Slices::of(ball.len(), 16, 1);
    let maps = IsmMaps {
        slices,
        keys: Grid::new(UVec2::new(16, 16 * 256), EMPTY),
    };
    let mut gathered = Gathered {
        irradiance: Grid::new(SIZE, Vec4::ZERO),
        residual: Grid::new(SIZE, Vec4::ZERO),
    };
    let receivers = Receivers::<Cpu>::of(&products.gbuffer);
    Cpu::default()
        .gather(
            &receivers,
            &lights,
            &maps,
            1,
            &mut gathered,
            &Job::default(),
        )
        .expect("light");
    let sum: f32 = gathered.irradiance.values().iter().map(|v| v.x).sum();
    let unshadowed = sum / (SIZE.x * SIZE.y) as f32 / (PI * SKY);
    assert!(
        (unshadowed - 1.0).abs() < 0.02,
        "without visibility all of the sky is seen: {unshadowed}"
    );
}

/// A mirror ball over a room, seen with nothing around.
const OVER_A_ROOM: &str = r#"format = 1
[[cloud]]
generate = "sphere"
points = 100000
[[mirror]]
shape = "sphere"
centre = [0, 4, -1]
radius = 1
[camera]
position = [0, 4.5, 5]
target = [0, 3, -1]
size = [200, 150]
"#;

fn over_a_room(choice: &BackendChoice, keys: &[(&str, &str)]) -> Result<Products, Failed> {
    let given = keys.iter();
    let given = given.map(|(key, value)| Override::new(key, value, "the test"));
    let given = given.collect::<Result<Vec<_>, _>>()?;
    let scene = Scene::parse(OVER_A_ROOM, Path::new("room.toml"), &given)?;
    let loaded = scene.load(&Job::default())?;
    let mut renderer = Renderer::new(choice, &loaded.surfels)?;
    let plan = loaded.plan(&scene.settings);
    Ok(renderer.render(&loaded.view()?, &plan, &scene.settings, &Job::default())?)
}

const GRADIENT: [(&str, &str); 2] = [
    ("environment.zenith", "0.2,0.4,1"),
    ("environment.horizon", "1,0.8,0.6"),
];

fn nothing_shows_the_sky_unless_a_background_is_asked_for() {
    let cpu = |more: &[(&str, &str)]| {
        let keys = [&GRADIENT[..], more].concat();
        over_a_room(&BackendChoice::Cpu, &keys).expect("a picture")
    };
    // Black is a background like others.
    let (sky, asked) = (cpu(&[]), cpu(&[("image.background", "#000000")]));
    let environment = Environment::new(
        Sky::Gradient {
            zenith: Vec3::new(0.2, 0.4, 1.0),
            horizon: Vec3::new(1.0, 0.8, 0.6),
        },
        Vec3::Y,
    );
    let width = sky.gbuffer.size().x as usize;
    let mirror = sky.mirror.as_ref().expect("the camera sees the mirror");
    let (mut empty, mut mirrored) = (0, 0);
    for (i, (got, asked)) in (sky.radiance.values().iter())
        .zip(asked.radiance.values())
        .enumerate()
    {
        let reflectance = sky.gbuffer.albedo.values()[i].w;
        if sky.gbuffer.material.values()[i].w <= 0.0 {
            let towards = (sky.gbuffer).direction((i % width) as i32, (i / width) as i32);
            let expected = environment.radiance(towards.normalize()).extend(1.0);
            assert!((*got - expected).length() < 1e-5, "{got} for {expected}");
            assert_eq!(asked.w, 0.0, "a background that is asked for stays");
            empty += 1;
        } else if reflectance > 0.0 && mirror.origin.values()[i].w > 0.0 && mirror.at(i).is_none() {
            let towards = mirror.direction.values()[i].truncate();
            let expected = *asked + (environment.radiance(towards) * reflectance).extend(0.0);
            assert!((*got - expected).length() < 1e-5, "{got} for {expected}");
            mirrored += 1;
        } else {
            assert_eq!(got, asked, "what is seen does not depend on the background");
        }
    }
    println!("{empty} pixels see nothing, {mirrored} in the mirror");
    assert!(empty > 1000 && mirrored > 10, "{empty}, {mirrored}");
}

fn scene_with(environment: &str) -> String {
    format!(
        "format = 1\n[[cloud]]\ngenerate = \"sphere\"\npoints = 2000\n[environment]\n{environment}\n"
    )
}

fn a_map_is_read_from_the_folder_of_the_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let size = UVec2::new(8, 4);
    let radiance = |i: usize| Vec4::new(0.1 * i as f32, 1.0, 2.0, 1.0);
    let mut texels = Grid::new(size, Vec4::ZERO);
    for (i, texel) in texels.values_mut().iter_mut().enumerate() {
        *texel = radiance(i);
    }
    let image = ExrImage::picture(&texels, Settings::default().image.background);
    let bytes = image.encode(&Job::default()).expect("a file");
    std::fs::write(folder.path().join("sky.exr"), bytes).expect("written");
    let file = folder.path().join("room.toml");
    let load = |map: &str| {
        let text = scene_with(&format!("map = \"{map}\""));
        let scene = Scene::parse(&text, &file, &[]).expect("a scene");
        assert_eq!(scene.inputs().len(), 2, "the map is an input");
        scene.load(&Job::default())
    };
    let environment = load("sky.exr").expect("a map").environment.expect("light");
    // Column 4 of row 1 of 8 and 4: 22.5 degrees to the right of the middle, 22.5 above the horizon; y is up.
    let ((sin, cos), (up, level)) = (
        22.5f32.to_radians().sin_cos(),
        22.5f32.to_radians().sin_cos(),
    );
    let got = environment.radiance(Vec3::new(sin * level, up, -cos * level));
    assert!((got - radiance(12).truncate()).length() < 1e-4, "got {got}");
    std::fs::write(folder.path().join("broken.exr"), b"v/1\x01, not").expect("written");
    for (map, says) in [("missing.exr", "cannot read"), ("broken.exr", "broken.exr")] {
        let refusal = load(map).expect_err("refused").to_string();
        assert!(refusal.contains(says), "{refusal}");
    }
}

fn refusals_name_file_and_line() {
    for (environment, at, says) in [
        ("color = [1, 1, 1]", 6, "did you mean \"colour\""),
        ("banana = 1", 6, "its keys are colour, zenith"),
        ("colour = [1, 1]", 6, "[red, green, blue]"),
        ("colour = [1, 1, -1]", 6, "from 0 to 1e9"),
        (
            "colour = [1, 1, 1]\nmap = \"sky.exr\"",
            7,
            "both colour and map",
        ),
        (
            "zenith = [1, 1, 1]\ncolour = [1, 1, 1]",
            6,
            "both colour and zenith",
        ),
        ("zenith = [1, 1, 1]", 5, "needs a horizon"),
        ("", 5, "needs a colour"),
        ("map = 3", 6, "a path"),
    ] {
        match Scene::parse(&scene_with(environment), Path::new("room.toml"), &[]) {
            Err(Error::Scene {
                path,
                line,
                problem,
            }) => {
                assert_eq!(
                    (path.to_str(), line),
                    (Some("room.toml"), Some(at)),
                    "{problem}"
                );
                assert!(problem.contains(says), "{problem}");
            }
            other => panic!("{environment:?} gave {other:?}"),
        }
    }
}

/// Pixels of which a channel differs by more than a 255th.
fn differing(a: &Products, b: &Products) -> usize {
    let pairs = a.radiance.values().iter().zip(b.radiance.values());
    pairs
        .filter(|(a, b)| (**a - **b).abs().max_element() > 1.0 / 255.0)
        .count()
}

fn both_backends_agree() -> Result<(), Failed> {
    let cpu = over_a_room(&BackendChoice::Cpu, &GRADIENT)?;
    let gpu = over_a_room(&BackendChoice::Gpu(None), &GRADIENT)?;
    let (off, all) = (differing(&cpu, &gpu), cpu.radiance.values().len());
    println!("{off} of {all} pixels differ by more than 1 of 255");
    assert!(off <= all / 500, "{off} of {all} pixels differ");
    // The negative control: another sky is noticed.
    let zenith = [("environment.zenith", "0.5,0.5,0.5"), GRADIENT[1]];
    let other = over_a_room(&BackendChoice::Gpu(None), &zenith)?;
    assert!(differing(&cpu, &other) > all / 10, "another sky");
    Ok(())
}
