//! Stage `vpl`: virtual point lights, drawn from what the lights see in proportion to the flux that it reflects
//! [Keller 1997, "Instant Radiosity"].
//!
//! A texel of solid angle dw = 1 / (f^2 |d|^3), d = (x / f, y / f, 1), receives I dw and reflects rho I dw (watts). Every
//! light stands for an equal share of the reflected flux (its importance). Low-discrepancy numbers through the inverse of the
//! distribution over rows, then columns, so that any run of lights that follow one another covers the lit surface evenly.
//! On the processor for both backends: a few thousand draws.

use std::f32::consts::PI;

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

use super::SpotLight;
use super::mirror_light::Leg;
use crate::backend::cpu::Cpu;
use crate::gbuffer::GBuffer;
use crate::gbuffer::average::Pixel;
use crate::gbuffer::fill::plane_depth;

/// Side of the map from which lights are drawn, texels. Every light is placed within its texel, so the side only bounds
/// how finely the lit surface's colours are told apart.
pub const VPL_MAP_SIDE: u32 = 512;

/// A surface seen flatter than this cosine counts as seen at it, where areas are divided by it.
const MIN_COSINE: f32 = 0.05;

/// A virtual point light: a small piece of surface that reflects what it received. Same layout on the GPU
/// (`shaders/shared/vpl.wgsl`).
///
/// Its radiant intensity in the unit direction w is cos(w) (`flux` / pi + `incident` x `specular` x lobe(w)), W/sr.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Vpl {
    /// Relative to the scene's origin.
    pub position: Vec3,
    /// The area that it stands for, over pi: added to squared distances, it bounds what is near.
    pub softening: f32,
    /// Unit vector, on the side from which it was lit.
    pub normal: Vec3,
    /// Exponent of the specular lobe.
    pub shininess: f32,
    /// Reflected diffusely, W per channel.
    pub flux: Vec3,
    /// Specular reflectance, 0 to 1.
    pub specular: f32,
    /// Received, W per channel.
    pub incident: Vec3,
    /// Local spacing of the surface.
    pub spacing: f32,
    /// Unit vector: where a mirror would send the light.
    pub mirrored: Vec3,
    /// First surfel of the slice of the cloud that its shadow map shows.
    pub slice: u32,
    /// Unit vector across the normal: columns of its shadow map.
    pub right: Vec3,
    /// As the two above; 0.
    pub pad0: u32,
    /// Unit vector across both: rows of its shadow map.
    pub up: Vec3,
    /// As the two above; 0.
    pub pad1: u32,
}

/// A surface where light arrives.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arrival {
    pub(super) position: Vec3,
    /// On the side of the light.
    pub(super) normal: Vec3,
    pub(super) albedo: Vec3,
    pub(super) specular: f32,
    pub(super) shininess: f32,
    pub(super) spacing: f32,
    /// Unit vector in which the light travels.
    pub(super) direction: Vec3,
    /// W per channel.
    pub(super) incident: Vec3,
}

impl Vpl {
    /// The light that a surface becomes; `area` is what it stands for.
    pub(super) fn of(arrival: &Arrival, area: f32) -> Self {
        let Arrival {
            normal, direction, ..
        } = *arrival;
        let right = normal.any_orthonormal_vector();
        Self {
            position: arrival.position,
            softening: area / PI,
            normal,
            shininess: arrival.shininess,
            flux: arrival.albedo * arrival.incident,
            specular: arrival.specular,
            incident: arrival.incident,
            spacing: arrival.spacing,
            mirrored: direction - normal * (2.0 * normal.dot(direction)),
            slice: 0,
            right,
            pad0: 0,
            up: normal.cross(right),
            pad1: 0,
        }
    }

    /// Flux that the diffuse part would have to reflect to be as bright in the unit direction `towards`; W per channel.
    pub(super) fn flux_towards(&self, towards: Vec3) -> Vec3 {
        if self.specular <= 0.0 {
            return self.flux;
        }
        let base = self.mirrored.dot(towards).max(0.0);
        let lobe = base.powf(self.shininess) * (self.shininess + 2.0) / (2.0 * PI);
        self.flux + self.incident * (self.specular * lobe * PI)
    }
}

