//! A tree over the triangles of a surface that answers, for a ball, what of the surface is in it and what solid angle
//! the rest fills, without looking at most of the triangles.
//!
//! A node is a patch of the surface with a box around it.
//!
//! * A patch whose box is in the ball adds the volume of its cones, `Σ n·(a - c) A / 3`, which two sums over its
//!   triangles give for every c.
//! * A patch whose box is outside fills a solid angle that depends on its rim alone: any other surface in the box with
//!   the same rim fills the same, since both together are closed and the center is not in the box. The other surface
//!   is a fan over the edges of the rim, of which a patch of T triangles has about √T. [Jacobson, Kavan and
//!   Sorkine-Hornung 2013] Patches of unconnected triangles have longer rims than that; they are opened instead.
//! * The rest is opened; at a leaf, [`triangle_in_ball`] answers.
//!
//! All of it is exact up to rounding.

use std::collections::HashMap;

use glam::DVec3;

use crate::spheres::far_part::{Split, solid_angle, triangle_in_ball};

/// Triangles of a leaf: a rim of fewer is hardly shorter than the patch.
const LEAF: usize = 4;

/// Nodes on the way from the root to a leaf at most: every level halves the patch, and there are at most 2²⁶
/// triangles.
const DEPTH: usize = 28;

/// Triangles of a fan whose solid angles are added as one product at most: four to this power is far from overflowing.
const MOST_AT_ONCE: f64 = 32.0;

/// A patch of the surface. Its left child, if any, is the next node.
struct Node {
    min: DVec3,
    max: DVec3,
    triangles: [u32; 2],
    /// The right child; 0 for a leaf.
    right: u32,
    /// Σ n A and Σ n·a A.
    area: DVec3,
    moment: f64,
    /// Where the edges of the rim are, if they are worth it.
    rim: Option<[u32; 2]>,
}

/// An edge of a rim: the smaller vertex, the larger one, and how many times more often it runs from the smaller to the
/// larger than back.
type Edge = (u32, u32, i32);

/// The tree. Vertices at equal places are one.
pub(crate) struct PatchTree {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    nodes: Vec<Node>,
    rims: Vec<[u32; 2]>,
    is_closed: bool,
}

impl PatchTree {
    /// The tree of at least one triangle.
    pub(crate) fn new(corners: impl Iterator<Item = [[f32; 3]; 3]>) -> Self {
        let (vertices, triangles) = welded(corners);
        let mut tree = Self { vertices, triangles, nodes: Vec::new(), rims: Vec::new(), is_closed: false };
        let count = tree.triangles.len();
        let rim = tree.build(0, count);
        tree.is_closed = rim.is_empty();
        tree
    }

