//! Rotations, reflections and exchanges of axes.
//!
//! Read `rotation` first; it turns bands 1 and 2 in closed form (`closed_bands`) and all others by `zyz`, rotations
//! about z between exchanges of y and z (`yz_exchange`, computed from Wigner's d-matrices of 90°): up to band 7 by
//! straight-line code (`low_bands`; `generated`, written by `cargo xtask tables`) whose sums a machine may round once
//! (`term`) or, in `f32` by AVX2, by registers (`register_bands` with the angles of `register_turns`), from band 64
//! on without matrices (`high_bands`, its sums in `exchange_lanes`). `ivanic` builds one matrix for each band,
//! for many expansions, one after the other (`band_matrices`); `lane_rotation` applies them to sixteen at once. `axis_permutation` is exact. Uses `basis`,
//! `simd` and `sphere`.

pub(crate) mod axis_permutation;
pub(crate) mod band_matrices;
pub(crate) mod closed_bands;
pub(crate) mod cos_sin;
pub(crate) mod exchange_lanes;
pub(crate) mod generated;
pub(crate) mod high_bands;
pub(crate) mod ivanic;
#[cfg(feature = "batch")]
pub(crate) mod lane_rotation;
pub(crate) mod low_bands;
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
pub(crate) mod register_bands;
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
pub(crate) mod register_turns;
pub(crate) mod rotation;
pub(crate) mod term;
pub(crate) mod yz_exchange;
pub(crate) mod zyz;

pub use axis_permutation::{Axis, AxisPermutation, mirror_in_place, quarter_turn_in_place};
pub use ivanic::RotationMatrices;
pub use rotation::{Rotation, tangent_frame};
