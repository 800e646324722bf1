//! Pass `pull_push`: holes in the mirrors' picture are filled from coarser and coarser averages of what surrounds them
//! [Preiner 2010, sections 3.6 and 4.6; Grossman and Dally 1998].

use glam::{UVec2, Vec3};

use super::average::Pixel;
use crate::backend::cpu::Cpu;
use crate::error::Result;
use crate::grid::Grid;
use crate::job::Job;
use crate::reflect::MirrorGBuffer;

/// The average of what the pixels below show; class and weight say what it may be blended with.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    pixel: Pixel,
    /// Relative to the scene's origin.
    position: Vec3,
    weight: f32,
}

/// Mirrors and other points never blend: the class of most of the four, of the others where both have as many.
fn pull(below: [Cell; 4]) -> Cell {
    let of = |mirror: bool| {
        below
            .iter()
            .filter(move |c| c.weight > 0.0 && (c.pixel.albedo.w > 0.0) == mirror)
    };
    let weight = |mirror: bool| of(mirror).map(|c| c.weight).sum::<f32>();
    let mirror = weight(true) > weight(false);
    let total = weight(mirror);
    if total <= 0.0 {
        return Cell::default();
    }
    let (mut sum, mut position) = (Pixel::default(), Vec3::ZERO);
    for cell in of(mirror) {
        let share = cell.weight / total;
        sum.surface += cell.pixel.surface * share;
        sum.albedo += cell.pixel.albedo * share;
        sum.material += cell.pixel.material * share;
        position += cell.position * share;
    }
    let normal = sum.surface.truncate().normalize_or(Vec3::Z);
    sum.surface = normal.extend(sum.surface.w);
    // Coarser levels count pixels, not weight: a lone pixel fills as well as four.
    Cell {
        pixel: sum,
        position,
        weight: total.min(1.0),
    }
}

/// Fills every pixel of a mirror that shows nothing from the finest of `levels` halvings that does, and notes which.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn pull_push(mirror: &mut MirrorGBuffer<Cpu>, levels: u32, job: &Job) -> Result<()> {
    if levels == 0 {
        return job.check();
    }
    // Pull.
    let finest = (0..mirror.material.values().len())
        .map(|i| {
            let Some(pixel) = mirror.at(i) else {
                return Cell::default();
            };
            let [origin, direction] =
                [&mirror.origin, &mirror.direction].map(|g| g.values()[i].truncate());
            Cell {
                pixel,
                position: origin + direction * pixel.surface.w,
                weight: 1.0,
            }
        })
        .collect();
    let Some(finest) = Grid::from_vec(mirror.size(), finest) else {
        return Ok(());
    };
    let mut pyramid = vec![finest];
    for _ in 0..levels {
        job.check()?;
        let Some(below) = pyramid.last() else { break };
        let size = UVec2::new(below.size().x.div_ceil(2), below.size().y.div_ceil(2));
        let at = |x: usize, y: usize| below.get(x, y).copied().unwrap_or_default();
        let width = size.x.max(1) as usize;
        let cells = (0..width * size.y as usize)
            .map(|i| {
                let (x, y) = (i % width * 2, i / width * 2);
                pull([at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)])
            })
            .collect();
        let Some(level) = Grid::from_vec(size, cells) else {
            break;
        };
        pyramid.push(level);
    }

    // Push.
    job.check()?;
    let width = mirror.origin.width();
    for i in 0..mirror.material.values().len() {
        if mirror.origin.values()[i].w == 0.0 || mirror.material.values()[i].w > 0.0 {
            continue;
        }
        let (x, y) = (i % width, i / width);
        let found = pyramid
            .iter()
            .enumerate()
            .skip(1)
            .find_map(|(level, cells)| {
                let cell = cells.get(x >> level, y >> level)?;
                (cell.weight > 0.0).then_some((level, *cell))
            });
        if let Some((level, cell)) = found {
            let normal = cell.pixel.surface.truncate();
            let distance = distance_to(mirror, i, cell.position, normal);
            let filled = Pixel {
                surface: normal.extend(distance),
                material: cell.pixel.material.truncate().extend(1.0),
                ..cell.pixel
            };
            mirror.show(i, filled);
            mirror.level.values_mut()[i] = level as f32;
        }
    }
    Ok(())
}

/// Where the ray of the value `index` meets the plane of that position and normal; the distance of the position itself
/// where it meets it too flatly.
fn distance_to(mirror: &MirrorGBuffer<Cpu>, index: usize, position: Vec3, normal: Vec3) -> f32 {
    let to_position = position - mirror.origin.values()[index].truncate();
    let met = normal.dot(to_position) / normal.dot(mirror.direction.values()[index].truncate());
    let own = to_position.length();
    if met > 0.5 * own && met < 2.0 * own {
        met
    } else {
        own
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;

    use crate::reflect::{Eye, Surface};

    fn mirror(size: UVec2, shown: &[usize]) -> MirrorGBuffer<Cpu> {
        let surface = Surface {
            size,
            point: Grid::new(size, Vec4::ONE),
            normal: Grid::new(size, Vec4::Z),
            eye: Eye::Point(Vec3::splat(2.0)),
        };
        let mut mirror = MirrorGBuffer::of(&surface);
        for &i in shown {
            let pixel = Pixel {
                surface: Vec4::new(0.0, 0.0, 1.0, 2.0),
                albedo: Vec4::new(0.5, 0.25, 0.125, 0.0),
                material: Vec4::new(0.0, 0.0, 0.01, 1.0),
            };
            mirror.show(i, pixel);
        }
        mirror
    }

    #[test]
    fn a_hole_is_filled_from_the_finest_level_that_shows_something() {
        let size = UVec2::new(8, 8);
        let mut filled = mirror(size, &[0]);
        pull_push(&mut filled, 3, &Job::default()).unwrap();
        let level = |x: usize, y: usize| filled.level.values()[y * 8 + x];
        assert_eq!(
            [level(0, 0), level(1, 1), level(3, 2), level(7, 7)],
            [0.0, 1.0, 2.0, 3.0]
        );
        assert_eq!(filled.coverage().covered, 64);
        assert_eq!(
            filled.at(63).map(|p| p.albedo),
            filled.at(0).map(|p| p.albedo)
        );
    }

    #[test]
    fn holes_wider_than_the_coarsest_level_stay() {
        let mut filled = mirror(UVec2::new(8, 8), &[0]);
        pull_push(&mut filled, 1, &Job::default()).unwrap();
        assert_eq!(filled.coverage().covered, 4);
    }

    #[test]
    fn nothing_is_filled_where_there_is_no_mirror() {
        let mut filled = mirror(UVec2::new(4, 4), &[0]);
        filled.origin.values_mut()[1].w = 0.0;
        pull_push(&mut filled, 2, &Job::default()).unwrap();
        assert!(
            filled.at(1).is_none(),
            "a pixel without mirror shows something"
        );
    }
}
