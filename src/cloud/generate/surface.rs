//! Area-uniform random points on the surface of a shape.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;
use rand::{Rng, RngExt};

use super::radial::{Blob, Bumps, Radial};
use super::shape::{Shape, check_direction, check_length, check_point};
use crate::cloud::TriangleMesh;
use crate::error::{Error, Result};

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// In the scene's frame.
    pub position: DVec3,
    /// Unit length, towards the front.
    pub normal: DVec3,
}

/// A shape, checked and ready to be sampled: every part of its area is as likely as every other of its size.
#[derive(Debug, Clone)]
pub struct Surface {
    kind: Kind,
    area: f64,
}

#[derive(Debug, Clone)]
enum Kind {
    Plane {
        centre: DVec3,
        half_right: DVec3,
        half_up: DVec3,
        normal: DVec3,
    },
    Sphere {
        centre: DVec3,
        radius: f64,
    },
    Paraboloid {
        frame: Frame,
        focal_length: f64,
        growth: f64,
    },
    Torus {
        frame: Frame,
        major_radius: f64,
        minor_radius: f64,
    },
    Blob(Radial<Blob>),
    Bumps(Radial<Bumps>),
    Mesh {
        mesh: Arc<TriangleMesh>,
        cumulative_area: Vec<f64>,
    },
}

/// Two axes perpendicular to a third, and the point they start from.
#[derive(Debug, Clone, Copy)]
struct Frame {
    origin: DVec3,
    u: DVec3,
    v: DVec3,
    axis: DVec3,
}

impl Frame {
    fn new(origin: DVec3, axis: DVec3) -> Self {
        let (u, v) = axis.any_orthonormal_pair();
        Self { origin, u, v, axis }
    }

    /// The direction at `angle` (radians) around the axis.
    fn around(&self, angle: f64) -> DVec3 {
        let (sin, cos) = angle.sin_cos();
        self.u * cos + self.v * sin
    }
}

impl Surface {
    /// Checks a shape and prepares it for sampling.
    pub(super) fn new(shape: &Shape) -> Result<Self> {
        let (kind, area) = match shape {
            Shape::Plane {
                centre,
                normal,
                up,
                size,
            } => {
                let centre = check_point("centre", *centre)?;
                let normal = check_direction("normal", *normal)?;
                let (width, height) =
                    (check_length("size", size.x)?, check_length("size", size.y)?);
                let right = check_direction("up", *up)?.cross(normal);
                let right = (right.length() > 1e-6)
                    .then(|| right.normalize())
                    .ok_or_else(|| {
                        Error::Setting(
                            "the mirror's up points along its normal; set up to another direction"
                                .into(),
                        )
                    })?;
                let half_right = right * (width / 2.0);
                let half_up = normal.cross(right) * (height / 2.0);
                (
                    Kind::Plane {
                        centre,
                        half_right,
                        half_up,
                        normal,
                    },
                    width * height,
                )
            }
            Shape::Sphere { centre, radius } => {
                let centre = check_point("centre", *centre)?;
                let radius = check_length("radius", *radius)?;
                (Kind::Sphere { centre, radius }, 4.0 * PI * radius * radius)
            }
            Shape::Paraboloid {
                vertex,
                axis,
                focal_length,
                rim_radius,
            } => {
                let frame = Frame::new(
                    check_point("vertex", *vertex)?,
                    check_direction("axis", *axis)?,
                );
                let f = check_length("focal_length", *focal_length)?;
                let slope = check_length("rim_radius", *rim_radius)? / (2.0 * f);
                // (1 + slope^2)^(3/2) - 1, which stays exact where the bowl is nearly flat.
                let growth = (1.5 * (slope * slope).ln_1p()).exp_m1();
                (
                    Kind::Paraboloid {
                        frame,
                        focal_length: f,
                        growth,
                    },
                    8.0 * PI / 3.0 * f * f * growth,
                )
            }
            Shape::Torus {
                centre,
                axis,
                major_radius,
                minor_radius,
            } => {
                let frame = Frame::new(
                    check_point("centre", *centre)?,
                    check_direction("axis", *axis)?,
                );
                let major_radius = check_length("major_radius", *major_radius)?;
                let minor_radius = check_length("minor_radius", *minor_radius)?;
                if minor_radius >= major_radius {
                    return Err(Error::Setting(format!(
                        "the mirror's minor_radius is {minor_radius}; it must be below its major_radius, {major_radius}"
                    )));
                }
                (
                    Kind::Torus {
                        frame,
                        major_radius,
                        minor_radius,
                    },
                    TAU * TAU * major_radius * minor_radius,
                )
            }
            Shape::Blob {
                centre,
                radius,
                amplitude,
            } => {
                let centre = check_point("centre", *centre)?;
                let radius = check_length("radius", *radius)?;
                if !(amplitude.abs() < 1.0) {
                    return Err(Error::Setting(format!(
                        "the mirror's amplitude is {amplitude}; it must be above -1 and below 1"
                    )));
                }
                let radial = Radial::new(
                    centre,
                    radius,
                    Blob {
                        amplitude: *amplitude,
                    },
                );
                let area = radial.area();
                (Kind::Blob(radial), area)
            }
            Shape::Bumps { centre, radius } => {
                let centre = check_point("centre", *centre)?;
                let radial = Radial::new(centre, check_length("radius", *radius)?, Bumps);
                let area = radial.area();
                (Kind::Bumps(radial), area)
            }
            Shape::Mesh(mesh) => {
                let cumulative_area = mesh.cumulative_area();
                let area = cumulative_area.last().copied().unwrap_or(0.0);
                if !(area > 0.0 && area.is_finite()) {
                    return Err(Error::Setting(
                        "the mesh has no triangle with an area; use another mesh".into(),
                    ));
                }
                (
                    Kind::Mesh {
                        mesh: Arc::clone(mesh),
                        cumulative_area,
                    },
                    area,
                )
            }
        };
        Ok(Self { kind, area })
    }

