//! Surfaces whose distance from a centre is a function of the direction: blob and bumps.

use std::f64::consts::PI;

use glam::DVec3;
use rand::Rng;

use super::surface::{SurfacePoint, direction, unit};
use crate::error::{Error, Result};

/// A relative displacement of the unit sphere.
pub(super) trait Displacement {
    /// Displacement along the unit direction `d`, and its gradient there.
    fn at(&self, d: DVec3) -> (f64, DVec3);
    /// Upper bounds of the displacement and of its gradient's length.
    fn bounds(&self) -> (f64, f64);
}

/// `amplitude sin(4 d.x) sin(4 d.y + 1) sin(4 d.z + 2)`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blob {
    amplitude: f64,
}

impl Blob {
    pub(super) fn new(amplitude: f64) -> Result<Self> {
        if amplitude.is_finite() && amplitude.abs() < 1.0 {
            return Ok(Self { amplitude });
        }
        Err(Error::Setting(format!(
            "the mirror's amplitude is {amplitude}; it must be above -1 and below 1"
        )))
    }
}

impl Displacement for Blob {
    fn at(&self, d: DVec3) -> (f64, DVec3) {
        let (sx, cx) = (4.0 * d.x).sin_cos();
        let (sy, cy) = (4.0 * d.y + 1.0).sin_cos();
        let (sz, cz) = (4.0 * d.z + 2.0).sin_cos();
        let gradient =
            DVec3::new(cx * sy * sz, sx * cy * sz, sx * sy * cz) * (4.0 * self.amplitude);
        (self.amplitude * sx * sy * sz, gradient)
    }

    fn bounds(&self) -> (f64, f64) {
        // The squares of the three products of one cosine and two sines add up to at most 1.
        (self.amplitude.abs(), 4.0 * self.amplitude.abs())
    }
}

/// `BUMP_HEIGHT` times the sum over the six axes a_k of an icosahedron of `sin(BUMP_FREQUENCY a_k.d + k)`, k = 0 to 5.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bumps;

/// Height of one wave of [`Bumps`], relative to the radius.
const BUMP_HEIGHT: f64 = 0.005;

/// Waves per radian around the sphere, times 2 pi.
const BUMP_FREQUENCY: f64 = 32.0;

/// The axes of an icosahedron, unit vectors: (0, 1, golden ratio) and its like.
const ICOSAHEDRON_AXES: [DVec3; 6] = {
    const SHORT: f64 = 0.525_731_112_119_133_6;
    const LONG: f64 = 0.850_650_808_352_039_9;
    [
        DVec3::new(0.0, SHORT, LONG),
        DVec3::new(0.0, -SHORT, LONG),
        DVec3::new(LONG, 0.0, SHORT),
        DVec3::new(LONG, 0.0, -SHORT),
        DVec3::new(SHORT, LONG, 0.0),
        DVec3::new(-SHORT, LONG, 0.0),
    ]
};

impl Displacement for Bumps {
    fn at(&self, d: DVec3) -> (f64, DVec3) {
        let mut phase = 0.0;
        let (mut height, mut gradient) = (0.0, DVec3::ZERO);
        for axis in ICOSAHEDRON_AXES {
            let (sin, cos) = (BUMP_FREQUENCY * axis.dot(d) + phase).sin_cos();
            height += BUMP_HEIGHT * sin;
            gradient += axis * (BUMP_HEIGHT * BUMP_FREQUENCY * cos);
            phase += 1.0;
        }
        (height, gradient)
    }

    fn bounds(&self) -> (f64, f64) {
        // The six axes are a tight frame: |sum of c_k a_k| <= sqrt(2) |c| <= sqrt(2) sqrt(6).
        (
            6.0 * BUMP_HEIGHT,
            12.0f64.sqrt() * BUMP_HEIGHT * BUMP_FREQUENCY,
        )
    }
}

/// A displaced sphere.
#[derive(Debug, Clone, Copy)]
pub(super) struct Radial<D> {
    centre: DVec3,
    radius: f64,
    displacement: D,
    /// Upper bound of [`Radial::density`].
    density_bound: f64,
}

impl<D: Displacement> Radial<D> {
    pub(super) fn new(centre: DVec3, radius: f64, displacement: D) -> Self {
        let (height, slope) = displacement.bounds();
        Self {
            centre,
            radius,
            displacement,
            density_bound: (1.0 + height) * (1.0 + height).hypot(slope),
        }
    }

    /// Relative distance from the centre along `d`, and its gradient in the sphere's tangent plane.
    fn distance(&self, d: DVec3) -> (f64, DVec3) {
        let (height, gradient) = self.displacement.at(d);
        (1.0 + height, gradient - d * gradient.dot(d))
    }

