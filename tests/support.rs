//! What the integration tests share.

use std::path::PathBuf;
use std::sync::LazyLock;

use catoptric::backend::gpu::{AdapterChoice, Gpu, GpuOptions};
use catoptric::camera::Camera;
use catoptric::gbuffer::{Coverage, GBuffer};
use catoptric::grid::Grid;
use catoptric::renderer::Products;
use glam::{DVec3, UVec2, Vec4};
use libtest_mimic::Trial;

/// A test that holds unless `check` panics.
pub(crate) fn claim(name: &'static str, check: fn()) -> Trial {
    Trial::test(name, move || {
        check();
        Ok(())
    })
}

/// The folder that an environment variable names, where it is set.
pub(crate) fn folder(variable: &str) -> Option<PathBuf> {
    std::env::var_os(variable).map(PathBuf::from)
}

static ANY_ADAPTER: LazyLock<bool> = LazyLock::new(|| {
    let options = GpuOptions {
        adapter: AdapterChoice::Any,
        ..GpuOptions::default()
    };
    Gpu::new(&options).is_ok()
});

/// Whether GPU tests are to be shown as ignored: there is no adapter, and nobody requires one (CATOPTRIC_GPU=require).
pub(crate) fn gpu_is_missing() -> bool {
    !*ANY_ADAPTER && std::env::var("CATOPTRIC_GPU").as_deref() != Ok("require")
}

/// What a rendering gives where nothing is seen.
pub(crate) fn empty_products(size: UVec2) -> Products {
    let camera = Camera {
        position: DVec3::ZERO,
        target: DVec3::NEG_Z,
        up: DVec3::Y,
        fov_y_degrees: 60.0,
        near: 0.1,
        far: 10.0,
        size,
    };
    let pinhole = camera.pinhole(DVec3::ZERO).expect("a sound camera");
    Products {
        gbuffer: GBuffer::empty(pinhole),
        coverage: Coverage {
            pixels: u64::from(size.x * size.y),
            ..Coverage::default()
        },
        radiance: Grid::new(size, Vec4::ZERO),
        mirror: None,
        bounces: Vec::new(),
        search_heat: None,
        virtual_lights: None,
        passes: Vec::new(),
        wall_ms: 0.0,
    }
}
