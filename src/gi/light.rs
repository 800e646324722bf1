//! Spot lights, and the projection through which their shadow maps are splatted.

use glam::{UVec2, Vec2, Vec3};

use crate::camera::Pinhole;

/// Largest outer half angle of a spot, degrees: one pinhole map must hold the cone.
pub const MAX_OUTER_DEGREES: f32 = 80.0;

/// Texels beyond the cone on each side, so that filtering never leaves the map.
const MARGIN_TEXELS: f32 = 2.0;

/// A spot light, relative to the scene's origin: full inside the inner half angle, falling linearly in angle to 0 at
/// the outer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotLight {
    /// Relative to the scene's origin.
    pub position: Vec3,
    /// Unit vector along the axis.
    pub axis: Vec3,
    /// W/sr per channel.
    pub intensity: Vec3,
    /// Half angle, radians.
    pub inner_angle: f32,
    /// Half angle, radians, at most [`MAX_OUTER_DEGREES`].
    pub outer_angle: f32,
}

impl SpotLight {
    /// The share of the intensity, 0 to 1, in the direction whose cosine with the axis is `cosine`.
    pub fn falloff(&self, cosine: f32) -> f32 {
        let angle = cosine.clamp(-1.0, 1.0).acos();
        let width = (self.outer_angle - self.inner_angle).max(1e-6);
        ((self.outer_angle - angle) / width).clamp(0.0, 1.0)
    }

    /// The pinhole of the light's map of `side` texels, for points up to `reach` away.
    pub fn pinhole(&self, side: u32, reach: f32) -> Pinhole {
        let half = side as f32 * 0.5;
        let focal = (half - MARGIN_TEXELS.min(half * 0.5)) / self.outer_angle.tan();
        let right = self.axis.any_orthonormal_vector();
        Pinhole {
            eye: self.position,
            focal,
            right,
            near: reach * 1e-5,
            up: right.cross(self.axis),
            far: reach,
            forward: self.axis,
            inverse_focal: 1.0 / focal,
            centre: Vec2::splat(half),
            size: UVec2::splat(side),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_falloff_is_linear_in_angle() {
        let light = SpotLight {
            position: Vec3::ZERO,
            axis: Vec3::Z,
            intensity: Vec3::ONE,
            inner_angle: 25f32.to_radians(),
            outer_angle: 35f32.to_radians(),
        };
        for (degrees, expected) in [
            (0.0, 1.0),
            (25.0, 1.0),
            (30.0, 0.5),
            (34.0, 0.1),
            (35.0, 0.0),
            (90.0, 0.0),
        ] {
            let got = light.falloff(f32::to_radians(degrees).cos());
            assert!(
                (got - expected).abs() < 1e-3,
                "at {degrees} degrees got {got}, expected {expected}"
            );
        }
    }

    #[test]
    fn the_map_holds_the_cone_and_loses_few_texels() {
        let light = SpotLight {
            position: Vec3::ZERO,
            axis: Vec3::new(0.48, -0.6, 0.64),
            intensity: Vec3::ONE,
            inner_angle: 0.0,
            outer_angle: 35f32.to_radians(),
        };
        let p = light.pinhole(1024, 10.0);
        let edge = p.focal * light.outer_angle.tan();
        assert!(
            (edge - 510.0).abs() < 0.01,
            "the cone reaches {edge} texels from the centre"
        );
        assert!(
            p.right.cross(p.up).dot(-p.forward) > 0.999,
            "right, up and backward are right-handed"
        );
    }
}
