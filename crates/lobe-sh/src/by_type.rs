//! Code that is compiled in this crate, once for each type of coefficients.
//!
//! Rationale
//! - A generic function is compiled in every crate that calls it, with the optimization of that crate: users would wait
//!   for kernels again and again, and in a program that is built for debugging, with dependencies that are optimized,
//!   kernels would be as slow as the program.
//! - Functions that are not generic are compiled where they stand; `inline(never)`, as rustc would otherwise compile
//!   small ones again where they are called. [`of_each_type`] writes one for each type, and [`by_type`] calls that of
//!   the slices at hand, in place of a method of [`Coefficient`](crate::Coefficient) for each kernel:
//!
//! ```ignore
//! of_each_type! {
//!     pub(super) fn turn(by: &Rotation, f: &mut [T]) { .. }
//! }
//!
//! fn turn<T: Coefficient>(by: &Rotation, f: &mut [T]) {
//!     by_type!(T: mut f => turn(by, f));
//! }
//! ```
//!
//! - A module has one `of_each_type!`, whose modules have fixed names. `T` is an alias there, so that its number is
//!   `<T as Coefficient>::Scalar`. The names before the arrow become slices of the type at hand: what is no slice is
//!   passed as a slice of one.

/// The functions once for each type of coefficients, which they call `T`, in modules that [`by_type`] finds; with
/// `numbers:` for `f32` and `f64` alone.
macro_rules! of_each_type {
    (@modules $($name:ident $t:ty),*; $functions:tt) => {
        $(crate::by_type::of_each_type! { @module $name $t; $functions })*
    };
    (@module $name:ident $t:ty; { $($function:item)* }) => {
        mod $name {
            use super::*;

            type T = $t;

            $(#[inline(never)] $function)*
        }
    };
    (numbers: $($function:item)*) => {
        crate::by_type::of_each_type! { @modules single f32, double f64; { $($function)* } }
    };
    ($($function:item)*) => {
        crate::by_type::of_each_type! {
            @modules single f32, double f64, single_colors crate::Rgb<f32>, double_colors crate::Rgb<f64>;
            { $($function)* }
        }
    };
}

/// Calls the function that [`of_each_type`] has made for the slices, which all are of one type `T`; those to write to
/// say `mut`.
macro_rules! by_type {
    ($t:ident: mut $out:ident => $function:ident($($argument:expr),*)) => {
        match <$t as crate::Coefficient>::typed_mut($out) {
            crate::scalar::TypedSliceMut::Single($out) => single::$function($($argument),*),
            crate::scalar::TypedSliceMut::Double($out) => double::$function($($argument),*),
            crate::scalar::TypedSliceMut::SingleColors($out) => single_colors::$function($($argument),*),
            crate::scalar::TypedSliceMut::DoubleColors($out) => double_colors::$function($($argument),*),
        }
    };
    ($t:ident: $($read:ident),+; mut $out:ident => $function:ident($($argument:expr),*)) => {
        match ($(<$t as crate::Coefficient>::typed($read),)+ <$t as crate::Coefficient>::typed_mut($out)) {
            ($(crate::scalar::TypedSlice::Single($read),)+ crate::scalar::TypedSliceMut::Single($out)) => {
                single::$function($($argument),*)
            }
            ($(crate::scalar::TypedSlice::Double($read),)+ crate::scalar::TypedSliceMut::Double($out)) => {
                double::$function($($argument),*)
            }
            ($(crate::scalar::TypedSlice::SingleColors($read),)+ crate::scalar::TypedSliceMut::SingleColors($out)) => {
                single_colors::$function($($argument),*)
            }
            ($(crate::scalar::TypedSlice::DoubleColors($read),)+ crate::scalar::TypedSliceMut::DoubleColors($out)) => {
                double_colors::$function($($argument),*)
            }
            _ => unreachable!("slices of one type"),
        }
    };
}

pub(crate) use {by_type, of_each_type};
