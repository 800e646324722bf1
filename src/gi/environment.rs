//! Stage `environment`: the light of the sky, as virtual point lights on a sphere around the scene.
//!
//! The sphere is a diffuse emitter that faces inwards: a patch of area dA sends L dA cos cos / d^2 to a point within, and over all
//! of it that is the integral of L cos over directions, wherever the point is. So patches are virtual point lights like others:
//! of equal area, at a spherical Fibonacci lattice [Gonzalez 2010, "Measurement of areas on a sphere using Fibonacci and
//! latitude-longitude lattices"], with the flux pi L dA. L is that of the direction from the sphere's centre.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Vec2, Vec3};

use super::sky_map::SkyMap;
use super::vpl::{Arrival, Vpl, evenly};

/// Radius of the sphere over half of the diagonal of the scene's box. Nothing lies nearer to a patch than the rest, where the
/// sum over 256 patches is still within a hundredth of the integral; more would leave the scene fewer texels of their maps.
const RADIUS: f32 = 1.25;

/// Smallest radius of the sphere: a single point has no box.
const MIN_RADIUS: f32 = 1e-6;

/// Radiance by direction, W/sr/m2 per channel.
#[derive(Debug, Clone, PartialEq)]
pub enum Sky {
    /// From the horizon's colour to the zenith's in proportion to the elevation; below the horizon the horizon's.
    Gradient {
        /// At 90 degrees.
        zenith: Vec3,
        /// At 0 degrees and below.
        horizon: Vec3,
    },
    /// Of a picture all around.
    Map(SkyMap),
}

/// Light from everywhere, from infinitely far away.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    sky: Sky,
    /// Unit vectors, right-handed: right, up, and away from the middle of a map.
    right: Vec3,
    up: Vec3,
    back: Vec3,
}

impl Environment {
    /// The sky over `up` (any length). The middle of a map is where -z is for y up, and where y is for z up.
    pub fn new(sky: Sky, up: Vec3) -> Self {
        let up = up.normalize_or(Vec3::Z);
        let right = Vec3::X
            .reject_from_normalized(up)
            .try_normalize()
            .unwrap_or_else(|| up.any_orthonormal_vector());
        Self {
            sky,
            right,
            up,
            back: right.cross(up),
        }
    }

    /// Radiance from the unit direction `towards`, W/sr/m2.
    pub fn radiance(&self, towards: Vec3) -> Vec3 {
        let height = towards.dot(self.up).clamp(-1.0, 1.0);
        match &self.sky {
            Sky::Gradient { zenith, horizon } => {
                horizon.lerp(*zenith, height.max(0.0).asin() / FRAC_PI_2)
            }
            Sky::Map(map) => {
                let azimuth = towards.dot(self.right).atan2(-towards.dot(self.back));
                map.at(Vec2::new(0.5 + azimuth / (2.0 * PI), height.acos() / PI))
            }
        }
    }

    /// `count` patches of the sphere around the box `bounds` as lights. Any run of patches that follow one another covers all of
    /// the sphere.
    pub fn vpls(&self, bounds: (Vec3, Vec3), count: u32) -> Vec<Vpl> {
        let centre = bounds.0.midpoint(bounds.1);
        let radius = ((bounds.1 - bounds.0).length() * 0.5 * RADIUS).max(MIN_RADIUS);
        let area = 4.0 * PI * radius * radius / count as f32;
        // Details finer than patches would be met by chance.
        let coarse = match &self.sky {
            Sky::Map(map) => Self {
                sky: Sky::Map(map.reduced(f64::from(count).sqrt().ceil() as usize)),
                ..*self
            },
            Sky::Gradient { .. } => self.clone(),
        };
        let light = |i: u32| {
            let out = coarse.patch(i, count);
            let arrival = Arrival {
                position: centre + out * radius,
                normal: -out,
                albedo: Vec3::ONE,
                specular: 0.0,
                shininess: 0.0,
                spacing: radius * 1e-4,
                direction: out,
                incident: coarse.radiance(out) * (PI * area),
            };
            // No point is near enough to a patch to need a bound.
            Vpl {
                softening: 0.0,
                ..Vpl::of(&arrival, area)
            }
        };
        evenly(count).into_iter().map(light).collect()
    }

