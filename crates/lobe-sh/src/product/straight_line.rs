//! The straight-line code, compiled here once for each type of numbers and not again in every crate that multiplies.
//!
//! Products of colors are those of their channels, one after the other: the same bits as with colors in the code, which
//! would be three times as long.

use crate::by_type::of_each_type;
#[cfg(feature = "simd")]
use crate::product::fused_pair::multiply_pair;
use crate::product::generated;
use crate::scalar::{Coefficient, Real, Rgb};
use crate::scalar::{TypedSlice as Slice, TypedSliceMut as SliceMut};

/// The most coefficients of a factor or a product that has code.
const MOST: usize = 49;

of_each_type! { numbers:
    pub(super) fn general(a: &[T], b: &[T], out: &mut [T]) -> bool {
        #[cfg(feature = "simd")]
        if let (Some(a), Some(b), Some(out)) = (T::single_slice(a), T::single_slice(b), T::single_slice_mut(out))
            && multiply_pair(a, b, out)
        {
            return true;
        }
        generated::general(a, b, out)
    }

    pub(super) fn square(a: &[T], out: &mut [T]) -> bool {
        generated::square(a, out)
    }

    pub(super) fn zonal(z: &[T], b: &[T], out: &mut [T]) -> bool {
        generated::zonal(z, b, out)
    }
}

/// [`generated::general`].
#[inline]
pub(crate) fn general<T: Coefficient>(a: &[T], b: &[T], out: &mut [T]) -> bool {
    match (T::typed(a), T::typed(b), T::typed_mut(out)) {
        (Slice::Single(a), Slice::Single(b), SliceMut::Single(out)) => single::general(a, b, out),
        (Slice::Double(a), Slice::Double(b), SliceMut::Double(out)) => double::general(a, b, out),
        (Slice::SingleColors(a), Slice::SingleColors(b), SliceMut::SingleColors(out)) => {
            by_channels([a, b], out, |[a, b], out| single::general(a, b, out))
        }
        (Slice::DoubleColors(a), Slice::DoubleColors(b), SliceMut::DoubleColors(out)) => {
            by_channels([a, b], out, |[a, b], out| double::general(a, b, out))
        }
        _ => unreachable!("slices of one type"),
    }
}

/// [`generated::square`].
#[inline]
pub(crate) fn square<T: Coefficient>(a: &[T], out: &mut [T]) -> bool {
    match (T::typed(a), T::typed_mut(out)) {
        (Slice::Single(a), SliceMut::Single(out)) => single::square(a, out),
        (Slice::Double(a), SliceMut::Double(out)) => double::square(a, out),
        (Slice::SingleColors(a), SliceMut::SingleColors(out)) => {
            by_channels([a], out, |[a], out| single::square(a, out))
        }
        (Slice::DoubleColors(a), SliceMut::DoubleColors(out)) => {
            by_channels([a], out, |[a], out| double::square(a, out))
        }
        _ => unreachable!("slices of one type"),
    }
}

/// [`generated::zonal`].
#[inline]
pub(crate) fn zonal<T: Coefficient>(z: &[T::Scalar], b: &[T], out: &mut [T]) -> bool {
    match (T::Scalar::typed(z), T::typed(b), T::typed_mut(out)) {
        (Slice::Single(z), Slice::Single(b), SliceMut::Single(out)) => single::zonal(z, b, out),
        (Slice::Double(z), Slice::Double(b), SliceMut::Double(out)) => double::zonal(z, b, out),
        (Slice::Single(z), Slice::SingleColors(b), SliceMut::SingleColors(out)) => {
            by_channels([b], out, |[b], out| single::zonal(z, b, out))
        }
        (Slice::Double(z), Slice::DoubleColors(b), SliceMut::DoubleColors(out)) => {
            by_channels([b], out, |[b], out| double::zonal(z, b, out))
        }
        _ => unreachable!("slices of one type"),
    }
}

/// Multiplies channel by channel; whether there is code, which leaves `out` as it is where there is none.
fn by_channels<S: Real, const FACTORS: usize>(
    factors: [&[Rgb<S>]; FACTORS],
    out: &mut [Rgb<S>],
    multiply: impl Fn([&[S]; FACTORS], &mut [S]) -> bool,
) -> bool {
    if out.len() > MOST || factors.iter().any(|factor| factor.len() > MOST) {
        return false;
    }
    let (mut numbers, mut product) = ([[S::ZERO; MOST]; FACTORS], [S::ZERO; MOST]);
    for c in 0..Rgb::<S>::CHANNELS {
        let mut channels: [&[S]; FACTORS] = [&[]; FACTORS];
        for ((channel, numbers), factor) in channels.iter_mut().zip(&mut numbers).zip(factors) {
            numbers.iter_mut().zip(factor).for_each(|(number, color)| *number = color.channel(c));
            *channel = &numbers[..factor.len()];
        }
        let product = &mut product[..out.len()];
        if !multiply(channels, product) {
            return false;
        }
        for (color, number) in out.iter_mut().zip(product) {
            *color.channel_mut(c) = *number;
        }
    }
    true
}
