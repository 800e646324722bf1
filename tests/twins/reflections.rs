//! The whole way from a G-buffer to what its mirrors show.

use catoptric::backend::cpu::Cpu;
use catoptric::backend::gpu::{Gpu, GpuOptions};
use catoptric::backend::{Backend, Cloud};
use catoptric::gi::GiSettings;
use catoptric::job::Job;
use catoptric::reflect::sscr::Search;
use catoptric::reflect::{Method, MirrorGBuffer, Reflector};
use catoptric::settings::Settings;
use glam::{UVec2, Vec4};

use super::support::{cloud, gpu, options, pinhole};

/// What the mirror ball of a cloud shows, and the picture with it.
fn reflected<B: Backend>(backend: &mut B, search: Search) -> (MirrorGBuffer<Cpu>, Vec<Vec4>) {
    let mut settings = Settings::default();
    settings.reflect.method = Method::Sscr;
    settings.sscr.search = search;
    let surfels = cloud(40_000, true);
    let points = backend.upload(&surfels).expect("points");
    let cloud = Cloud { points, surfels };
    let (job, size) = (Job::default(), UVec2::new(211, 157));
    let seen = backend
        .splat(&cloud.points, &pinhole(size), &settings.splat, &job)
        .expect("a G-buffer");
    let (mirror, report) = Reflector::default()
        .reflect(backend, &cloud, &seen, 5.0, &settings, &job)
        .expect("a reflection");
    assert!(report.coverage > 0.2, "{report:?}");
    let mut radiance = backend
        .shade(&seen, &[], &GiSettings::default(), &job)
        .expect("radiance");
    backend
        .blend(&mut radiance, &seen, &mirror, None, &job)
        .expect("blended");
    let radiance = backend.read(&radiance).expect("radiance").into_owned();
    (mirror.take(backend).expect("a mirror G-buffer"), radiance)
}

pub(super) fn bands_of_a_reflection_do_not_show() {
    // 256 KiB a binding: 16,384 points or pixels, 10,922 hits.
    let mut banded = Gpu::new(&GpuOptions {
        binding_limit: Some(1 << 18),
        ..options()
    })
    .expect("a device");
    for search in [Search::Interleaved, Search::Guided] {
        let (whole, picture) = reflected(&mut *gpu(), search);
        let (bands, banded_picture) = reflected(&mut banded, search);
        assert_eq!(whole.origin, bands.origin, "{search:?}: origins");
        assert_eq!(whole.direction, bands.direction, "{search:?}: directions");
        assert_eq!(whole.region, bands.region, "{search:?}: regions");
        assert_eq!(whole.count, bands.count, "{search:?}: counts");
        assert_eq!(whole.surface, bands.surface, "{search:?}: surfaces");
        assert_eq!(whole.albedo, bands.albedo, "{search:?}: albedos");
        assert_eq!(whole.material, bands.material, "{search:?}: materials");
        assert_eq!(whole.level, bands.level, "{search:?}: levels");
        assert_eq!(picture, banded_picture, "{search:?}: the picture");
    }
}
