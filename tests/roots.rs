//! The search's oracle: where the mirrors of an analytic scene show a point, all places of it, in f64. It shares no code
//! with the program.
//!
//! For a point the error of the reflected direction is taken at every mirror pixel, as the difference of two stereographic
//! projections; every cell of 2x2 pixels is two triangles, and one whose errors surround zero holds a root. Newton steps on
//! the analytic surface then move it to its place, and look for others in cells whose errors come near to zero. Roots in
//! cells that leave the mirror are not counted.

use glam::{DMat2, DVec2, DVec3};
use libtest_mimic::Trial;
use rayon::prelude::*;

use crate::analytic::{Hit, Kind, Oracle, View, reflect};
use crate::support::claim;

pub(crate) fn tests() -> Vec<Trial> {
    vec![
        claim(
            "roots::the_ray_of_every_root_meets_its_point",
            the_ray_of_every_root_meets_its_point,
        ),
        claim(
            "roots::a_flat_mirror_shows_a_point_once_where_the_mirrored_camera_sees_it",
            a_flat_mirror_shows_a_point_once,
        ),
        claim(
            "roots::whatever_a_pixel_shows_has_a_root_there",
            whatever_a_pixel_shows_has_a_root_there,
        ),
        claim("roots::measures_see_wrong_hits", measures_see_wrong_hits),
    ]
}

/// A place where the mirror shows a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Root {
    /// Pixels (centres at + 0.5).
    pub(crate) pixel: DVec2,
    /// Whether nothing stands between mirror and point.
    pub(crate) visible: bool,
}

/// The mirror at a pixel.
#[derive(Debug, Clone, Copy)]
struct Mirror {
    number: usize,
    position: DVec3,
    /// Mirror space: right, up, to the eye.
    axes: [DVec3; 3],
    /// Stereographic projection of the reflected direction.
    reflected: DVec2,
}

/// What the mirrors of a view show.
pub(crate) struct Roots {
    oracle: Oracle,
    view: View,
    /// The pixels that show a mirror.
    mirrors: Vec<Mirror>,
    /// The cells that lie on one mirror: their corners among `mirrors`, and where the first corner is.
    cells: Vec<([usize; 4], DVec2)>,
    /// Whether each pixel is the first corner of such a cell.
    whole: Vec<bool>,
}

/// Farthest that Newton steps may move a root from where they start, pixels.
const FARTHEST: f64 = 2.0;

/// Roots nearer to each other than this are one, pixels.
const SAME: f64 = 0.3;

impl Roots {
    /// The mirrors of a scene as seen in `view`, whose pixels' centres show `hits`.
    pub(crate) fn new(oracle: Oracle, view: View, hits: &[Hit]) -> Self {
        let mut mirrors = Vec::new();
        let slots: Vec<Option<usize>> = hits
            .iter()
            .map(|hit| {
                let mirror = mirror(&view, hit)?;
                mirrors.push(mirror);
                Some(mirrors.len() - 1)
            })
            .collect();
        let w = view.width;
        let cell = |i: usize| {
            let corners = [slots[i]?, slots[i + 1]?, slots[i + w]?, slots[i + w + 1]?];
            let number = mirrors[corners[0]].number;
            let one = corners.iter().all(|&k| mirrors[k].number == number);
            let first = DVec2::new((i % w) as f64 + 0.5, (i / w) as f64 + 0.5);
            one.then_some((corners, first))
        };
        let mut whole = vec![false; slots.len()];
        let mut cells = Vec::new();
        for i in (0..w * (view.height - 1)).filter(|i| i % w + 1 < w) {
            if let Some(cell) = cell(i) {
                whole[i] = true;
                cells.push(cell);
            }
        }
        Self {
            oracle,
            view,
            mirrors,
            cells,
            whole,
        }
    }

