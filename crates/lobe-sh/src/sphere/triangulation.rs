//! Triangulations of the sphere, by subdividing an icosahedron.

use crate::once::Once;
use crate::prelude::*;
use crate::sphere::vector::{cross, dot, unit};

/// A spherical triangle inside a cap.
///
/// The cap about `center` that holds the three corners, at most a half sphere, holds the triangle: a point of it is
/// `x = Σ a_k v_k / |Σ a_k v_k|` with `a_k >= 0`, and `center·x >= cos ρ Σ a_k / |Σ a_k v_k| >= cos ρ`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    corners: [[f64; 3]; 3],
    /// The direction of the sum of the corners.
    pub(crate) center: [f64; 3],
    /// The largest angle to a corner, with a margin for gaps that the rounding of midpoints may open.
    pub(crate) radius: f64,
}

/// Rounding moves corners by some 1e-16 off the edges they divide.
const SLACK: f64 = 1e-14;

impl Triangle {
    fn new(corners: [[f64; 3]; 3]) -> Self {
        let [a, b, c] = corners;
        let center = unit([0, 1, 2].map(|k| a[k] + b[k] + c[k]));
        let square = |v: [f64; 3]| {
            let d = [0, 1, 2].map(|k| v[k] - center[k]);
            dot(d, d)
        };
        let chord = square(a).max(square(b)).max(square(c)).sqrt();
        Self { corners, center, radius: 2.0 * (0.5 * chord).asin() + SLACK }
    }

    /// The four triangles between corners and midpoints of edges.
    pub(crate) fn quarters(&self) -> [Self; 4] {
        let [a, b, c] = self.corners;
        let middle = |p: [f64; 3], q: [f64; 3]| unit([0, 1, 2].map(|k| p[k] + q[k]));
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].map(Self::new)
    }
}

/// The finest triangulation that is kept: 5120 triangles.
const LEVELS: usize = 5;

/// The first level with at least two triangles for each coefficient of a function of `order`, or the last but one.
fn level_for(order: usize) -> usize {
    (0..LEVELS - 1).find(|level| 20 << (2 * level) >= 2 * order * order).unwrap_or(LEVELS - 1)
}

/// The components of the centers of the triangulation one level finer than [`triangulation`].
pub(crate) fn fine_directions(order: usize) -> [&'static [f64]; 3] {
    static DIRECTIONS: [Once<[Vec<f64>; 3]>; LEVELS] = [const { Once::new() }; LEVELS];
    let level = (level_for(order) + 1).min(LEVELS - 1);
    let directions = DIRECTIONS[level]
        .get_or_init(|| [0, 1, 2].map(|k| triangulation_of_level(level).iter().map(|t| t.center[k]).collect()));
    directions.each_ref().map(Vec::as_slice)
}

/// An icosahedron subdivided until there are at least two triangles for each coefficient of a function of `order`, at
/// most to the last level but one.
pub(crate) fn triangulation(order: usize) -> &'static [Triangle] {
    triangulation_of_level(level_for(order))
}

fn triangulation_of_level(level: usize) -> &'static [Triangle] {
    static TRIANGULATIONS: [Once<Vec<Triangle>>; LEVELS] = [const { Once::new() }; LEVELS];
    TRIANGULATIONS[level].get_or_init(|| {
        (0..level).fold(icosahedron(), |triangles, _| triangles.iter().flat_map(Triangle::quarters).collect())
    })
}

/// The triples of the twelve corners `(0, ±1, ±g)` and their cyclic permutations, `g` the golden ratio, that are one
/// edge apart.
fn icosahedron() -> Vec<Triangle> {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut corners = Vec::new();
    for a in [-1.0, 1.0] {
        for b in [-golden, golden] {
            corners.extend([[0.0, a, b], [b, 0.0, a], [a, b, 0.0]].map(unit));
        }
    }
    let near = |i: usize, j: usize| dot(corners[i], corners[j]) > 0.3;
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(k, i) {
                    let outwards = dot(corners[i], cross(corners[j], corners[k])) > 0.0;
                    let (j, k) = if outwards { (j, k) } else { (k, j) };
                    triangles.push(Triangle::new([corners[i], corners[j], corners[k]]));
                }
            }
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::directions;

    #[test]
    fn triangles_cover_the_sphere_once() {
        for order in [1, 4, 10, 20, 64] {
            let triangles = triangulation(order);
            // Girard: the area is the excess, here by Eriksson's formula tan(E/2) = det / (1 + ..).
            let area: f64 = triangles
                .iter()
                .map(|t| {
                    let [a, b, c] = t.corners;
                    2.0 * dot(a, cross(b, c)).atan2(1.0 + dot(a, b) + dot(b, c) + dot(c, a))
                })
                .sum();
            let sphere = 4.0 * core::f64::consts::PI;
            assert!((area - sphere).abs() < 1e-11, "{} triangles cover {area}", triangles.len());
            for v in directions() {
                let inside = |t: &Triangle| dot(t.center, v) >= t.radius.cos();
                assert!(triangles.iter().any(inside), "{v:?} is in no cap of {}", triangles.len());
            }
        }
        assert_eq!(icosahedron().len(), 20, "faces of the icosahedron");
    }

    #[test]
    fn quarters_lie_in_the_cap_of_the_whole() {
        for whole in triangulation(1) {
            for part in whole.quarters() {
                for corner in part.corners {
                    assert!(dot(corner, whole.center).min(1.0).acos() <= whole.radius, "{corner:?} of {whole:?}");
                }
                assert!(part.radius < 0.62 * whole.radius, "{} of {}", part.radius, whole.radius);
            }
        }
    }
}
