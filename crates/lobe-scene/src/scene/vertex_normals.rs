//! Vertex normals: the angle-weighted mean of the adjacent triangles' normals.

use glam::{DVec3, Vec3};

/// Unit normals for all vertices: the normals of the triangles around each, weighted by their angles there.
///
/// ```text
///   n_v ∝ Σ_t  α_t n_t        α_t = angle of triangle t at v
/// ```
///
/// Weights by angle do not depend on how a flat face is divided into triangles [Thürmer and Wüthrich 1998]. Vertices
/// are not merged: where a file has two at one point, the edge between them stays hard.
///
/// A vertex of no triangle, or one whose sum vanishes, gets +z.
pub(crate) fn angle_weighted_normals(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let Some(weighted) = weighted_normals(triangle.map(|i| positions[i as usize])) else { continue };
        triangle.iter().zip(weighted).for_each(|(&i, normal)| sums[i as usize] += normal);
    }
    sums.into_iter().map(|sum| sum.try_normalize().unwrap_or(DVec3::Z).as_vec3().to_array()).collect()
}

/// What a triangle adds to the sums at its corners, `α_t n_t`; nothing without an area.
pub(crate) fn weighted_normals(corners: [[f32; 3]; 3]) -> Option<[DVec3; 3]> {
    let p = corners.map(|p| Vec3::from(p).as_dvec3());
    let normal = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize()?;
    Some([0, 1, 2].map(|k| {
        let (to_next, to_last) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
        let angle = to_next.cross(to_last).length().atan2(to_next.dot(to_last));
        angle * normal
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corner of a cube: its three faces count alike, however they are cut.
    #[test]
    fn the_normal_of_a_cubes_corner_is_its_diagonal_however_the_faces_are_cut() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]];
        let cuts: [&[[u32; 3]]; 2] = [
            &[[0, 2, 1], [0, 3, 2], [0, 1, 3]],
            // The face z = 0 in two triangles.
            &[[0, 4, 1], [0, 2, 4], [0, 3, 2], [0, 1, 3]],
        ];
        for triangles in cuts {
            let n = angle_weighted_normals(&positions, triangles)[0];
            for c in n {
                assert!((f64::from(c) + 1.0 / 3.0_f64.sqrt()).abs() < 1e-7, "{n:?}, expected -(1, 1, 1)/√3");
            }
        }
    }

    #[test]
    fn vertices_without_triangles_get_a_unit_normal() {
        let normals = angle_weighted_normals(&[[0.0; 3]; 2], &[[0, 1, 1]]);
        assert_eq!(normals, [[0.0, 0.0, 1.0]; 2], "+z");
    }
}
