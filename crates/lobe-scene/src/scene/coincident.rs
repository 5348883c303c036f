//! Coincident triangles: duplicates among the triangles of a scene.

use crate::scene::scene::Scene;

impl Scene {
    /// The number of triangles that have the corners of another one that comes before, in any order: duplicates, such as
    /// of a node that is there twice. Of each only the first is hit where the surface has no holes, and a
    /// [`Bvh`](crate::Bvh) has no others.
    ///
    /// In n log n. Corners are told apart by a hash of 64 bits.
    #[must_use]
    pub fn coincident_triangles(&self) -> usize {
        let mut hashes: Vec<u64> = self.corners().map(hash).collect();
        hashes.sort_unstable();
        hashes.windows(2).filter(|pair| pair[0] == pair[1]).count()
    }
}

/// A hash of three corners, whatever their order.
fn hash(corners: [[f32; 3]; 3]) -> u64 {
    // Zero has two signs.
    let mut bits = corners.map(|p| p.map(|c| (c + 0.0).to_bits()));
    bits.sort_unstable();
    bits.as_flattened().iter().fold(0, |hash: u64, &word| {
        let hash = (hash ^ u64::from(word)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        hash ^ hash >> 29
    })
}

#[cfg(test)]
mod tests {
    use crate::built_in;
    use crate::scene::mesh::{Mesh, MeshParts};
    use crate::scene::scene::Scene;

    #[test]
    fn triangles_at_the_place_of_others_are_counted_whatever_the_order_of_their_corners() {
        let parts = MeshParts {
            positions: vec![[0.0, -0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -0.0], [0.0, 1.0, 1e-7]],
            triangles: vec![[0, 1, 2], [2, 1, 3], [0, 1, 4], [1, 2, 0]],
            ..MeshParts::default()
        };
        let mesh = Mesh::new(parts).unwrap();
        let count = |meshes: Vec<Mesh>| Scene::new(meshes, vec![], vec![]).unwrap().coincident_triangles();
        assert_eq!(count(vec![mesh.clone()]), 2, "two of four at the place of the first");
        assert_eq!(count(vec![mesh; 3]), 10, "twelve at two places");
        for name in built_in::NAMES {
            assert_eq!(built_in::named(name).unwrap().coincident_triangles(), 0, "{name}");
        }
    }
}
