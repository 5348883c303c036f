//! Cell tree of a cube map: each cell holds Chebyshev nodes that carry the light of all its texels.

use std::f64::consts::PI;

use lobe_io::parallel;
use lobe_sh::Dir;
use lobe_sh::sphere::gauss_legendre;

use crate::map::cube_map::CubeMap;
use crate::mapping::cube::{self, FACES};
use crate::mapping::mapping::Mapping;
use crate::mapping::solid_angles::SolidAngles;

// A smooth function K is, over a cell, nearly its polynomial through the P x P nodes p_jk of that cell. So
//
//     ∫_cell L K ds  ≈  Σ_jk K(p_jk) m_jk        m_jk = ∫_cell L l_j(a) l_k(b) ds
//
// with the Lagrange polynomials l of the nodes: the moments m are computed exactly, once for all K (the black-box fast
// multipole method of Fong and Darve 2009). The error is that of the interpolation, and small as soon as the cell is
// smaller than K's features, however rough L is: a sun between nodes is as accurate as one on a node. As the parent's l
// are polynomials too, a parent's moments follow from those of its children and not from the texels.

/// Nodes along the side of a cell. Of 4, 6, 8 and 10, eight is the fastest at an error of 1e-3.
pub(crate) const SIDE: usize = 8;

/// Nodes of a cell.
pub(crate) const NODES: usize = SIDE * SIDE;

/// Planes of the nodes' data: `x`, `y`, `z`, area, area times red, green, blue.
pub(crate) const PLANES: usize = 7;

/// The nodes of a cell.
pub(crate) type Cell = [[f32; NODES]; PLANES];

/// Before its moments are known.
const NO_CELL: Cell = [[0.0; NODES]; PLANES];

/// A part of a row of texels that lies in one cell.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    /// The texel.
    pub(crate) texel: usize,
    /// Its extent on the face, in `[0, 1]`.
    pub(crate) range: [f64; 2],
    /// The fraction of the texel's width.
    part: f64,
    /// The mean of every Lagrange polynomial over the piece.
    means: [f64; SIDE],
}

/// The tree: cells of depth `k` have a side of `1/2^k` of their face.
pub(crate) struct CellTree<'a> {
    pub(crate) source: &'a CubeMap,
    solid_angles: SolidAngles,
    /// For each column of the deepest cells, its pieces of texels.
    pub(crate) pieces: Vec<Vec<Piece>>,
    /// The cells of each depth, face after face, row after row.
    pub(crate) levels: Vec<Vec<Cell>>,
}

impl<'a> CellTree<'a> {
    /// The greatest depth at which a cell has at least as many texels as nodes.
    pub(crate) fn last_depth(size: usize) -> usize {
        size.div_ceil(SIDE).next_power_of_two().ilog2() as usize
    }

    pub(crate) fn new(source: &'a CubeMap, depth: usize) -> Self {
        let size = source.size();
        let solid_angles = SolidAngles::of(Mapping::Cube, size, FACES * size);
        let pieces = (0..1 << depth).map(|column| pieces(size, column, 1 << depth)).collect();
        let mut tree = Self { source, solid_angles, pieces, levels: Vec::new() };
        let mut levels = vec![tree.deepest(depth)];
        for k in (0..depth).rev() {
            let children = &levels[levels.len() - 1];
            levels.push(parents(children, k));
        }
        levels.reverse();
        tree.levels = levels;
        tree
    }

    pub(crate) fn depth(&self) -> usize {
        self.levels.len() - 1
    }

    /// The moments of the cells of the deepest level, from the texels.
    fn deepest(&self, depth: usize) -> Vec<Cell> {
        let side = 1 << depth;
        let mut cells = vec![NO_CELL; FACES * side * side];
        parallel::fill(&mut cells, side, &|i| {
            let (face, column, row) = place(i, depth);
            let mut masses = [[0.0; NODES]; 4];
            for down in &self.pieces[row] {
                let mut line = [[0.0; SIDE]; 4];
                for along in &self.pieces[column] {
                    let texel = down.texel * self.source.size() + along.texel;
                    let area = self.solid_angles.get(along.texel, down.texel) * down.part * along.part;
                    let light = self.source.face(face)[texel].to_array().map(f64::from);
                    let light = [area, area * light[0], area * light[1], area * light[2]];
                    for (line, light) in line.iter_mut().zip(light) {
                        for (sum, mean) in line.iter_mut().zip(&along.means) {
                            *sum += light * mean;
                        }
                    }
                }
                spread(&mut masses, &line, &down.means);
            }
            cell(i, depth, &masses)
        });
        cells
    }
}

