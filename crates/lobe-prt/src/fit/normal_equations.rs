//! The normal equations of a fit at vertices.

use std::io;
use std::ops::Range;

use lobe_io::parallel;

use crate::fit::conjugate_gradients::{LANES, Lanes, solve};
use crate::fit::fitted_vertices::FittedVertices;
use crate::fit::smoothness::hinges;
use crate::fit::sparse_matrix::SparseMatrix;
use crate::fit::surface_points::area;
use crate::fit::triangle_moments::{ELEMENT, VARIANCE};
use crate::job::checkpoint::rows_at_once;
use crate::receivers::planes::shared_vertices;

/// Bytes of right-hand sides in memory, about: so many columns are solved for at a time.
const RIGHT_BYTES: usize = 256 << 20;

/// What is no unknown: a vertex of no triangle.
const NONE: u32 = u32::MAX;

/// The normal equations of all coefficients.
#[derive(Debug)]
pub(crate) struct NormalEquations<'a> {
    fitted: &'a FittedVertices<'a>,
    /// For each vertex of all meshes its unknown.
    unknowns: Vec<u32>,
    /// The unknowns of the corners of each triangle.
    corners: Vec<[u32; 3]>,
    matrix: SparseMatrix,
    /// Numbers of each vertex.
    vector: usize,
}

/// The moments of triangles from `first` on, as many as fill the rows.
pub(crate) type ReadRows<'a> = &'a dyn Fn(usize, &mut [f32]) -> io::Result<()>;

/// The weight of the regularization where the noise has a variance.
pub(crate) type Regularization<'a> = &'a dyn Fn(f64) -> f64;

impl<'a> NormalEquations<'a> {
    /// The equations for the moments of all triangles, `vector` numbers of transfer for each corner, and regularization
    /// whose weight in a triangle follows the variance of its noise.
    pub(crate) fn new(
        fitted: &'a FittedVertices<'a>,
        vector: usize,
        regularization: Regularization<'_>,
        read: ReadRows<'_>,
    ) -> io::Result<Self> {
        let (unknowns, count) = unknowns(fitted);
        let corners: Vec<_> = fitted.corners().iter().map(|t| t.map(|vertex| unknowns[vertex as usize])).collect();
        let mut elements = Vec::with_capacity(corners.len());
        for_each_row((&corners, vector), read, |_, element, _| elements.push(std::array::from_fn(|k| element[k])))?;
        let matrix = matrix(fitted, (&corners, count), &elements, regularization);
        Ok(Self { fitted, unknowns, corners, matrix, vector })
    }

    /// The fitted numbers of the vertices that are asked for. `read` gives the same moments again.
    ///
    /// Beside these numbers, memory holds 256 MiB of right-hand sides, or eight columns of them if those are more.
    pub(crate) fn solve(&self, read: ReadRows<'_>) -> io::Result<Vec<f32>> {
        let columns = RIGHT_BYTES / (size_of::<Lanes>() * self.matrix.rows()).max(1);
        self.solve_columns_at_once(columns.max(1) * LANES, read)
    }

    /// The same, so many columns at a time.
    fn solve_columns_at_once(&self, at_once: usize, read: ReadRows<'_>) -> io::Result<Vec<f32>> {
        let mut numbers = vec![0.0; self.fitted.vertices().len() * self.vector];
        for first in (0..self.vector).step_by(at_once) {
            let columns = first..(first + at_once).min(self.vector);
            let right = self.right(columns.clone(), read)?;
            let of = |(): &mut (), block: usize| solve(&self.matrix, right[block].clone());
            let blocks = parallel::map_with(right.len(), &|| (), &of);
            for (&vertex, row) in self.fitted.vertices().iter().zip(numbers.chunks_exact_mut(self.vector)) {
                let unknown = self.unknowns[vertex] as usize;
                for (part, block) in row[columns.clone()].chunks_mut(LANES).zip(&blocks) {
                    let found = block.get(unknown).copied().unwrap_or_default();
                    part.iter_mut().zip(found).for_each(|(number, found)| *number = found as f32);
                }
            }
        }
        Ok(numbers)
    }

    /// The right-hand sides of some columns, eight at a time, for each unknown.
    fn right(&self, columns: Range<usize>, read: ReadRows<'_>) -> io::Result<Vec<Vec<Lanes>>> {
        let mut right = vec![vec![[0.0; LANES]; self.matrix.rows()]; columns.len().div_ceil(LANES)];
        for_each_row((&self.corners, self.vector), read, |corners, _, moments| {
            for (corner, moments) in corners.iter().zip(moments.chunks_exact(self.vector)) {
                for (block, numbers) in right.iter_mut().zip(moments[columns.clone()].chunks(LANES)) {
                    let sums = &mut block[*corner as usize];
                    sums.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += f64::from(*number));
                }
            }
        })?;
        Ok(right)
    }
}

