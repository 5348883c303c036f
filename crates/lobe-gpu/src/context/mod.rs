//! The device: which one of the machine, what it can do, what went wrong on it, and how numbers come back.
//!
//! Read `options`, then `context`, `programs`, what was compiled for it, and `readback`. Uses no other room.

use std::sync::{Mutex, MutexGuard, PoisonError};

pub(crate) mod context;
pub(crate) mod options;
pub(crate) mod programs;
pub(crate) mod readback;

/// What a mutex holds, also after a thread panicked with it.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
