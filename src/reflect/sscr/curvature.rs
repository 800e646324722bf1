//! Pass `curvature`: how a mirror bends from the left and from the upper pixel to this one, and whether it breaks off in
//! between: one byte a pixel [Preiner 2010, sections 3.5.1 and 4.3, figure 4.3].
//!
//! The bend along x is the change of the normal's x component from the left pixel, that along y the change of its y
//! component (down the screen) from the upper one. The depth step is not the thesis's difference of depths, which tears
//! apart what is seen at a flat angle, but the distance of both points from each other's tangent planes: 0 on a plane from
//! whatever angle, and free of curvature to second order (exactly 0 on a sphere).

use glam::{Vec3, Vec4Swizzles};
use rayon::prelude::*;

use crate::backend::cpu::Cpu;
use crate::camera::Pinhole;
use crate::grid::Grid;
use crate::reflect::Surface;
use crate::settings_group;

settings_group! {
    /// How mirrors are cut into regions of homogeneous curvature.
    pub struct LhcSettings in "lhc" {
        /// Change of a component of the unit normal, from one pixel to the next, up to which a mirror counts as flat
        /// [Preiner 2010, algorithm 3.3]. More forgives noisy normals; from 0.01 on it hides true bends, and from 0.03 on
        /// it fuses regions.
        planar_threshold: f32 = 0.0001, 0.0..=2.0, "per pixel";
        /// Distance between two pixels' tangent planes above which the mirror breaks off between them
        /// [Preiner 2010, algorithm 3.2, there a difference of depths].
        depth_step: f32 = 2.0, 0.0..=10000.0, "x spacing";
    }
}

/// Bent inwards from the previous pixel to this one.
pub const CONCAVE: u8 = 1;
/// Bent outwards.
pub const CONVEX: u8 = 2;
/// Not bent, or no previous pixel to compare with.
pub const PLANAR: u8 = 3;

/// Bits of the class along x. All four class bits are 0 where there is no mirror.
pub const X_CLASS: u8 = 0b0000_0011;
/// Bits of the class along y, [`Y_SHIFT`] up.
pub const Y_CLASS: u8 = 0b0000_1100;
/// Place of the class along y.
pub const Y_SHIFT: u32 = 2;
/// The mirror breaks off between the left pixel and this one.
pub const X_STEP: u8 = 1 << 4;
/// The mirror breaks off between the upper pixel and this one.
pub const Y_STEP: u8 = 1 << 5;

/// Sine of the angle, off the tangent planes, up to which the way to the next pixel follows the mirror however long it
/// is (1.1 degrees): so much the noise of the normals tilts them. Surfels seen at a flatter angle are not drawn.
pub const MIN_STEP_SINE: f32 = 0.02;

/// Along what the change of a normal is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Axes {
    /// Along the axes of a camera's screen, unit vectors, as the thesis does.
    Screen {
        /// To the right.
        right: Vec3,
        /// Down.
        down: Vec3,
    },
    /// From the previous pixel's mirror point to this one's: for an eye in every pixel, which have no screen in common.
    /// The sign is that of the mirror's normal curvature along the way.
    Way,
}

impl From<&Pinhole> for Axes {
    fn from(pinhole: &Pinhole) -> Self {
        Self::Screen {
            right: pinhole.right,
            down: -pinhole.up,
        }
    }
}

/// The mirror in one pixel.
#[derive(Debug, Clone, Copy)]
struct Sample {
    point: Vec3,
    normal: Vec3,
    spacing: f32,
}

impl Sample {
    /// The mirror at column `x`, row `y`, if there is one.
    fn at(surface: &Surface<Cpu>, x: usize, y: usize) -> Option<Self> {
        let point = surface.point.get(x, y)?;
        let normal = surface.normal.get(x, y)?;
        (point.w > 0.0).then_some(Self {
            point: point.xyz(),
            normal: normal.xyz(),
            spacing: normal.w,
        })
    }

    /// Whether the mirror breaks off between `previous` and this.
    fn breaks_off(&self, previous: &Self, depth_step: f32) -> bool {
        let way = self.point - previous.point;
        let gap = 0.5 * (self.normal + previous.normal).dot(way).abs();
        let limit = depth_step * self.spacing.max(previous.spacing);
        // What is not a number breaks off.
        !(gap <= limit.max(MIN_STEP_SINE * way.length()))
    }

