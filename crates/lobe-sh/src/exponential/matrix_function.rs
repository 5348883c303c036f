//! Functions of the product matrix of an expansion.

use alloc::vec::Vec;

use crate::expansion::{Expansion as _, ShVec};
use crate::product::matrix::ProductMatrix;
use crate::solver::matrix::Matrix;
use crate::solver::symmetric_eigen::SymmetricEigen;

/// The eigenvalues and eigenvectors of the product matrix of `f` at its own order, `M = R D Rᵀ`.
///
/// `M` multiplies by `f`, so that `D` holds values of `f` as the basis sees them, and `R q(D) Rᵀ` multiplies by `q(f)`.
///
/// `None` if a coefficient is not finite.
pub(crate) fn spectrum(f: &ShVec<f64>) -> Option<SymmetricEigen> {
    if !f.coefficients().iter().all(|c| c.is_finite()) {
        return None;
    }
    let matrix = ProductMatrix::<f64>::new(f, f.order());
    let n = f.coefficients().len();
    let entries = matrix.entries();
    Some(SymmetricEigen::new(Matrix::from_fn(n, n, |i, j| entries[i * n + j])))
}

/// `R q(D) Rᵀ v`.
pub(crate) fn apply(spectrum: &SymmetricEigen, q: &dyn Fn(f64) -> f64, v: &[f64]) -> Vec<f64> {
    let mut turned = spectrum.vectors.transposed_times(v);
    for (c, d) in turned.iter_mut().zip(&spectrum.values) {
        *c *= q(*d);
    }
    spectrum.vectors.times(&turned)
}