    /// Area, in the square of the scene's unit.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// One random point; every part of the area is as likely as every other of its size.
    pub fn sample<R: Rng>(&self, rng: &mut R) -> SurfacePoint {
        match &self.kind {
            Kind::Plane {
                centre,
                half_right,
                half_up,
                normal,
            } => {
                let (x, y) = (2.0 * unit(rng) - 1.0, 2.0 * unit(rng) - 1.0);
                SurfacePoint {
                    position: *centre + *half_right * x + *half_up * y,
                    normal: *normal,
                }
            }
            Kind::Sphere { centre, radius } => {
                let normal = direction(rng);
                SurfacePoint {
                    position: *centre + normal * *radius,
                    normal,
                }
            }
            Kind::Paraboloid {
                frame,
                focal_length: f,
                growth,
            } => {
                // The area within a radius grows as (1 + slope^2)^(3/2) - 1, which has a closed inverse.
                let slope = ((unit(rng) * growth).ln_1p() * (2.0 / 3.0))
                    .exp_m1()
                    .max(0.0)
                    .sqrt();
                let outwards = frame.around(TAU * unit(rng));
                SurfacePoint {
                    position: frame.origin
                        + outwards * (2.0 * f * slope)
                        + frame.axis * (f * slope * slope),
                    normal: (frame.axis - outwards * slope).normalize(),
                }
            }
            Kind::Torus {
                frame,
                major_radius,
                minor_radius,
            } => {
                let outwards = frame.around(TAU * unit(rng));
                // The outer half of the tube is longer than the inner: reject by the distance from the axis.
                let (sin, cos) = loop {
                    let (sin, cos) = (TAU * unit(rng)).sin_cos();
                    if unit(rng) * (major_radius + minor_radius)
                        <= major_radius + minor_radius * cos
                    {
                        break (sin, cos);
                    }
                };
                let normal = outwards * cos + frame.axis * sin;
                SurfacePoint {
                    position: frame.origin + outwards * *major_radius + normal * *minor_radius,
                    normal,
                }
            }
            Kind::Blob(radial) => radial.sample(rng),
            Kind::Bumps(radial) => radial.sample(rng),
            Kind::Mesh {
                mesh,
                cumulative_area,
            } => {
                let target = unit(rng) * self.area;
                let triangle = cumulative_area.partition_point(|&a| a <= target);
                // Uniform in the triangle: the square root turns a strip's length into an equal share.
                let (root, along) = (unit(rng).sqrt(), unit(rng));
                let weights = DVec3::new(1.0 - root, root * (1.0 - along), root * along);
                let (position, normal) = mesh.interpolate(triangle, weights);
                SurfacePoint { position, normal }
            }
        }
    }
}

/// A number in [0, 1).
pub(super) fn unit<R: Rng>(rng: &mut R) -> f64 {
    rng.random()
}

/// A uniform direction.
pub(super) fn direction<R: Rng>(rng: &mut R) -> DVec3 {
    let z = 2.0 * unit(rng) - 1.0;
    let (sin, cos) = (TAU * unit(rng)).sin_cos();
    let across = (1.0 - z * z).sqrt();
    DVec3::new(across * cos, across * sin, z)
}
