//! What can be looked at instead of the picture: every layer of the G-buffers, and where the search ends.

use catoptric::grid::Grid;
use catoptric::image::{ImageSettings, picture, srgb_from_linear};
use catoptric::output::heat_colour;
use catoptric::renderer::Products;
use glam::{UVec2, Vec2, Vec3, Vec4};

use super::{shadow_maps, virtual_lights};

/// A layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Buffer {
    #[default]
    Picture,
    Albedo,
    Normal,
    Depth,
    Position,
    Specular,
    Mirror,
    Filled,
    Region,
    ReflectedAlbedo,
    ReflectedNormal,
    Distance,
    Points,
    Level,
    Steps,
    Misses,
    Residual,
    VirtualLights,
    ShadowMaps,
}

/// A layer's colours.
pub(super) struct Painted {
    pub(super) picture: Grid<[u8; 4]>,
    /// What the darkest and the brightest colour stand for, where colours stand for numbers.
    pub(super) scale: Option<(f32, f32)>,
}

/// Colours of regions and of what has no colour of its own follow one another at this angle of the colour circle.
const GOLDEN: f32 = 0.618_034;

impl Buffer {
    pub(super) const ALL: [Self; 19] = [
        Self::Picture,
        Self::Albedo,
        Self::Normal,
        Self::Depth,
        Self::Position,
        Self::Specular,
        Self::Mirror,
        Self::Filled,
        Self::Region,
        Self::ReflectedAlbedo,
        Self::ReflectedNormal,
        Self::Distance,
        Self::Points,
        Self::Level,
        Self::Steps,
        Self::Misses,
        Self::Residual,
        Self::VirtualLights,
        Self::ShadowMaps,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Picture => "Picture",
            Self::Albedo => "Albedo",
            Self::Normal => "Normal",
            Self::Depth => "Depth",
            Self::Position => "Position",
            Self::Specular => "Specular",
            Self::Mirror => "Mirror",
            Self::Filled => "Filled",
            Self::Region => "Regions",
            Self::ReflectedAlbedo => "Reflected albedo",
            Self::ReflectedNormal => "Reflected normal",
            Self::Distance => "Distance",
            Self::Points => "Hits",
            Self::Level => "Closing level",
            Self::Steps => "Search steps",
            Self::Misses => "Search misses",
            Self::Residual => "Search residual",
            Self::VirtualLights => "Virtual lights",
            Self::ShadowMaps => "Shadow maps (ISM)",
        }
    }

    pub(super) fn about(self) -> &'static str {
        match self {
            Self::Picture => "The picture: light, exposed and tone mapped.",
            Self::Albedo => "The colour of points without light.",
            Self::Normal => "Which way surfaces face; x, y, z as red, green, blue.",
            Self::Depth => "Distance along the axis of view.",
            Self::Position => "Where points lie in the scene's box; x, y, z as red, green, blue.",
            Self::Specular => "Specular reflectance.",
            Self::Mirror => "How much of a point is a mirror.",
            Self::Filled => {
                "Holes that were filled: in which ring; dark where points were splatted."
            }
            Self::Region => {
                "Mirror regions of one curvature (LHC map, or charts of the guided search)."
            }
            Self::ReflectedAlbedo => "The colour of what mirrors show, without light.",
            Self::ReflectedNormal => "Which way surfaces that mirrors show face.",
            Self::Distance => "How far from the mirror what it shows is.",
            Self::Points => "How many points make a mirror's pixel.",
            Self::Level => {
                "How a mirror's pixel came to be: dark by the search, brighter from coarser levels of closing."
            }
            Self::Steps => "Steps of the interleaved search, on average.",
            Self::Misses => "Searches of the interleaved search that ended here and found nothing.",
            Self::Residual => "What is left of the interleaved search's error.",
            Self::VirtualLights => {
                "The points from which indirect light comes, over the darkened picture: in their colour, larger with their flux."
            }
            Self::ShadowMaps => {
                "What virtual lights see, map by map (imperfect shadow maps): how far away it is."
            }
        }
    }

    /// Whether it shows what only a mirror has.
    pub(super) fn is_of_mirrors(self) -> bool {
        matches!(
            self,
            Self::Region
                | Self::ReflectedAlbedo
                | Self::ReflectedNormal
                | Self::Distance
                | Self::Points
                | Self::Level
        ) || self.needs_search_heat()
    }

    /// Whether a frame must say where its searches end.
    pub(super) fn needs_search_heat(self) -> bool {
        matches!(self, Self::Steps | Self::Misses | Self::Residual)
    }

    /// Whether a frame must say which its virtual lights are.
    pub(super) fn needs_virtual_lights(self) -> bool {
        matches!(self, Self::VirtualLights | Self::ShadowMaps)
    }

    /// Whether a frame that was asked for with the layer `asked` has what this one shows.
    pub(super) fn comes_with(self, asked: Self) -> bool {
        (!self.needs_search_heat() || asked.needs_search_heat())
            && (!self.needs_virtual_lights() || asked.needs_virtual_lights())
    }

    /// Whether its pixels are those of the camera.
    pub(super) fn is_of_view(self) -> bool {
        self != Self::ShadowMaps
    }

    /// The layer in colours; black where it has nothing.
    pub(super) fn paint(self, products: &Products, image: &ImageSettings) -> Painted {
        let gbuffer = &products.gbuffer;
        let size = gbuffer.surface.size();
        let valid = |i: usize| gbuffer.material.values()[i].w > 0.0;
        let of = |grid: &Grid<Vec4>, i: usize| grid.values()[i];
        let colours = |colour: &dyn Fn(usize) -> Option<Vec3>| painted(size, colour);
        let mirror = products.mirror.as_ref();
        let shown = |i: usize| mirror.filter(|m| m.at(i).is_some());
        match self {
            Self::Picture => Painted {
                picture: picture(&products.radiance, image),
                scale: None,
            },
            Self::Albedo => colours(&|i| {
                valid(i)
                    .then(|| of(&gbuffer.albedo, i).truncate())
                    .map(srgb)
            }),
            Self::Normal => colours(&|i| {
                valid(i).then(|| of(&gbuffer.surface, i).truncate() * 0.5 + Vec3::splat(0.5))
            }),
            Self::Depth => scaled(size, &|i| valid(i).then(|| of(&gbuffer.surface, i).w)),
            Self::Position => boxed(size, &|i| valid(i).then(|| position(products, i))),
            Self::Specular => scaled(size, &|i| valid(i).then(|| of(&gbuffer.material, i).x)),
            Self::Mirror => scaled(size, &|i| valid(i).then(|| of(&gbuffer.albedo, i).w)),
            Self::Filled => scaled(size, &|i| {
                valid(i).then(|| of(&gbuffer.material, i).w - 1.0)
            }),
            Self::Region => colours(&|i| {
                let region = mirror.map_or(0, |m| m.region.values()[i]);
                (region > 0).then(|| hue(region as f32 * GOLDEN))
            }),
            Self::ReflectedAlbedo => {
                colours(&|i| shown(i).map(|m| srgb(of(&m.albedo, i).truncate())))
            }
            Self::ReflectedNormal => colours(&|i| {
                shown(i).map(|m| of(&m.surface, i).truncate() * 0.5 + Vec3::splat(0.5))
            }),
            Self::Distance => scaled(size, &|i| shown(i).map(|m| of(&m.surface, i).w)),
            Self::Points => scaled(size, &|i| shown(i).map(|m| m.count.values()[i] as f32)),
            Self::Level => scaled(size, &|i| shown(i).map(|m| m.level.values()[i])),
            Self::Steps | Self::Misses | Self::Residual => {
                let heat = products.search_heat.as_ref();
                scaled(size, &|i| {
                    let sums = heat?.values().get(i)?;
                    let value = match self {
                        Self::Steps => sums.mean_steps(),
                        Self::Residual => sums.mean_residual(),
                        _ => sums.lost as f32,
                    };
                    (sums.found + sums.lost > 0).then_some(value)
                })
            }
            Self::VirtualLights => virtual_lights::paint(products, image),
            Self::ShadowMaps => shadow_maps::paint(products),
        }
    }
}

