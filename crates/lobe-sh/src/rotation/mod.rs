//! TODO room rotation.

pub(crate) mod axis_permutation;
pub(crate) mod ivanic;
pub(crate) mod low_bands;
pub(crate) mod mirror;
pub(crate) mod rotation;
pub(crate) mod wigner_half_pi;
pub(crate) mod yz_exchange;
pub(crate) mod zyz;
