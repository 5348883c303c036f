//! Householder reflections, and the triangular factor of a matrix by them.

use crate::prelude::*;
use crate::solver::matrix::{Matrix, add_scaled, dot, norm};

/// The reflection `1 - t v vᵀ` that takes a vector to a multiple of its first axis.
pub(crate) struct Reflection {
    pub(crate) v: Vec<f64>,
    pub(crate) t: f64,
    /// The component that is left, `∓|x|`.
    pub(crate) image: f64,
}

impl Reflection {
    /// Of the vector `x`; `None` if it is zero, or empty. The sign is that which cancels no digits.
    pub(crate) fn of(x: &[f64]) -> Option<Self> {
        let length = norm(x);
        if length == 0.0 {
            return None;
        }
        let image = -length.copysign(x[0]);
        let mut v = x.to_vec();
        v[0] -= image;
        Some(Self { t: (length * v[0].abs()).recip(), v, image })
    }

    /// Reflects a vector.
    pub(crate) fn apply(&self, x: &mut [f64]) {
        let part = self.t * dot(&self.v, x);
        add_scaled(x, &self.v, -part);
    }
}

/// The square upper triangular `R` of `A = Q R`, for at least as many rows as columns. Source: [Golub and Van Loan 2013]
pub(crate) fn triangular_factor(mut a: Matrix) -> Matrix {
    let size = a.columns();
    for k in 0..size {
        if let Some(reflection) = Reflection::of(&a.column(k)[k..]) {
            for j in k + 1..size {
                reflection.apply(&mut a.column_mut(j)[k..]);
            }
            a[(k, k)] = reflection.image;
        }
    }
    Matrix::from_fn(size, size, |i, j| if i <= j { a[(i, j)] } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    #[test]
    fn the_factor_has_the_products_of_the_columns() {
        let mut random = Random::new(3);
        for size in 0..9 {
            let entries = random.signed_vec((size + 3) * size);
            let a = Matrix::from_fn(size + 3, size, |i, j| entries[i * size + j]);
            let r = triangular_factor(a.clone());
            for j in 0..size {
                for i in 0..size {
                    let (found, expected) = (dot(r.column(i), r.column(j)), dot(a.column(i), a.column(j)));
                    assert!((found - expected).abs() < 1e-14 * size as f64, "{i}, {j}: {found} against {expected}");
                    assert!(i <= j || r[(i, j)] == 0.0, "{i}, {j} of {size}: {}", r[(i, j)]);
                }
            }
        }
    }
}
