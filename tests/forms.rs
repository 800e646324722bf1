//! The mirrors of the oracle, each where it stands alone.

use glam::DVec3;

/// The form of a mirror where it stands alone.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Form {
    Sphere,
    Parabola,
    Blob,
    Torus,
    Plane,
    Bumps,
}

/// Where single mirrors stand.
pub(crate) const C: DVec3 = DVec3::new(0.0, 0.0, -1.1);

/// Rays start this far from where they left, so that they do not meet it again.
const START: f64 = 1e-7;

impl Form {
    /// The first place after `START` where a ray meets the form.
    pub(crate) fn meet(self, origin: DVec3, ray: DVec3) -> Option<f64> {
        match self {
            Self::Sphere => quadratic(
                ray.dot(ray),
                (origin - C).dot(ray),
                (origin - C).length_squared() - 0.44 * 0.44,
            )
            .into_iter()
            .find(|&t| t > START),
            Self::Parabola => {
                // x^2 + y^2 - (z + 1.3) = 0, for a focal length of 0.25.
                let a = ray.x * ray.x + ray.y * ray.y;
                let b = origin.x * ray.x + origin.y * ray.y - ray.z / 2.0;
                let c = origin.x * origin.x + origin.y * origin.y - (origin.z + 1.3);
                let inside = |t: &f64| {
                    let p = origin + ray * *t;
                    *t > START && p.x * p.x + p.y * p.y <= 0.44 * 0.44
                };
                quadratic(a, b, c).into_iter().find(inside)
            }
            Self::Plane => {
                let (sin, cos) = 20f64.to_radians().sin_cos();
                let t = (C - origin).dot(DVec3::new(sin, 0.0, cos))
                    / ray.dot(DVec3::new(sin, 0.0, cos));
                let q = origin + ray * t - C;
                let across = q.dot(DVec3::new(cos, 0.0, -sin));
                (t > START && across.abs() <= 0.4 && q.y.abs() <= 0.4).then_some(t)
            }
            Self::Blob | Self::Torus | Self::Bumps => self.march(origin, ray),
        }
    }

    /// Signed distance-like function of the round forms, positive outside, and a bound of its slope.
    pub(crate) fn level(self, p: DVec3) -> f64 {
        let q = p - C;
        let d = q.normalize();
        match self {
            Self::Blob => {
                let dents = (4.0 * d.x).sin() * (4.0 * d.y + 1.0).sin() * (4.0 * d.z + 2.0).sin();
                q.length() - 0.40 * (1.0 + 0.25 * dents)
            }
            Self::Bumps => {
                let golden = (1.0 + 5f64.sqrt()) / 2.0;
                let axes = [
                    (0.0, 1.0, golden),
                    (0.0, -1.0, golden),
                    (golden, 0.0, 1.0),
                    (golden, 0.0, -1.0),
                    (1.0, golden, 0.0),
                    (-1.0, golden, 0.0),
                ];
                let wave = |(k, axis): (usize, (f64, f64, f64))| {
                    (BUMP_FREQUENCY * DVec3::from(axis).normalize().dot(d) + k as f64).sin()
                };
                let waves: f64 = axes.into_iter().enumerate().map(wave).sum();
                q.length() - 0.42 * (1.0 + BUMP_HEIGHT * waves)
            }
            Self::Torus => {
                let (sin, cos) = 35f64.to_radians().sin_cos();
                let along = q.dot(DVec3::new(0.0, -sin, cos));
                let across = (q.length_squared() - along * along).max(0.0).sqrt();
                (across - 0.36).hypot(along) - 0.13
            }
            Self::Sphere | Self::Parabola | Self::Plane => f64::NAN,
        }
    }

    /// Steps that cannot jump over the surface, then bisection.
    fn march(self, origin: DVec3, ray: DVec3) -> Option<f64> {
        const SMALLEST_STEP: f64 = 2e-5;
        // A ball around the form, and the steepest that its level rises.
        let (ball, slope) = match self {
            Self::Torus => (0.5, 1.0),
            Self::Blob => (0.51, 1.7),
            _ => (0.46, 1.4),
        };
        let length = ray.length();
        let [near, far] = quadratic(
            length * length,
            (origin - C).dot(ray),
            (origin - C).length_squared() - ball * ball,
        )[..] else {
            return None;
        };
        let level = |t: f64| self.level(origin + ray * t);
        let mut outside = near.max(START);
        let mut t = outside;
        while t < far {
            let height = level(t);
            if height < 0.0 {
                let mut inside = t;
                for _ in 0..60 {
                    let middle = (outside + inside) / 2.0;
                    if level(middle) < 0.0 {
                        inside = middle;
                    } else {
                        outside = middle;
                    }
                }
                return Some(outside);
            }
            outside = t;
            t += (height / slope).max(SMALLEST_STEP) / length;
        }
        None
    }

    /// Unit normal of the front.
    pub(crate) fn normal(self, p: DVec3) -> DVec3 {
        match self {
            Self::Sphere => (p - C).normalize(),
            Self::Parabola => DVec3::new(-2.0 * p.x, -2.0 * p.y, 1.0).normalize(),
            Self::Plane => DVec3::new(20f64.to_radians().sin(), 0.0, 20f64.to_radians().cos()),
            Self::Blob | Self::Torus | Self::Bumps => {
                const H: f64 = 1e-5;
                let slope = |axis: DVec3| self.level(p + axis * H) - self.level(p - axis * H);
                DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize()
            }
        }
    }

    /// Distance of a point from the surface, to first order; infinite beside its rim.
    pub(crate) fn distance(self, p: DVec3) -> f64 {
        const RIM: f64 = 1e-9;
        let q = p - C;
        match self {
            Self::Sphere => (q.length() - 0.44).abs(),
            Self::Parabola => {
                let across = p.x.hypot(p.y);
                let height = (p.z + 1.3 - across * across) / (1.0 + 4.0 * across * across).sqrt();
                if across > 0.44 + RIM {
                    f64::INFINITY
                } else {
                    height.abs()
                }
            }
            Self::Plane => {
                let (sin, cos) = 20f64.to_radians().sin_cos();
                let beside = q.y.abs().max(q.dot(DVec3::new(cos, 0.0, -sin)).abs()) > 0.4 + RIM;
                if beside {
                    f64::INFINITY
                } else {
                    q.dot(DVec3::new(sin, 0.0, cos)).abs()
                }
            }
            Self::Blob | Self::Torus | Self::Bumps => self.level(p).abs(),
        }
    }

    pub(crate) fn one_sided(self) -> bool {
        matches!(self, Self::Parabola | Self::Plane)
    }
}

/// Relative height of a wave of the bumps, and its frequency.
const BUMP_HEIGHT: f64 = 0.005;
const BUMP_FREQUENCY: f64 = 32.0;

/// Roots of `a t^2 + 2 b t + c` in ascending order.
fn quadratic(a: f64, b: f64, c: f64) -> Vec<f64> {
    if a.abs() < 1e-14 * b.abs() {
        return vec![-c / (2.0 * b)];
    }
    let under = b * b - a * c;
    if under < 0.0 {
        return Vec::new();
    }
    let q = -(b + under.sqrt().copysign(b));
    let (one, two) = (q / a, c / q);
    vec![one.min(two), one.max(two)]
}
