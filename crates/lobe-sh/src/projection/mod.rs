//! TODO room projection.

pub(crate) mod least_squares;
pub(crate) mod monte_carlo;
pub(crate) mod project;
