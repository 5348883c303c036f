//! The normal equations of a fit at vertices.

use std::io;

use lobe_io::parallel;
use lobe_scene::Scene;

use crate::fit::conjugate_gradients::{LANES, Lanes, solve};
use crate::fit::smoothness::hinges;
use crate::fit::sparse_matrix::SparseMatrix;
use crate::fit::triangle_moments::ELEMENT;
use crate::job::checkpoint::rows_at_once;
use crate::receivers::planes::shared_vertices;

/// The normal equations of all coefficients.
#[derive(Debug)]
pub(crate) struct NormalEquations {
    /// For each vertex of all meshes its unknown.
    unknowns: Vec<u32>,
    matrix: SparseMatrix,
    /// Right-hand sides, eight at a time, for each unknown.
    right: Vec<Vec<Lanes>>,
}

/// The moments of triangles from `first` on, as many as fill the rows.
pub(crate) type ReadRows<'a> = &'a dyn Fn(usize, &mut [f32]) -> io::Result<()>;

impl NormalEquations {
    /// The equations for the moments of all triangles, `vector` numbers of transfer for each corner, and regularization
    /// of a weight.
    pub(crate) fn new(scene: &Scene, vector: usize, regularization: f64, read: ReadRows<'_>) -> io::Result<Self> {
        let unknowns = shared_vertices(scene);
        let corners = corners(scene, &unknowns);
        let row = ELEMENT + 3 * vector;
        let mut right = vec![vec![[0.0; LANES]; unknowns.len()]; vector.div_ceil(LANES)];
        let mut elements = Vec::with_capacity(corners.len());
        // Add up the moments of each triangle.
        let at_once = rows_at_once(row);
        let mut rows = Vec::new();
        for (part, corners) in corners.chunks(at_once).enumerate() {
            rows.resize(corners.len() * row, 0.0);
            read(part * at_once, &mut rows)?;
            for (corners, row) in corners.iter().zip(rows.chunks_exact(row)) {
                let (element, moments) = row.split_at(ELEMENT);
                elements.push(std::array::from_fn::<f32, ELEMENT, _>(|k| element[k]));
                for (corner, moments) in corners.iter().zip(moments.chunks_exact(vector)) {
                    for (block, numbers) in right.iter_mut().zip(moments.chunks(LANES)) {
                        let sums = &mut block[*corner as usize];
                        sums.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += f64::from(*number));
                    }
                }
            }
        }
        let matrix = matrix(scene, &unknowns, &corners, &elements, regularization);
        Ok(Self { unknowns, matrix, right })
    }

    /// The fitted numbers of all vertices, `vector` for each.
    pub(crate) fn solve(self, vector: usize) -> Vec<f32> {
        let Self { unknowns, matrix, right } = self;
        let blocks = parallel::map_with(right.len(), &|| (), &|(), block: usize| solve(&matrix, right[block].clone()));
        let of_vertex = |&unknown: &u32| {
            let numbers = blocks.iter().flat_map(move |block| block[unknown as usize]);
            numbers.take(vector).map(|number| number as f32)
        };
        unknowns.iter().flat_map(of_vertex).collect()
    }
}

/// The unknowns of the corners of each triangle.
fn corners(scene: &Scene, unknowns: &[u32]) -> Vec<[u32; 3]> {
    let mut first = 0;
    let mut corners = Vec::with_capacity(scene.triangle_count());
    for mesh in scene.meshes() {
        corners.extend(mesh.triangles().iter().map(|t| t.map(|v| unknowns[first + v as usize])));
        first += mesh.positions().len();
    }
    corners
}

