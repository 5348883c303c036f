//! Refit of a BVH8 to triangles that have moved: the same tree with other boxes.

use crate::bvh::collapse::{BLOCK_COST, half_area};
use crate::bvh::lanes::WIDTH;
use crate::bvh::wide_node::{BLOCK_BIT, Block, Node};
use crate::scene::scene::Bounds;

/// Moves the corners of all triangles and the boxes around them; returns the box around everything.
///
/// One pass from the leaves to the root, in linear time: children stand behind their parents. Which triangles share a
/// box stays as it was, so boxes grow where neighbors part.
pub(crate) fn refit(nodes: &mut [Node], blocks: &mut [Block], corners: &[[[f32; 3]; 3]]) -> Bounds {
    let mut of_nodes = vec![nothing(); nodes.len()];
    for (index, node) in nodes.iter_mut().enumerate().rev() {
        let mut all = nothing();
        for slot in 0..WIDTH {
            if node.bounds(slot).is_none() {
                continue;
            }
            let child = node.child(slot);
            let bounds = match child & BLOCK_BIT {
                0 => of_nodes[child as usize],
                _ => blocks[(child & !BLOCK_BIT) as usize].refit(corners),
            };
            node.set_box(slot, &bounds);
            all = union(&all, &bounds);
        }
        of_nodes[index] = all;
    }
    of_nodes[0]
}

/// The expected number of tests for a ray that meets the box of all triangles, by the surface area heuristic: of nodes, and
/// of blocks, which cost a little more. Zero without area.
pub(crate) fn cost(nodes: &[Node], all: &Bounds) -> f32 {
    let boxes = nodes.iter().flat_map(|node| (0..WIDTH).map(move |slot| (node.child(slot), node.bounds(slot))));
    let of_box = |(child, bounds): (u32, Option<Bounds>)| {
        let factor = if child & BLOCK_BIT == 0 { 1.0 } else { BLOCK_COST };
        bounds.map_or(0.0, |bounds| f64::from(factor * half_area(&bounds)))
    };
    let sum: f64 = boxes.map(of_box).sum();
    let whole = f64::from(half_area(all));
    if whole > 0.0 { (1.0 + sum / whole) as f32 } else { 0.0 }
}

fn nothing() -> Bounds {
    Bounds { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] }
}

fn union(a: &Bounds, b: &Bounds) -> Bounds {
    Bounds {
        min: std::array::from_fn(|k| a.min[k].min(b.min[k])),
        max: std::array::from_fn(|k| a.max[k].max(b.max[k])),
    }
}
