//! Kernels for sixteen `f32` side by side, by the widest instructions of the machine.
//!
//! Read `machine` first: it asks the processor once and runs a [`Kernel`] by its registers. `lanes` is the block of
//! sixteen numbers in memory, `wide` the arithmetic on as many of them as a register holds, `wide_functions` roots and
//! exponentials. Uses no other room.

pub(crate) mod lanes;
pub(crate) mod machine;
#[cfg(feature = "std")]
pub(crate) mod wide;
#[cfg(feature = "std")]
pub(crate) mod wide_functions;

pub use lanes::{LANES, Lanes};
pub use machine::{Kernel, Machine};
#[cfg(feature = "std")]
pub use wide::{Wide, constant};
