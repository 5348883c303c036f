//! The device: which one of the machine, what it can do, what went wrong on it, and how numbers come back.
//!
//! Read `options`, then `context`, then `readback`. Uses no other room.

pub(crate) mod context;
pub(crate) mod options;
pub(crate) mod readback;
