//! A tree of boxes over discs: eight discs a leaf, eight children a node, packed level by level along a Morton curve
//! (a packed R-tree, [Kamel and Faloutsos 1993]). Its size follows from the number of discs alone.

use rayon::prelude::*;
use wide::f32x8;

use super::leaf::{Bounds, Leaf, Meeting, Ray, Vec3x8, WIDTH, leaf};
use crate::cloud::Surfels;
use crate::cloud::along_curve;
use crate::gbuffer::SplatSettings;

/// Nodes a task, when a level is built.
const CHUNK: usize = 1 << 10;

/// The boxes of eight children.
#[derive(Debug, Clone, Copy)]
struct Node {
    min: Vec3x8,
    max: Vec3x8,
    /// How far behind the nearest hit a disc of this child may still be blended.
    reach: f32x8,
}

/// A child that is still to be visited.
#[derive(Debug, Clone, Copy, Default)]
struct Pending {
    /// Smallest distance at which it matters.
    soonest: f32,
    /// Levels above the leaves' nodes, plus 1; 0 is a leaf.
    level: u32,
    index: u32,
}

/// What a thread keeps from ray to ray.
#[derive(Debug, Default)]
pub(super) struct Stack(Vec<Pending>);

/// The tree.
#[derive(Debug)]
pub(super) struct Tree {
    leaves: Vec<Leaf>,
    /// From the leaves' nodes up; the last has one node.
    levels: Vec<Vec<Node>>,
    /// Squared half width of a disc over its squared radius.
    size_squared: f32,
}

/// Memory of a tree over so many discs, with what building it takes for a while; bytes.
pub(super) fn memory(discs: usize) -> u64 {
    let leaves = discs.div_ceil(WIDTH) as u64;
    let nodes = leaves / (WIDTH as u64 - 1) + 2;
    let kept = leaves * size_of::<Leaf>() as u64 + nodes * size_of::<Node>() as u64;
    let sorting = discs as u64 * (size_of::<(u64, u32)>() + size_of::<u32>()) as u64;
    kept + sorting + leaves * size_of::<Bounds>() as u64
}

impl Tree {
    /// The tree over all surfels as discs of the splats' size.
    pub(super) fn new(surfels: &Surfels, settings: &SplatSettings) -> Self {
        let order = along_curve(&surfels.places);
        let (leaves, mut bounds): (Vec<Leaf>, Vec<Bounds>) = order
            .par_chunks(WIDTH)
            .with_min_len(CHUNK)
            .map(|indices| leaf(surfels, indices, settings))
            .unzip();
        drop(order);
        let mut levels = Vec::new();
        while bounds.len() > 1 || levels.is_empty() && !bounds.is_empty() {
            let (nodes, above): (Vec<Node>, Vec<Bounds>) = bounds
                .par_chunks(WIDTH)
                .with_min_len(CHUNK)
                .map(node)
                .unzip();
            levels.push(nodes);
            bounds = above;
        }
        Self {
            leaves,
            levels,
            size_squared: settings.size * settings.size,
        }
    }

    /// What the tree takes, bytes.
    pub(super) fn memory(&self) -> u64 {
        let nodes: usize = self.levels.iter().map(Vec::len).sum();
        (self.leaves.len() * size_of::<Leaf>() + nodes * size_of::<Node>()) as u64
    }

    /// Calls `meet` with every disc that the ray meets at up to the distance that `meet` last gave, nearer parts of the
    /// scene first, and with some that lie farther.
    pub(super) fn visit(&self, ray: &Ray, stack: &mut Stack, mut meet: impl FnMut(Meeting) -> f32) {
        let mut nearest = f32::INFINITY;
        let Stack(stack) = stack;
        stack.clear();
        stack.push(Pending {
            soonest: 0.0,
            level: self.levels.len() as u32,
            index: 0,
        });
        let slabs = Slabs::new(ray);
        while let Some(pending) = stack.pop() {
            if pending.soonest > nearest {
                continue;
            }
            let index = pending.index as usize;
            let Some(below) = pending.level.checked_sub(1) else {
                if let Some(leaf) = self.leaves.get(index) {
                    leaf.meet(ray, self.size_squared, |meeting| nearest = meet(meeting));
                }
                continue;
            };
            let Some(node) = self.levels.get(below as usize).and_then(|l| l.get(index)) else {
                continue;
            };
            let (soonest, mut entered) = slabs.enter(node, nearest);
            // The nearest on top.
            let first = stack.len();
            while entered != 0 {
                let lane = entered.trailing_zeros() as usize & (WIDTH - 1);
                entered &= entered - 1;
                let child = Pending {
                    soonest: soonest[lane],
                    level: below,
                    index: (index * WIDTH + lane) as u32,
                };
                stack.push(child);
                let mut at = stack.len() - 1;
                while at > first && stack[at - 1].soonest < child.soonest {
                    stack.swap(at - 1, at);
                    at -= 1;
                }
            }
        }
    }
}

/// A ray, ready to be cut with boxes.
struct Slabs {
    origin: Vec3x8,
    inverse: Vec3x8,
    /// Whether the ray runs down an axis: it enters at the upper side then.
    downwards: [bool; 3],
}

impl Slabs {
    fn new(ray: &Ray) -> Self {
        /// Smallest slope that is divided by: boxes beside the ray stay finitely far.
        const SMALLEST: f32 = 1e-12;
        let inverse = ray.direction.to_array().map(|d| {
            let away = if d.abs() < SMALLEST {
                SMALLEST.copysign(d)
            } else {
                d
            };
            1.0 / away
        });
        Self {
            origin: ray.origin.to_array().map(f32x8::splat),
            inverse: inverse.map(f32x8::splat),
            downwards: inverse.map(|i| i < 0.0),
        }
    }

    /// Where each child starts to matter, and which of them do, one bit each.
    #[inline(always)]
    fn enter(&self, node: &Node, nearest: f32) -> ([f32; WIDTH], u32) {
        let mut enter = f32x8::ZERO;
        let mut leave = f32x8::splat(f32::INFINITY);
        for axis in 0..3 {
            let (near, far) = if self.downwards[axis] {
                (node.max[axis], node.min[axis])
            } else {
                (node.min[axis], node.max[axis])
            };
            enter = enter.fast_max((near - self.origin[axis]) * self.inverse[axis]);
            leave = leave.fast_min((far - self.origin[axis]) * self.inverse[axis]);
        }
        let soonest = enter - node.reach;
        let entered = enter.simd_le(leave) & soonest.simd_le(f32x8::splat(nearest));
        (soonest.to_array(), entered.to_bitmask())
    }
}

/// A node over up to eight boxes, and the box around them.
fn node(children: &[Bounds]) -> (Node, Bounds) {
    let at = |lane: usize| children.get(lane).copied().unwrap_or(Bounds::EMPTY);
    let column = |value: &dyn Fn(Bounds) -> f32| {
        f32x8::from(std::array::from_fn::<f32, WIDTH, _>(|lane| value(at(lane))))
    };
    let node = Node {
        min: std::array::from_fn(|axis| column(&|b| b.min[axis])),
        max: std::array::from_fn(|axis| column(&|b| b.max[axis])),
        reach: column(&|b| b.reach),
    };
    let bounds = children.iter().copied().fold(Bounds::EMPTY, Bounds::union);
    (node, bounds)
}
