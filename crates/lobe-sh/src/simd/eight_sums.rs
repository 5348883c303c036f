//! Sums whose bits do not depend on the width of the registers.

use pulp::Simd;

/// The numbers that are summed side by side: a register of the widest machine.
const SIDE_BY_SIDE: usize = 8;

/// The most registers that hold them.
pub const MOST_PARTS: usize = SIDE_BY_SIDE / 2;

/// The passes over some numbers that together make eight sums side by side: register `k` of the numbers belongs to
/// pass `k % sum_parts::<S>()`.
///
/// AVX-512 holds eight sums in one register, AVX2 in two, NEON in four. A narrow machine passes several times, each time
/// with as many sums as a wide one, so that it needs no more registers and finds the same bits
/// (`all_machines_that_fuse_find_the_same_sums`). Plain code, which does not fuse, passes once.
///
/// ```
/// use lobe_sh::simd::sum_parts;
///
/// assert_eq!(sum_parts::<pulp::Scalar>(), 1);
/// ```
#[inline(always)]
#[must_use]
pub fn sum_parts<S: Simd>() -> usize {
    if S::F64_LANES == 1 { 1 } else { SIDE_BY_SIDE / S::F64_LANES }
}

/// The sum of all numbers in the registers of [`sum_parts`] passes: the upper half is added to the lower until one is left.
#[inline(always)]
pub fn sum_of_parts<S: Simd>(simd: S, mut parts: [S::f64s; MOST_PARTS]) -> f64 {
    let mut count = sum_parts::<S>();
    while count > 1 {
        count /= 2;
        for k in 0..count {
            parts[k] = simd.add_f64s(parts[k], parts[k + count]);
        }
    }
    simd.reduce_sum_f64s(parts[0])
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use lobe_testkit::Random;

    use super::*;
    use crate::simd::{Kernel, Machine};

    struct Sum<'a>(&'a [f64]);

    impl Kernel for Sum<'_> {
        type Output = f64;

        #[inline(always)]
        fn wide<S: Simd>(self, simd: S) -> f64 {
            let (registers, parts) = (S::as_simd_f64s(self.0).0, sum_parts::<S>());
            let mut sums = [simd.splat_f64s(0.0); MOST_PARTS];
            for (k, x) in registers.iter().enumerate() {
                sums[k % parts] = simd.mul_add_e_f64s(*x, *x, sums[k % parts]);
            }
            sum_of_parts(simd, sums)
        }

        fn plain(self) -> f64 {
            self.0.iter().map(|x| x * x).sum()
        }
    }

    #[test]
    fn all_machines_that_fuse_find_the_same_sums() {
        let mut random = Random::new(1);
        for count in [0, 8, 64, 1000] {
            let numbers: Vec<f64> = (0..count).map(|_| random.signed()).collect();
            let plain = Machine::PLAIN.run(Sum(&numbers));
            let fused: Vec<f64> =
                Machine::available().filter(|m| !m.is_plain()).map(|m| m.run(Sum(&numbers))).collect();
            assert!(fused.iter().all(|sum| sum.to_bits() == fused[0].to_bits()), "{count}: {fused:?}");
            assert!(fused.iter().all(|sum| (sum - plain).abs() <= 1e-13 * plain), "{count}: {fused:?} and {plain}");
        }
    }
}
