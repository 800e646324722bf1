//! Analytic scenes as the reflection passes take them: mirrors without any error of splatting, and clouds.

use std::sync::Arc;

use catoptric::Job;
use catoptric::backend::cpu::Cpu;
use catoptric::camera::Camera;
use catoptric::cloud::generate::{SceneName, generate};
use catoptric::cloud::{Surfels, prepare};
use catoptric::grid::Grid;
use catoptric::reflect::sscr::LhcMap;
use catoptric::reflect::sscr::curvature::{Axes, LhcSettings, curvature};
use catoptric::reflect::sscr::lhc::Labeller;
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

/// The regions of a view's mirrors.
pub(crate) fn regions(view: &View, surface: &Surface<Cpu>) -> LhcMap {
    let camera = Camera {
        position: view.position,
        target: view.target,
        up: view.up,
        fov_y_degrees: view.fov_y_degrees,
        near: 0.05,
        far: 10.0,
        size: surface.size,
    };
    let pinhole = camera.pinhole(DVec3::ZERO).expect("a sound camera");
    let cells = curvature(surface, Axes::from(&pinhole), &LhcSettings::default());
    Labeller::default().lhc(&cells).clone()
}

/// A generated scene as surfels.
pub(crate) fn cloud(name: SceneName, points: usize) -> Arc<Surfels> {
    let job = Job::default();
    let raw = generate(name, points, 1, None, &job).expect("a scene that needs no mesh");
    let prepared = prepare(vec![raw.into()], DVec3::ZERO, &job).expect("a sound cloud");
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
