//! Spheres in a tree, so that many of them far away count as one.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use lobe_io::parallel;

use crate::accumulate::occluder::Occluder;
use crate::accumulate::shares::{Share, Surface};
use crate::error::ShadowError;

/// What stands for all spheres under a node, as seen from far away.
///
/// Logarithms add up, and that of a small sphere is nearly proportional to `r²/d²`. So `count` equal spheres at the common
/// center, `Σ r² c / Σ r²`, with the common radius `√(Σ r²/count)`, have nearly the same sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) center: [f32; 3],
    pub(crate) radius: f32,
    pub(crate) count: f32,
    /// What is left to them by others that they overlap.
    pub(crate) share: Share,
    /// The radius of the solid whose part they are: the largest of the spheres that each overlaps, or its own.
    pub(crate) solid: f32,
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

    fn sphere(&self) -> Occluder {
        Occluder::new(self.center, self.radius)
    }
}

/// The tree over a set of spheres, for [`SphereShadows`](crate::SphereShadows).
///
/// It is made for the places of the spheres at one time and can [follow](SphereTree::refit) them: which spheres lie together
/// stays, where they are and what stands for them is computed anew.
#[derive(Clone, Debug)]
pub struct SphereTree {
    /// In units of which there are `unit` in one of the spheres'.
    pub(crate) nodes: Vec<Node>,
    /// The sphere of each leaf, by the place of the node; `u32::MAX` for other nodes.
    pub(crate) spheres: Vec<u32>,
    pub(crate) unit: Unit,
}

impl Default for SphereTree {
    /// No spheres.
    fn default() -> Self {
        Self { nodes: Vec::new(), spheres: Vec::new(), unit: Unit::of(&[]) }
    }
}

/// Of a node that is no leaf.
const NO_SPHERE: u32 = u32::MAX;

/// The most pairs of overlapping spheres that share what they hide, each counted from both sides: a second or two of work. Spheres that
/// are fitted to solids overlap some tens of others each.
const MOST_OVERLAPS: usize = 1 << 22;

/// Spheres that are apart by less than this part of their distance may overlap: the sums of the tree are rounded.
const ROUNDING: f32 = 1e-5;

impl SphereTree {
    /// A binary tree: halves by the median along the longest side of the box of the centers, down to single spheres.
    /// Spheres of radius 0 are left out. Those that overlap [share](crate::ShadowOptions::share_overlaps) what they hide; which do is found
    /// by the tree, in `n log n` steps for `n` spheres that overlap few others each.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] of `spheres` if a number is not finite, a radius is negative, or more than 2²¹ pairs overlap.
    pub fn over(spheres: &[Occluder]) -> Result<Self, ShadowError> {
        let mut tree = Self::unshared(spheres)?;
        tree.share()?;
        Ok(tree)
    }

    /// The same of spheres each of which hides all that it hides.
    ///
    /// # Errors
    /// As [`SphereTree::over`], for any number of overlaps.
    pub(crate) fn unshared(spheres: &[Occluder]) -> Result<Self, ShadowError> {
        check(spheres)?;
        let mut members: Vec<u32> = (0..spheres.len() as u32).filter(|k| spheres[*k as usize].radius > 0.0).collect();
        let mut tree = Self::default();
        if !members.is_empty() {
            tree.push_empty();
            tree.split(0, &mut members, spheres);
            tree.place(spheres);
        }
        Ok(tree)
    }

