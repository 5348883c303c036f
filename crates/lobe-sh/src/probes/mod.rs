//! Limits of the machine and functions one by one, for `lobe-bench`, compiled with the kernels.
//!
//! The command is optimized little, and a kernel that is instantiated there is slower than its user has it. Nothing
//! here is generic, and nothing is inlined elsewhere. Read `rates` first; `one_by_one` calls generic functions for
//! `f32`. Uses `product`, `rotation` and `simd`. No part of the public interface.

pub(crate) mod one_by_one;
pub(crate) mod rates;

pub use crate::simd::cache_bytes;
pub use one_by_one::{multiply_pairs, rotate_one};
pub use rates::{CHAIN_CYCLES, copy, integer_chain, multiply_adds, multiply_adds_in, store, sum};
