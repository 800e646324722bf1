//! Stage `bounce`: the virtual point lights of the next bounce. From each light's map one texel is drawn by the cosine, and the
//! surfel that it shows receives the light's whole flux; so flux is carried on without bias. On the processor for both
//! backends: one texel a light.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use super::ism::{DISC, SURFEL_BITS, Slices, direction_of, ism_distance, texel_of};
use super::mirror_light::Leg;
use super::vpl::{Arrival, Vpl, evenly, importance, radical_inverse};
use crate::cloud::{Surfel, Surfels};
use crate::gbuffer::EMPTY;

/// Discs by which an empty texel is a hole are as much wider: random points then leave 2 of 1000 rays to pass, and outlines
/// grow by 0.7 of a slice's spacing. Beyond, the light leaves the scene.
const WIDER: f32 = 2.0;

/// Rings of texels around an empty one in which such discs are looked for.
const RINGS: i32 = 12;

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

/// A virtual light and its map.
#[derive(Clone, Copy)]
pub(super) struct Mapped<'a> {
    pub(super) surfels: &'a Surfels,
    pub(super) vpl: &'a Vpl,
    pub(super) map: &'a [u32],
    pub(super) slices: &'a Slices,
}

/// What a texel shows.
struct Shown {
    surfel: Surfel,
    /// From the light.
    distance: f32,
    column: i32,
    row: i32,
}

/// Steps to all texels of a ring.
fn ring(reach: i32) -> impl Iterator<Item = (i32, i32)> {
    let square = (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| (dx, dy)));
    square.filter(move |(dx, dy)| dx.abs().max(dy.abs()) == reach)
}

impl Mapped<'_> {
    fn shown(&self, column: i32, row: i32) -> Option<Shown> {
        let side = self.slices.side as i32;
        if column < 0 || row < 0 || column >= side || row >= side {
            return None;
        }
        let key = self.map.get((row * side + column) as usize).copied();
        let key = key.filter(|&key| key != EMPTY)?;
        let index = (self.slices).surfel(self.vpl.slice, key & ((1 << SURFEL_BITS) - 1));
        Some(Shown {
            surfel: self.surfels.get(index as usize)?,
            distance: ism_distance(key),
            column,
            row,
        })
    }

    /// Whether the ray in the unit direction `towards` meets a surfel's disc when it is wider.
    fn meets_wider(&self, surfel: &Surfel, towards: Vec3) -> bool {
        let centre = surfel.position - self.vpl.position;
        let t = surfel.normal.dot(centre) / surfel.normal.dot(towards);
        let half = WIDER * DISC * self.slices.thinning * surfel.radius;
        t > 0.0 && (towards * t - centre).length_squared() <= half * half
    }

    /// What the map shows in the direction `towards`, which falls on a texel; holes are closed by what is around.
    fn seen(&self, towards: Vec3, column: i32, row: i32) -> Option<Shown> {
        self.shown(column, row).or_else(|| {
            (1..=RINGS)
                .flat_map(ring)
                .filter_map(|(dx, dy)| self.shown(column + dx, row + dy))
                .find(|shown| self.meets_wider(&shown.surfel, towards))
        })
    }

    /// What a ray of the light meets; `number` draws the ray. `None` where it leaves the scene.
    pub(super) fn meet(&self, number: u64, albedo_scale: f32) -> Option<Met> {
        let (vpl, side) = (self.vpl, self.slices.side);
        let d = cosine_direction(radical_inverse(number, 5), radical_inverse(number, 7));
        let (column, row) = texel_of(d, 1.0, side);
        let direction = world_from_vpl(vpl, d);
        let shown = self.seen(direction, column as i32, row as i32)?;
        let Shown {
            surfel, distance, ..
        } = shown;
        let on_plane = |towards: Vec3| {
            let plane = surfel.normal.dot(surfel.position - vpl.position);
            let plane = plane / surfel.normal.dot(towards);
            (plane > 0.5 * distance && plane < 2.0 * distance).then_some(plane)
        };
        // On the surfel's plane; where the ray grazes it, in the direction of the texel that shows it.
        let (direction, distance) = on_plane(direction).map_or_else(
            || {
                let d = direction_of(shown.column as u32, shown.row as u32, side);
                (world_from_vpl(vpl, d), distance)
            },
            |plane| (direction, plane),
        );
        arrive(
            &surfel,
            vpl.position + direction * distance,
            direction,
            vpl.flux_towards(direction),
            albedo_scale,
        )
    }
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