    /// Follows spheres that have moved: the same ones, in the same order. Where one begins to have a radius, has none any longer, or is new, the
    /// tree is made anew.
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
        let mut members: Vec<u32> = self.spheres.iter().copied().filter(|k| *k != NO_SPHERE).collect();
        members.sort_unstable();
        if !(0..spheres.len() as u32).filter(|k| spheres[*k as usize].radius > 0.0).eq(members) {
            *self = Self::over(spheres)?;
            return Ok(());
        }
        self.place(spheres);
        self.share()
    }

    /// Whether there is no sphere.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    fn push_empty(&mut self) {
        let place = self.nodes.len() as u32;
        let (center, first_child, child_count) = ([0.0; 3], 0, 0);
        let (radius, count, share, solid, reach) = (0.0, 0.0, Share::Nothing, 0.0, 0.0);
        self.nodes.push(Node { center, radius, count, share, solid, reach, first_child, child_count, place });
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

    /// Puts the leaves where their spheres are, none of which shares anything, and what stands for them above.
    fn place(&mut self, spheres: &[Occluder]) {
        self.unit = Unit::of(spheres);
        for (node, which) in self.nodes.iter_mut().zip(&self.spheres).filter(|(node, _)| node.is_leaf()) {
            let Occluder { center, radius } = spheres[*which as usize];
            let (center, radius) = (self.unit.scaled(center), self.unit.length(radius));
            *node = Node { center, radius, count: 1.0, share: Share::Whole, solid: radius, reach: radius, ..*node };
        }
        self.merge();
    }

    /// Lets spheres that overlap share what they hide.
    fn share(&mut self) -> Result<(), ShadowError> {
        let surface = Surface::new();
        let found = AtomicUsize::new(0);
        let leaves: Vec<&Node> = self.nodes.iter().filter(|node| node.is_leaf()).collect();
        let shares: Vec<Option<(u32, Share, f32)>> = parallel::map(leaves.len(), &|k| {
            // Look for no more once there are too many.
            if found.load(Ordering::Relaxed) > MOST_OVERLAPS {
                return None;
            }
            let others = self.overlapping(leaves[k]);
            let all = found.fetch_add(others.len(), Ordering::Relaxed) + others.len();
            let solid = others.iter().fold(leaves[k].radius, |solid, other| solid.max(other.radius));
            (all <= MOST_OVERLAPS).then(|| (leaves[k].place, surface.share(&leaves[k].sphere(), &others), solid))
        });
        if found.into_inner() > MOST_OVERLAPS {
            let message = format!(
                "expected {} pairs of overlapping spheres at most, found more: take fewer or smaller ones, or each by itself \
                 (share_overlaps)",
                MOST_OVERLAPS / 2
            );
            return Err(ShadowError::Invalid { place: "spheres".to_owned(), message });
        }
        for (place, share, solid) in shares.into_iter().flatten() {
            let node = &mut self.nodes[place as usize];
            (node.share, node.solid) = (share, solid);
        }
        self.merge();
        Ok(())
    }

    /// Lets each sphere hide all that it hides.
    pub(crate) fn unshare(&mut self) {
        self.nodes.iter_mut().for_each(|node| (node.share, node.solid) = (Share::Whole, node.radius));
        self.merge();
    }

    /// The other spheres that reach into that of a leaf, in their order.
    fn overlapping(&self, leaf: &Node) -> Vec<Occluder> {
        let mut found = Vec::new();
        let mut waiting = vec![0];
        while let Some(k) = waiting.pop() {
            let node: &Node = &self.nodes[k];
            let together = node.reach + leaf.radius;
            let squared = squared(node.center, leaf.center);
            if node.is_leaf() {
                if node.place != leaf.place && squared < together * together {
                    found.push((self.spheres[k], node.sphere()));
                }
            } else if squared <= (together * (1.0 + ROUNDING)).powi(2) {
                waiting.extend(node.children());
            }
        }
        found.sort_unstable_by_key(|(which, _)| *which);
        found.into_iter().map(|(_, sphere)| sphere).collect()
    }

    /// Computes what stands for several from the last node, so that children come before their parents.
    fn merge(&mut self) {
        for k in (0..self.nodes.len()).rev() {
            let node = self.nodes[k];
            if !node.is_leaf() {
                self.nodes[k] = merged(node, &self.nodes[node.children()]);
            }
        }
    }
}

/// What stands for the children of a node together.
fn merged(node: Node, children: &[Node]) -> Node {
    let count: f32 = children.iter().map(|child| child.count).sum();
    let area = |child: &Node| f64::from(child.count) * f64::from(child.radius).powi(2);
    let shown = |child: &Node| area(child) * f64::from(child.share.mean());
    let (all, all_shown): (f64, f64) = (children.iter().map(area).sum(), children.iter().map(shown).sum());
    let center = [0, 1, 2].map(|axis| {
        let weighted: f64 = children.iter().map(|child| shown(child) * f64::from(child.center[axis])).sum();
        // Where nothing shows, any center between them will do.
        if all_shown > 0.0 { (weighted / all_shown) as f32 } else { children[0].center[axis] }
    });
    let part = |child: &Node| if all > 0.0 { (area(child) / all) as f32 } else { 0.0 };
    let share = Share::mixed(children.iter().map(|child| (part(child), child.share)));
    let radius = (all / f64::from(count)).sqrt() as f32;
    let solid = children.iter().map(|child| part(child) * child.solid.powi(2)).sum::<f32>().sqrt();
    let reach = children.iter().map(|child| distance(center, child.center) + child.reach).fold(0.0, f32::max);
    Node { center, radius, count, share, solid, reach, ..node }
}

fn squared(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum()
}

pub(crate) fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    squared(a, b).sqrt()
}

/// The exponent of the largest coordinate or radius of a tree: the square of what is 10²⁷ times as small is still above the
/// `NO_DISTANCE` of `aim`, and that of what is a million times as far away below the largest float.
const TOP: i32 = 40;

