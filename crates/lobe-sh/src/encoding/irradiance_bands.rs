//! Bands 0 to 2 of an irradiance, as the encodings read them.

use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::{Coefficient, Expansion};

/// `A_1 / π`, the share of the linear band that the clamped cosine lets through.
pub(crate) const LINEAR_SHARE: f64 = 2.0 / 3.0;

/// `A_2 / π`.
pub(crate) const QUADRATIC_SHARE: f64 = 0.25;

/// `y_0 = 1/(2√π)`.
pub(crate) fn y_0() -> f64 {
    0.5 / PI.sqrt()
}

/// Coefficient `i` in `f64`; zero where the expansion ends before it.
pub(crate) fn coefficient<T: Coefficient>(f: &impl Expansion<T>, i: usize) -> T::Wide {
    f.coefficients().get(i).map_or(T::Wide::ZERO, |c| c.widen())
}

/// The linear band as a vector: `(-f_3, -f_1, f_2)`, towards where the function grows.
pub(crate) fn linear_vector<T: Coefficient>(f: &impl Expansion<T>) -> [T::Wide; 3] {
    [-coefficient(f, 3), -coefficient(f, 1), coefficient(f, 2)]
}

/// One channel of a vector of coefficients.
pub(crate) fn channel_of<W: Coefficient<Scalar = f64>>(vector: [W; 3], c: usize) -> [f64; 3] {
    vector.map(|w| w.channel(c))
}

/// `x`, or 0 where it is below; NaN stays, which `max` would hide.
pub(crate) fn not_negative(x: f64) -> f64 {
    if x < 0.0 { 0.0 } else { x }
}
