//! What is under the cursor.

use catoptric::renderer::Products;
use glam::{DVec3, UVec2, Vec3};

use super::buffers::{Buffer, position};
use super::{shadow_maps, virtual_lights};

/// A direction or a colour, for people.
pub(super) fn vector(v: Vec3) -> String {
    format!("{:.3}  {:.3}  {:.3}", v.x, v.y, v.z)
}

/// A position in the scene's frame, for people.
pub(super) fn global(v: DVec3) -> String {
    format!("{:.4}  {:.4}  {:.4}", v.x, v.y, v.z)
}

/// What is under the cursor.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Probe {
    /// In the scene's frame.
    pub(super) position: Option<DVec3>,
    /// Where what the mirror shows there really is.
    pub(super) reflected: Option<DVec3>,
    /// Names and values, for people.
    pub(super) lines: Vec<(&'static str, String)>,
}

impl Probe {
    /// What a pixel of a layer of a frame shows.
    pub(super) fn new(products: &Products, origin: DVec3, pixel: UVec2, buffer: Buffer) -> Self {
        if !buffer.is_of_view() {
            return Self {
                lines: shadow_maps::probe(products, origin, pixel),
                ..Self::default()
            };
        }
        let mut probe = Self::of_view(products, origin, pixel);
        if buffer == Buffer::VirtualLights {
            let lines = virtual_lights::probe(products, origin, pixel);
            probe.lines.extend(lines);
        }
        probe
    }

    /// What the camera sees there.
    fn of_view(products: &Products, origin: DVec3, pixel: UVec2) -> Self {
        let gbuffer = &products.gbuffer;
        let size = gbuffer.surface.size();
        if pixel.cmpge(size).any() {
            return Self::default();
        }
        let i = (pixel.y * size.x + pixel.x) as usize;
        let mut probe = Self {
            lines: vec![("pixel", format!("{}, {}", pixel.x, pixel.y))],
            ..Self::default()
        };
        let material = gbuffer.material.values()[i];
        if material.w > 0.0 {
            let (surface, albedo) = (gbuffer.surface.values()[i], gbuffer.albedo.values()[i]);
            let position = origin + position(products, i).as_dvec3();
            probe.position = Some(position);
            probe.lines.extend([
                ("position", global(position)),
                ("depth", format!("{:.4}", surface.w)),
                ("normal", vector(surface.truncate())),
                ("albedo", vector(albedo.truncate())),
                ("mirror", format!("{:.2}", albedo.w)),
            ]);
        }
        let radiance = products.radiance.values()[i];
        if radiance.w > 0.0 {
            probe.lines.push(("radiance", vector(radiance.truncate())));
        }
        if let Some(mirror) = &products.mirror {
            let region = mirror.region.values()[i];
            if region > 0 {
                probe.lines.push(("region", region.to_string()));
            }
            if mirror.at(i).is_some() {
                let surface = mirror.surface.values()[i];
                let start = mirror.origin.values()[i].truncate();
                let at = start + mirror.direction.values()[i].truncate() * surface.w;
                let reflected = origin + at.as_dvec3();
                probe.reflected = Some(reflected);
                probe.lines.extend([
                    ("shows", global(reflected)),
                    ("distance", format!("{:.4}", surface.w)),
                    ("hits", mirror.count.values()[i].to_string()),
                    ("level", format!("{}", mirror.level.values()[i])),
                ]);
            }
        }
        probe
    }
}
