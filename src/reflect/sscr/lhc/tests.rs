use glam::UVec2;
use proptest::prelude::*;

use super::super::curvature::{CONCAVE, CONVEX, PLANAR, X_STEP, Y_SHIFT, Y_STEP};
use super::*;

/// The 4-connected regions by a plain flood fill: labels from 1 on, in the order of the first pixels.
fn flood(cells: &Grid<u8>, class: impl Fn(u8) -> u8) -> Grid<u32> {
    let (w, h) = (cells.width(), cells.height());
    let mut labels = Grid::new(cells.size(), 0);
    let at = |x: usize, y: usize| *cells.get(x, y).unwrap();
    let joined = |(x, y): (usize, usize), (u, v): (usize, usize)| {
        let later = at(x.max(u), y.max(v));
        let step = if x == u { Y_STEP } else { X_STEP };
        class(at(x, y)) == class(at(u, v)) && later & step == 0
    };
    let mut next = 0;
    for i in 0..w * h {
        if class(cells.values()[i]) == 0 || labels.values()[i] != 0 {
            continue;
        }
        next += 1;
        let mut stack = vec![i];
        while let Some(j) = stack.pop() {
            if std::mem::replace(&mut labels.values_mut()[j], next) != 0 {
                continue;
            }
            let (x, y) = (j % w, j / w);
            let mut neighbours = vec![(x, y + 1), (x + 1, y)];
            neighbours.extend(x.checked_sub(1).map(|u| (u, y)));
            neighbours.extend(y.checked_sub(1).map(|v| (x, v)));
            for (u, v) in neighbours {
                if u < w && v < h && joined((x, y), (u, v)) && labels.values()[v * w + u] == 0 {
                    stack.push(v * w + u);
                }
            }
        }
    }
    labels
}

/// What is wrong with a map's list of regions, judged by its labels alone.
fn wrong_regions(map: &LhcMap) -> Option<String> {
    let mut tallies = vec![Tally::EMPTY; map.regions.len()];
    for (i, &label) in map.labels.values().iter().enumerate() {
        if label == 0 {
            continue;
        }
        let region = label as usize - 1;
        let Some(tally) = tallies.get_mut(region) else {
            return Some(format!("label {label} has no region"));
        };
        let (x, y) = (i % map.labels.width(), i / map.labels.width());
        tally.add(x, x + 1, y);
    }
    let total: u32 = tallies.iter().map(|t| t.pixels).sum();
    let mut sum = 0.0;
    for (k, (region, tally)) in map.regions.iter().zip(&tallies).enumerate() {
        sum += region.weight;
        let share = tally.pixels as f32 / total as f32;
        if (region.pixels, region.bounds) != (tally.pixels, tally.bounds) {
            return Some(format!("region {k} is {tally:?}, not {region:?}"));
        }
        if (region.weight - share).abs() > 1e-6 || (region.accumulated_weight - sum).abs() > 1e-4 {
            return Some(format!(
                "region {k} weighs {share}, all to it {sum}: {region:?}"
            ));
        }
    }
    let last = map.regions.last().map_or(1.0, |r| r.accumulated_weight);
    if last.to_bits() != 1f32.to_bits() {
        return Some(format!("the weights add up to {last}"));
    }
    let pixels = |k: usize| tallies[k].pixels;
    let late = (1..tallies.len()).find(|&k| pixels(k - 1) < pixels(k));
    late.map(|k| format!("region {k} comes too late"))
}

/// The first region of a size whose first pixel lies before that of the region listed before it.
fn late_region(map: &LhcMap) -> Option<usize> {
    let first = |k: usize| {
        map.labels
            .values()
            .iter()
            .position(|&l| l as usize == k + 1)
    };
    let same_size = |k: usize| map.regions[k - 1].pixels == map.regions[k].pixels;
    (1..map.regions.len()).find(|&k| same_size(k) && first(k - 1) > first(k))
}

/// The first pixel in which two maps disagree about which pixels belong together.
fn disagreement(a: &Grid<u32>, b: &Grid<u32>) -> Option<usize> {
    let mut forth = std::collections::HashMap::new();
    let mut back = std::collections::HashMap::new();
    (a.values().iter().zip(b.values())).position(|(&x, &y)| {
        *forth.entry(x).or_insert(y) != y
            || *back.entry(y).or_insert(x) != x
            || (x == 0) != (y == 0)
    })
}

/// Maps of classes 0 to `classes`, some with steps.
fn cells(classes: u8) -> impl Strategy<Value = Grid<u8>> {
    (1u32..14, 1u32..14, 1u32..20).prop_flat_map(move |(w, h, rarity)| {
        let step = move |bit: u8| (0..rarity).prop_map(move |r| if r == 0 { bit } else { 0 });
        let cell = (0..=classes, step(X_STEP), step(Y_STEP));
        let cell = cell.prop_map(|(class, x, y)| if class == 0 { 0 } else { class | x | y });
        let all = proptest::collection::vec(cell, (w * h) as usize);
        all.prop_map(move |values| Grid::from_vec(UVec2::new(w, h), values).unwrap())
    })
}

