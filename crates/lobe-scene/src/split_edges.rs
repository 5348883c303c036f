//! Smaller triangles without cracks.

use std::collections::HashMap;

use crate::{Mesh, MeshParts, Scene, SceneError};

/// A scene may grow to this many triangles.
const MOST_TRIANGLES: usize = 1 << 26;

impl Scene {
    /// The scene with edges split until none is longer than `max_edge`, so that light at vertices has vertices enough.
    ///
    /// Longest edges are halved first. Whether an edge is split, and where, follows from its two end points alone, so it is
    /// split alike in all triangles that have it, in other meshes too: no triangle's corner comes to lie on another's
    /// edge, and what was watertight stays so. New vertices take the mean of all attributes; the first vertices of
    /// each mesh are those it had, in their order.
    ///
    /// # Errors
    /// [`SceneError::Options`] if `max_edge` is not above zero, or the scene would have more than 2²⁶ triangles.
    pub fn split_edges(&self, max_edge: f32) -> Result<Self, SceneError> {
        if !(max_edge > 0.0 && max_edge.is_finite()) {
            return Err(SceneError::Options(format!("expected a longest edge above zero, found {max_edge}")));
        }
        let mut budget = MOST_TRIANGLES;
        let mut meshes = Vec::new();
        for mesh in self.meshes() {
            let parts = split(mesh.clone().into_parts(), max_edge, &mut budget)?;
            meshes.push(Mesh::new(parts)?);
        }
        Self::new(meshes, self.materials().to_vec(), self.textures().to_vec())
    }
}

// Every triangle is cut at the middle of its longest edge, if that is too long, and so are the two pieces, until none is.
// A middle belongs to an edge and not to a triangle: the squared length and the middle are computed from the end points
// in an order that does not depend on the triangle. Cracks cannot appear: an edge is halved in all of its triangles or
// in none. The only decision is "is it longer than max_edge", which is a property of the edge, and a triangle is finished
// only when all its edges say no. That the longest goes first decides the shape of the pieces alone. Of equally long edges
// the one whose end points come first in order of their coordinates goes first, so that duplicates are cut alike.
fn split(mut parts: MeshParts, max_edge: f32, budget: &mut usize) -> Result<MeshParts, SceneError> {
    let limit = f64::from(max_edge) * f64::from(max_edge);
    let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
    let mut finished = Vec::with_capacity(parts.triangles.len());
    let mut open = Vec::new();
    for triangle in std::mem::take(&mut parts.triangles) {
        open.push(triangle);
        while let Some(t) = open.pop() {
            let Some(k) = longest_edge(&parts.positions, t, limit) else {
                let Some(left) = budget.checked_sub(1) else {
                    let message = format!(
                        "edges of at most {max_edge} would take more than {MOST_TRIANGLES} triangles: allow longer ones"
                    );
                    return Err(SceneError::Options(message));
                };
                *budget = left;
                finished.push(t);
                continue;
            };
            let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
            let middle = *middles.entry((a.min(b), a.max(b))).or_insert_with(|| parts.middle(a, b));
            if [a, b].iter().any(|&i| parts.positions[i as usize] == parts.positions[middle as usize]) {
                // Neighbours in f32: there is nothing between them.
                finished.push(t);
                continue;
            }
            open.extend([[a, middle, c], [middle, b, c]]);
        }
    }
    parts.triangles = finished;
    Ok(parts)
}

/// Which edge of a triangle is to be split: the longest, if it is longer than allowed.
fn longest_edge(positions: &[[f32; 3]], triangle: [u32; 3], limit: f64) -> Option<usize> {
    let edge = |k: usize| ordered(positions[triangle[k] as usize], positions[triangle[(k + 1) % 3] as usize]);
    let square = |k: usize| {
        let (p, q) = edge(k);
        (0..3).map(|i| (f64::from(p[i]) - f64::from(q[i])).powi(2)).sum::<f64>()
    };
    let rank = |k: usize| (square(k), edge(k));
    let longest = (1..3).fold(0, |best, k| if rank(k) > rank(best) { k } else { best });
    (square(longest) > limit).then_some(longest)
}

/// Two points, the one with the smaller coordinates first.
fn ordered(p: [f32; 3], q: [f32; 3]) -> ([f32; 3], [f32; 3]) {
    if p <= q { (p, q) } else { (q, p) }
}

impl MeshParts {
    /// Adds a vertex halfway between two.
    fn middle(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = (a as usize, b as usize);
        push_mean(&mut self.positions, a, b);
        push_mean(&mut self.normals, a, b);
        self.uvs.iter_mut().for_each(|uvs| push_mean(uvs, a, b));
        push_mean(&mut self.colors, a, b);
        (self.positions.len() - 1) as u32
    }
}

/// The mean of two values: addition of two numbers does not depend on their order.
fn push_mean<const N: usize>(values: &mut Vec<[f32; N]>, a: usize, b: usize) {
    if let (Some(p), Some(q)) = (values.get(a).copied(), values.get(b).copied()) {
        values.push(std::array::from_fn(|k| 0.5 * (p[k] + q[k])));
    }
}
