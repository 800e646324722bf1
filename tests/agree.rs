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
    for (scene, search) in [
        ("sphere", "interleaved"),
        ("sphere", "guided"),
        ("multi", "guided"),
        ("plane", "interleaved"),
    ] {
        let name = format!("agree::{scene}_{search}_agrees_on_both_backends");
        let test = move || agrees_on_both_backends(scene, search);
        trials.push(Trial::test(name, test).with_ignored_flag(gpu_is_missing()));
    }
    trials
}

/// A delivered scene, thinned for speed.
fn render(scene: &str, choice: &BackendChoice) -> Result<(Products, Vec<[u8; 4]>), Failed> {
    render_with(scene, choice, &[])
}

/// The same with more settings.
fn render_with(
    scene: &str,
    choice: &BackendChoice,
    settings: &[(&str, &str)],
) -> Result<(Products, Vec<[u8; 4]>), Failed> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("pointclouds/{scene}.toml"));
    let set = |key: &str, value: &str| Override::new(key, value, "the test");
    let mut thinned = vec![
        set("cloud.0.points", "300000")?,
        set("camera.size", "400x300")?,
    ];
    for (key, value) in settings {
        thinned.push(set(key, value)?);
    }
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

/// How near the reflected albedo is to the traced one where both show something, dB.
fn psnr(products: &Products, traced: &Products) -> f64 {
    let (Some(got), Some(expected)) = (&products.mirror, &traced.mirror) else {
        return f64::NAN;
    };
    let (mut sum, mut count) = (0.0, 0.0);
    for i in 0..got.albedo.values().len() {
        if let (Some(a), Some(b)) = (got.at(i), expected.at(i)) {
            let apart = (a.albedo - b.albedo).truncate();
            sum += f64::from(apart.length_squared());
            count += 3.0;
        }
    }
    10.0 * (count / sum).log10()
}

fn agrees_on_both_backends(scene: &str, search: &str) -> Result<(), Failed> {
    let searched = [("reflect.method", "sscr"), ("sscr.search", search)];
    let (cpu, gpu) = (
        render_with(scene, &BackendChoice::Cpu, &searched)?,
        render_with(scene, &BackendChoice::Gpu(None), &searched)?,
    );
    let mirror = |i: usize| {
        let of = |p: &Products| p.gbuffer.albedo.values().get(i).is_some_and(|a| a.w > 0.0);
        of(&cpu.0) || of(&gpu.0)
    };
    let most = cpu.1.len() / 10_000;
    let off = differing(&cpu.1, &gpu.1, mirror);
    println!("{scene}, {search}: {off} pixels differ by more than 1 of 255");
    assert!(off <= most, "{off} pixels differ, and {most} may");

    // The mirrors: nearly every pixel, and the quality beside the traced reference.
    let seen = (0..cpu.1.len()).filter(|&i| mirror(i)).count();
    let everywhere = differing(&cpu.1, &gpu.1, |_| false);
    println!("{scene}, {search}: with mirrors {everywhere}, of {seen} mirror pixels");
    assert!(
        (everywhere - off) * 100 <= seen,
        "{everywhere} pixels differ"
    );
    let traced = render_with(
        scene,
        &BackendChoice::Cpu,
        &[("reflect.method", "ray_trace")],
    )?
    .0;
    let quality = |p: &Products| psnr(p, &traced);
    let (a, b) = (quality(&cpu.0), quality(&gpu.0));
    println!("{scene}, {search}: reflected albedo {a:.3} dB on the CPU, {b:.3} dB on the GPU");
    assert!((a - b).abs() <= 0.1, "{a} and {b} dB");

    // The negative control: larger splats or fewer points blur the mirrors by more than that.
    let fewer = [
        ("reflect.method", "sscr"),
        ("sscr.search", search),
        ("sscr.max_splat", "5"),
        ("sscr.points_per_pixel", "2"),
    ];
    let blurred = quality(&render_with(scene, &BackendChoice::Gpu(None), &fewer)?.0);
    assert!((a - blurred).abs() > 0.1, "{a} and, blurred, {blurred} dB");

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
