//! Sums of products that a machine may round once.

use core::ops::{Add, Neg, Sub};

use crate::scalar::{Coefficient, Real};

/// A coefficient, or one whose sums of products are rounded once.
pub(crate) trait Term: Copy + Add<Output = Self> + Sub<Output = Self> + Neg<Output = Self> {
    /// The coefficient.
    type Value: Coefficient<Scalar = Self::Scalar>;

    /// The number type of one channel.
    type Scalar: Real;

    fn of(value: Self::Value) -> Self;

    fn value(self) -> Self::Value;

    /// `a f`.
    fn times(self, a: Self::Scalar) -> Self;

    /// `a f + g`.
    fn times_plus(self, a: Self::Scalar, g: Self) -> Self;

    /// `a f - g`.
    #[inline(always)]
    fn times_minus(self, a: Self::Scalar, g: Self) -> Self {
        self.times_plus(a, -g)
    }

    /// `g - a f`.
    #[inline(always)]
    fn times_from(self, a: Self::Scalar, g: Self) -> Self {
        (-self).times_plus(a, g)
    }
}

impl<T: Coefficient> Term for T {
    type Value = T;
    type Scalar = T::Scalar;

    #[inline(always)]
    fn of(value: T) -> Self {
        value
    }

    #[inline(always)]
    fn value(self) -> T {
        self
    }

    #[inline(always)]
    fn times(self, a: T::Scalar) -> Self {
        self.scale(a)
    }

    #[inline(always)]
    fn times_plus(self, a: T::Scalar, g: Self) -> Self {
        self.scale(a) + g
    }
}

/// A coefficient with fused multiply-adds, for kernels that run where the machine has them.
#[cfg(feature = "simd")]
#[derive(Clone, Copy)]
pub(crate) struct Fused<T>(T);

#[cfg(feature = "simd")]
impl<T: Coefficient> Term for Fused<T> {
    type Value = T;
    type Scalar = T::Scalar;

    #[inline(always)]
    fn of(value: T) -> Self {
        Self(value)
    }

    #[inline(always)]
    fn value(self) -> T {
        self.0
    }

    #[inline(always)]
    fn times(self, a: T::Scalar) -> Self {
        Self(self.0.scale(a))
    }

    #[inline(always)]
    fn times_plus(self, a: T::Scalar, g: Self) -> Self {
        Self(self.0.scale_plus(a, g.0))
    }
}

#[cfg(feature = "simd")]
impl<T: Coefficient> Add for Fused<T> {
    type Output = Self;

    #[inline(always)]
    fn add(self, g: Self) -> Self {
        Self(self.0 + g.0)
    }
}

#[cfg(feature = "simd")]
impl<T: Coefficient> Sub for Fused<T> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, g: Self) -> Self {
        Self(self.0 - g.0)
    }
}

#[cfg(feature = "simd")]
impl<T: Coefficient> Neg for Fused<T> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

/// A constant of the formula, rounded once.
#[inline(always)]
pub(crate) fn number<S: Real>(constant: f64) -> S {
    S::from_f64(constant)
}
