//! Flat meshes: triangles that share a vertex only where they lie in one plane.

use std::collections::HashMap;
use std::hash::Hash;

use glam::Vec3;

use crate::scene::mesh::MeshParts;

/// Triangles whose vertices have one normal each.
#[derive(Debug, PartialEq)]
pub(crate) struct FlatMesh {
    /// The vertices that stand behind the given ones: for each the one that it is a copy of.
    pub(crate) added: Vec<u32>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl FlatMesh {
    /// Adds vertices where triangles around a vertex have different normals. The first triangle at a vertex keeps it;
    /// one without area keeps all.
    pub(crate) fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        Self::of_keys(positions.len(), triangles, |t| unit_normal(positions, triangles[t]))
    }

    /// Gives each triangle vertices of its own, so that it stays flat wherever they move.
    pub(crate) fn unshared(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let is_there = |&vertex: &u32| (vertex as usize) < vertices;
        Self::of_keys(vertices, triangles, |t| triangles[t].iter().all(is_there).then_some(t))
    }

    /// Adds vertices where triangles around a vertex have different keys. The first triangle at a vertex keeps it; one
    /// without a key, which alone may have indices out of range, keeps all.
    pub(crate) fn of_keys<K: Copy + Eq + Hash>(
        vertices: usize,
        triangles: &[[u32; 3]],
        key: impl Fn(usize) -> Option<K>,
    ) -> Self {
        let mut first = vec![None; vertices];
        let mut others = HashMap::new();
        let mut added = Vec::new();
        let mut flat = triangles.to_vec();
        for (t, triangle) in flat.iter_mut().enumerate() {
            let Some(key) = key(t) else { continue };
            for vertex in triangle {
                if *first[*vertex as usize].get_or_insert(key) != key {
                    *vertex = *others.entry((*vertex, key)).or_insert_with(|| {
                        added.push(*vertex);
                        (vertices + added.len() - 1) as u32
                    });
                }
            }
        }
        Self { added, triangles: flat }
    }

    /// Makes the mesh that this was made of flat; its normals are to be made anew.
    pub(crate) fn apply(self, parts: &mut MeshParts) {
        fn extend<T: Copy>(values: &mut Vec<T>, added: &[u32]) {
            if !values.is_empty() {
                values.extend(added.iter().map(|&i| values[i as usize]).collect::<Vec<_>>());
            }
        }
        extend(&mut parts.positions, &self.added);
        parts.uvs.iter_mut().for_each(|uvs| extend(uvs, &self.added));
        extend(&mut parts.lightmap_uvs, &self.added);
        extend(&mut parts.colors, &self.added);
        parts.triangles = self.triangles;
    }
}

/// The bits of a triangle's unit normal, rounded; `None` without area or where an index is out of range.
pub(crate) fn unit_normal(positions: &[[f32; 3]], triangle: [u32; 3]) -> Option<[u32; 3]> {
    let corner = |i: u32| positions.get(i as usize).map(|&p| Vec3::from(p).as_dvec3());
    let [a, b, c] = triangle.map(corner);
    let (a, b, c) = (a?, b?, c?);
    // Neighbors in one plane differ by a rounding, which is more than the last bits of `f32` after the sum.
    let normal = (b - a).cross(c - a).try_normalize()?.as_vec3() + 2.0;
    Some(normal.to_array().map(f32::to_bits))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_are_added_where_planes_meet_and_nowhere_else() {
        // A square in two triangles, folded along its diagonal or not.
        let square = |z: f32| [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, z]];
        let triangles = [[0, 1, 2], [0, 2, 3], [0, 0, 1]];
        let even = FlatMesh::new(&square(0.0), &triangles);
        assert_eq!(even, FlatMesh { added: vec![], triangles: triangles.to_vec() }, "one plane");
        let folded = FlatMesh::new(&square(0.5), &triangles);
        let expected = FlatMesh { added: vec![0, 2], triangles: vec![[0, 1, 2], [4, 5, 3], [0, 0, 1]] };
        assert_eq!(folded, expected, "two planes");
        let unshared = FlatMesh::unshared(4, &[[0, 1, 2], [0, 2, 3], [0, 2, 9]]);
        let expected = FlatMesh { added: vec![0, 2], triangles: vec![[0, 1, 2], [4, 5, 3], [0, 2, 9]] };
        assert_eq!(unshared, expected, "one plane, for poses; what has an index out of range stays");
    }
}
