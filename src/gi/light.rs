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
    /// Whether its cone is a square pyramid instead, full all over: the sixth part of a point light around one of the scene's
    /// axes. The angles are not used then.
    pub pyramid: bool,
}

/// Half a right angle and a little: the map of a pyramid holds its edges.
const PYRAMID_ANGLE: f32 = std::f32::consts::FRAC_PI_4;

impl SpotLight {
    /// The six parts of a light that shines in all directions.
    pub fn all_around(position: Vec3, intensity: Vec3) -> [Self; 6] {
        [
            Vec3::X,
            Vec3::NEG_X,
            Vec3::Y,
            Vec3::NEG_Y,
            Vec3::Z,
            Vec3::NEG_Z,
        ]
        .map(|axis| Self {
            position,
            axis,
            intensity,
            inner_angle: PYRAMID_ANGLE,
            outer_angle: PYRAMID_ANGLE,
            pyramid: true,
        })
    }

    /// The share of the intensity, 0 to 1, in a unit direction.
    pub fn falloff_towards(&self, direction: Vec3) -> f32 {
        if self.pyramid {
            return f32::from(u8::from(self.pyramid_holds(direction)));
        }
        self.falloff(direction.dot(self.axis))
    }

    /// Whether a direction lies in the pyramid around the axis. Of the six around a point every direction is in exactly
    /// one: edges belong to the first axis that they touch.
    fn pyramid_holds(&self, d: Vec3) -> bool {
        let along = d.dot(self.axis);
        let size = d.abs();
        if self.axis.x != 0.0 {
            along > 0.0 && size.y <= along && size.z <= along
        } else if self.axis.y != 0.0 {
            along > 0.0 && size.x < along && size.z <= along
        } else {
            along > 0.0 && size.x < along && size.y < along
        }
    }

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
            pyramid: false,
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
    fn every_direction_is_in_one_pyramid() {
        let six = SpotLight::all_around(Vec3::ZERO, Vec3::ONE);
        for i in 0..4096 {
            // Edges and corners are among them.
            let d = Vec3::new((i % 16) as f32, (i / 16 % 16) as f32, (i / 256) as f32) - 8.0;
            if d == Vec3::ZERO {
                continue;
            }
            let shares: f32 = six.iter().map(|part| part.falloff_towards(d)).sum();
            assert_eq!(shares, 1.0, "towards {d}");
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
            pyramid: false,
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