/// Importance of what an arrival reflects, W.
fn weight(arrival: &Arrival) -> f64 {
    f64::from(importance(arrival.albedo * arrival.incident)).max(0.0)
}

/// The same of all.
pub(super) fn reflected(arrivals: &[Arrival]) -> f32 {
    arrivals.iter().map(weight).sum::<f64>() as f32
}

/// Bits of a coordinate along the curve on which arrivals are sorted.
const CURVE_BITS: u32 = 10;

/// The arrivals along a curve through all places [Morton 1966], so that those that follow one another are neighbours.
fn along_a_curve(arrivals: &[Arrival]) -> Vec<&Arrival> {
    let positions = || arrivals.iter().map(|a| a.position);
    let corner = positions().fold(Vec3::INFINITY, Vec3::min);
    let size = positions().fold(Vec3::NEG_INFINITY, Vec3::max) - corner;
    let scale = ((1 << CURVE_BITS) - 1) as f32 / size.max_element().max(f32::MIN_POSITIVE);
    let place = |arrival: &&Arrival| {
        let cell = ((arrival.position - corner) * scale).as_uvec3();
        (0..CURVE_BITS).fold(0u32, |place, bit| {
            let of = |v: u32, axis: u32| (v >> bit & 1) << (3 * bit + axis);
            place | of(cell.x, 0) | of(cell.y, 1) | of(cell.z, 2)
        })
    };
    let mut sorted: Vec<&Arrival> = arrivals.iter().collect();
    sorted.sort_by_cached_key(place);
    sorted
}

