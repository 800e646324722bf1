//! Surfaces with a closed formula: rectangle, sphere, bowl and ring.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use rand::Rng;

use super::shape::{check_direction, check_length, check_point};
use super::surface::{SurfacePoint, direction, unit};
use crate::error::{Error, Result};

/// A flat rectangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rectangle {
    centre: DVec3,
    right: DVec3,
    up: DVec3,
    normal: DVec3,
    size: DVec2,
}

impl Rectangle {
    pub(super) fn new(centre: DVec3, normal: DVec3, up: DVec3, size: DVec2) -> Result<Self> {
        let centre = check_point("centre", centre)?;
        let normal = check_direction("normal", normal)?;
        let size = DVec2::new(check_length("size", size.x)?, check_length("size", size.y)?);
        let right = check_direction("up", up)?.cross(normal);
        if right.length() < 1e-6 {
            return Err(Error::Setting(
                "the mirror's up points along its normal; set up to another direction".into(),
            ));
        }
        let right = right.normalize();
        Ok(Self {
            centre,
            right,
            up: normal.cross(right),
            normal,
            size,
        })
    }

    pub(super) fn area(&self) -> f64 {
        self.size.x * self.size.y
    }

    pub(super) fn sample<R: Rng>(&self, rng: &mut R) -> SurfacePoint {
        let (x, y) = (
            (unit(rng) - 0.5) * self.size.x,
            (unit(rng) - 0.5) * self.size.y,
        );
        SurfacePoint {
            position: self.centre + self.right * x + self.up * y,
            normal: self.normal,
        }
    }
}

/// A ball, seen from outside.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ball {
    centre: DVec3,
    radius: f64,
}

impl Ball {
    pub(super) fn new(centre: DVec3, radius: f64) -> Result<Self> {
        Ok(Self {
            centre: check_point("centre", centre)?,
            radius: check_length("radius", radius)?,
        })
    }

    pub(super) fn area(&self) -> f64 {
        4.0 * PI * self.radius * self.radius
    }

    pub(super) fn sample<R: Rng>(&self, rng: &mut R) -> SurfacePoint {
        let normal = direction(rng);
        SurfacePoint {
            position: self.centre + normal * self.radius,
            normal,
        }
    }
}

/// An axis through a point, and two directions across it.
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

/// A paraboloid, seen from its hollow side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bowl {
    frame: Frame,
    focal_length: f64,
    /// (1 + s^2)^(3/2) - 1, where s is the slope at the rim; the area grows with it.
    growth: f64,
}

impl Bowl {
    pub(super) fn new(
        vertex: DVec3,
        axis: DVec3,
        focal_length: f64,
        rim_radius: f64,
    ) -> Result<Self> {
        let frame = Frame::new(
            check_point("vertex", vertex)?,
            check_direction("axis", axis)?,
        );
        let focal_length = check_length("focal_length", focal_length)?;
        let slope = check_length("rim_radius", rim_radius)? / (2.0 * focal_length);
        // By way of the logarithm it stays exact where the bowl is nearly flat.
        let growth = (1.5 * (slope * slope).ln_1p()).exp_m1();
        Ok(Self {
            frame,
            focal_length,
            growth,
        })
    }

    pub(super) fn area(&self) -> f64 {
        8.0 * PI / 3.0 * self.focal_length * self.focal_length * self.growth
    }

    pub(super) fn sample<R: Rng>(&self, rng: &mut R) -> SurfacePoint {
        let slope = ((unit(rng) * self.growth).ln_1p() * (2.0 / 3.0))
            .exp_m1()
            .max(0.0)
            .sqrt();
        let outwards = self.frame.around(TAU * unit(rng));
        let (across, along) = (
            2.0 * self.focal_length * slope,
            self.focal_length * slope * slope,
        );
        SurfacePoint {
            position: self.frame.origin + outwards * across + self.frame.axis * along,
            normal: (self.frame.axis - outwards * slope).normalize(),
        }
    }
}

/// A torus, seen from outside.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ring {
    frame: Frame,
    major: f64,
    minor: f64,
}

impl Ring {
    pub(super) fn new(
        centre: DVec3,
        axis: DVec3,
        major_radius: f64,
        minor_radius: f64,
    ) -> Result<Self> {
        let frame = Frame::new(
            check_point("centre", centre)?,
            check_direction("axis", axis)?,
        );
        let major = check_length("major_radius", major_radius)?;
        let minor = check_length("minor_radius", minor_radius)?;
        if minor >= major {
            return Err(Error::Setting(format!(
                "the mirror's minor_radius is {minor}; it must be below its major_radius, {major}"
            )));
        }
        Ok(Self {
            frame,
            major,
            minor,
        })
    }

    pub(super) fn area(&self) -> f64 {
        TAU * TAU * self.major * self.minor
    }

    pub(super) fn sample<R: Rng>(&self, rng: &mut R) -> SurfacePoint {
        let outwards = self.frame.around(TAU * unit(rng));
        // The outer half of the tube is longer than the inner: reject by the distance from the axis.
        let (sin, cos) = loop {
            let (sin, cos) = (TAU * unit(rng)).sin_cos();
            if unit(rng) * (self.major + self.minor) <= self.major + self.minor * cos {
                break (sin, cos);
            }
        };
        let normal = outwards * cos + self.frame.axis * sin;
        SurfacePoint {
            position: self.frame.origin + outwards * self.major + normal * self.minor,
            normal,
        }
    }
}
