#![doc = include_str!("../README.md")]

mod chi_square;
mod denormals;
mod directions;
mod glb_faults;
mod glb_unused;
mod golden;
mod random;
mod skipped;

pub use chi_square::ChiSquare;
pub use denormals::meets_denormals;
pub use directions::{directions, fibonacci_sphere};
pub use glb_faults::glb_faults;
pub use glb_unused::glb_unused;
pub use golden::{golden, golden_f64s};
pub use random::Random;
pub use skipped::skipped;
