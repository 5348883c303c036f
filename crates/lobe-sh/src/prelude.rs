//! Names that `std` has in scope and `core` has not: the types of `alloc`, and elementary functions.

pub(crate) use alloc::string::String;
pub(crate) use alloc::vec::Vec;

#[cfg(not(feature = "std"))]
pub(crate) use num_traits::Float as _;
