//! An expansion whose order is known at compile time.

use core::ops::{Add, AddAssign, Index, IndexMut, Mul, MulAssign, Neg, Sub, SubAssign};

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::basis::basis::eval_basis_into;
use crate::basis::index::order_of;
use crate::expansion::{Expansion, FixedOrder};
use crate::scalar::{Coefficient, Real, Rgb};
use crate::sphere::Dir;

/// An expansion of `N` coefficients, a perfect square: order `n = √N`, index order `i = l(l+1) + m`.
///
/// Counted by coefficients because stable Rust cannot write `[T; n * n]`; the aliases [`ShL0`] to [`ShL9`] name
/// the highest band instead. A wrong `N` does not compile:
///
/// ```compile_fail
/// let not_a_square = lobe_sh::Sh::<5, f32>::zero();
/// ```
///
/// ```
/// use lobe_sh::{Dir, Expansion as _, ShL2};
///
/// let f = ShL2::from([1.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// assert!(f.eval(Dir::Z) > f.eval(-Dir::Z));
/// assert_eq!(f.dot(&f), 1.25);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Sh<const N: usize, T = f32> {
    pub(crate) coefficients: [T; N],
}

macro_rules! aliases {
    ($($name:ident $n:literal $band:literal),*) => {$(
        #[doc = concat!("An expansion of bands 0 to ", $band, ": ", $n, " coefficients.")]
        pub type $name<T = f32> = Sh<$n, T>;
    )*};
}

aliases!(
    ShL0 1 "0", ShL1 4 "1", ShL2 9 "2", ShL3 16 "3", ShL4 25 "4",
    ShL5 36 "5", ShL6 49 "6", ShL7 64 "7", ShL8 81 "8", ShL9 100 "9"
);

impl<const N: usize, T> Sh<N, T> {
    /// The expansion of these coefficients, which need not be numbers yet.
    pub(crate) fn of(coefficients: [T; N]) -> Self {
        const { assert!(order_of(N).is_some(), "N must be a perfect square") }
        Self { coefficients }
    }
}

impl<const N: usize, T: Coefficient> Sh<N, T> {
    /// The order `n = √N`.
    pub const ORDER: usize = match order_of(N) {
        Some(order) => order,
        None => panic!("the number of coefficients of an expansion must be a perfect square"),
    };

    /// The function that is zero everywhere.
    #[must_use]
    pub const fn zero() -> Self {
        const { assert!(Self::ORDER * Self::ORDER == N, "N must be a perfect square") }
        Self { coefficients: [T::ZERO; N] }
    }

    /// The function that is `value` everywhere: `f_00 = √(4π) value`.
    #[must_use]
    pub fn constant(value: T) -> Self {
        const { assert!(N > 0, "a constant needs order 1 at least") }
        let mut f = Self::zero();
        f.coefficients[0] = T::narrow(value.widen().scale((4.0 * core::f64::consts::PI).sqrt()));
        f
    }

    /// The basis functions towards `s` times `value`: the projection of a unit impulse of that strength.
    #[must_use]
    pub fn impulse(s: Dir, value: T) -> Self {
        let mut y = [0.0; N];
        eval_basis_into(s.to_array(), &mut y);
        Self::from(y.map(|y| T::narrow(value.widen().scale(y))))
    }

    /// The first `n²` of these coefficients; missing ones are zero.
    #[must_use]
    pub fn from_slice(coefficients: &[T]) -> Self {
        <Self as FixedOrder>::from_coefficients(coefficients)
    }

    /// The coefficients as an array.
    #[must_use]
    pub fn to_array(self) -> [T; N] {
        self.coefficients
    }

    /// The expansion with another number of coefficients: cut off, or filled up with zeros.
    #[must_use]
    pub fn resized<const M: usize>(&self) -> Sh<M, T> {
        Sh::from_slice(&self.coefficients)
    }

    /// The expansion with every coefficient changed by `f`, for example to another number type.
    #[must_use]
    pub fn map<U: Coefficient>(self, f: impl FnMut(T) -> U) -> Sh<N, U> {
        Sh { coefficients: self.coefficients.map(f) }
    }
}

impl<const N: usize, T: Coefficient> From<[T; N]> for Sh<N, T> {
    fn from(coefficients: [T; N]) -> Self {
        Self::of(coefficients)
    }
}

impl<const N: usize, T: Coefficient> Expansion<T> for Sh<N, T> {
    fn coefficients(&self) -> &[T] {
        &self.coefficients
    }

    fn coefficients_mut(&mut self) -> &mut [T] {
        &mut self.coefficients
    }

    fn order(&self) -> usize {
        Self::ORDER
    }
}

impl<const N: usize, T: Coefficient> FixedOrder for Sh<N, T> {
    type Value = T;
    const ORDER: usize = Self::ORDER;

    fn zero() -> Self {
        Self::zero()
    }
}

impl<const N: usize, T: Coefficient> Default for Sh<N, T> {
    fn default() -> Self {
        Self::zero()
    }
}

impl<const N: usize, T> Index<usize> for Sh<N, T> {
    type Output = T;

    fn index(&self, i: usize) -> &T {
        &self.coefficients[i]
    }
}

impl<const N: usize, T> IndexMut<usize> for Sh<N, T> {
    fn index_mut(&mut self, i: usize) -> &mut T {
        &mut self.coefficients[i]
    }
}

