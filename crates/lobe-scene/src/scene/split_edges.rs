//! Edge splitting: subdivision of triangles without cracks.

use std::collections::{HashMap, HashSet};

use crate::error::SceneError;
use crate::scene::mesh::double_area;
use crate::scene::mesh::{Mesh, MeshParts};
use crate::scene::scene::Scene;

/// The most triangles of a subdivided scene.
pub(crate) const MOST_TRIANGLES: usize = 1 << 26;

/// The end points of an edge, the one with the smaller coordinates first: the same for all triangles that have it.
type Edge = ([f32; 3], [f32; 3]);

/// For each mesh the ends of its edges that were halved, the smaller index first, in the order of their new vertices.
pub type HalvedEdges = Vec<Vec<[u32; 2]>>;

impl Scene {
    /// Splits edges until none is longer than `max_edge`, so that light at vertices is resolved.
    ///
    /// Longest edges are halved first. Whether an edge is split, and where, depends on its two end points alone, so it
    /// is split alike in all triangles that have it, in other meshes too: no triangle's corner comes to lie on
    /// another's edge, and a watertight scene stays watertight. New vertices have the mean of all attributes; the first
    /// vertices of each mesh are the old ones, in their order, and [`Mesh::halved`] says where the others come from.
    ///
    /// # Errors
    /// [`SceneError::Options`] if `max_edge` is not above zero, or the scene would have more than 2²⁶ triangles.
    pub fn split_edges(&self, max_edge: f32) -> Result<Self, SceneError> {
        let limit = squared_limit(self, max_edge)?;
        Ok(self.split_where(&|edge| squared_length(edge) > limit, &goal_of(max_edge))?.0)
    }

    /// Halves chosen edges once, and with them the longest edge of each triangle that loses another edge, so that
    /// triangles keep their shape however often they are split [Rivara 1984].
    ///
    /// `is_chosen` is called for each triangle's edges by mesh and vertices. A chosen edge is halved in all triangles
    /// with an edge at that place, in other meshes too, as in [`Scene::split_edges`]. Returns the scene and the edges that
    /// were halved.
    ///
    /// # Errors
    /// [`SceneError::Options`] if the scene would have more than 2²⁶ triangles.
    pub fn halve_edges(&self, is_chosen: impl Fn(usize, [u32; 2]) -> bool) -> Result<(Self, HalvedEdges), SceneError> {
        let mut chosen = HashSet::new();
        for (m, mesh) in self.meshes().iter().enumerate() {
            for &t in mesh.triangles() {
                let edges = (0..3).filter(|&k| is_chosen(m, [t[k], t[(k + 1) % 3]]));
                chosen.extend(edges.map(|k| place(edge(mesh.positions(), t, k))));
            }
        }
        self.add_longest_edges(&mut chosen);
        self.split_where(&|edge| chosen.contains(&place(edge)), "halves of the chosen edges")
    }

    /// Adds the longest edge of each triangle with an edge that is chosen, until nothing changes.
    fn add_longest_edges(&self, chosen: &mut HashSet<[u32; 6]>) {
        loop {
            let before = chosen.len();
            for mesh in self.meshes() {
                for &t in mesh.triangles() {
                    let of = |k| place(edge(mesh.positions(), t, k));
                    if (0..3).any(|k| chosen.contains(&of(k))) {
                        chosen.extend(longest_edge(mesh.positions(), t, &|_| true).map(of));
                    }
                }
            }
            if chosen.len() == before {
                return;
            }
        }
    }

    /// `goal` describes the cause of too many triangles.
    fn split_where(
        &self,
        is_to_be_split: &dyn Fn(Edge) -> bool,
        goal: &str,
    ) -> Result<(Self, HalvedEdges), SceneError> {
        let mut budget = MOST_TRIANGLES;
        let (mut meshes, mut halved) = (Vec::new(), Vec::new());
        for mesh in self.meshes() {
            let Some((parts, edges)) = split(mesh.clone().into_parts(), is_to_be_split, &mut budget) else {
                return Err(too_many(goal));
            };
            meshes.push(Mesh::new(parts)?);
            halved.push(edges);
        }
        let scene = Self::new(meshes, self.materials().to_vec(), self.textures().to_vec())?;
        Ok((scene.moved(self.origin()), halved))
    }
}

/// The square of a longest edge, if it is above zero and the scene with no longer ones is not too large.
fn squared_limit(scene: &Scene, max_edge: f32) -> Result<f64, SceneError> {
    let limit = squared(max_edge)?;
    check_count(scene.meshes().iter().map(|mesh| (mesh, limit)), &goal_of(max_edge))?;
    Ok(limit)
}

/// The square of a longest edge, if it is above zero.
pub(crate) fn squared(max_edge: f32) -> Result<f64, SceneError> {
    if max_edge > 0.0 && max_edge.is_finite() {
        return Ok(f64::from(max_edge) * f64::from(max_edge));
    }
    Err(SceneError::Options(format!("expected a longest edge above zero, found {max_edge}")))
}

/// Refuses meshes that would have too many triangles without edges whose square is above a limit.
pub(crate) fn check_count<'a>(meshes: impl Iterator<Item = (&'a Mesh, f64)>, goal: &str) -> Result<(), SceneError> {
    // No triangle without a longer edge is larger than the equilateral one.
    let least = |(mesh, limit): (&Mesh, f64)| {
        let area: f64 = (0..mesh.triangles().len()).map(|t| 0.5 * double_area(mesh.corners(t))).sum();
        area / (0.75_f64.sqrt() / 2.0 * limit)
    };
    if meshes.map(least).sum::<f64>() > MOST_TRIANGLES as f64 { Err(too_many(goal)) } else { Ok(()) }
}

