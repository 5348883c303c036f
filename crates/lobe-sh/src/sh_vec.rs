//! An expansion whose order is known at run time.

use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Neg, Sub, SubAssign};

use serde::de::{Deserialize, Deserializer, Error as _};
use serde::{Serialize, Serializer};

use crate::index::{len, order_of};
use crate::{Coefficient, Dir, Expansion, eval_basis};

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
        Self { coefficients: vec![T::ZERO; len(order)] }
    }

    /// The function of order `n` that is `value` everywhere: `f_00 = √(4π) value`.
    ///
    /// # Panics
    /// If `order` is 0.
    #[must_use]
    pub fn constant(order: usize, value: T) -> Self {
        assert!(order > 0, "a constant needs order 1 at least");
        let mut f = Self::zero(order);
        f.coefficients[0] = T::narrow(value.widen().scale((4.0 * std::f64::consts::PI).sqrt()));
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
        coefficients.resize(len(order), T::ZERO);
        Self { coefficients }
    }

    /// The expansion with every coefficient changed by `f`, for example to another number type.
    #[must_use]
    pub fn map<U: Coefficient>(&self, f: impl FnMut(T) -> U) -> ShVec<U> {
        ShVec { coefficients: self.coefficients.iter().copied().map(f).collect() }
    }

    fn assert_same_order(&self, other: &Self) {
        assert_eq!(self.order(), other.order(), "the orders of two expansions differ; resize one");
    }
}

impl<T: Coefficient> Expansion<T> for ShVec<T> {
    fn coefficients(&self) -> &[T] {
        &self.coefficients
    }

    fn coefficients_mut(&mut self) -> &mut [T] {
        &mut self.coefficients
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

impl<T: Coefficient> AddAssign<&Self> for ShVec<T> {
    fn add_assign(&mut self, other: &Self) {
        self.assert_same_order(other);
        for (a, b) in self.coefficients.iter_mut().zip(&other.coefficients) {
            *a += *b;
        }
    }
}

impl<T: Coefficient> SubAssign<&Self> for ShVec<T> {
    fn sub_assign(&mut self, other: &Self) {
        self.assert_same_order(other);
        for (a, b) in self.coefficients.iter_mut().zip(&other.coefficients) {
            *a -= *b;
        }
    }
}

impl<T: Coefficient> Add for &ShVec<T> {
    type Output = ShVec<T>;

    fn add(self, other: Self) -> ShVec<T> {
        let mut sum = self.clone();
        sum += other;
        sum
    }
}

impl<T: Coefficient> Sub for &ShVec<T> {
    type Output = ShVec<T>;

    fn sub(self, other: Self) -> ShVec<T> {
        let mut difference = self.clone();
        difference -= other;
        difference
    }
}

impl<T: Coefficient> Neg for &ShVec<T> {
    type Output = ShVec<T>;

    fn neg(self) -> ShVec<T> {
        self.map(|c| -c)
    }
}

/// Scales the function; for the product of two functions see [`product_into`](crate::product_into).
impl<T: Coefficient<Scalar = S>, S: Copy> Mul<S> for &ShVec<T> {
    type Output = ShVec<T>;

    fn mul(self, s: S) -> ShVec<T> {
        self.map(|c| c.scale(s))
    }
}

impl<T: Coefficient + Serialize> Serialize for ShVec<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.coefficients.serialize(serializer)
    }
}

impl<'de, T: Coefficient + Deserialize<'de>> Deserialize<'de> for ShVec<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let coefficients = Vec::<T>::deserialize(deserializer)?;
        let len = coefficients.len();
        Self::from_vec(coefficients).ok_or_else(|| D::Error::custom(format!("expected n² coefficients, found {len}")))
    }
}
