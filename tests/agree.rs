//! The same picture from one thread as from two, and from both backends, of the scenes as they are delivered.

use std::path::Path;

use catoptric::image::picture;
use catoptric::job::Job;
use catoptric::renderer::{BackendChoice, Products, Renderer};
use catoptric::scene::{Override, Scene};
use libtest_mimic::{Failed, Trial};

use crate::support::gpu_is_missing;

pub(crate) fn tests() -> Vec<Trial> {
    let mut trials = vec![Trial::test(
        "agree::one_thread_and_two_draw_the_same_bytes",
        one_thread_and_two_draw_the_same_bytes,
    )];
    for scene in ["sphere", "multi", "plane"] {
        let name = format!("agree::{scene}_agrees_on_both_backends");
        let test = move || agrees_on_both_backends(scene);
        trials.push(Trial::test(name, test).with_ignored_flag(gpu_is_missing()));
    }
    trials
}

/// A delivered scene, thinned for speed.
fn render(scene: &str, choice: &BackendChoice) -> Result<(Products, Vec<[u8; 4]>), Failed> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("pointclouds/{scene}.toml"));
    let set = |key: &str, value: &str| Override::new(key, value, "the test");
    let thinned = [
        set("cloud.0.points", "300000")?,
        set("camera.size", "400x300")?,
    ];
    let scene = Scene::open(&file, &thinned)?;
    let job = Job::default();
    let loaded = scene.load(&job)?;
    let mut renderer = Renderer::new(choice, &loaded.surfels)?;
    let products = renderer.render(
        &loaded.view()?,
        &loaded.plan(&scene.settings),
        &scene.settings,
        &job,
    )?;
    let shown = picture(&products.radiance, &scene.settings.image).into_vec();
    Ok((products, shown))
}

fn one_thread_and_two_draw_the_same_bytes() -> Result<(), Failed> {
    let with = |threads: usize| -> Result<(Products, Vec<[u8; 4]>), Failed> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        pool.install(|| render("sphere", &BackendChoice::Cpu))
    };
    let (one, two) = (with(1)?, with(2)?);
    assert_eq!(one.1, two.1, "the pictures differ");
    assert_eq!(
        one.0.gbuffer.surface, two.0.gbuffer.surface,
        "the G-buffers differ"
    );
    assert_eq!(one.0.radiance, two.0.radiance, "the radiances differ");
    Ok(())
}

/// Pixels outside of mirrors whose values differ by more than one of 255.
fn differing(a: &[[u8; 4]], b: &[[u8; 4]], mirror: impl Fn(usize) -> bool) -> usize {
    let apart = |(a, b): (&[u8; 4], &[u8; 4])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 1);
    a.iter()
        .zip(b)
        .enumerate()
        .filter(|(i, pair)| !mirror(*i) && apart(*pair))
        .count()
}

fn agrees_on_both_backends(scene: &str) -> Result<(), Failed> {
    let (cpu, gpu) = (
        render(scene, &BackendChoice::Cpu)?,
        render(scene, &BackendChoice::Gpu(None))?,
    );
    let mirror = |i: usize| {
        let of = |p: &Products| p.gbuffer.albedo.values().get(i).is_some_and(|a| a.w > 0.0);
        of(&cpu.0) || of(&gpu.0)
    };
    let most = cpu.1.len() / 10_000;
    let off = differing(&cpu.1, &gpu.1, mirror);
    println!("{scene}: {off} pixels differ by more than 1 of 255");
    assert!(off <= most, "{off} pixels differ, and {most} may");

    // What the mirrors show may differ where a flipped curvature reorders regions, but not by much on the whole.
    let mean = |p: &Products| {
        let seen = (0..p.radiance.values().len()).filter(|&i| mirror(i));
        seen.map(|i| f64::from(p.radiance.values()[i].truncate().element_sum()))
            .sum::<f64>()
    };
    let (a, b) = (mean(&cpu.0), mean(&gpu.0));
    assert!(
        (a / b - 1.0).abs() < 0.02,
        "the mirrors' light differs: {a} and {b}"
    );

    // The negative control: a picture two levels brighter in one row is noticed.
    let mut brighter = gpu.1.clone();
    brighter
        .iter_mut()
        .take(400)
        .for_each(|p| p[0] = p[0].saturating_add(2));
    assert!(
        differing(&cpu.1, &brighter, mirror) > most,
        "a brighter row is not noticed"
    );
    Ok(())
}
