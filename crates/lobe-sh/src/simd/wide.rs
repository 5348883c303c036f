//! Arithmetic on as many numbers at once as a register of the machine holds.

use core::ops::{Add, Div, Mul, Sub};

use pulp::Simd;

use crate::simd::{LANES, Lane, Lanes};

/// As many numbers as a register holds.
#[derive(Clone, Copy, Debug)]
pub struct Wide<S: Simd, T: Lane = f32> {
    pub(super) simd: S,
    pub(super) values: T::Register<S>,
}

/// A constant in every lane.
#[inline(always)]
pub fn constant<S: Simd>(simd: S, value: f32) -> Wide<S> {
    Wide::splat(simd, value)
}

/// The number nearest to a constant, in every lane.
#[inline(always)]
pub(crate) fn rounded<S: Simd, T: Lane>(simd: S, value: f64) -> Wide<S, T> {
    Wide::splat(simd, T::from_f64(value))
}

impl<S: Simd> Wide<S> {
    /// The parts into which a block falls.
    pub const PARTS: usize = LANES / S::F32_LANES;

    /// Part `part` of a block.
    #[inline(always)]
    pub fn load(simd: S, block: &Lanes, part: usize) -> Self {
        Self::load_array(simd, &block.0, part)
    }

    /// To part `part` of a block.
    #[inline(always)]
    pub fn store(self, block: &mut Lanes, part: usize) {
        self.store_array(&mut block.0, part);
    }
}

impl<S: Simd, T: Lane> Wide<S, T> {
    /// One number in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: T) -> Self {
        Self { simd, values: <T as Lane>::splat(simd, value) }
    }

    /// Part `part` of numbers, of which a register holds each.
    #[inline(always)]
    pub fn load_array(simd: S, numbers: &[T], part: usize) -> Self {
        Self { simd, values: T::registers::<S>(numbers).0[part] }
    }

    /// To part `part` of numbers, of which a register holds each.
    #[inline(always)]
    pub fn store_array(self, numbers: &mut [T], part: usize) {
        T::registers_mut::<S>(numbers).0[part] = self.values;
    }

    /// `self · factor + term`, rounded once.
    #[inline(always)]
    pub fn times_plus(self, factor: Self, term: Self) -> Self {
        self.with(T::mul_add(self.simd, self.values, factor.values, term.values))
    }

    /// `term - self · factor`, rounded once.
    #[inline(always)]
    pub fn times_from(self, factor: Self, term: Self) -> Self {
        self.negated().times_plus(factor, term)
    }

    /// `self · factor - term`, rounded once.
    #[inline(always)]
    pub fn times_minus(self, factor: Self, term: Self) -> Self {
        self.times_plus(factor, term.negated())
    }

    /// `-self`.
    #[inline(always)]
    pub fn negated(self) -> Self {
        self.with(<T as Lane>::neg(self.simd, self.values))
    }

    /// -1 where this is negative, else 1.
    #[inline(always)]
    pub fn sign(self) -> Self {
        let simd = self.simd;
        self.if_less(Self::splat(simd, T::ZERO), Self::splat(simd, -T::ONE), Self::splat(simd, T::ONE))
    }

    /// The smaller of each two.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.with(T::min(self.simd, self.values, other.values))
    }

    /// The larger of each two.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.with(T::max(self.simd, self.values, other.values))
    }

    /// The square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.with(T::sqrt(self.simd, self.values))
    }

    /// One divided by this.
    #[inline(always)]
    pub fn recip(self) -> Self {
        Self::splat(self.simd, T::ONE) / self
    }

    /// `then` where this is less than `other`, `or` elsewhere.
    #[inline(always)]
    pub fn if_less(self, other: Self, then: Self, or: Self) -> Self {
        self.with(T::if_less(self.simd, [self.values, other.values], [then.values, or.values]))
    }

    /// Whether any is above `limit`.
    #[inline(always)]
    pub fn any_above(self, limit: Self) -> bool {
        T::any_less(self.simd, limit.values, self.values)
    }

    #[inline(always)]
    pub(super) fn with(self, values: T::Register<S>) -> Self {
        Self { simd: self.simd, values }
    }
}

macro_rules! operator {
    ($trait:ident $method:ident) => {
        impl<S: Simd, T: Lane> $trait for Wide<S, T> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.with(<T as Lane>::$method(self.simd, self.values, other.values))
            }
        }
    };
}

operator!(Add add);
operator!(Sub sub);
operator!(Mul mul);
operator!(Div div);
