//! How the gizmo looks.

use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Shape, Stroke, Vec2};

use super::grips::{Grip, Outline};
use crate::viewer::handles::Arm;

/// Of the axes: x, y, z.
const AXES: [Color32; 3] = [
    Color32::from_rgb(235, 80, 80),
    Color32::from_rgb(110, 200, 70),
    Color32::from_rgb(80, 145, 255),
];
const VIEW: Color32 = Color32::from_rgb(225, 225, 225);
const TAKEN: Color32 = Color32::from_rgb(255, 215, 60);
/// Beneath all lines, so that they are seen before any picture.
const SHADE: Color32 = Color32::from_black_alpha(150);

const WIDTH: f32 = 2.5;
const TIP: f32 = 12.0;
const KNOB: f32 = 5.0;

/// The colour of a part.
fn colour(grip: Grip, arms: &[Arm]) -> Color32 {
    match grip {
        Grip::Axis(i) | Grip::Across(i) | Grip::Ring(i) => AXES[i.min(2)],
        Grip::Arm(i) => arms.get(i).map_or(VIEW, |arm| AXES[arm.axis.min(2)]),
        Grip::View | Grip::ViewRing | Grip::Grow => VIEW,
    }
}

/// One part, as it is when the cursor is on it or elsewhere.
pub(super) fn part(painter: &Painter, grip: Grip, outline: &Outline, arms: &[Arm], taken: bool) {
    let colour = if taken { TAKEN } else { colour(grip, arms) };
    match outline {
        Outline::Arrow([from, to]) => {
            let along = (*to - *from).normalized();
            let neck = *to - along * TIP;
            line(painter, &[*from, neck], colour);
            let side = along.rot90() * (TIP * 0.42);
            let tip = vec![neck - side, neck + side, *to];
            painter.add(Shape::convex_polygon(tip, colour, Stroke::new(1.0, SHADE)));
        }
        Outline::Square(corners) => {
            let fill = colour.gamma_multiply(if taken { 0.7 } else { 0.35 });
            let stroke = Stroke::new(1.0, colour);
            painter.add(Shape::convex_polygon(corners.to_vec(), fill, stroke));
        }
        Outline::Disc(middle, radius) => {
            let fill = colour.gamma_multiply(if taken { 0.7 } else { 0.3 });
            painter.circle(*middle, *radius, fill, Stroke::new(1.5, colour));
        }
        Outline::Circle(middle, radius) => {
            painter.circle_stroke(*middle, *radius, Stroke::new(WIDTH + 2.0, SHADE));
            painter.circle_stroke(*middle, *radius, Stroke::new(WIDTH, colour));
        }
        Outline::Ring(parts) => {
            for part in parts {
                line(painter, part, colour);
            }
        }
        Outline::Knob([from, to]) => {
            painter.line_segment([*from, *to], Stroke::new(1.0, colour.gamma_multiply(0.6)));
            let corner = Vec2::splat(KNOB);
            let square = eframe::egui::Rect::from_min_max(*to - corner, *to + corner);
            painter.rect(
                square,
                1.0,
                colour,
                Stroke::new(1.0, SHADE),
                eframe::egui::StrokeKind::Outside,
            );
        }
    }
}

/// A line through points, which is seen before any picture.
fn line(painter: &Painter, points: &[Pos2], colour: Color32) {
    painter.line(points.to_vec(), Stroke::new(WIDTH + 2.0, SHADE));
    painter.line(points.to_vec(), Stroke::new(WIDTH, colour));
}

/// The line that a drag goes along.
pub(super) fn guide(painter: &Painter, ends: [Pos2; 2]) {
    painter.line_segment(ends, Stroke::new(1.0, TAKEN.gamma_multiply(0.6)));
}

/// Words beside the cursor.
pub(super) fn say(painter: &Painter, at: Pos2, text: &str) {
    let font = FontId::proportional(14.0);
    let galley = painter.layout_no_wrap(text.to_owned(), font, Color32::WHITE);
    let corner = Align2::LEFT_BOTTOM.anchor_size(at + Vec2::new(14.0, -10.0), galley.size());
    // Near the edges of the picture they stay inside.
    let room = painter.clip_rect().shrink(4.0);
    let inside = corner.translate(
        (room.min - corner.min).max(Vec2::ZERO) + (room.max - corner.max).min(Vec2::ZERO),
    );
    painter.rect_filled(inside.expand(3.0), 3.0, Color32::from_black_alpha(190));
    painter.galley(inside.min, galley, Color32::WHITE);
}
