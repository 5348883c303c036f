//! Collapse of the binary tree built by obvhs into a BVH8.

use std::cmp::Ordering;

use obvhs::bvh2::Bvh2;

use crate::Bounds;
use crate::bvh::lanes::WIDTH;
use crate::bvh::wide_node::{BLOCK_BIT, Block, Node};

/// The cost of testing a block of triangles, in units of testing the eight boxes of a node: nine loads and three edge
/// functions against six fused operations. An estimate from counting instructions, not tuned.
pub(crate) const BLOCK_COST: f32 = 1.2;

/// The nodes of the wide tree, the root first, and its blocks.
///
/// ```text
///   C(n, 1) = min( A_n c_block  if at most 8 triangles,   A_n + D(n, 8) )
///   C(n, i) = min( D(n, i), C(n, i - 1) )
///   D(n, i) = min over 0 < k < i of  C(left, k) + C(right, i - k)
/// ```
///
/// `C(n, i)` is the least cost, by the surface area heuristic, of representing the subtree n by at most i children of
/// one wide node; `A_n` is the area of its box. The choices behind `C(root, 1)` give the best wide tree to which this
/// binary one can be collapsed [Ylitie, Karras and Laine 2017] section 3.
pub(crate) fn collapse(binary: &Bvh2, corners: &[[[f32; 3]; 3]]) -> (Vec<Node>, Vec<Block>) {
    let plan = Plan::new(binary);
    let mut wide = Wide { plan, corners, nodes: vec![Node::empty()], blocks: Vec::new() };
    // Pairs of a binary node to be collapsed and the wide node that receives its children.
    let mut open = vec![(0_usize, 0_usize)];
    while let Some((subtree, node)) = open.pop() {
        let mut pieces = Vec::with_capacity(WIDTH);
        // Only the root may become a block here.
        if wide.plan.is_block(subtree) {
            pieces.push(subtree);
        } else {
            wide.plan.distribute(subtree, WIDTH, &mut pieces);
        }
        for (slot, piece) in ordered(wide.plan.merged(&pieces)).into_iter().enumerate() {
            let child = wide.child(&piece, &mut open);
            wide.nodes[node].set_box(slot, &piece.bounds);
            wide.nodes[node].set_child(slot, child);
        }
    }
    (wide.nodes, wide.blocks)
}

/// A child of a wide node: a subtree, or several that share a block.
#[derive(Clone, Debug)]
struct Piece {
    subtrees: Vec<usize>,
    bounds: Bounds,
    /// The number of triangles, if they become a block.
    in_block: Option<u32>,
}

impl Piece {
    /// The two pieces merged into one block, if they fit and it costs no more.
    fn merged(&self, other: &Self) -> Option<Self> {
        let count = self.in_block? + other.in_block?;
        let (a, b) = (&self.bounds, &other.bounds);
        let bounds = Bounds {
            min: std::array::from_fn(|k| a.min[k].min(b.min[k])),
            max: std::array::from_fn(|k| a.max[k].max(b.max[k])),
        };
        let is_cheaper = half_area(&bounds) <= half_area(a) + half_area(b);
        let subtrees = || [&self.subtrees[..], &other.subtrees[..]].concat();
        (count as usize <= WIDTH && is_cheaper).then(|| Self { subtrees: subtrees(), bounds, in_block: Some(count) })
    }
}

/// Sorts inner nodes before blocks, and small before large: the last one is visited first, and a large one is hit more
/// often.
fn ordered(mut pieces: Vec<Piece>) -> Vec<Piece> {
    let is_first = |p: &Piece| (p.in_block.is_some(), half_area(&p.bounds));
    pieces.sort_by(|a, b| is_first(a).partial_cmp(&is_first(b)).unwrap_or(Ordering::Equal));
    pieces
}

pub(crate) fn half_area(bounds: &Bounds) -> f32 {
    let [x, y, z] = std::array::from_fn(|k| bounds.max[k] - bounds.min[k]);
    (x + y) * z + x * y
}

struct Wide<'a> {
    plan: Plan<'a>,
    corners: &'a [[[f32; 3]; 3]],
    nodes: Vec<Node>,
    blocks: Vec<Block>,
}

impl Wide<'_> {
    /// Creates the child for a piece: a block now, or a node to be filled later.
    fn child(&mut self, piece: &Piece, open: &mut Vec<(usize, usize)>) -> u32 {
        if piece.in_block.is_some() {
            let triangles = self.plan.triangles(&piece.subtrees);
            self.blocks.push(Block::new(triangles.iter().map(|&t| (t, self.corners[t as usize]))));
            BLOCK_BIT | (self.blocks.len() - 1) as u32
        } else {
            self.nodes.push(Node::empty());
            open.push((piece.subtrees[0], self.nodes.len() - 1));
            (self.nodes.len() - 1) as u32
        }
    }
}

