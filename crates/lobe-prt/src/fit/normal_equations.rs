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
    /// The equations for the moments of all triangles, `vector` numbers of transfer for each corner, and regularization of
    /// a weight.
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
