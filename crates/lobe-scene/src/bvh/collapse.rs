//! Collapse of a binary tree into a BVH8.

use std::cmp::Ordering;

use rayon::prelude::*;

use crate::bvh::binary_tree::{BinaryNode, BinaryTree};
use crate::bvh::lanes::WIDTH;
use crate::bvh::wide_node::{BLOCK_BIT, Block, Node};
use crate::scene::scene::Bounds;

/// The cost of testing a block of triangles, in units of testing the eight boxes of a node: nine loads and three edge
/// functions against six fused operations. An estimate from counting instructions, not tuned.
pub(crate) const BLOCK_COST: f32 = 1.2;

/// Subtrees of more triangles than this are collapsed side by side.
const SIDE_BY_SIDE: u32 = 8192;

/// Blocks that one thread fills at a time.
const CHUNK: usize = 1024;

/// The nodes of the wide tree, the root first, children behind their parents; and its blocks. Leaves of the binary tree have eight
/// triangles at most.
///
/// ```text
///   C(n, i) = A_n c_block                     for a leaf
///   C(n, 1) = A_n + D(n, 8)                   else
///   C(n, i) = min( D(n, i), C(n, i - 1) )
///   D(n, i) = min over 0 < k < i of  C(left, k) + C(right, i - k)
/// ```
///
/// `C(n, i)` is the least cost, by the surface area heuristic, of representing the subtree n by at most i children of
/// one wide node; `A_n` is the area of its box. The choices behind `C(root, 1)` give the best wide tree to which this
/// binary one can be collapsed [Ylitie, Karras and Laine 2017] section 3.
pub(crate) fn collapse(binary: &BinaryTree, corners: &[[[f32; 3]; 3]]) -> (Vec<Node>, Vec<Block>) {
    let plan = Plan::new(binary);
    let mut wide = Wide::new();
    let parts = wide.grow(&plan, 0, SIDE_BY_SIDE);
    let grown = |&(subtree, _): &(usize, usize)| {
        let mut part = Wide::new();
        part.grow(&plan, subtree, 0);
        part
    };
    let grown: Vec<Wide> = parts.par_iter().map(grown).collect();
    for ((_, node), part) in parts.into_iter().zip(grown) {
        wide.graft(node, part);
    }
    let filled = |subtrees: &Subtrees| {
        let triangles = subtrees.places().iter().flat_map(|&place| binary.boxes(place as usize));
        Block::new(triangles.map(|&t| (t, corners[t as usize])))
    };
    (wide.nodes, wide.blocks.par_iter().with_min_len(CHUNK).map(filled).collect())
}

/// A wide tree, or the part of one below a node, of which the blocks are yet to be filled.
#[derive(Clone, Debug)]
struct Wide {
    nodes: Vec<Node>,
    blocks: Vec<Subtrees>,
}

impl Wide {
    fn new() -> Self {
        Self { nodes: vec![Node::empty()], blocks: Vec::new() }
    }

    /// Collapses a subtree into the first node, down to subtrees of no more than `enough` triangles; returns those that are left,
    /// each with the node that waits for its children.
    fn grow(&mut self, plan: &Plan<'_>, root: usize, enough: u32) -> Vec<(usize, usize)> {
        let (mut open, mut left) = (vec![(root, 0)], Vec::new());
        while let Some((subtree, node)) = open.pop() {
            if plan.binary.nodes[subtree].count <= enough {
                left.push((subtree, node));
                continue;
            }
            for (slot, piece) in plan.pieces(subtree).iter().enumerate() {
                let child = if piece.in_block.is_some() {
                    self.blocks.push(piece.subtrees);
                    BLOCK_BIT | (self.blocks.len() - 1) as u32
                } else {
                    self.nodes.push(Node::empty());
                    open.push((piece.subtrees.places[0] as usize, self.nodes.len() - 1));
                    (self.nodes.len() - 1) as u32
                };
                self.nodes[node].set_box(slot, &piece.bounds);
                self.nodes[node].set_child(slot, child);
            }
        }
        left
    }

    /// Puts the first node of a part in the place of a node, and all others behind those that are here.
    fn graft(&mut self, node: usize, mut part: Self) {
        let (nodes, blocks) = (self.nodes.len() as u32 - 1, self.blocks.len() as u32);
        for of_part in &mut part.nodes {
            of_part.move_children(|child| if child & BLOCK_BIT == 0 { child + nodes } else { child + blocks });
        }
        let mut grafted = part.nodes.into_iter();
        if let Some(first) = grafted.next() {
            self.nodes[node] = first;
        }
        self.nodes.extend(grafted);
        self.blocks.append(&mut part.blocks);
    }
}

/// Up to eight subtrees, by their places in the binary tree.
#[derive(Clone, Copy, Debug, Default)]
struct Subtrees {
    places: [u32; WIDTH],
    count: u32,
}

impl Subtrees {
    fn places(&self) -> &[u32] {
        &self.places[..self.count as usize]
    }

    fn and(mut self, other: &Self) -> Self {
        for &place in other.places() {
            self.places[self.count as usize] = place;
            self.count += 1;
        }
        self
    }
}

/// A child of a wide node: a subtree, or several that share a block.
#[derive(Clone, Copy, Debug)]
struct Piece {
    subtrees: Subtrees,
    bounds: Bounds,
    area: f32,
    /// The number of triangles, if they become a block.
    in_block: Option<u32>,
}

