//! The measures of quality against figures of an independent program (compare.py with flip-evaluator 1.7), and against faults
//! of a known size.

use catoptric::measure::Planes;
use catoptric::measure::quality::{MirrorPicture, Reference, Seen, Wanted, picture_quality};
use glam::{DVec3, UVec2};
use libtest_mimic::Trial;

use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "quality::pictures_are_judged_as_others_judge_them",
            pictures_are_judged_as_others_judge_them,
        ),
        claim(
            "quality::the_same_picture_is_perfect",
            the_same_picture_is_perfect,
        ),
        claim(
            "quality::faults_of_mirrors_come_out_as_large_as_they_are",
            faults_come_out_as_large_as_they_are,
        ),
        claim("quality::the_controls_are_bad", the_controls_are_bad),
        claim("quality::other_sizes_are_refused", other_sizes_are_refused),
    ]
}

const SIZE: UVec2 = UVec2::new(90, 60);

fn at(i: usize) -> (f64, f64) {
    ((i % 90) as f64, (i / 90) as f64)
}

fn waves(i: usize) -> DVec3 {
    let (x, y) = at(i);
    let of = [
        (0.31 * x + 0.17 * y).sin(),
        (0.23 * x - 0.11 * y).cos(),
        (0.05 * x * y).sin(),
    ];
    DVec3::splat(0.5) + DVec3::new(0.4, 0.4, 0.3) * DVec3::from(of)
}

fn disturbed(i: usize) -> DVec3 {
    let (x, y) = at(i);
    let by = DVec3::new(
        0.1 * (0.7 * x).sin(),
        0.1 * (0.9 * y).cos(),
        0.15 * (0.4 * (x + y)).sin(),
    );
    (waves(i) + by).clamp(DVec3::ZERO, DVec3::ONE)
}

fn moved(i: usize) -> DVec3 {
    waves(if i.is_multiple_of(90) { i + 89 } else { i - 1 })
}

fn disc() -> Vec<bool> {
    (0..5400)
        .map(|i| (at(i).0 - 40.0).powi(2) + (at(i).1 - 28.0).powi(2) < 400.0)
        .collect()
}

fn pictures_are_judged_as_others_judge_them() {
    let reference = Planes::new(SIZE, waves);
    for (picture, psnr, ssim, flip) in [
        (
            Planes::new(SIZE, disturbed),
            21.504_010_816_8,
            0.814_300_386_5,
            0.270_976,
        ),
        (
            Planes::new(SIZE, moved),
            15.285_617_708_3,
            0.905_712_025_9,
            0.353_649,
        ),
    ] {
        let got = picture_quality(&picture, &reference, &disc()).expect("one size");
        assert!(
            (got.psnr - psnr).abs() < 1e-9,
            "PSNR {got:?}, expected {psnr}"
        );
        assert!(
            (got.ssim - ssim).abs() < 1e-9,
            "SSIM {got:?}, expected {ssim}"
        );
        assert!(
            (got.flip - flip).abs() < 1e-5,
            "FLIP {got:?}, expected {flip}"
        );
    }
}

fn the_same_picture_is_perfect() {
    let reference = Planes::new(SIZE, waves);
    let got = picture_quality(&reference, &reference, &disc()).expect("one size");
    assert!(
        (got.psnr, got.flip) == (120.0, 0.0) && (got.ssim - 1.0).abs() < 1e-12,
        "{got:?}"
    );
    // What lies outside of the mask does not count, but for what the windows see of it.
    let elsewhere = Planes::new(SIZE, |i| if at(i).0 > 85.0 { DVec3::ONE } else { waves(i) });
    let got = picture_quality(&elsewhere, &reference, &disc()).expect("one size");
    assert!(got.psnr >= 120.0 && got.flip <= 1e-12, "{got:?}");
}

/// A flat mirror: each pixel's ray goes straight up by a metre, its neighbours 1 cm beside.
fn wanted(i: usize) -> Wanted {
    let (x, y) = at(i);
    let point = DVec3::new(x * 0.01, y * 0.01, 0.0);
    let seen = Seen {
        position: point + DVec3::Z,
        albedo: waves(i),
    };
    Wanted {
        point,
        seen,
        wall: true,
    }
}

fn reference() -> Reference {
    let pixels = disc()
        .iter()
        .enumerate()
        .map(|(i, m)| m.then(|| wanted(i)))
        .collect();
    Reference::new(SIZE, disc(), pixels)
}

fn shown(seen: impl Fn(usize, Seen) -> Option<Seen>) -> MirrorPicture {
    let pixels = (0..5400).map(|i| seen(i, wanted(i).seen)).collect();
    MirrorPicture { size: SIZE, pixels }
}

fn faults_come_out_as_large_as_they_are() {
    let reference = reference();
    let of = |picture: &MirrorPicture| reference.quality(picture).expect("one size");
    let sound = of(&shown(|_, seen| Some(seen)));
    assert_eq!(
        (sound.mirror_pixels, sound.coverage, sound.recall),
        (1245, 1.0, 1.0)
    );
    assert!(
        sound.position_m.max == 0.0 && sound.albedo_psnr == 120.0,
        "{sound:?}"
    );

    // 15 mm aside are 1.5 pixels and 0.86 degrees; 3 cm are too far to be the same place.
    let aside = |by: f64| {
        shown(move |_, seen| {
            Some(Seen {
                position: seen.position + DVec3::X * by,
                ..seen
            })
        })
    };
    let near = of(&aside(0.015));
    assert!((near.position_m.median - 0.015).abs() < 1e-9, "{near:?}");
    assert!((near.position_px.p99 - 1.5).abs() < 1e-6, "{near:?}");
    assert!(
        (near.angle_degrees.p95 - 0.015f64.atan().to_degrees()).abs() < 1e-6,
        "{near:?}"
    );
    assert_eq!((near.recall, of(&aside(0.03)).recall), (1.0, 0.0));

    let holes = of(&shown(|i, seen| (!i.is_multiple_of(10)).then_some(seen)));
    assert!(
        (holes.coverage - 0.9).abs() < 0.02 && holes.recall == holes.coverage,
        "{holes:?}"
    );
    assert!(
        holes.albedo_psnr < 20.0 && holes.albedo_ssim < 0.9,
        "{holes:?}"
    );
}

fn the_controls_are_bad() {
    let (moved, black) = (reference().moved(), reference().black());
    assert!(moved.psnr < 25.0 && moved.ssim < 0.99, "{moved:?}");
    assert!(
        black.psnr < moved.psnr && black.ssim < moved.ssim,
        "{black:?}"
    );
}

fn other_sizes_are_refused() {
    let small = MirrorPicture {
        size: UVec2::ONE,
        pixels: vec![None],
    };
    let said = reference()
        .quality(&small)
        .expect_err("another size")
        .to_string();
    assert!(said.contains("camera.size=90x60"), "{said}");
    let planes = |size| Planes::new(size, |_| DVec3::ZERO);
    assert!(picture_quality(&planes(UVec2::ONE), &planes(SIZE), &disc()).is_err());
}
