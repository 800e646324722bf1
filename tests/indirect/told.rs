//! Virtual lights and shadow maps, as a frame tells them: in the furnace all of them are known on paper.

use catoptric::gi::virtual_lights::{ShadowMaps, VirtualLight, VirtualLights};
use catoptric::job::Job;
use catoptric::plan::{Plan, SceneFacts};
use catoptric::renderer::{BackendChoice, Renderer};
use catoptric::settings::Settings;
use glam::Vec3;
use libtest_mimic::Trial;

use super::furnace::{ball, in_the_centre, lit_by, view};
use crate::support::{claim, gpu_is_missing};

const POINTS: usize = 30_000;
const VPLS: u32 = 64;
const SIDE: u32 = 64;

/// Of each bounce 2^17 texels are kept.
const MAPS: usize = 32;

pub(super) fn tests() -> Vec<Trial> {
    let on_gpu = |name: &str, check: fn()| {
        let run = move || {
            check();
            Ok(())
        };
        Trial::test(format!("indirect::{name}"), run).with_ignored_flag(gpu_is_missing())
    };
    vec![
        claim("indirect::told_lights_are_those_of_paper_on_cpu", || {
            told_lights_are_those_of_paper(&BackendChoice::Cpu);
        }),
        on_gpu("told_lights_are_those_of_paper_on_gpu", || {
            told_lights_are_those_of_paper(&BackendChoice::Gpu(None));
        }),
        on_gpu(
            "both_backends_tell_the_same_lights",
            both_backends_tell_the_same_lights,
        ),
        claim(
            "indirect::who_does_not_ask_is_told_no_lights",
            who_does_not_ask_is_told_no_lights,
        ),
    ]
}

/// What a frame of the furnace tells.
fn told(choice: &BackendChoice, settings: &Settings, asks: bool) -> Option<VirtualLights> {
    let surfels = ball(POINTS, 0.5, None);
    let view = view(in_the_centre());
    let facts = SceneFacts {
        points: surfels.len() as u64,
        mirror_points: 0,
        lights: view.lights.len(),
        environment: false,
    };
    let mut plan = Plan::new(&facts, settings);
    if asks {
        plan.ask_for_virtual_lights();
    }
    let mut renderer = Renderer::new(choice, &surfels).expect("a backend");
    let products = renderer
        .render(&view, &plan, settings, &Job::default())
        .expect("a picture");
    products.virtual_lights.map(|lights| (*lights).clone())
}

fn settings() -> Settings {
    let mut settings = lit_by(VPLS, 2);
    settings.gi.ism_size = SIDE;
    settings
}

fn of_bounce(told: &VirtualLights, bounce: u32) -> Vec<VirtualLight> {
    let lights = told.lights.iter().filter(|light| light.bounce == bounce);
    lights.copied().collect()
}

/// Texels by how they compare with paper.
#[derive(Debug, Default)]
struct Texels {
    right: usize,
    wrong: usize,
    empty: usize,
}

/// How far the unit ball is from a place in it.
fn to_the_ball(from: Vec3, towards: Vec3) -> f32 {
    let along = from.dot(towards);
    (along * along + 1.0 - from.length_squared()).sqrt() - along
}

fn compare(told: &VirtualLights, maps: &ShadowMaps) -> Texels {
    let mut texels = Texels::default();
    let side = maps.side();
    for index in 0..maps.count() {
        let light = &told.lights[maps.first_light + index];
        let map = maps.map(index).expect("a map");
        for (i, &distance) in map.iter().enumerate() {
            let (column, row) = ((i % side) as u32, (i / side) as u32);
            let from = light.vpl.position;
            let towards = light.shown_at(column, row, side as u32, 1.0) - from;
            // Flatter ones fall on discs that stand out from the ball.
            if towards.dot(light.vpl.normal) < 0.3 {
                continue;
            }
            let paper = to_the_ball(from, towards);
            if distance.is_infinite() {
                texels.empty += 1;
            } else if (distance - paper).abs() < 0.03 {
                texels.right += 1;
            } else {
                texels.wrong += 1;
            }
        }
    }
    texels
}