/// Where what a pixel shows is, relative to the scene's origin.
pub(super) fn position(products: &Products, i: usize) -> Vec3 {
    let (gbuffer, width) = (&products.gbuffer, products.gbuffer.surface.width().max(1));
    let centre = Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
    gbuffer
        .pinhole
        .world_from_pixel(centre, gbuffer.surface.values()[i].w)
}

pub(super) fn srgb(linear: Vec3) -> Vec3 {
    linear.map(|v| f32::from(srgb_from_linear(v)) / 255.0)
}

/// A saturated colour.
fn hue(turn: f32) -> Vec3 {
    let channel = |offset: f32| ((turn + offset).fract() * 6.0 - 3.0).abs() - 1.0;
    let colour = Vec3::new(channel(0.0), channel(1.0 / 3.0), channel(2.0 / 3.0));
    colour.clamp(Vec3::ZERO, Vec3::ONE) * 0.75 + Vec3::splat(0.2)
}

fn painted(size: UVec2, colour: &dyn Fn(usize) -> Option<Vec3>) -> Painted {
    let mut picture = Grid::new(size, [0, 0, 0, 255]);
    for (i, pixel) in picture.values_mut().iter_mut().enumerate() {
        if let Some(colour) = colour(i) {
            let [r, g, b] = colour.to_array().map(|v| (v * 255.0 + 0.5) as u8);
            *pixel = [r, g, b, 255];
        }
    }
    Painted {
        picture,
        scale: None,
    }
}

/// From the smallest value, dark, to the largest, bright.
fn scaled(size: UVec2, value: &dyn Fn(usize) -> Option<f32>) -> Painted {
    let pixels = size.x as usize * size.y as usize;
    let values = (0..pixels).filter_map(value).filter(|v| v.is_finite());
    let (low, high) = values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    let width = if high > low { high - low } else { 1.0 };
    let colour =
        |i| value(i).map(|v| Vec3::from(heat_colour((v - low) / width).map(f32::from)) / 255.0);
    Painted {
        scale: (low <= high).then_some((low, high)),
        ..painted(size, &colour)
    }
}

/// Places within the box around all of them.
fn boxed(size: UVec2, place: &dyn Fn(usize) -> Option<Vec3>) -> Painted {
    let pixels = size.x as usize * size.y as usize;
    let all = || (0..pixels).filter_map(place).filter(|p| p.is_finite());
    let low = all().fold(Vec3::INFINITY, Vec3::min);
    let width =
        (all().fold(Vec3::NEG_INFINITY, Vec3::max) - low).max(Vec3::splat(f32::MIN_POSITIVE));
    painted(size, &|i| place(i).map(|p| (p - low) / width))
}