/// The sum of the elements of all triangles, and of the regularization.
fn matrix(
    scene: &Scene,
    unknowns: &[u32],
    corners: &[[u32; 3]],
    elements: &[[f32; ELEMENT]],
    regularization: f64,
) -> SparseMatrix {
    /// The places of an element's numbers.
    const PLACES: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];
    let hinges = hinges(scene, unknowns);
    // Areas are parts of that of all, as in the moments; each triangle belongs to up to three hinges.
    let area: f64 = scene.corners().map(crate::fit::surface_points::area).sum();
    let weight = if area > 0.0 { regularization / area } else { 0.0 };
    let pairs = || (0..3).flat_map(|a| (0..3).map(move |b| (a, b)));
    let of_triangles = || {
        corners.iter().zip(elements).flat_map(move |(corners, element)| {
            pairs().map(move |(a, b)| (corners[a], corners[b], f64::from(element[PLACES[a][b]])))
        })
    };
    let of_hinges = || {
        hinges.iter().flat_map(move |hinge| {
            let weight = weight * hinge.area;
            let pairs = (0..4).flat_map(|a| (0..4).map(move |b| (a, b)));
            pairs
                .map(move |(a, b)| (hinge.unknowns[a], hinge.unknowns[b], weight * hinge.weights[a] * hinge.weights[b]))
        })
    };
    SparseMatrix::of_entries(unknowns.len(), || of_triangles().chain(of_hinges()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::surface_points::{SurfacePoint, SurfacePoints};
    use crate::fit::triangle_moments::add_moments;
    use lobe_scene::built_in;
    use lobe_testkit::Random;

    /// Numbers of transfer: more than fit into the lanes of one block.
    const VECTOR: usize = LANES + 1;

    /// The rows of all triangles of a scene, whose transfer at a point of a triangle is given.
    fn rows(scene: &Scene, transfer: &mut dyn FnMut(usize, &SurfacePoint) -> [f32; VECTOR]) -> Vec<f32> {
        let points = SurfacePoints::new(scene, 256);
        let row = ELEMENT + 3 * VECTOR;
        let mut rows = vec![0.0; row * points.triangles()];
        for (triangle, row) in rows.chunks_exact_mut(row).enumerate() {
            let mut sums = vec![0.0; row.len()];
            let [places, _] = SurfacePoint::sequences(scene, 0, triangle, 0);
            for index in 0..points.count(triangle) {
                let point = SurfacePoint::new(scene, triangle, index, &places);
                let weight = points.area(triangle) / f64::from(points.count(triangle));
                add_moments(&mut sums, weight, point.weights, &transfer(triangle, &point));
            }
            row.iter_mut().zip(&sums).for_each(|(number, sum)| *number = *sum as f32);
        }
        rows
    }

    fn solved(scene: &Scene, rows: &[f32], regularization: f64) -> Vec<f32> {
        let read = |first: usize, out: &mut [f32]| {
            let start = first * (ELEMENT + 3 * VECTOR);
            out.copy_from_slice(&rows[start..][..out.len()]);
            Ok(())
        };
        NormalEquations::new(scene, VECTOR, regularization, &read).unwrap().solve(VECTOR)
    }

    #[test]
    fn what_lies_in_the_space_of_the_vertices_comes_back_exactly() {
        let scene = built_in::ball_over_ground(6);
        let unknowns = shared_vertices(&scene);
        let mut random = Random::new(5);
        let values: Vec<[f64; VECTOR]> =
            unknowns.iter().map(|_| std::array::from_fn(|_| random.unit() - 0.3)).collect();
        let corners = corners(&scene, &unknowns);
        let rows = rows(&scene, &mut |triangle, point| {
            std::array::from_fn(|k| {
                let corners = corners[triangle].iter().zip(point.weights);
                corners.map(|(&corner, weight)| weight * values[corner as usize][k]).sum::<f64>() as f32
            })
        });
        let found = solved(&scene, &rows, 0.0);
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
        let unknowns = shared_vertices(&scene);
        let (count, corners) = (unknowns.len(), corners(&scene, &unknowns));
        let mut random = Random::new(6);
        // Each equation is a row: the weights of the unknowns, and the value they should have.
        let mut normal = vec![vec![0.0; count + 1]; count];
        let mut add = |weights: &[(usize, f64)], value: f64, importance: f64| {
            for &(i, a) in weights {
                weights.iter().for_each(|&(j, b)| normal[i][j] += importance * a * b);
                normal[i][count] += importance * a * value;
            }
        };
        let points = SurfacePoints::new(&scene, 256);
        let rows = rows(&scene, &mut |triangle, point| {
            let value = random.unit() as f32;
            let weights: Vec<_> =
                corners[triangle].iter().zip(point.weights).map(|(&corner, w)| (corner as usize, w)).collect();
            let importance = points.area(triangle) / f64::from(points.count(triangle));
            add(&weights, f64::from(value), importance);
            [value; VECTOR]
        });
        let area: f64 = scene.corners().map(crate::fit::surface_points::area).sum();
        for hinge in hinges(&scene, &unknowns) {
            let weights: Vec<_> = hinge.unknowns.iter().zip(hinge.weights).map(|(&u, w)| (u as usize, w)).collect();
            add(&weights, 0.0, REGULARIZATION * hinge.area / area);
        }
        let expected = eliminated(normal);
        let found = solved(&scene, &rows, REGULARIZATION);
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
