//! Differences of pictures: in numbers, to the eye, and beyond chance.
//!
//! Read first: [`compare`] (root mean square and its relatives), then [`flip`] and [`hdr_flip`] for the eye, [`z_test`] for
//! pictures made of random samples. Uses the room `picture`.

pub(crate) mod compare;
pub(crate) mod flip;
pub(crate) mod hdr_flip;
pub(crate) mod z_test;