fn told_lights_are_those_of_paper(choice: &BackendChoice) {
    let told = told(choice, &settings(), true).expect("lights");
    // 4 pi steradians of pi W/sr, half of which is reflected; of that, half again.
    let sent = 4.0 * std::f32::consts::PI * std::f32::consts::PI;
    for (bounce, count, flux) in [(1, VPLS, sent / 2.0), (2, VPLS / 2, sent / 4.0)] {
        let lights = of_bounce(&told, bounce);
        let off = lights.len().abs_diff(count as usize);
        assert!(off <= 1, "{} lights of bounce {bounce}", lights.len());
        let sum: f32 = lights.iter().map(|light| light.vpl.flux.x).sum();
        assert!(
            (sum / flux - 1.0).abs() < 0.03,
            "bounce {bounce} reflects {sum} W, on paper {flux}"
        );
        for light in &lights {
            let at = light.vpl.position;
            assert!((at.length() - 1.0).abs() < 0.02, "on the ball: {at}");
            assert!(light.vpl.normal.dot(-at) > 0.99, "looks inwards: {light:?}");
        }
    }
    assert_eq!(
        told.lights.len(),
        of_bounce(&told, 1).len() + of_bounce(&told, 2).len()
    );
    let bounces: Vec<u32> = told.maps.iter().map(|maps| maps.bounce).collect();
    assert_eq!(bounces, [1, 2]);
    assert_eq!(told.maps[0].count(), MAPS, "fewer than lights");
    assert_eq!(told.maps[1].first_light, of_bounce(&told, 1).len());
    for maps in &told.maps {
        let texels = compare(&told, maps);
        println!("bounce {}: {texels:?}", maps.bounce);
        assert!(texels.right > 3 * texels.empty, "{texels:?}");
        assert!(texels.wrong * 100 < texels.right, "{texels:?}");
    }
    let mut turned = told.clone();
    for light in &mut turned.lights {
        light.vpl.normal = Vec3::X;
    }
    let texels = compare(&turned, &told.maps[0]);
    assert!(
        texels.wrong > texels.right,
        "turned lights are noticed: {texels:?}"
    );
}

fn both_backends_tell_the_same_lights() {
    let of = |choice| told(choice, &settings(), true).expect("lights");
    let (cpu, gpu) = (of(&BackendChoice::Cpu), of(&BackendChoice::Gpu(None)));
    let (a, b) = (of_bounce(&cpu, 1), of_bounce(&gpu, 1));
    assert_eq!(a.len(), b.len());
    // What the lamp sees is rounded otherwise, so that a light may be drawn from the next texel.
    let near = |(a, b): &(&VirtualLight, &VirtualLight)| {
        let flux = (a.vpl.flux - b.vpl.flux).length() < 1e-3 * a.vpl.flux.length();
        a.vpl.position.distance(b.vpl.position) < 1e-3 && flux
    };
    let same = a.iter().zip(&b).filter(near).count();
    assert!(same * 50 >= a.len() * 49, "{same} of {} lights", a.len());
    let (a, b) = (&cpu.maps[0].distances, &gpu.maps[0].distances);
    assert_eq!(a.size(), b.size());
    let same = |(a, b): &(&f32, &f32)| a == b || (*a - *b).abs() < 2e-3 * a.abs();
    let texels = a.values().iter().zip(b.values()).filter(same).count();
    println!("{texels} of {} texels", a.values().len());
    assert!(
        texels * 50 >= a.values().len() * 49,
        "{texels} of {} texels",
        a.values().len()
    );
}

fn who_does_not_ask_is_told_no_lights() {
    let dark = lit_by(0, 2);
    for (settings, asks, lights) in [
        (settings(), true, true),
        (settings(), false, false),
        (dark, true, false),
    ] {
        let told = told(&BackendChoice::Cpu, &settings, asks);
        assert_eq!(
            told.is_some(),
            lights,
            "asks: {asks}, {} lights",
            settings.gi.vpl_count
        );
    }
}
