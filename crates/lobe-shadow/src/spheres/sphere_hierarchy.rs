//! Trees of spheres: each parent contains its children, so that fewer spheres stand for a set where it looks small.
//!
//! The two nodes whose smallest common ball is smallest are joined, again and again, until one is left (agglomerative
//! clustering). The smallest ball around two balls that do not contain each other is along the line of their centers:
//!
//! ```text
//!   R = (|c₂ - c₁| + R₁ + R₂) / 2        c = c₁ + (R - R₁) (c₂ - c₁)/|c₂ - c₁|
//! ```
//!
//! A node with up to `arity` children takes, in the place of its largest child, that one's children, while there is
//! room.

use glam::DVec3;

use crate::{ShadowError, SphereSet};

/// Nodes are joined in time proportional to the square of their number: at 2¹⁴ spheres, some seconds.
const MOST_LEAVES: usize = 1 << 14;

/// Children of a node at most.
const MOST_CHILDREN: usize = 64;

/// Rounding of a radius to single precision must not uncover a child: a part of the radius and of the distance to the
/// origin.
const SLACK: f64 = 4.0 * f32::EPSILON as f64;

/// A node of a [`SphereHierarchy`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereNode {
    /// The center of a ball around all leaves below it; that of the sphere for a leaf. From the origin of the tree.
    pub center: [f32; 3],
    /// Its radius.
    pub radius: f32,
    /// The index of the first child; the others follow it. 0 for a leaf.
    pub first_child: u32,
    /// The number of children; 0 for a leaf.
    pub children: u32,
    /// The first of the leaves below it, as a place in [`SphereHierarchy::leaves`].
    pub first_leaf: u32,
    /// The number of leaves below it; 1 for a leaf.
    pub leaf_count: u32,
}

impl SphereNode {
    /// Whether it is one of the spheres of the set.
    #[must_use]
    pub fn is_leaf(&self) -> bool {
        self.children == 0
    }
}

/// A tree over the spheres of a set.
///
/// ```
/// use lobe_shadow::{SphereHierarchy, SphereSet};
///
/// let set = SphereSet::new(vec![[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [2.0, 0.0, 0.0]], vec![1.0; 3])?;
/// let tree = SphereHierarchy::new(&set, 2)?;
/// let root = tree.nodes()[0];
/// assert_eq!((root.children, root.leaf_count), (2, 3));
/// assert!((root.radius - 5.5).abs() < 1e-4, "from -1 to 10");
/// // The spheres at 0 and 2 lie below one child, that at 9 is the other.
/// assert_eq!(tree.nodes()[1].leaf_count + tree.nodes()[2].leaf_count, 3);
/// # Ok::<(), lobe_shadow::ShadowError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SphereHierarchy {
    nodes: Vec<SphereNode>,
    leaves: Vec<u32>,
    origin: [f64; 3],
}

/// A node while the tree is made: its ball and its children.
struct Joined {
    center: DVec3,
    radius: f64,
    children: Vec<usize>,
}

impl SphereHierarchy {
    /// The tree over a set, each node of which has up to `arity` children.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if the set is empty or has more than 2¹⁴ spheres, or the arity is not from 2 to 64.
    pub fn new(set: &SphereSet, arity: usize) -> Result<Self, ShadowError> {
        if !(1..=MOST_LEAVES).contains(&set.len()) {
            return Err(ShadowError::Options(format!("expected 1 to {MOST_LEAVES} spheres, found {}", set.len())));
        }
        if !(2..=MOST_CHILDREN).contains(&arity) {
            return Err(ShadowError::Options(format!("expected 2 to {MOST_CHILDREN} children, found {arity}")));
        }
        let mut joined = join_all(set);
        let root = joined.len() - 1;
        for k in set.len()..=root {
            widen(&mut joined, k, arity);
        }
        let mut tree = Self { nodes: Vec::new(), leaves: Vec::new(), origin: set.origin() };
        tree.lay_out(set, &joined, root);
        tree.number_leaves(0);
        Ok(tree)
    }

    /// A tree from its parts, as a file has them, about the origin of the mesh's frame.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if they are no tree, or a ball does not contain its children.
    pub fn from_parts(nodes: Vec<SphereNode>, leaves: Vec<u32>) -> Result<Self, ShadowError> {
        check(&nodes, &leaves).map_err(ShadowError::Options)?;
        Ok(Self { nodes, leaves, origin: [0.0; 3] })
    }

