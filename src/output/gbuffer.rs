//! The camera G-buffer as an EXR file.

use glam::{DVec3, Vec2, Vec4};
use rayon::prelude::*;

use super::exr::ExrImage;
use crate::backend::cpu::Cpu;
use crate::gbuffer::GBuffer;
use crate::grid::Grid;

/// The camera's G-buffer as channels albedo.RGB, normal.XYZ, position.XYZ, depth.Z, specular.V, shininess.V, mirror.V
/// and valid.V.
///
/// Positions are relative to `origin`, which is noted in attributes; normals and positions are in the scene's frame.
/// Where nothing is seen, every channel is 0.
pub fn camera_gbuffer(gbuffer: &GBuffer<Cpu>, origin: DVec3) -> ExrImage {
    let width = gbuffer.surface.width().max(1);
    let at =
        |grid: &Grid<Vec4>, pixel: usize| grid.values().get(pixel).copied().unwrap_or_default();
    let channel = |value: &(dyn Fn(usize) -> f32 + Sync)| -> Vec<f32> {
        let pixels = (0..gbuffer.surface.values().len()).into_par_iter();
        let valid = |pixel| at(&gbuffer.material, pixel).w > 0.0;
        pixels
            .map(|pixel| if valid(pixel) { value(pixel) } else { 0.0 })
            .collect()
    };
    let position = |pixel: usize| {
        let centre = Vec2::new((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5);
        gbuffer
            .pinhole
            .world_from_pixel(centre, at(&gbuffer.surface, pixel).w)
    };

    let mut image = ExrImage::new(gbuffer.surface.size());
    image.add_channels("albedo", "RGB", |i| {
        channel(&|pixel| at(&gbuffer.albedo, pixel)[i])
    });
    image.add_channels("normal", "XYZ", |i| {
        channel(&|pixel| at(&gbuffer.surface, pixel)[i])
    });
    image.add_channels("position", "XYZ", |i| channel(&|pixel| position(pixel)[i]));
    image.add_channels("depth", "Z", |_| {
        channel(&|pixel| at(&gbuffer.surface, pixel).w)
    });
    image.add_channels("specular", "V", |_| {
        channel(&|pixel| at(&gbuffer.material, pixel).x)
    });
    image.add_channels("shininess", "V", |_| {
        channel(&|pixel| at(&gbuffer.material, pixel).y)
    });
    image.add_channels("mirror", "V", |_| {
        channel(&|pixel| at(&gbuffer.albedo, pixel).w)
    });
    image.add_channels("valid", "V", |_| channel(&|_| 1.0));
    image.set_origin(origin);
    image
}

#[cfg(test)]
mod tests {
    use glam::{UVec2, Vec3};

    use super::*;
    use crate::camera::Camera;

    /// A G-buffer of 3 x 2 pixels of which the last is empty, but for leftovers of its neighbours.
    fn image() -> ExrImage {
        let size = UVec2::new(3, 2);
        let origin = DVec3::new(500_000.0, 0.0, -20.0);
        let camera = Camera {
            position: origin + DVec3::new(0.0, 0.0, 0.9),
            target: origin,
            up: DVec3::Y,
            fov_y_degrees: 60.0,
            near: 0.05,
            far: 10.0,
            size,
        };
        let mut material = Grid::new(size, Vec4::new(0.25, 30.0, 0.01, 1.0));
        material.values_mut()[5].w = 0.0;
        let gbuffer = GBuffer {
            pinhole: camera.pinhole(origin).expect("a sound camera"),
            surface: Grid::new(size, Vec4::new(0.0, 0.6, 0.8, 2.0)),
            albedo: Grid::new(size, Vec4::new(0.1, 0.2, 0.3, 0.4)),
            material,
        };
        camera_gbuffer(&gbuffer, origin)
    }

    #[test]
    fn the_channels_are_those_that_readers_know() {
        let expected = "albedo.B albedo.G albedo.R depth.Z mirror.V normal.X normal.Y normal.Z position.X position.Y \
                        position.Z shininess.V specular.V valid.V";
        let image = image();
        assert_eq!(
            image
                .channels
                .keys()
                .map(String::as_str)
                .collect::<Vec<_>>()
                .join(" "),
            expected
        );
        assert_eq!(
            image.numbers.values().copied().collect::<Vec<_>>(),
            [500_000.0, 0.0, -20.0]
        );
    }

    #[test]
    fn values_are_in_their_channels() {
        let image = image();
        let first = |name: &str| image.channels[name][0];
        assert_eq!(
            ["albedo.R", "albedo.G", "albedo.B", "mirror.V"].map(first),
            [0.1, 0.2, 0.3, 0.4]
        );
        assert_eq!(
            ["normal.X", "normal.Y", "normal.Z", "depth.Z"].map(first),
            [0.0, 0.6, 0.8, 2.0]
        );
        assert_eq!(
            ["specular.V", "shininess.V", "valid.V"].map(first),
            [0.25, 30.0, 1.0]
        );
    }

    #[test]
    fn positions_lie_on_the_pixels_rays_at_their_depths() {
        let image = image();
        let slope = 30f32.to_radians().tan();
        for (p, (x, y)) in [(0, (-1.0, 0.5)), (1, (0.0, 0.5)), (3, (-1.0, -0.5))] {
            let expected = Vec3::new(x * 2.0 * slope, y * 2.0 * slope, 0.9 - 2.0);
            let got =
                Vec3::from(["X", "Y", "Z"].map(|c| image.channels[&format!("position.{c}")][p]));
            assert!(
                (got - expected).length() < 1e-5,
                "pixel {p}: got {got}, expected {expected}"
            );
        }
    }

    #[test]
    fn what_is_empty_is_0_in_every_channel() {
        for (name, values) in image().channels {
            assert_eq!(values[5], 0.0, "{name}");
        }
    }
}
