//! A tree of beams over a chart: every tile of the picture that may show a point is found, so that none of its places in
//! the mirror is missed.

use glam::{UVec2, Vec2};

use super::beam::{Beam, Points8};
use super::charts::corners;
use super::field::{MirrorField, Sample};

/// Side of a leaf's tile, cells.
pub const LEAF: u32 = 4;

/// A square of cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Node {
    /// What it can show.
    pub(crate) beam: Beam,
    /// What it is made of.
    pub(crate) kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    /// So many nodes from this index on.
    Children { first: u32, count: u32 },
    /// A tile: searches start at this one of the tree's starts.
    Leaf { start: u32 },
}

/// A quadtree over the cells of a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamTree {
    nodes: Vec<Node>,
    starts: Vec<Start>,
}

/// Where searches start in a tile, and the field there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Place in the field.
    pub at: Vec2,
    /// The field at that place.
    pub sample: Sample,
}

/// Working memory of a walk.
#[derive(Debug, Default)]
pub struct Walk(Vec<(u32, u32)>);

impl BeamTree {
    /// The tree over cells, given by the column and row of their upper left pixels; `None` where there is none.
    pub(super) fn new(field: &MirrorField, cells: &[(u32, u32)]) -> Option<Self> {
        let first = cells.first()?;
        let (mut low, mut high) = (UVec2::from(*first), UVec2::from(*first));
        for &cell in cells {
            low = low.min(cell.into());
            high = high.max(cell.into());
        }
        let side = ((high - low).max_element() + 1)
            .max(LEAF)
            .next_power_of_two();
        let mut tree = Self {
            nodes: Vec::new(),
            starts: Vec::new(),
        };
        let root = Node {
            beam: Beam::around(std::iter::empty()),
            kind: Kind::Children { first: 0, count: 0 },
        };
        tree.nodes.push(root);
        tree.grow(field, 0, low, side, &mut cells.to_vec());
        Some(tree)
    }

    /// Makes node `index` of the square of `side` cells at `corner` with these cells in it.
    fn grow(
        &mut self,
        field: &MirrorField,
        index: usize,
        corner: UVec2,
        side: u32,
        cells: &mut [(u32, u32)],
    ) {
        let samples = cells.iter().flat_map(|&(x, y)| corners(field, x, y));
        self.nodes[index].beam = Beam::around(samples);
        if side <= LEAF {
            // The cell next to the tile's middle.
            let middle = corner.as_vec2() + (side as f32 - 1.0) * 0.5;
            let distance = |cell: &(u32, u32)| {
                Vec2::new(cell.0 as f32, cell.1 as f32).distance_squared(middle)
            };
            let nearest = cells
                .iter()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)));
            let (x, y) = nearest.copied().unwrap_or((corner.x, corner.y));
            let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            self.nodes[index].kind = Kind::Leaf {
                start: self.starts.len() as u32,
            };
            if let Some(sample) = field.sample(at) {
                self.starts.push(Start { at, sample });
            }
            return;
        }
        // Quadrants: sorted in place, upper left, upper right, lower left, lower right.
        let half = side / 2;
        let quadrant = |cell: &(u32, u32)| {
            u32::from(cell.0 >= corner.x + half) + 2 * u32::from(cell.1 >= corner.y + half)
        };
        cells.sort_by_key(quadrant);
        let first = self.nodes.len();
        let ends: [usize; 4] =
            std::array::from_fn(|k| cells.partition_point(|c| quadrant(c) <= k as u32));
        let starts = [0, ends[0], ends[1], ends[2]];
        let filled: Vec<usize> = (0..4).filter(|&k| starts[k] < ends[k]).collect();
        self.nodes[index].kind = Kind::Children {
            first: first as u32,
            count: filled.len() as u32,
        };
        for _ in &filled {
            self.nodes.push(self.nodes[index]);
        }
        for (child, &k) in filled.iter().enumerate() {
            let corner = corner + UVec2::new(k as u32 & 1, k as u32 >> 1) * half;
            self.grow(
                field,
                first + child,
                corner,
                half,
                &mut cells[starts[k]..ends[k]],
            );
        }
    }

    /// Calls `each(start, mask)` for every tile that may show some of eight points: where searches start, and a bit for each
    /// of those points. `mask` says which points to look for.
    #[inline]
    pub fn visit(
        &self,
        points: &Points8,
        mask: u32,
        walk: &mut Walk,
        mut each: impl FnMut(&Start, u32),
    ) {
        walk.0.clear();
        walk.0.push((0, mask));
        while let Some((index, mask)) = walk.0.pop() {
            let Some(node) = self.nodes.get(index as usize) else {
                continue;
            };
            let mask = mask & node.beam.may_show(points);
            if mask == 0 {
                continue;
            }
            match node.kind {
                Kind::Children { first, count } => {
                    walk.0.extend((first..first + count).map(|k| (k, mask)));
                }
                Kind::Leaf { start } => {
                    if let Some(start) = self.starts.get(start as usize) {
                        each(start, mask);
                    }
                }
            }
        }
    }

    /// All nodes; the first is the root.
    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Where searches start.
    pub(crate) fn starts(&self) -> &[Start] {
        &self.starts
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether it has no node.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }
}
