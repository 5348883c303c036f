//! Arithmetic on as many `f32` at once as the machine's registers hold, and the exponential of them.
//!
//! Sixteen receivers go together, [`Block`] by block; a machine of narrower registers takes a block in several parts. Machines
//! that can round a product and a sum together do, which halves the operations: results are the same for any number of
//! threads, and differ in the last digits between kinds of machines.

use std::ops::{Add, Mul, Sub};

use pulp::Simd;

/// Receivers that are computed together.
pub(crate) const BLOCK: usize = 16;

/// One number for each receiver of a block.
pub(crate) type Block = [f32; BLOCK];

/// As many numbers as a register holds.
#[derive(Clone, Copy)]
pub(crate) struct Lanes<S: Simd> {
    simd: S,
    values: S::f32s,
}

impl<S: Simd> Lanes<S> {
    /// The parts into which a block falls.
    pub(crate) const PARTS: usize = BLOCK / S::F32_LANES;

    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f32) -> Self {
        Self { simd, values: simd.splat_f32s(value) }
    }

    /// Part `part` of a block.
    #[inline(always)]
    pub(crate) fn load(simd: S, block: &Block, part: usize) -> Self {
        Self { simd, values: S::as_simd_f32s(block).0[part] }
    }

    #[inline(always)]
    pub(crate) fn store(self, block: &mut Block, part: usize) {
        S::as_mut_simd_f32s(block).0[part] = self.values;
    }

    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        self.with(self.simd.min_f32s(self.values, other.values))
    }

    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        self.with(self.simd.max_f32s(self.values, other.values))
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        self.with(self.simd.sqrt_f32s(self.values))
    }

    /// `self · factor + term`.
    #[inline(always)]
    pub(crate) fn times_plus(self, factor: Self, term: Self) -> Self {
        self.with(self.simd.mul_add_e_f32s(self.values, factor.values, term.values))
    }

    /// One divided by this.
    #[inline(always)]
    pub(crate) fn recip(self) -> Self {
        self.with(self.simd.div_f32s(self.simd.splat_f32s(1.0), self.values))
    }

    /// `1/√x` for a normal `x` above 0, within 5e-7 of it: Newton's steps from an estimate of 3.5 %, without the division and the root,
    /// which take several times as long.
    ///
    /// The estimate halves the exponent: the bits of a float, read as an integer, are nearly its logarithm (Lomont 2003). Each
    /// step leaves 3/2 of the square of the error: 1.8e-3, 4.7e-6, rounding.
    #[inline(always)]
    pub(crate) fn inverse_sqrt(self) -> Self {
        let simd = self.simd;
        let bits = simd.transmute_u32s_f32s(self.values);
        let halved = simd.wrapping_dyn_shr_u32s(bits, simd.splat_u32s(1));
        let mut y = self.with(simd.transmute_f32s_u32s(simd.sub_u32s(simd.splat_u32s(INVERSE_SQRT), halved)));
        let minus_half = self * Self::splat(simd, -0.5);
        for _ in 0..3 {
            y = y * (minus_half * y).times_plus(y, Self::splat(simd, 1.5));
        }
        y
    }

    /// `then` where this is less than `other`, `or` elsewhere.
    #[inline(always)]
    pub(crate) fn if_less(self, other: Self, then: Self, or: Self) -> Self {
        self.with(self.simd.select_f32s(self.simd.less_than_f32s(self.values, other.values), then.values, or.values))
    }

    /// Whether any is above `limit`.
    #[inline(always)]
    pub(crate) fn any_above(self, limit: Self) -> bool {
        self.simd.first_true_m32s(self.simd.less_than_f32s(limit.values, self.values)) < S::F32_LANES
    }

    #[inline(always)]
    fn with(self, values: S::f32s) -> Self {
        Self { simd: self.simd, values }
    }

    /// `eˣ`, within 2e-7 of it for `x` from -87 to 88, where `f32` is normal; beyond, that of the nearer end (test
    /// `the_exponential_of_lanes_is_within_its_stated_error`).
    ///
    /// ```text
    ///   eˣ = 2^k e^r        k = x / ln 2, rounded        r = x - k ln 2, |r| <= ½ ln 2
    /// ```
    ///
    /// `e^r` is its Taylor polynomial of degree 7, the remainder of which is below `(½ ln 2)⁸/8! = 5e-9`. `ln 2` is taken off in
    /// two parts, of which the first has so few digits that its product with `k` is exact (Cody and Waite 1980).
    #[inline(always)]
    pub(crate) fn exp(self) -> Self {
        let splat = |value| Self::splat(self.simd, value);
        let x = self.max(splat(EXP_RANGE[0])).min(splat(EXP_RANGE[1]));
        // The sum with a number so large has no digits after the point, and k in the lowest bits.
        let shifted = x.times_plus(splat(std::f32::consts::LOG2_E), splat(SHIFT));
        let k = shifted - splat(SHIFT);
        let r = k.times_plus(splat(-LN_2[1]), k.times_plus(splat(-LN_2[0]), x));
        let mut p = splat(TAYLOR[0]);
        for c in &TAYLOR[1..] {
            p = p.times_plus(r, splat(*c));
        }
        let simd = self.simd;
        let bits = simd.transmute_u32s_f32s(shifted.values);
        let exponent = simd.wrapping_dyn_shl_u32s(bits, simd.splat_u32s(f32::MANTISSA_DIGITS - 1));
        let power = simd.add_u32s(exponent, simd.splat_u32s(1.0_f32.to_bits()));
        p * self.with(simd.transmute_f32s_u32s(power))
    }
}

