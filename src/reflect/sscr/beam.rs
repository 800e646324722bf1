//! What part of a mirror can show: a ball around its points and a cone around its reflected rays. Eight points of the cloud
//! are compared with it at a time.

use glam::Vec3;
use wide::f32x8;

/// What a cosine is rounded by, at most: the cone of a plane would vanish otherwise.
const COSINE_PAD: f32 = 1e-6;

/// A ball of mirror points and the cone of the rays that leave them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Centre of the ball.
    pub centre: Vec3,
    /// Radius of the ball.
    pub radius: f32,
    /// Unit axis of the cone.
    pub axis: Vec3,
    /// Cosine of the cone's half angle.
    pub cosine: f32,
    /// Its sine.
    pub sine: f32,
    /// Squared distance from the centre up to which every point may be shown: within the ball, or so near that a cone
    /// wider than a half space, widened by the ball, is all directions.
    pub near_squared: f32,
}

/// Eight points.
#[derive(Debug, Clone, Copy)]
pub struct Points8 {
    /// Coordinates.
    pub xyz: [f32x8; 3],
}

impl Points8 {
    /// Up to eight points; the other lanes are never shown anywhere.
    pub fn new(points: &[Vec3]) -> Self {
        let lane = |k: usize| {
            let mut lanes = [f32::NAN; 8];
            for (lane, point) in lanes.iter_mut().zip(points) {
                *lane = point[k];
            }
            f32x8::from(lanes)
        };
        Self {
            xyz: [lane(0), lane(1), lane(2)],
        }
    }

    /// The vectors to them, each from a place of its own.
    #[inline(always)]
    pub(super) fn seen_from(&self, places: &[Vec3; 8]) -> [f32x8; 3] {
        std::array::from_fn(|k| self.xyz[k] - f32x8::from(places.map(|p| p[k])))
    }
}

impl Beam {
    /// The beam of mirror points with their reflected directions, which are walked three times.
    pub fn around(samples: impl Iterator<Item = (Vec3, Vec3)> + Clone) -> Self {
        let (mut min, mut max, mut sum) = (Vec3::INFINITY, Vec3::NEG_INFINITY, Vec3::ZERO);
        for (point, ray) in samples.clone() {
            min = min.min(point);
            max = max.max(point);
            sum += ray;
        }
        let centre = (min + max) * 0.5;
        let axis = sum.normalize_or(Vec3::Z);
        let (mut radius, mut cosine) = (0f32, 1f32);
        for (point, ray) in samples {
            radius = radius.max(point.distance(centre));
            cosine = cosine.min(ray.dot(axis) / ray.length());
        }
        // Rays between two pixels lie on the chord between theirs, but points of the surface bulge.
        let radius = radius * 1.001;
        let cosine = (cosine - COSINE_PAD).max(-1.0);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let near = if cosine < 0.0 {
            radius / sine.max(1e-6)
        } else {
            radius
        };
        Self {
            centre,
            radius,
            axis,
            cosine,
            sine,
            near_squared: near * near,
        }
    }

    /// Which of eight points it may show, a bit each: those whose direction from the centre is within the cone, widened by
    /// the angle under which the ball appears from there.
    #[inline(always)]
    pub fn may_show(&self, points: &Points8) -> u32 {
        let [x, y, z] = points.xyz;
        let (x, y, z) = (
            x - f32x8::splat(self.centre.x),
            y - f32x8::splat(self.centre.y),
            z - f32x8::splat(self.centre.z),
        );
        let squared = x * x + y * y + z * z;
        let along = x * f32x8::splat(self.axis.x)
            + y * f32x8::splat(self.axis.y)
            + z * f32x8::splat(self.axis.z);
        let tangent = (squared - f32x8::splat(self.radius * self.radius)).fast_max(f32x8::ZERO);
        let least =
            f32x8::splat(self.cosine) * tangent.sqrt() - f32x8::splat(self.sine * self.radius);
        let near = squared.simd_le(f32x8::splat(self.near_squared));
        (near | along.simd_ge(least)).to_bitmask()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shows(beam: &Beam, point: Vec3) -> bool {
        let mask = beam.may_show(&Points8::new(&[Vec3::splat(1e6), point]));
        mask & 2 != 0
    }

    #[test]
    fn no_point_on_a_ray_is_culled() {
        // A bowl of rays from a patch: every point along each may be shown.
        let samples: Vec<(Vec3, Vec3)> = (0..64)
            .map(|i| {
                let (u, v) = ((i % 8) as f32 / 7.0 - 0.5, (i / 8) as f32 / 7.0 - 0.5);
                (Vec3::new(u, v, 0.0), Vec3::new(u, v, 0.7).normalize())
            })
            .collect();
        for stretch in [0.1, 1.0, 6.0] {
            // Wider and wider, beyond a half space.
            let wide: Vec<_> = (samples.iter())
                .map(|(p, r)| {
                    (
                        *p,
                        Vec3::new(r.x * stretch, r.y * stretch, r.z - 0.3 * stretch),
                    )
                })
                .map(|(p, r)| (p, r.normalize()))
                .collect();
            let beam = Beam::around(wide.iter().copied());
            for (p, r) in &wide {
                for t in [0.0, 0.01, 0.5, 2.0, 100.0] {
                    assert!(shows(&beam, *p + *r * t), "{beam:?}: {p} + {t} {r}");
                }
            }
        }
    }

    #[test]
    fn what_lies_beside_a_narrow_beam_is_culled() {
        let samples = [
            (Vec3::ZERO, Vec3::Z),
            (Vec3::X * 0.1, Vec3::new(0.05, 0.0, 1.0).normalize()),
        ];
        let beam = Beam::around(samples.into_iter());
        assert!(shows(&beam, Vec3::new(0.1, 0.0, 2.0)), "in the beam");
        for point in [Vec3::X, Vec3::NEG_Z, Vec3::new(1.0, 0.0, 2.0), Vec3::NAN] {
            assert!(!shows(&beam, point), "{point} is beside {beam:?}");
        }
    }
}
