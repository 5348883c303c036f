//! From a function to its expansion.
//!
//! Read `project` first: quadrature, exact for polynomials. `monte_carlo` samples with an estimate of the error,
//! `least_squares` fits scattered samples. Uses `basis`, `expansion`, `solver` and `sphere`.

pub(crate) mod least_squares;
pub(crate) mod monte_carlo;
pub(crate) mod project;

pub use least_squares::{Conditioning, LeastSquaresFit, least_squares};
pub use monte_carlo::{MonteCarloEstimate, MonteCarloOptions, Sampling, project_monte_carlo};
pub use project::{Projection, project, project_as, project_to_accuracy};