    /// All places where the mirrors show the point.
    pub(crate) fn of(&self, point: DVec3) -> Vec<Root> {
        let errors: Vec<DVec2> = self.mirrors.iter().map(|m| m.error(point)).collect();
        let mut roots: Vec<Root> = Vec::new();
        for &(corners, corner) in &self.cells {
            let [a, b, c, d] = corners.map(|k| errors[k]);
            if !may_vanish([a, b, c, d]) {
                continue;
            }
            let first = surrounds_zero(a, b, c).map(|(u, v)| corner + DVec2::new(u, v));
            let second =
                surrounds_zero(d, c, b).map(|(u, v)| corner + DVec2::ONE - DVec2::new(u, v));
            // Where the mirror folds its picture, triangles are slivers that roots slip out of.
            let middle = first.or(second).is_none().then_some(corner + 0.5);
            for start in [first, second, middle].into_iter().flatten() {
                let Some(root) = self.polished(start, point) else {
                    continue;
                };
                let known = roots.iter().any(|r| r.pixel.distance(root.pixel) <= SAME);
                if !known && self.in_whole_cell(root.pixel) {
                    roots.push(root);
                }
            }
        }
        roots
    }

    /// Whether a place lies between four pixels of one mirror.
    fn in_whole_cell(&self, pixel: DVec2) -> bool {
        let corner = pixel - 0.5;
        corner.min_element() >= 0.0 && {
            let index = corner.y as usize * self.view.width + corner.x as usize;
            self.whole.get(index).copied().unwrap_or(false)
        }
    }

    /// The mirror at any place of the picture.
    fn at(&self, pixel: DVec2) -> Option<Mirror> {
        let inside = pixel.x >= 0.0
            && pixel.y >= 0.0
            && pixel.x <= self.view.width as f64
            && pixel.y <= self.view.height as f64;
        let hit = || {
            self.oracle
                .cast(self.view.position, self.view.through(pixel))
        };
        inside.then(hit).and_then(|hit| mirror(&self.view, &hit))
    }

    /// Newton steps on the analytic surface; `None` where they lead elsewhere.
    fn polished(&self, start: DVec2, point: DVec3) -> Option<Root> {
        const H: f64 = 1e-4;
        let mut pixel = start;
        for _ in 0..15 {
            let mirror = self.at(pixel)?;
            let error = mirror.error(point);
            let slope = |d: DVec2| {
                let forth = self.at(pixel + d).map(|m| (m.error(point) - error) / H);
                forth.or_else(|| Some((error - self.at(pixel - d)?.error(point)) / H))
            };
            let jacobian = DMat2::from_cols(slope(DVec2::X * H)?, slope(DVec2::Y * H)?);
            if jacobian.determinant().abs() < 1e-18 {
                return None;
            }
            let step = -(jacobian.inverse() * error);
            if step.length() < 1e-7 {
                return Some(self.root(pixel, &mirror, point));
            }
            // Back into the mirror, where a step leaves it.
            let mut damped = step.clamp_length_max(1.0);
            while self.at(pixel + damped).is_none() {
                damped *= 0.5;
                if damped.length() < 0.02 {
                    return None;
                }
            }
            pixel += damped;
            if pixel.distance(start) > FARTHEST {
                return None;
            }
        }
        None
    }

    fn root(&self, pixel: DVec2, mirror: &Mirror, point: DVec3) -> Root {
        let seen = self.oracle.cast(mirror.position, mirror.direction());
        let distance = mirror.position.distance(point);
        Root {
            pixel,
            visible: mirror.position.distance(seen.position) > distance - 1e-4,
        }
    }
}

/// The mirror of a hit.
fn mirror(view: &View, hit: &Hit) -> Option<Mirror> {
    let Kind::Mirror(number) = hit.kind else {
        return None;
    };
    let right = (view.target - view.position).cross(view.up).normalize();
    let z = (view.position - hit.position).normalize();
    let x = (right - z * right.dot(z)).normalize();
    let axes = [x, z.cross(x), z];
    let [nx, ny, nz] = axes.map(|axis| axis.dot(hit.normal));
    Some(Mirror {
        number,
        position: hit.position,
        axes,
        reflected: DVec2::new(nx, ny) / nz,
    })
}

impl Mirror {
    /// Zero where the mirror shows the point.
    fn error(&self, point: DVec3) -> DVec2 {
        let to_point = point - self.position;
        let [x, y, z] = self.axes.map(|axis| axis.dot(to_point));
        self.reflected - DVec2::new(x, y) / (to_point.length() + z)
    }

    /// Unit direction of the reflected ray.
    fn direction(&self) -> DVec3 {
        // The inverse of the stereographic projection.
        let s = self.reflected;
        let z = 2.0 / (1.0 + s.length_squared());
        let [x, y, eye] = self.axes;
        (x * s.x + y * s.y + eye) * z - eye
    }
}

