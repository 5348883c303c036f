//! The logarithm of a function on the sphere.

use alloc::vec::Vec;
use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::expansion::zonal::Zonal;
use crate::exponential::matrix_function::{apply, spectrum};
use crate::{Dir, Expansion, ShVec};

/// The least eigenvalue that [`logarithm`] keeps unless told otherwise, relative to the largest.
///
/// Visibility cut off at a low order swings below zero: the product matrix of one sphere has eigenvalues down to -0.08
/// to -0.09 of the largest at orders 3 to 6, and no logarithm there. 0.02 is the value of a public re-implementation of
/// [Ren et al. 2006]; the test `the_exponential_of_a_logarithm_is_the_function_to_the_clamp` measures what it costs.
///
/// [Ren et al. 2006]: https://doi.org/10.1145/1141911.1141982
pub const LOG_CLAMP: f64 = 0.02;

/// The logarithm of `g` at its own order ([Ren et al. 2006]): the function `f` with `exp(f) = g` in truncated products.
///
/// With the product matrix `M = R D Rᵀ` of `g`, `M_ij = ∫ g y_i y_j ds`, and the constant `1 = (√4π, 0, ..)`,
///
/// ```text
///   log g = R q(D) Rᵀ (g - 1)        q(x) = ln x / (x - 1)
/// ```
///
/// Eigenvalues below `clamp` times the largest are raised to that, so that functions that are zero or ring below zero
/// have a logarithm; where none is raised, [`ExpMethod::Eigen`](crate::ExpMethod::Eigen) brings `g` back up to rounding
/// (test). Of coefficients that are not finite the logarithm is NaN. A function without positive eigenvalues is taken for the constant `clamp`.
///
/// # Panics
/// If `clamp` is not in `(0, 1]`.
///
/// [Ren et al. 2006]: https://doi.org/10.1145/1141911.1141982
#[must_use]
pub fn logarithm(g: &impl Expansion<f64>, clamp: f64) -> ShVec<f64> {
    assert!(clamp > 0.0 && clamp <= 1.0, "the clamp of a logarithm lies in (0, 1], it is not {clamp}");
    logarithm_relative_to(0.0, g, clamp)
}

/// As [`logarithm`], with eigenvalues of at least `clamp` times `size` in any case.
fn logarithm_relative_to(size: f64, g: &impl Expansion<f64>, clamp: f64) -> ShVec<f64> {
    let mut rest = ShVec::zero(g.order());
    rest.coefficients_mut().copy_from_slice(g.coefficients());
    if g.order() == 0 {
        return rest;
    }
    let Some(spectrum) = spectrum(g) else { return rest.map(|_| f64::NAN) };
    let largest = spectrum.eigenvalues.max().max(size);
    if largest <= 0.0 {
        return ShVec::constant(g.order(), clamp.ln());
    }
    rest.coefficients_mut()[0] -= (4.0 * PI).sqrt();
    apply(&spectrum, |d| slope_of_ln(d.max(clamp * largest)), rest.coefficients())
}

/// `ln x / (x - 1)`, 1 at `x = 1`.
fn slope_of_ln(x: f64) -> f64 {
    let h = x - 1.0;
    if h == 0.0 { 1.0 } else { h.ln_1p() / h }
}

impl Zonal {
    /// The logarithm of the visibility that a sphere of angular radius `half_angle` (radians, in `[0, π]`) leaves: 0
    /// within that angle of the axis, 1 outside; see [`logarithm`] for `clamp`.
    ///
    /// What is relative in the clamp is so to 1, the open sky, or to the overshoot of the basis above it. A sphere around the
    /// point leaves the constant `ln clamp / (1 - clamp)`.
    ///
    /// Spheres that stand together add up: the exponential of the sum is what all of them leave.
    ///
    /// # Panics
    /// If `half_angle` is outside `[0, π]`, or as [`logarithm`].
    #[must_use]
    pub fn sphere_logarithm(order: usize, half_angle: f64, clamp: f64) -> Self {
        let hidden = Self::cone(order, half_angle).towards(Dir::Z, -1.0);
        let visible = &ShVec::constant(order, 1.0) + &hidden;
        if order == 0 {
            return Self::new(Vec::new());
        }
        assert!(clamp > 0.0 && clamp <= 1.0, "the clamp of a logarithm lies in (0, 1], it is not {clamp}");
        Self::about(Dir::Z, &logarithm_relative_to(1.0, &visible, clamp))
    }
}