/// A receiver is nowhere farther than this along an axis, in the units of a tree: what is hidden from it is below 10⁻¹¹ of the sky.
const FARTHEST: f32 = 1e18;

/// The power of two by which lengths of the world become those of a tree. Shadows depend on ratios of lengths alone, and products
/// with powers of two are exact: so spheres of any size hide the same, whatever the unit of length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit(f32);

impl Unit {
    /// That by which the largest number of spheres has the exponent [`TOP`].
    fn of(spheres: &[Occluder]) -> Self {
        let numbers = spheres.iter().flat_map(|s| s.center.into_iter().chain([s.radius]));
        let largest = numbers.fold(0.0_f32, |largest, c| largest.max(c.abs()));
        if largest == 0.0 {
            return Self(1.0);
        }
        // Subnormal numbers have the exponent -127 here, and stay as small as they are.
        let exponent = (largest.to_bits() >> MANTISSA) as i32 - BIAS;
        let power = (TOP - exponent).min(BIAS);
        Self(f32::from_bits(((power + BIAS) as u32) << MANTISSA))
    }

    fn length(self, length: f32) -> f32 {
        self.0 * length
    }

    /// A point of the world in the units of the tree.
    pub(crate) fn scaled(self, p: [f32; 3]) -> [f32; 3] {
        p.map(|c| (self.0 * c).clamp(-FARTHEST, FARTHEST))
    }

    /// A sphere in the world.
    pub(crate) fn of_world(self, sphere: Occluder) -> Occluder {
        Occluder::new(sphere.center.map(|c| c / self.0), sphere.radius / self.0)
    }
}

/// Bits of the mantissa of an `f32`, and the bias of its exponent.
const MANTISSA: u32 = 23;
const BIAS: i32 = 127;

fn check(spheres: &[Occluder]) -> Result<(), ShadowError> {
    let is_fine = |s: &Occluder| s.center.iter().all(|c| c.is_finite()) && s.radius.is_finite() && s.radius >= 0.0;
    if let Some(k) = spheres.iter().position(|sphere| !is_fine(sphere)) {
        let message = format!("expected finite centers and radii, radii of 0 or more, found {:?}", spheres[k]);
        return Err(ShadowError::Invalid { place: format!("sphere {k}"), message });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    fn strewn(count: usize, largest: f64) -> Vec<Occluder> {
        let mut random = Random::new(3);
        let mut sphere = || {
            let center = [0, 1, 2].map(|_| random.signed() as f32);
            Occluder::new(center, (largest * random.unit().powi(3)) as f32)
        };
        (0..count).map(|_| sphere()).collect()
    }

    #[test]
    fn the_tree_finds_the_overlaps_that_all_pairs_find() {
        for largest in [0.05, 0.3, 1.5] {
            let spheres = strewn(300, largest);
            let tree = SphereTree::unshared(&spheres).unwrap();
            for leaf in tree.nodes.iter().filter(|node| node.is_leaf()) {
                let own = tree.spheres[leaf.place as usize] as usize;
                let pairs = |k: &usize| {
                    let sum = spheres[own].radius + spheres[*k].radius;
                    *k != own
                        && spheres[*k].radius > 0.0
                        && squared(spheres[own].center, spheres[*k].center) < sum * sum
                };
                let expected: Vec<Occluder> = (0..spheres.len()).filter(pairs).map(|k| spheres[k]).collect();
                let found: Vec<Occluder> = tree.overlapping(leaf).into_iter().map(|s| tree.unit.of_world(s)).collect();
                assert_eq!(found, expected, "sphere {own} of radii up to {largest}");
            }
        }
    }

    #[test]
    fn spheres_that_all_overlap_are_refused_in_one_line() {
        let many = vec![Occluder::new([1.0, 2.0, 3.0], 0.5); 50_000];
        let message = SphereTree::over(&many).unwrap_err().to_string();
        assert!(message.starts_with("spheres: expected 2097152 pairs") && !message.contains('\n'), "{message}");
        assert!(SphereTree::unshared(&many).is_ok(), "each by itself they are no matter");
    }

    #[test]
    fn a_tree_is_the_same_in_every_unit_of_length() {
        let spheres = strewn(50, 0.3);
        let tree = SphereTree::over(&spheres).unwrap();
        for exponent in [-60, -20, 50, 120] {
            let by = 2.0_f32.powi(exponent);
            let scaled = |s: &Occluder| Occluder::new(s.center.map(|c| by * c), by * s.radius);
            let scaled: Vec<Occluder> = spheres.iter().map(scaled).collect();
            assert_eq!(SphereTree::over(&scaled).unwrap().nodes, tree.nodes, "2^{exponent}");
        }
    }
}
