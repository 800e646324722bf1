//! The camera path as a line over the picture, with its keyframes and where they look.

use catoptric::camera::Camera;
use eframe::egui::{Color32, Painter, Pos2, Stroke};
use glam::DVec3;

use super::film::Film;

const COLOUR: Color32 = Color32::from_rgb(120, 230, 120);

/// Straight pieces of the whole line, about.
const PIECES: usize = 400;

/// Part of the way to its target that a keyframe's direction is drawn long.
const DIRECTION: f64 = 0.2;

/// Farther from the window's corner nothing is drawn, points.
const FARTHEST: f32 = 1e5;

/// Draws it as seen by `eye`; `on_screen` tells where a point is, if it is in front of the camera.
pub(super) fn show(
    film: &Film,
    painter: &Painter,
    eye: &Camera,
    on_screen: impl Fn(DVec3) -> Option<Pos2>,
) {
    // What is at the eye is nowhere on screen.
    let nearest = eye.position.distance(eye.target) * 1e-3;
    let on_screen = |point: DVec3| {
        let at = on_screen(point).filter(|at| at.to_vec2().abs().max_elem() < FARTHEST);
        at.filter(|_| point.distance(eye.position) > nearest)
    };
    let path = &film.path;
    let (thin, thick) = (Stroke::new(1.0, COLOUR), Stroke::new(2.0, COLOUR));
    let mut times = Vec::new();
    let (start, end) = path.span();
    let knots: Vec<f64> = match path.turntable {
        Some(_) => vec![start, end],
        None => path.keyframes().iter().map(|k| k.time).collect(),
    };
    let steps = (PIECES / knots.len().max(1)).clamp(2, 120);
    for ends in knots.windows(2) {
        let step = (ends[1] - ends[0]) / steps as f64;
        times.extend((0..steps).map(|k| ends[0] + step * k as f64));
    }
    times.push(end);
    let place = |time: &f64| path.pose(*time).and_then(|pose| on_screen(pose.position));
    let places: Vec<Option<Pos2>> = times.iter().map(place).collect();
    for ends in places.windows(2) {
        // What is behind the camera breaks the line.
        if let [Some(from), Some(to)] = ends {
            painter.line_segment([*from, *to], thick);
        }
    }
    let mark = |position: DVec3, target: DVec3, radius: f32, fill: Color32| {
        let Some(at) = on_screen(position) else {
            return;
        };
        if let Some(towards) = on_screen(position.lerp(target, DIRECTION)) {
            painter.line_segment([at, towards], thin);
        }
        painter.circle(at, radius, fill, thick);
    };
    if path.turntable.is_none() {
        for keyframe in path.keyframes() {
            let pose = keyframe.pose;
            mark(
                pose.position,
                pose.target,
                4.0,
                Color32::from_black_alpha(160),
            );
        }
    }
    if let Some(now) = path.pose(film.at) {
        mark(now.position, now.target, 6.0, COLOUR);
    }
}
