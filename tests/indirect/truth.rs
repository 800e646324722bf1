//! Indirect light against what an independent renderer says of the same scenes (`CATOPTRIC_TRUTH` names the folder).

use std::path::{Path, PathBuf};

use catoptric::job::Job;
use catoptric::renderer::{BackendChoice, Renderer};
use catoptric::scene::{Override, Scene};
use glam::{UVec2, Vec3};
use libtest_mimic::{Failed, Trial};

use crate::npz::Npz;
use crate::support::folder;

const SIZE: UVec2 = UVec2::new(800, 600);

/// Side of the blocks in which pictures are compared, pixels.
const BLOCK: usize = 16;

pub(super) fn tests() -> Vec<Trial> {
    let unknown = folder("CATOPTRIC_TRUTH").is_none();
    let mut trials = Vec::new();
    for scene in ["sphere", "parabola", "plane"] {
        let name = format!("indirect::one_bounce_in_{scene}_is_that_of_the_truth");
        trials.push(Trial::test(name, move || one_bounce(scene)));
    }
    trials.push(Trial::test(
        "indirect::light_by_way_of_mirrors_is_that_of_the_truth",
        light_by_way_of_mirrors,
    ));
    trials.push(Trial::test(
        "indirect::five_bounces_are_those_of_the_truth",
        five_bounces,
    ));
    trials.push(Trial::test(
        "indirect::no_place_stands_out_with_the_defaults",
        no_place_stands_out,
    ));
    trials.push(Trial::test(
        "indirect::interleaved_pixels_are_as_the_others",
        interleaved_pixels_are_as_the_others,
    ));
    (trials.into_iter())
        .map(|t| t.with_ignored_flag(unknown))
        .collect()
}

/// Radiance of a delivered scene under these settings.
fn render(scene: &str, settings: &[(&str, &str)]) -> Result<Vec<Vec3>, Failed> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let overrides = settings
        .iter()
        .map(|(key, value)| Override::new(key, value, "the test"))
        .collect::<Result<Vec<_>, _>>()?;
    let scene = Scene::open(&root.join(format!("pointclouds/{scene}.toml")), &overrides)?;
    let job = Job::default();
    let loaded = scene.load(&job)?;
    let mut renderer = Renderer::new(&BackendChoice::Cpu, &loaded.surfels)?;
    let products = renderer.render(
        &loaded.view()?,
        &loaded.plan(&scene.settings),
        &scene.settings,
        &job,
    )?;
    Ok(products
        .radiance
        .values()
        .iter()
        .map(|v| v.truncate())
        .collect())
}

fn picture(path: &Path) -> Result<Vec<Vec3>, Failed> {
    let size = SIZE.x as usize;
    let image = exr::prelude::read_first_rgba_layer_from_file(
        path,
        |_, _| vec![Vec3::ZERO; (SIZE.x * SIZE.y) as usize],
        move |pixels, at, (r, g, b, _): (f32, f32, f32, f32)| {
            pixels[at.y() * size + at.x()] = Vec3::new(r, g, b);
        },
    )?;
    Ok(image.layer_data.channel_data.pixels)
}

/// Indirect light of the truth, and where it is compared: walls of one colour, not the picture's diagonals, which look exactly
/// along edges of the room.
struct Truth {
    indirect: Vec<Vec3>,
    albedo: Vec<Vec3>,
    counts: Vec<bool>,
}

impl Truth {
    fn read(scene: &str, reference: &str) -> Result<Self, Failed> {
        let folder: PathBuf = folder("CATOPTRIC_TRUTH").ok_or("no truth")?;
        let all = picture(&folder.join(format!("{scene}_{reference}.exr")))?;
        let direct = picture(&folder.join(format!("{scene}_direct4.exr")))?;
        let seen = Npz::open(&folder.join(format!("{scene}_aov.npz")))?;
        let (mirror, wall) = (seen.bytes("mirror")?, seen.bytes("prim_id")?);
        let counts = |i: usize| {
            let (x, y) = (i % SIZE.x as usize, i / SIZE.x as usize);
            let diagonal = (x as f64 - 399.5).abs() == (y as f64 - 299.5).abs();
            mirror[i] == 0 && wall[i] != 3 && wall[i] != 6 && !diagonal
        };
        let albedo = |wall: &u8| match wall {
            1 => Vec3::new(0.63, 0.065, 0.05),
            2 => Vec3::new(0.14, 0.45, 0.091),
            _ => Vec3::new(0.725, 0.71, 0.68),
        };
        Ok(Self {
            indirect: all.iter().zip(&direct).map(|(a, d)| *a - *d).collect(),
            albedo: wall.iter().map(albedo).collect(),
            counts: (0..all.len()).map(counts).collect(),
        })
    }

