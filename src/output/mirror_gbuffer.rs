//! The mirrors' G-buffer as an EXR file.

use glam::{DVec3, Vec4};

use super::exr::ExrImage;
use crate::backend::cpu::Cpu;
use crate::reflect::MirrorGBuffer;

/// The mirrors' G-buffer as channels region.V, reflected_albedo.RGB, reflected_normal.XYZ, reflected_position.XYZ,
/// reflected_specular.V, reflected_shininess.V, reflected_mirror.V, distance.Z, count.V, level.V and valid.V.
///
/// Positions are relative to `origin`, which is noted in attributes. Where nothing is seen, every channel but the region
/// is 0.
pub fn mirror_gbuffer(mirror: &MirrorGBuffer<Cpu>, origin: DVec3) -> ExrImage {
    let pixels = mirror.origin.values().len();
    let channel = |value: &dyn Fn(usize) -> f32| -> Vec<f32> {
        (0..pixels)
            .map(|i| {
                if mirror.at(i).is_some() {
                    value(i)
                } else {
                    0.0
                }
            })
            .collect()
    };
    let of = |grid: &[Vec4], pixel: usize| grid.get(pixel).copied().unwrap_or_default();
    let position = |pixel: usize| {
        let distance = of(mirror.surface.values(), pixel).w;
        of(mirror.origin.values(), pixel) + of(mirror.direction.values(), pixel) * distance
    };
    let mut image = ExrImage::new(mirror.size());
    image.add_channels("region", "V", |_| {
        mirror.region.values().iter().map(|&r| r as f32).collect()
    });
    image.add_channels("reflected_albedo", "RGB", |c| {
        channel(&|i| of(mirror.albedo.values(), i)[c])
    });
    image.add_channels("reflected_normal", "XYZ", |c| {
        channel(&|i| of(mirror.surface.values(), i)[c])
    });
    image.add_channels("reflected_position", "XYZ", |c| {
        channel(&|i| position(i)[c])
    });
    image.add_channels("reflected_specular", "V", |_| {
        channel(&|i| of(mirror.material.values(), i).x)
    });
    image.add_channels("reflected_shininess", "V", |_| {
        channel(&|i| of(mirror.material.values(), i).y)
    });
    image.add_channels("reflected_mirror", "V", |_| {
        channel(&|i| of(mirror.albedo.values(), i).w)
    });
    image.add_channels("distance", "Z", |_| {
        channel(&|i| of(mirror.surface.values(), i).w)
    });
    image.add_channels("count", "V", |_| {
        channel(&|i| mirror.count.values().get(i).copied().unwrap_or_default() as f32)
    });
    image.add_channels("level", "V", |_| {
        channel(&|i| mirror.level.values().get(i).copied().unwrap_or_default())
    });
    image.add_channels("valid", "V", |_| channel(&|_| 1.0));
    image.set_origin(origin);
    image
}