/// The bits from which half of those of a number are taken for its inverse root (Lomont 2003).
const INVERSE_SQRT: u32 = 0x5f37_5a86;

/// The arguments between which the exponential is a normal `f32`.
const EXP_RANGE: [f32; 2] = [-87.0, 88.0];

/// `1.5 · 2²³`: its neighbors are whole numbers, and its lowest bits are zero.
const SHIFT: f32 = 12_582_912.0;

/// `ln 2` in 9 digits and the rest.
const LN_2: [f32; 2] = [0.693_359_375, -2.121_944_4e-4];

/// `1/k!` from the seventh down.
const TAYLOR: [f32; 8] = [1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0];

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(self.simd.add_f32s(self.values, other.values))
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(self.simd.sub_f32s(self.values, other.values))
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(self.simd.mul_f32s(self.values, other.values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::{Arch, WithSimd};

    struct InverseRoots<'a>(&'a mut [Block]);

    impl WithSimd for InverseRoots<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for block in self.0 {
                for part in 0..Lanes::<S>::PARTS {
                    Lanes::load(simd, block, part).inverse_sqrt().store(block, part);
                }
            }
        }
    }

    #[test]
    fn inverse_roots_are_within_their_stated_error() {
        let arguments: Vec<f32> =
            (0..160_000).map(|k| 10_f64.powf(60.0 * k as f64 / 160_000.0 - 30.0) as f32).collect();
        for arch in [Arch::new(), Arch::Scalar] {
            let mut found = arguments.as_chunks::<BLOCK>().0.to_vec();
            arch.dispatch(InverseRoots(&mut found));
            let error = |(x, found): (&f32, &f32)| (f64::from(*found) * f64::from(*x).sqrt() - 1.0).abs();
            let worst = arguments.iter().zip(found.as_flattened()).map(error).fold(0.0, f64::max);
            println!("{worst:.2e}");
            assert!(worst < 5e-7, "{worst:.2e}");
        }
    }

    struct Exponentials<'a>(&'a mut [Block]);

    impl WithSimd for Exponentials<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for block in self.0 {
                for part in 0..Lanes::<S>::PARTS {
                    Lanes::load(simd, block, part).exp().store(block, part);
                }
            }
        }
    }

    #[test]
    fn the_exponential_of_lanes_is_within_its_stated_error() {
        let count = 200_000;
        let arguments: Vec<f32> = (0..count).map(|k| -87.0 + 175.0 * k as f32 / count as f32).collect();
        let mut wide = arguments.as_chunks::<BLOCK>().0.to_vec();
        let mut narrow = wide.clone();
        Arch::new().dispatch(Exponentials(&mut wide));
        Arch::Scalar.dispatch(Exponentials(&mut narrow));
        let mut worst = 0.0_f64;
        for found in [&wide, &narrow] {
            for (x, found) in arguments.iter().zip(found.as_flattened()) {
                worst = worst.max((f64::from(*found) / f64::from(*x).exp() - 1.0).abs());
            }
        }
        println!("{worst:.2e}");
        assert!(worst < 2e-7, "{worst}");
        let mut ends = [[-1e4; BLOCK], [1e4; BLOCK], [0.0; BLOCK]];
        Arch::new().dispatch(Exponentials(&mut ends));
        assert!(ends[0][0] > 0.0 && ends[0][0] < 1e-37 && ends[1][0] < f32::INFINITY && ends[2][0] == 1.0, "{ends:?}");
    }
}
