//! The binary tree: parallel locally-ordered clustering, and reinsertion.

use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::morton::morton_encode_u64;

use crate::Bounds;

/// Neighbors looked at on each side, along a curve through all centers.
const WINDOW: usize = 24;

/// A round that merges less than this part of the clusters is followed by one that merges half of them, neighbors with
/// neighbors.
const SLOW: usize = 8;

/// Where a ray that meets the box of all triangles meets more boxes than this, in the mean, they overlap so much
/// that reinsertion would look at a good part of them for each.
const MOST_MET: f32 = 1000.0;

/// Parts of the nodes that are reinserted where it lowers the cost, in two runs.
const REINSERTED: [f32; 2] = [0.2, 0.4];

/// A binary tree over boxes, one at each leaf, none of them empty.
///
/// Clusters are boxes along a space-filling curve. In each round a cluster finds the one among its neighbors with which
/// it has the smallest box, and two that find each other are merged [Meister and Bittner 2018b]. Afterwards subtrees are
/// moved to where they lower the cost [Meister and Bittner 2018a].
///
/// It takes n log n whatever the boxes are. Two provisions see to that. Among pairs of equal cost both sides prefer the
/// same one, so that a row of equal triangles, or all at one place, merges in pairs. Where clusters lie within each other
/// each prefers the smaller one, and few find each other: then neighbors are merged as they come.
pub(crate) fn build(boxes: &[Bounds]) -> Bvh2 {
    let (mut tree, _) = clustered(boxes);
    let area = |node: &Bvh2Node| node.aabb().half_area();
    let met = tree.nodes.iter().map(area).sum::<f32>() / area(&tree.nodes[0]);
    // The quotient is no number if all boxes are one point.
    if met <= MOST_MET {
        let mut optimizer = ReinsertionOptimizer::default();
        REINSERTED.iter().for_each(|&part| optimizer.run(&mut tree, part, None));
    }
    tree
}

/// The tree before reinsertion, and the number of rounds: each takes time linear in what is left.
fn clustered(boxes: &[Bounds]) -> (Bvh2, usize) {
    let mut tree = Bvh2 { primitive_indices: along_curve(boxes), ..Bvh2::default() };
    let leaf = |(place, &index): (usize, &u32)| {
        let Bounds { min, max } = boxes[index as usize];
        Bvh2Node::new(Aabb { min: min.into(), max: max.into() }, 1, place as u32)
    };
    let mut clusters: Vec<Bvh2Node> = tree.primitive_indices.iter().enumerate().map(leaf).collect();
    // Children are stored in pairs from the end, parents before them, the root first.
    tree.nodes = vec![Bvh2Node::default(); 2 * boxes.len() - 1];
    let mut end = tree.nodes.len();
    let (mut rounds, mut is_slow) = (0, false);
    while clusters.len() > 1 {
        let partners = if is_slow { neighbors(clusters.len()) } else { nearest(&clusters) };
        let mut next = Vec::with_capacity(clusters.len());
        for (i, cluster) in clusters.iter().enumerate() {
            let partner = partners[i];
            if partners[partner] != i || partner == i {
                next.push(*cluster);
            } else if i < partner {
                end -= 2;
                (tree.nodes[end], tree.nodes[end + 1]) = (*cluster, clusters[partner]);
                next.push(Bvh2Node::new(cluster.aabb().union(clusters[partner].aabb()), 0, end as u32));
            }
        }
        is_slow = (clusters.len() - next.len()) * SLOW < clusters.len();
        clusters = next;
        rounds += 1;
    }
    tree.nodes[0] = clusters[0];
    tree.children_are_ordered_after_parents = true;
    // Reinsertion makes its stacks for this depth.
    tree.max_depth = tree.max_depth.max(rounds + 1);
    (tree, rounds)
}

/// For each cluster the one within the window with which it has the smallest box. Of pairs of equal cost the nearer comes
/// first, then every second one of equal distance: an order of pairs, the same for both sides.
fn nearest(clusters: &[Bvh2Node]) -> Vec<usize> {
    // Cost, rank among pairs of that cost, and partner.
    let mut best = vec![(f32::INFINITY, u32::MAX, 0_u32); clusters.len()];
    for (i, cluster) in clusters.iter().enumerate() {
        for distance in 1..=WINDOW.min(clusters.len() - 1 - i) {
            let other = i + distance;
            let cost = cluster.aabb().union(clusters[other].aabb()).half_area();
            let rank = (2 * distance + (i / distance) % 2) as u32;
            for (side, partner) in [(i, other), (other, i)] {
                if (cost, rank) < (best[side].0, best[side].1) {
                    best[side] = (cost, rank, partner as u32);
                }
            }
        }
    }
    best.into_iter().map(|(_, _, partner)| partner as usize).collect()
}