/// Face, column and row of cell `i` of a depth.
pub(crate) fn place(i: usize, depth: usize) -> (usize, usize, usize) {
    let side = 1 << depth;
    (i / (side * side), i % side, i / side % side)
}

/// The four quarters of cell `i` of a depth, among the cells of the next: upper left, upper right, lower left, lower
/// right.
pub(crate) fn children_of(i: usize, depth: usize) -> [usize; 4] {
    let (face, column, row) = place(i, depth);
    let side = 2 << depth;
    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (face * side + 2 * row + dy) * side + 2 * column + dx)
}

/// `masses[k][j] += line[j] factors[k]`.
fn spread(masses: &mut [[f64; NODES]; 4], line: &[[f64; SIDE]; 4], factors: &[f64; SIDE]) {
    for (masses, line) in masses.iter_mut().zip(line) {
        for (row, factor) in masses.as_chunks_mut::<SIDE>().0.iter_mut().zip(factors) {
            for (mass, value) in row.iter_mut().zip(line) {
                *mass += value * factor;
            }
        }
    }
}

/// The moments of the cells of depth `k`, from those of the next depth.
fn parents(children: &[Cell], k: usize) -> Vec<Cell> {
    let side = 1 << k;
    // Lagrange polynomials of the parent at the nodes of its left and of its right child.
    let nodes = nodes();
    let halves = [-1.0, 1.0].map(|shift| nodes.map(|t| lagrange(0.5 * (t + shift))));
    let mut cells = vec![NO_CELL; FACES * side * side];
    parallel::fill(&mut cells, side, &|i| {
        let mut masses = [[0.0; NODES]; 4];
        for ((down, across), child) in [(0, 0), (0, 1), (1, 0), (1, 1)].into_iter().zip(children_of(i, k)) {
            let child = &children[child];
            for y in 0..SIDE {
                let mut line = [[0.0; SIDE]; 4];
                for (line, plane) in line.iter_mut().zip(&child[3..]) {
                    for (x, factors) in halves[across].iter().enumerate() {
                        let mass = f64::from(plane[y * SIDE + x]);
                        for (sum, factor) in line.iter_mut().zip(factors) {
                            *sum += mass * factor;
                        }
                    }
                }
                spread(&mut masses, &line, &halves[down][y]);
            }
        }
        cell(i, k, &masses)
    });
    cells
}

/// Cell `i` of a depth, with the directions and moments of its nodes.
fn cell(i: usize, depth: usize, masses: &[[f64; NODES]; 4]) -> Cell {
    let (face, column, row) = place(i, depth);
    let nodes = nodes();
    let scale = 1.0 / (1_usize << depth) as f64;
    let at = |i: usize, t: f64| (i as f64 + 0.5 + 0.5 * t) * scale;
    let mut cell = [[0.0; NODES]; PLANES];
    for (y, b) in nodes.iter().enumerate() {
        for (x, a) in nodes.iter().enumerate() {
            let s = cube::dir_from_face(face, at(column, *a), at(row, *b)).to_array();
            for k in 0..3 {
                cell[k][y * SIDE + x] = s[k] as f32;
            }
        }
    }
    for (plane, masses) in cell[3..].iter_mut().zip(masses) {
        for (to, mass) in plane.iter_mut().zip(masses) {
            *to = *mass as f32;
        }
    }
    cell
}

/// The texels, or pieces of them, in column `column` of `columns` columns of cells.
fn pieces(size: usize, column: usize, columns: usize) -> Vec<Piece> {
    let rule = gauss_legendre(SIDE / 2);
    // In units of 1/(size columns) of a face all ends are integers.
    let (start, end) = (column * size, (column + 1) * size);
    (start / columns..end.div_ceil(columns))
        .map(|texel| {
            let range = [start.max(texel * columns), end.min((texel + 1) * columns)];
            let unit = (size * columns) as f64;
            let local = range.map(|at| 2.0 * (at - start) as f64 / size as f64 - 1.0);
            let mut means = [0.0; SIDE];
            for (x, weight) in &rule {
                let t = 0.5 * (local[0] + local[1]) + 0.5 * x * (local[1] - local[0]);
                for (mean, value) in means.iter_mut().zip(lagrange(t)) {
                    *mean += 0.5 * weight * value;
                }
            }
            let part = (range[1] - range[0]) as f64 / columns as f64;
            Piece { texel, range: range.map(|at| at as f64 / unit), part, means }
        })
        .collect()
}

