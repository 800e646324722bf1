//! The mirrors' kernels against their CPU twins.

use catoptric::backend::Backend;
use catoptric::backend::cpu::Cpu;
use catoptric::backend::gpu::{Gpu, GpuOptions};
use catoptric::camera::Pinhole;
use catoptric::gbuffer::GBuffer;
use catoptric::grid::Grid;
use catoptric::job::Job;
use catoptric::reflect::sscr::curvature::{Axes, LhcSettings};
use catoptric::reflect::{Eye, MirrorGBuffer, Surface};
use glam::Vec4;

use super::mirror_splats;
use super::support::{
    assert_agree, bring, bring_gbuffer, difference, gpu, options, pinhole, seen_by_cpu,
};

/// The mirror ball of the small cloud, and its picture's pinhole.
fn ball() -> (Surface<Cpu>, Pinhole) {
    let seen = seen_by_cpu(true);
    let surface = Surface::of(&seen);
    assert!(surface.pixels() > 70, "{} mirror pixels", surface.pixels());
    (surface, seen.pinhole)
}

/// The same, seen from a point of its own in every pixel.
pub(super) fn from_many_eyes(surface: Surface<Cpu>) -> Surface<Cpu> {
    let mut eyes = surface.point.clone();
    for (i, eye) in eyes.values_mut().iter_mut().enumerate() {
        *eye += Vec4::new(0.1, 0.2 + 0.001 * i as f32, 1.5, 0.0);
    }
    Surface {
        eye: Eye::PerPixel(eyes),
        ..surface
    }
}

/// A CPU's mirrors on the device.
pub(super) fn bring_surface(gpu: &mut Gpu, surface: &Surface<Cpu>) -> Surface<Gpu> {
    let size = surface.size;
    Surface {
        size,
        point: bring(gpu, size, surface.point.values()),
        normal: bring(gpu, size, surface.normal.values()),
        eye: match &surface.eye {
            Eye::Point(eye) => Eye::Point(*eye),
            Eye::PerPixel(eyes) => Eye::PerPixel(bring(gpu, size, eyes.values())),
        },
    }
}

/// A CPU's mirror G-buffer on the device.
pub(super) fn bring_mirror(gpu: &mut Gpu, mirror: &MirrorGBuffer<Cpu>) -> MirrorGBuffer<Gpu> {
    let size = mirror.size();
    MirrorGBuffer {
        origin: bring(gpu, size, mirror.origin.values()),
        direction: bring(gpu, size, mirror.direction.values()),
        surface: bring(gpu, size, mirror.surface.values()),
        albedo: bring(gpu, size, mirror.albedo.values()),
        material: bring(gpu, size, mirror.material.values()),
        region: bring(gpu, size, mirror.region.values()),
        count: bring(gpu, size, mirror.count.values()),
        level: bring(gpu, size, mirror.level.values()),
    }
}

/// Pixels that differ in anything, vectors by more than `tolerance` (of the larger, or 1).
fn apart(got: &MirrorGBuffer<Cpu>, expected: &MirrorGBuffer<Cpu>, tolerance: f32) -> Vec<usize> {
    let vectors = |m: &MirrorGBuffer<Cpu>, i: usize| {
        [&m.origin, &m.direction, &m.surface, &m.albedo, &m.material].map(|g| g.values()[i])
    };
    let rest = |m: &MirrorGBuffer<Cpu>, i: usize| {
        let level = m.level.values()[i].to_bits();
        (m.region.values()[i], m.count.values()[i], level)
    };
    let same = |i: usize| {
        let pairs = vectors(got, i).into_iter().zip(vectors(expected, i));
        let mut near = pairs.map(|(a, b)| difference(&[a], &[b], tolerance).is_none());
        near.all(|near| near) && rest(got, i) == rest(expected, i)
    };
    (0..expected.origin.values().len())
        .filter(|&i| !same(i))
        .collect()
}

/// Asserts that two mirror G-buffers agree; on a graphics card, which may round otherwise, in all but a few pixels.
pub(super) fn assert_mirrors_agree(
    gpu: &mut Gpu,
    got: MirrorGBuffer<Gpu>,
    expected: &MirrorGBuffer<Cpu>,
    tolerance: f32,
) {
    let got = got.take(gpu).expect("a mirror G-buffer");
    let wrong = apart(&got, expected, tolerance);
    let allowed = if gpu.device().is_software() {
        0
    } else {
        expected.origin.values().len() / 50
    };
    if wrong.len() > allowed {
        let i = wrong[0];
        panic!(
            "{} pixels differ, such as {i}: got {:?} of {} points, expected {:?} of {}",
            wrong.len(),
            got.at(i),
            got.count.values()[i],
            expected.at(i),
            expected.count.values()[i],
        );
    }
}

