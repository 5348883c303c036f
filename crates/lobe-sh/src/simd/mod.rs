//! Kernels for sixteen `f32` side by side, by the widest instructions of the machine.
//!
//! Read `machine` first: it asks the processor once and runs a [`Kernel`] by its registers. `lanes` is the block of
//! sixteen numbers in memory and the arithmetic on as many of them as a register holds. Uses no other room.

pub(crate) mod lanes;
pub(crate) mod machine;

pub use lanes::{LANES, Lanes};
#[cfg(feature = "std")]
pub use lanes::{Wide, constant};
pub use machine::{Kernel, Machine};