/// Brightness of a colour to a person: weights of linear sRGB.
pub fn luminance(colour: Vec3) -> f32 {
    0.2126 * colour.x + 0.7152 * colour.y + 0.0722 * colour.z
}

/// What a colour counts where lights are drawn and thinned: its length. Of all weights this leaves the least noise in the three
/// channels together; by luminance, a light of a red wall carries three times the red of a white wall's, and spots what is near.
pub fn importance(colour: Vec3) -> f32 {
    colour.length()
}

/// The numbers below `count` in bit-reversed order: any run of them covers all evenly.
pub(super) fn evenly(count: u32) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count).collect();
    order.sort_by(|a, b| {
        let place = |i: &u32| radical_inverse(u64::from(*i), 2);
        place(a).total_cmp(&place(b))
    });
    order
}

/// Element `index` of the van der Corput sequence in `base`: 0 to 1, exclusive.
pub(super) fn radical_inverse(mut index: u64, base: u64) -> f64 {
    let (mut value, mut scale) = (0.0, 1.0 / base as f64);
    while index > 0 {
        value += (index % base) as f64 * scale;
        index /= base;
        scale /= base as f64;
    }
    value
}

/// What a light sees, texel by texel.
pub struct LitMap {
    /// The light.
    pub light: SpotLight,
    /// What it sees.
    pub gbuffer: GBuffer<Cpu>,
}

/// A texel of a light's map.
struct Texel {
    seen: Pixel,
    /// The ray to its centre, scaled to 1 along the axis.
    direction: Vec3,
    /// What it receives, W per channel.
    incident: Vec3,
}

impl LitMap {
    fn texel(&self, x: i32, y: i32) -> Option<Texel> {
        let seen = self.gbuffer.at(x, y)?;
        let direction = self.gbuffer.direction(x, y);
        let length = direction.length();
        let focal = self.gbuffer.pinhole.focal;
        let solid_angle = 1.0 / (focal * focal * length * length * length);
        let incident =
            self.light.intensity * (self.light.falloff_towards(direction / length) * solid_angle);
        Some(Texel {
            seen,
            direction,
            incident,
        })
    }

    /// Importance of what a texel reflects diffusely, W; mirrors carry no lights.
    fn weight(&self, x: i32, y: i32) -> f64 {
        let Some(texel) = self.texel(x, y).filter(|t| t.seen.albedo.w <= 0.0) else {
            return 0.0;
        };
        let reflected = texel.incident * texel.seen.albedo.truncate();
        f64::from(importance(reflected)).max(0.0)
    }

    /// All that leaves the light, W per channel: the sum of I dw over its map, whatever it meets.
    pub fn power(&self) -> Vec3 {
        let size = self.gbuffer.size().as_ivec2();
        let mut sum = glam::DVec3::ZERO;
        for y in 0..size.y {
            for x in 0..size.x {
                let direction = self.gbuffer.direction(x, y);
                let length = direction.length();
                let focal = self.gbuffer.pinhole.focal;
                let solid_angle = 1.0 / (focal * focal * length * length * length);
                let falloff = self.light.falloff_towards(direction / length);
                sum += (self.light.intensity * (falloff * solid_angle)).as_dvec3();
            }
        }
        sum.as_vec3()
    }