impl Piece {
    /// The two pieces merged into one block, if they fit and it costs no more.
    fn merged(&self, other: &Self) -> Option<Self> {
        let count = self.in_block? + other.in_block?;
        if count as usize > WIDTH {
            return None;
        }
        let (a, b) = (&self.bounds, &other.bounds);
        let bounds = Bounds {
            min: std::array::from_fn(|k| a.min[k].min(b.min[k])),
            max: std::array::from_fn(|k| a.max[k].max(b.max[k])),
        };
        let area = half_area(&bounds);
        let subtrees = || self.subtrees.and(&other.subtrees);
        (area <= self.area + other.area).then(|| Self { subtrees: subtrees(), bounds, area, in_block: Some(count) })
    }

    /// Inner nodes before blocks, and small before large: the last one is visited first, and a large one is hit more often.
    fn order(&self, other: &Self) -> Ordering {
        let key = |p: &Self| (p.in_block.is_some(), p.area);
        key(self).partial_cmp(&key(other)).unwrap_or(Ordering::Equal)
    }
}

/// The children of a wide node.
#[derive(Clone, Debug, Default)]
struct Pieces(Vec<Piece>);

impl Pieces {
    /// Adds a piece, and merges blocks where that costs no more: triangles separated in the binary tree may share a block.
    fn push(&mut self, mut piece: Piece) {
        while let Some((k, both)) = self.0.iter().enumerate().find_map(|(k, p)| Some((k, p.merged(&piece)?))) {
            self.0.remove(k);
            piece = both;
        }
        self.0.push(piece);
    }

    fn ordered(mut self) -> Vec<Piece> {
        self.0.sort_by(Piece::order);
        self.0
    }
}

pub(crate) fn half_area(bounds: &Bounds) -> f32 {
    let [x, y, z] = std::array::from_fn(|k| bounds.max[k] - bounds.min[k]);
    (x + y) * z + x * y
}

/// The costs of all subtrees.
struct Plan<'a> {
    binary: &'a BinaryTree,
    /// `C(n, i)` at `[n][i - 1]`.
    costs: Vec<Costs>,
}

type Costs = [f32; WIDTH - 1];

impl<'a> Plan<'a> {
    fn new(binary: &'a BinaryTree) -> Self {
        let mut costs = vec![[0.0; WIDTH - 1]; binary.nodes.len()];
        find_costs(&binary.nodes, &mut costs);
        Self { binary, costs }
    }

    /// The children of the wide node of a subtree.
    fn pieces(&self, subtree: usize) -> Vec<Piece> {
        let mut pieces = Pieces::default();
        // Only the root may be a leaf here.
        if self.binary.nodes[subtree].is_leaf() {
            self.add(subtree, &mut pieces);
        } else {
            self.distribute(subtree, WIDTH, &mut pieces);
        }
        pieces.ordered()
    }

    /// The number of the `i` children that the left side gets.
    fn best_split(&self, node: usize, i: usize) -> usize {
        let [left, right] = self.binary.children(node);
        let cost = |k: usize| self.costs[left][k - 1] + self.costs[right][i - k - 1];
        (1..i).map(|k| (k, cost(k))).fold((1, cost(1)), |best, new| if new.1 < best.1 { new } else { best }).0
    }

    /// Collects the subtrees that represent `node` by at most `i` children of one wide node.
    fn distribute(&self, node: usize, i: usize, pieces: &mut Pieces) {
        let k = self.best_split(node, i);
        let [left, right] = self.binary.children(node);
        for (side, share) in [(left, k), (right, i - k)] {
            // The fewest children at the same cost.
            let costs = &self.costs[side];
            let share = (1..=share).find(|&j| costs[j - 1] <= costs[share - 1]).unwrap_or(share);
            if share == 1 || self.binary.nodes[side].is_leaf() {
                self.add(side, pieces);
            } else {
                self.distribute(side, share, pieces);
            }
        }
    }

    /// Adds a subtree as one child.
    fn add(&self, node: usize, pieces: &mut Pieces) {
        let of_node = &self.binary.nodes[node];
        let mut subtrees = Subtrees { count: 1, ..Subtrees::default() };
        subtrees.places[0] = node as u32;
        let in_block = of_node.is_leaf().then_some(of_node.count);
        pieces.push(Piece { subtrees, bounds: of_node.bounds, area: half_area(&of_node.bounds), in_block });
    }
}

/// Finds the costs of a subtree, its root first.
fn find_costs(nodes: &[BinaryNode], costs: &mut [Costs]) {
    if nodes[0].count > SIDE_BY_SIDE {
        let right = nodes[0].right as usize;
        let (left_costs, right_costs) = costs[1..].split_at_mut(right - 1);
        rayon::join(|| find_costs(&nodes[1..right], left_costs), || find_costs(&nodes[right..], right_costs));
        costs[0] = cost(&nodes[0], &costs[1], &costs[right]);
        return;
    }
    // Children stand behind their parents.
    for (place, node) in nodes.iter().enumerate().rev() {
        costs[place] = if node.is_leaf() {
            [half_area(&node.bounds) * BLOCK_COST; WIDTH - 1]
        } else {
            cost(node, &costs[place + 1], &costs[place + node.right as usize])
        };
    }
}

/// The costs of an inner node, from those of its children.
fn cost(node: &BinaryNode, left: &Costs, right: &Costs) -> Costs {
    // `D(n, i)` at `i - 2`.
    let mut splits = [f32::INFINITY; WIDTH - 1];
    for i in 0..WIDTH - 1 {
        for k in 0..=i {
            let cost = left[k] + right[i - k];
            splits[i] = if cost < splits[i] { cost } else { splits[i] };
        }
    }
    let mut least = half_area(&node.bounds) + splits[WIDTH - 2];
    std::array::from_fn(|i| {
        least = if i > 0 && splits[i - 1] < least { splits[i - 1] } else { least };
        least
    })
}
