//! Constants in the generated products.

use crate::{Coefficient, Real as _};

/// The constant in every channel of a coefficient: generated code is written once for numbers and colors.
#[inline(always)]
pub(crate) fn k<T: Coefficient>(constant: f64) -> T {
    T::splat(T::Scalar::from_f64(constant))
}