    /// The light at `place` (0 to 1 in both) within a texel that is drawn with a probability of `share`, of `count` lights.
    fn vpl(&self, x: i32, y: i32, place: Vec2, share: f64, count: f64) -> Option<Vpl> {
        let texel = self.texel(x, y)?;
        let Pixel {
            surface,
            albedo,
            material,
        } = texel.seen;
        let pinhole = &self.gbuffer.pinhole;
        let towards = pinhole.direction(Vec2::new(x as f32, y as f32) + place);
        let normal = surface.truncate();
        let depth = plane_depth(normal, texel.direction, surface.w, towards);
        let direction = towards.normalize_or_zero();
        let drawn = (1.0 / (count * share)) as f32;
        let distance_squared = depth * depth * towards.length_squared();
        let length = texel.direction.length();
        let solid_angle = 1.0 / (pinhole.focal * pinhole.focal * length * length * length);
        let cosine = normal.dot(direction).abs().max(MIN_COSINE);
        let arrival = Arrival {
            position: pinhole.eye + towards * depth,
            normal,
            albedo: albedo.truncate(),
            specular: material.x,
            shininess: material.y,
            spacing: material.z,
            direction,
            incident: texel.incident * drawn,
        };
        Some(Vpl::of(
            &arrival,
            solid_angle * distance_squared / cosine * drawn,
        ))
    }
}

/// Where `target` falls in a list of weights that add up to more: the entry, and how far into it (0 to 1).
fn find(weights: impl Iterator<Item = f64>, mut target: f64) -> Option<(usize, f64)> {
    let mut last = None;
    for (i, weight) in weights.enumerate() {
        if weight <= 0.0 {
            continue;
        }
        if target < weight {
            return Some((i, target / weight));
        }
        target -= weight;
        // Rounding may leave a little: it belongs to the last.
        last = Some((i, 0.999_999));
    }
    last
}

/// Draws `count` lights from what all lights see. None where nothing reflects.
pub fn vpls(maps: &[LitMap], count: u32) -> Vec<Vpl> {
    // Rows of all maps, one after the other.
    let rows: Vec<Row<'_>> = maps
        .iter()
        .flat_map(|map| {
            let size = map.gbuffer.size().as_ivec2();
            (0..size.y).map(move |y| {
                let weights: Vec<f64> = (0..size.x).map(|x| map.weight(x, y)).collect();
                let total = weights.iter().sum();
                Row {
                    map,
                    y,
                    weights,
                    total,
                }
            })
        })
        .collect();
    let total: f64 = rows.iter().map(|row| row.total).sum();
    if !(total > 0.0 && total.is_finite()) {
        return Vec::new();
    }
    let n = f64::from(count);
    (1..=u64::from(count))
        .filter_map(|k| {
            let (row, v) = find(rows.iter().map(|r| r.total), radical_inverse(k, 2) * total)?;
            let row = rows.get(row)?;
            let (x, u) = find(
                row.weights.iter().copied(),
                radical_inverse(k, 3) * row.total,
            )?;
            let share = row.weights.get(x)? / total;
            let place = Vec2::new(u as f32, v as f32);
            row.map.vpl(x as i32, row.y, place, share, n)
        })
        .collect()
}

/// A row of a light's map.
struct Row<'a> {
    map: &'a LitMap,
    y: i32,
    /// Importance of what its texels reflect, W.
    weights: Vec<f64>,
    total: f64,
}

/// Mirror texels that send rays on, in each direction one of so many.
const CAUSTIC_STEP: usize = 2;

impl LitMap {
    /// The rays that the mirrors send on of what they receive.
    pub(super) fn mirrored(&self) -> impl Iterator<Item = Leg> + '_ {
        let size = self.gbuffer.size().as_ivec2();
        let texels = (0..size.y)
            .step_by(CAUSTIC_STEP)
            .flat_map(move |y| (0..size.x).step_by(CAUSTIC_STEP).map(move |x| (x, y)));
        texels.filter_map(|(x, y)| {
            let texel = self.texel(x, y)?;
            let Pixel {
                surface,
                albedo,
                material,
            } = texel.seen;
            let stands_for = (CAUSTIC_STEP * CAUSTIC_STEP) as f32;
            let flux = texel.incident * (albedo.w * stands_for);
            if albedo.w <= 0.0 || flux.max_element() <= 0.0 {
                return None;
            }
            let position = self.gbuffer.pinhole.eye + texel.direction * surface.w;
            let direction = texel.direction.normalize_or_zero();
            Some(Leg {
                spacing: material.z,
                ..Leg::reflected(position, surface.truncate(), direction, flux)
            })
        })
    }
}
