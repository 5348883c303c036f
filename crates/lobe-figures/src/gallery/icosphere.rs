//! An icosphere: directions spread evenly over the sphere, joined to triangles.

use std::collections::BTreeMap;

use lobe_sh::Dir;

use lobe_sh::sphere::vector::{add, cross, dot};

/// The vertices and faces of a subdivided icosahedron.
#[derive(Clone, Debug)]
pub(crate) struct Icosphere {
    pub(crate) vertices: Vec<Dir>,
    pub(crate) triangles: Vec<[usize; 3]>,
}

impl Icosphere {
    /// The icosahedron with every triangle cut into four `subdivisions` times: 12, 42, 162, .. vertices.
    pub(crate) fn new(subdivisions: usize) -> Self {
        let mut sphere = icosahedron();
        for _ in 0..subdivisions {
            sphere = sphere.subdivided();
        }
        sphere
    }

    fn subdivided(&self) -> Self {
        let mut vertices = self.vertices.clone();
        let mut middles = BTreeMap::new();
        let mut middle = |a: usize, b: usize| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let sum = add(vertices[a].to_array(), vertices[b].to_array());
                vertices.push(Dir::new(sum).unwrap_or_else(|| unreachable!("neighbors are not opposite")));
                vertices.len() - 1
            })
        };
        let mut triangles = Vec::with_capacity(4 * self.triangles.len());
        for &[a, b, c] in &self.triangles {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        Self { vertices, triangles }
    }

    /// The triangle around `s`, and the weights of its corners, which sum to 1.
    ///
    /// ```text
    ///   s ∝ w₀ v₀ + w₁ v₁ + w₂ v₂        w₀ ∝ s·(v₁ × v₂), and so on around
    /// ```
    ///
    /// The spherical barycentric coordinates of Möbius, scaled to sum to 1. On an edge the third weight is 0 and the
    /// other two depend on the ends of the edge alone, so functions mixed by them are continuous across all edges; the
    /// areas of the three spherical triangles, as weights, are so only across edges of mirrored neighbors.
    pub(crate) fn locate(&self, s: Dir) -> ([usize; 3], [f64; 3]) {
        let weights = |triangle: &[usize; 3]| {
            let [a, b, c] = triangle.map(|i| self.vertices[i].to_array());
            [cross(b, c), cross(c, a), cross(a, b)].map(|n| dot(n, s.to_array()))
        };
        let least = |w: &[f64; 3]| w[0].min(w[1]).min(w[2]);
        let candidates = self.triangles.iter().map(|t| (*t, weights(t)));
        // Rounding may put a direction on an edge a little outside both triangles: the best one will do.
        let best = candidates.reduce(|best, next| if least(&next.1) > least(&best.1) { next } else { best });
        let Some((triangle, weights)) = best else { unreachable!("an icosahedron has triangles") };
        let weights = weights.map(|w| w.max(0.0));
        let sum: f64 = weights.iter().sum();
        (triangle, weights.map(|w| w / sum))
    }
}

/// Its twelve vertices are the corners of three golden rectangles; its faces the triples of neighbors, each
/// counter-clockwise from outside.
fn icosahedron() -> Icosphere {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut corners = Vec::with_capacity(12);
    for a in [-1.0, 1.0] {
        for b in [-golden, golden] {
            corners.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]);
        }
    }
    let vertices: Vec<Dir> = corners.into_iter().filter_map(Dir::new).collect();
    // Neighbors have the cosine 1/√5, all others less.
    let near = |a: usize, b: usize| vertices[a].dot(vertices[b]) > 0.4;
    let mut triangles = Vec::with_capacity(20);
    for a in 0..vertices.len() {
        for b in a + 1..vertices.len() {
            for c in b + 1..vertices.len() {
                if near(a, b) && near(b, c) && near(c, a) {
                    let [p, q, r] = [a, b, c].map(|i| vertices[i].to_array());
                    triangles.push(if dot(p, cross(q, r)) > 0.0 { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    Icosphere { vertices, triangles }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::{Random, directions};

    use super::*;
    use lobe_sh::sphere::vector::scale;

    #[test]
    fn the_numbers_of_vertices_and_triangles_are_eulers() {
        for (subdivisions, vertices) in [(0, 12), (1, 42), (2, 162)] {
            let sphere = Icosphere::new(subdivisions);
            assert_eq!(sphere.vertices.len(), vertices, "{subdivisions} subdivisions");
            assert_eq!(sphere.triangles.len(), 2 * vertices - 4, "{subdivisions} subdivisions");
        }
    }

    #[test]
    fn the_weights_give_back_the_direction() {
        for subdivisions in [0, 1, 2] {
            let sphere = Icosphere::new(subdivisions);
            let vertices: Vec<_> = sphere.vertices.iter().map(|v| v.to_array()).collect();
            for s in directions().into_iter().chain(vertices) {
                let s = Dir::new(s).unwrap();
                let (triangle, weights) = sphere.locate(s);
                let parts: [_; 3] = std::array::from_fn(|k| scale(sphere.vertices[triangle[k]].to_array(), weights[k]));
                let back = Dir::new(add(add(parts[0], parts[1]), parts[2])).unwrap();
                assert!(back.angle_to(s) < 1e-14, "{subdivisions} subdivisions: {s:?} came back as {back:?}");
            }
        }
    }

    #[test]
    fn what_is_mixed_by_the_weights_is_continuous_across_edges() {
        let sphere = Icosphere::new(1);
        let mut random = Random::new(7);
        let values: Vec<f64> = sphere.vertices.iter().map(|_| random.signed()).collect();
        let mixed = |s: Dir| {
            let (triangle, weights) = sphere.locate(s);
            (0..3).map(|k| weights[k] * values[triangle[k]]).sum::<f64>()
        };
        for [a, b, _] in &sphere.triangles {
            let [p, q] = [a, b].map(|i| sphere.vertices[*i].to_array());
            let across = scale(cross(p, q), 1e-9);
            for k in 1..10 {
                let on = add(scale(p, 0.1 * f64::from(k)), scale(q, 1.0 - 0.1 * f64::from(k)));
                let side = |h: f64| mixed(Dir::new(add(on, scale(across, h))).unwrap());
                assert!((side(1.0) - side(-1.0)).abs() < 1e-7, "{} and {}", side(1.0), side(-1.0));
            }
        }
    }
}
