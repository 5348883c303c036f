//! Functions on the sphere: the real spherical-harmonic basis, expansions in it, and what lighting does with them.
//!
//! The conventions are those of Sloan, D3DX and DirectXMath: orthonormal, Condon-Shortley phase kept, flat index
//! `i = l(l+1) + m`, order `n` = number of bands, z up. `CONVENTIONS.md` at the root of the repository shows them.

mod axis_permutation;
mod basis;
mod closed_bands;
mod coefficient;
mod complex;
mod convolve;
mod dir;
mod error;
mod expansion;
#[cfg(feature = "json")]
mod file;
mod gradient;
mod half_turn;
mod index;
mod ivanic;
mod kernel;
mod least_squares;
mod legendre;
mod mirror;
mod monte_carlo;
mod project;
mod quadrature;
mod quantity;
mod real;
mod rgb;
mod rotation;
#[cfg(feature = "json")]
mod save;
mod sh;
mod sh_vec;
mod swap;
mod zonal;
mod zyz;

pub use axis_permutation::AxisPermutation;
pub use basis::{Basis, eval_basis, eval_basis_into};
pub use coefficient::Coefficient;
pub use complex::{complex_from_real, eval_complex, real_from_complex};
pub use convolve::{convolve_in_place, convolved};
pub use dir::Dir;
pub use error::ShError;
pub use expansion::Expansion;
#[cfg(feature = "json")]
pub use file::{FileCoefficients, ShFile, load_sh_json, read_sh_json, save_sh_json, write_sh_json};
pub use gradient::{eval_basis_gradients, eval_with_gradient};
pub use index::{MAX_ORDER, band_and_m, band_range, index, len, order_of};
pub use ivanic::RotationMatrices;
pub use least_squares::{Conditioning, Fit, least_squares};
pub use legendre::{legendre, legendre_normalised};
pub use mirror::{Axis, mirror_in_place, quarter_turn_in_place};
pub use monte_carlo::{Estimate, MonteCarlo, Sampling, project_monte_carlo};
pub use project::{Projection, project, project_to_accuracy};
pub use quadrature::{SphereQuadrature, gauss_legendre};
pub use quantity::Quantity;
pub use real::Real;
pub use rgb::Rgb;
pub use rotation::{Rotation, RotationError};
#[cfg(feature = "json")]
pub use save::{check_writable, write_atomically};
pub use sh::{Sh, ShL0, ShL1, ShL2, ShL3, ShL4, ShL5, ShL6, ShL7, ShL8, ShL9};
pub use sh_vec::ShVec;
pub use zonal::Zonal;
