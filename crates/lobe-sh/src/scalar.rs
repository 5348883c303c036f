//! Numbers and colors: the types that one coefficient of an expansion may have.
//!
//! [`Real`] is `f32` or `f64`, [`Rgb`] a color of three of them, and [`Coefficient`] any of these. Kernels are written
//! once over the two traits.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A coefficient of an expansion: `f32`, `f64`, [`Rgb<f32>`](Rgb) or `Rgb<f64>`.
///
/// A color is a vector of independent channels: sums, products and scaling act on each channel alone. No other type can be one, as kernels
/// are compiled for these.
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

    /// `self.scale(s) + plus`, each channel rounded once. Quick where the code is compiled for fused multiply-adds.
    #[doc(hidden)]
    #[cfg(feature = "simd")]
    #[must_use]
    fn scale_plus(self, s: Self::Scalar, plus: Self) -> Self;

    /// The slice as one of its type, for what is compiled in this crate for each of them, and not again in every crate that calls it.
    #[doc(hidden)]
    fn typed(slice: &[Self]) -> TypedSlice<'_>;

    /// [`Coefficient::typed`] to write to.
    #[doc(hidden)]
    fn typed_mut(slice: &mut [Self]) -> TypedSliceMut<'_>;

    /// The slice if the type is `f32`, for kernels that exist for it alone.
    #[doc(hidden)]
    #[inline(always)]
    fn single_slice(slice: &[Self]) -> Option<&[f32]> {
        if let TypedSlice::Single(slice) = Self::typed(slice) { Some(slice) } else { None }
    }

    /// [`Coefficient::single_slice`] to write to.
    #[doc(hidden)]
    #[inline(always)]
    fn single_slice_mut(slice: &mut [Self]) -> Option<&mut [f32]> {
        if let TypedSliceMut::Single(slice) = Self::typed_mut(slice) { Some(slice) } else { None }
    }
}

/// `f32` or `f64`: the number type of a kernel.
///
/// Kernels are written once over this trait. Constants enter as `f64` and are rounded once.
pub trait Real: Coefficient<Scalar = Self> + PartialOrd + Div<Output = Self> {
    /// One.
    const ONE: Self;

    /// Rounds to this type.
    fn from_f64(value: f64) -> Self;

    /// Converts without loss.
    fn to_f64(self) -> f64;

    /// [`Coefficient::typed`] of colors.
    #[doc(hidden)]
    fn typed_colors(slice: &[Rgb<Self>]) -> TypedSlice<'_>;

    /// [`Coefficient::typed_mut`] of colors.
    #[doc(hidden)]
    fn typed_colors_mut(slice: &mut [Rgb<Self>]) -> TypedSliceMut<'_>;
}

/// A slice of one of the four types of coefficients.
#[doc(hidden)]
#[derive(Debug)]
pub enum TypedSlice<'a> {
    Single(&'a [f32]),
    Double(&'a [f64]),
    SingleColors(&'a [Rgb<f32>]),
    DoubleColors(&'a [Rgb<f64>]),
}

/// The same to write to.
#[doc(hidden)]
#[derive(Debug)]
pub enum TypedSliceMut<'a> {
    Single(&'a mut [f32]),
    Double(&'a mut [f64]),
    SingleColors(&'a mut [Rgb<f32>]),
    DoubleColors(&'a mut [Rgb<f64>]),
}

macro_rules! numbers {
    ($($t:ty: $typed:ident, $colors:ident);*) => {$(
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

            #[cfg(feature = "simd")]
            #[inline(always)]
            fn scale_plus(self, s: Self, plus: Self) -> Self {
                self.mul_add(s, plus)
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

            #[inline(always)]
            fn typed(slice: &[Self]) -> TypedSlice<'_> {
                TypedSlice::$typed(slice)
            }

            #[inline(always)]
            fn typed_mut(slice: &mut [Self]) -> TypedSliceMut<'_> {
                TypedSliceMut::$typed(slice)
            }
        }

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
            fn typed_colors(slice: &[Rgb<Self>]) -> TypedSlice<'_> {
                TypedSlice::$colors(slice)
            }

            #[inline(always)]
            fn typed_colors_mut(slice: &mut [Rgb<Self>]) -> TypedSliceMut<'_> {
                TypedSliceMut::$colors(slice)
            }
        }
    )*};
}

numbers!(f32: Single, SingleColors; f64: Double, DoubleColors);

/// A linear color: red, green and blue with Rec. 709 primaries unless the data says otherwise.
///
/// Serialized as `[r, g, b]` (feature `serde`); three numbers in this order in memory (feature `bytemuck`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "[S; 3]", into = "[S; 3]"))]
#[cfg_attr(
    feature = "serde",
    serde(bound(serialize = "S: serde::Serialize + Clone", deserialize = "S: serde::Deserialize<'de>"))
)]
#[repr(C)]
pub struct Rgb<S = f32> {
    /// Red.
    pub r: S,
    /// Green.
    pub g: S,
    /// Blue.
    pub b: S,
}