    /// The class of the bend from `previous` to this along a unit vector, or along the way between them.
    fn bend(&self, previous: &Self, axis: Option<Vec3>, planar_threshold: f32) -> u8 {
        let axis = axis.unwrap_or_else(|| (self.point - previous.point).normalize_or_zero());
        let change = (self.normal - previous.normal).dot(axis);
        if change > planar_threshold {
            CONVEX
        } else if change < -planar_threshold {
            CONCAVE
        } else {
            PLANAR
        }
    }

    /// Class and step from `previous`, if there is one, to this.
    fn compare(
        &self,
        previous: Option<Self>,
        axis: Option<Vec3>,
        settings: &LhcSettings,
    ) -> (u8, bool) {
        match previous {
            None => (PLANAR, false),
            Some(p) if self.breaks_off(&p, settings.depth_step) => (PLANAR, true),
            Some(p) => (self.bend(&p, axis, settings.planar_threshold), false),
        }
    }
}

/// The curvature map of the mirrors on screen: a byte per pixel of [`X_CLASS`], [`Y_CLASS`], [`X_STEP`] and [`Y_STEP`],
/// 0 where there is no mirror.
pub fn curvature(surface: &Surface<Cpu>, axes: Axes, settings: &LhcSettings) -> Grid<u8> {
    let (right, down) = match axes {
        Axes::Screen { right, down } => (Some(right), Some(down)),
        Axes::Way => (None, None),
    };
    let pixel = |x: usize, y: usize| {
        let Some(here) = Sample::at(surface, x, y) else {
            return 0;
        };
        let previous = |x: Option<usize>, y: Option<usize>| Sample::at(surface, x?, y?);
        let left = previous(x.checked_sub(1), Some(y));
        let upper = previous(Some(x), y.checked_sub(1));
        let (x_class, x_step) = here.compare(left, right, settings);
        let (y_class, y_step) = here.compare(upper, down, settings);
        x_class
            | y_class << Y_SHIFT
            | if x_step { X_STEP } else { 0 }
            | if y_step { Y_STEP } else { 0 }
    };
    let mut map = Grid::new(surface.size, 0);
    let width = map.width().max(1);
    let rows = map.values_mut().par_chunks_mut(width).enumerate();
    rows.for_each(|(y, row)| {
        for (x, byte) in row.iter_mut().enumerate() {
            *byte = pixel(x, y);
        }
    });
    map
}

#[cfg(test)]
mod tests {
    use glam::{UVec2, Vec4};

    use super::*;
    use crate::reflect::Eye;

    const SCREEN: Axes = Axes::Screen {
        right: Vec3::X,
        down: Vec3::NEG_Y,
    };

    /// A mirror seen from the origin along -z, by what each ray (1 long along the axis) meets: point and normal.
    fn seen(mirror: impl Fn(Vec3) -> Option<(Vec3, Vec3)>) -> Surface<Cpu> {
        let size = UVec2::new(40, 30);
        let (mut point, mut normal) = (Grid::new(size, Vec4::ZERO), Grid::new(size, Vec4::ZERO));
        for i in 0..1200 {
            let (x, y) = ((i % 40) as f32 - 19.5, (i / 40) as f32 - 14.5);
            if let Some((p, n)) = mirror(Vec3::new(x / 40.0, -y / 40.0, -1.0)) {
                point.values_mut()[i] = p.extend(1.0);
                normal.values_mut()[i] = n.extend(0.01);
            }
        }
        let eye = Eye::Point(Vec3::ZERO);
        Surface {
            size,
            point,
            normal,
            eye,
        }
    }

    /// A ball of radius 0.5, 2 away; `side` -1 is its front, 1 the hollow behind.
    fn ball(ray: Vec3, side: f32) -> Option<(Vec3, Vec3)> {
        let centre = Vec3::new(0.0, 0.0, -2.0);
        let (a, b) = (ray.length_squared(), ray.dot(centre));
        let under = b * b - a * (centre.length_squared() - 0.25);
        let point = (under > 0.0).then(|| ray * ((b + side * under.sqrt()) / a))?;
        Some((point, (point - centre) / 0.5 * -side))
    }

    /// A plane through a point.
    fn plane(ray: Vec3, through: Vec3, normal: Vec3) -> (Vec3, Vec3) {
        (ray * (through.dot(normal) / ray.dot(normal)), normal)
    }

