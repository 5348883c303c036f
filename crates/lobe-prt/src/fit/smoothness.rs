//! The regularization of a fit: second differences across edges.

use glam::DVec3;

use crate::fit::fitted_vertices::FittedVertices;
use crate::receivers::edges::for_each_edge;
use crate::receivers::inset::wide;

/// Two triangles with a common edge, unfolded into a plane.
///
/// ```text
///   E = (λ_k A_k + λ_l A_l) (k·v)²
///   k ∝ (cot bₖ + cot bₗ,  cot aₖ + cot aₗ,  -cot aₖ - cot bₖ,  -cot aₗ - cot bₗ),   |k| = 1
/// ```
///
/// v are the values at the ends a and b of the edge and at the corners k and l opposite to it, cot aₖ is the cotangent
/// of the angle at a in the triangle of k, A the areas and λ the weights of the triangles. k·v is 0 for linear
/// functions: it is the change of slope across the edge [Bergou, Wardetzky, Harmon, Zorin and Grinspun 2006], made free
/// of units so that thin triangles count no more than others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hinge {
    pub(crate) unknowns: [u32; 4],
    pub(crate) weights: [f64; 4],
    /// The sum over both triangles of λ and the area.
    pub(crate) weight: f64,
}

/// The hinges of all edges of two triangles, with the weights λ of these. `unknowns` are those of the corners of each;
/// edges whose ends have values of their own in each triangle, creases, are none.
pub(crate) fn hinges(fitted: &FittedVertices<'_>, unknowns: &[[u32; 3]], lambda: &dyn Fn(usize) -> f64) -> Vec<Hinge> {
    let side = |number: u32| {
        let (triangle, k) = (number as usize / 3, number as usize % 3);
        let (own, at) = (&unknowns[triangle], fitted.face(triangle).corners().map(wide));
        let [a, b, l] = along(own, k);
        ([own[a], own[b]], Side::new(own[l], [at[a], at[b], at[l]], lambda(triangle)))
    };
    let firsts = firsts(unknowns);
    let seconds = firsts.iter().enumerate().filter(|&(_, &first)| first != NONE);
    seconds.filter_map(|(second, &first)| side(first).1.meet(side(second as u32))).collect()
}

/// The corners of an edge of a triangle, that of the smaller unknown first, and the corner opposite to it.
fn along(own: &[u32; 3], k: usize) -> [usize; 3] {
    let [i, j, l] = [k, (k + 1) % 3, (k + 2) % 3];
    if own[i] < own[j] { [i, j, l] } else { [j, i, l] }
}

/// No side.
const NONE: u32 = u32::MAX;

/// For each side of each triangle that is the second at its edge, the first.
fn firsts(unknowns: &[[u32; 3]]) -> Vec<u32> {
    let sides = || unknowns.iter().flat_map(|own| (0..3).map(move |k| along(own, k)).map(|[a, b, _]| [own[a], own[b]]));
    let mut firsts = vec![NONE; 3 * unknowns.len()];
    for_each_edge(sides, |[a, b], sides| {
        if let [first, second, ..] = *sides
            && a != b
        {
            firsts[second as usize] = first;
        }
    });
    firsts
}

/// A triangle beside an edge.
#[derive(Clone, Copy)]
struct Side {
    opposite: u32,
    /// The cotangents of the angles at the ends of the edge.
    cotangents: [f64; 2],
    /// λ and the area.
    weight: f64,
}

impl Side {
    fn new(opposite: u32, [a, b, c]: [DVec3; 3], lambda: f64) -> Self {
        let double = (b - a).cross(c - a).length();
        let cotangents = [(b - a).dot(c - a) / double, (a - b).dot(c - b) / double];
        Self { opposite, cotangents, weight: lambda * 0.5 * double }
    }

