//! Products of expansions of several receivers side by side.

use std::sync::OnceLock;

use lobe_sh::GauntTensor;
use pulp::Simd;

use crate::accumulate::lanes::{BLOCK, Block, Lanes};

/// Coefficients of the highest order.
pub(crate) const MAX_LEN: usize = 64;

/// An expansion of each of sixteen receivers, of which the first `order²` blocks are in use: so long that no index is checked.
pub(crate) type Expansions = [Block; MAX_LEN];

/// Those that are 0.
pub(crate) const ZERO: Expansions = [[0.0; BLOCK]; MAX_LEN];

/// The product of two expansions of one order, cut off at that order.
///
/// ```text
///   (f g)_k = Σ_{i<=j} (f_i g_j + f_j g_i) G_ijk            G_ijk = ∫ y_i y_j y_k ds;   f_i g_i once for i = j
/// ```
///
/// The non-zero coefficients are read from a list. The straight-line code of [`lobe_sh::product_into`] has about half the
/// operations, but is compiled for registers of 128 bits and without products and sums in one.
#[derive(Clone, Debug)]
pub(crate) struct LaneProduct {
    pairs: Vec<Pair>,
    terms: Vec<Term>,
}

#[derive(Clone, Copy, Debug)]
struct Pair {
    i: u8,
    j: u8,
    /// The end of its terms.
    end: u32,
}

#[derive(Clone, Copy, Debug)]
struct Term {
    value: f32,
    k: u8,
}

impl LaneProduct {
    /// That of an order from 1 to 8, made once.
    pub(crate) fn of_order(order: usize) -> &'static Self {
        static ALL: [OnceLock<LaneProduct>; 9] = [const { OnceLock::new() }; 9];
        ALL[order].get_or_init(|| Self::new(order))
    }

    fn new(order: usize) -> Self {
        let tensor = GauntTensor::new(order, order, order);
        let (mut pairs, mut terms) = (Vec::new(), Vec::new());
        for pair in
            tensor.coefficients().chunk_by(|s, t| (s.i, s.j) == (t.i, t.j)).filter(|pair| pair[0].i <= pair[0].j)
        {
            terms.extend(pair.iter().map(|t| Term { value: t.value as f32, k: t.k as u8 }));
            pairs.push(Pair { i: pair[0].i as u8, j: pair[0].j as u8, end: terms.len() as u32 });
        }
        Self { pairs, terms }
    }

    /// Takes `f g` off `out`, in one part of the lanes.
    #[inline(always)]
    pub(crate) fn subtract<S: Simd>(&self, simd: S, part: usize, f: &Expansions, g: &Expansions, out: &mut Expansions) {
        let mut start = 0;
        for pair in &self.pairs {
            let (fi, gi) = (at(simd, part, f, pair.i), at(simd, part, g, pair.i));
            let both = if pair.i == pair.j {
                fi * gi
            } else {
                fi.times_plus(at(simd, part, g, pair.j), at(simd, part, f, pair.j) * gi)
            };
            let end = pair.end as usize;
            for term in self.terms.get(start..end).unwrap_or_default() {
                let sum = both.times_plus(Lanes::splat(simd, -term.value), at(simd, part, out, term.k));
                sum.store(&mut out[usize::from(term.k) % MAX_LEN], part);
            }
            start = end;
        }
    }
}

#[inline(always)]
fn at<S: Simd>(simd: S, part: usize, of: &Expansions, i: u8) -> Lanes<S> {
    Lanes::load(simd, &of[usize::from(i) % MAX_LEN], part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_sh::product_into;
    use lobe_testkit::Random;
    use pulp::{Arch, WithSimd};

    struct Subtract<'a>(&'a LaneProduct, &'a Expansions, &'a Expansions, &'a mut Expansions);

    impl WithSimd for Subtract<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            (0..Lanes::<S>::PARTS).for_each(|part| self.0.subtract(simd, part, self.1, self.2, self.3));
        }
    }

    #[test]
    fn every_lane_of_a_product_is_the_product_of_the_lanes() {
        let mut random = Random::new(1);
        for order in 1..=8 {
            let (n, product) = (order * order, LaneProduct::new(order));
            let mut lanes = || {
                let mut all = ZERO;
                all[..n].as_flattened_mut().fill_with(|| random.signed() as f32);
                all
            };
            let (f, g) = (lanes(), lanes());
            for arch in [Arch::new(), Arch::Scalar] {
                let mut found = ZERO;
                arch.dispatch(Subtract(&product, &f, &g, &mut found));
                for k in 0..BLOCK {
                    let of = |x: &Expansions| x[..n].iter().map(|x| x[k]).collect::<Vec<f32>>();
                    let mut expected = vec![0.0; n];
                    product_into(&of(&f), &of(&g), &mut expected);
                    for (i, (found, expected)) in of(&found).iter().zip(&expected).enumerate() {
                        let off = (found + expected).abs();
                        assert!(off < 1e-5, "order {order}, lane {k}, {i}: {found} taken off, {expected} expected");
                    }
                }
            }
        }
    }
}
