//! The values of functions in blocks towards a direction for each.

use crate::basis::basis::Basis;
use crate::basis::index::coefficient_count;
#[cfg(feature = "simd")]
use crate::basis::lane_basis::{HIGHEST_ORDER, basis};
#[cfg(feature = "simd")]
use crate::basis::places::Places;
#[cfg(feature = "simd")]
use crate::simd::Wide;
use crate::simd::{Kernel, LANES, Lanes, Machine};

/// Sums side by side, so that an addition need not wait for the one before.
#[cfg(feature = "simd")]
const SUMS: usize = 4;

/// `Σ_i f_i y_i(s)` of each function towards its direction: `out` has a number for each function that there is, at most sixteen
/// for each block of directions. Functions have `order²` blocks.
pub(crate) fn eval_functions(
    machine: Machine,
    order: usize,
    functions: &[Lanes],
    directions: &[[Lanes; 3]],
    out: &mut [f32],
) {
    let count = coefficient_count(order);
    assert_eq!(functions.len(), count * directions.len(), "blocks of functions against those of directions");
    if count == 0 {
        out.fill(0.0);
    } else {
        machine.run(Values { order, functions, directions, out });
    }
}

struct Values<'a> {
    order: usize,
    functions: &'a [Lanes],
    directions: &'a [[Lanes; 3]],
    out: &'a mut [f32],
}

/// Values of the basis times part `part` of the coefficients of sixteen functions, added up as they come.
#[cfg(feature = "simd")]
struct Sums<'a, S: pulp::Simd> {
    simd: S,
    coefficients: &'a [Lanes],
    part: usize,
    sums: [Wide<S>; SUMS],
}

#[cfg(feature = "simd")]
impl<S: pulp::Simd> Places<S> for Sums<'_, S> {
    #[inline(always)]
    fn put(&mut self, i: usize, value: Wide<S>) {
        let sum = &mut self.sums[i % SUMS];
        *sum = Wide::load(self.simd, &self.coefficients[i], self.part).times_plus(value, *sum);
    }
}

impl Kernel for Values<'_> {
    type Output = ();

    #[cfg(feature = "simd")]
    #[inline(always)]
    fn wide<S: pulp::Simd>(self, simd: S) {
        if self.order > HIGHEST_ORDER {
            // The recurrence has no code for blocks in lanes.
            return self.plain();
        }
        let functions = self.functions.chunks_exact(coefficient_count(self.order));
        for ((coefficients, s), out) in functions.zip(self.directions).zip(self.out.chunks_mut(LANES)) {
            let mut values = Lanes::ZERO;
            for part in 0..Wide::<S>::PARTS {
                let s = [Wide::load(simd, &s[0], part), Wide::load(simd, &s[1], part), Wide::load(simd, &s[2], part)];
                let mut sums = Sums { simd, coefficients, part, sums: [Wide::splat(simd, 0.0); SUMS] };
                basis(simd, self.order, s, &mut sums);
                let [a, b, c, d] = sums.sums;
                ((a + b) + (c + d)).store(&mut values, part);
            }
            out.copy_from_slice(&values.0[..out.len()]);
        }
    }

    fn plain(self) {
        let functions = self.functions.chunks_exact(coefficient_count(self.order));
        Basis::<f32>::with_shared(self.order, |basis| {
            for ((coefficients, s), out) in functions.zip(self.directions).zip(self.out.chunks_mut(LANES)) {
                let mut values = [0.0; LANES];
                basis.for_each_in_block(s.map(|axis| axis.0), self.order, |i, y| {
                    for ((value, f), y) in values.iter_mut().zip(coefficients[i].0).zip(y) {
                        *value += f * y;
                    }
                });
                out.copy_from_slice(&values[..out.len()]);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use lobe_testkit::Random;

    use super::*;
    use crate::batch::dir_batch::DirBatch;
    use crate::batch::sh_batch::ShBatch;
    use crate::expansion::{Expansion as _, ShVec};
    use crate::sphere::Dir;

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
    fn every_machine_evaluates_as_the_plain_code() {
        let mut random = Random::new(6);
        let mut block = || Lanes(core::array::from_fn(|_| random.signed() as f32));
        let all = lobe_testkit::directions();
        let directions: Vec<[Lanes; 3]> = all
            .chunks_exact(LANES)
            .take(3)
            .map(|s| core::array::from_fn(|axis| Lanes(core::array::from_fn(|lane| s[lane][axis] as f32))))
            .collect();
        for order in 1..12 {
            let functions: Vec<Lanes> = (0..3 * coefficient_count(order)).map(|_| block()).collect();
            let mut expected = [f32::NAN; 2 * LANES + 5];
            eval_functions(Machine::PLAIN, order, &functions, &directions, &mut expected);
            for machine in Machine::available() {
                let mut found = [f32::NAN; 2 * LANES + 5];
                eval_functions(machine, order, &functions, &directions, &mut found);
                let near = found.iter().zip(expected).all(|(x, y)| f64::from((x - y).abs()) < ERROR);
                assert!(near, "{}, order {order}: {found:?} for {expected:?}", machine.name());
            }
        }
    }
}
