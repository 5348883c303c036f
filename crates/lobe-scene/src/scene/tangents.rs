//! Tangents: the directions of texture coordinates along a surface, as MikkTSpace computes them.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

/// The tangents at the corners of all triangles; [`Mesh::with_tangents`](crate::Mesh::with_tangents) has the formula. Indices are in
/// range, normals are unit vectors.
pub(crate) fn corner_tangents(
    positions: &[[f32; 3]],
    normals: &[[f32; 3]],
    uvs: &[[f32; 2]],
    triangles: &[[u32; 3]],
) -> Vec<[[f32; 4]; 3]> {
    let first = welded(positions, normals, uvs);
    let unfolded = |t: &[u32; 3]| {
        let corner = |i: u32| (wide(positions[i as usize]), DVec2::from(uvs[i as usize].map(f64::from)));
        Unfolded::new(t.map(corner))
    };
    // Add up what triangles contribute to their vertices, those that are mirrored in the texture by themselves.
    let mut sums = vec![[DVec3::ZERO; 2]; positions.len()];
    for t in triangles {
        let Some(triangle) = unfolded(t) else { continue };
        for (k, &i) in t.iter().enumerate() {
            let sum = &mut sums[first[i as usize] as usize][usize::from(triangle.is_mirrored)];
            *sum += triangle.at_corner(k, wide(normals[i as usize]));
        }
    }
    // Give each corner the sum of its own side, or of that which there is.
    let tangents = |t: &[u32; 3]| {
        let own = unfolded(t).map(|triangle| triangle.is_mirrored);
        t.map(|i| {
            let sums = sums[first[i as usize] as usize];
            let is_mirrored = own.unwrap_or(sums[0] == DVec3::ZERO && sums[1] != DVec3::ZERO);
            let [x, y, z] = sums[usize::from(is_mirrored)].normalize_or_zero().as_vec3().to_array();
            [x, y, z, if is_mirrored { -1.0 } else { 1.0 }]
        })
    };
    triangles.iter().map(tangents).collect()
}

/// A triangle with an area in the texture.
struct Unfolded {
    points: [DVec3; 3],
    /// The direction of u along the triangle.
    along_u: DVec3,
    /// Whether the texture shows the triangle mirrored.
    is_mirrored: bool,
}

impl Unfolded {
    /// A triangle by its points and their places in the texture; none without an area there.
    ///
    /// ```text
    ///   ∂p/∂u ∝ sign(a) (v_2 e_1 - v_1 e_2),    a = u_1 v_2 - u_2 v_1,    e_k = p_k - p_0,  (u_k, v_k) likewise
    /// ```
    ///
    /// v runs downwards: a picture seen from its front, corners counter-clockwise, has a negative area.
    fn new(corners: [(DVec3, DVec2); 3]) -> Option<Self> {
        let [(p, at), (p1, at1), (p2, at2)] = corners;
        let (first, second) = (at1 - at, at2 - at);
        let area = first.perp_dot(second);
        let along_u = (second.y * (p1 - p) - first.y * (p2 - p)) * area.signum();
        let is_mirrored = area > 0.0;
        let along_u = along_u.try_normalize().filter(|_| area != 0.0)?;
        Some(Self { points: [p, p1, p2], along_u, is_mirrored })
    }

    /// What the triangle adds to the tangent of one of its corners, of this unit normal.
    fn at_corner(&self, k: usize, normal: DVec3) -> DVec3 {
        let within = |v: DVec3| (v - normal * normal.dot(v)).normalize_or_zero();
        let p = self.points;
        let (to_next, to_last) = (within(p[(k + 1) % 3] - p[k]), within(p[(k + 2) % 3] - p[k]));
        let angle = to_next.dot(to_last).clamp(-1.0, 1.0).acos();
        angle * within(self.along_u)
    }
}

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

/// For each vertex the first that is the same in position, normal and place in the texture: files cut surfaces where other
/// attributes differ.
fn welded(positions: &[[f32; 3]], normals: &[[f32; 3]], uvs: &[[f32; 2]]) -> Vec<u32> {
    // Zero has two signs.
    let bits = |c: f32| (c + 0.0).to_bits();
    let mut first = HashMap::with_capacity(positions.len());
    let mut number = |i: usize| {
        let vertex = (positions[i].map(bits), normals[i].map(bits), uvs[i].map(bits));
        *first.entry(vertex).or_insert(i as u32)
    };
    (0..positions.len()).map(&mut number).collect()
}

