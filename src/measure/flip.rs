//! FLIP, how different two pictures look where one takes the other's place: P. Andersson, J. Nilsson, T. Akenine-Möller,
//! M. Oskarsson, K. Åström, M. Fairchild, "FLIP: A difference evaluator for alternating images", 2020; the variant for
//! pictures of a display (LDR).

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::planes::{Beyond, Planes, convolved};

/// Pixels per degree: a display 0.7 m wide of 3840 pixels, seen from 0.7 m.
const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;

/// Exponents and knee of the mapping of colour differences, and the exponent of feature differences (section 4).
const QC: f64 = 0.7;
const PC: f64 = 0.4;
const PT: f64 = 0.95;
const QF: f64 = 0.5;

/// Width of the eye's feature detectors, degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// Terms a sqrt(pi / b) exp(-pi^2 x^2 / b) of the contrast sensitivity, for luminance, red-green and blue-yellow
/// (table 1).
const SENSITIVITY: [&[(f64, f64)]; 3] = [
    &[(1.0, 0.0047)],
    &[(1.0, 0.0053)],
    &[(34.1, 0.04), (13.5, 0.025)],
];

/// Largest b of [`SENSITIVITY`], which sets how far the filters reach.
const WIDEST: f64 = 0.04;

/// XYZ of linear RGB with the primaries of sRGB and its white D65, column by column.
const XYZ_FROM_RGB: DMat3 = DMat3::from_cols_array(&[
    10_135_552.0 / 24_577_794.0,
    2_613_072.0 / 12_288_897.0,
    1_425_312.0 / 73_733_382.0,
    8_788_810.0 / 24_577_794.0,
    8_788_810.0 / 12_288_897.0,
    8_788_810.0 / 73_733_382.0,
    4_435_075.0 / 24_577_794.0,
    887_015.0 / 12_288_897.0,
    70_074_185.0 / 73_733_382.0,
]);

/// The difference of two pictures of one size (sRGB, 0 to 1) at each pixel: 0 where none is seen, to 1.
pub(super) fn flip(a: &Planes, b: &Planes) -> Vec<f64> {
    let [a, b] = [a, b].map(|picture| picture.map(|srgb| opponent(linear(srgb))));
    let [seen_a, seen_b] = [&a, &b].map(|picture| filtered(picture).map(perceived));
    let ([edges_a, points_a], [edges_b, points_b]) = (features(&a), features(&b));
    let largest = largest_difference();
    (0..edges_a.len())
        .map(|i| {
            let colour = spread(hyab(seen_a.at(i), seen_b.at(i)).powf(QC), largest);
            let feature = (edges_a[i] - edges_b[i])
                .abs()
                .max((points_a[i] - points_b[i]).abs());
            colour.powf(1.0 - (feature / 2f64.sqrt()).powf(QF))
        })
        .collect()
}

/// Linear RGB of sRGB, 0 to 1.
fn linear(srgb: DVec3) -> DVec3 {
    srgb.clamp(DVec3::ZERO, DVec3::ONE).map(|c| {
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    })
}

/// XYZ of the display's white.
fn white() -> DVec3 {
    XYZ_FROM_RGB * DVec3::ONE
}

/// The opponent space YCxCz, in which the eye's filters are linear.
fn opponent(rgb: DVec3) -> DVec3 {
    let xyz = XYZ_FROM_RGB * rgb / white();
    DVec3::new(
        116.0 * xyz.y - 16.0,
        500.0 * (xyz.x - xyz.y),
        200.0 * (xyz.y - xyz.z),
    )
}

fn rgb_of_opponent(ycxcz: DVec3) -> DVec3 {
    let y = (ycxcz.x + 16.0) / 116.0;
    let xyz = DVec3::new(ycxcz.y / 500.0 + y, y, y - ycxcz.z / 200.0);
    XYZ_FROM_RGB.inverse() * (xyz * white())
}

