//! Pass `shade`: direct light on a G-buffer. CPU twin of `shaders/shade.wgsl`.
//!
//! Radiance = (albedo / pi + specular (s + 2) / (2 pi) cos^s) times irradiance: Lambert and the normalised Phong lobe
//! [Lafortune and Willems 1994]. A spot's irradiance is intensity times falloff times cosine over squared distance,
//! where its map sees the point.

use std::f32::consts::PI;

use glam::{Vec2, Vec3, Vec4};
use rayon::prelude::*;

use super::GiSettings;
use crate::backend::cpu::Cpu;
use crate::backend::{LightMap, LitBy};
use crate::error::Result;
use crate::gbuffer::average::Pixel;
use crate::gbuffer::{GBuffer, column_row, depth_from_key};
use crate::grid::Grid;
use crate::job::Job;
use crate::reflect::MirrorGBuffer;

/// Receivers that the light meets at a flatter angle keep their own depth in all texels (0.9 degrees).
pub const RECEIVER_COSINE: f32 = 0.015;

/// What receives light in a pixel.
#[derive(Debug, Clone, Copy)]
struct Receiver {
    position: Vec3,
    normal: Vec3,
    /// Unit vector towards the eye.
    view: Vec3,
    seen: Pixel,
}

/// A light's share that reaches a point, 0 to 1: bilinear over the four nearest texels, each compared with the receiver's
/// own plane at that texel, so that no bias against self-shadowing is needed. Empty texels are lit.
fn visibility(receiver: &Receiver, map: &LightMap<Cpu>, bias: f32) -> f32 {
    let LightMap { pinhole, keys } = map;
    let view = pinhole.view_from_world(receiver.position);
    if view.z < pinhole.near {
        return 0.0;
    }
    let normal = pinhole.view_from_world_direction(receiver.normal);
    let along = normal.dot(view);
    let pixel = pinhole.pixel_from_view(view) - 0.5;
    let base = pixel.floor();
    let fraction = pixel - base;
    let mut lit = 0.0;
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let corner = Vec2::new(dx as f32, dy as f32);
        let weight = (1.0 - corner - fraction).abs();
        let texel = base + corner;
        let slope = pinhole.slope(texel + 0.5);
        let towards = normal.x * slope.x + normal.y * slope.y + normal.z;
        let own = if along.abs() > RECEIVER_COSINE * view.length() {
            along / towards
        } else {
            view.z
        };
        // A plane that turns away within a texel has no depth there.
        let own = if own > 0.5 * view.z && own < 2.0 * view.z {
            own
        } else {
            view.z
        };
        let (x, y) = (texel.x as i64, texel.y as i64);
        let key = match (usize::try_from(x), usize::try_from(y)) {
            (Ok(x), Ok(y)) => keys.get(x, y).copied(),
            _ => None,
        };
        let blocked = key
            .and_then(depth_from_key)
            .is_some_and(|depth| depth < own - bias);
        if !blocked {
            lit += weight.x * weight.y;
        }
    }
    lit
}

/// Radiance that a receiver sends to the eye from one spot.
fn spot_radiance(receiver: &Receiver, lit_by: &LitBy<Cpu>, settings: &GiSettings) -> Vec3 {
    let light = &lit_by.light;
    let to_light = light.position - receiver.position;
    let distance_squared = to_light.length_squared();
    if distance_squared <= 0.0 {
        return Vec3::ZERO;
    }
    let direction = to_light / distance_squared.sqrt();
    let cosine = receiver.normal.dot(direction);
    let falloff = light.falloff_towards(-direction);
    if cosine <= 0.0 || falloff <= 0.0 {
        return Vec3::ZERO;
    }
    let lit = visibility(
        receiver,
        &lit_by.map,
        settings.light_bias * receiver.seen.material.z,
    );
    let irradiance = light.intensity * (falloff * cosine / distance_squared * lit);
    let [specular, shininess] = [receiver.seen.material.x, receiver.seen.material.y];
    let mut reflected = receiver.seen.albedo.truncate() * settings.albedo_scale / PI;
    if specular > 0.0 {
        let mirrored = receiver.normal * (2.0 * cosine) - direction;
        let lobe =
            mirrored.dot(receiver.view).max(0.0).powf(shininess) * (shininess + 2.0) / (2.0 * PI);
        reflected += specular * lobe;
    }
    reflected * irradiance
}

/// Radiance that a receiver sends to the eye from all lights.
fn direct(receiver: &Receiver, lights: &[LitBy<Cpu>], settings: &GiSettings) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for lit_by in lights {
        sum += spot_radiance(receiver, lit_by, settings);
    }
    sum
}

/// Radiance of every pixel towards the eye, W/sr/m2; alpha 1 where valid. A mirror's own part is weighted by what its
/// reflectance leaves.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn shade(
    gbuffer: &GBuffer<Cpu>,
    lights: &[LitBy<Cpu>],
    settings: &GiSettings,
    job: &Job,
) -> Result<Grid<Vec4>> {
    let mut radiance = Grid::new(gbuffer.size(), Vec4::ZERO);
    let width = gbuffer.surface.width();
    radiance
        .values_mut()
        .par_iter_mut()
        .enumerate()
        .for_each(|(i, out)| {
            let (x, y) = column_row(i, width);
            let Some(seen) = gbuffer.at(x, y).filter(|_| !job.is_cancelled()) else {
                return;
            };
            let direction = gbuffer.direction(x, y);
            let receiver = Receiver {
                position: gbuffer.pinhole.eye + direction * seen.surface.w,
                normal: seen.surface.truncate(),
                view: -direction.normalize_or_zero(),
                seen,
            };
            *out = (direct(&receiver, lights, settings) * (1.0 - seen.albedo.w)).extend(1.0);
        });
    job.check()?;
    Ok(radiance)
}

/// Radiance that every mirror pixel shows, W/sr/m2: what it sees is lit like everything else, with the mirror's point as
/// the eye [Preiner 2010, section 4.7]. A mirror seen in a mirror is black but for what its reflectance leaves.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn shade_mirror(
    mirror: &MirrorGBuffer<Cpu>,
    lights: &[LitBy<Cpu>],
    settings: &GiSettings,
    job: &Job,
) -> Result<Grid<Vec4>> {
    let mut radiance = Grid::new(mirror.size(), Vec4::ZERO);
    let rays = mirror
        .origin
        .values()
        .par_iter()
        .zip(mirror.direction.values());
    radiance
        .values_mut()
        .par_iter_mut()
        .zip(rays)
        .enumerate()
        .for_each(|(i, (out, (origin, direction)))| {
            let Some(seen) = mirror.at(i).filter(|_| !job.is_cancelled()) else {
                return;
            };
            let receiver = Receiver {
                position: origin.truncate() + direction.truncate() * seen.surface.w,
                normal: seen.surface.truncate(),
                view: -direction.truncate(),
                seen,
            };
            *out = (direct(&receiver, lights, settings) * (1.0 - seen.albedo.w)).extend(1.0);
        });
    job.check()?;
    Ok(radiance)
}