pub(super) fn one_changed_pixel_of_a_mirror_is_noticed() {
    let expected = mirror_splats::shown();
    assert!(apart(&expected, &expected, 0.0).is_empty(), "it is itself");
    for change in [
        |m: &mut MirrorGBuffer<Cpu>| m.albedo.values_mut()[7].y += 1e-3,
        |m: &mut MirrorGBuffer<Cpu>| m.surface.values_mut()[7].w = f32::NAN,
        |m: &mut MirrorGBuffer<Cpu>| m.count.values_mut()[7] += 1,
        |m: &mut MirrorGBuffer<Cpu>| m.level.values_mut()[7] += 1.0,
    ] {
        let mut changed = mirror_splats::shown();
        change(&mut changed);
        assert_eq!(apart(&changed, &expected, 2e-5), [7], "one pixel");
    }
}

pub(super) fn surfaces_agree() {
    let gpu = &mut gpu();
    let seen = seen_by_cpu(true);
    let expected = Surface::of(&seen);
    let there = bring_gbuffer(gpu, &seen);
    let got = gpu.surface(&there, &Job::default()).expect("mirrors");
    let got = got.take(&mut **gpu).expect("mirrors");
    assert!(matches!(got.eye, Eye::Point(eye) if eye == seen.pinhole.eye));
    for (what, got, expected) in [
        ("point", &got.point, &expected.point),
        ("normal", &got.normal, &expected.normal),
    ] {
        assert_agree(what, got.values(), expected.values(), 1e-6);
    }
}

pub(super) fn reflected_rays_agree_from_one_eye_and_from_many() {
    let gpu = &mut gpu();
    let mut many = Vec::new();
    for surface in [ball().0, from_many_eyes(ball().0)] {
        let expected = MirrorGBuffer::of(&surface);
        let there = bring_surface(gpu, &surface);
        let got = gpu
            .reflected_rays(&there, &Job::default())
            .expect("the rays");
        assert_mirrors_agree(gpu, got, &expected, 1e-6);
        many.push(expected);
    }
    let moved = difference(many[0].direction.values(), many[1].direction.values(), 1e-2);
    assert!(moved.is_some(), "other eyes see other things");
}

/// Bytes of two curvature maps that differ.
fn differing(a: &[u8], b: &[u8]) -> usize {
    assert_eq!(a.len(), b.len(), "as many bytes");
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

pub(super) fn curvatures_are_equal_to_the_last_byte() {
    let mut banded = Gpu::new(&GpuOptions {
        binding_limit: Some(1 << 13),
        ..options()
    })
    .expect("a device");
    let gpu = &mut gpu();
    let (surface, pinhole) = ball();
    for axes in [Axes::from(&pinhole), Axes::Way] {
        let (settings, job) = (LhcSettings::default(), Job::default());
        let expected = Cpu::default()
            .curvature(&surface, axes, &settings, &job)
            .expect("bytes")
            .into_vec();
        let kinds: std::collections::BTreeSet<_> = expected.iter().copied().collect();
        assert!(kinds.len() > 4, "there is something to tell: {kinds:?}");
        for gpu in [&mut **gpu, &mut banded] {
            let there = bring_surface(gpu, &surface);
            let got = gpu.curvature(&there, axes, &settings, &job).expect("bytes");
            let got = gpu.read(&got).expect("bytes").into_owned();
            // A graphics card may round a bend about the threshold to the other side.
            let allowed = if gpu.device().is_software() {
                0
            } else {
                expected.len() / 100
            };
            let wrong = differing(&got, &expected);
            assert!(wrong <= allowed, "{axes:?}: {wrong} bytes differ");
        }
        let mut flipped = expected.clone();
        flipped[400] ^= 1;
        assert_eq!(
            differing(&flipped, &expected),
            1,
            "a flipped bit is noticed"
        );
    }
}

pub(super) fn blending_agrees_with_light_and_without() {
    let gpu = &mut gpu();
    let shown = mirror_splats::shown();
    let size = shown.size();
    let mut gbuffer = GBuffer::<Cpu>::empty(pinhole(size));
    for (i, own) in gbuffer.albedo.values_mut().iter_mut().enumerate() {
        let reflectance = if shown.origin.values()[i].w > 0.0 {
            0.5 + 0.5 * (i % 7) as f32 / 6.0
        } else {
            0.0
        };
        *own = Vec4::new(0.2, 0.3, 0.4, reflectance);
    }
    let own = Grid::new(size, Vec4::new(0.1, 0.2, 0.05, 1.0));
    let there = (bring_gbuffer(gpu, &gbuffer), bring_mirror(gpu, &shown));
    let lit = Grid::new(size, Vec4::new(2.0, 1.0, 0.5, 1.0));
    let lit_there = bring(gpu, size, lit.values());
    let mut results = Vec::new();
    for light in [true, false] {
        let mut expected = own.clone();
        let mut got = bring(gpu, size, own.values());
        let job = Job::default();
        Cpu::default()
            .blend(&mut expected, &gbuffer, &shown, light.then_some(&lit), &job)
            .expect("blended");
        gpu.blend(
            &mut got,
            &there.0,
            &there.1,
            light.then_some(&lit_there),
            &job,
        )
        .expect("blended");
        let got = gpu.read(&got).expect("radiance").into_owned();
        assert_agree("radiance", &got, expected.values(), 1e-6);
        mirror_splats::assert_differs(&got, own.values());
        results.push(got);
    }
    mirror_splats::assert_differs(&results[0], &results[1]);
}
