//! Quasi-Monte Carlo directions: Sobol' points with Owen scrambling (`sobol`), and the maps from the square to the
//! sphere (`warp`). Uses no other room.

pub(crate) mod sobol;
pub(crate) mod warp;
