//! The two floating-point types a kernel may be written for.

use std::sync::OnceLock;

use crate::basis::basis::with_shared;
use crate::{Basis, Coefficient};

/// `f32` or `f64`: the number type of a kernel.
///
/// Kernels are written once over this trait. Constants enter as `f64` and are rounded once.
pub trait Real: Coefficient<Scalar = Self> + PartialOrd + std::ops::Div<Output = Self> {
    /// One.
    const ONE: Self;

    /// Rounds to this type.
    fn from_f64(value: f64) -> Self;

    /// Converts without loss.
    fn to_f64(self) -> f64;

    /// The non-negative square root; NaN below zero.
    fn sqrt(self) -> Self;

    /// Calls `f` with a basis of at least `order`, shared by the whole process for common orders.
    fn with_shared_basis<R>(order: usize, f: impl FnOnce(&Basis<Self>) -> R) -> R;
}

macro_rules! impl_real {
    ($($t:ty),*) => {$(
        impl Real for $t {
            const ONE: Self = 1.0;

            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as Self
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }

            fn with_shared_basis<R>(order: usize, f: impl FnOnce(&Basis<Self>) -> R) -> R {
                static BASIS: OnceLock<Basis<$t>> = OnceLock::new();
                with_shared(&BASIS, order, f)
            }
        }
    )*};
}

impl_real!(f32, f64);