    /// Mean error of blocks over the mean, and error of the mean.
    fn errors(&self, got: &[Vec3]) -> (f64, f64) {
        let columns = SIZE.x as usize / BLOCK;
        let rows = SIZE.y as usize / BLOCK;
        let mut sums = vec![(Vec3::ZERO, 0); columns * rows];
        let (mut all, mut expected) = (0.0, 0.0);
        for i in (0..got.len()).filter(|&i| self.counts[i]) {
            all += f64::from(got[i].element_sum());
            expected += f64::from(self.indirect[i].element_sum());
            let (x, y) = (i % SIZE.x as usize / BLOCK, i / SIZE.x as usize / BLOCK);
            if y < rows {
                let block = &mut sums[y * columns + x];
                block.0 += got[i] - self.indirect[i];
                block.1 += 1;
            }
        }
        let off: Vec<f64> = sums
            .iter()
            .filter(|(_, count)| *count > BLOCK * BLOCK / 2)
            .map(|(sum, count)| f64::from(sum.abs().element_sum()) / 3.0 / *count as f64)
            .collect();
        let counted = self.counts.iter().filter(|c| **c).count() as f64;
        let mean = expected / 3.0 / counted;
        (
            off.iter().sum::<f64>() / off.len() as f64 / mean,
            all / expected - 1.0,
        )
    }

    /// By how much the brightest blotch is too bright, in any channel, over the mean of all: blocks a twelfth of the picture high.
    fn blotch(&self, got: &[Vec3]) -> f32 {
        const WIDE: usize = 48;
        let columns = SIZE.x as usize / WIDE;
        let mut sums = vec![(Vec3::ZERO, 0u32); columns * (SIZE.y as usize / WIDE)];
        let (mut all, mut count) = (0.0, 0u32);
        for i in (0..got.len()).filter(|&i| self.counts[i]) {
            all += self.indirect[i].element_sum() / 3.0;
            count += 1;
            let (x, y) = (i % SIZE.x as usize / WIDE, i / SIZE.x as usize / WIDE);
            if let Some(block) = sums.get_mut(y * columns + x).filter(|_| x < columns) {
                block.0 += got[i] - self.indirect[i];
                block.1 += 1;
            }
        }
        let mean = all / count as f32;
        (sums
            .iter()
            .filter(|(_, count)| *count as usize > WIDE * WIDE / 2))
        .map(|(sum, count)| sum.max_element() / *count as f32 / mean)
        .fold(0.0, f32::max)
    }

    /// The flat ambient that comes nearest.
    fn flat(&self) -> Vec<Vec3> {
        let (mut product, mut square) = (0.0, 0.0);
        for i in (0..self.counts.len()).filter(|&i| self.counts[i]) {
            product += self.albedo[i].dot(self.indirect[i]);
            square += self.albedo[i].length_squared();
        }
        self.albedo
            .iter()
            .map(|a| *a * (product / square))
            .collect()
    }
}

/// Indirect light of a delivered scene: its picture less that of its direct light.
fn indirect(scene: &str, settings: &[(&str, &str)]) -> Result<Vec<Vec3>, Failed> {
    let direct = render(scene, &[("gi.vpl_count", "0")])?;
    let all = render(scene, settings)?;
    Ok(all.iter().zip(&direct).map(|(a, d)| *a - *d).collect())
}

fn hold(what: &str, (block, mean): (f64, f64), bounds: (f64, f64)) -> Result<(), Failed> {
    let text = format!(
        "{what}: blocks off by {:.2} %, mean by {:+.2} %",
        block * 100.0,
        mean * 100.0
    );
    println!("{text}");
    if block <= bounds.0 && mean.abs() <= bounds.1 {
        Ok(())
    } else {
        Err(format!("{text}; bounds are {bounds:?}").into())
    }
}

const ABSORBING: [(&str, &str); 3] = [
    ("gi.vpl_count", "256"),
    ("gi.mirror_light", "false"),
    ("gi.bounces", "1"),
];

fn one_bounce(scene: &'static str) -> Result<(), Failed> {
    let truth = Truth::read(scene, "gi1n")?;
    let errors = truth.errors(&indirect(scene, &ABSORBING)?);
    hold(scene, errors, (0.07, 0.06))?;
    let flat = truth.errors(&truth.flat());
    if flat.0 < 0.2 {
        return Err(format!("a flat ambient passes: {flat:?}").into());
    }
    if scene != "sphere" {
        return Ok(());
    }
    // Maps that show one point shadow nothing.
    let blind = [ABSORBING.as_slice(), &[("gi.ism_points", "1")]].concat();
    let blind = truth.errors(&indirect(scene, &blind)?);
    println!("without visibility: {blind:?}");
    if blind.0 < 2.0 * errors.0 {
        return Err(format!("without visibility {blind:?}, with it {errors:?}").into());
    }
    let more = [&[("gi.vpl_count", "1024")], &ABSORBING[1..]].concat();
    hold(
        "1024 lights",
        truth.errors(&indirect(scene, &more)?),
        (0.045, 0.035),
    )
}

