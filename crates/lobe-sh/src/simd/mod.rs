//! Kernels for numbers side by side, by the widest instructions of the machine.
//!
//! Read `machine` first: it asks the processor once and runs a [`Kernel`] by its registers. `lanes` is the block of
//! sixteen `f32` in memory, `wide` the arithmetic on as many `f32` or `f64` as a register holds, by `lane`, and `wide_functions`
//! roots and exponentials; `eight_sums` adds alike by registers of any width; `past_caches` copies what is not read soon. Uses no other room.

#[cfg(feature = "simd")]
pub(crate) mod eight_sums;
#[cfg(feature = "simd")]
pub(crate) mod lane;
#[cfg(feature = "batch")]
pub(crate) mod lanes;
pub(crate) mod machine;
#[cfg(feature = "simd")]
pub(crate) mod past_caches;
#[cfg(feature = "simd")]
pub(crate) mod wide;
#[cfg(feature = "simd")]
pub(crate) mod wide_functions;

#[cfg(feature = "simd")]
pub use eight_sums::{MOST_PARTS, sum_of_parts, sum_parts};
#[cfg(feature = "simd")]
pub use lane::Lane;
#[cfg(feature = "batch")]
pub use lanes::{LANES, Lanes};
pub use machine::{Kernel, Machine};
#[cfg(feature = "simd")]
#[doc(hidden)]
pub use past_caches::cache_bytes;
#[cfg(feature = "simd")]
pub use past_caches::copy_past_caches;
#[cfg(feature = "simd")]
pub(crate) use wide::rounded;
#[cfg(feature = "simd")]
pub use wide::{Wide, constant};
