//! Irradiance in fewer numbers than nine a channel, or better than nine would be: one encoding a file.
//!
//! Every encoding is made from the expansion of the irradiance `E` (radiance convolved with the clamped cosine, `1/π`
//! not included) and gives `E` back for a normal. Bands that the expansion lacks count as zero. [`IrradianceEncoding`]
//! lists all, to loop over.

mod ahd;
mod ambient_cube;
mod encoding_error;
mod h_basis;
mod hemisphere;
mod hl2;
mod irradiance_encoding;
mod irradiance_matrix;
mod non_linear_l1;
mod packed_irradiance;
mod zh3;
mod zh3_axis;

pub use ahd::Ahd;
pub use ambient_cube::AmbientCube;
pub use encoding_error::{EncodingError, encoding_error};
pub use h_basis::{HBasis, HBasis4, HBasis6};
pub use hemisphere::{hemisphere_least_squares, tangent_frame};
pub use hl2::{Hl2, Hl2Weights};
pub use irradiance_encoding::{EncodedIrradiance, IrradianceEncoding};
pub use irradiance_matrix::IrradianceMatrix;
pub use non_linear_l1::NonLinearL1;
pub use packed_irradiance::PackedIrradiance;
pub use zh3::{Zh3, Zh3Axis};

use std::f64::consts::PI;

use crate::{Coefficient, Expansion};

/// `A_1 / π`, the share of the linear band that the clamped cosine lets through.
const LINEAR_SHARE: f64 = 2.0 / 3.0;

/// `A_2 / π`.
const QUADRATIC_SHARE: f64 = 0.25;

/// `y_0 = 1/(2√π)`.
fn y_0() -> f64 {
    0.5 / PI.sqrt()
}

/// Coefficient `i` in `f64`; zero where the expansion ends before it.
fn coefficient<T: Coefficient>(f: &impl Expansion<T>, i: usize) -> T::Wide {
    f.coefficients().get(i).map_or(T::Wide::ZERO, |c| c.widen())
}

/// The linear band as a vector: `(-f_3, -f_1, f_2)`, towards where the function grows.
fn linear_vector<T: Coefficient>(f: &impl Expansion<T>) -> [T::Wide; 3] {
    [-coefficient(f, 3), -coefficient(f, 1), coefficient(f, 2)]
}

/// One channel of a vector of coefficients.
fn channel_of<W: Coefficient<Scalar = f64>>(vector: [W; 3], c: usize) -> [f64; 3] {
    vector.map(|w| w.channel(c))
}

/// `x`, or 0 where it is below; NaN stays, which `max` would hide.
fn not_negative(x: f64) -> f64 {
    if x < 0.0 { 0.0 } else { x }
}
