//! Comparison of pictures: error metrics, perceptual metrics and statistical tests.
//!
//! Read first: [`compare`] (root mean square and its relatives), then [`flip`] and [`hdr_flip`] for perception,
//! [`z_test`] for Monte Carlo pictures. Uses the room `picture`.

pub(crate) mod compare;
pub(crate) mod flip;
pub(crate) mod hdr_flip;
pub(crate) mod z_test;
