//! Conjugate gradients for several right-hand sides at once.

use crate::fit::sparse_matrix::SparseMatrix;

/// Right-hand sides that are solved for side by side.
pub(crate) const LANES: usize = 8;

/// Numbers of one row, a lane for each right-hand side.
pub(crate) type Lanes = [f64; LANES];

/// The residual at the end, as a part of that of zero: below the rounding of the `f32` that results become.
const TOLERANCE: f64 = 1e-8;

/// Steps at most. Where nothing but regularization decides, in what nobody sees, convergence is slow and does not
/// matter.
const MOST_STEPS: usize = 500;

/// Solves `A x = b` for a symmetric positive semidefinite matrix; rows whose diagonal is zero get zero.
///
/// Steps are scaled by the diagonal. For the matrix of the moments of triangles alone, that bounds the condition number
/// by 4 whatever their shapes [Wathen 1987], so that some twenty steps suffice. The result depends on the arguments
/// alone.
pub(crate) fn solve(matrix: &SparseMatrix, right: Vec<Lanes>) -> Vec<Lanes> {
    let inverse: Vec<f64> = (0..matrix.rows()).map(|row| inverse(matrix.diagonal(row))).collect();
    let mut x = vec![[0.0; LANES]; right.len()];
    let mut residual = right;
    let mut direction: Vec<Lanes> = residual.iter().zip(&inverse).map(|(r, d)| r.map(|r| r * d)).collect();
    let mut product = vec![[0.0; LANES]; x.len()];
    let mut energy = dot(&residual, &direction);
    let goal = energy.map(|energy| energy * TOLERANCE * TOLERANCE);
    for _ in 0..MOST_STEPS {
        if (0..LANES).all(|k| energy[k] <= goal[k]) {
            break;
        }
        // Go along the direction as far as the error becomes less.
        multiply(matrix, &direction, &mut product);
        let curvature = dot(&direction, &product);
        let step: Lanes = std::array::from_fn(|k| quotient(energy[k], curvature[k]));
        for row in 0..x.len() {
            for k in 0..LANES {
                x[row][k] += step[k] * direction[row][k];
                residual[row][k] -= step[k] * product[row][k];
            }
        }
        // Take the next direction, conjugate to all before.
        let next = residual.iter().zip(&inverse).fold([0.0; LANES], |mut sum, (r, d)| {
            (0..LANES).for_each(|k| sum[k] += r[k] * r[k] * d);
            sum
        });
        for ((p, r), d) in direction.iter_mut().zip(&residual).zip(&inverse) {
            for k in 0..LANES {
                p[k] = r[k] * d + quotient(next[k], energy[k]) * p[k];
            }
        }
        energy = next;
    }
    x
}

/// `1/d`, or 0 for a row without entries.
fn inverse(diagonal: f64) -> f64 {
    if diagonal > 0.0 { 1.0 / diagonal } else { 0.0 }
}

/// A quotient of which both are 0 once a right-hand side is solved.
fn quotient(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

fn multiply(matrix: &SparseMatrix, x: &[Lanes], product: &mut [Lanes]) {
    for (row, out) in product.iter_mut().enumerate() {
        *out = [0.0; LANES];
        for (column, value) in matrix.row(row) {
            (0..LANES).for_each(|k| out[k] += value * x[column][k]);
        }
    }
}

fn dot(a: &[Lanes], b: &[Lanes]) -> Lanes {
    let mut sum = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        (0..LANES).for_each(|k| sum[k] += a[k] * b[k]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    #[test]
    fn the_solution_of_a_product_is_what_was_multiplied() {
        // The second difference of a line plus a little, and a row of nothing.
        let rows = 50;
        let entries = || {
            (0..rows as u32 - 1).flat_map(move |row| {
                let next = (row + 1) % (rows as u32 - 1);
                [(row, row, 1.1), (next, next, 1.0), (row, next, -1.0), (next, row, -1.0)]
            })
        };
        let matrix = SparseMatrix::of_entries(rows, entries);
        let mut random = Random::new(4);
        let mut expected: Vec<Lanes> = (0..rows).map(|_| std::array::from_fn(|_| random.unit() - 0.5)).collect();
        expected[rows - 1] = [0.0; LANES];
        let mut right = vec![[0.0; LANES]; rows];
        multiply(&matrix, &expected, &mut right);
        let found = solve(&matrix, right);
        let worst = found.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs());
        let worst = worst.fold(0.0, f64::max);
        // The tolerance times the condition number, some 40.
        assert!(worst < 1e-6, "off by {worst}");
    }
}