/// Each cluster with the next one; a last one that is left over with itself.
fn neighbors(count: usize) -> Vec<usize> {
    (0..count).map(|i| if (i ^ 1) < count { i ^ 1 } else { i }).collect()
}

/// The indices of boxes in the order of their centers along the Z-order curve, 21 bits for each axis.
fn along_curve(boxes: &[Bounds]) -> Vec<u32> {
    let center = |b: &Bounds| 0.5 * (DVec3::from(b.min.map(f64::from)) + DVec3::from(b.max.map(f64::from)));
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for c in boxes.iter().map(center) {
        (min, max) = (min.min(c), max.max(c));
    }
    // One scale for all axes keeps cells cubes; coordinates are below 1.
    let scale = (1.0 - f64::from(f32::EPSILON)) / (max - min).max_element().max(f64::MIN_POSITIVE);
    let code = |b: &Bounds| {
        // Numbers, not vectors: the library may be built with another version of glam.
        let [x, y, z] = ((center(b) - min) * scale * f64::from(1_u32 << 21)).to_array().map(|c| c as u32);
        morton_encode_u64(x, y, z)
    };
    let mut order: Vec<(u64, u32)> = boxes.iter().map(code).zip(0..).collect();
    order.sort_unstable();
    order.into_iter().map(|(_, index)| index).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that each box is at one leaf, that leaves hold one each, and that boxes hold those of their children;
    /// returns the number of boxes that a ray meets in the mean.
    fn checked(name: &str, boxes: &[Bounds]) -> f32 {
        // A round leaves 7/8 of the clusters at most, or the next one half: 5.2 is 1 / log2(8/7).
        let (rounds, most) = (clustered(boxes).1, 5.2 * (boxes.len() as f64).log2() + 2.0);
        assert!(rounds as f64 <= most, "{name}: {} boxes in {rounds} rounds, more than {most}", boxes.len());
        let tree = build(boxes);
        let mut found = vec![0; boxes.len()];
        let mut open = vec![0_usize];
        while let Some(node) = open.pop() {
            let node = &tree.nodes[node];
            if node.is_leaf() {
                assert_eq!(node.prim_count, 1, "{name}: boxes of a leaf");
                let index = tree.primitive_indices[node.first_index as usize] as usize;
                found[index] += 1;
                assert_eq!(node.aabb().min.to_array(), boxes[index].min, "{name}: the box of {index}");
            } else {
                for child in [0, 1].map(|k| node.first_index as usize + k) {
                    let union = node.aabb().union(tree.nodes[child].aabb());
                    assert!(union.min == node.aabb().min && union.max == node.aabb().max, "{name}: node {child}");
                    open.push(child);
                }
            }
        }
        assert!(found.iter().all(|&times| times == 1), "{name}: each box at one leaf");
        let root = tree.nodes[0].aabb().half_area();
        tree.nodes.iter().map(|node| node.aabb().half_area() / root).sum()
    }

    fn boxes(count: usize, at: impl Fn(f32) -> ([f32; 3], [f32; 3])) -> Vec<Bounds> {
        (0..count).map(|i| at(i as f32)).map(|(min, max)| Bounds { min, max }).collect()
    }

    #[test]
    fn any_boxes_make_a_tree_in_a_logarithmic_number_of_rounds() {
        let count = 50_000;
        checked("one box", &boxes(1, |_| ([0.0; 3], [1.0; 3])));
        checked("three points", &boxes(3, |_| ([1.0; 3], [1.0; 3])));
        checked("all at one place", &boxes(count, |_| ([0.0; 3], [1.0, 1.0, 0.0])));
        checked("nested", &boxes(count, |i| ([-1.0 - i; 3], [1.0 + i; 3])));
        checked("from one corner", &boxes(count, |i| ([0.0; 3], [1.0 + i; 3])));
        checked("parallel sticks", &boxes(count, |i| ([0.0, i, 0.0], [1e6, i + 0.5, 1.0])));
        let met = checked("a row", &boxes(count, |i| ([i, 0.0, 0.0], [i + 1.0, 1.0, 0.0])));
        // A balanced tree over a row has the area of the row once for each level.
        assert!(met < 20.0, "a ray meets {met} boxes of a row");
    }
}