    pub(crate) fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    pub(crate) fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    pub(crate) fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize])
    }

    /// The unit normals of the vertices, weighted by the area of their triangles; zero where these cancel.
    pub(crate) fn vertex_normals(&self) -> Vec<DVec3> {
        let mut normals = vec![DVec3::ZERO; self.vertices.len()];
        for (t, triangle) in self.triangles.iter().enumerate() {
            let [a, b, c] = self.corners(t);
            triangle.iter().for_each(|&v| normals[v as usize] += (b - a).cross(c - a));
        }
        normals.into_iter().map(DVec3::normalize_or_zero).collect()
    }

    /// Whether every edge is used as often in one direction as in the other.
    pub(crate) fn is_closed(&self) -> bool {
        self.is_closed
    }

    pub(crate) fn bounds(&self) -> [DVec3; 2] {
        [self.nodes[0].min, self.nodes[0].max]
    }

    /// The signed volume of the cones from a point to all triangles.
    pub(crate) fn cone_volume(&self, apex: DVec3) -> f64 {
        (self.nodes[0].moment - self.nodes[0].area.dot(apex)) / 3.0
    }

    /// Turns every triangle over.
    pub(crate) fn turn_over(&mut self) {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self.rims.iter_mut().for_each(|edge| edge.swap(0, 1));
        for node in &mut self.nodes {
            (node.area, node.moment) = (-node.area, -node.moment);
        }
    }

    /// What a ball sees of the surface.
    pub(crate) fn seen(&self, center: DVec3, radius: f64) -> Split {
        let mut seen = Split::default();
        let square = radius * radius;
        self.visit(|node, is_leaf| {
            let nearest = center.clamp(node.min, node.max).distance_squared(center);
            let farthest = (center - node.min).abs().max((node.max - center).abs()).length_squared();
            if farthest <= square {
                seen.near_volume += (node.moment - node.area.dot(center)) / 3.0;
                seen.near_area += node.area;
                return false;
            }
            if nearest >= square
                && nearest > 0.0
                && let Some(angle) = self.rim_angle(node, center)
            {
                seen.far_angle += angle;
                return false;
            }
            if is_leaf {
                for triangle in node.triangles[0]..node.triangles[1] {
                    let corners = self.corners(triangle as usize).map(|p| p - center);
                    seen.add(triangle_in_ball(corners, radius));
                }
            }
            true
        });
        seen
    }

    /// The signed solid angle of the whole surface seen from a point.
    pub(crate) fn angle(&self, point: DVec3) -> f64 {
        let mut sum = 0.0;
        self.visit(|node, is_leaf| {
            let is_outside = point.cmplt(node.min).any() || point.cmpgt(node.max).any();
            if is_outside && let Some(angle) = self.rim_angle(node, point) {
                sum += angle;
                return false;
            }
            if is_leaf {
                let triangles = node.triangles[0]..node.triangles[1];
                sum += triangles.map(|t| solid_angle(self.corners(t as usize).map(|p| p - point))).sum::<f64>();
            }
            true
        });
        sum
    }

    /// Visits nodes from the root on, the children of those for which `open` says so; it is also told whether there
    /// are none.
    fn visit(&self, mut open: impl FnMut(&Node, bool) -> bool) {
        let mut stack = [0_u32; DEPTH + 1];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let index = stack[depth];
            let node = &self.nodes[index as usize];
            if open(node, node.right == 0) && node.right != 0 {
                stack[depth] = node.right;
                stack[depth + 1] = index + 1;
                depth += 2;
            }
        }
    }

    /// The signed solid angle of a fan over the rim, if it is kept.
    ///
    /// With unit vectors to its corners, the solid angle of a triangle is twice the argument of `1 + a·b + b·c + c·a +
    /// i a·(b×c)`. The arguments of several add up in the product, which saves arc tangents as long as the sum is
    /// below π for sure: each triangle of the fan lies in the box, and so fills less than the ball around the box, `2π
    /// (1 - √(1 - s²))` for a ball of radius s times its distance.
    fn rim_angle(&self, node: &Node, center: DVec3) -> Option<f64> {
        let [start, end] = node.rim?;
        let rim = &self.rims[start as usize..end as usize];
        let Some(&[first, _]) = rim.first() else { return Some(0.0) };
        let s2 = 0.25 * node.min.distance_squared(node.max) / (node.min.midpoint(node.max)).distance_squared(center);
        let at_once = if s2 < 1.0 { (1.0 / (1.0 - (1.0 - s2).sqrt())).clamp(1.0, MOST_AT_ONCE) as usize } else { 1 };
        let direction = |v: u32| (self.vertices[v as usize] - center).normalize();
        let apex = direction(first);
        let mut sum = 0.0;
        for edges in rim.chunks(at_once) {
            let (mut re, mut im) = (1.0, 0.0);
            for &[u, v] in edges {
                if u != first && v != first {
                    let (b, c) = (direction(u), direction(v));
                    let (x, y) = (1.0 + apex.dot(b) + b.dot(c) + c.dot(apex), apex.dot(b.cross(c)));
                    (re, im) = (re * x - im * y, re * y + im * x);
                }
            }
            sum += 2.0 * f64::atan2(im, re);
        }
        Some(sum)
    }

    /// Makes the nodes of some of the triangles, and returns the rim.
    fn build(&mut self, start: usize, end: usize) -> Vec<Edge> {
        let index = self.nodes.len();
        let mut node = self.node(start, end);
        self.nodes.push(self.node(start, end));
        let rim = if end - start <= LEAF {
            rim_of(&self.triangles[start..end])
        } else {
            self.split(start, end);
            let middle = usize::midpoint(start, end);
            let left = self.build(start, middle);
            node.right = self.nodes.len() as u32;
            let right = self.build(middle, end);
            merged(&left, &right)
        };
        let edges: usize = rim.iter().map(|edge| edge.2.unsigned_abs() as usize).sum();
        if edges < end - start {
            let first = self.rims.len() as u32;
            for &(u, v, times) in &rim {
                let edge = if times > 0 { [u, v] } else { [v, u] };
                self.rims.extend((0..times.unsigned_abs()).map(|_| edge));
            }
            node.rim = Some([first, self.rims.len() as u32]);
        }
        self.nodes[index] = node;
        rim
    }

    fn node(&self, start: usize, end: usize) -> Node {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut area, mut moment) = (DVec3::ZERO, 0.0);
        for triangle in start..end {
            let [a, b, c] = self.corners(triangle);
            min = min.min(a).min(b).min(c);
            max = max.max(a).max(b).max(c);
            let half = (b - a).cross(c - a) * 0.5;
            area += half;
            moment += half.dot(a);
        }
        Node { min, max, triangles: [start as u32, end as u32], right: 0, area, moment, rim: None }
    }

    /// Puts the half of the triangles with the smaller middles along the longest axis first.
    fn split(&mut self, start: usize, end: usize) {
        let vertices = &self.vertices;
        let middle = |t: &[u32; 3]| t.iter().map(|&v| vertices[v as usize]).sum::<DVec3>();
        let part = &mut self.triangles[start..end];
        let (min, max) = part
            .iter()
            .map(middle)
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), m| (min.min(m), max.max(m)));
        let axis = (max - min).max_position();
        let half = usize::midpoint(start, end) - start;
        // Triangles of equal middles are told apart by their vertices, so that the order is always the same.
        part.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]).then_with(|| a.cmp(b)));
    }
}

