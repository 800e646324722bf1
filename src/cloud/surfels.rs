//! The surfels that every stage works on: oriented discs with a material, 32 bytes each in two columns.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

/// Place and size of a surfel; the first of its two columns. Same layout on the GPU (`vec4f`).
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Place {
    /// Metres (or the files' unit), relative to the scene's origin.
    pub position: Vec3,
    /// The local spacing, in the unit of `position`; a splat's half width is `splat.size` times this.
    pub radius: f32,
}

/// Orientation and material of a surfel, packed; the second column. Same layout on the GPU (`vec4u`,
/// unpacked in `shaders/shared/surfel.wgsl`).
///
/// Both backends read these same 16 bytes, so quantisation can never make them differ:
/// word 0 normal x, y; word 1 normal z, red; word 2 green, blue; word 3 mirror, specular (8 bits each), shininess.
/// Normals are signed 16-bit (0.002 degrees), albedo is linear unsigned 16-bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Finish(pub [u32; 4]);

/// One surfel, unpacked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surfel {
    /// Relative to the scene's origin, in the files' unit.
    pub position: Vec3,
    /// Local spacing, in the unit of `position`.
    pub radius: f32,
    /// Unit length.
    pub normal: Vec3,
    /// Linear RGB, 0 to 1.
    pub albedo: Vec3,
    /// Mirror reflectance, 0 to 1; the surfel is a mirror where it is above 0.
    pub mirror: f32,
    /// Specular reflectance, 0 to 1.
    pub specular: f32,
    /// Exponent of the normalised Phong lobe, 0 to 65535.
    pub shininess: f32,
}

/// Largest exponent of a Phong lobe that is kept; more is clamped to it.
pub const MAX_SHININESS: f32 = 65_535.0;

/// `log2(1 + shininess)` of [`MAX_SHININESS`]: shininess is stored and blended on this scale.
pub const SHININESS_LOG_RANGE: f32 = 16.0;

fn unorm(value: f32, max: f32) -> u32 {
    (value.clamp(0.0, 1.0) * max + 0.5) as u32
}

fn snorm16(value: f32) -> u32 {
    let rounded = (value.clamp(-1.0, 1.0) * 32_767.0).round() as i16;
    u32::from(rounded as u16)
}

fn unpack_snorm16(bits: u32) -> f32 {
    f32::from((bits & 0xffff) as u16 as i16) * (1.0 / 32_767.0)
}

fn unpack_unorm16(bits: u32) -> f32 {
    f32::from((bits & 0xffff) as u16) * (1.0 / 65_535.0)
}

impl Finish {
    /// Packs normal and material. A reflectance above 0 stays above 0.
    pub fn pack(s: &Surfel) -> Self {
        let mirror = if s.mirror > 0.0 {
            unorm(s.mirror, 255.0).max(1)
        } else {
            0
        };
        let shininess = (1.0 + s.shininess.clamp(0.0, MAX_SHININESS)).log2() / SHININESS_LOG_RANGE;
        Self([
            snorm16(s.normal.x) | snorm16(s.normal.y) << 16,
            snorm16(s.normal.z) | unorm(s.albedo.x, 65_535.0) << 16,
            unorm(s.albedo.y, 65_535.0) | unorm(s.albedo.z, 65_535.0) << 16,
            mirror | unorm(s.specular, 255.0) << 8 | unorm(shininess, 65_535.0) << 16,
        ])
    }

    /// The normal; its length is 1 to within 5e-5.
    pub fn normal(self) -> Vec3 {
        let [a, b, ..] = self.0;
        Vec3::new(
            unpack_snorm16(a),
            unpack_snorm16(a >> 16),
            unpack_snorm16(b),
        )
    }

    /// Linear RGB, 0 to 1.
    pub fn albedo(self) -> Vec3 {
        let [_, b, c, _] = self.0;
        Vec3::new(
            unpack_unorm16(b >> 16),
            unpack_unorm16(c),
            unpack_unorm16(c >> 16),
        )
    }

    /// Mirror reflectance, 0 to 1.
    pub fn mirror(self) -> f32 {
        (self.0[3] & 0xff) as f32 * (1.0 / 255.0)
    }

    /// Specular reflectance, 0 to 1.
    pub fn specular(self) -> f32 {
        (self.0[3] >> 8 & 0xff) as f32 * (1.0 / 255.0)
    }

    /// Shininess on the scale `log2(1 + s) / 16`, 0 to 1, on which it is blended.
    pub fn shininess_log(self) -> f32 {
        unpack_unorm16(self.0[3] >> 16)
    }
}

/// Shininess from the scale on which it is stored and blended.
pub fn shininess_from_log(log: f32) -> f32 {
    (log * SHININESS_LOG_RANGE).exp2() - 1.0
}

/// The points of a scene as oriented discs, structure of arrays, in shuffled order.
///
/// The order is a fixed random permutation of the source, so that any prefix or slice is a fair sample of the whole.
#[derive(Debug, Clone, PartialEq)]
pub struct Surfels {
    /// Place and size.
    pub places: Vec<Place>,
    /// Orientation and material.
    pub finishes: Vec<Finish>,
    /// Index of each surfel in the order of the sources (all clouds of the scene one after the other).
    pub source: Vec<u32>,
    /// What `position` is relative to, in the scene's frame.
    pub origin: DVec3,
}

impl Surfels {
    /// Number of surfels.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// One surfel, unpacked; `None` outside.
    pub fn get(&self, index: usize) -> Option<Surfel> {
        let (place, finish) = (self.places.get(index)?, self.finishes.get(index)?);
        Some(Surfel {
            position: place.position,
            radius: place.radius,
            normal: finish.normal(),
            albedo: finish.albedo(),
            mirror: finish.mirror(),
            specular: finish.specular(),
            shininess: shininess_from_log(finish.shininess_log()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packing_keeps_a_surfel_to_its_stated_precision() {
        let s = Surfel {
            position: Vec3::ZERO,
            radius: 1.0,
            normal: Vec3::new(0.48, -0.6, 0.64),
            albedo: Vec3::new(0.725, 0.0, 1.0),
            mirror: 1e-4,
            specular: 0.5,
            shininess: 40.0,
        };
        let f = Finish::pack(&s);
        assert!(
            f.normal().angle_between(s.normal) < 5e-5,
            "normal {:?}",
            f.normal()
        );
        assert!(
            (f.albedo() - s.albedo).abs().max_element() < 1e-5,
            "albedo {:?}",
            f.albedo()
        );
        assert!(f.mirror() > 0.0, "a faint mirror stays a mirror");
        assert!(
            (f.specular() - 0.5).abs() < 3e-3,
            "specular {}",
            f.specular()
        );
        let shininess = shininess_from_log(f.shininess_log());
        assert!(
            (shininess / 40.0 - 1.0).abs() < 1e-3,
            "shininess {shininess}"
        );
    }
}
