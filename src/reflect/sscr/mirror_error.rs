//! How far, and to which side, a mirror's reflection misses a point: the mirror-space error function of
//! [Preiner 2010, section 3.3], with its formula put right.

use glam::{Vec2, Vec3};

/// Smallest cosine between normal and view that is divided by: at silhouettes the error grows without bound.
const SMALLEST_COSINE: f32 = 1e-4;

/// A mirror at a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MirrorPoint {
    /// Relative to the scene's origin.
    pub position: Vec3,
    /// Unit length, on the side of the eye.
    pub normal: Vec3,
    /// Unit direction to the eye.
    pub to_eye: Vec3,
    /// Local spacing of the mirror's points.
    pub spacing: f32,
}

impl MirrorPoint {
    /// A direction in mirror space: z towards the eye, x in the plane of z and the picture's x axis `right`.
    pub fn mirror_space(&self, right: Vec3, d: Vec3) -> Vec3 {
        let z = self.to_eye;
        let x = (right - z * right.dot(z)).normalize_or_zero();
        let y = z.cross(x);
        Vec3::new(x.dot(d), y.dot(d), z.dot(d))
    }
}

/// Error of the mirror at a pixel towards `point`, right and up: both components are zero where the mirror shows the
/// point there, and nowhere else; on a plane or a convex mirror each changes its sign along its axis only once.
///
/// The difference of two stereographic projections from the direction opposite to the eye: that of the reflected view,
/// `n.xy / n.z`, and that of the direction to the point, `l.xy / (1 + l.z)`, in mirror space.
pub fn mirror_error(mirror: &MirrorPoint, right: Vec3, point: Vec3) -> Vec2 {
    let n = mirror.mirror_space(right, mirror.normal);
    let l = mirror.mirror_space(right, (point - mirror.position).normalize_or_zero());
    let reflected = 1.0 / n.z.max(SMALLEST_COSINE);
    // A point behind the mirror on the line of sight lies at the projection's pole.
    let seen = 1.0 / (1.0 + l.z).max(SMALLEST_COSINE);
    Vec2::new(n.x * reflected - l.x * seen, n.y * reflected - l.y * seen)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mirror(normal: Vec3) -> MirrorPoint {
        MirrorPoint {
            position: Vec3::new(0.1, 0.2, -1.0),
            normal: normal.normalize(),
            to_eye: Vec3::new(-0.1, -0.2, 1.0).normalize(),
            spacing: 0.01,
        }
    }

    #[test]
    fn the_error_vanishes_along_the_reflected_ray_and_nowhere_else() {
        let m = mirror(Vec3::new(0.3, -0.2, 1.0));
        let view = -m.to_eye;
        let reflected = view - m.normal * (2.0 * view.dot(m.normal));
        let error = mirror_error(&m, Vec3::X, m.position + reflected * 2.5);
        assert!(error.length() < 1e-6, "on the ray: {error}");
        let beside = (reflected + Vec3::new(0.01, 0.0, 0.0)).normalize();
        let error = mirror_error(&m, Vec3::X, m.position + beside * 2.5);
        assert!(error.length() > 2e-3, "beside the ray: {error}");
    }

    #[test]
    fn poles_stay_finite() {
        let m = mirror(Vec3::Z);
        for point in [
            m.position - m.to_eye * 3.0,
            m.position,
            m.position + m.to_eye,
        ] {
            let error = mirror_error(&m, Vec3::X, point);
            assert!(error.is_finite(), "{point}: {error}");
        }
        let edge_on = MirrorPoint {
            normal: m.to_eye.cross(Vec3::X).normalize(),
            ..m
        };
        assert!(
            mirror_error(&edge_on, m.to_eye, m.position + Vec3::X).is_finite(),
            "at a silhouette, with the axis along the view"
        );
    }
}
