//! Roots and exponentials of as many `f32` at once as a register holds.

use pulp::Simd;

use crate::simd::{Wide, constant};

impl<S: Simd> Wide<S> {
    /// `1/√x` for a normal `x` above 0, within 5e-7 of it: Newton's steps from an estimate of 3.5 %, without the division and the root,
    /// which take several times as long.
    ///
    /// The estimate halves the exponent: the bits of a float, read as an integer, are nearly its logarithm (Lomont 2003). Each
    /// step leaves 3/2 of the square of the error: 1.8e-3, 4.7e-6, rounding.
    #[inline(always)]
    pub fn inverse_sqrt(self) -> Self {
        let simd = self.simd;
        let bits = simd.transmute_u32s_f32s(self.values);
        let halved = simd.wrapping_dyn_shr_u32s(bits, simd.splat_u32s(1));
        let mut y = self.with(simd.transmute_f32s_u32s(simd.sub_u32s(simd.splat_u32s(INVERSE_SQRT), halved)));
        let minus_half = self * constant(simd, -0.5);
        for _ in 0..3 {
            y = y * (minus_half * y).times_plus(y, constant(simd, 1.5));
        }
        y
    }

    /// `eˣ`, within 2e-7 of it for `x` from -87 to 88, where `f32` is normal; beyond, that of the nearer end (test
    /// `exponentials_are_within_their_stated_error`).
    ///
    /// ```text
    ///   eˣ = 2^k e^r        k = x / ln 2, rounded        r = x - k ln 2, |r| <= ½ ln 2
    /// ```
    ///
    /// `e^r` is its Taylor polynomial of degree 7, the remainder of which is below `(½ ln 2)⁸/8! = 5e-9`. `ln 2` is taken off in
    /// two parts, of which the first has so few digits that its product with `k` is exact (Cody and Waite 1980).
    #[inline(always)]
    pub fn exp(self) -> Self {
        let splat = |value| constant(self.simd, value);
        let x = self.max(splat(EXP_RANGE[0])).min(splat(EXP_RANGE[1]));
        // The sum with a number so large has no digits after the point, and k in the lowest bits.
        let shifted = x.times_plus(splat(core::f32::consts::LOG2_E), splat(SHIFT));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{LANES, Lanes, Machine};
    use pulp::WithSimd;

    #[derive(Clone, Copy)]
    enum Function {
        InverseRoot,
        Exponential,
    }

    struct Each<'a>(Function, &'a mut [Lanes]);

    impl WithSimd for Each<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for block in self.1 {
                for part in 0..Wide::<S>::PARTS {
                    let x = Wide::load(simd, block, part);
                    let value = match self.0 {
                        Function::InverseRoot => x.inverse_sqrt(),
                        Function::Exponential => x.exp(),
                    };
                    value.store(block, part);
                }
            }
        }
    }

    /// By every kind of registers that the machine has.
    fn values(function: Function, arguments: &[f32]) -> impl Iterator<Item = Vec<f32>> {
        Machine::available().map(move |machine| {
            let mut blocks: Vec<Lanes> = arguments.as_chunks::<LANES>().0.iter().copied().map(Lanes).collect();
            machine.arch().dispatch(Each(function, &mut blocks));
            blocks.iter().flat_map(|block| block.0).collect()
        })
    }

    /// The largest `|found/expected - 1|`.
    fn worst(arguments: &[f32], found: &[f32], expected: impl Fn(f64) -> f64) -> f64 {
        assert_eq!(arguments.len(), found.len(), "values");
        let error = |(x, found): (&f32, &f32)| (f64::from(*found) / expected(f64::from(*x)) - 1.0).abs();
        arguments.iter().zip(found).map(error).fold(0.0, f64::max)
    }

    #[test]
    fn inverse_roots_are_within_their_stated_error() {
        let arguments: Vec<f32> =
            (0..160_000).map(|k| 10_f64.powf(60.0 * f64::from(k) / 160_000.0 - 30.0) as f32).collect();
        for found in values(Function::InverseRoot, &arguments) {
            let worst = worst(&arguments, &found, |x| x.sqrt().recip());
            assert!(worst < 5e-7, "{worst:.2e}");
        }
    }

    #[test]
    fn exponentials_are_within_their_stated_error() {
        let arguments: Vec<f32> = (0..160_000).map(|k| (-87.0 + 175.0 * f64::from(k) / 160_000.0) as f32).collect();
        for found in values(Function::Exponential, &arguments) {
            let worst = worst(&arguments, &found, f64::exp);
            assert!(worst < 2e-7, "{worst:.2e}");
        }
        let mut ends = [0.0; LANES];
        ends[..2].copy_from_slice(&[-1e4, 1e4]);
        for found in values(Function::Exponential, &ends) {
            assert!(found[0] > 0.0 && found[0] < 1e-37 && found[1] < f32::INFINITY && found[2] == 1.0, "{found:?}");
        }
    }
}