/// Lights of what arrived, thinned so that each reflects `share` (importance, W), without bias: systematic resampling along a
/// curve through all places, so that the lights lie as the light does. Any run of them covers all places.
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
    for arrival in along_a_curve(arrivals) {
        let own = weight(arrival) / f64::from(share);
        sum += own;
        while next < sum {
            next += 1.0;
            let mut kept = *arrival;
            kept.incident *= (1.0 / own) as f32;
            vpls.push(Vpl::of(&kept, stands_for));
        }
    }
    evenly(vpls.len() as u32)
        .into_iter()
        .filter_map(|i| vpls.get(i as usize).copied())
        .collect()
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
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;
    use crate::cloud::{Finish, Place};
    use crate::gi::ism::ism;
    use crate::job::Job;

    fn arrival(position: Vec3, normal: Vec3) -> Arrival {
        Arrival {
            position,
            normal,
            albedo: Vec3::splat(0.5),
            specular: 0.0,
            shininess: 0.0,
            spacing: 0.01,
            direction: -normal,
            incident: Vec3::ONE,
        }
    }

    #[test]
    fn thinning_keeps_the_flux() {
        let arrival = |i: usize| Arrival {
            incident: Vec3::splat(0.1 + (i * 37 % 101) as f32 * 0.01),
            ..arrival(Vec3::splat((i * 61 % 127) as f32), Vec3::Z)
        };
        let arrivals: Vec<_> = (0..1000).map(arrival).collect();
        let before = reflected(&arrivals);
        let thinned = thin(&arrivals, before / 100.0, 1.0);
        let after: f32 = thinned.iter().map(|v| importance(v.flux)).sum();
        assert_eq!(thinned.len(), 100, "each stands for a hundredth");
        assert!(
            (after / before - 1.0).abs() < 1e-3,
            "{before} W became {after} W"
        );
    }

    #[test]
    fn lights_lie_as_the_light_does() {
        // Random places on a line; any eight lights that follow one another have one in each eighth.
        let place = |i: u64| Vec3::X * (i * 7919 % 4096) as f32 / 4096.0;
        let arrivals: Vec<_> = (0..4096).map(|i| arrival(place(i), Vec3::Z)).collect();
        let lights = thin(&arrivals, reflected(&arrivals) / 64.0, 1.0);
        for run in lights.chunks(8) {
            let mut eighths: Vec<_> = run.iter().map(|v| (v.position.x * 8.0) as u32).collect();
            eighths.sort_unstable();
            assert_eq!(eighths, (0..8).collect::<Vec<_>>(), "of {run:?}");
        }
    }

    /// A box from -1 to 1 of random points; without its face at x = 1 where it is open.
    fn room(open: bool) -> Arc<Surfels> {
        let points = 60_000u64;
        let spacing = (24.0 / points as f32).sqrt();
        let (mut places, mut finishes) = (Vec::new(), Vec::new());
        for i in 1..=points {
            let number = |base| radical_inverse(i, base) as f32 * 2.0 - 1.0;
            // Not in order: neighbours in the list are of all faces.
            let (axis, sign) = (i * 7 % 3, if i * 7 / 3 % 2 == 0 { 1.0 } else { -1.0 });
            if open && axis == 0 && sign > 0.0 {
                continue;
            }
            let (u, v) = (number(5), number(11));
            let (position, normal) = match axis {
                0 => (Vec3::new(sign, u, v), Vec3::NEG_X),
                1 => (Vec3::new(u, sign, v), Vec3::NEG_Y),
                _ => (Vec3::new(u, v, sign), Vec3::NEG_Z),
            };
            places.push(Place {
                position,
                radius: spacing,
            });
            finishes.push(Finish::pack(&Surfel {
                position,
                radius: spacing,
                normal: normal * sign,
                albedo: Vec3::splat(0.5),
                mirror: 0.0,
                specular: 0.0,
                shininess: 0.0,
            }));
        }
        Arc::new(Surfels {
            source: (0..places.len() as u32).collect(),
            places,
            finishes,
            origin: DVec3::ZERO,
        })
    }

    const RAYS: u64 = 4000;

    /// Share of a light's rays that leave a room.
    fn leaving(surfels: &Surfels, position: Vec3) -> f64 {
        let slices = Slices::of(surfels.len(), 64, 4000);
        let vpl = Vpl::of(&arrival(position, Vec3::Y), 1.0);
        let maps = ism(surfels, &[vpl], slices, &Job::default()).expect("a map");
        let mapped = Mapped {
            surfels,
            vpl: &vpl,
            map: maps.keys.values(),
            slices: &slices,
        };
        let gone = (0..RAYS).filter(|&ray| mapped.meet(ray, 1.0).is_none());
        gone.count() as f64 / RAYS as f64
    }

    /// The same on paper: those that pass the face at x = 1.
    fn passing(position: Vec3) -> f64 {
        let vpl = Vpl::of(&arrival(position, Vec3::Y), 1.0);
        let pass = |ray: &u64| {
            let d = cosine_direction(radical_inverse(*ray, 5), radical_inverse(*ray, 7));
            let d = world_from_vpl(&vpl, d);
            let far = (d.signum() - position) / d;
            d.x > 0.0 && far.x <= far.y && far.x <= far.z
        };
        (0..RAYS).filter(pass).count() as f64 / RAYS as f64
    }

    #[test]
    fn no_light_leaves_a_closed_room_and_what_meets_its_opening_does() {
        let (closed, open) = (room(false), room(true));
        for position in [
            Vec3::new(0.0, -1.0, 0.0),
            Vec3::new(-0.97, -1.0, 0.2),
            Vec3::new(0.9, -1.0, 0.0),
            Vec3::new(-0.98, -1.0, 0.97),
        ] {
            let lost = leaving(&closed, position);
            let (gone, paper) = (leaving(&open, position), passing(position));
            println!("at {position}: {lost} lost, {gone} leave, {paper} on paper");
            assert!(lost < 0.005, "at {position} {lost} of the light is lost");
            assert!(
                (gone - paper).abs() < 0.03,
                "at {position} {gone} of the light leaves, on paper {paper}"
            );
        }
    }
}
