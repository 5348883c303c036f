//! Spheres in a tree, so that many of them far away count as one.

use std::ops::Range;

use crate::ShadowError;

/// A sphere that hides what is behind it: center and radius, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occluder {
    /// The center.
    pub center: [f32; 3],
    /// The radius, 0 or more; a sphere of radius 0 hides nothing.
    pub radius: f32,
}

impl Occluder {
    /// A sphere.
    #[must_use]
    pub const fn new(center: [f32; 3], radius: f32) -> Self {
        Self { center, radius }
    }
}

/// What stands for all spheres under a node, as seen from far away.
///
/// Logarithms add up, and that of a small sphere is nearly proportional to `r²/d²`. So `count` equal spheres at the common
/// center, `Σ r² c / Σ r²`, with the common radius `√(Σ r²/count)`, have nearly the same sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) center: [f32; 3],
    pub(crate) radius: f32,
    pub(crate) count: f32,
    /// From the center to the farthest point of any of the spheres.
    pub(crate) reach: f32,
    /// The children's places among the nodes, after this one; empty for a leaf.
    pub(crate) first_child: u32,
    pub(crate) child_count: u32,
    /// The node's own place.
    pub(crate) place: u32,
}

impl Node {
    pub(crate) fn children(&self) -> Range<usize> {
        self.first_child as usize..(self.first_child + self.child_count) as usize
    }

    pub(crate) fn is_leaf(&self) -> bool {
        self.child_count == 0
    }
}

/// The tree over a set of spheres, for [`SphereShadows`](crate::SphereShadows).
///
/// [`SphereTree::over`] builds one over any spheres; [`SphereTree::from_children`] takes one that exists, such as the
/// hierarchy of a sphere set that moves. The tree is about which spheres lie together; where they are, the nodes have from the
/// spheres themselves.
#[derive(Clone, Debug, Default)]
pub struct SphereTree {
    pub(crate) nodes: Vec<Node>,
    /// The sphere of each leaf, by the place of the node; `u32::MAX` for other nodes.
    pub(crate) spheres: Vec<u32>,
}

/// Of a node that is no leaf.
const NO_SPHERE: u32 = u32::MAX;

impl SphereTree {
    /// A binary tree: halves by the median along the longest side of the box of the centers, down to single spheres.
    /// Spheres of radius 0 are left out.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] of `spheres` if a number is not finite or a radius is negative.
    pub fn over(spheres: &[Occluder]) -> Result<Self, ShadowError> {
        check(spheres)?;
        let mut members: Vec<u32> = (0..spheres.len() as u32).filter(|k| spheres[*k as usize].radius > 0.0).collect();
        let mut tree = Self::default();
        if !members.is_empty() {
            tree.push_empty();
            tree.split(0, &mut members, spheres);
            tree.refit_nodes(spheres);
        }
        Ok(tree)
    }

    /// A tree by the children of every node: `children[k]` are the places of those of node `k`, after `k`; node 0 is the
    /// root. A node without children is a leaf, and stands for the sphere `sphere_of_leaf[k]`.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] if the children are no tree, a leaf has no sphere, or as [`SphereTree::over`].
    pub fn from_children(
        children: &[Range<u32>],
        sphere_of_leaf: &[u32],
        spheres: &[Occluder],
    ) -> Result<Self, ShadowError> {
        check(spheres)?;
        let invalid = |message: String| ShadowError::Invalid { place: "tree of spheres".to_owned(), message };
        if children.len() != sphere_of_leaf.len() {
            let message =
                format!("expected a sphere for each of {} nodes, found {}", children.len(), sphere_of_leaf.len());
            return Err(invalid(message));
        }
        let mut parents = vec![0_u8; children.len()];
        let mut tree = Self::default();
        for (k, (range, sphere)) in children.iter().zip(sphere_of_leaf).enumerate() {
            let is_leaf = range.is_empty();
            if !is_leaf && (range.start as usize <= k || range.end as usize > children.len()) {
                return Err(invalid(format!("node {k}: its children {range:?} are not after it and within the tree")));
            }
            if is_leaf && *sphere as usize >= spheres.len() {
                return Err(invalid(format!("leaf {k}: there is no sphere {sphere} of {}", spheres.len())));
            }
            if !is_leaf {
                parents[range.start as usize..range.end as usize]
                    .iter_mut()
                    .for_each(|count| *count = count.saturating_add(1));
            }
            tree.push_empty();
            tree.spheres[k] = if is_leaf { *sphere } else { NO_SPHERE };
            if !is_leaf {
                (tree.nodes[k].first_child, tree.nodes[k].child_count) = (range.start, range.end - range.start);
            }
        }
        if let Some(k) = parents.iter().skip(1).position(|count| *count != 1) {
            return Err(invalid(format!("node {}: expected one parent, found {}", k + 1, parents[k + 1])));
        }
        tree.refit_nodes(spheres);
        Ok(tree)
    }

