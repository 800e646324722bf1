//! Pass `settle`: puts what closed holes of mirrors show to where the nearest found pixel around lies. CPU twin of
//! `shaders/settle.wgsl`.
//!
//! Closing gives a hole the mean distance of other rays. Along its own ray that ends before or behind the surface, most of all at
//! the rim of a curved mirror, where neighbours look far apart: behind it, every light is in shadow.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::receivers::Receivers;
use crate::backend::cpu::Cpu;
use crate::error::Result;
use crate::gbuffer::column_row;
use crate::grid::Grid;
use crate::job::Job;

/// How far a found pixel may be, pixels: what the third level of closing spans.
pub const REACH: i32 = 8;

/// Cosine between normals above which a found pixel shows the same surface.
pub const NORMAL_COSINE: f32 = 0.5;

fn dot(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Positions of `receivers`, settled where `level` says that a pixel was closed.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn settle(receivers: &Receivers<Cpu>, level: &Grid<f32>, job: &Job) -> Result<Grid<Vec4>> {
    let size = receivers.size.as_ivec2();
    let (positions, normals) = (receivers.position.values(), receivers.normal.values());
    let level = level.values();
    let mut settled = Grid::new(receivers.size, Vec4::ZERO);
    let place = |i: usize| {
        let mut place = positions[i];
        if !(place.w > 0.0 && level[i] > 0.0) {
            return place;
        }
        let normal = normals[i].truncate();
        let (x, y) = column_row(i, size.x as usize);
        let mut nearest = REACH * REACH + 1;
        for v in (y - REACH).max(0)..=(y + REACH).min(size.y - 1) {
            for u in (x - REACH).max(0)..=(x + REACH).min(size.x - 1) {
                let far = (u - x) * (u - x) + (v - y) * (v - y);
                let there = (v * size.x + u) as usize;
                let found = positions[there].w > 0.0 && level[there] <= 0.0;
                let alike = || dot(normal, normals[there].truncate()) > NORMAL_COSINE;
                if far < nearest && found && alike() {
                    nearest = far;
                    place = positions[there];
                }
            }
        }
        place
    };
    let values = settled.values_mut().par_iter_mut().enumerate();
    values.for_each(|(i, out)| {
        if !job.is_cancelled() {
            *out = place(i);
        }
    });
    job.check()?;
    Ok(settled)
}
