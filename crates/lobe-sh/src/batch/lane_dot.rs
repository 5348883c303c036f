//! Sums of products of the coefficients of functions in blocks.

use crate::basis::index::coefficient_count;
#[cfg(feature = "std")]
use crate::simd::Wide;
use crate::simd::{Kernel, LANES, Lanes, Machine};

/// `Σ_i a_i b_i` of each pair of functions: `out` has a number for each function that there is, at most sixteen for `order²` blocks.
pub(crate) fn dot_blocks(machine: Machine, order: usize, a: &[Lanes], b: &[Lanes], out: &mut [f32]) {
    assert_eq!(a.len(), b.len(), "blocks of two batches");
    if order > 0 {
        machine.run(Dot { count: coefficient_count(order), a, b, out });
    }
}

struct Dot<'a> {
    count: usize,
    a: &'a [Lanes],
    b: &'a [Lanes],
    out: &'a mut [f32],
}

impl Kernel for Dot<'_> {
    type Output = ();

    #[cfg(feature = "std")]
    #[inline(always)]
    fn wide<S: pulp::Simd>(self, simd: S) {
        let pairs = self.a.chunks_exact(self.count).zip(self.b.chunks_exact(self.count));
        for ((a, b), out) in pairs.zip(self.out.chunks_mut(LANES)) {
            let mut sums = Lanes::ZERO;
            for part in 0..Wide::<S>::PARTS {
                let mut sum = Wide::load(simd, &sums, part);
                for (a, b) in a.iter().zip(b) {
                    sum = Wide::load(simd, a, part).times_plus(Wide::load(simd, b, part), sum);
                }
                sum.store(&mut sums, part);
            }
            out.copy_from_slice(&sums.0[..out.len()]);
        }
    }

    fn plain(self) {
        let pairs = self.a.chunks_exact(self.count).zip(self.b.chunks_exact(self.count));
        for ((a, b), out) in pairs.zip(self.out.chunks_mut(LANES)) {
            for (lane, out) in out.iter_mut().enumerate() {
                *out = a.iter().zip(b).map(|(a, b)| a.0[lane] * b.0[lane]).sum();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use lobe_testkit::Random;

    use super::*;
    use crate::{Dir, DirBatch, Expansion as _, ShBatch, ShVec};

    /// Of coefficients of size 1 and up to 144 values of the basis, rounded in another order.
    const ERROR: f64 = 2e-5;

    #[test]
    fn functions_of_a_batch_have_the_values_of_single_ones() {
        let directions: Vec<Dir> = lobe_testkit::directions().into_iter().filter_map(Dir::new).collect();
        let mut random = Random::new(5);
        for order in [0, 1, 2, 3, 6, 10, 12] {
            let coefficients = |random: &mut Random| (0..order * order).map(|_| random.signed() as f32).collect();
            let functions: Vec<ShVec<f32>> =
                directions.iter().filter_map(|_| ShVec::from_vec(coefficients(&mut random))).collect();
            let mut values = vec![f32::NAN; directions.len()];
            ShBatch::from_functions(&functions).eval_into(&directions.iter().copied().collect(), &mut values);
            for ((f, s), found) in functions.iter().zip(&directions).zip(values) {
                let expected: f64 = f.eval(*s).into();
                assert!(
                    (f64::from(found) - expected).abs() < ERROR,
                    "order {order} towards {s:?}: {found}, {expected}"
                );
            }
        }
        ShBatch::zero(3, 0).eval_into(&DirBatch::default(), &mut []);
    }

    #[test]
    fn every_machine_sums_as_the_plain_code() {
        let mut random = Random::new(6);
        for order in 1..9 {
            let count = coefficient_count(order);
            let mut blocks = || -> Vec<Lanes> {
                (0..3 * count).map(|_| Lanes(core::array::from_fn(|_| random.signed() as f32))).collect()
            };
            let (a, b) = (blocks(), blocks());
            let mut expected = [0.0; 2 * LANES + 5];
            dot_blocks(Machine::PLAIN, order, &a, &b, &mut expected);
            for machine in Machine::available() {
                let mut found = [f32::NAN; 2 * LANES + 5];
                dot_blocks(machine, order, &a, &b, &mut found);
                let near = found.iter().zip(expected).all(|(x, y)| f64::from((x - y).abs()) < ERROR);
                assert!(near, "{}, order {order}: {found:?} for {expected:?}", machine.name());
            }
        }
    }
}
