//! Pictures that are made in parts: what they show is what the whole shows.

use catoptric::Job;
use catoptric::grid::Grid;
use catoptric::measure::quality::{MirrorPicture, Reference};
use catoptric::renderer::{BackendChoice, Products, Renderer};
use catoptric::scene::Scene;
use glam::Vec4;
use libtest_mimic::Trial;

use crate::scene::set;
use crate::support::{claim, gpu_is_missing};

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim("parts::they_show_what_the_whole_shows", || {
            agree(&BackendChoice::Cpu);
        }),
        claim("parts::on_a_device_too", || {
            agree(&BackendChoice::Gpu(None));
        })
        .with_ignored_flag(gpu_is_missing()),
    ]
}

fn rendered(choice: &BackendChoice, part_size: u32) -> Products {
    let text = "format = 1\n[[cloud]]\ngenerate = \"sphere\"\npoints = 60000\n[[light]]\nkind = \"spot\"\n\
                position = [0.95, 0.6, 0]\ntarget = [-1, -0.6, 0]\nintensity = [9, 9, 9]\n[camera]\nposition = [0, 0, 0.9]\n\
                target = [0, 0, -1]\nsize = [640, 400]\n[settings.gi]\nvpl_count = 64\n[settings.reflect]\nmethod = \"sscr\"\n";
    let part = set(&format!("image.part_size={part_size}"));
    let scene = Scene::parse(text, "room.toml".as_ref(), &[part]).expect("a scene");
    let loaded = scene.load(&Job::default()).expect("points");
    let (view, mut plan) = (loaded.view().expect("a view"), loaded.plan(&scene.settings));
    plan.ask_for_virtual_lights();
    let mut renderer = Renderer::new(choice, &loaded.surfels).expect("a backend");
    renderer
        .render(&view, &plan, &scene.settings, &Job::default())
        .expect("a picture")
}

/// Share of the pixels that differ by more than `most` in any channel, relative to the brightest.
fn differ(a: &Grid<Vec4>, b: &Grid<Vec4>, most: f32) -> f64 {
    let brightest = a
        .values()
        .iter()
        .fold(0.0_f32, |m, v| m.max(v.abs().max_element()));
    let pairs = a.values().iter().zip(b.values());
    let off = pairs.filter(|(a, b)| (**a - **b).abs().max_element() > most * brightest);
    off.count() as f64 / a.values().len() as f64
}

/// A pixel to the left.
fn shifted(grid: &Grid<Vec4>) -> Grid<Vec4> {
    let mut values = grid.values().to_vec();
    values.rotate_left(1);
    Grid::from_vec(grid.size(), values).expect("a grid")
}

fn agree(choice: &BackendChoice) {
    let whole = rendered(choice, 4096);
    let parts = rendered(choice, 256);
    let told = parts.virtual_lights.as_ref();
    assert!(told.is_some_and(|told| !told.maps.is_empty()), "lights");
    assert!(
        parts.virtual_lights == whole.virtual_lights,
        "lights are those of the whole"
    );
    assert_eq!(parts.radiance.size(), whole.radiance.size());

    // What the camera sees: an edge may fall to the other side of a pixel's middle.
    let seen = differ(&whole.gbuffer.surface, &parts.gbuffer.surface, 1e-3);
    let control = differ(
        &whole.gbuffer.surface,
        &shifted(&whole.gbuffer.surface),
        1e-3,
    );
    assert!(
        seen < 1e-3 && control > 0.1,
        "{seen} of the surface, {control} a pixel off"
    );
    let filled = whole.coverage.filled.abs_diff(parts.coverage.filled);
    assert!(filled < 100, "{:?} {:?}", whole.coverage, parts.coverage);

    // Light, with mirrors: each part searches by itself.
    let light = differ(&whole.radiance, &parts.radiance, 0.01);
    let control = differ(&whole.radiance, &shifted(&whole.radiance), 0.01);
    assert!(
        light < 1e-3 && control > 0.01,
        "{light} of the picture, {control} a pixel off"
    );

    // What mirrors show.
    let [of_whole, of_parts] = [&whole, &parts].map(|p| p.mirror.as_ref().expect("a mirror"));
    let origin = glam::DVec3::ZERO;
    let reference = Reference::of(of_whole, origin);
    let picture = MirrorPicture::new(of_parts, origin);
    let quality = reference.quality(&picture).expect("of one size");
    let psnr = reference.albedo_psnr(&picture).expect("of one size");
    println!(
        "surface {seen}, light {light}, mirrors {psnr} dB, recall {}",
        quality.recall
    );
    assert!(
        psnr > 25.0 && quality.coverage > 0.99,
        "{psnr} dB, {}",
        quality.coverage
    );

    // Regions of one part are not those of another.
    let size = of_parts.region.size();
    let in_part = |i: u32| (i % size.x / 256, i / size.x / 256);
    let mut first = std::collections::BTreeMap::new();
    let mut shared = 0;
    for (i, region) in of_parts
        .region
        .values()
        .iter()
        .enumerate()
        .filter(|(_, r)| **r > 0)
    {
        let part = *first.entry(*region).or_insert(in_part(i as u32));
        shared += u32::from(part != in_part(i as u32));
    }
    assert!(first.len() >= 4, "{} regions", first.len());
    let bounce = &parts.bounces[0];
    assert!(
        bounce.points_hit > 0 && bounce.hit_rate <= 1.0 && bounce.coverage <= 1.0,
        "{bounce:?}"
    );
    assert_eq!(shared, 0, "pixels of a region that another part has");
}