    /// Unit direction from the sphere's centre to patch `i`.
    fn patch(&self, i: u32, count: u32) -> Vec3 {
        let height = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
        let (sin, cos) = (golden * f64::from(i)).sin_cos();
        let level = (1.0 - height * height).sqrt();
        let towards = self.right * (level * cos) as f32
            + self.back * (level * sin) as f32
            + self.up * height as f32;
        towards.normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Irradiance of lights at a point, without shadows.
    fn irradiance(lights: &[Vpl], position: Vec3, normal: Vec3) -> f32 {
        let of = |light: &Vpl| {
            let to = light.position - position;
            let facing = to.dot(normal).max(0.0) * (-to).dot(light.normal).max(0.0);
            light.flux.x * facing / (PI * to.length_squared() * to.length_squared())
        };
        lights.iter().map(of).sum()
    }

    #[test]
    fn the_patches_of_an_even_sky_light_every_place_and_side_alike() {
        let sky = Sky::Gradient {
            zenith: Vec3::splat(0.7),
            horizon: Vec3::splat(0.7),
        };
        let bounds = (Vec3::new(-1.0, -2.0, 0.0), Vec3::new(3.0, 2.0, 1.0));
        // At the box's corners, near the sky's sphere, single patches tell.
        for (patches, tolerance) in [(256, 0.03), (4096, 0.01)] {
            let lights = Environment::new(sky.clone(), Vec3::Z).vpls(bounds, patches);
            for position in [
                Vec3::new(1.0, 0.0, 0.5),
                bounds.0,
                bounds.1,
                Vec3::new(3.0, 0.0, 0.0),
            ] {
                for normal in [Vec3::Z, Vec3::NEG_X, Vec3::new(0.6, -0.8, 0.0), Vec3::NEG_Z] {
                    let got = irradiance(&lights, position, normal) / (0.7 * PI);
                    assert!(
                        (got - 1.0).abs() < tolerance,
                        "{patches} patches: {got} of what is exact, at {position} towards {normal}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_gradient_follows_the_elevation() {
        let sky = Environment::new(
            Sky::Gradient {
                zenith: Vec3::new(0.0, 0.0, 3.0),
                horizon: Vec3::new(3.0, 0.0, 0.0),
            },
            Vec3::Y * 2.0,
        );
        for (degrees, blue) in [
            (-90.0, 0.0),
            (-10.0, 0.0),
            (0.0, 0.0),
            (30.0, 1.0),
            (90.0, 3.0),
        ] {
            let (sin, cos) = f32::to_radians(degrees).sin_cos();
            let got = sky.radiance(Vec3::new(0.6 * cos, sin, 0.8 * cos));
            let expected = Vec3::new(3.0 - blue, 0.0, blue);
            assert!((got - expected).length() < 1e-5, "at {degrees}: {got}");
        }
    }

    #[test]
    fn the_middle_of_a_map_is_before_whoever_looks_along_minus_z_with_y_up() {
        // Columns: behind and left, left and before, before and right, right and behind.
        let texels = [0.0, 1.0, 2.0, 3.0].map(Vec3::splat).to_vec();
        let map = SkyMap::new(4, texels).expect("a map");
        let sky = Environment::new(Sky::Map(map), Vec3::Y);
        let left_before = sky.radiance(Vec3::new(-1.0, 0.0, -1.0).normalize());
        let right_before = sky.radiance(Vec3::new(1.0, 0.0, -1.0).normalize());
        assert!((left_before.x - 1.0).abs() < 1e-5, "{left_before}");
        assert!((right_before.x - 2.0).abs() < 1e-5, "{right_before}");
    }
}