    /// The same tree about another origin: all of it is moved.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if it is not finite.
    pub fn with_origin(self, origin: [f64; 3]) -> Result<Self, ShadowError> {
        if !origin.iter().all(|c| c.is_finite()) {
            return Err(ShadowError::Options(format!("expected a finite origin of spheres, found {origin:?}")));
        }
        Ok(Self { origin, ..self })
    }

    /// The point of the mesh's own frame from which centers count, that of the set.
    #[must_use]
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// The nodes, the root first, parents before children and the children of a node side by side.
    #[must_use]
    pub fn nodes(&self) -> &[SphereNode] {
        &self.nodes
    }

    /// The indices of the spheres of the set, so that those below a node are side by side.
    #[must_use]
    pub fn leaves(&self) -> &[u32] {
        &self.leaves
    }

    /// The children of a node.
    ///
    /// # Panics
    /// If there is no such node.
    #[must_use]
    pub fn children(&self, node: usize) -> &[SphereNode] {
        let SphereNode { first_child, children, .. } = self.nodes[node];
        &self.nodes[first_child as usize..(first_child + children) as usize]
    }

    /// The spheres below a node, as indices into the set.
    ///
    /// # Panics
    /// If there is no such node.
    #[must_use]
    pub fn leaves_below(&self, node: usize) -> &[u32] {
        let SphereNode { first_leaf, leaf_count, .. } = self.nodes[node];
        &self.leaves[first_leaf as usize..(first_leaf + leaf_count) as usize]
    }

    /// Appends the nodes level by level. A leaf first keeps the index of its sphere.
    fn lay_out(&mut self, set: &SphereSet, joined: &[Joined], root: usize) {
        let mut from = vec![root];
        let mut next = 0;
        while next < from.len() {
            let node = &joined[from[next]];
            let is_leaf = node.children.is_empty();
            let (center, radius) = if is_leaf {
                (set.centers()[from[next]], set.radii()[from[next]])
            } else {
                let slack = SLACK * (node.radius + node.center.abs().max_element());
                (node.center.as_vec3().to_array(), (node.radius + slack) as f32)
            };
            let first_child = if is_leaf { 0 } else { from.len() as u32 };
            let first_leaf = if is_leaf { from[next] as u32 } else { 0 };
            let children = node.children.len() as u32;
            self.nodes.push(SphereNode { center, radius, first_child, children, first_leaf, leaf_count: 1 });
            from.extend(&node.children);
            next += 1;
        }
    }

    /// Lists the leaves below a node in order.
    fn number_leaves(&mut self, root: usize) {
        // Nodes that are entered, and, after what is below them, left.
        let mut stack = vec![(root, false)];
        while let Some((index, is_left)) = stack.pop() {
            let node = self.nodes[index];
            let here = self.leaves.len() as u32;
            if is_left {
                self.nodes[index].leaf_count = here - node.first_leaf;
            } else if node.is_leaf() {
                self.leaves.push(node.first_leaf);
                self.nodes[index].first_leaf = here;
            } else {
                self.nodes[index].first_leaf = here;
                stack.push((index, true));
                let children = node.first_child as usize..(node.first_child + node.children) as usize;
                stack.extend(children.rev().map(|child| (child, false)));
            }
        }
    }
}

/// The smallest ball around two.
fn around(a: &Joined, b: &Joined) -> (DVec3, f64) {
    let distance = a.center.distance(b.center);
    if distance + b.radius <= a.radius {
        return (a.center, a.radius);
    }
    if distance + a.radius <= b.radius {
        return (b.center, b.radius);
    }
    let radius = 0.5 * (distance + a.radius + b.radius);
    (a.center + (b.center - a.center) * ((radius - a.radius) / distance), radius)
}

