//! The straight-line code, compiled here once for each type of coefficients and not again in every crate that multiplies.

use crate::Coefficient;
use crate::product::generated;
use crate::scalar::{TypedSlice as Slice, TypedSliceMut as SliceMut};

macro_rules! of_types {
    ($($name:ident: $t:ty, $scalar:ty;)*) => {$(
        mod $name {
            use super::generated;

            #[inline(never)]
            pub(super) fn general(a: &[$t], b: &[$t], out: &mut [$t]) -> bool {
                generated::general(a, b, out)
            }

            #[inline(never)]
            pub(super) fn square(a: &[$t], out: &mut [$t]) -> bool {
                generated::square(a, out)
            }

            #[inline(never)]
            pub(super) fn zonal(z: &[$scalar], b: &[$t], out: &mut [$t]) -> bool {
                generated::zonal(z, b, out)
            }
        }
    )*};
}

of_types! {
    single: f32, f32;
    double: f64, f64;
    single_colors: crate::Rgb<f32>, f32;
    double_colors: crate::Rgb<f64>, f64;
}

/// [`generated::general`].
#[inline]
pub(crate) fn general<T: Coefficient>(a: &[T], b: &[T], out: &mut [T]) -> bool {
    match (T::typed(a), T::typed(b), T::typed_mut(out)) {
        (Slice::Single(a), Slice::Single(b), SliceMut::Single(out)) => single::general(a, b, out),
        (Slice::Double(a), Slice::Double(b), SliceMut::Double(out)) => double::general(a, b, out),
        (Slice::SingleColors(a), Slice::SingleColors(b), SliceMut::SingleColors(out)) => {
            single_colors::general(a, b, out)
        }
        (Slice::DoubleColors(a), Slice::DoubleColors(b), SliceMut::DoubleColors(out)) => {
            double_colors::general(a, b, out)
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
        (Slice::SingleColors(a), SliceMut::SingleColors(out)) => single_colors::square(a, out),
        (Slice::DoubleColors(a), SliceMut::DoubleColors(out)) => double_colors::square(a, out),
        _ => unreachable!("slices of one type"),
    }
}

/// [`generated::zonal`].
#[inline]
pub(crate) fn zonal<T: Coefficient>(z: &[T::Scalar], b: &[T], out: &mut [T]) -> bool {
    match (T::Scalar::typed(z), T::typed(b), T::typed_mut(out)) {
        (Slice::Single(z), Slice::Single(b), SliceMut::Single(out)) => single::zonal(z, b, out),
        (Slice::Double(z), Slice::Double(b), SliceMut::Double(out)) => double::zonal(z, b, out),
        (Slice::Single(z), Slice::SingleColors(b), SliceMut::SingleColors(out)) => single_colors::zonal(z, b, out),
        (Slice::Double(z), Slice::DoubleColors(b), SliceMut::DoubleColors(out)) => double_colors::zonal(z, b, out),
        _ => unreachable!("slices of one type"),
    }
}
