//! Test utilities for Lobe's tests only: directions over the whole sphere, golden values, statistics, a .glb validator.
//!
//! It depends on no other crate of Lobe, so that every crate's tests can use it.

mod chi_square;
mod directions;
mod glb_faults;
mod golden;
mod random;

pub use chi_square::ChiSquare;
pub use directions::{directions, fibonacci_sphere};
pub use glb_faults::glb_faults;
pub use golden::{golden, golden_f64s};
pub use random::Random;