    /// Follows spheres that have moved: the same ones, in the same order.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] if a sphere of the tree is missing, or as [`SphereTree::over`].
    pub fn refit(&mut self, spheres: &[Occluder]) -> Result<(), ShadowError> {
        check(spheres)?;
        let last = self.spheres.iter().filter(|k| **k != NO_SPHERE).max();
        if let Some(last) = last.filter(|k| **k as usize >= spheres.len()) {
            let message = format!("expected the spheres of the tree, {} or more, found {}", last + 1, spheres.len());
            return Err(ShadowError::Invalid { place: "spheres".to_owned(), message });
        }
        self.refit_nodes(spheres);
        Ok(())
    }

    /// Whether there is no sphere.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    fn push_empty(&mut self) {
        let place = self.nodes.len() as u32;
        let (center, first_child, child_count) = ([0.0; 3], 0, 0);
        self.nodes.push(Node { center, radius: 0.0, count: 0.0, reach: 0.0, first_child, child_count, place });
        self.spheres.push(NO_SPHERE);
    }

    /// Makes node `k` the root of a tree over `members`.
    fn split(&mut self, k: usize, members: &mut [u32], spheres: &[Occluder]) {
        if let [only] = members {
            self.spheres[k] = *only;
            return;
        }
        let center = |m: u32| spheres[m as usize].center;
        let side = |axis: usize| {
            let (low, high) = members.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), m| {
                (low.min(center(*m)[axis]), high.max(center(*m)[axis]))
            });
            high - low
        };
        let sides = [side(0), side(1), side(2)];
        let axis = (0..3).fold(0, |best, axis| if sides[axis] > sides[best] { axis } else { best });
        members.sort_unstable_by(|a, b| center(*a)[axis].total_cmp(&center(*b)[axis]).then(a.cmp(b)));
        let (low, high) = members.split_at_mut(members.len() / 2);
        let first = self.nodes.len();
        self.push_empty();
        self.push_empty();
        (self.nodes[k].first_child, self.nodes[k].child_count) = (first as u32, 2);
        self.split(first, low, spheres);
        self.split(first + 1, high, spheres);
    }

    /// Computes the nodes from the last, so that children come before their parents.
    fn refit_nodes(&mut self, spheres: &[Occluder]) {
        for k in (0..self.nodes.len()).rev() {
            let node = self.nodes[k];
            let (center, radius, count, reach) = if node.is_leaf() {
                let sphere = spheres[self.spheres[k] as usize];
                (sphere.center, sphere.radius, 1.0, sphere.radius)
            } else {
                merged(&self.nodes[node.children()])
            };
            self.nodes[k] = Node { center, radius, count, reach, ..node };
        }
    }
}

/// What stands for these nodes together.
fn merged(nodes: &[Node]) -> ([f32; 3], f32, f32, f32) {
    let count: f32 = nodes.iter().map(|node| node.count).sum();
    let area = |node: &Node| f64::from(node.count) * f64::from(node.radius).powi(2);
    let all: f64 = nodes.iter().map(area).sum();
    let center = |axis: usize| {
        let weighted: f64 = nodes.iter().map(|node| area(node) * f64::from(node.center[axis])).sum();
        // Without any area every node is a point, and any center between them will do.
        if all > 0.0 { (weighted / all) as f32 } else { nodes[0].center[axis] }
    };
    let center = [center(0), center(1), center(2)];
    let radius = (all / f64::from(count)).sqrt() as f32;
    let reach = nodes.iter().map(|node| distance(center, node.center) + node.reach).fold(0.0, f32::max);
    (center, radius, count, reach)
}

pub(crate) fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt()
}

fn check(spheres: &[Occluder]) -> Result<(), ShadowError> {
    let is_fine = |s: &Occluder| s.center.iter().all(|c| c.is_finite()) && s.radius.is_finite() && s.radius >= 0.0;
    if let Some(k) = spheres.iter().position(|sphere| !is_fine(sphere)) {
        let message = format!("expected finite centers and radii of 0 or more, found {:?}", spheres[k]);
        return Err(ShadowError::Invalid { place: format!("sphere {k}"), message });
    }
    Ok(())
}