/// The spheres of the set, and after them the nodes they are joined to, the root last.
fn join_all(set: &SphereSet) -> Vec<Joined> {
    let leaf = |(c, r): (&[f32; 3], &f32)| Joined {
        center: DVec3::from_array(c.map(f64::from)),
        radius: f64::from(*r),
        children: Vec::new(),
    };
    let mut joined: Vec<Joined> = set.centers().iter().zip(set.radii()).map(leaf).collect();
    let mut free: Vec<usize> = (0..joined.len()).collect();
    let mut partners: Vec<Option<(usize, f64)>> = vec![None; joined.len()];
    for k in 0..joined.len() {
        partners[k] = partner(&joined, &free, k);
    }
    while free.len() > 1 {
        let width = |k: usize| partners[k].map_or(f64::INFINITY, |(_, width)| width);
        let Some(&a) = free.iter().min_by(|a, b| width(**a).total_cmp(&width(**b))) else { break };
        let Some((b, _)) = partners[a] else { break };
        let (center, radius) = around(&joined[a], &joined[b]);
        let new = joined.len();
        joined.push(Joined { center, radius, children: vec![a.min(b), a.max(b)] });
        free.retain(|&k| k != a && k != b);
        free.push(new);
        partners.push(partner(&joined, &free, new));
        for &k in &free {
            if k == new {
                continue;
            }
            let (_, with_new) = around(&joined[k], &joined[new]);
            match partners[k] {
                Some((old, _)) if old == a || old == b => partners[k] = partner(&joined, &free, k),
                Some((_, width)) if width <= with_new => {}
                _ => partners[k] = Some((new, with_new)),
            }
        }
    }
    joined
}

/// The node with which another has the smallest ball, and its radius.
fn partner(joined: &[Joined], free: &[usize], of: usize) -> Option<(usize, f64)> {
    let others = free.iter().filter(|&&k| k != of).map(|&k| (k, around(&joined[of], &joined[k]).1));
    others.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Replaces the largest child by its children while there is room. Nodes below are done.
fn widen(joined: &mut [Joined], node: usize, arity: usize) {
    let mut children = joined[node].children.clone();
    loop {
        let room = arity - children.len();
        let fits = |k: &usize| (2..=room + 1).contains(&joined[*k].children.len());
        let largest = children.iter().copied().filter(fits);
        let Some(largest) = largest.max_by(|a, b| joined[*a].radius.total_cmp(&joined[*b].radius)) else { break };
        let place = children.iter().position(|&k| k == largest).unwrap_or(0);
        children.splice(place..=place, joined[largest].children.iter().copied());
    }
    joined[node].children = children;
}

/// What is wrong with the parts of a tree.
fn check(nodes: &[SphereNode], leaves: &[u32]) -> Result<(), String> {
    let mut seen = vec![false; leaves.len()];
    for (place, &leaf) in leaves.iter().enumerate() {
        match seen.get_mut(leaf as usize) {
            Some(seen) if !*seen => *seen = true,
            _ => {
                return Err(format!(
                    "expected every sphere once among {} leaves, found {leaf} at {place}",
                    leaves.len()
                ));
            }
        }
    }
    let Some(root) = nodes.first() else { return Err("expected nodes, found none".to_owned()) };
    if (root.first_leaf, root.leaf_count as usize) != (0, leaves.len()) {
        return Err(format!("expected a root above {} leaves, found {}", leaves.len(), root.leaf_count));
    }
    let mut next = 1_u64;
    for (index, node) in nodes.iter().enumerate() {
        let fault = |what: &str| Err(format!("expected {what} at node {index}, found {node:?}"));
        let is_finite = node.center.iter().all(|x| x.is_finite()) && node.radius.is_finite();
        if !(is_finite && node.radius >= 0.0) {
            return fault("a finite ball");
        }
        if node.is_leaf() {
            if node.leaf_count != 1 || node.first_leaf as usize >= leaves.len() {
                return fault("a leaf of one sphere");
            }
            continue;
        }
        let children = u64::from(node.children);
        if u64::from(node.first_child) != next || next + children > nodes.len() as u64 {
            return fault("children level by level");
        }
        let mut leaf = u64::from(node.first_leaf);
        for child in &nodes[next as usize..(next + children) as usize] {
            if u64::from(child.first_leaf) != leaf {
                return fault("leaves side by side");
            }
            leaf += u64::from(child.leaf_count);
            if !contains(node, child) {
                return fault("a ball around its children");
            }
        }
        if leaf != u64::from(node.first_leaf) + u64::from(node.leaf_count) {
            return fault("as many leaves as its children have");
        }
        next += children;
    }
    if next == nodes.len() as u64 { Ok(()) } else { Err(format!("expected {next} nodes, found {}", nodes.len())) }
}

/// Whether a ball contains another, up to the rounding of single precision.
fn contains(node: &SphereNode, child: &SphereNode) -> bool {
    let [a, b] = [node, child].map(|n| DVec3::from_array(n.center.map(f64::from)));
    let size = f64::from(node.radius) + a.abs().max_element();
    a.distance(b) + f64::from(child.radius) <= f64::from(node.radius) + SLACK * size
}