/// Curvature maps of every class, some with steps.
fn curvature_maps() -> impl Strategy<Value = Grid<u8>> {
    (cells(3), cells(3)).prop_map(|(x, y)| {
        let mut map = x.clone();
        for (i, byte) in map.values_mut().iter_mut().enumerate() {
            let y_class = y.values().get(i).map_or(PLANAR, |&c| (c & PLANAR).max(1));
            *byte |= if *byte == 0 { 0 } else { y_class << Y_SHIFT };
        }
        map
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn labels_are_those_of_a_flood_fill(cells in prop_oneof![cells(1), cells(3)]) {
        let class = |c: u8| c & 0xf;
        let mut labeller = Labeller::default();
        let map = labeller.label(&cells, class);
        prop_assert_eq!(disagreement(&map.labels, &flood(&cells, class)), None);
        prop_assert_eq!(wrong_regions(map), None);
        prop_assert_eq!(late_region(map), None);
    }

    #[test]
    fn suppressed_pixels_are_filled_and_the_others_flooded(map in curvature_maps()) {
        let mut labeller = Labeller::default();
        labeller.lhc(&map);
        let (cells, lhc) = (labeller.cells, labeller.map);
        let open = |c: u8| u8::from(c != 0 && c & SUPPRESSED == 0);
        let mut labels = lhc.labels.clone();
        for (label, &cell) in labels.values_mut().iter_mut().zip(cells.values()) {
            *label *= u32::from(open(cell));
        }
        prop_assert_eq!(disagreement(&labels, &flood(&cells, open)), None);
        prop_assert_eq!(wrong_regions(&lhc), None);
        // What has no label has no neighbour with one, but across a step.
        let all = flood(&cells, |c| u8::from(c != 0));
        let labelled: std::collections::HashSet<u32> = all.values().iter().zip(lhc.labels.values())
            .filter_map(|(&piece, &label)| (label != 0).then_some(piece)).collect();
        for (&piece, &label) in all.values().iter().zip(lhc.labels.values()) {
            prop_assert!(piece == 0 || label != 0 || !labelled.contains(&piece));
        }
    }

    #[test]
    fn a_flipped_label_is_caught(cells in cells(2), pick in any::<prop::sample::Index>()) {
        let class = |c: u8| c & 0xf;
        let mut labeller = Labeller::default();
        let map = labeller.label(&cells, class);
        let mut flipped = map.labels.clone();
        let i = pick.index(flipped.values().len());
        flipped.values_mut()[i] = if flipped.values()[i] == 0 { 1 } else { 0 };
        prop_assert!(disagreement(&flipped, &flood(&cells, class)).is_some());
        let flipped = LhcMap { labels: flipped, regions: map.regions.clone() };
        prop_assert!(wrong_regions(&flipped).is_some());
    }
}

#[test]
fn a_hole_under_a_thin_edge_does_not_split_its_region() {
    // The pixels above the hole lie on the outer contour too; the one in its corner is reached from its contour alone.
    let ring = [1, 1, 1, 1, 1, 0, 0, 1, 1, 0, 1, 1, 1, 1, 1, 1].to_vec();
    let cells = Grid::from_vec(UVec2::splat(4), ring).unwrap();
    let mut labeller = Labeller::default();
    assert_eq!(labeller.label(&cells, |c| c).regions.len(), 1);
}

/// A mirror of one class everywhere.
fn full(size: UVec2) -> Grid<u8> {
    Grid::new(size, CONVEX | CONVEX << Y_SHIFT)
}

#[test]
fn a_mirror_that_fills_the_screen_is_one_region() {
    let mut labeller = Labeller::default();
    let map = labeller.lhc(&full(UVec2::new(80, 60)));
    assert_eq!(map.regions.len(), 1);
    assert_eq!(map.regions[0].pixels, 4800);
}

#[test]
fn nothing_has_no_region() {
    let mut labeller = Labeller::default();
    for size in [
        UVec2::ZERO,
        UVec2::new(0, 7),
        UVec2::new(7, 0),
        UVec2::splat(9),
    ] {
        let map = labeller.lhc(&Grid::new(size, 0));
        assert_eq!(map.regions.len(), 0, "{size}");
        assert_eq!(map.labels.size(), size);
    }
}

#[test]
fn one_pixel_is_no_region_and_four_are_one() {
    let mut labeller = Labeller::default();
    assert_eq!(labeller.lhc(&full(UVec2::ONE)).regions.len(), 0);
    let map = labeller.lhc(&full(UVec2::splat(2)));
    assert_eq!(map.labels.values(), [1; 4]);
}

#[test]
fn a_labeller_forgets_the_picture_before() {
    let mut used = Labeller::default();
    used.lhc(&full(UVec2::splat(20)));
    let mut map = full(UVec2::splat(20));
    map.values_mut()[205..].fill(0);
    let fresh = Labeller::default().lhc(&map).clone();
    assert_eq!(used.lhc(&map), &fresh);
}

#[test]
fn ten_thousand_regions_stay_ten_thousand() {
    // Squares of 6 x 6 pixels, convex and concave by turns.
    let size = UVec2::splat(600);
    let mut map = full(size);
    for (i, byte) in map.values_mut().iter_mut().enumerate() {
        let (x, y) = (i % 600, i / 600);
        if (x / 6 + y / 6) % 2 == 1 {
            *byte = CONCAVE | CONCAVE << Y_SHIFT;
        }
    }
    let mut labeller = Labeller::default();
    let lhc = labeller.lhc(&map);
    assert_eq!(lhc.regions.len(), 10_000);
    assert!(
        lhc.labels.values().iter().all(|&l| l > 0),
        "a pixel has no label"
    );
}
