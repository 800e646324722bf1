//! Analytic scenes as the reflection passes take them: mirrors without any error of splatting, and clouds.

use std::sync::Arc;

use catoptric::Job;
use catoptric::backend::cpu::Cpu;
use catoptric::cloud::generate::{SceneName, generate};
use catoptric::cloud::{Material, PlacedCloud, Surfels, prepare};
use catoptric::gbuffer::disc::PixelRect;
use catoptric::grid::Grid;
use catoptric::reflect::sscr::{LhcMap, Region};
use catoptric::reflect::{Eye, Surface};
use glam::{DVec3, UVec2, Vec4};

use crate::analytic::{Hit, Kind, View};

/// Spacing of the points of the reference scenes, metres.
pub(crate) const SPACING: f32 = 0.0051;

/// The mirrors of a view, exactly; `tilt` turns every normal by so many degrees around the view's up axis.
pub(crate) fn surface(view: &View, hits: &[Hit], tilt: f64) -> Surface<Cpu> {
    let size = UVec2::new(view.width as u32, view.height as u32);
    let turn = glam::DQuat::from_axis_angle(view.up.normalize(), tilt.to_radians());
    let mirror = |hit: &Hit| matches!(hit.kind, Kind::Mirror(_));
    let point = |hit: &Hit| {
        if mirror(hit) {
            hit.position.as_vec3().extend(1.0)
        } else {
            Vec4::ZERO
        }
    };
    let normal = |hit: &Hit| {
        if mirror(hit) {
            (turn * hit.normal).as_vec3().extend(SPACING)
        } else {
            Vec4::ZERO
        }
    };
    Surface {
        size,
        point: Grid::from_vec(size, hits.iter().map(point).collect()).expect("a view's hits"),
        normal: Grid::from_vec(size, hits.iter().map(normal).collect()).expect("a view's hits"),
        eye: Eye::Point(view.position.as_vec3()),
    }
}

/// All mirror pixels as one region.
pub(crate) fn one_region(surface: &Surface<Cpu>) -> LhcMap {
    let labels: Vec<u32> = surface
        .point
        .values()
        .iter()
        .map(|p| u32::from(p.w > 0.0))
        .collect();
    let width = surface.size.x as usize;
    let at = |index: usize| ((index % width) as u32, (index / width) as u32);
    let mut bounds = PixelRect {
        x0: u32::MAX,
        y0: u32::MAX,
        x1: 0,
        y1: 0,
    };
    let mut pixels = 0;
    for (index, _) in labels.iter().enumerate().filter(|(_, label)| **label == 1) {
        let (x, y) = at(index);
        bounds.x0 = bounds.x0.min(x);
        bounds.y0 = bounds.y0.min(y);
        bounds.x1 = bounds.x1.max(x + 1);
        bounds.y1 = bounds.y1.max(y + 1);
        pixels += 1;
    }
    LhcMap {
        labels: Grid::from_vec(surface.size, labels).expect("a label a pixel"),
        regions: vec![Region {
            bounds,
            pixels,
            weight: 1.0,
            accumulated_weight: 1.0,
        }],
    }
}

/// A generated scene as surfels.
pub(crate) fn cloud(name: SceneName, points: usize) -> Arc<Surfels> {
    let job = Job::default();
    let raw = generate(name, points, 1, None, &job).expect("a scene that needs no mesh");
    let placed = PlacedCloud {
        raw,
        transform: None,
        material: Material::default(),
        mirrors: Vec::new(),
        name: name.to_string(),
    };
    let prepared = prepare(vec![placed], DVec3::ZERO, &job).expect("a sound cloud");
    Arc::new(prepared.surfels)
}

/// Pixels at least `margin` pixels inside of the mirrors' outlines, by index.
pub(crate) fn inside(view: &View, hits: &[Hit], margin: usize) -> Vec<usize> {
    let same = |index: usize| {
        let (x, y) = (index % view.width, index / view.width);
        if x < margin || y < margin || x + margin >= view.width || y + margin >= view.height {
            return false;
        }
        let rows = y - margin..=y + margin;
        rows.flat_map(|row| (x - margin..=x + margin).map(move |column| (column, row)))
            .all(|(column, row)| hits[row * view.width + column].kind == hits[index].kind)
    };
    (0..hits.len())
        .filter(|&index| matches!(hits[index].kind, Kind::Mirror(_)) && same(index))
        .collect()
}
