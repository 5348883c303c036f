//! Receivers that lie together, and what hides the sky of all of them.

use crate::accumulate::shares::Share;
use crate::accumulate::sphere_tree::{Node, SphereTree, Unit, distance};
use crate::receivers::ShadowReceivers;

/// A sphere around receivers, and a cone around their normals.
pub(crate) struct Group {
    pub(crate) center: [f32; 3],
    radius: f32,
    axis: [f32; 3],
    /// The cosine and the sine of the largest angle between the axis and a normal.
    spread: [f32; 2],
}

/// The least length of a mean of normals that has a direction.
const LEAST_AXIS: f32 = 1e-3;

impl Group {
    /// That of receivers, in the units of a tree.
    pub(crate) fn new(receivers: &ShadowReceivers<'_>, members: &[u32], unit: Unit) -> Self {
        let mean = |of: &dyn Fn(u32) -> [f32; 3]| {
            let sum = members.iter().map(|k| of(*k)).fold([0.0; 3], |sum, v| [0, 1, 2].map(|axis| sum[axis] + v[axis]));
            sum.map(|c| c / members.len().max(1) as f32)
        };
        let position = |k: u32| unit.scaled(receivers.positions()[k as usize]);
        let center = mean(&position);
        let radius = members.iter().map(|k| distance(center, position(*k))).fold(0.0, f32::max);
        let axis = mean(&|k| receivers.normals()[k as usize]);
        let length = distance(axis, [0.0; 3]);
        let (axis, least) = if length > LEAST_AXIS {
            let axis = axis.map(|c| c / length);
            (axis, members.iter().map(|k| dot(axis, receivers.normals()[*k as usize])).fold(1.0, f32::min).max(-1.0))
        } else {
            // Normals that cancel may have any angle to an axis.
            (UP, -1.0)
        };
        Self { center, radius, axis, spread: [least, (1.0 - least * least).sqrt()] }
    }

    /// The least and the greatest height of a point above the tangent plane of any receiver, or a wider interval:
    /// `d cos(α ± β)` for the angles `α` of the point and `β` of the normals to the axis, less or more the radius.
    fn heights(&self, point: [f32; 3]) -> [f32; 2] {
        let to = [0, 1, 2].map(|k| point[k] - self.center[k]);
        let d = distance(point, self.center);
        let along = dot(self.axis, to);
        let across = (d * d - along * along).max(0.0).sqrt();
        let [cos, sin] = self.spread;
        let low = if along <= -d * cos { -d } else { along * cos - across * sin };
        let high = if along >= d * cos { d } else { along * cos + across * sin };
        [low - self.radius, high + self.radius]
    }
}

/// The axis of normals that have none.
const UP: [f32; 3] = [0.0, 0.0, 1.0];

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Sorts what can be seen by a group into nodes that each receiver sees by itself and, if there is a limit for them, nodes
/// that are far: as large as they may be by `cut`, both in the order of the tree.
///
/// What is wholly below the planes of all receivers is in neither. What is far is wholly above them, so that the group needs
/// no plane.
pub(crate) fn sort_out(
    tree: &SphereTree,
    group: &Group,
    cut: f32,
    far_limit: Option<f32>,
    near: &mut Vec<Node>,
    far: &mut Vec<Node>,
) {
    let mut waiting = if tree.is_empty() { Vec::new() } else { vec![0_usize] };
    while let Some(k) = waiting.pop() {
        let node = tree.nodes[k];
        if node.share == Share::Nothing {
            continue;
        }
        let [low, high] = group.heights(node.center);
        if high < -node.reach {
            continue;
        }
        let d = distance(node.center, group.center);
        // What a plane cuts through is opened, so that each sphere sinks by itself.
        let is_small = node.reach <= cut * (d - group.radius) && low >= node.reach;
        if node.is_leaf() || is_small {
            let is_far = far_limit.is_some_and(|limit| group.radius <= limit * (d - node.reach)) && low >= node.reach;
            if is_far { far.push(node) } else { near.push(node) }
        } else {
            waiting.extend(node.children().rev());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::occluder::Occluder;
    use lobe_testkit::Random;

    #[test]
    fn eight_times_the_spheres_are_not_three_times_the_nodes() {
        let (at, normal) = ([[6.0, 0.0, 0.0]; 16], [UP; 16]);
        let receivers = ShadowReceivers::new(&at, &normal).unwrap();
        let members: Vec<u32> = (0..16).collect();
        let nodes = |count: usize| {
            let mut random = Random::new(1);
            // All above the plane, where nodes need not be opened.
            let center = |random: &mut Random| [0.0, 0.0, 0.5].map(|low| low + random.unit() as f32);
            let spheres: Vec<Occluder> = (0..count).map(|_| Occluder::new(center(&mut random), 0.02)).collect();
            let tree = SphereTree::over(&spheres).unwrap();
            let (mut near, mut far) = (Vec::new(), Vec::new());
            sort_out(&tree, &Group::new(&receivers, &members, tree.unit), 0.1, None, &mut near, &mut far);
            let all: f32 = near.iter().map(|node| node.count).sum();
            assert_eq!(all, count as f32, "every sphere is under one of the nodes");
            near.len()
        };
        let [some, many] = [64, 512].map(nodes);
        assert!(many < 3 * some, "{some} nodes for 64 spheres, {many} for 512");
    }
}
