//! What one coefficient of an expansion may be: a number or a color.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use crate::{Real, Rgb};

/// A coefficient of an expansion: `f32`, `f64`, [`Rgb<f32>`](Rgb) or `Rgb<f64>`.
///
/// A color is a vector of independent channels: sums, products and scaling act on each channel alone.
pub trait Coefficient:
    Copy
    + Default
    + PartialEq
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// The number type of one channel.
    type Scalar: Real;

    /// The same kind of coefficient in `f64`, for sums over many terms.
    type Wide: Coefficient<Scalar = f64, Wide = Self::Wide>;

    /// Number of channels: 1 or 3.
    const CHANNELS: usize;

    /// Zero in every channel.
    const ZERO: Self;

    /// `s` in every channel.
    fn splat(s: Self::Scalar) -> Self;

    /// Multiplies every channel by `s`.
    #[must_use]
    fn scale(self, s: Self::Scalar) -> Self;

    /// Channel `c`.
    ///
    /// # Panics
    /// If `c >= CHANNELS`.
    fn channel(self, c: usize) -> Self::Scalar;

    /// The coefficient whose channel `c` is `f(c)`.
    fn from_channels(f: impl FnMut(usize) -> Self::Scalar) -> Self;

    /// Converts to `f64` channels without loss.
    fn widen(self) -> Self::Wide;

    /// Rounds from `f64` channels.
    fn narrow(wide: Self::Wide) -> Self;
}

macro_rules! impl_coefficient {
    ($($t:ty),*) => {$(
        impl Coefficient for $t {
            type Scalar = Self;
            type Wide = f64;
            const CHANNELS: usize = 1;
            const ZERO: Self = 0.0;

            #[inline(always)]
            fn splat(s: Self) -> Self {
                s
            }

            #[inline(always)]
            fn scale(self, s: Self) -> Self {
                self * s
            }

            #[inline]
            fn channel(self, c: usize) -> Self {
                assert!(c == 0, "a scalar coefficient has channel 0 only, not {c}");
                self
            }

            #[inline]
            fn from_channels(mut f: impl FnMut(usize) -> Self) -> Self {
                f(0)
            }

            #[inline(always)]
            fn widen(self) -> f64 {
                f64::from(self)
            }

            #[inline(always)]
            fn narrow(wide: f64) -> Self {
                wide as Self
            }
        }
    )*};
}

impl_coefficient!(f32, f64);

impl<S: Real> Coefficient for Rgb<S> {
    type Scalar = S;
    type Wide = Rgb<f64>;
    const CHANNELS: usize = 3;
    const ZERO: Self = Self::new(S::ZERO, S::ZERO, S::ZERO);

    #[inline(always)]
    fn splat(s: S) -> Self {
        Self::new(s, s, s)
    }

    #[inline(always)]
    fn scale(self, s: S) -> Self {
        Self::new(self.r * s, self.g * s, self.b * s)
    }

    #[inline]
    fn channel(self, c: usize) -> S {
        self.to_array()[c]
    }

    #[inline]
    fn from_channels(mut f: impl FnMut(usize) -> S) -> Self {
        Self::new(f(0), f(1), f(2))
    }

    #[inline(always)]
    fn widen(self) -> Rgb<f64> {
        Rgb::new(self.r.to_f64(), self.g.to_f64(), self.b.to_f64())
    }

    #[inline(always)]
    fn narrow(wide: Rgb<f64>) -> Self {
        Self::new(S::from_f64(wide.r), S::from_f64(wide.g), S::from_f64(wide.b))
    }
}
