//! Eigenvalues and eigenvectors of a symmetric matrix.

use crate::prelude::*;
use crate::solver::householder::Reflection;
use crate::solver::matrix::{Matrix, add_scaled, dot};

/// More steps a value than any matrix of finite numbers needs: two or three do.
const MOST_STEPS: usize = 60;

/// The eigenvalue decomposition `A = V D Vᵀ`.
#[derive(Clone, Debug)]
pub(crate) struct SymmetricEigen {
    /// The diagonal of `D`, in no order.
    pub(crate) values: Vec<f64>,
    /// The eigenvectors, in the order of the values.
    pub(crate) vectors: Matrix,
}

impl SymmetricEigen {
    /// Of a matrix of finite numbers, by reflections to tridiagonal form and QR steps with Wilkinson's shift. Source: [Golub and Van Loan 2013]
    pub(crate) fn new(a: Matrix) -> Self {
        let mut form = Tridiagonal::of(a);
        form.diagonalize();
        Self { values: form.diagonal, vectors: form.vectors }
    }

    /// The largest value; -∞ of none.
    pub(crate) fn largest(&self) -> f64 {
        self.values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }
}

/// `A = V T Vᵀ`, where `T` has entries on the diagonal and beside it.
struct Tridiagonal {
    diagonal: Vec<f64>,
    beside: Vec<f64>,
    vectors: Matrix,
}

impl Tridiagonal {
    /// One reflection a column, on both sides, `A - v wᵀ - w vᵀ`.
    fn of(mut a: Matrix) -> Self {
        let size = a.columns();
        let mut vectors = Matrix::identity(size);
        for k in 1..size.max(1) {
            let Some(Reflection { v, t, image }) = Reflection::of(&a.column(k - 1)[k..]) else { continue };
            let mut w: Vec<f64> = (k..size).map(|j| t * dot(&a.column(j)[k..], &v)).collect();
            let half = 0.5 * t * dot(&w, &v);
            add_scaled(&mut w, &v, -half);
            for j in k..size {
                let column = &mut a.column_mut(j)[k..];
                add_scaled(column, &v, -w[j - k]);
                add_scaled(column, &w, -v[j - k]);
            }
            a[(k, k - 1)] = image;
            let mut sum = vec![0.0; size];
            (k..size).for_each(|j| add_scaled(&mut sum, vectors.column(j), t * v[j - k]));
            (k..size).for_each(|j| add_scaled(vectors.column_mut(j), &sum, -v[j - k]));
        }
        let diagonal = (0..size).map(|k| a[(k, k)]).collect();
        let beside = (1..size).map(|k| a[(k, k - 1)]).collect();
        Self { diagonal, beside, vectors }
    }

    /// Turns neighboring columns until nothing is beside the diagonal.
    fn diagonalize(&mut self) {
        let mut high = self.beside.len();
        for _ in 0..MOST_STEPS * self.diagonal.len() {
            while high > 0 && self.is_negligible(high - 1) {
                high -= 1;
            }
            if high == 0 {
                return;
            }
            let low = (0..high).rev().find(|&k| self.is_negligible(k)).map_or(0, |k| k + 1);
            self.step(low, high);
        }
    }

    fn is_negligible(&self, k: usize) -> bool {
        self.beside[k].abs() <= f64::EPSILON * (self.diagonal[k].abs() + self.diagonal[k + 1].abs())
    }

    /// An implicit QR step on the rows from `low` to `high`.
    fn step(&mut self, low: usize, high: usize) {
        let (d, e) = (&mut self.diagonal, &mut self.beside);
        let half = 0.5 * (d[high - 1] - d[high]);
        let last = e[high - 1];
        let shift = d[high] - last * last / (half + half.hypot(last).copysign(half));
        let (mut x, mut z) = (d[low] - shift, e[low]);
        for k in low..high {
            // The rotation that takes z to zero.
            let r = x.hypot(z);
            let (c, s) = if r == 0.0 { (1.0, 0.0) } else { (x / r, z / r) };
            if k > low {
                e[k - 1] = r;
            }
            let (p, q, w) = (d[k], d[k + 1], e[k]);
            d[k] = c * c * p + 2.0 * c * s * w + s * s * q;
            d[k + 1] = s * s * p - 2.0 * c * s * w + c * c * q;
            e[k] = c * s * (q - p) + (c * c - s * s) * w;
            if k + 1 < high {
                (x, z) = (e[k], s * e[k + 1]);
                e[k + 1] *= c;
            }
            self.vectors.rotate_columns(k, k + 1, [c, s]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    fn check(a: &Matrix) {
        let size = a.columns();
        let found = SymmetricEigen::new(a.clone());
        let mut expected =
            nalgebra::DMatrix::from_fn(size, size, |i, j| a[(i, j)]).symmetric_eigenvalues().as_slice().to_vec();
        let mut values = found.values.clone();
        expected.sort_by(f64::total_cmp);
        values.sort_by(f64::total_cmp);
        let scale = values.iter().fold(1.0, |scale: f64, x| scale.max(x.abs())) * size as f64;
        for (a, b) in values.iter().zip(&expected) {
            assert!((a - b).abs() < 1e-15 * scale, "{values:?} against {expected:?}");
        }
        for (j, value) in found.values.iter().enumerate() {
            let v = found.vectors.column(j);
            for (i, x) in a.times(v).iter().enumerate() {
                assert!((x - value * v[i]).abs() < 2e-15 * scale, "vector {j} of {size}: {x} against {}", value * v[i]);
            }
            for k in 0..size {
                let expected = f64::from(u8::from(j == k));
                let found = dot(v, found.vectors.column(k));
                assert!((found - expected).abs() < 1e-15 * size.max(8) as f64, "{j}·{k} of {size} is {found}");
            }
        }
    }

    #[test]
    fn values_are_those_of_nalgebra_and_vectors_belong_to_them() {
        let mut random = Random::new(7);
        assert!(SymmetricEigen::new(Matrix::zeros(0, 0)).values.is_empty(), "nothing");
        for size in 1..24 {
            let entries = random.signed_vec(size * size);
            check(&Matrix::from_fn(size, size, |i, j| entries[i * size + j] + entries[j * size + i]));
        }
    }

    #[test]
    fn multiple_and_zero_values_are_found() {
        check(&Matrix::identity(7));
        check(&Matrix::zeros(5, 5));
        check(&Matrix::from_fn(9, 9, |_, _| 1.0));
        check(&Matrix::from_fn(6, 6, |i, j| if i + j == 5 { 1.0 } else { 0.0 }));
        check(&Matrix::from_fn(8, 8, |i, j| if i.abs_diff(j) == 4 { 1e-9 } else { f64::from(u8::from(i == j)) }));
    }
}
