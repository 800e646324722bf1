//! What mirrors show against what they ought to show, by the oracle of analytic scenes.

use catoptric::backend::cpu::Cpu;
use catoptric::reflect::MirrorGBuffer;
use glam::DVec3;
use libtest_mimic::{Failed, Trial};
use rayon::prelude::*;

use crate::analytic::{Hit, Kind, Oracle, View, reflect};
use crate::npz::Npz;
use crate::support::{claim, folder};

pub(crate) fn tests() -> Vec<Trial> {
    let mut trials = vec![claim(
        "shown::the_measures_see_small_faults",
        the_measures_see_small_faults,
    )];
    for scene in ["sphere", "parabola", "plane"] {
        trials.push(
            Trial::test(
                format!("shown::the_oracle_sees_in_the_{scene}_what_an_independent_renderer_does"),
                move || agrees_with_the_delivered_truth(scene),
            )
            .with_ignored_flag(folder("CATOPTRIC_TRUTH").is_none()),
        );
    }
    trials
}

/// What each pixel's mirror shows, at its centre; `None` where there is no mirror's front.
pub(crate) struct Shown(Vec<Option<Hit>>);

impl Shown {
    /// By the oracle's rays.
    pub(crate) fn new(oracle: &Oracle, view: &View) -> Self {
        let shown = |hit: &Hit| {
            let ray = hit.position - view.position;
            matches!(hit.kind, Kind::Mirror(_))
                .then(|| oracle.cast(hit.position, reflect(ray, hit.normal)))
        };
        Self(oracle.view(view).par_iter().map(shown).collect())
    }

    /// The pixel's hit, where its mirror shows a wall.
    pub(crate) fn wall(&self, index: usize) -> Option<&Hit> {
        let hit = self.0.get(index)?.as_ref();
        hit.filter(|hit| matches!(hit.kind, Kind::Wall(_)))
    }

    /// Number of pixels whose centre shows a mirror's front.
    pub(crate) fn pixels(&self) -> usize {
        self.0.iter().flatten().count()
    }
}

/// Where the point that a mirror pixel shows lies, relative to the scene's origin; `None` where it shows nothing.
pub(crate) fn position(mirror: &MirrorGBuffer<Cpu>, index: usize) -> Option<DVec3> {
    let distance = mirror.at(index)?.surface.w;
    let [origin, direction] =
        [&mirror.origin, &mirror.direction].map(|grid| grid.values()[index].truncate());
    Some((origin + direction * distance).as_dvec3())
}

/// How well mirrors show what they ought to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Figures {
    /// Part of the mirrors' pixels that show something.
    pub(crate) coverage: f64,
    /// Distance of what is shown from what ought to be, metres: half are nearer.
    pub(crate) median: f64,
    /// PSNR of the sRGB of what the mirrors show of the walls' albedo, dB; what shows nothing counts as black.
    pub(crate) psnr: f64,
    /// As `psnr`, of the truth moved by one pixel.
    pub(crate) moved: f64,
    /// As `psnr`, of black.
    pub(crate) black: f64,
}

impl Figures {
    pub(crate) fn of(truth: &Shown, mirror: &MirrorGBuffer<Cpu>) -> Self {
        let mut distances: Vec<f64> = (0..truth.0.len())
            .filter_map(|i| Some(truth.0[i]?.position.distance(position(mirror, i)?)))
            .collect();
        distances.sort_by(f64::total_cmp);
        let albedo = |i: usize| mirror.at(i).map(|p| p.albedo.truncate().as_dvec3());
        let before = |i: usize| Some(truth.0[i.checked_sub(1)?]?.albedo);
        Self {
            coverage: distances.len() as f64 / truth.pixels() as f64,
            median: distances
                .get(distances.len() / 2)
                .copied()
                .unwrap_or(f64::INFINITY),
            psnr: truth.psnr(albedo),
            moved: truth.psnr(before),
            black: truth.psnr(|_| None),
        }
    }
}

