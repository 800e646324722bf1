//! Stages of a cancelled job, on both backends.

use catoptric::backend::Backend;
use catoptric::backend::cpu::Cpu;
use catoptric::{Error, Job};

use catoptric::gbuffer::SplatSettings;
use catoptric::gbuffer::disc::PixelRect;
use catoptric::reflect::LabelledMirrors;
use catoptric::reflect::sscr::curvature::Axes;
use catoptric::reflect::sscr::{Region, SscrSettings};
use glam::Vec3;

use super::support::{SIZE, cloud, gpu, pinhole};

pub(super) fn stages_end_on_the_cpu() {
    stages_are_cancelled(&mut Cpu::default());
}

pub(super) fn stages_end_on_the_gpu() {
    stages_are_cancelled(&mut *gpu());
}

fn stages_are_cancelled<B: Backend>(backend: &mut B) {
    let (job, settings) = (Job::default(), SplatSettings::default());
    let points = backend.upload(&cloud(3000, true)).expect("points");
    let mut seen = backend
        .splat(&points, &pinhole(SIZE), &settings, &job)
        .expect("a G-buffer");
    let surface = backend.surface(&seen, &job).expect("mirrors");
    let mut mirror = backend.reflected_rays(&surface, &job).expect("rays");
    // One region: whatever of the picture is a mirror.
    let pixels = SIZE.x * SIZE.y;
    let labels = backend
        .write(SIZE, &vec![1u32; pixels as usize])
        .expect("labels");
    let region = Region {
        bounds: PixelRect {
            x0: 0,
            y0: 0,
            x1: SIZE.x,
            y1: SIZE.y,
        },
        pixels,
        weight: 1.0,
        accumulated_weight: 1.0,
    };
    let mirrors = LabelledMirrors {
        surface: &surface,
        labels: &labels,
        regions: &[region],
        right: Vec3::X,
    };
    let sscr = SscrSettings::default();
    let (hits, _) = backend
        .root_find(&points, &mirrors, &sscr, 5.0, &job)
        .expect("hits");
    let splatting = sscr.splatting(false, &settings, 1, 1);
    let mut radiance = backend
        .shade_mirror(&mirror, &[], &Default::default(), &job)
        .expect("radiance");
    job.cancel();
    let again = backend.splat(&points, &pinhole(SIZE), &settings, &job);
    let map = backend.light_map(&points, &pinhole(SIZE), &settings, &job);
    for (stage, outcome) in [
        ("splat", again.err()),
        ("light_map", map.err()),
        ("fill", backend.fill(&mut seen, &settings, &job).err()),
        ("coverage", backend.coverage(&seen, &job).err()),
        ("smooth", backend.smooth(&mut seen, &settings, &job).err()),
        (
            "shade",
            backend.shade(&seen, &[], &Default::default(), &job).err(),
        ),
        ("edl", backend.edl(&seen, &Default::default(), &job).err()),
        ("surface", backend.surface(&seen, &job).err()),
        (
            "reflected_rays",
            backend.reflected_rays(&surface, &job).err(),
        ),
        (
            "curvature",
            backend
                .curvature(&surface, Axes::Way, &Default::default(), &job)
                .err(),
        ),
        (
            "root_find",
            backend.root_find(&points, &mirrors, &sscr, 5.0, &job).err(),
        ),
        (
            "search_heat",
            backend.search_heat(&points, &mirrors, &sscr, &job).err(),
        ),
        (
            "accumulate",
            backend
                .accumulate(&hits, &points, &mut mirror, &splatting, &job)
                .err(),
        ),
        (
            "mirror_coverage",
            backend.mirror_coverage(&mirror, &job).err(),
        ),
        ("pull_push", backend.pull_push(&mut mirror, 2, &job).err()),
        (
            "shade_mirror",
            backend
                .shade_mirror(&mirror, &[], &Default::default(), &job)
                .err(),
        ),
        (
            "blend",
            backend
                .blend(&mut radiance, &seen, &mirror, None, &job)
                .err(),
        ),
    ] {
        assert!(
            matches!(outcome, Some(Error::Cancelled)),
            "{stage}: {outcome:?}"
        );
    }
    backend
        .splat(&points, &pinhole(SIZE), &settings, &Job::default())
        .expect("the next job is not cancelled");
}