/// Calls `found` with the unknowns of the corners of each triangle, its element and its moments of `vector` numbers.
fn for_each_row(
    (corners, vector): (&[[u32; 3]], usize),
    read: ReadRows<'_>,
    mut found: impl FnMut(&[u32; 3], &[f32], &[f32]),
) -> io::Result<()> {
    let row = ELEMENT + 3 * vector;
    let at_once = rows_at_once(row);
    let mut rows = Vec::new();
    for (part, corners) in corners.chunks(at_once).enumerate() {
        rows.resize(corners.len() * row, 0.0);
        read(part * at_once, &mut rows)?;
        for (corners, row) in corners.iter().zip(rows.chunks_exact(row)) {
            let (element, moments) = row.split_at(ELEMENT);
            found(corners, element, moments);
        }
    }
    Ok(())
}

/// The sum of the elements of all triangles, and of the regularization, for `count` unknowns.
fn matrix(
    fitted: &FittedVertices<'_>,
    (corners, count): (&[[u32; 3]], usize),
    elements: &[[f32; ELEMENT]],
    regularization: Regularization<'_>,
) -> SparseMatrix {
    /// The places of an element's numbers.
    const PLACES: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];
    let hinges = hinges(fitted, corners, &|triangle| regularization(f64::from(elements[triangle][VARIANCE])));
    // Areas are parts of that of all, as in the moments; each triangle belongs to up to three hinges.
    let area: f64 = (0..corners.len()).map(|k| area(fitted.face(k).corners())).sum();
    let part = if area > 0.0 { 1.0 / area } else { 0.0 };
    let pairs = || (0..3).flat_map(|a| (0..3).map(move |b| (a, b)));
    let of_triangles = || {
        corners.iter().zip(elements).flat_map(move |(corners, element)| {
            pairs().map(move |(a, b)| (corners[a], corners[b], f64::from(element[PLACES[a][b]])))
        })
    };
    let of_hinges = || {
        hinges.iter().flat_map(move |hinge| {
            let weight = part * hinge.weight;
            let pairs = (0..4).flat_map(|a| (0..4).map(move |b| (a, b)));
            pairs
                .map(move |(a, b)| (hinge.unknowns[a], hinge.unknowns[b], weight * hinge.weights[a] * hinge.weights[b]))
        })
    };
    SparseMatrix::of_entries(count, || of_triangles().chain(of_hinges()))
}