    /// Area of the surface per area of the unit sphere, where the radius is 1.
    fn density(distance: f64, slope: DVec3) -> f64 {
        distance * (distance * distance + slope.length_squared()).sqrt()
    }

    pub(super) fn sample<R: Rng>(&self, rng: &mut R) -> SurfacePoint {
        loop {
            let d = direction(rng);
            let (distance, slope) = self.distance(d);
            if unit(rng) * self.density_bound <= Self::density(distance, slope) {
                return SurfacePoint {
                    position: self.centre + d * (self.radius * distance),
                    normal: (d * distance - slope).normalize(),
                };
            }
        }
    }

    /// Area of the surface.
    pub(super) fn area(&self) -> f64 {
        self.area_over(RINGS)
    }

    /// Area, by Gauss-Legendre quadrature over `rings` values of z and the trapezoidal rule around each.
    fn area_over(&self, rings: u32) -> f64 {
        let mut sum = 0.0;
        for (z, weight) in gauss_legendre(rings) {
            let across = (1.0 - z * z).sqrt();
            for i in 0..2 * rings {
                let (sin, cos) = (PI * f64::from(i) / f64::from(rings)).sin_cos();
                let (distance, slope) = self.distance(DVec3::new(across * cos, across * sin, z));
                sum += weight * Self::density(distance, slope);
            }
        }
        sum * PI / f64::from(rings) * self.radius * self.radius
    }
}

/// Rings of the quadrature of an area; more change nothing (a test holds that to 1e-9).
const RINGS: u32 = 192;

/// Nodes and weights of the Gauss-Legendre quadrature over [-1, 1], by Newton steps on the Legendre polynomial.
fn gauss_legendre(count: u32) -> Vec<(f64, f64)> {
    let n = f64::from(count);
    let node = |i: u32| {
        let mut x = (PI * (f64::from(i) + 0.75) / (n + 0.5)).cos();
        let mut derivative = 1.0;
        for _ in 0..8 {
            let (mut last, mut value) = (1.0, x);
            for k in 2..=count {
                let k = f64::from(k);
                (last, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * last) / k);
            }
            derivative = n * (x * value - last) / (x * x - 1.0);
            x -= value / derivative;
        }
        (x, 2.0 / ((1.0 - x * x) * derivative * derivative))
    };
    (0..count).map(node).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn gauss_legendre_is_exact_for_polynomials() {
        let integral: f64 = gauss_legendre(8).iter().map(|(x, w)| w * x.powi(14)).sum();
        assert!(
            (integral - 2.0 / 15.0).abs() < 1e-13,
            "got {integral}, expected 2/15"
        );
    }

    #[test]
    fn an_undented_blob_has_the_area_of_a_sphere() {
        let area = Radial::new(DVec3::X, 0.5, Blob { amplitude: 0.0 }).area();
        assert!((area - PI).abs() < 1e-12, "got {area}, expected pi");
    }

    #[test]
    fn more_rings_do_not_change_an_area() {
        let bumps = Radial::new(DVec3::ZERO, 1.0, Bumps);
        let (some, more) = (bumps.area(), bumps.area_over(2 * RINGS));
        assert!(
            (some / more - 1.0).abs() < 1e-9,
            "bumps: {some} with some rings, {more} with more"
        );
        let blob = Radial::new(DVec3::ZERO, 1.0, Blob { amplitude: 0.99 });
        let (some, more) = (blob.area(), blob.area_over(2 * RINGS));
        assert!(
            (some / more - 1.0).abs() < 1e-9,
            "blob: {some} with some rings, {more} with more"
        );
    }

    #[test]
    fn no_density_exceeds_its_bound() {
        let bumps = Radial::new(DVec3::ZERO, 1.0, Bumps);
        let blob = Radial::new(DVec3::ZERO, 1.0, Blob { amplitude: 0.9 });
        for (z, _) in gauss_legendre(200) {
            for i in 0..400 {
                let (sin, cos) = (TAU * f64::from(i) / 400.0).sin_cos();
                let across = (1.0 - z * z).sqrt();
                let d = DVec3::new(across * cos, across * sin, z);
                let (distance, slope) = bumps.distance(d);
                let density = Radial::<Bumps>::density(distance, slope);
                assert!(
                    density <= bumps.density_bound,
                    "bumps at {d}: {density} > {}",
                    bumps.density_bound
                );
                let (distance, slope) = blob.distance(d);
                let density = Radial::<Blob>::density(distance, slope);
                assert!(
                    density <= blob.density_bound,
                    "blob at {d}: {density} > {}",
                    blob.density_bound
                );
            }
        }
    }
}