    /// Every byte of a map that is not 0, without those at the mirror's edge.
    fn inner(map: &Grid<u8>) -> Vec<u8> {
        let mut bytes = Vec::new();
        for y in 1..30 {
            for x in 1..40 {
                let at = |x, y| *map.get(x, y).unwrap();
                if at(x, y) != 0 && at(x - 1, y) != 0 && at(x, y - 1) != 0 {
                    bytes.push(at(x, y));
                }
            }
        }
        assert!(bytes.len() > 100, "{} pixels are too few", bytes.len());
        bytes
    }

    fn assert_all(map: &Grid<u8>, expected: u8) {
        let wrong = inner(map).into_iter().find(|&b| b != expected);
        assert_eq!(wrong, None, "expected {expected:06b}");
    }

    const BOTH_CONVEX: u8 = CONVEX | CONVEX << Y_SHIFT;
    const BOTH_CONCAVE: u8 = CONCAVE | CONCAVE << Y_SHIFT;
    const BOTH_PLANAR: u8 = PLANAR | PLANAR << Y_SHIFT;

    #[test]
    fn a_ball_is_convex_and_its_hollow_concave_both_ways() {
        for axes in [SCREEN, Axes::Way] {
            let map = |side| curvature(&seen(|r| ball(r, side)), axes, &LhcSettings::default());
            assert_all(&map(-1.0), BOTH_CONVEX);
            assert_all(&map(1.0), BOTH_CONCAVE);
        }
    }

    #[test]
    fn nothing_is_0() {
        let map = curvature(&seen(|_| None), SCREEN, &LhcSettings::default());
        assert!(map.values().iter().all(|&b| b == 0), "{map:?}");
    }

    #[test]
    fn a_plane_is_planar_and_whole_however_flat_it_is_seen() {
        for degrees in [0f32, 78.0, 88.0, 89.5] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let through = Vec3::new(-1.0, 0.0, -2.0);
            let normal = Vec3::new(sin, 0.0, cos);
            let surface = seen(|r| Some(plane(r, through, normal)).filter(|(p, _)| p.z < 0.0));
            assert_all(
                &curvature(&surface, SCREEN, &LhcSettings::default()),
                BOTH_PLANAR,
            );
        }
    }

    #[test]
    fn a_pane_before_another_breaks_off_where_it_ends() {
        let pane = |ray: Vec3| {
            let near = (ray.x < 0.0 && ray.y < 0.0) as u8 as f32;
            Some(plane(ray, Vec3::NEG_Z * (2.0 - 0.05 * near), Vec3::Z))
        };
        let map = curvature(&seen(pane), SCREEN, &LhcSettings::default());
        let at = |x, y| map.get(x, y).unwrap() & (X_STEP | Y_STEP);
        assert_eq!(at(20, 20), X_STEP, "to the right of the pane");
        assert_eq!(at(10, 15), Y_STEP, "where the pane begins below");
        assert_eq!(at(10, 20), 0, "on the pane");
        let forgiving = LhcSettings {
            depth_step: 6.0,
            ..Default::default()
        };
        assert_all(&curvature(&seen(pane), SCREEN, &forgiving), BOTH_PLANAR);
    }

    #[test]
    fn what_is_not_a_number_breaks_off() {
        let broken = |ray: Vec3| {
            let (p, n) = plane(ray, Vec3::NEG_Z, Vec3::Z);
            Some((if ray.x > 0.0 { p * f32::NAN } else { p }, n))
        };
        let map = curvature(&seen(broken), SCREEN, &LhcSettings::default());
        assert_eq!(*map.get(20, 5).unwrap(), BOTH_PLANAR | X_STEP | Y_STEP);
    }

    #[test]
    fn a_saddle_bends_one_way_along_x_and_the_other_along_y() {
        // z = -2 + (y^2 - x^2) / 2, found by fixed point iteration.
        let saddle = |ray: Vec3| {
            let mut p = ray * 2.0;
            for _ in 0..60 {
                p = ray * (2.0 - 0.5 * (p.y * p.y - p.x * p.x));
            }
            Some((p, Vec3::new(p.x, -p.y, 1.0).normalize()))
        };
        let map = curvature(&seen(saddle), Axes::Way, &LhcSettings::default());
        assert_all(&map, CONVEX | CONCAVE << Y_SHIFT);
    }
}
