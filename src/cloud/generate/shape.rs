//! The mirrors that can be put into a scene, as a scene file describes them.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::surface::Surface;
use crate::cloud::TriangleMesh;
use crate::error::{Error, Result};

/// A mirror's surface in the scene's frame; lengths in the scene's unit.
///
/// Plane and paraboloid are one-sided: their front is where the normal points, their back is black.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A flat rectangle; its front is the side of `normal`.
    Plane {
        /// Its middle.
        centre: DVec3,
        /// Where its front looks; any length but 0.
        normal: DVec3,
        /// Roughly the direction of its height; made perpendicular to `normal`.
        up: DVec3,
        /// Width (across `up`) and height (along `up`).
        size: DVec2,
    },
    /// A ball, seen from outside.
    Sphere {
        /// Its middle.
        centre: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// A bowl; its front is the hollow side, towards the focus.
    Paraboloid {
        /// The deepest point.
        vertex: DVec3,
        /// Where it opens to; any length but 0.
        axis: DVec3,
        /// Distance from the vertex to the focus.
        focal_length: f64,
        /// Distance of the rim from the axis.
        rim_radius: f64,
    },
    /// A ring, seen from outside.
    Torus {
        /// Its middle.
        centre: DVec3,
        /// Perpendicular to the ring; any length but 0.
        axis: DVec3,
        /// Radius of the ring's centre line.
        major_radius: f64,
        /// Radius of the tube, below the major radius.
        minor_radius: f64,
    },
    /// A dented ball: along the unit direction d its radius is
    /// `radius (1 + amplitude sin(4 d.x) sin(4 d.y + 1) sin(4 d.z + 2))`.
    Blob {
        /// Its middle.
        centre: DVec3,
        /// Mean radius.
        radius: f64,
        /// Relative depth of the dents, above -1 and below 1.
        amplitude: f64,
    },
    /// A ball covered with small bumps and dents; `docs/SCENES.md` defines them.
    Bumps {
        /// Its middle.
        centre: DVec3,
        /// Mean radius.
        radius: f64,
    },
    /// A triangle mesh, seen from the side of its normals.
    Mesh(Arc<TriangleMesh>),
}

impl Shape {
    /// The shape, checked and ready to be sampled.
    ///
    /// # Errors
    /// [`Error::Setting`] where a length is not above 0, a direction is 0 or a value is not finite.
    pub fn surface(&self) -> Result<Surface> {
        Surface::new(self)
    }

    /// Area of the surface, in the square of the scene's unit.
    ///
    /// # Errors
    /// As [`Shape::surface`].
    pub fn area(&self) -> Result<f64> {
        Ok(self.surface()?.area())
    }

    /// The shape scaled by `factor` about the point `about`, then shifted by `shift`.
    #[must_use]
    pub fn scaled_and_shifted(&self, factor: f64, about: DVec3, shift: DVec3) -> Self {
        let place = |p: DVec3| about + (p - about) * factor + shift;
        match self.clone() {
            Self::Plane {
                centre,
                normal,
                up,
                size,
            } => Self::Plane {
                centre: place(centre),
                normal,
                up,
                size: size * factor,
            },
            Self::Sphere { centre, radius } => Self::Sphere {
                centre: place(centre),
                radius: radius * factor,
            },
            Self::Paraboloid {
                vertex,
                axis,
                focal_length,
                rim_radius,
            } => Self::Paraboloid {
                vertex: place(vertex),
                axis,
                focal_length: focal_length * factor,
                rim_radius: rim_radius * factor,
            },
            Self::Torus {
                centre,
                axis,
                major_radius,
                minor_radius,
            } => Self::Torus {
                centre: place(centre),
                axis,
                major_radius: major_radius * factor,
                minor_radius: minor_radius * factor,
            },
            Self::Blob {
                centre,
                radius,
                amplitude,
            } => Self::Blob {
                centre: place(centre),
                radius: radius * factor,
                amplitude,
            },
            Self::Bumps { centre, radius } => Self::Bumps {
                centre: place(centre),
                radius: radius * factor,
            },
            Self::Mesh(mesh) => Self::Mesh(Arc::new(mesh.with_places(place))),
        }
    }
}

/// Refuses a length that is not a finite number above 0.
pub(super) fn check_length(what: &str, value: f64) -> Result<f64> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(Error::Setting(format!(
            "the mirror's {what} is {value}; it must be a finite number above 0"
        )))
    }
}

/// Refuses a point that is not finite.
pub(super) fn check_point(what: &str, value: DVec3) -> Result<DVec3> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(Error::Setting(format!(
            "the mirror's {what} is {value}; it must be three finite numbers"
        )))
    }
}

/// A direction as a unit vector; refuses zero and non-finite ones.
pub(super) fn check_direction(what: &str, value: DVec3) -> Result<DVec3> {
    value.try_normalize().ok_or_else(|| {
        Error::Setting(format!(
            "the mirror's {what} is {value}; it must be a direction other than zero"
        ))
    })
}