/// Whether a field with these values at the corners of a cell may vanish in it, or a little beside it.
fn may_vanish(corners: [DVec2; 4]) -> bool {
    let low = corners.into_iter().fold(DVec2::INFINITY, DVec2::min);
    let high = corners.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
    let margin = (high - low) * 0.1;
    (low - margin).max_element() <= 0.0 && (high + margin).min_element() >= 0.0
}

/// Where in the triangle (0, 0), (1, 0), (0, 1) a field with the values `a`, `b`, `c` at its corners vanishes.
fn surrounds_zero(a: DVec2, b: DVec2, c: DVec2) -> Option<(f64, f64)> {
    let (ab, ac) = (b - a, c - a);
    let area = ab.perp_dot(ac);
    let (u, v) = (-a.perp_dot(ac) / area, a.perp_dot(ab) / area);
    // A root on a shared edge belongs to both: the second is the same.
    (u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9).then_some((u, v))
}

/// A search's hits against the roots.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Quality {
    /// Points with a hit, part of all points.
    pub(crate) hit_rate: f64,
    /// Points with a root, part of all points.
    pub(crate) findable: f64,
    /// Points with a correct hit, part of those with a root.
    pub(crate) recall: f64,
    /// Roots with a hit, part of all roots.
    pub(crate) root_recall: f64,
    /// Hits farther than [`WRONG`] from every root of their point, part of all hits.
    pub(crate) false_hits: f64,
    /// Distance of correct hits from their root, pixels: half are nearer.
    pub(crate) median: f64,
    /// 95 % are nearer.
    pub(crate) p95: f64,
}

/// A hit this far from every root of its point is false, pixels.
const WRONG: f64 = 4.0;

/// Measures hits: for every point its roots and where it was found.
pub(crate) fn quality(points: &[(Vec<Root>, Vec<DVec2>)]) -> Quality {
    let nearest = |roots: &[Root], hit: &DVec2| {
        let distances = roots.iter().map(|r| r.pixel.distance(*hit));
        distances.fold(f64::INFINITY, f64::min)
    };
    let (mut findable, mut with_hit, mut recalled) = (0, 0, 0);
    let (mut roots_in_all, mut roots_found, mut hits_in_all, mut wrong) = (0, 0, 0, 0);
    let mut errors = Vec::new();
    for (roots, hits) in points {
        findable += usize::from(!roots.is_empty());
        with_hit += usize::from(!hits.is_empty());
        roots_in_all += roots.len();
        hits_in_all += hits.len();
        let distances: Vec<f64> = hits.iter().map(|hit| nearest(roots, hit)).collect();
        let correct = distances.iter().filter(|d| **d <= WRONG);
        wrong += hits.len() - correct.clone().count();
        recalled += usize::from(correct.clone().count() > 0);
        errors.extend(correct);
        let found = |root: &&Root| hits.iter().any(|hit| hit.distance(root.pixel) <= WRONG);
        roots_found += roots.iter().filter(found).count();
    }
    errors.sort_by(f64::total_cmp);
    let quantile = |part: f64| {
        let last = errors.len().saturating_sub(1) as f64;
        errors
            .get((last * part) as usize)
            .copied()
            .unwrap_or(f64::NAN)
    };
    let part = |count: usize, all: usize| count as f64 / all.max(1) as f64;
    Quality {
        hit_rate: part(with_hit, points.len()),
        findable: part(findable, points.len()),
        recall: part(recalled, findable),
        root_recall: part(roots_found, roots_in_all),
        false_hits: part(wrong, hits_in_all),
        median: quantile(0.5),
        p95: quantile(0.95),
    }
}

/// A view of a scene, four pixels wide to three high.
fn seen(name: &str, height: usize) -> Roots {
    let view = View {
        width: height / 3 * 4,
        height,
        ..View::REFERENCE
    };
    let oracle = Oracle::named(name);
    let hits = oracle.view(&view);
    Roots::new(oracle, view, &hits)
}

/// Places in the room.
fn room_points(count: usize) -> impl ParallelIterator<Item = DVec3> {
    // Multiples of the generalised golden ratio fill the room evenly.
    (1..=count).into_par_iter().map(|i| {
        let part = |ratio: f64| (i as f64 * ratio).fract();
        DVec3::new(
            2.0 * part(0.819_172_513_396) - 1.0,
            2.0 * part(0.671_043_606_704) - 1.0,
            4.0 * part(0.549_700_477_902) - 3.0,
        )
    })
}

