//! Irradiance in fewer numbers than the nine of order 3 for each channel, or in a form that suits shaders.
//!
//! Read `irradiance_encoding` first: it lists all encodings, to loop over, and measures their errors. Every encoding
//! is made from the expansion of the irradiance `E` (radiance convolved with the clamped cosine, not divided by π) and
//! gives `E` back for a normal; bands that the expansion lacks count as zero. `packed_irradiance`, of
//! many normals by `packed_lanes`, `irradiance_matrix` and `irradiance_polynomial` are order 3 rearranged, `packed_irradiance_5` is
//! order 5; all others are approximations. `engine_form` has the nine colors of radiance as engines keep them, in the
//! frame of `engine_frame`. The functions below read bands 0 to 2 for them, or up to 4. Uses `batch`, `expansion`,
//! `projection`, `rotation`, `simd`, `solver` and `sphere`.

pub(crate) mod ahd;
pub(crate) mod ambient_cube;
pub(crate) mod engine_form;
pub(crate) mod engine_frame;
pub(crate) mod h_basis;
pub(crate) mod hemisphere;
pub(crate) mod hl2;
pub(crate) mod irradiance_encoding;
pub(crate) mod irradiance_matrix;
pub(crate) mod irradiance_polynomial;
pub(crate) mod non_linear_l1;
pub(crate) mod packed_irradiance;
pub(crate) mod packed_irradiance_5;
#[cfg(feature = "batch")]
mod packed_lanes;
pub(crate) mod zh3;

pub use ahd::Ahd;
pub use ambient_cube::AmbientCube;
pub use engine_form::EngineForm;
pub use engine_frame::EngineFrame;
pub use h_basis::{HBasis, HBasis4, HBasis6};
pub use hemisphere::hemisphere_least_squares;
pub use hl2::{Hl2, Hl2Weights};
pub use irradiance_encoding::{EncodedIrradiance, EncodingError, IrradianceEncoding, encoding_error};
pub use irradiance_matrix::IrradianceMatrix;
pub use irradiance_polynomial::IrradiancePolynomial;
pub use non_linear_l1::NonLinearL1;
pub use packed_irradiance::PackedIrradiance;
pub use packed_irradiance_5::PackedIrradiance5;
pub use zh3::{Zh3, Zh3Axis};

use core::array;
use core::f64::consts::PI;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::expansion::{Expansion, Sh, Zonal};
use crate::scalar::{Coefficient, Rgb};

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

/// The irradiance under the first `N` coefficients of a radiance.
pub(crate) fn irradiance_under<const N: usize, T: Coefficient<Wide = Rgb<f64>>>(
    radiance: &impl Expansion<T>,
) -> Sh<N, Rgb<f64>> {
    let first = Sh::<N, Rgb<f64>>::of(array::from_fn(|i| coefficient(radiance, i)));
    first.convolved(&Zonal::clamped_cosine(first.order()))
}

/// One channel of a vector of coefficients.
pub(crate) fn channel_of<W: Coefficient<Scalar = f64>>(vector: [W; 3], c: usize) -> [f64; 3] {
    vector.map(|w| w.channel(c))
}

/// `x`, or 0 where it is below; NaN stays, which `max` would hide.
pub(crate) fn not_negative(x: f64) -> f64 {
    if x < 0.0 { 0.0 } else { x }
}
