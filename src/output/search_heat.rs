//! Where the searches end, as EXR layers and as a picture.

use glam::UVec2;

use super::exr::ExrImage;
use crate::grid::Grid;
use crate::reflect::sscr::heat::HeatSums;

/// Share of the pixels that show something up to which the colours tell values apart: single hot ones would darken all
/// others.
const BRIGHTEST: f64 = 0.95;

/// From little to much, of even steps to the eye also in grey: viridis [van der Walt and Smith 2015], nine of its colours,
/// sRGB.
const COLOURS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// The heat as channels steps.V and residual.V (on average over the points found), misses.V and count.V (points lost and
/// found).
pub fn search_heat(heat: &Grid<HeatSums>) -> ExrImage {
    let mut image = ExrImage::new(heat.size());
    let mut layer = |name: &str, value: fn(&HeatSums) -> f32| {
        image.add_channels(name, "V", |_| heat.values().iter().map(value).collect());
    };
    layer("steps", HeatSums::mean_steps);
    layer("misses", |sums| sums.lost as f32);
    layer("residual", HeatSums::mean_residual);
    layer("count", |sums| sums.found as f32);
    image
}

/// Three pictures side by side: steps, misses and residual, from dark (0) to bright (what 95 in 100 pixels stay below).
/// Black is where no search ended, or, of steps and residual, where none found its point.
pub fn search_heat_picture(heat: &Grid<HeatSums>) -> Grid<[u8; 4]> {
    let found = |sums: &HeatSums| sums.found > 0;
    let panels = [
        panel(heat, found, HeatSums::mean_steps),
        panel(
            heat,
            |sums| sums.found + sums.lost > 0,
            |sums| sums.lost as f32,
        ),
        panel(heat, found, HeatSums::mean_residual),
    ];
    let size = UVec2::new(heat.size().x * panels.len() as u32, heat.size().y);
    let mut picture = Grid::new(size, [0, 0, 0, 255]);
    let (width, row) = (heat.width(), size.x as usize);
    for (i, panel) in panels.iter().enumerate() {
        let rows = picture.values_mut().chunks_exact_mut(row.max(1));
        for (out, from) in rows.zip(panel.chunks_exact(width.max(1))) {
            out[i * width..(i + 1) * width].copy_from_slice(from);
        }
    }
    picture
}

fn panel(
    heat: &Grid<HeatSums>,
    shown: impl Fn(&HeatSums) -> bool,
    value: impl Fn(&HeatSums) -> f32,
) -> Vec<[u8; 4]> {
    let mut values: Vec<f32> = heat
        .values()
        .iter()
        .filter(|s| shown(s))
        .map(&value)
        .collect();
    let last = (values.len() as f64 * BRIGHTEST) as usize;
    let brightest = if values.is_empty() {
        0.0
    } else {
        *values.select_nth_unstable_by(last, f32::total_cmp).1
    };
    let colour_of = |sums: &HeatSums| {
        if !shown(sums) {
            return [0, 0, 0, 255];
        }
        let part = if brightest > 0.0 {
            value(sums) / brightest
        } else {
            0.0
        };
        let [r, g, b] = heat_colour(part);
        [r, g, b, 255]
    };
    heat.values().iter().map(colour_of).collect()
}

/// The colour (sRGB) of a value from 0, dark, to 1, bright.
pub fn heat_colour(value: f32) -> [u8; 3] {
    let place = value.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f32;
    let first = (place as usize).min(COLOURS.len() - 2);
    let part = place - first as f32;
    let (a, b) = (COLOURS[first], COLOURS[first + 1]);
    std::array::from_fn(|i| {
        let (a, b) = (f32::from(a[i]), f32::from(b[i]));
        (a + (b - a) * part + 0.5) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reflect::sscr::heat::RESIDUAL_SCALE;

    /// Two pixels of 2x1: nothing, and three searches.
    fn heat() -> Grid<HeatSums> {
        let sums = HeatSums {
            steps: 9,
            residual: (RESIDUAL_SCALE * 0.5) as u64,
            found: 2,
            lost: 1,
        };
        Grid::from_vec(UVec2::new(2, 1), vec![HeatSums::default(), sums]).expect("two pixels")
    }

    #[test]
    fn layers_are_means_over_what_was_found_and_counts() {
        let image = search_heat(&heat());
        let of = |name: &str| image.channels[name].clone();
        assert_eq!(of("steps.V"), [0.0, 4.5]);
        assert_eq!(of("residual.V"), [0.0, 0.25]);
        assert_eq!(of("misses.V"), [0.0, 1.0]);
        assert_eq!(of("count.V"), [0.0, 2.0]);
    }

    #[test]
    fn a_picture_has_three_panels_black_where_no_search_ended() {
        let picture = search_heat_picture(&heat());
        assert_eq!(picture.size(), UVec2::new(6, 1));
        let [black, bright] = [[0, 0, 0, 255], [253, 231, 37, 255]];
        assert_eq!(
            picture.values(),
            [black, bright, black, bright, black, bright]
        );
    }

    #[test]
    fn colours_get_lighter_with_the_value() {
        let light = |value: f32| {
            let [r, g, b] = heat_colour(value).map(f32::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let all: Vec<f32> = (0..=100u8).map(|i| light(f32::from(i) / 100.0)).collect();
        assert!(all.windows(2).all(|w| w[0] <= w[1]), "{all:?}");
        assert_eq!(heat_colour(f32::INFINITY), heat_colour(1.0));
    }
}
