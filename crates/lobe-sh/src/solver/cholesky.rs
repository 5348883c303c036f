//! The Cholesky factorization of a positive definite matrix.

use crate::prelude::*;
use crate::solver::matrix::{Matrix, add_scaled, dot};

/// The upper triangular `U` of `A = Uᵀ U`.
pub(crate) struct Cholesky(Matrix);

impl Cholesky {
    /// Column by column; `None` where rounding leaves a pivot that is not positive. Reads the upper triangle alone.
    ///
    /// ```text
    ///   U_ij = (A_ij - Σ_k<i U_ki U_kj) / U_ii        U_jj² = A_jj - Σ_k<j U_kj²
    /// ```
    pub(crate) fn new(mut a: Matrix) -> Option<Self> {
        for j in 0..a.columns() {
            for i in 0..j {
                a[(i, j)] = (a[(i, j)] - dot(&a.column(i)[..i], &a.column(j)[..i])) / a[(i, i)];
            }
            let above = &a.column(j)[..j];
            let pivot = a[(j, j)] - dot(above, above);
            if pivot.is_nan() || pivot <= 0.0 {
                return None;
            }
            a[(j, j)] = pivot.sqrt();
        }
        Some(Self(a))
    }

    /// The ratio of the smallest to the largest pivot, `U_jj²`.
    pub(crate) fn pivot_ratio(&self) -> f64 {
        let diagonal = || (0..self.0.columns()).map(|j| self.0[(j, j)]);
        (diagonal().fold(f64::INFINITY, f64::min) / diagonal().fold(0.0, f64::max)).powi(2)
    }

    /// The solution of `A x = b`.
    pub(crate) fn solve(&self, b: &[f64]) -> Vec<f64> {
        let mut x = b.to_vec();
        for j in 0..x.len() {
            x[j] = (x[j] - dot(&self.0.column(j)[..j], &x[..j])) / self.0[(j, j)];
        }
        for j in (0..x.len()).rev() {
            x[j] /= self.0[(j, j)];
            let (rest, solved) = x.split_at_mut(j);
            add_scaled(rest, &self.0.column(j)[..j], -solved[0]);
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    #[test]
    fn solutions_are_those_of_nalgebra_and_indefinite_matrices_have_none() {
        let mut random = Random::new(1);
        for size in 1..12 {
            let a = nalgebra::DMatrix::from_fn(size + 2, size, |_, _| random.signed());
            let gram = a.transpose() * &a;
            let b = random.signed_vec(size);
            let entries = |i: usize, j: usize| gram[(i, j)];
            let x = Cholesky::new(Matrix::from_fn(size, size, entries)).unwrap().solve(&b);
            let expected = gram.clone().lu().solve(&nalgebra::DVector::from_vec(b)).unwrap();
            for (x, y) in x.iter().zip(&expected) {
                assert!((x - y).abs() < 1e-10 * (1.0 + expected.norm()), "size {size}: {x} against {y}");
            }
            let shifted = Matrix::from_fn(size, size, |i, j| entries(i, j) - if i == j { 100.0 } else { 0.0 });
            assert!(Cholesky::new(shifted).is_none(), "size {size}, indefinite");
        }
        assert!(Cholesky::new(Matrix::from_fn(2, 2, |_, _| f64::NAN)).is_none(), "not a number");
        assert!(Cholesky::new(Matrix::zeros(0, 0)).is_some_and(|c| c.solve(&[]).is_empty()), "nothing");
    }
}
