//! The oracle: casts rays, in f64, into the scenes of `docs/SCENES.md`. It shares no code with the program.

use glam::DVec3;
use rayon::prelude::*;

/// What a ray meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Left, right, floor, ceiling, back, front: 1 to 6.
    Wall(u8),
    /// The front of the mirror of that number.
    Mirror(usize),
    /// The black back of the mirror of that number.
    Back(usize),
}

/// Where a ray meets the scene.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// Along the ray, in multiples of its direction.
    pub t: f64,
    pub position: DVec3,
    /// Unit length, of the front.
    pub normal: DVec3,
    /// Linear RGB; 0 on mirrors.
    pub albedo: DVec3,
    pub kind: Kind,
}

/// A camera.
#[derive(Debug, Clone, Copy)]
pub struct View {
    pub position: DVec3,
    pub target: DVec3,
    pub up: DVec3,
    pub fov_y_degrees: f64,
    pub width: usize,
    pub height: usize,
}

impl View {
    /// The camera of the reference scenes.
    pub const REFERENCE: Self = Self {
        position: DVec3::new(0.0, 0.0, 0.9),
        target: DVec3::new(0.0, 0.0, -1.1),
        up: DVec3::Y,
        fov_y_degrees: 60.0,
        width: 800,
        height: 600,
    };

    /// The ray through the centre of a pixel, 1 long along the axis.
    pub fn direction(&self, x: usize, y: usize) -> DVec3 {
        let forward = (self.target - self.position).normalize();
        let right = forward.cross(self.up).normalize();
        let tan = (self.fov_y_degrees / 2.0).to_radians().tan();
        let aspect = self.width as f64 / self.height as f64;
        let sx = (2.0 * (x as f64 + 0.5) / self.width as f64 - 1.0) * tan * aspect;
        let sy = (1.0 - 2.0 * (y as f64 + 0.5) / self.height as f64) * tan;
        forward + right * sx + right.cross(forward) * sy
    }
}

/// The form of a mirror where it stands alone.
#[derive(Debug, Clone, Copy)]
enum Form {
    Sphere,
    Parabola,
    Blob,
    Torus,
    Plane,
    Bumps,
}

/// A mirror: its form, scaled about `C` and shifted.
#[derive(Debug, Clone, Copy)]
struct Mirror {
    form: Form,
    scale: f64,
    shift: DVec3,
}

/// Where single mirrors stand.
pub const C: DVec3 = DVec3::new(0.0, 0.0, -1.1);

/// Rays start this far from where they left, so that they do not meet it again.
const START: f64 = 1e-7;