/// The unknown of each vertex of all meshes, and their number.
fn unknowns(fitted: &FittedVertices<'_>) -> (Vec<u32>, usize) {
    let shared = shared_vertices(fitted.scene());
    let mut numbers = vec![NONE; shared.len()];
    fitted.corners().iter().flatten().for_each(|&vertex| numbers[shared[vertex as usize] as usize] = 0);
    let mut count = 0;
    for number in numbers.iter_mut().filter(|number| **number != NONE) {
        (*number, count) = (count, count + 1);
    }
    (shared.iter().map(|&vertex| numbers[vertex as usize]).collect(), count as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::face::SurfacePoint;
    use crate::fit::surface_points::SurfacePoints;
    use crate::fit::triangle_moments::add_moments;
    use lobe_scene::built_in;
    use lobe_testkit::Random;

    /// Numbers of transfer: more than fit into the lanes of one block.
    const VECTOR: usize = LANES + 1;

    /// The rows of all triangles, whose transfer at a point of a triangle is given.
    fn rows(fitted: &FittedVertices<'_>, transfer: &mut dyn FnMut(usize, &SurfacePoint) -> [f32; VECTOR]) -> Vec<f32> {
        let points = SurfacePoints::new(fitted, 256);
        let row = ELEMENT + 3 * VECTOR;
        let mut rows = vec![0.0; row * points.triangles()];
        for (triangle, row) in rows.chunks_exact_mut(row).enumerate() {
            let mut sums = vec![0.0; row.len()];
            let [places, _] = fitted.face(triangle).sequences(0, 0);
            for index in 0..points.count(triangle) {
                let point = fitted.face(triangle).point(index, &places);
                let weight = points.area(triangle) / f64::from(points.count(triangle));
                add_moments(&mut sums, weight, point.weights, &transfer(triangle, &point));
            }
            row.iter_mut().zip(&sums).for_each(|(number, sum)| *number = *sum as f32);
        }
        rows
    }

    fn corners(fitted: &FittedVertices<'_>, unknowns: &[u32]) -> Vec<[u32; 3]> {
        fitted.corners().iter().map(|t| t.map(|vertex| unknowns[vertex as usize])).collect()
    }

    fn solved(fitted: &FittedVertices<'_>, rows: &[f32], regularization: f64) -> Vec<f32> {
        let read = |first: usize, out: &mut [f32]| {
            let start = first * (ELEMENT + 3 * VECTOR);
            out.copy_from_slice(&rows[start..][..out.len()]);
            Ok(())
        };
        let equations = NormalEquations::new(fitted, VECTOR, &|_| regularization, &read).unwrap();
        let found = equations.solve(&read).unwrap();
        assert_eq!(equations.solve_columns_at_once(LANES, &read).unwrap(), found, "a block of columns at a time");
        found
    }

    #[test]
    fn what_lies_in_the_space_of_the_vertices_comes_back_exactly() {
        let scene = built_in::ball_over_ground(6);
        let fitted = FittedVertices::all(&scene).unwrap();
        let (unknowns, _) = unknowns(&fitted);
        let mut random = Random::new(5);
        let values: Vec<[f64; VECTOR]> =
            unknowns.iter().map(|_| std::array::from_fn(|_| random.unit() - 0.3)).collect();
        let corners = corners(&fitted, &unknowns);
        let rows = rows(&fitted, &mut |triangle, point| {
            std::array::from_fn(|k| {
                let corners = corners[triangle].iter().zip(point.weights);
                corners.map(|(&corner, weight)| weight * values[corner as usize][k]).sum::<f64>() as f32
            })
        });
        let found = solved(&fitted, &rows, 0.0);
        for (vertex, (found, &unknown)) in found.chunks_exact(VECTOR).zip(&unknowns).enumerate() {
            for (found, expected) in found.iter().zip(values[unknown as usize]) {
                // Moments are rounded to f32, and thin triangles at the poles of the ball condition little.
                let error = (f64::from(*found) - expected).abs();
                assert!(error < 1e-4, "vertex {vertex}: {found}, expected {expected}");
            }
        }
    }

    #[test]
    fn the_fit_is_the_solution_of_the_dense_normal_equations() {
        /// A weight that shows.
        const REGULARIZATION: f64 = 0.5;
        let scene = built_in::ball_over_ground(4);
        let fitted = FittedVertices::all(&scene).unwrap();
        let (unknowns, count) = unknowns(&fitted);
        let corners = corners(&fitted, &unknowns);
        let mut random = Random::new(6);
        // Each equation is a row: the weights of the unknowns, and the value they should have.
        let mut normal = vec![vec![0.0; count + 1]; count];
        let mut add = |weights: &[(usize, f64)], value: f64, importance: f64| {
            for &(i, a) in weights {
                weights.iter().for_each(|&(j, b)| normal[i][j] += importance * a * b);
                normal[i][count] += importance * a * value;
            }
        };
        let points = SurfacePoints::new(&fitted, 256);
        let rows = rows(&fitted, &mut |triangle, point| {
            let value = random.unit() as f32;
            let weights: Vec<_> =
                corners[triangle].iter().zip(point.weights).map(|(&corner, w)| (corner as usize, w)).collect();
            let importance = points.area(triangle) / f64::from(points.count(triangle));
            add(&weights, f64::from(value), importance);
            [value; VECTOR]
        });
        let area: f64 = scene.corners().map(area).sum();
        for hinge in hinges(&fitted, &corners, &|_| REGULARIZATION) {
            let weights: Vec<_> = hinge.unknowns.iter().zip(hinge.weights).map(|(&u, w)| (u as usize, w)).collect();
            add(&weights, 0.0, hinge.weight / area);
        }
        let expected = eliminated(normal);
        let found = solved(&fitted, &rows, REGULARIZATION);
        for (found, &unknown) in found.chunks_exact(VECTOR).zip(&unknowns) {
            let error = (f64::from(found[VECTOR - 1]) - expected[unknown as usize]).abs();
            // Moments are rounded to f32.
            assert!(error < 1e-4, "{}, expected {}", found[VECTOR - 1], expected[unknown as usize]);
        }
    }

    /// Gauss' elimination with the right-hand side as last column; unknowns without equations are 0.
    fn eliminated(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
        let count = rows.len();
        for pivot in 0..count {
            if rows[pivot][pivot] == 0.0 {
                continue;
            }
            let own = rows[pivot].clone();
            for (_, row) in rows.iter_mut().enumerate().filter(|(number, _)| *number != pivot) {
                let factor = row[pivot] / own[pivot];
                row.iter_mut().zip(&own).for_each(|(a, b)| *a -= factor * b);
            }
        }
        let value = |(number, row): (usize, &Vec<f64>)| {
            if row[number] == 0.0 { 0.0 } else { row[count] / row[number] }
        };
        rows.iter().enumerate().map(value).collect()
    }
}
