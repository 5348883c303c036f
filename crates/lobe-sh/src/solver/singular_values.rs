//! Singular values of a square matrix, and least-squares solutions by them.

use crate::prelude::*;
use crate::solver::matrix::{Matrix, add_scaled, dot, norm};

/// More sweeps than any matrix of finite numbers needs: some six to ten do.
const MOST_SWEEPS: usize = 60;

/// The singular value decomposition `A = U Σ Vᵀ`.
pub(crate) struct SingularValues {
    /// `U Σ`.
    scaled: Matrix,
    v: Matrix,
    /// The diagonal of `Σ`, in the order of the columns.
    pub(crate) values: Vec<f64>,
}

impl SingularValues {
    /// By one-sided Jacobi rotations: pairs of columns of `A V` are turned until all are orthogonal to rounding.
    ///
    /// ```text
    ///   a_p' = c a_p + s a_q,  a_q' = c a_q - s a_p        a_p'·a_q' = 0        A V = U Σ
    /// ```
    ///
    /// The simplest method, and the most exact one for small values: of `k` digits of the ratio of lengths none is lost. Source: [Golub and Van Loan 2013]
    pub(crate) fn new(a: Matrix) -> Self {
        let size = a.columns();
        let (mut scaled, mut v) = (a, Matrix::identity(size));
        // Of a sum of as many products the rounding is of this size.
        let orthogonal = f64::EPSILON * (scaled.rows() as f64).sqrt();
        for _ in 0..MOST_SWEEPS {
            let mut has_turned = false;
            for p in 0..size {
                for q in p + 1..size {
                    if let Some(turn) = orthogonalizing(scaled.column(p), scaled.column(q), orthogonal) {
                        scaled.rotate_columns(p, q, turn);
                        v.rotate_columns(p, q, turn);
                        has_turned = true;
                    }
                }
            }
            if !has_turned {
                break;
            }
        }
        let values = (0..size).map(|j| norm(scaled.column(j))).collect();
        Self { scaled, v, values }
    }

    /// The largest value; 0 of none.
    pub(crate) fn largest(&self) -> f64 {
        self.values.iter().copied().fold(0.0, f64::max)
    }

    /// The `x` of least norm that minimizes `|A x - b|`, where values up to `threshold` count as zero.
    ///
    /// ```text
    ///   x = Σ_j v_j (u_j·b) / σ_j        σ_j > threshold
    /// ```
    pub(crate) fn solve(&self, b: &[f64], threshold: f64) -> Vec<f64> {
        let mut x = vec![0.0; self.values.len()];
        for (j, value) in self.values.iter().enumerate().filter(|(_, value)| **value > threshold) {
            add_scaled(&mut x, self.v.column(j), dot(self.scaled.column(j), b) / value / value);
        }
        x
    }
}

/// Cosine and sine of the turn that makes two columns orthogonal; `None` if they are.
fn orthogonalizing(a: &[f64], b: &[f64], orthogonal: f64) -> Option<[f64; 2]> {
    let (aa, bb, ab) = (dot(a, a), dot(b, b), dot(a, b));
    if ab.abs() <= orthogonal * aa.sqrt() * bb.sqrt() {
        return None;
    }
    // The smaller root t of t² + 2 ζ t = 1, the tangent.
    let zeta = (aa - bb) / (2.0 * ab);
    let t = 1.0_f64.copysign(zeta) / (zeta.abs() + zeta.hypot(1.0));
    let c = t.hypot(1.0).recip();
    Some([c, c * t])
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    #[test]
    fn solutions_are_the_shortest_of_those_with_the_least_residual() {
        let mut random = Random::new(5);
        for size in 0..12 {
            for rank in 0..=size {
                let (left, right) = (random.signed_vec(size * rank), random.signed_vec(size * rank));
                let entry =
                    |i: usize, j: usize| (0..rank).map(|k| left[i * rank + k] * right[j * rank + k]).sum::<f64>();
                let a = Matrix::from_fn(size, size, entry);
                let svd = SingularValues::new(a.clone());
                let norm_squared: f64 = (0..size).map(|j| dot(a.column(j), a.column(j))).sum();
                let squares = dot(&svd.values, &svd.values);
                assert!((norm_squared - squares).abs() <= 1e-13 * squares, "rank {rank} of {size}: {:?}", svd.values);
                let threshold = 1e-10 * svd.largest();
                let found = svd.values.iter().filter(|value| **value > threshold).count();
                assert_eq!(found, rank, "{:?}", svd.values);
                let b = random.signed_vec(size);
                let x = svd.solve(&b, threshold);
                let scale = 1e-12 * (1.0 + norm(&x)) * (1.0 + svd.largest()).powi(2);
                // The residual is orthogonal to all columns, and x to all that the matrix takes to zero.
                let residual: Vec<f64> = a.times(&x).iter().zip(&b).map(|(a, b)| a - b).collect();
                let slope = norm(&a.transposed_times(&residual));
                assert!(slope < scale, "rank {rank} of {size}: the slope {slope} at {x:?}");
                for (x, again) in x.iter().zip(svd.solve(&a.times(&x), threshold)) {
                    assert!((x - again).abs() < 1e4 * scale, "rank {rank} of {size}: {x} became {again}");
                }
            }
        }
    }

    #[test]
    fn values_of_full_rank_are_those_of_nalgebra() {
        let mut random = Random::new(6);
        for size in 1..20 {
            let entries = random.signed_vec(size * size);
            let entry = |i: usize, j: usize| entries[i * size + j];
            let theirs = nalgebra::DMatrix::from_fn(size, size, entry).singular_values();
            let mut values = SingularValues::new(Matrix::from_fn(size, size, entry)).values;
            values.sort_by(|a, b| b.total_cmp(a));
            for (a, b) in values.iter().zip(&theirs) {
                assert!((a - b).abs() < 1e-14 * size as f64, "size {size}: {a} against {b}");
            }
        }
    }

    #[test]
    fn small_values_keep_their_digits() {
        // Columns that are orthogonal, their lengths ten orders of magnitude apart, turned by an orthogonal matrix of the right.
        let scales = [1.0, 1e-5, 1e-10];
        let (c, s) = (0.8, 0.6);
        let turn = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
        let svd = SingularValues::new(Matrix::from_fn(3, 3, |i, j| turn[i][j] * scales[j]));
        for (found, expected) in svd.values.iter().zip(scales) {
            assert!((found / expected - 1.0).abs() < 1e-15, "{found} against {expected}");
        }
    }
}