/// Vertices by their places, and triangles of them.
fn welded(corners: impl Iterator<Item = [[f32; 3]; 3]>) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut vertices, mut numbers) = (Vec::new(), HashMap::new());
    let triangles = corners.map(|triangle| {
        triangle.map(|p| {
            // Adding 0 makes -0 to 0.
            *numbers.entry(p.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                vertices.push(DVec3::from_array(p.map(f64::from)));
                (vertices.len() - 1) as u32
            })
        })
    });
    let triangles = triangles.collect();
    (vertices, triangles)
}

/// The rim of a few triangles, in order.
fn rim_of(triangles: &[[u32; 3]]) -> Vec<Edge> {
    let edges = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let edges = edges.filter(|[u, v]| u != v).map(|[u, v]| if u < v { (u, v, 1) } else { (v, u, -1) });
    let mut edges: Vec<Edge> = edges.collect();
    edges.sort_unstable();
    merged(&edges, &[])
}

/// Two lists of edges in order as one; those that run as often back as forth are none.
fn merged(left: &[Edge], right: &[Edge]) -> Vec<Edge> {
    let (mut i, mut j) = (0, 0);
    let mut all: Vec<Edge> = Vec::with_capacity(left.len() + right.len());
    while i < left.len() || j < right.len() {
        let take_left = j == right.len() || (i < left.len() && (left[i].0, left[i].1) <= (right[j].0, right[j].1));
        let edge = if take_left { left[i] } else { right[j] };
        (i, j) = if take_left { (i + 1, j) } else { (i, j + 1) };
        match all.last_mut() {
            Some(last) if (last.0, last.1) == (edge.0, edge.1) => last.2 += edge.2,
            _ => {
                if all.last().is_some_and(|last| last.2 == 0) {
                    all.pop();
                }
                all.push(edge);
            }
        }
    }
    if all.last().is_some_and(|last| last.2 == 0) {
        all.pop();
    }
    all
}
