//! Area-uniform random points on the surface of a shape.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;
use rand::{Rng, RngExt};

use super::parametric::{Ball, Bowl, Rectangle, Ring};
use super::radial::{Blob, Bumps, Radial};
use super::shape::{Shape, check_length, check_point};
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
    Rectangle(Rectangle),
    Ball(Ball),
    Bowl(Bowl),
    Ring(Ring),
    Blob(Radial<Blob>),
    Bumps(Radial<Bumps>),
    Mesh(Triangles),
}

impl Surface {
    /// Checks a shape and prepares it for sampling.
    pub(super) fn new(shape: &Shape) -> Result<Self> {
        let kind = match *shape {
            Shape::Plane {
                centre,
                normal,
                up,
                size,
            } => Kind::Rectangle(Rectangle::new(centre, normal, up, size)?),
            Shape::Sphere { centre, radius } => Kind::Ball(Ball::new(centre, radius)?),
            Shape::Paraboloid {
                vertex,
                axis,
                focal_length,
                rim_radius,
            } => Kind::Bowl(Bowl::new(vertex, axis, focal_length, rim_radius)?),
            Shape::Torus {
                centre,
                axis,
                major_radius,
                minor_radius,
            } => Kind::Ring(Ring::new(centre, axis, major_radius, minor_radius)?),
            Shape::Blob {
                centre,
                radius,
                amplitude,
            } => {
                let (centre, radius) = (
                    check_point("centre", centre)?,
                    check_length("radius", radius)?,
                );
                Kind::Blob(Radial::new(centre, radius, Blob::new(amplitude)?))
            }
            Shape::Bumps { centre, radius } => {
                let (centre, radius) = (
                    check_point("centre", centre)?,
                    check_length("radius", radius)?,
                );
                Kind::Bumps(Radial::new(centre, radius, Bumps))
            }
            Shape::Mesh(ref mesh) => Kind::Mesh(Triangles::new(mesh)),
        };
        let area = match &kind {
            Kind::Rectangle(s) => s.area(),
            Kind::Ball(s) => s.area(),
            Kind::Bowl(s) => s.area(),
            Kind::Ring(s) => s.area(),
            Kind::Blob(s) => s.area(),
            Kind::Bumps(s) => s.area(),
            Kind::Mesh(s) => s.area(),
        };
        if area > 0.0 && area.is_finite() {
            Ok(Self { kind, area })
        } else {
            Err(Error::Setting(format!(
                "the mirror's area comes out as {area}; make it larger or smaller"
            )))
        }
    }

    /// Area, in the square of the scene's unit; finite and above 0.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// One random point; every part of the area is as likely as every other of its size.
    pub fn sample<R: Rng>(&self, rng: &mut R) -> SurfacePoint {
        match &self.kind {
            Kind::Rectangle(s) => s.sample(rng),
            Kind::Ball(s) => s.sample(rng),
            Kind::Bowl(s) => s.sample(rng),
            Kind::Ring(s) => s.sample(rng),
            Kind::Blob(s) => s.sample(rng),
            Kind::Bumps(s) => s.sample(rng),
            Kind::Mesh(s) => s.sample(rng),
        }
    }
}

/// A mesh, and the area of its triangles up to and including each.
#[derive(Debug, Clone)]
struct Triangles {
    mesh: Arc<TriangleMesh>,
    cumulative_area: Vec<f64>,
}

impl Triangles {
    fn new(mesh: &Arc<TriangleMesh>) -> Self {
        Self {
            mesh: Arc::clone(mesh),
            cumulative_area: mesh.cumulative_area(),
        }
    }

    fn area(&self) -> f64 {
        self.cumulative_area.last().copied().unwrap_or(0.0)
    }

    fn sample<R: Rng>(&self, rng: &mut R) -> SurfacePoint {
        let target = unit(rng) * self.area();
        let triangle = self.cumulative_area.partition_point(|&a| a <= target);
        // Uniform in the triangle: the square root gives every strip along a side its share.
        let (root, along) = (unit(rng).sqrt(), unit(rng));
        let weights = DVec3::new(1.0 - root, root * (1.0 - along), root * along);
        let (position, normal) = self.mesh.interpolate(triangle, weights);
        SurfacePoint { position, normal }
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