/// Splits the edges of one mesh whose squared length is above a limit, and counts its triangles off the budget. None if
/// that does not suffice. Triangles without area stay.
pub(crate) fn split_longer(mesh: &Mesh, limit: f64, budget: &mut usize) -> Option<(MeshParts, Vec<[u32; 2]>)> {
    split(mesh.clone().into_parts(), &|edge| squared_length(edge) > limit, budget)
}

pub(crate) fn goal_of(max_edge: f32) -> String {
    format!("edges of at most {max_edge}")
}

pub(crate) fn too_many(goal: &str) -> SceneError {
    SceneError::Options(format!("{goal} would take more than {MOST_TRIANGLES} triangles: allow longer ones"))
}

// Bisect every triangle at the middle of its longest edge among those to be split, and so on with the two halves, until
// none is left. The middle belongs to the edge and not to a triangle: squared length and middle are computed from the
// end points in an order that does not depend on the triangle. Cracks cannot appear: an edge is halved in all of its
// triangles or in none, because whether it is to be split is a property of the edge, and a triangle is finished only
// when none of its edges is to be split. The order of longest first affects the shape of the triangles alone. Of
// equally long edges the one whose end points come first in order of their coordinates goes first, so that duplicates
// are split alike. Returns `None` if the budget of triangles does not suffice.
//
// Beside the mesh stand the ends of the edges that were halved, in the order of their middles.
fn split(
    mut parts: MeshParts,
    is_to_be_split: &dyn Fn(Edge) -> bool,
    budget: &mut usize,
) -> Option<(MeshParts, Vec<[u32; 2]>)> {
    let mut halved = Vec::new();
    let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
    let mut finished = Vec::with_capacity(parts.triangles.len());
    let tangents = std::mem::take(&mut parts.tangents);
    let mut open = Vec::new();
    for (number, triangle) in std::mem::take(&mut parts.triangles).into_iter().enumerate() {
        open.push((triangle, tangents.get(number).copied()));
        while let Some((t, along)) = open.pop() {
            let Some(k) = longest_edge(&parts.positions, t, is_to_be_split) else {
                *budget = budget.checked_sub(1)?;
                finished.push(t);
                parts.tangents.extend(along);
                continue;
            };
            let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
            let middle = *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                halved.push([a.min(b), a.max(b)]);
                parts.middle(a, b)
            });
            if [a, b].iter().any(|&i| parts.positions[i as usize] == parts.positions[middle as usize]) {
                // Neighbors in f32: there is nothing between them.
                finished.push(t);
                parts.tangents.extend(along);
                continue;
            }
            let [first, second] = halved_tangents(along, k);
            open.extend([([a, middle, c], first), ([middle, b, c], second)]);
        }
    }
    parts.triangles = finished;
    Some((parts, halved))
}

/// The tangents at the corners of both halves of a triangle whose edge from corner `k` was halved, if it has any.
fn halved_tangents(tangents: Option<[[f32; 4]; 3]>, k: usize) -> [Option<[[f32; 4]; 3]>; 2] {
    let Some(all) = tangents else { return [None; 2] };
    let [a, b, c] = [0, 1, 2].map(|i| all[(k + i) % 3]);
    let middle = std::array::from_fn(|i| 0.5 * (a[i] + b[i]));
    [Some([a, middle, c]), Some([middle, b, c])]
}

/// The edge of a triangle to split first: the longest of those to be split.
fn longest_edge(positions: &[[f32; 3]], triangle: [u32; 3], is_to_be_split: &dyn Fn(Edge) -> bool) -> Option<usize> {
    let mut best = None;
    for k in 0..3 {
        let edge = edge(positions, triangle, k);
        let rank = (squared_length(edge), edge);
        if is_to_be_split(edge) && best.is_none_or(|(_, other)| rank > other) {
            best = Some((k, rank));
        }
    }
    best.map(|(k, _)| k)
}

/// The edge from a corner of a triangle to the next.
fn edge(positions: &[[f32; 3]], triangle: [u32; 3], k: usize) -> Edge {
    let [p, q] = [k, (k + 1) % 3].map(|k| positions[triangle[k] as usize]);
    if p <= q { (p, q) } else { (q, p) }
}

fn squared_length((p, q): Edge) -> f64 {
    (0..3).map(|i| (f64::from(p[i]) - f64::from(q[i])).powi(2)).sum()
}

/// The coordinates of an edge as a hash key, -0 and 0 being the same.
fn place((p, q): Edge) -> [u32; 6] {
    std::array::from_fn(|i| (if i < 3 { p[i] } else { q[i - 3] } + 0.0).to_bits())
}

impl MeshParts {
    /// Adds a vertex halfway between two.
    pub(crate) fn middle(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = (a as usize, b as usize);
        push_mean(&mut self.positions, a, b);
        push_mean(&mut self.normals, a, b);
        self.uvs.iter_mut().for_each(|uvs| push_mean(uvs, a, b));
        push_mean(&mut self.lightmap_uvs, a, b);
        push_mean(&mut self.colors, a, b);
        self.halved.push([a as u32, b as u32]);
        (self.positions.len() - 1) as u32
    }
}

/// Appends the mean of two values: addition of two numbers does not depend on their order.
pub(crate) fn push_mean<const N: usize>(values: &mut Vec<[f32; N]>, a: usize, b: usize) {
    if let (Some(p), Some(q)) = (values.get(a).copied(), values.get(b).copied()) {
        values.push(std::array::from_fn(|k| 0.5 * (p[k] + q[k])));
    }
}
