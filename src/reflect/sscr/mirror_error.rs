//! How far, and to which side, a mirror's reflection misses a point: the mirror-space error function of
//! [Preiner 2010, section 3.3], with its formula put right.

use super::scalar::{Scalar, Vector};

/// Smallest cosine between normal and view that is divided by: at silhouettes the error grows without bound.
pub const SMALLEST_COSINE: f32 = 1e-4;

/// A mirror at a pixel, with what the error there takes from it alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MirrorPoint<R: Scalar = f32> {
    /// Relative to the scene's origin.
    pub position: R::Vec3,
    /// Unit length, on the side of the eye.
    pub normal: R::Vec3,
    /// Mirror space's z axis: the unit direction to the eye.
    pub to_eye: R::Vec3,
    /// Mirror space's x axis: unit length, in the plane of `to_eye` and the picture's x axis.
    pub right: R::Vec3,
    /// The reflected view in the projection that errors are taken in.
    pub reflected: R::Vec2,
    /// Local spacing of the mirror's points.
    pub spacing: R,
}

impl<R: Scalar> MirrorPoint<R> {
    /// The mirror at `position`, of unit `normal` and with points at `spacing`, seen from `eye` in a picture with the unit
    /// x axis `right`.
    pub fn new(
        position: R::Vec3,
        normal: R::Vec3,
        spacing: R,
        eye: R::Vec3,
        right: R::Vec3,
    ) -> Self {
        let to_eye = R::unit(eye - position);
        let mut mirror = Self {
            position,
            normal,
            to_eye,
            right: R::unit(right - to_eye * right.dot(to_eye)),
            ..Self::none()
        };
        let [x, y, z] = R::parts3(mirror.mirror_space(normal));
        let cosine = z.max(R::of(SMALLEST_COSINE));
        mirror.reflected = R::vec2(x / cosine, y / cosine);
        mirror.spacing = spacing;
        mirror
    }

    /// No mirror.
    pub fn none() -> Self {
        let zero = R::default();
        let nowhere = R::vec3(zero, zero, zero);
        Self {
            position: nowhere,
            normal: nowhere,
            to_eye: nowhere,
            right: nowhere,
            reflected: R::vec2(zero, zero),
            spacing: zero,
        }
    }

    /// A direction in mirror space: right, up, towards the eye.
    #[inline]
    pub fn mirror_space(&self, d: R::Vec3) -> R::Vec3 {
        let up = R::cross(self.to_eye, self.right);
        R::vec3(self.right.dot(d), up.dot(d), self.to_eye.dot(d))
    }
}

/// Error of the mirror at a pixel towards `point`, right and up: both components are zero where the mirror shows the
/// point there, and nowhere else; on a plane or a convex mirror each changes its sign along its axis only once.
///
/// The difference of two stereographic projections from the direction opposite to the eye: that of the reflected view,
/// `n.xy / n.z`, and that of the direction to the point, `q.xy / (|q| + q.z)`, in mirror space.
#[inline]
pub fn mirror_error<R: Scalar>(mirror: &MirrorPoint<R>, point: R::Vec3) -> R::Vec2 {
    let q = mirror.mirror_space(point - mirror.position);
    let distance = q.length();
    let [x, y, z] = R::parts3(q);
    // A point behind the mirror on the line of sight lies at the projection's pole, one on the mirror anywhere.
    let pole = (R::of(SMALLEST_COSINE) * distance).max(R::MIN_POSITIVE);
    let seen = R::of(1.0) / (distance + z).max(pole);
    let [reflected_x, reflected_y] = R::parts2(mirror.reflected);
    R::vec2(reflected_x - x * seen, reflected_y - y * seen)
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;

    const POSITION: Vec3 = Vec3::new(0.1, 0.2, -1.0);

    fn mirror(normal: Vec3, right: Vec3) -> MirrorPoint {
        MirrorPoint::new(POSITION, normal.normalize(), 0.01, Vec3::ZERO, right)
    }

    #[test]
    fn the_error_vanishes_along_the_reflected_ray_and_nowhere_else() {
        let m = mirror(Vec3::new(0.3, -0.2, 1.0), Vec3::X);
        let view = -m.to_eye;
        let reflected = view - m.normal * (2.0 * view.dot(m.normal));
        let error = mirror_error(&m, m.position + reflected * 2.5);
        assert!(error.length() < 1e-6, "on the ray: {error}");
        let beside = (reflected + Vec3::new(0.01, 0.0, 0.0)).normalize();
        let error = mirror_error(&m, m.position + beside * 2.5);
        assert!(error.length() > 2e-3, "beside the ray: {error}");
    }

    #[test]
    fn poles_stay_finite() {
        let m = mirror(Vec3::Z, Vec3::X);
        for point in [
            m.position - m.to_eye * 3.0,
            m.position,
            m.position + m.to_eye,
        ] {
            let error = mirror_error(&m, point);
            assert!(error.is_finite(), "{point}: {error}");
        }
        // At a silhouette, with the picture's axis along the view, from the mirror itself.
        let across = POSITION.cross(Vec3::X);
        for m in [
            mirror(across, Vec3::X),
            mirror(Vec3::Z, POSITION.normalize()),
            MirrorPoint::new(POSITION, Vec3::Z, 0.01, POSITION, Vec3::X),
        ] {
            let error = mirror_error(&m, m.position + Vec3::X);
            assert!(error.is_finite(), "{m:?}: {error}");
        }
    }

    #[test]
    fn f64_tells_what_f32_rounds() {
        let (single, normal) = (
            mirror(Vec3::new(0.3, -0.2, 1.0), Vec3::X),
            DVec3::new(0.3, -0.2, 1.0),
        );
        let double: MirrorPoint<f64> = MirrorPoint::new(
            POSITION.as_dvec3(),
            normal.normalize(),
            0.01,
            DVec3::ZERO,
            DVec3::X,
        );
        let point = Vec3::new(0.7, -0.4, 0.8);
        let exact = mirror_error(&double, point.as_dvec3());
        let apart = (mirror_error(&single, point).as_dvec2() - exact).length();
        assert!(apart < 1e-6, "{apart}");
        assert!(apart > 1e-12, "f64 is as coarse as f32");
    }
}
