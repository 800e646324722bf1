//! The layer of virtual lights: where they are in the picture, and which one is under the cursor.

use catoptric::gi::virtual_lights::VirtualLights;
use catoptric::gi::vpl::importance;
use catoptric::grid::Grid;
use catoptric::image::{ImageSettings, picture};
use catoptric::renderer::Products;
use glam::{DVec3, UVec2, Vec2, Vec3};

use super::buffers::{Painted, srgb};
use super::probe::{global, vector};

/// What is left of the picture's brightness.
const DARKENED: f32 = 0.4;

/// Radius of the disc of the light of most flux, part of the picture's height; its area goes with the flux.
const LARGEST: f32 = 0.007;

/// The least radius, pixels.
const SMALLEST: f32 = 2.0;

/// How much of a light is left that lies behind what is seen.
const FAINT: f32 = 0.3;

/// It does where it is farther along the axis by more than this part, ...
const FARTHER: f32 = 0.01;

/// ... and so many spacings of its surface: splats do not meet it to the last digit.
const SPACINGS: f32 = 2.0;

/// A light in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mark {
    /// Its number, from 0.
    pub(super) light: usize,
    /// Pixels.
    pub(super) centre: Vec2,
    radius: f32,
    pub(super) hidden: bool,
}

/// All lights in the picture.
pub(super) fn marks(products: &Products) -> impl Iterator<Item = Mark> + '_ {
    let gbuffer = &products.gbuffer;
    let (pinhole, size) = (&gbuffer.pinhole, gbuffer.surface.size());
    let lights = products.virtual_lights.iter().flat_map(|l| &l.lights);
    let fluxes = lights.clone().map(|light| importance(light.vpl.flux));
    let most = fluxes.fold(f32::MIN_POSITIVE, f32::max);
    let widest = (LARGEST * size.y as f32).max(SMALLEST);
    lights.enumerate().filter_map(move |(light, each)| {
        let flux = importance(each.vpl.flux);
        let view = pinhole.view_from_world(each.vpl.position);
        let centre = pinhole.pixel_from_view(view);
        let inside = centre.cmpge(Vec2::ZERO).all() && centre.cmplt(size.as_vec2()).all();
        if !(flux > 0.0 && view.z > 0.0 && inside) {
            return None;
        }
        let (x, y) = (centre.x as usize, centre.y as usize);
        let valid = gbuffer.material.get(x, y).is_some_and(|m| m.w > 0.0);
        let seen = gbuffer.surface.get(x, y).filter(|_| valid);
        let reach = SPACINGS * each.vpl.spacing;
        Some(Mark {
            light,
            centre,
            radius: (widest * (flux / most).sqrt()).max(SMALLEST),
            hidden: seen.is_some_and(|seen| view.z > seen.w * (1.0 + FARTHER) + reach),
        })
    })
}

/// The picture, darkened, with all lights over it.
pub(super) fn paint(products: &Products, image: &ImageSettings) -> Painted {
    let mut picture = picture(&products.radiance, image);
    for [r, g, b, _] in picture.values_mut() {
        for channel in [r, g, b] {
            *channel = (f32::from(*channel) * DARKENED) as u8;
        }
    }
    if let Some(told) = &products.virtual_lights {
        for hidden in [true, false] {
            for mark in marks(products).filter(|mark| mark.hidden == hidden) {
                disc(&mut picture, &mark, colour(told, mark.light));
            }
        }
    }
    Painted {
        picture,
        scale: None,
    }
}

/// Of a light at its brightest, sRGB from 0 to 1.
fn colour(told: &VirtualLights, light: usize) -> Vec3 {
    let flux = (told.lights.get(light)).map_or(Vec3::ZERO, |light| light.vpl.flux);
    srgb(flux / flux.max_element().max(f32::MIN_POSITIVE))
}

/// A disc with a dark edge, so that it stands out.
fn disc(picture: &mut Grid<[u8; 4]>, mark: &Mark, colour: Vec3) {
    let opacity = if mark.hidden { FAINT } else { 1.0 };
    let (size, width) = (picture.size(), picture.width());
    let reach = Vec2::splat(mark.radius + 2.0);
    let first = (mark.centre - reach).max(Vec2::ZERO).as_uvec2();
    let end = (mark.centre + reach).max(Vec2::ZERO).as_uvec2().min(size);
    for y in first.y..end.y {
        for x in first.x..end.x {
            let away = mark.centre.distance(UVec2::new(x, y).as_vec2() + 0.5);
            let part = |radius: f32| opacity * (radius + 0.5 - away).clamp(0.0, 1.0);
            let i = y as usize * width + x as usize;
            if let Some(pixel) = picture.values_mut().get_mut(i) {
                blend(pixel, Vec3::ZERO, part(mark.radius + 1.0));
                blend(pixel, colour, part(mark.radius));
            }
        }
    }
}

fn blend(pixel: &mut [u8; 4], colour: Vec3, part: f32) {
    for (channel, over) in pixel.iter_mut().zip(colour.to_array()) {
        let mixed = f32::from(*channel) * (1.0 - part) + 255.0 * over * part;
        *channel = (mixed + 0.5) as u8;
    }
}

/// The light on which a pixel is, or the nearest; one that is seen before one that is hidden.
pub(super) fn nearest(products: &Products, pixel: UVec2) -> Option<Mark> {
    let at = pixel.as_vec2() + 0.5;
    let off = |mark: &Mark| (mark.centre.distance(at) - mark.radius).max(0.0);
    marks(products).min_by(|a, b| {
        let middle = |mark: &Mark| mark.centre.distance(at);
        (off(a).total_cmp(&off(b)))
            .then(a.hidden.cmp(&b.hidden))
            .then(middle(a).total_cmp(&middle(b)))
    })
}

/// What the nearest light is.
pub(super) fn probe(
    products: &Products,
    origin: DVec3,
    pixel: UVec2,
) -> Vec<(&'static str, String)> {
    let told = products.virtual_lights.as_deref();
    let Some((told, mark)) = told.zip(nearest(products, pixel)) else {
        return Vec::new();
    };
    let mut lines = about(told, mark.light, origin);
    if mark.hidden {
        lines.push(("", "behind what is seen".to_owned()));
    }
    lines
}

/// A light, for people; `number` is from 0.
pub(super) fn about(
    told: &VirtualLights,
    number: usize,
    origin: DVec3,
) -> Vec<(&'static str, String)> {
    let Some(light) = told.lights.get(number) else {
        return Vec::new();
    };
    let vpl = &light.vpl;
    let bounce = match light.bounce {
        0 => "the environment".to_owned(),
        bounce => bounce.to_string(),
    };
    let watts = |v: f32| format!("{v:.2e}");
    let [r, g, b] = vpl.flux.to_array().map(watts);
    vec![
        ("light", format!("{} of {}", number + 1, told.lights.len())),
        ("bounce", bounce),
        ("light at", global(origin + vpl.position.as_dvec3())),
        ("faces", vector(vpl.normal)),
        ("flux, W", format!("{r}  {g}  {b}")),
    ]
}