    /// Makes a hinge of the first triangle of an edge and the second one.
    fn meet(&self, ([a, b], other): ([u32; 2], Self)) -> Option<Hinge> {
        let ([ak, bk], [al, bl]) = (self.cotangents, other.cotangents);
        let weights = [bk + bl, ak + al, -ak - bk, -al - bl];
        let length = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
        let is_sound = self.opposite != other.opposite && length.is_finite() && length > 0.0;
        is_sound.then(|| Hinge {
            unknowns: [a, b, self.opposite, other.opposite],
            weights: weights.map(|w| w / length),
            weight: self.weight + other.weight,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_scene::{Mesh, MeshParts, Scene};

    fn two_triangles(positions: [[f32; 3]; 4]) -> Scene {
        let parts = MeshParts {
            positions: positions.to_vec(),
            normals: vec![[0.0, 0.0, 1.0]; 4],
            triangles: vec![[0, 1, 2], [1, 0, 3]],
            ..MeshParts::default()
        };
        Scene::new(vec![Mesh::new(parts).unwrap()], vec![], vec![]).unwrap()
    }

    /// The hinges of two triangles, whose vertices have these unknowns.
    fn hinges_of(positions: [[f32; 3]; 4], unknowns: [u32; 4]) -> Vec<Hinge> {
        let scene = two_triangles(positions);
        let fitted = FittedVertices::all(&scene).unwrap();
        let of_corners: Vec<_> = fitted.corners().iter().map(|t| t.map(|v| unknowns[v as usize])).collect();
        hinges(&fitted, &of_corners, &|_| 1.0)
    }

    #[test]
    fn a_hinge_is_the_change_of_slope_across_its_edge() {
        let positions = [[0.0, -0.3, 0.0], [0.0, 1.1, 0.0], [-0.7, 0.2, 0.0], [1.9, 0.9, 0.0]];
        let hinges = hinges_of(positions, [0, 1, 2, 3]);
        assert_eq!(hinges.len(), 1, "one inner edge");
        let value = |of: &dyn Fn([f32; 3]) -> f64| {
            let Hinge { unknowns, weights, .. } = hinges[0];
            unknowns.iter().zip(weights).map(|(&u, w)| w * of(positions[u as usize])).sum::<f64>()
        };
        for linear in [|_: [f32; 3]| 1.0, |p: [f32; 3]| f64::from(p[0]), |p: [f32; 3]| f64::from(p[1])] {
            // Rounding of f64.
            assert!(value(&linear).abs() < 1e-12, "of a linear function");
        }
        // A roof over the edge, of slope 1 on either side, and one that is twice as steep.
        let roof = value(&|p| f64::from(p[0].abs()));
        assert!(roof.abs() > 0.1 && (value(&|p| f64::from(p[0].abs() * 2.0)) / roof - 2.0).abs() < 1e-12, "{roof}");
    }

    #[test]
    fn a_hinge_does_not_change_when_the_triangles_are_folded_or_grow() {
        let of = |fold: f32, size: f32| {
            let (sin, cos) = fold.sin_cos();
            let positions = [[0.0, -0.3, 0.0], [0.0, 1.1, 0.0], [-0.7, 0.2, 0.0], [1.9 * cos, 0.9, 1.9 * sin]];
            hinges_of(positions.map(|p| p.map(|c| size * c)), [0, 1, 2, 3])[0].weights
        };
        for (found, expected) in of(0.8, 30.0).iter().zip(of(0.0, 1.0)) {
            // Positions are rounded to f32.
            assert!((found - expected).abs() < 1e-5, "{found}, {expected}");
        }
    }

    #[test]
    fn creases_borders_and_triangles_without_area_have_no_hinges() {
        let positions = [[0.0, -0.3, 0.0], [0.0, 1.1, 0.0], [-0.7, 0.2, 0.0], [1.9, 0.9, 0.0]];
        let flat = [[0.0, -0.3, 0.0], [0.0, 1.1, 0.0], [0.0, 0.2, 0.0], [1.9, 0.9, 0.0]];
        assert!(hinges_of(flat, [0, 1, 2, 3]).is_empty(), "no area");
        assert!(hinges_of(positions, [0, 0, 2, 3]).is_empty(), "no length");
    }
}
