//! An expansion whose order is known at run time.

use core::ops::{Add, AddAssign, Index, IndexMut, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::basis::eval_basis;
use crate::basis::index::{coefficient_count, order_of};
use crate::expansion::{Expansion, FixedOrder, Sh};
use crate::prelude::*;
use crate::scalar::Coefficient;
use crate::sphere::Dir;

/// An expansion of any order, its `n²` coefficients in index order `i = l(l+1) + m`.
///
/// Operators need equal orders; [`ShVec::resized`] makes them equal.
#[derive(Clone, Debug, PartialEq)]
pub struct ShVec<T = f32> {
    coefficients: Vec<T>,
}

impl<T: Coefficient> ShVec<T> {
    /// The function of order `n` that is zero everywhere.
    #[must_use]
    pub fn zero(order: usize) -> Self {
        Self { coefficients: vec![T::ZERO; coefficient_count(order)] }
    }

    /// The function of order `n` that is `value` everywhere: `f_00 = √(4π) value`.
    ///
    /// # Panics
    /// If `order` is 0.
    #[must_use]
    pub fn constant(order: usize, value: T) -> Self {
        assert!(order > 0, "a constant needs order 1 at least");
        let mut f = Self::zero(order);
        f.coefficients[0] = T::narrow(value.widen().scale((4.0 * core::f64::consts::PI).sqrt()));
        f
    }

    /// The basis functions towards `s` times `value`: the projection of a unit impulse of that strength.
    #[must_use]
    pub fn impulse(order: usize, s: Dir, value: T) -> Self {
        let y = eval_basis(s, order);
        Self { coefficients: y.into_iter().map(|y| T::narrow(value.widen().scale(y))).collect() }
    }

    /// The expansion of these coefficients; `None` if their number is no perfect square.
    #[must_use]
    pub fn from_vec(coefficients: Vec<T>) -> Option<Self> {
        order_of(coefficients.len()).map(|_| Self { coefficients })
    }

    /// The coefficients.
    #[must_use]
    pub fn into_vec(self) -> Vec<T> {
        self.coefficients
    }

    /// The expansion with another order: cut off, or filled up with zeros.
    #[must_use]
    pub fn resized(&self, order: usize) -> Self {
        let mut coefficients = self.coefficients.clone();
        coefficients.resize(coefficient_count(order), T::ZERO);
        Self { coefficients }
    }

    /// The expansion with every coefficient changed by `f`, for example to another number type.
    #[must_use]
    pub fn map<U: Coefficient>(&self, f: impl FnMut(T) -> U) -> ShVec<U> {
        ShVec { coefficients: self.coefficients.iter().copied().map(f).collect() }
    }

    /// The expansion of coefficients that are known to be `n²`.
    pub(crate) fn of(coefficients: Vec<T>) -> Self {
        debug_assert!(order_of(coefficients.len()).is_some(), "an expansion has n² coefficients");
        Self { coefficients }
    }

    /// The expansion as a type of fixed order: cut off, or filled up with zeros.
    ///
    /// ```
    /// use lobe_sh::{Dir, ShL1, ShVec};
    ///
    /// let light = ShVec::impulse(5, Dir::Z, 1.0_f32);
    /// assert_eq!(light.to_fixed::<ShL1>(), ShL1::impulse(Dir::Z, 1.0));
    /// ```
    #[must_use]
    pub fn to_fixed<E: FixedOrder<Value = T>>(&self) -> E {
        E::from_coefficients(self.coefficients())
    }
}

/// An expansion in `f64`, whatever its coefficients are kept in.
pub(crate) fn widened<T: Coefficient>(f: &impl Expansion<T>) -> ShVec<T::Wide> {
    ShVec::of(f.coefficients().iter().map(|c| c.widen()).collect())
}

impl<T: Coefficient> Expansion<T> for ShVec<T> {
    fn coefficients(&self) -> &[T] {
        &self.coefficients
    }

    fn coefficients_mut(&mut self) -> &mut [T] {
        &mut self.coefficients
    }
}

impl<const N: usize, T: Coefficient> From<Sh<N, T>> for ShVec<T> {
    fn from(f: Sh<N, T>) -> Self {
        Self { coefficients: f.to_array().to_vec() }
    }
}

impl<T> Index<usize> for ShVec<T> {
    type Output = T;

    fn index(&self, i: usize) -> &T {
        &self.coefficients[i]
    }
}

impl<T> IndexMut<usize> for ShVec<T> {
    fn index_mut(&mut self, i: usize) -> &mut T {
        &mut self.coefficients[i]
    }
}

/// Sums and differences of functions of one kind and order, by reference.
macro_rules! sums {
    ([$($generics:tt)*] $function:ty, $trait:ident $method:ident, $assign_trait:ident $assign_method:ident) => {
        impl $($generics)* $assign_trait<&Self> for $function {
            fn $assign_method(&mut self, other: &Self) {
                assert_eq!(self.order(), other.order(), "the orders of two functions differ; resize one");
                self.coefficients.iter_mut().zip(&other.coefficients).for_each(|(a, b)| a.$assign_method(*b));
            }
        }

        impl $($generics)* $trait for &$function {
            type Output = $function;

            fn $method(self, other: Self) -> $function {
                let mut result = self.clone();
                result.$assign_method(other);
                result
            }
        }
    };
}
pub(crate) use sums;

sums!([<T: Coefficient>] ShVec<T>, Add add, AddAssign add_assign);
sums!([<T: Coefficient>] ShVec<T>, Sub sub, SubAssign sub_assign);

/// Scales the function.
impl<T: Coefficient<Scalar = S>, S: Copy> MulAssign<S> for ShVec<T> {
    fn mul_assign(&mut self, s: S) {
        for c in &mut self.coefficients {
            *c = c.scale(s);
        }
    }
}

impl<T: Coefficient> Neg for &ShVec<T> {
    type Output = ShVec<T>;

    fn neg(self) -> ShVec<T> {
        self.map(|c| -c)
    }
}

/// Scales the function; for the product of two functions see [`product_into`](crate::product::product_into).
impl<T: Coefficient<Scalar = S>, S: Copy> Mul<S> for &ShVec<T> {
    type Output = ShVec<T>;

    fn mul(self, s: S) -> ShVec<T> {
        self.map(|c| c.scale(s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Rgb;
    use lobe_testkit::{Random, directions};

    fn random(order: usize, seed: u64) -> ShVec<f64> {
        ShVec { coefficients: Random::new(seed).signed_vec(coefficient_count(order)) }
    }

    #[test]
    fn arithmetic_is_that_of_the_functions() {
        let (f, g) = (random(5, 1), random(5, 2));
        let mut h = &(&f + &(&g * 0.5)) - &-&f;
        h *= 2.0;
        for v in directions() {
            let s = Dir::from_unit(v);
            let expected = 4.0 * f.eval(s) + g.eval(s);
            assert!((h.eval(s) - expected).abs() < 1e-12, "towards {v:?}: {} against {expected}", h.eval(s));
        }
    }

    #[test]
    #[should_panic(expected = "the orders of two functions differ")]
    fn expansions_of_different_orders_do_not_add() {
        let _ = &random(2, 1) + &random(3, 1);
    }

    #[test]
    fn constants_and_impulses_are_those_of_fixed_order() {
        let value = Rgb::new(1.0_f32, 0.5, -2.0);
        assert_eq!(ShVec::constant(3, value), crate::ShL2::constant(value).into(), "constant");
        for v in directions() {
            let s = Dir::from_unit(v);
            assert_eq!(ShVec::impulse(3, s, value), crate::ShL2::impulse(s, value).into(), "impulse towards {v:?}");
        }
    }

    #[test]
    fn only_perfect_squares_are_expansions() {
        assert_eq!(ShVec::from_vec(vec![1.0; 8]), None, "8 coefficients");
        assert_eq!(ShVec::from_vec(vec![1.0; 9]).map(|f| f.order()), Some(3), "9 coefficients");
        let f = random(4, 3);
        assert_eq!(f.resized(6).resized(4), f, "longer and back");
        assert_eq!(f.resized(2).coefficients(), &f.coefficients()[..4], "cut off");
    }

    #[test]
    fn order_zero_is_the_zero_function() {
        let none = ShVec::<f64>::zero(0);
        assert_eq!((none.order(), none.eval(Dir::X), none.mean()), (0, 0.0, 0.0), "order, value, mean");
        assert_eq!((none.dot(&random(3, 1)), none.band_energies()), (0.0, vec![]), "dot and energies");
    }

    #[cfg(feature = "json")]
    #[test]
    fn serialization_round_trips_and_checks_the_length() {
        let f = random(3, 4);
        let text = serde_json::to_string(&f).unwrap();
        assert_eq!(serde_json::from_str::<ShVec<f64>>(&text).unwrap(), f, "{text}");
        let error = serde_json::from_str::<ShVec<f64>>("[1, 2, 3]").unwrap_err().to_string();
        assert!(error.contains("expected n² coefficients, found 3"), "{error}");
    }
}