impl Shown {
    fn psnr(&self, albedo: impl Fn(usize) -> Option<DVec3> + Sync) -> f64 {
        let (sum, n) = (0..self.0.len())
            .filter_map(|i| {
                let got = srgb(albedo(i).unwrap_or(DVec3::ZERO));
                Some((got - srgb(self.wall(i)?.albedo)).length_squared())
            })
            .fold((0.0, 0), |(sum, n), e| (sum + e, n + 3));
        -10.0 * (sum / f64::from(n)).max(1e-12).log10()
    }
}

pub(crate) fn srgb(linear: DVec3) -> DVec3 {
    let encode = |c: f64| {
        if c <= 0.003_130_8 {
            12.92 * c
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        }
    };
    let [r, g, b] = linear.clamp(DVec3::ZERO, DVec3::ONE).to_array();
    DVec3::new(encode(r), encode(g), encode(b))
}

/// A buffer that shows the truth, `off` metres too far.
fn perfect(truth: &Shown, view: &View, oracle: &Oracle, off: f64) -> MirrorGBuffer<Cpu> {
    let size = glam::UVec2::new(view.width as u32, view.height as u32);
    let mut mirror = MirrorGBuffer::empty(size);
    let hits = oracle.view(view);
    for (i, hit) in hits.iter().enumerate() {
        let Some(shown) = truth.0[i] else { continue };
        let way = shown.position - hit.position;
        mirror.origin.values_mut()[i] = hit.position.as_vec3().extend(1.0);
        mirror.direction.values_mut()[i] = way.normalize().as_vec3().extend(0.0);
        mirror.surface.values_mut()[i].w = (way.length() + off) as f32;
        mirror.albedo.values_mut()[i] = shown.albedo.as_vec3().extend(0.0);
        mirror.material.values_mut()[i].w = 1.0;
    }
    mirror
}

fn the_measures_see_small_faults() {
    let (oracle, view) = (Oracle::named("sphere"), View::REFERENCE);
    let truth = Shown::new(&oracle, &view);
    let sound = Figures::of(&truth, &perfect(&truth, &view, &oracle, 0.0));
    assert!(
        sound.coverage >= 1.0 && sound.median < 1e-6 && sound.psnr > 100.0,
        "the truth itself: {sound:?}"
    );
    assert!(
        sound.moved < 32.0 && sound.black < 10.0,
        "the controls: {sound:?}"
    );
    let far = Figures::of(&truth, &perfect(&truth, &view, &oracle, 0.02));
    assert!((far.median - 0.02).abs() < 1e-4, "2 cm too far: {far:?}");
    let mut holes = perfect(&truth, &view, &oracle, 0.0);
    let covered = holes.material.values_mut().iter_mut().step_by(10);
    covered.for_each(|m| m.w = 0.0);
    let holes = Figures::of(&truth, &holes);
    assert!(
        (holes.coverage - 0.9).abs() < 0.01 && holes.psnr < 20.0,
        "a tenth is missing: {holes:?}"
    );
}

/// The oracle's albedo and positions are those of the delivered truth, but on edges between colours.
fn agrees_with_the_delivered_truth(scene: &str) -> Result<(), Failed> {
    let folder = folder("CATOPTRIC_TRUTH").ok_or("no truth")?;
    let delivered = Npz::open(&folder.join(format!("{scene}_aov.npz")))?;
    let (albedo, positions) = (delivered.vectors("Qalb")?, delivered.vectors("Q")?);
    let mirror = delivered.bytes("mirror")?;
    let truth = Shown::new(&Oracle::named(scene), &View::REFERENCE);
    let both: Vec<(usize, &Hit)> = (0..albedo.len())
        .filter(|&i| mirror[i] > 0)
        .filter_map(|i| Some((i, truth.wall(i)?)))
        .collect();
    let wrong = both
        .iter()
        .filter(|(i, hit)| {
            hit.albedo.distance(albedo[*i]) > 0.01 || hit.position.distance(positions[*i]) > 0.005
        })
        .count();
    println!("{scene}: {wrong} of {} pixels differ", both.len());
    if wrong * 200 > both.len() || both.len() < 10_000 {
        return Err(format!("{wrong} of {} pixels differ", both.len()).into());
    }
    Ok(())
}
