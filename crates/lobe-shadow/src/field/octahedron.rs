//! Directions on the vertices of an octahedral grid, and between them.

/// A grid over a square, onto which the sphere is unfolded as an octahedron: `cells` × `cells` squares with
/// `(cells + 1)²` vertices.
///
/// ```text
///   p = s / (|s_x| + |s_y| + |s_z|)
///   (u, v) = (p_x, p_y)                                       for p_z >= 0
///            ((1 - |p_y|) sgn p_x, (1 - |p_x|) sgn p_y)       else                  in [-1, 1]²
/// ```
///
/// Values lie on vertices, not in the middle of texels: the border of the square is folded onto itself, vertices that
/// meet there ([`Octahedron::representative`]) hold the same value, and the bilinear interpolation is continuous over the whole
/// sphere without a neighbor across a seam ever being looked up (test `interpolation_is_continuous_everywhere`). A cube needs a choice of
/// faces for that, a subdivided icosahedron a search for the triangle. The price is that `(cells + 1)²` values are kept
/// where `cells² + 2` vertices differ, and that the smallest cells, around the axes, have a fifth of the area of the largest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Octahedron {
    pub(crate) cells: usize,
}

/// The cell of a direction: the number of its vertex of least u and v, and the place within it in `[0, 1]²`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cell {
    pub(crate) vertex: usize,
    pub(crate) place: [f32; 2],
}

impl Octahedron {
    /// Number of vertices, those that coincide counted each.
    pub(crate) fn len(self) -> usize {
        (self.cells + 1) * (self.cells + 1)
    }

    /// The first of the vertices that are folded onto this one: of the border the halves of each side meet, and all four
    /// corners.
    pub(crate) fn representative(self, vertex: usize) -> usize {
        let side = self.cells + 1;
        let [mut i, mut j] = [vertex % side, vertex / side];
        if (j == 0 || j == self.cells) && 2 * i > self.cells {
            i = self.cells - i;
        }
        if (i == 0 || i == self.cells) && 2 * j > self.cells {
            j = self.cells - j;
        }
        j * side + i
    }

    /// The unit vector of a vertex. Vertices that are folded onto each other have the same, bit by bit.
    pub(crate) fn direction(self, vertex: usize) -> [f64; 3] {
        let (side, vertex) = (self.cells + 1, self.representative(vertex));
        let [i, j] = [vertex % side, vertex / side];
        let [u, v] = [i, j].map(|k| (2 * k) as f64 / self.cells as f64 - 1.0);
        let z = 1.0 - u.abs() - v.abs();
        let p = if z >= 0.0 { [u, v, z] } else { [(1.0 - v.abs()).copysign(u), (1.0 - u.abs()).copysign(v), z] };
        let length = p.iter().map(|c| c * c).sum::<f64>().sqrt();
        p.map(|c| c / length + 0.0)
    }

    /// The cell of a direction of any length above 0.
    #[inline]
    pub(crate) fn cell(self, [x, y, z]: [f32; 3]) -> Cell {
        let scale = 1.0 / (x.abs() + y.abs() + z.abs());
        let (x, y) = (x * scale, y * scale);
        let (u, v) = if z >= 0.0 { (x, y) } else { ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)) };
        let half = 0.5 * self.cells as f32;
        let [(i, a), (j, b)] = [u, v].map(|c| {
            let c = (c + 1.0) * half;
            let k = (c as usize).min(self.cells - 1);
            (k, (c - k as f32).min(1.0))
        });
        Cell { vertex: j * (self.cells + 1) + i, place: [a, b] }
    }

    /// The four vertices of a cell with their bilinear weights.
    #[inline]
    pub(crate) fn corners(self, cell: Cell) -> [(usize, f32); 4] {
        let [a, b] = cell.place;
        let (first, next) = (cell.vertex, cell.vertex + self.cells + 1);
        [(first, (1.0 - a) * (1.0 - b)), (first + 1, a * (1.0 - b)), (next, (1.0 - a) * b), (next + 1, a * b)]
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;
    use lobe_testkit::Random;

    #[test]
    fn a_vertex_is_at_its_own_direction() {
        for cells in [2, 4, 8, 16] {
            let grid = Octahedron { cells };
            for vertex in 0..grid.len() {
                let s = grid.direction(vertex);
                let found = grid.corners(grid.cell(s.map(|c| c as f32)));
                let at: f32 = found.iter().filter(|(v, _)| grid.direction(*v) == s).map(|(_, w)| w).sum();
                assert!((at - 1.0).abs() < 1e-5, "{cells} cells, vertex {vertex} {s:?}: {found:?}");
            }
            let mut places = HashMap::new();
            for vertex in 0..grid.len() {
                *places.entry(grid.direction(vertex).map(|c| (c * 1e9).round() as i64)).or_insert(0) += 1;
            }
            assert_eq!(places.len(), cells * cells + 2, "different directions of {cells} cells");
        }
    }

    #[test]
    fn interpolation_is_continuous_everywhere() {
        // A function that differs from vertex to vertex, and steps so small that it can change by little.
        let grid = Octahedron { cells: 6 };
        let value = |vertex: usize| {
            let [x, y, z] = grid.direction(vertex);
            ((31.0 * x).sin() + (47.0 * y).sin() + (17.0 * z).sin()) as f32
        };
        let at = |s: [f64; 3]| -> f32 {
            grid.corners(grid.cell(s.map(|c| c as f32))).iter().map(|&(v, w)| w * value(v)).sum()
        };
        let mut random = Random::new(2);
        for k in 0..20000 {
            let mut s = random.direction();
            // Most of the time at the folds: the lower half's seams and the equator.
            if k % 4 > 0 {
                s[k % 3] = 0.0;
                let length = s.iter().map(|c| c * c).sum::<f64>().sqrt();
                s = s.map(|c| c / length);
            }
            let t: [f64; 3] = std::array::from_fn(|c| s[c] + 1e-5 * random.signed());
            assert!((at(s) - at(t)).abs() < 3e-3, "{s:?}: {} and {}", at(s), at(t));
        }
    }
}