fn the_ray_of_every_root_meets_its_point() {
    for name in ["sphere", "parabola", "plane", "torus", "blob"] {
        let roots = seen(name, 120);
        let worst = room_points(200).map(|point| {
            let found = roots.of(point);
            let miss = |root: &Root| {
                let mirror = roots.at(root.pixel).expect("a root lies on a mirror");
                let along = (point - mirror.position).dot(mirror.direction());
                assert!(along > 0.0, "{name}: {point} lies behind {root:?}");
                (mirror.position + mirror.direction() * along).distance(point)
            };
            (found.len(), found.iter().map(miss).fold(0.0, f64::max))
        });
        let (count, miss) = worst.reduce(|| (0, 0.0), |a, b| (a.0 + b.0, a.1.max(b.1)));
        assert!(count > 5, "{name}: {count} roots are too few to tell");
        // Finite differences of the normal, seen from up to 3 m.
        assert!(miss < 1e-6, "{name}: a ray misses its point by {miss} m");
    }
}

fn a_flat_mirror_shows_a_point_once() {
    let roots = seen("plane", 120);
    let normal = DVec3::new(20f64.to_radians().sin(), 0.0, 20f64.to_radians().cos());
    let centre = DVec3::new(0.0, 0.0, -1.1);
    let view = roots.view;
    let found: usize = room_points(2000)
        .map(|point| {
            let mirrored = point - normal * (2.0 * normal.dot(point - centre));
            // The line from the eye to the mirrored point, through the picture.
            let slope = (mirrored - view.position) / (view.position.z - mirrored.z);
            let scale = view.height as f64 / 2.0 / 30f64.to_radians().tan();
            let pixel = DVec2::new(
                view.width as f64 / 2.0 + scale * slope.x,
                view.height as f64 / 2.0 - scale * slope.y,
            );
            let found = roots.of(point);
            assert!(found.len() <= 1, "{point} is shown {} times", found.len());
            for root in &found {
                let off = root.pixel.distance(pixel);
                assert!(off < 1e-6, "{point}: {root:?} is {off} off {pixel}");
            }
            found.len()
        })
        .sum();
    assert!(found > 50, "{found} roots are too few to tell");
}

fn whatever_a_pixel_shows_has_a_root_there() {
    for name in ["sphere", "parabola", "plane", "torus", "blob"] {
        let roots = seen(name, 300);
        let cells: Vec<DVec2> = roots.cells.iter().map(|c| c.1).step_by(31).collect();
        let missing: usize = cells
            .par_iter()
            .map(|&corner| {
                // Off the pixels' centres.
                let place = corner + DVec2::new(0.4, 0.3);
                let ray = roots.view.through(place);
                let Some(mirror) = roots.at(place) else {
                    return 0;
                };
                let first = roots.oracle.cast(roots.view.position, ray);
                let shown = roots
                    .oracle
                    .cast(first.position, reflect(ray, first.normal));
                if shown.position.distance(mirror.position) < 1e-3 {
                    return 0;
                }
                let found = roots.of(shown.position);
                let there = |r: &Root| r.pixel.distance(place) < 1e-2 && r.visible;
                usize::from(!found.iter().any(there))
            })
            .sum();
        // Two roots that meet within a cell leave no trace at its corners.
        assert!(
            missing * 50 <= cells.len(),
            "{name}: {missing} of {} places show points without a root there",
            cells.len()
        );
    }
}

fn measures_see_wrong_hits() {
    let root = |x: f64| Root {
        pixel: DVec2::new(x, 0.0),
        visible: true,
    };
    let points = [
        (vec![root(10.0), root(50.0)], vec![DVec2::new(10.0, 0.5)]),
        (vec![root(10.0)], vec![DVec2::new(15.0, 0.0)]),
        (vec![root(10.0)], vec![]),
        (vec![], vec![DVec2::ZERO]),
    ];
    let q = quality(&points);
    assert_eq!((q.hit_rate, q.findable), (0.75, 0.75), "{q:?}");
    assert_eq!((q.recall, q.root_recall), (1.0 / 3.0, 0.25), "{q:?}");
    assert_eq!((q.false_hits, q.median), (2.0 / 3.0, 0.5), "{q:?}");
}
