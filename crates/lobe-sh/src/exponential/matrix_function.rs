//! Functions of the product matrix of an expansion.

use alloc::vec::Vec;

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::product::matrix::ProductMatrix;
use crate::{Expansion as _, ShVec};

/// The eigenvalues and eigenvectors of the product matrix of `f` at its own order, `M = R D Rᵀ`.
///
/// `M` multiplies by `f`, so that `D` holds values of `f` as the basis sees them, and `R q(D) Rᵀ` multiplies by `q(f)`.
///
/// `None` if a coefficient is not finite: the solver would never end.
pub(crate) fn spectrum(f: &ShVec<f64>) -> Option<SymmetricEigen<f64, nalgebra::Dyn>> {
    if !f.coefficients().iter().all(|c| c.is_finite()) {
        return None;
    }
    let matrix = ProductMatrix::<f64>::new(f, f.order());
    let n = f.coefficients().len();
    Some(SymmetricEigen::new(DMatrix::from_row_slice(n, n, matrix.entries())))
}

/// `R q(D) Rᵀ v`.
pub(crate) fn apply(spectrum: &SymmetricEigen<f64, nalgebra::Dyn>, q: &dyn Fn(f64) -> f64, v: &[f64]) -> Vec<f64> {
    let mut turned = spectrum.eigenvectors.tr_mul(&DVector::from_row_slice(v));
    for (c, d) in turned.iter_mut().zip(spectrum.eigenvalues.iter()) {
        *c *= q(*d);
    }
    (&spectrum.eigenvectors * turned).iter().copied().collect()
}