fn light_by_way_of_mirrors() -> Result<(), Failed> {
    let truth = Truth::read("sphere", "gi1")?;
    let errors = truth.errors(&indirect("sphere", &[ABSORBING[0], ABSORBING[2]])?);
    hold("sphere", errors, (0.07, 0.05))?;
    let absorbing = truth.errors(&indirect("sphere", &ABSORBING)?);
    if absorbing.0 < 2.0 * errors.0 {
        return Err(format!("absorbing mirrors are as near: {absorbing:?}").into());
    }
    Ok(())
}

fn five_bounces() -> Result<(), Failed> {
    let many = [("gi.vpl_count", "1024"), ("gi.bounces", "5")];
    let absorbing = [many.as_slice(), &[("gi.mirror_light", "false")]].concat();
    let truth = Truth::read("sphere", "gin")?;
    let got = indirect("sphere", &absorbing)?;
    hold("absorbing", truth.errors(&got), (0.075, 0.07))?;
    let truth = Truth::read("sphere", "gi")?;
    let got = indirect("sphere", &many)?;
    hold("by way of mirrors", truth.errors(&got), (0.075, 0.07))
}

fn no_place_stands_out() -> Result<(), Failed> {
    let truth = Truth::read("sphere", "gi")?;
    let got = indirect("sphere", &[])?;
    let blotch = truth.blotch(&got);
    println!("the brightest blotch is {blotch:.2} of the mean too bright");
    if blotch > 0.75 {
        return Err(format!("a blotch is {blotch} of the mean too bright").into());
    }
    // The negative control: a spot twice as bright as the mean is noticed.
    let mut spotted = got;
    for y in 96..192 {
        for x in 192..288 {
            spotted[y * SIZE.x as usize + x] += Vec3::X * 0.02;
        }
    }
    if truth.blotch(&spotted) < 0.75 {
        return Err(format!("a spot passes: {}", truth.blotch(&spotted)).into());
    }
    Ok(())
}

/// PSNR of sRGB at the exposure of the reference pictures over the pixels of `which`, dB.
fn psnr(a: &[Vec3], b: &[Vec3], which: &[bool]) -> f64 {
    let srgb = |v: f32| {
        let x = (4.0 * f64::from(v)).clamp(0.0, 1.0);
        if x <= 0.003_130_8 {
            12.92 * x
        } else {
            1.055 * x.powf(1.0 / 2.4) - 0.055
        }
    };
    let square = |a: f32, b: f32| (srgb(a) - srgb(b)).powi(2);
    let pixels = a.iter().zip(b).zip(which).filter(|(_, which)| **which);
    let sum: f64 = pixels
        .map(|((a, b), _)| square(a.x, b.x) + square(a.y, b.y) + square(a.z, b.z))
        .sum();
    let count = which.iter().filter(|w| **w).count();
    -10.0 * (sum / (3 * count) as f64).max(1e-12).log10()
}

/// Bounds in dB are those of mirror and rest.
fn interleaved_pixels_are_as_the_others() -> Result<(), Failed> {
    let folder = folder("CATOPTRIC_TRUTH").ok_or("no truth")?;
    for (scene, bounds) in [("sphere", [46.0, 50.0]), ("plane", [46.0, 50.0])] {
        let seen = Npz::open(&folder.join(format!("{scene}_aov.npz")))?;
        let mirror: Vec<bool> = seen.bytes("mirror")?.iter().map(|m| *m > 0).collect();
        let rest: Vec<bool> = mirror.iter().map(|m| !m).collect();
        let whole = render(scene, &[("gi.interleave", "1")])?;
        let interleaved = render(scene, &[])?;
        let unmerged = render(scene, &[("gi.filter", "0")])?;
        for (which, bound) in [mirror, rest].iter().zip(bounds) {
            let merged = psnr(&interleaved, &whole, which);
            let unmerged = psnr(&unmerged, &whole, which);
            println!("{scene}: merged {merged:.1} dB, unmerged {unmerged:.1} dB");
            if merged < bound || unmerged > merged - 6.0 {
                return Err(format!("{scene}: merged {merged} dB, unmerged {unmerged} dB").into());
            }
        }
    }
    Ok(())
}
