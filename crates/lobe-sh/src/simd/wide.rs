//! Arithmetic on as many `f32` at once as a register of the machine holds.

use core::ops::{Add, Mul, Sub};

use pulp::Simd;

use crate::simd::{LANES, Lanes};

/// As many numbers as a register holds.
#[derive(Clone, Copy, Debug)]
pub struct Wide<S: Simd> {
    pub(super) simd: S,
    pub(super) values: S::f32s,
}

/// A constant in every lane.
#[inline(always)]
pub fn constant<S: Simd>(simd: S, value: f32) -> Wide<S> {
    Wide { simd, values: simd.splat_f32s(value) }
}

impl<S: Simd> Wide<S> {
    /// The parts into which a block falls.
    pub const PARTS: usize = LANES / S::F32_LANES;

    /// Part `part` of a block.
    #[inline(always)]
    pub fn load(simd: S, block: &Lanes, part: usize) -> Self {
        Self::load_array(simd, &block.0, part)
    }

    /// Part `part` of sixteen numbers.
    #[inline(always)]
    pub fn load_array(simd: S, block: &[f32; LANES], part: usize) -> Self {
        Self { simd, values: S::as_simd_f32s(block).0[part] }
    }

    /// To part `part` of a block.
    #[inline(always)]
    pub fn store(self, block: &mut Lanes, part: usize) {
        self.store_array(&mut block.0, part);
    }

    /// To part `part` of sixteen numbers.
    #[inline(always)]
    pub fn store_array(self, block: &mut [f32; LANES], part: usize) {
        S::as_mut_simd_f32s(block).0[part] = self.values;
    }

    /// `self · factor + term`, rounded once.
    #[inline(always)]
    pub fn times_plus(self, factor: Self, term: Self) -> Self {
        self.with(self.simd.mul_add_e_f32s(self.values, factor.values, term.values))
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
        self.with(self.simd.xor_f32s(self.values, self.simd.splat_f32s(-0.0)))
    }

    /// -1 where this is negative, else 1.
    #[inline(always)]
    pub fn sign(self) -> Self {
        let simd = self.simd;
        self.if_less(constant(simd, 0.0), constant(simd, -1.0), constant(simd, 1.0))
    }

    /// The smaller of each two.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.with(self.simd.min_f32s(self.values, other.values))
    }

    /// The larger of each two.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.with(self.simd.max_f32s(self.values, other.values))
    }

    /// The square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.with(self.simd.sqrt_f32s(self.values))
    }

    /// One divided by this.
    #[inline(always)]
    pub fn recip(self) -> Self {
        self.with(self.simd.div_f32s(self.simd.splat_f32s(1.0), self.values))
    }

    /// `then` where this is less than `other`, `or` elsewhere.
    #[inline(always)]
    pub fn if_less(self, other: Self, then: Self, or: Self) -> Self {
        let simd = self.simd;
        // By their bits: the selection of numbers is a call of pulp that is compiled without AVX2.
        let (then, or) = (simd.transmute_u32s_f32s(then.values), simd.transmute_u32s_f32s(or.values));
        let chosen = simd.select_u32s(simd.less_than_f32s(self.values, other.values), then, or);
        self.with(simd.transmute_f32s_u32s(chosen))
    }

    /// Whether any is above `limit`.
    #[inline(always)]
    pub fn any_above(self, limit: Self) -> bool {
        self.simd.first_true_m32s(self.simd.less_than_f32s(limit.values, self.values)) < S::F32_LANES
    }

    #[inline(always)]
    pub(super) fn with(self, values: S::f32s) -> Self {
        Self { simd: self.simd, values }
    }
}

macro_rules! operator {
    ($trait:ident $method:ident $of_simd:ident) => {
        impl<S: Simd> $trait for Wide<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.with(self.simd.$of_simd(self.values, other.values))
            }
        }
    };
}

operator!(Add add add_f32s);
operator!(Sub sub sub_f32s);
operator!(Mul mul mul_f32s);
