//! A small cloud, the device, and comparisons.

use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

use bytemuck::Pod;
use catoptric::backend::Backend;
use catoptric::backend::cpu::Cpu;
use catoptric::backend::gpu::{AdapterChoice, Gpu, GpuOptions};
use catoptric::camera::{Camera, Pinhole};
use catoptric::cloud::{Finish, Place, Surfel, Surfels};
use catoptric::gbuffer::{GBuffer, SplatSettings};
use catoptric::gi::SpotLight;
use catoptric::job::Job;
use glam::{DVec3, UVec2, Vec3, Vec4};

/// No multiple of a workgroup's side.
pub(super) const SIZE: UVec2 = UVec2::new(37, 21);

static GPU: LazyLock<Option<Mutex<Gpu>>> =
    LazyLock::new(|| Gpu::new(&options()).ok().map(Mutex::new));

/// The path that every adapter runs: default limits, no features.
pub(super) fn options() -> GpuOptions {
    GpuOptions {
        adapter: AdapterChoice::Any,
        portable: true,
        ..GpuOptions::default()
    }
}

pub(super) fn gpu() -> MutexGuard<'static, Gpu> {
    let gpu = GPU
        .as_ref()
        .expect("CATOPTRIC_GPU=require, but there is no graphics adapter");
    gpu.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Numbers from 0 to 1, the same on every machine.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next()
    }
}

/// A back wall, a floor and a ball before them, of `count` surfels; the ball is a mirror where `mirrors`. A few surfels are
/// glossy, look away, are edge-on, behind the camera, or huge.
pub(super) fn cloud(count: usize, mirrors: bool) -> Arc<Surfels> {
    let mut numbers = Numbers(7);
    let spacing = (12.0 / count as f32).sqrt();
    let (mut places, mut finishes) = (Vec::new(), Vec::new());
    for i in 0..count {
        let (u, v) = (numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0));
        let (mut position, mut normal) = match i % 4 {
            0 | 1 => (Vec3::new(1.5 * u, v, -2.0), Vec3::Z),
            2 => (Vec3::new(1.5 * u, -1.0, v - 1.0), Vec3::Y),
            _ => {
                let (sin, cos) = (u * std::f32::consts::PI).sin_cos();
                let n = Vec3::new((1.0 - v * v).sqrt() * cos, v, (1.0 - v * v).sqrt() * sin);
                (Vec3::new(0.2, -0.3, -1.0) + n * 0.45, n)
            }
        };
        match i % 97 {
            0 => normal = -normal,
            1 => normal = Vec3::X,
            2 => position.z = 5.0,
            _ => {}
        }
        let surfel = Surfel {
            position,
            radius: if i % 101 == 0 { spacing * 6.0 } else { spacing },
            normal,
            albedo: Vec3::new(numbers.next(), 0.6 + 0.2 * u, 0.5 + 0.3 * v),
            mirror: if mirrors && i % 4 == 3 { 0.8 } else { 0.0 },
            specular: if i % 3 == 0 { 0.3 } else { 0.0 },
            shininess: 1.0 + 60.0 * numbers.next(),
        };
        places.push(Place {
            position,
            radius: surfel.radius,
        });
        finishes.push(Finish::pack(&surfel));
    }
    Arc::new(Surfels {
        places,
        finishes,
        source: (0..count as u32).collect(),
        origin: DVec3::ZERO,
    })
}

pub(super) fn pinhole(size: UVec2) -> Pinhole {
    let camera = Camera {
        position: DVec3::new(0.1, 0.2, 1.2),
        target: DVec3::new(0.05, -0.1, -1.0),
        up: DVec3::Y,
        fov_y_degrees: 55.0,
        near: 0.01,
        far: 100.0,
        size,
    };
    camera.pinhole(DVec3::ZERO).expect("a sound camera")
}

pub(super) fn spot() -> SpotLight {
    SpotLight {
        position: Vec3::new(-0.6, 0.9, 0.6),
        axis: Vec3::new(0.5, -0.8, -1.2).normalize(),
        intensity: Vec3::new(6.0, 5.0, 4.0),
        inner_angle: 25f32.to_radians(),
        outer_angle: 35f32.to_radians(),
        pyramid: false,
    }
}

/// What differs between two lists by more than `tolerance` (of the larger, or 1); `None` where nothing does.
pub(super) fn difference(got: &[Vec4], expected: &[Vec4], tolerance: f32) -> Option<String> {
    assert_eq!(got.len(), expected.len(), "as many values");
    // What is no number is off, too.
    let off = |a: Vec4, b: Vec4| {
        let limit = tolerance * b.abs().max_element().max(1.0);
        !(a - b).abs().cmple(Vec4::splat(limit)).all()
    };
    let wrong: Vec<_> = (0..got.len())
        .filter(|&i| off(got[i], expected[i]))
        .collect();
    let first = *wrong.first()?;
    let (x, y) = (first % SIZE.x as usize, first / SIZE.x as usize);
    Some(format!(
        "{} values differ, the first at {x}, {y}: got {}, expected {}",
        wrong.len(),
        got[first],
        expected[first]
    ))
}

/// Asserts that all values agree.
pub(super) fn assert_agree(what: &str, got: &[Vec4], expected: &[Vec4], tolerance: f32) {
    if let Some(text) = difference(got, expected, tolerance) {
        panic!("{what}: {text}");
    }
}

pub(super) fn bring<T: Pod>(gpu: &mut Gpu, size: UVec2, values: &[T]) -> <Gpu as Backend>::Grid<T> {
    gpu.write(size, values).expect("a small grid")
}

/// A CPU's G-buffer on the device.
pub(super) fn bring_gbuffer(gpu: &mut Gpu, g: &GBuffer<Cpu>) -> GBuffer<Gpu> {
    let size = g.size();
    GBuffer {
        pinhole: g.pinhole,
        surface: bring(gpu, size, g.surface.values()),
        albedo: bring(gpu, size, g.albedo.values()),
        material: bring(gpu, size, g.material.values()),
    }
}

pub(super) fn assert_gbuffers_agree(
    gpu: &mut Gpu,
    got: &GBuffer<Gpu>,
    expected: &GBuffer<Cpu>,
    tolerance: f32,
) {
    let read = |gpu: &mut Gpu, grid| gpu.read::<Vec4>(grid).expect("a grid").into_owned();
    assert_agree(
        "surface",
        &read(gpu, &got.surface),
        expected.surface.values(),
        tolerance,
    );
    assert_agree(
        "albedo",
        &read(gpu, &got.albedo),
        expected.albedo.values(),
        tolerance,
    );
    assert_agree(
        "material",
        &read(gpu, &got.material),
        expected.material.values(),
        tolerance,
    );
}

pub(super) fn seen_by_cpu(mirrors: bool) -> GBuffer<Cpu> {
    let mut cpu = Cpu::default();
    let points = cpu.upload(&cloud(3000, mirrors)).expect("points");
    cpu.splat(
        &points,
        &pinhole(SIZE),
        &SplatSettings::default(),
        &Job::default(),
    )
    .expect("a G-buffer")
}
