//! The logarithm of a function on the sphere.

use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::expansion::sh_vec::widened;
use crate::expansion::{Expansion, ShVec};
use crate::exponential::matrix_function::{apply, spectrum};

/// The least eigenvalue that [`logarithm`] keeps unless told otherwise, relative to the largest.
///
/// Visibility cut off at a low order swings below zero: the product matrix of one sphere has eigenvalues down to -0.08
/// to -0.09 of the largest at orders 3 to 6, and no logarithm there. 0.02 is the value of a public re-implementation of
/// [Ren et al. 2006]; the test `the_exponential_of_a_logarithm_is_the_function_to_the_clamp` measures what it costs.
///
/// [Ren et al. 2006]: https://doi.org/10.1145/1141911.1141982
pub const LOG_CLAMP: f64 = 0.02;

/// The logarithm of `g` at its own order ([Ren et al. 2006]): the function `f` whose exponential is `g`, or near it.
///
/// With the product matrix `M = R D Rᵀ` of `g`, `M_ij = ∫ g y_i y_j ds`, and the constant `1 = (√4π, 0, ..)`,
///
/// ```text
///   log g = R q(D) Rᵀ (g - 1)        q(x) = ln x / (x - 1)
/// ```
///
/// Eigenvalues below `clamp` times the largest are raised to that, so that functions that are zero or ring below zero
/// have a logarithm. Where none is raised, [`ExpMethod::Eigen`](crate::exponential::ExpMethod::Eigen) brings `g` back to rounding at orders
/// 1 and 2, and above to the fourth power of its contrast. With `g = μ (1 + h)`, where `μ` is the mean, and `⊗` the truncated
/// product:
///
/// ```text
///   exp log g - g = μ/24 ((h⊗h)⊗(h⊗h) - h⊗(h⊗(h⊗h))) + O(h⁵)
/// ```
///
/// because truncated products do not associate: `f` is `ln M` applied to 1, and the product matrix of `f`, by which the exponential is
/// taken, is not `ln M`. Two spheres of 0.6 and 0.4 in a sky that is brighter by 2 come back within 2.4e-7 to 9.6e-6 of the norm at orders 3 to 8
/// (test `what_comes_back_is_off_by_the_fourth_power_of_the_contrast`).
///
/// Of coefficients that are not finite the logarithm is NaN. A function without positive eigenvalues is taken for the constant `clamp`.
///
/// # Panics
/// If `clamp` is not in `(0, 1]`.
///
/// [Ren et al. 2006]: https://doi.org/10.1145/1141911.1141982
#[must_use]
pub fn logarithm(g: &impl Expansion<f64>, clamp: f64) -> ShVec<f64> {
    check_clamp(clamp);
    logarithm_of(widened(g), clamp)
}

/// [`logarithm`], not generic, so that the eigenvectors are compiled in this crate alone.
fn logarithm_of(mut g: ShVec<f64>, clamp: f64) -> ShVec<f64> {
    if g.order() == 0 {
        return g;
    }
    let Some(spectrum) = spectrum(&g) else { return g.map(|_| f64::NAN) };
    let largest = spectrum.largest();
    if largest <= 0.0 {
        return ShVec::constant(g.order(), clamp.ln());
    }
    g.coefficients_mut()[0] -= (4.0 * PI).sqrt();
    ShVec::of(apply(&spectrum, &|d| slope_of_ln(d.max(clamp * largest)), g.coefficients()))
}

pub(crate) fn check_clamp(clamp: f64) {
    assert!(clamp > 0.0 && clamp <= 1.0, "the clamp of a logarithm lies in (0, 1], it is not {clamp}");
}

/// `ln x / (x - 1)`, 1 at `x = 1`.
pub(crate) fn slope_of_ln(x: f64) -> f64 {
    let h = x - 1.0;
    match h {
        0.0 => 1.0,
        // Near 1 the digits are in h, near 0 in x.
        h if h > -0.5 => h.ln_1p() / h,
        h => x.ln() / h,
    }
}