/// What the eye resolves of a picture in YCxCz, at the distance of [`PIXELS_PER_DEGREE`].
fn filtered(picture: &Planes) -> Planes {
    let reach = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let mut filtered = picture.clone();
    let channels = filtered.channels.iter_mut().zip(&picture.channels);
    for ((out, plane), terms) in channels.zip(SENSITIVITY) {
        // Each term is separable; their sum weighs 1 in all.
        let of_terms: Vec<(f64, Vec<f64>)> = terms
            .iter()
            .map(|&(a, b)| {
                let kernel = (-reach..=reach)
                    .map(|x| (-(PI * f64::from(x) / PIXELS_PER_DEGREE).powi(2) / b).exp());
                (a * (PI / b).sqrt(), kernel.collect())
            })
            .collect();
        let weight = |(a, kernel): &(f64, Vec<f64>)| a * kernel.iter().sum::<f64>().powi(2);
        let total: f64 = of_terms.iter().map(weight).sum();
        out.fill(0.0);
        for (a, kernel) in &of_terms {
            let part = convolved(
                plane,
                picture.size.x as usize,
                kernel,
                kernel,
                Beyond::Repeated,
            );
            for (out, value) in out.iter_mut().zip(part) {
                *out += a / total * value;
            }
        }
    }
    filtered
}

/// L*a*b* of YCxCz, with colours as faint as the eye sees them in the dark [Hunt 1952].
fn perceived(ycxcz: DVec3) -> DVec3 {
    lab(rgb_of_opponent(ycxcz).clamp(DVec3::ZERO, DVec3::ONE))
}

fn lab(rgb: DVec3) -> DVec3 {
    const DELTA: f64 = 6.0 / 29.0;
    let f = (XYZ_FROM_RGB * rgb / white()).map(|t| {
        if t > DELTA.powi(3) {
            t.cbrt()
        } else {
            t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    });
    let lightness = 116.0 * f.y - 16.0;
    let hunt = 0.01 * lightness;
    DVec3::new(
        lightness,
        hunt * 500.0 * (f.x - f.y),
        hunt * 200.0 * (f.y - f.z),
    )
}

/// Distance of two colours of L*a*b*: city block in lightness, Euclidean in colour [Abasi et al. 2020].
fn hyab(a: DVec3, b: DVec3) -> f64 {
    (a.x - b.x).abs() + (a.y - b.y).hypot(a.z - b.z)
}

/// The largest difference that a display can show: green against blue.
fn largest_difference() -> f64 {
    hyab(lab(DVec3::Y), lab(DVec3::Z)).powf(QC)
}

/// Small differences get most of the range 0 to 1.
fn spread(difference: f64, largest: f64) -> f64 {
    let knee = PC * largest;
    if difference < knee {
        difference * PT / knee
    } else {
        PT + (difference - knee) / (largest - knee) * (1.0 - PT)
    }
}

/// How strong edges and points are at each pixel of a picture in YCxCz.
fn features(picture: &Planes) -> [Vec<f64>; 2] {
    let width = picture.size.x as usize;
    let grey: Vec<f64> = (picture.channels[0].iter())
        .map(|y| (y + 16.0) / 116.0)
        .collect();
    let sigma = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let reach = (3.0 * sigma).ceil() as i32;
    let gauss = |x: i32| (-f64::from(x * x) / (2.0 * sigma * sigma)).exp();
    let derivatives: [&dyn Fn(i32) -> f64; 2] = [&|x| -f64::from(x) * gauss(x), &|x| {
        (f64::from(x * x) / (sigma * sigma) - 1.0) * gauss(x)
    }];
    let mut across: Vec<f64> = (-reach..=reach).map(gauss).collect();
    let sum: f64 = across.iter().sum();
    across.iter_mut().for_each(|w| *w /= sum);
    derivatives.map(|derivative| {
        // Weights above 0 sum up to 1, those below to -1.
        let mut along: Vec<f64> = (-reach..=reach).map(derivative).collect();
        let of_sign = |sign: f64| -> f64 { along.iter().map(|w| (w * sign).max(0.0)).sum() };
        let (above, below) = (of_sign(1.0), of_sign(-1.0));
        along
            .iter_mut()
            .for_each(|w| *w /= if *w > 0.0 { above } else { below });
        let dx = convolved(&grey, width, &along, &across, Beyond::Repeated);
        let dy = convolved(&grey, width, &across, &along, Beyond::Repeated);
        dx.iter().zip(dy).map(|(dx, dy)| dx.hypot(dy)).collect()
    })
}