#[cfg(test)]
mod tests {
    use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};

    use super::*;
    use crate::scene::vertex_normals::angle_weighted_normals;

    /// A surface whose tangents `bevy_mikktspace` computes, a port of the original.
    #[derive(Default)]
    struct Surface {
        positions: Vec<[f32; 3]>,
        normals: Vec<[f32; 3]>,
        uvs: Vec<[f32; 2]>,
        triangles: Vec<[u32; 3]>,
        theirs: Vec<[[f32; 4]; 3]>,
    }

    impl Surface {
        fn at(&self, face: usize, corner: usize) -> usize {
            self.triangles[face][corner] as usize
        }

        /// A grid of cells over the unit square of (a, b).
        fn of_grid(cells: u32, position: impl Fn(f64, f64) -> [f64; 3], uv: impl Fn(f64, f64) -> [f64; 2]) -> Self {
            let side = cells + 1;
            let mut surface = Self::default();
            for i in 0..side * side {
                let [a, b] = [i % side, i / side].map(|k| f64::from(k) / f64::from(cells));
                surface.positions.push(position(a, b).map(|c| c as f32));
                surface.uvs.push(uv(a, b).map(|c| c as f32));
            }
            for i in 0..cells * cells {
                let corner = i / cells * side + i % cells;
                let [a, b, c, d] = [corner, corner + 1, corner + side + 1, corner + side];
                surface.triangles.extend([[a, b, c], [a, c, d]]);
            }
            surface.normals = angle_weighted_normals(&surface.positions, &surface.triangles);
            surface
        }

        fn ours(&self) -> Vec<[[f32; 4]; 3]> {
            corner_tangents(&self.positions, &self.normals, &self.uvs, &self.triangles)
        }
    }

    impl Geometry for Surface {
        fn num_faces(&self) -> usize {
            self.triangles.len()
        }

        fn num_vertices_of_face(&self, _: usize) -> usize {
            3
        }

        fn position(&self, face: usize, corner: usize) -> [f32; 3] {
            self.positions[self.at(face, corner)]
        }

        fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
            self.normals[self.at(face, corner)]
        }

        fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
            self.uvs[self.at(face, corner)]
        }

        fn set_tangent(&mut self, found: Option<TangentSpace>, face: usize, corner: usize) {
            self.theirs.resize(self.triangles.len(), [[0.0; 4]; 3]);
            if let Some(found) = found {
                self.theirs[face][corner] = found.tangent_encoded();
            }
        }
    }

    #[test]
    fn tangents_are_those_of_mikktspace() {
        let wave = |a: f64, b: f64| [a, b, 0.2 * (5.0 * a + 3.0 * b).sin()];
        let turned = |a: f64, b: f64| [0.8 * a - 0.6 * b, 0.6 * a + 0.8 * b + 0.3 * a * b];
        let cases = [
            ("a wave", Surface::of_grid(9, wave, turned)),
            // The texture turns back in the middle, where both halves share their vertices.
            ("a mirrored texture", Surface::of_grid(8, wave, |a, b| [(2.0 * a - 1.0).abs(), 1.0 - b])),
        ];
        for (name, mut surface) in cases {
            generate_tangents(&mut surface).unwrap();
            let (ours, theirs) = (surface.ours(), &surface.theirs);
            for (t, (ours, theirs)) in ours.iter().zip(theirs).enumerate() {
                for ([x, y, z, w], [a, b, c, d]) in ours.iter().zip(theirs) {
                    let off = (x - a).abs().max((y - b).abs()).max((z - c).abs());
                    // Their sign is for a v that runs upwards.
                    assert!(off < 1e-5 && w == &-d, "{name}: {ours:?}, theirs {theirs:?} at triangle {t}");
                }
            }
        }
    }

    #[test]
    fn on_a_ball_tangents_run_along_the_parallels_but_for_the_poles() {
        let (tau, pi) = (std::f64::consts::TAU, std::f64::consts::PI);
        let ball = |a: f64, b: f64| {
            let ((sin_phi, cos_phi), (sin, cos)) = ((tau * a).sin_cos(), (pi * (1.0 - b)).sin_cos());
            [sin * cos_phi, sin * sin_phi, cos]
        };
        let mut surface = Surface::of_grid(32, ball, |a, b| [a, 1.0 - b]);
        surface.normals = surface.positions.clone();
        for (triangle, corners) in surface.triangles.iter().zip(surface.ours()) {
            for (&i, [x, y, z, w]) in triangle.iter().zip(corners) {
                let [px, py, pz] = surface.positions[i as usize];
                let radius = px.hypot(py);
                if radius < 0.3 {
                    continue;
                }
                // At the seam all triangles are on one side, off the parallel by half the angle of a cell.
                let along = (x * -py + y * px) / radius;
                assert!(along > 0.99 && w == 1.0, "({x}, {y}, {z}), {w} at ({px}, {py}, {pz})");
            }
        }
    }

    #[test]
    fn a_triangle_without_area_in_the_texture_takes_the_tangents_of_its_neighbors() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        // Seen from its front, and mirrored. The last place is on the line through the first and the third.
        for (uvs, expected) in [
            ([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.5, 0.5]], [1.0, 0.0, 0.0, 1.0]),
            ([[1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [0.5, 0.5]], [-1.0, 0.0, 0.0, -1.0]),
        ] {
            let found = corner_tangents(&positions, &[[0.0, 0.0, 1.0]; 4], &uvs, &[[0, 1, 2], [0, 2, 3]]);
            assert_eq!(found, [[expected; 3], [expected, expected, [0.0, 0.0, 0.0, 1.0]]], "{uvs:?}");
        }
    }

    #[test]
    fn a_triangle_without_area_in_the_texture_has_no_tangents_of_its_own() {
        for uvs in [[[0.5, 0.5]; 3], [[0.0, 0.0], [0.5, 0.5], [1.0, 1.0]]] {
            let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
            let found = corner_tangents(&positions, &[[0.0, 0.0, 1.0]; 3], &uvs, &[[0, 1, 2]]);
            assert_eq!(found, [[[0.0, 0.0, 0.0, 1.0]; 3]], "{uvs:?}");
        }
    }
}
