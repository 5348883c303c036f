//! Comparison of pictures: error metrics, perceptual metrics and statistical tests.
//!
//! Read [`compare`] (root mean square and its relatives) first, then [`flip`] and [`hdr_flip`] for perception,
//! [`z_test`] and [`halves`] for Monte Carlo pictures. Uses `picture`.

pub(crate) mod compare;
pub(crate) mod flip;
pub(crate) mod halves;
pub(crate) mod hdr_flip;
pub(crate) mod z_test;