impl Form {
    /// The first place after `START` where a ray meets the form.
    fn meet(self, origin: DVec3, ray: DVec3) -> Option<f64> {
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
    fn level(self, p: DVec3) -> f64 {
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
                        inside = middle
                    } else {
                        outside = middle
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
    fn normal(self, p: DVec3) -> DVec3 {
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
    fn distance(self, p: DVec3) -> f64 {
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

    fn one_sided(self) -> bool {
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

/// The light of the reference scenes.
const LIGHT: DVec3 = DVec3::new(-0.6, 0.9, 0.2);
const LIGHT_TARGET: DVec3 = DVec3::new(1.0, -1.0, -3.0);

/// A reference scene.
#[derive(Debug, Clone)]
pub struct Oracle {
    mirrors: Vec<Mirror>,
}

impl Oracle {
    /// A scene by its name; `multi` is without the bunny.
    ///
    /// # Panics
    /// Where there is no scene of that name.
    pub fn named(name: &str) -> Self {
        let one = |form| {
            vec![Mirror {
                form,
                scale: 1.0,
                shift: DVec3::ZERO,
            }]
        };
        let mirrors = match name {
            "sphere" => one(Form::Sphere),
            "parabola" => one(Form::Parabola),
            "blob" => one(Form::Blob),
            "torus" => one(Form::Torus),
            "plane" => one(Form::Plane),
            "bumps" => one(Form::Bumps),
            "multi" => {
                let places = [
                    (Form::Sphere, -0.66, 0.36),
                    (Form::Parabola, 0.0, 0.36),
                    (Form::Blob, 0.66, 0.36),
                    (Form::Torus, -0.66, -0.38),
                    (Form::Plane, 0.66, -0.38),
                ];
                let place = |(form, x, y)| Mirror {
                    form,
                    scale: 0.6,
                    shift: DVec3::new(x, y, 0.0),
                };
                places.map(place).to_vec()
            }
            other => panic!("the oracle knows no scene {other}"),
        };
        Self { mirrors }
    }

    /// What a ray from inside the room meets first.
    pub fn cast(&self, origin: DVec3, ray: DVec3) -> Hit {
        let mut first = wall(origin, ray);
        for (number, mirror) in self.mirrors.iter().enumerate() {
            // Into the frame where the mirror stands alone.
            let local = C + (origin - C - mirror.shift) / mirror.scale;
            let Some(t) = mirror.form.meet(local, ray).map(|t| t * mirror.scale) else {
                continue;
            };
            if t < first.t {
                let normal = mirror.form.normal(local + ray * (t / mirror.scale));
                let behind = mirror.form.one_sided() && normal.dot(ray) > 0.0;
                let kind = if behind {
                    Kind::Back(number)
                } else {
                    Kind::Mirror(number)
                };
                first = Hit {
                    t,
                    position: origin + ray * t,
                    normal,
                    albedo: DVec3::ZERO,
                    kind,
                };
            }
        }
        first
    }

    /// How far a point lies from the nearest surface, and that surface there; `t` has no meaning.
    pub fn nearest(&self, p: DVec3) -> (f64, Hit) {
        let mut found = (
            f64::INFINITY,
            Hit {
                t: 0.0,
                ..wall(DVec3::ZERO, DVec3::X)
            },
        );
        for (number, axis, side, normal) in WALLS {
            let distance = (p[axis] - side).abs();
            if distance < found.0 {
                let kind = Kind::Wall(number);
                found = (
                    distance,
                    Hit {
                        t: 0.0,
                        position: p,
                        normal,
                        albedo: wall_albedo(number, p),
                        kind,
                    },
                );
            }
        }
        for (number, mirror) in self.mirrors.iter().enumerate() {
            let local = C + (p - C - mirror.shift) / mirror.scale;
            let distance = mirror.form.distance(local) * mirror.scale;
            if distance < found.0 {
                let (normal, kind) = (mirror.form.normal(local), Kind::Mirror(number));
                found = (
                    distance,
                    Hit {
                        t: 0.0,
                        position: p,
                        normal,
                        albedo: DVec3::ZERO,
                        kind,
                    },
                );
            }
        }
        found
    }

    /// Distance of a star-shaped scene's first mirror from its centre, along the unit direction `d`.
    pub fn radius(&self, d: DVec3) -> f64 {
        match self.mirrors[0].form {
            Form::Sphere => 0.44,
            form => 1.0 - form.level(C + d),
        }
    }

    /// Direct radiance of what was hit, the same towards everywhere: W/sr/m2 per channel.
    pub fn direct(&self, hit: &Hit) -> DVec3 {
        let to_light = LIGHT - hit.position;
        let (distance, axis) = (to_light.length(), (LIGHT_TARGET - LIGHT).normalize());
        let angle = axis
            .dot(-to_light / distance)
            .clamp(-1.0, 1.0)
            .acos()
            .to_degrees();
        let falloff = ((35.0 - angle) / 10.0).clamp(0.0, 1.0);
        let cosine = hit.normal.dot(to_light) / distance;
        if falloff <= 0.0 || cosine <= 0.0 || hit.albedo == DVec3::ZERO {
            return DVec3::ZERO;
        }
        // Walls are lit unless a mirror stands in front.
        if self.cast(LIGHT, -to_light).t < 1.0 - 1e-6 {
            return DVec3::ZERO;
        }
        hit.albedo * (6.0 * falloff * cosine / (std::f64::consts::PI * distance * distance))
    }

    /// Direct radiance that a ray brings back by way of up to `bounces` mirrors; black after that.
    pub fn radiance(&self, origin: DVec3, ray: DVec3, bounces: u32) -> DVec3 {
        let hit = self.cast(origin, ray);
        match hit.kind {
            Kind::Wall(_) => self.direct(&hit),
            Kind::Mirror(_) if bounces > 0 => {
                self.radiance(hit.position, reflect(ray, hit.normal), bounces - 1)
            }
            Kind::Mirror(_) | Kind::Back(_) => DVec3::ZERO,
        }
    }

    /// What each pixel's centre shows, row by row from the top; `t` is the depth along the axis.
    pub fn view(&self, view: &View) -> Vec<Hit> {
        let pixel = |i: usize| {
            self.cast(
                view.position,
                view.direction(i % view.width, i / view.width),
            )
        };
        (0..view.width * view.height)
            .into_par_iter()
            .map(pixel)
            .collect()
    }
}

/// A ray after a mirror.
pub fn reflect(ray: DVec3, normal: DVec3) -> DVec3 {
    ray - normal * (2.0 * ray.dot(normal))
}

/// Number, axis, place along it and inward normal of each wall.
pub const WALLS: [(u8, usize, f64, DVec3); 6] = [
    (1, 0, -1.0, DVec3::X),
    (2, 0, 1.0, DVec3::NEG_X),
    (3, 1, -1.0, DVec3::Y),
    (4, 1, 1.0, DVec3::NEG_Y),
    (5, 2, -3.0, DVec3::Z),
    (6, 2, 1.0, DVec3::NEG_Z),
];

/// Where a ray from inside leaves the room.
fn wall(origin: DVec3, ray: DVec3) -> Hit {
    let mut first = (f64::INFINITY, 0, DVec3::ZERO);
    for (number, axis, side, normal) in WALLS {
        let t = (side - origin[axis]) / ray[axis];
        if ray.dot(normal) < 0.0 && t < first.0 {
            first = (t, number, normal);
        }
    }
    let (t, number, normal) = first;
    let position = origin + ray * t;
    Hit {
        t,
        position,
        normal,
        albedo: wall_albedo(number, position),
        kind: Kind::Wall(number),
    }
}

fn wall_albedo(number: u8, p: DVec3) -> DVec3 {
    let even = |a: f64, b: f64| ((a * 4.0).floor() as i64 + (b * 4.0).floor() as i64) % 2 == 0;
    DVec3::from(match number {
        1 => [0.63, 0.065, 0.05],
        2 => [0.14, 0.45, 0.091],
        3 if !even(p.x, p.z) => [0.25; 3],
        6 if even(p.x, p.y) => [0.75, 0.45, 0.10],
        6 => [0.10, 0.25, 0.65],
        _ => [0.725, 0.71, 0.68],
    })
}
