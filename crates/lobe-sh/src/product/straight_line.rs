//! The straight-line code, compiled here once for each type of coefficients and not again in every crate that multiplies.

use crate::Coefficient;
use crate::by_type::{by_type, of_each_type};
use crate::product::generated;
use crate::scalar::{TypedSlice as Slice, TypedSliceMut as SliceMut};

of_each_type! {
    pub(super) fn general(a: &[T], b: &[T], out: &mut [T]) -> bool {
        generated::general(a, b, out)
    }

    pub(super) fn square(a: &[T], out: &mut [T]) -> bool {
        generated::square(a, out)
    }

    pub(super) fn zonal(z: &[<T as Coefficient>::Scalar], b: &[T], out: &mut [T]) -> bool {
        generated::zonal(z, b, out)
    }
}

/// [`generated::general`].
#[inline]
pub(crate) fn general<T: Coefficient>(a: &[T], b: &[T], out: &mut [T]) -> bool {
    by_type!(T: a, b; mut out => general(a, b, out))
}

/// [`generated::square`].
#[inline]
pub(crate) fn square<T: Coefficient>(a: &[T], out: &mut [T]) -> bool {
    by_type!(T: a; mut out => square(a, out))
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