/// The Chebyshev nodes in `[-1, 1]`.
pub(crate) fn nodes() -> [f64; SIDE] {
    std::array::from_fn(|j| (PI * (SIDE as f64 - j as f64 - 0.5) / SIDE as f64).cos())
}

/// The Lagrange polynomials of the nodes at `t`.
pub(crate) fn lagrange(t: f64) -> [f64; SIDE] {
    let nodes = nodes();
    std::array::from_fn(|j| {
        let others = (0..SIDE).filter(|k| *k != j);
        others.map(|k| (t - nodes[k]) / (nodes[j] - nodes[k])).product()
    })
}

/// The angular size of the longest side of cell `i` of a depth, and the direction of its center.
///
/// A step `δ` on the plane of a face, in units of half its edge, is at most `δ/√(1 + r²)` wide seen from the center,
/// `r` being the distance from the middle of the face.
pub(crate) fn extent(i: usize, depth: usize) -> (Dir, f64) {
    let (face, column, row) = place(i, depth);
    let side = (1_usize << depth) as f64;
    let middle = |i: usize| (i as f64 + 0.5) / side;
    let nearest = |i: usize| 0.0_f64.clamp(2.0 * i as f64 / side - 1.0, 2.0 * (i + 1) as f64 / side - 1.0);
    let (a, b) = (nearest(column), nearest(row));
    (cube::dir_from_face(face, middle(column), middle(row)), 2.0 / side / (1.0 + a * a + b * b).sqrt())
}

#[cfg(test)]
mod tests {
    use lobe_sh::{Coefficient, Rgb};
    use lobe_testkit::Random;

    use super::*;

    #[test]
    fn every_depth_holds_all_light_and_its_center() {
        let mut random = Random::new(5);
        for (size, depth) in [(64, 3), (64, 1), (63, 3), (24, 2), (5, 0), (1, 0)] {
            let mut value = || random.unit() as f32;
            let texels = (0..6 * size * size).map(|_| Rgb::new(value(), 50.0 * value(), 1.0)).collect();
            let source = CubeMap::new(size, texels).unwrap();
            let tree = CellTree::new(&source, depth);
            let mean = source.mean();
            for (k, level) in tree.levels.iter().enumerate() {
                let sum = |plane: usize| level.iter().flat_map(|cell| cell[plane]).map(f64::from).sum::<f64>();
                let found = [3, 4, 5].map(|plane| sum(plane) / (4.0 * PI));
                for (found, expected) in found.iter().zip([1.0, mean.r, mean.g]) {
                    assert!((found / expected - 1.0).abs() < 1e-6, "{size}, depth {k}: {found} against {expected}");
                }
            }
        }
    }

    #[test]
    fn a_smooth_function_is_integrated_against_rough_light() {
        // Light from one texel: ∫ K over it, from any depth whose cells are small against K.
        let size = 48;
        let axis = Dir::new([0.3, -0.5, 0.81]).unwrap();
        let kernel = |s: Dir| (2.0 * s.dot(axis)).exp();
        for (face, x, y) in [(0, 3, 40), (2, 24, 24), (5, 47, 0)] {
            let mut source = CubeMap::from_fn(size, |_| Rgb::splat(0.0));
            source.texels_mut()[(face * size + y) * size + x] = Rgb::splat(1.0);
            let tree = CellTree::new(&source, 3);
            let rule = gauss_legendre(4);
            let mut expected = 0.0;
            for (a, p) in &rule {
                for (b, q) in &rule {
                    let at = |i: usize, t: f64| (i as f64 + 0.5 + 0.5 * t) / size as f64;
                    let s = cube::dir_from_face(face, at(x, *a), at(y, *b));
                    expected += 0.25 * p * q * cube::solid_angle(size, x, y) * kernel(s);
                }
            }
            for (k, tolerance) in [(1, 1e-4), (2, 1e-5), (3, 1e-5)] {
                let mut found = 0.0;
                for cell in &tree.levels[k] {
                    for i in 0..NODES {
                        // Stored in f32, so not of length 1 in f64.
                        let s = Dir::new([0, 1, 2].map(|c| f64::from(cell[c][i]))).unwrap();
                        found += kernel(s) * f64::from(cell[4][i]);
                    }
                }
                assert!((found / expected - 1.0).abs() < tolerance, "depth {k}: {found} against {expected}");
            }
        }
    }
}