/// Scales the function.
impl<const N: usize, T: Coefficient<Scalar = S>, S: Copy> MulAssign<S> for Sh<N, T> {
    fn mul_assign(&mut self, s: S) {
        for c in &mut self.coefficients {
            *c = c.scale(s);
        }
    }
}

macro_rules! coefficientwise {
    ($trait:ident $method:ident, $assign_trait:ident $assign_method:ident) => {
        impl<const N: usize, T: Coefficient> $assign_trait for Sh<N, T> {
            fn $assign_method(&mut self, other: Self) {
                self.coefficients.iter_mut().zip(other.coefficients).for_each(|(a, b)| a.$assign_method(b));
            }
        }

        impl<const N: usize, T: Coefficient> $trait for Sh<N, T> {
            type Output = Self;

            fn $method(mut self, other: Self) -> Self {
                self.$assign_method(other);
                self
            }
        }
    };
}

coefficientwise!(Add add, AddAssign add_assign);
coefficientwise!(Sub sub, SubAssign sub_assign);

impl<const N: usize, T: Coefficient> Neg for Sh<N, T> {
    type Output = Self;

    fn neg(self) -> Self {
        Self { coefficients: self.coefficients.map(|c| -c) }
    }
}

/// Scales the function; for the product of two functions see [`product_into`](crate::product::product_into).
impl<const N: usize, T: Coefficient<Scalar = S>, S: Copy> Mul<S> for Sh<N, T> {
    type Output = Self;

    fn mul(self, s: S) -> Self {
        Self { coefficients: self.coefficients.map(|c| c.scale(s)) }
    }
}

impl<const N: usize, T> From<Sh<N, T>> for [T; N] {
    fn from(f: Sh<N, T>) -> Self {
        f.coefficients
    }
}

/// Rows of red, green and blue, as engines keep them: `[[f32; 3]; 9]` for bands 0 to 2.
impl<const N: usize, S: Real> From<[[S; 3]; N]> for Sh<N, Rgb<S>> {
    fn from(rows: [[S; 3]; N]) -> Self {
        Self::from(rows.map(Rgb::from))
    }
}

impl<const N: usize, S: Real> From<Sh<N, Rgb<S>>> for [[S; 3]; N] {
    fn from(f: Sh<N, Rgb<S>>) -> Self {
        f.coefficients.map(Rgb::to_array)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::ShVec;
    use crate::scalar::Rgb;

    #[test]
    fn arithmetic_is_that_of_the_functions() {
        let f = ShL2::<f64>::from_slice(&[1.0, -2.0, 0.5, 3.0, 0.25, -1.0, 2.0, 0.75, -0.5]);
        let g = ShL2::<f64>::constant(2.0);
        for v in lobe_testkit::directions() {
            let s = Dir::from_unit(v);
            let sum = (f + g * 0.5 - f * 3.0).eval(s);
            let expected = -2.0 * f.eval(s) + 1.0;
            assert!((sum - expected).abs() < 1e-13, "towards {v:?}: {sum} against {expected}");
        }
    }

    #[test]
    fn resizing_keeps_the_common_bands() {
        let f = ShL1::from([1.0_f32, 2.0, 3.0, 4.0]);
        assert_eq!(f.resized::<9>().to_array(), [1.0, 2.0, 3.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0], "up");
        assert_eq!(f.resized::<1>().to_array(), [1.0], "down");
    }

    #[test]
    fn fixed_and_run_time_orders_convert() {
        let f = ShL2::<f64>::from_slice(&lobe_testkit::Random::new(2).signed_vec(9));
        let g = ShVec::from(f);
        assert_eq!(g.coefficients(), f.coefficients(), "to run time");
        assert_eq!(ShL2::from_slice(g.coefficients()), f, "and back");
        assert_eq!(f.map(|c| Rgb::splat(c as f32))[3].g, f[3] as f32, "to f32 colors");
        let mut twice = f;
        twice *= 2.0;
        assert_eq!(twice, f * 2.0, "scaled");
        assert_eq!((ShL2::default(), -(f - f)), (ShL2::<f64>::zero(), f * -0.0), "zero");
    }

    #[test]
    fn the_dot_product_with_an_impulse_evaluates() {
        let f = ShL3::<f64>::from_slice(&lobe_testkit::Random::new(1).signed_vec(16));
        for v in lobe_testkit::directions() {
            let s = Dir::from_unit(v);
            let by_dot = f.dot(&ShL3::impulse(s, 1.0));
            assert!((by_dot - f.eval(s)).abs() < 1e-13, "towards {v:?}: {by_dot} against {}", f.eval(s));
        }
    }

    #[test]
    fn channels_do_not_mix() {
        let f = ShL1::<Rgb<f64>>::impulse(Dir::X, Rgb::new(1.0, 0.0, 2.0));
        let value = f.eval(Dir::X);
        assert!(value.g == 0.0 && (value.b - 2.0 * value.r).abs() < 1e-15, "{value:?}");
    }

    #[cfg(feature = "json")]
    #[test]
    fn serialization_round_trips_and_checks_the_length() {
        let f = ShL1::<Rgb>::impulse(Dir::X, Rgb::new(1.0, 0.5, 2.0));
        let text = serde_json::to_string(&f).unwrap();
        assert_eq!(serde_json::from_str::<ShL1<Rgb>>(&text).unwrap(), f, "{text}");
        assert!(serde_json::from_str::<ShL2<Rgb>>(&text).is_err(), "4 rows are no ShL2");
    }
}
