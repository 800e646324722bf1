//! Stage `bounce`: the virtual point lights of the next bounce. From each light's map one texel is drawn by the cosine, and the
//! surfel that it shows receives the light's whole flux; so flux is carried on without bias. On the processor for both
//! backends: one texel a light.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use super::ism::{SURFEL_BITS, Slices, direction_of, ism_distance, texel_of};
use super::mirror_light::Leg;
use super::vpl::{Arrival, Vpl, luminance, radical_inverse};
use crate::cloud::{Surfel, Surfels};
use crate::gbuffer::EMPTY;

/// Rings of texels around an empty one in which what it should show is looked for; beyond, the light leaves the scene.
const RINGS: i32 = 2;

/// What a light's ray meets.
pub(super) enum Met {
    /// A surface that reflects diffusely.
    Surface(Arrival),
    /// The front of a mirror, from which the light goes on.
    Mirror(Leg),
}

/// A unit direction (across, up, along) by the cosine, from two numbers 0 to 1.
pub(super) fn cosine_direction(u: f64, v: f64) -> Vec3 {
    let (sin, cos) = (TAU * v as f32).sin_cos();
    let radius = (u as f32).sqrt();
    let along = (1.0 - u as f32).max(1e-6).sqrt();
    Vec3::new(radius * cos, radius * sin, along)
}

/// A direction across, up and along a light, in the scene's frame.
pub(super) fn world_from_vpl(vpl: &Vpl, d: Vec3) -> Vec3 {
    vpl.right * d.x + vpl.up * d.y + vpl.normal * d.z
}

/// What a texel shows, or the nearest that shows something.
fn key_near(map: &[u32], column: u32, row: u32, side: u32) -> Option<(u32, u32, u32)> {
    let at = |x: i32, y: i32| {
        let inside = x >= 0 && y >= 0 && x < side as i32 && y < side as i32;
        inside
            .then(|| map.get((y * side as i32 + x) as usize).copied())
            .flatten()
            .filter(|&key| key != EMPTY)
            .map(|key| (key, x as u32, y as u32))
    };
    let (x, y) = (column as i32, row as i32);
    (0..=RINGS).find_map(|ring| {
        let square = (-ring..=ring).flat_map(move |dy| (-ring..=ring).map(move |dx| (dx, dy)));
        square
            .filter(|(dx, dy): &(i32, i32)| dx.abs().max(dy.abs()) == ring)
            // Holes have something on both sides; beyond an outline the light leaves.
            .filter(|(dx, dy)| at(x - dx, y - dy).is_some())
            .find_map(|(dx, dy)| at(x + dx, y + dy))
    })
}

/// What a ray of a light meets, by its map; `number` draws the ray. `None` where it leaves the scene.
pub(super) fn meet(
    surfels: &Surfels,
    vpl: &Vpl,
    map: &[u32],
    slices: &Slices,
    albedo_scale: f32,
    number: u64,
) -> Option<Met> {
    let d = cosine_direction(radical_inverse(number, 5), radical_inverse(number, 7));
    let (column, row) = texel_of(d, 1.0, slices.side);
    let (key, x, y) = key_near(map, column, row, slices.side)?;
    // A neighbour's surfel is met in the neighbour's direction.
    let d = if (x, y) == (column, row) {
        d
    } else {
        direction_of(x, y, slices.side)
    };
    let direction = world_from_vpl(vpl, d);
    let index = slices.surfel(vpl.slice, key & ((1 << SURFEL_BITS) - 1));
    let surfel = surfels.get(index as usize)?;
    let shown = ism_distance(key);
    // On the surfel's plane, where the ray does not graze it.
    let plane = surfel.normal.dot(surfel.position - vpl.position) / surfel.normal.dot(direction);
    let distance = if plane > 0.5 * shown && plane < 2.0 * shown {
        plane
    } else {
        shown
    };
    let incident = vpl.flux_towards(direction);
    arrive(
        &surfel,
        vpl.position + direction * distance,
        direction,
        incident,
        albedo_scale,
    )
}

fn arrive(
    surfel: &Surfel,
    position: Vec3,
    direction: Vec3,
    incident: Vec3,
    albedo_scale: f32,
) -> Option<Met> {
    let behind = surfel.normal.dot(direction) > 0.0;
    if surfel.mirror > 0.0 {
        // Backs of mirrors are black.
        return (!behind).then(|| {
            Met::Mirror(Leg::reflected(
                position,
                surfel.normal,
                direction,
                incident * surfel.mirror,
            ))
        });
    }
    Some(Met::Surface(Arrival {
        position,
        normal: if behind {
            -surfel.normal
        } else {
            surfel.normal
        },
        albedo: surfel.albedo * albedo_scale,
        specular: surfel.specular,
        shininess: surfel.shininess,
        spacing: surfel.radius,
        direction,
        incident,
    }))
}

/// Luminance of what an arrival reflects, W.
fn weight(arrival: &Arrival) -> f64 {
    f64::from(luminance(arrival.albedo * arrival.incident)).max(0.0)
}

/// The same of all.
pub(super) fn reflected(arrivals: &[Arrival]) -> f32 {
    arrivals.iter().map(weight).sum::<f64>() as f32
}

/// Lights of what arrived, thinned so that each reflects `share` (luminance, W), without bias: systematic resampling.
/// `area` is that of the whole scene.
pub(super) fn thin(arrivals: &[Arrival], share: f32, area: f32) -> Vec<Vpl> {
    let total: f64 = arrivals.iter().map(weight).sum();
    let count = total / f64::from(share);
    if !(count > 0.0 && count.is_finite()) {
        return Vec::new();
    }
    let stands_for = area / count.max(1.0) as f32;
    let mut vpls = Vec::new();
    let (mut sum, mut next) = (0.0, 0.5);
    for arrival in arrivals {
        let own = weight(arrival) / f64::from(share);
        sum += own;
        while next < sum {
            next += 1.0;
            let mut kept = *arrival;
            kept.incident *= (1.0 / own) as f32;
            vpls.push(Vpl::of(&kept, stands_for));
        }
    }
    vpls
}

/// Area of the surfaces of a cloud: the sum of the squared spacings of its points.
pub(super) fn area(surfels: &Surfels) -> f32 {
    let sum: f64 = (surfels.places.iter())
        .map(|p| f64::from(p.radius) * f64::from(p.radius))
        .sum();
    (sum as f32).min(f32::MAX / PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_flux() {
        let arrival = |i: usize| Arrival {
            position: Vec3::ZERO,
            normal: Vec3::Z,
            albedo: Vec3::splat(0.5),
            specular: 0.0,
            shininess: 0.0,
            spacing: 0.01,
            direction: Vec3::NEG_Z,
            incident: Vec3::splat(0.1 + (i * 37 % 101) as f32 * 0.01),
        };
        let arrivals: Vec<_> = (0..1000).map(arrival).collect();
        let before: f32 = arrivals
            .iter()
            .map(|a| luminance(a.albedo * a.incident))
            .sum();
        let thinned = thin(&arrivals, before / 100.0, 1.0);
        let after: f32 = thinned.iter().map(|v| luminance(v.flux)).sum();
        assert_eq!(thinned.len(), 100, "each stands for a hundredth");
        assert!(
            (after / before - 1.0).abs() < 1e-3,
            "{before} W became {after} W"
        );
    }
}