/// The costs of all subtrees.
struct Plan<'a> {
    binary: &'a Bvh2,
    /// `C(n, i)` at `[n][i - 1]`.
    costs: Vec<[f32; WIDTH - 1]>,
    counts: Vec<u32>,
}

impl<'a> Plan<'a> {
    fn new(binary: &'a Bvh2) -> Self {
        let count = binary.nodes.len();
        let mut plan = Self { binary, costs: vec![[0.0; WIDTH - 1]; count], counts: vec![0; count] };
        // Order parents before children, then compute the costs in reverse.
        let (mut order, mut open) = (Vec::with_capacity(count), vec![0_usize]);
        while let Some(node) = open.pop() {
            order.push(node);
            if !plan.is_leaf(node) {
                open.extend(plan.children(node));
            }
        }
        for &node in order.iter().rev() {
            plan.cost(node);
        }
        plan
    }

    fn cost(&mut self, node: usize) {
        let area = self.binary.nodes[node].aabb().half_area();
        if self.is_leaf(node) {
            self.counts[node] = self.binary.nodes[node].prim_count;
            self.costs[node] = [area * BLOCK_COST; WIDTH - 1];
            return;
        }
        let [left, right] = self.children(node);
        self.counts[node] = self.counts[left] + self.counts[right];
        let block = if self.counts[node] as usize <= WIDTH { area * BLOCK_COST } else { f32::INFINITY };
        let mut costs = [block.min(area + self.best_split(node, WIDTH).1); WIDTH - 1];
        for i in 2..WIDTH {
            costs[i - 1] = costs[i - 2].min(self.best_split(node, i).1);
        }
        self.costs[node] = costs;
    }

    /// The number of the `i` children that the left side gets, and `D(n, i)`.
    fn best_split(&self, node: usize, i: usize) -> (usize, f32) {
        let [left, right] = self.children(node);
        let cost = |k: usize| self.costs[left][k - 1] + self.costs[right][i - k - 1];
        (1..i).map(|k| (k, cost(k))).fold((1, cost(1)), |best, new| if new.1 < best.1 { new } else { best })
    }

    /// Collects the subtrees that represent `node` by at most `i` children of one wide node.
    fn distribute(&self, node: usize, i: usize, pieces: &mut Vec<usize>) {
        let (k, _) = self.best_split(node, i);
        let [left, right] = self.children(node);
        for (side, share) in [(left, k), (right, i - k)] {
            // The fewest children at the same cost.
            let costs = &self.costs[side];
            let share = (1..=share).find(|&j| costs[j - 1] <= costs[share - 1]).unwrap_or(share);
            if share == 1 || self.is_leaf(side) { pieces.push(side) } else { self.distribute(side, share, pieces) }
        }
    }

    fn is_leaf(&self, node: usize) -> bool {
        self.binary.nodes[node].is_leaf()
    }

    fn children(&self, node: usize) -> [usize; 2] {
        let first = self.binary.nodes[node].first_index as usize;
        [first, first + 1]
    }

    /// Whether the subtree as a single child is cheapest as a block.
    fn is_block(&self, node: usize) -> bool {
        let area = self.binary.nodes[node].aabb().half_area();
        self.is_leaf(node) || (self.counts[node] as usize <= WIDTH && self.costs[node][0] >= area * BLOCK_COST)
    }

    fn bounds(&self, node: usize) -> Bounds {
        let aabb = self.binary.nodes[node].aabb();
        Bounds { min: aabb.min.to_array(), max: aabb.max.to_array() }
    }

    /// The pieces, with blocks merged where that costs no more: triangles separated in the binary tree may share a
    /// block.
    fn merged(&self, subtrees: &[usize]) -> Vec<Piece> {
        let piece = |&subtree: &usize| Piece {
            subtrees: vec![subtree],
            bounds: self.bounds(subtree),
            in_block: self.is_block(subtree).then(|| self.counts[subtree]),
        };
        let mut pieces: Vec<Piece> = Vec::with_capacity(WIDTH);
        for mut piece in subtrees.iter().map(piece) {
            while let Some((k, both)) = pieces.iter().enumerate().find_map(|(k, p)| Some((k, p.merged(&piece)?))) {
                pieces.remove(k);
                piece = both;
            }
            pieces.push(piece);
        }
        pieces
    }

    fn triangles(&self, subtrees: &[usize]) -> Vec<u32> {
        let (mut triangles, mut open) = (Vec::with_capacity(WIDTH), subtrees.to_vec());
        while let Some(node) = open.pop() {
            if self.is_leaf(node) {
                let first = self.binary.nodes[node].first_index as usize;
                let count = self.binary.nodes[node].prim_count as usize;
                triangles.extend_from_slice(&self.binary.primitive_indices[first..first + count]);
            } else {
                open.extend(self.children(node));
            }
        }
        triangles
    }
}