impl<S> Rgb<S> {
    /// A color from its channels.
    #[inline(always)]
    pub const fn new(r: S, g: S, b: S) -> Self {
        Self { r, g, b }
    }

    /// The channels in order.
    #[inline(always)]
    pub fn to_array(self) -> [S; 3] {
        [self.r, self.g, self.b]
    }
}

impl<S: Real> Rgb<S> {
    /// Channel `c` to write to; blue from 2 on.
    #[inline(always)]
    pub(crate) fn channel_mut(&mut self, c: usize) -> &mut S {
        match c {
            0 => &mut self.r,
            1 => &mut self.g,
            _ => &mut self.b,
        }
    }

    /// Relative luminance `0.2126 r + 0.7152 g + 0.0722 b` (ITU-R BT.709).
    #[must_use]
    pub fn luminance(self) -> S {
        self.r * S::from_f64(0.2126) + self.g * S::from_f64(0.7152) + self.b * S::from_f64(0.0722)
    }
}

impl<S> From<[S; 3]> for Rgb<S> {
    fn from([r, g, b]: [S; 3]) -> Self {
        Self { r, g, b }
    }
}

impl<S> From<Rgb<S>> for [S; 3] {
    fn from(c: Rgb<S>) -> Self {
        [c.r, c.g, c.b]
    }
}

macro_rules! channelwise {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<S: Real> $trait for Rgb<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                Self::new(self.r $op o.r, self.g $op o.g, self.b $op o.b)
            }
        }
    };
}

channelwise!(Add, add, +);
channelwise!(Sub, sub, -);
channelwise!(Mul, mul, *);

impl<S: Real> Neg for Rgb<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.r, -self.g, -self.b)
    }
}

impl<S: Real> AddAssign for Rgb<S> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<S: Real> SubAssign for Rgb<S> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

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

    #[cfg(feature = "simd")]
    #[inline(always)]
    fn scale_plus(self, s: S, plus: Self) -> Self {
        Self::new(self.r.scale_plus(s, plus.r), self.g.scale_plus(s, plus.g), self.b.scale_plus(s, plus.b))
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

    #[inline(always)]
    fn typed(slice: &[Self]) -> TypedSlice<'_> {
        S::typed_colors(slice)
    }

    #[inline(always)]
    fn typed_mut(slice: &mut [Self]) -> TypedSliceMut<'_> {
        S::typed_colors_mut(slice)
    }
}

/// A constant in every channel.
#[inline(always)]
pub(crate) fn constant<T: Coefficient>(constant: f64) -> T {
    T::splat(T::Scalar::from_f64(constant))
}

/// `Σ w c`, summed in `f64`.
pub(crate) fn weighted_sum<T: Coefficient>(terms: impl IntoIterator<Item = (T, f64)>) -> T::Wide {
    let mut sum = T::Wide::ZERO;
    terms.into_iter().for_each(|(c, w)| sum += c.widen().scale(w));
    sum
}

/// The weight of channel `c` in the luminance: that of [`Rgb::luminance`], or 1 if there is only one channel.
pub(crate) fn luminance_weight<T: Coefficient>(c: usize) -> f64 {
    if T::CHANNELS == 1 {
        return 1.0;
    }
    Rgb::<f64>::from_channels(|k| f64::from(u8::from(k == c))).luminance()
}

/// The relative luminance of a color; a number is its own luminance.
pub(crate) fn luminance<W: Coefficient<Scalar = f64>>(value: W) -> f64 {
    (0..W::CHANNELS).map(|c| luminance_weight::<W>(c) * value.channel(c)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_has_luminance_one_and_green_the_most_of_it() {
        assert!((Rgb::new(1.0_f64, 1.0, 1.0).luminance() - 1.0).abs() < 1e-15, "white");
        assert_eq!(Rgb::new(0.0, 2.0, 0.0).luminance(), 2.0 * 0.7152, "green");
    }

    #[test]
    fn arithmetic_acts_on_each_channel() {
        let (a, b) = (Rgb::new(1.0, 2.0, 3.0), Rgb::new(4.0, -5.0, 0.5));
        assert_eq!((a + b, a - b), (Rgb::new(5.0, -3.0, 3.5), Rgb::new(-3.0, 7.0, 2.5)), "sum and difference");
        assert_eq!((a * b, -a), (Rgb::new(4.0, -10.0, 1.5), Rgb::new(-1.0, -2.0, -3.0)), "product and negative");
        let mut c = a;
        c += b;
        c -= a;
        assert_eq!(<[f64; 3]>::from(c), b.to_array(), "there and back");
    }
}
