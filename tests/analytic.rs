//! The oracle: casts rays, in f64, into the scenes of `docs/SCENES.md`. It shares no code with the program.

#![expect(clippy::panic, reason = "a test fails by panicking")]

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::forms::{C, Form};

/// What a ray meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Left, right, floor, ceiling, back, front: 1 to 6.
    Wall(u8),
    /// The front of the mirror of that number.
    Mirror(usize),
    /// The black back of the mirror of that number.
    Back(usize),
}

/// Where a ray meets the scene.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hit {
    /// Along the ray, in multiples of its direction.
    pub(crate) t: f64,
    pub(crate) position: DVec3,
    /// Unit length, of the front.
    pub(crate) normal: DVec3,
    /// Linear RGB; 0 on mirrors.
    pub(crate) albedo: DVec3,
    pub(crate) kind: Kind,
}

/// A camera.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View {
    pub(crate) position: DVec3,
    pub(crate) target: DVec3,
    pub(crate) up: DVec3,
    pub(crate) fov_y_degrees: f64,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl View {
    /// The camera of the reference scenes.
    pub(crate) const REFERENCE: Self = Self {
        position: DVec3::new(0.0, 0.0, 0.9),
        target: DVec3::new(0.0, 0.0, -1.1),
        up: DVec3::Y,
        fov_y_degrees: 60.0,
        width: 800,
        height: 600,
    };

    /// The ray through the centre of a pixel, 1 long along the axis.
    pub(crate) fn direction(&self, x: usize, y: usize) -> DVec3 {
        self.through(DVec2::new(x as f64 + 0.5, y as f64 + 0.5))
    }

    /// The ray through a place of the picture, pixels from the top left, 1 long along the axis.
    pub(crate) fn through(&self, at: DVec2) -> DVec3 {
        let forward = (self.target - self.position).normalize();
        let right = forward.cross(self.up).normalize();
        let tan = (self.fov_y_degrees / 2.0).to_radians().tan();
        let aspect = self.width as f64 / self.height as f64;
        let sx = (2.0 * at.x / self.width as f64 - 1.0) * tan * aspect;
        let sy = (1.0 - 2.0 * at.y / self.height as f64) * tan;
        forward + right * sx + right.cross(forward) * sy
    }
}

/// A mirror: its form, scaled about `C` and shifted.
#[derive(Debug, Clone, Copy)]
struct Mirror {
    form: Form,
    scale: f64,
    shift: DVec3,
}

/// The light of the reference scenes.
const LIGHT: DVec3 = DVec3::new(-0.6, 0.9, 0.2);
const LIGHT_TARGET: DVec3 = DVec3::new(1.0, -1.0, -3.0);

/// A reference scene.
#[derive(Debug, Clone)]
pub(crate) struct Oracle {
    mirrors: Vec<Mirror>,
}

impl Oracle {
    /// A scene by its name; `multi` is without the bunny.
    ///
    /// # Panics
    /// Where there is no scene of that name.
    pub(crate) fn named(name: &str) -> Self {
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
    pub(crate) fn cast(&self, origin: DVec3, ray: DVec3) -> Hit {
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
    pub(crate) fn nearest(&self, p: DVec3) -> (f64, Hit) {
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
    pub(crate) fn radius(&self, d: DVec3) -> f64 {
        match self.mirrors[0].form {
            Form::Sphere => 0.44,
            form => 1.0 - form.level(C + d),
        }
    }

    /// Direct radiance of what was hit, the same towards everywhere: W/sr/m2 per channel.
    pub(crate) fn direct(&self, hit: &Hit) -> DVec3 {
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
    pub(crate) fn radiance(&self, origin: DVec3, ray: DVec3, bounces: u32) -> DVec3 {
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
    pub(crate) fn view(&self, view: &View) -> Vec<Hit> {
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
pub(crate) fn reflect(ray: DVec3, normal: DVec3) -> DVec3 {
    ray - normal * (2.0 * ray.dot(normal))
}

/// Number, axis, place along it and inward normal of each wall.
pub(crate) const WALLS: [(u8, usize, f64, DVec3); 6] = [
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
