//! Pass `average`: sums become a pixel's one surfel. CPU twin of `shaders/average.wgsl`.

use glam::{Vec3, Vec4};

use super::depth_from_key;
use super::visibility::Sums;
use crate::cloud::shininess_from_log;

/// One pixel of a G-buffer: see [`super::GBuffer`] for the three vectors.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pixel {
    /// Normal and depth.
    pub surface: Vec4,
    /// Linear RGB and mirror reflectance.
    pub albedo: Vec4,
    /// Specular reflectance, shininess, radius, valid.
    pub material: Vec4,
}

/// The surfel that a pixel shows; all zero where it shows none.
pub fn average(key: u32, sums: &Sums) -> Pixel {
    let Some(front) = depth_from_key(key) else {
        return Pixel::default();
    };
    let [weight, behind, specular, shininess] = sums.depth.map(|v| v as f32);
    if weight <= 0.0 {
        return Pixel::default();
    }
    let inverse = 1.0 / weight;
    let [red, green, blue, mirror] = sums.albedo.map(|v| v as f32 * inverse);
    let [x, y, z, radius] = sums.normal.map(|v| v as f32 * inverse);
    let length_squared = x * x + y * y + z * z;
    // Opposite normals that cancel leave none: any unit vector is as good, and none is NaN.
    let normal = if length_squared > 1e-12 {
        Vec3::new(x, y, z) / length_squared.sqrt()
    } else {
        Vec3::Z
    };
    Pixel {
        surface: normal.extend(front + behind * inverse * front),
        albedo: Vec4::new(red, green, blue, mirror),
        material: Vec4::new(
            specular * inverse,
            shininess_from_log(shininess * inverse),
            radius * front,
            1.0,
        ),
    }
}
