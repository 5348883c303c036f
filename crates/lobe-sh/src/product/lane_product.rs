//! Products of many pairs of expansions of one order, cut off at that order, sixteen side by side in `f32`.

use alloc::vec::Vec;

use crate::basis::index::coefficient_count;
#[cfg(feature = "simd")]
use crate::once::Once;
#[cfg(feature = "simd")]
use crate::product::gaunt::GauntTensor;
use crate::product::gaunt::MAX_GAUNT_ORDER;
use crate::product::generated;
#[cfg(feature = "simd")]
use crate::product::lanes;
use crate::product::product::{product_into, square_into};
use crate::simd::{Kernel, LANES, Lanes, Machine};
#[cfg(feature = "simd")]
use crate::simd::{Wide, constant};

/// The factors: blocks of two functions, of one that is squared, or of the bands of a zonal function and of another.
#[derive(Clone, Copy)]
pub(crate) enum Factors<'a> {
    Two(&'a [Lanes], &'a [Lanes]),
    One(&'a [Lanes]),
    Zonal(&'a [Lanes], &'a [Lanes]),
}

/// The product of each pair of functions in blocks, cut off at their order: as
/// [`ShBatch::product_into`](crate::batch::ShBatch::product_into), on blocks that are somewhere else and by a machine of choice.
///
/// # Panics
/// If the slices do not have the same number of blocks, a multiple of `order²`, or the order is above
/// [`MAX_GAUNT_ORDER`].
pub fn product_of_blocks(machine: Machine, order: usize, a: &[Lanes], b: &[Lanes], out: &mut [Lanes]) {
    let count = coefficient_count(order);
    assert!(a.len() == out.len() && b.len() == out.len(), "{} and {} blocks for {}", a.len(), b.len(), out.len());
    assert!(out.is_empty() || out.len().is_multiple_of(count), "{} blocks of order {order}", out.len());
    multiply_blocks(machine, order, Factors::Two(a, b), out);
}

/// The product of each pair: `order²` blocks for each sixteen functions.
///
/// ```text
///   (f g)_k = Σ_{i<=j} (f_i g_j + f_j g_i) Γ_ijk        f_i g_i once for i = j
/// ```
///
/// The code of orders 2 to 6 is that of [`product_into`] with products and sums in one operation; higher orders read the
/// Gaunt coefficients from a list, each for all lanes.
pub(crate) fn multiply_blocks(machine: Machine, order: usize, factors: Factors<'_>, out: &mut [Lanes]) {
    assert!(order <= MAX_GAUNT_ORDER, "products of batches reach order {MAX_GAUNT_ORDER}, not {order}");
    if order > 0 {
        machine.run(Multiply { order, factors, out });
    }
}

struct Multiply<'a> {
    order: usize,
    factors: Factors<'a>,
    out: &'a mut [Lanes],
}

impl Kernel for Multiply<'_> {
    type Output = ();

    #[cfg(feature = "simd")]
    #[inline(always)]
    fn wide<S: pulp::Simd>(self, simd: S) {
        let Self { order, factors, out } = self;
        macro_rules! each {
            ($order:literal, $count:literal, $general:ident, $square:ident, $zonal:ident) => {{
                let out = out.as_chunks_mut::<$count>().0;
                match factors {
                    Factors::Two(a, b) => {
                        let pairs = a.as_chunks::<$count>().0.iter().zip(b.as_chunks::<$count>().0);
                        for ((a, b), out) in pairs.zip(out) {
                            for part in 0..Wide::<S>::PARTS {
                                lanes::$general::product(simd, part, a, b, out);
                            }
                        }
                    }
                    Factors::One(a) => {
                        for (a, out) in a.as_chunks::<$count>().0.iter().zip(out) {
                            for part in 0..Wide::<S>::PARTS {
                                lanes::$square::product(simd, part, a, out);
                            }
                        }
                    }
                    Factors::Zonal(z, f) => {
                        let pairs = z.as_chunks::<$order>().0.iter().zip(f.as_chunks::<$count>().0);
                        for ((z, f), out) in pairs.zip(out) {
                            for part in 0..Wide::<S>::PARTS {
                                lanes::$zonal::product(simd, part, z, f, out);
                            }
                        }
                    }
                }
            }};
        }
        match order {
            2 => each!(2, 4, general_2, square_2, zonal_2),
            3 => each!(3, 9, general_3, square_3, zonal_3),
            4 => each!(4, 16, general_4, square_4, zonal_4),
            5 => each!(5, 25, general_5, square_5, zonal_5),
            6 => each!(6, 36, general_6, square_6, zonal_6),
            _ => {
                let count = coefficient_count(order);
                let whole;
                let (a, b) = match factors {
                    Factors::Two(a, b) => (a, b),
                    Factors::One(a) => (a, a),
                    Factors::Zonal(z, f) => {
                        whole = expanded(order, z);
                        (&*whole, f)
                    }
                };
                let terms = Terms::of_order(order);
                let pairs = a.chunks_exact(count).zip(b.chunks_exact(count));
                for ((a, b), out) in pairs.zip(out.chunks_exact_mut(count)) {
                    for part in 0..Wide::<S>::PARTS {
                        by_tensor(simd, part, terms, a, b, out);
                    }
                }
            }
        }
    }

    fn plain(self) {
        let Self { order, factors, out } = self;
        let count = coefficient_count(order);
        let mut single = [(); 3].map(|()| vec![0.0; count]);
        let [of_a, of_b, of_out] = &mut single;
        let take = |to: &mut [f32], from: &[Lanes], lane: usize| {
            to.iter_mut().zip(from).for_each(|(to, from)| *to = from.0[lane]);
        };
        for (group, out) in out.chunks_exact_mut(count).enumerate() {
            let part = group * count..(group + 1) * count;
            for lane in 0..LANES {
                match factors {
                    Factors::Two(a, b) => {
                        take(of_a, &a[part.clone()], lane);
                        take(of_b, &b[part.clone()], lane);
                        product_into(of_a, of_b, of_out);
                    }
                    Factors::One(a) => {
                        take(of_a, &a[part.clone()], lane);
                        square_into(of_a, of_out);
                    }
                    Factors::Zonal(z, f) => {
                        let bands = &z[group * order..][..order];
                        take(&mut of_a[..order], bands, lane);
                        take(of_b, &f[part.clone()], lane);
                        if !generated::zonal(&of_a[..order], of_b, of_out) {
                            take(of_a, &expanded(order, bands), lane);
                            product_into(of_a, of_b, of_out);
                        }
                    }
                }
                out.iter_mut().zip(&*of_out).for_each(|(out, value)| out.0[lane] = *value);
            }
        }
    }
}

/// The blocks of zonal functions as of any function: zero but for `m = 0`.
fn expanded(order: usize, zonal: &[Lanes]) -> Vec<Lanes> {
    let count = coefficient_count(order);
    let mut out = vec![Lanes::ZERO; zonal.len() / order * count];
    for (bands, out) in zonal.chunks_exact(order).zip(out.chunks_exact_mut(count)) {
        for (l, band) in bands.iter().enumerate() {
            out[l * (l + 1)] = *band;
        }
    }
    out
}

/// The Gaunt coefficients of one order as a list, pair after pair.
#[cfg(feature = "simd")]
struct Terms {
    pairs: Vec<Pair>,
    terms: Vec<Term>,
}

#[cfg(feature = "simd")]
struct Pair {
    i: u8,
    j: u8,
    /// The end of its terms.
    end: u16,
}

#[cfg(feature = "simd")]
struct Term {
    value: f32,
    k: u8,
}

#[cfg(feature = "simd")]
impl Terms {
    /// Those of an order, made once.
    fn of_order(order: usize) -> &'static Self {
        static ALL: [Once<Terms>; MAX_GAUNT_ORDER + 1] = [const { Once::new() }; MAX_GAUNT_ORDER + 1];
        ALL[order].get_or_init(|| {
            let tensor = GauntTensor::new(order, order, order);
            let mut made = Self { pairs: Vec::new(), terms: Vec::new() };
            let pairs = tensor.coefficients().chunk_by(|s, t| (s.i, s.j) == (t.i, t.j));
            for pair in pairs.filter(|pair| pair[0].i <= pair[0].j) {
                made.terms.extend(pair.iter().map(|t| Term { value: t.value as f32, k: t.k as u8 }));
                let (i, j, end) = (pair[0].i as u8, pair[0].j as u8, made.terms.len() as u16);
                made.pairs.push(Pair { i, j, end });
            }
            made
        })
    }
}

#[cfg(feature = "simd")]
#[inline(always)]
fn at<S: pulp::Simd>(simd: S, part: usize, blocks: &[Lanes], i: u8) -> Wide<S> {
    Wide::load(simd, &blocks[usize::from(i)], part)
}

#[cfg(feature = "simd")]
#[inline(always)]
fn by_tensor<S: pulp::Simd>(simd: S, part: usize, terms: &Terms, a: &[Lanes], b: &[Lanes], out: &mut [Lanes]) {
    for out in &mut *out {
        constant(simd, 0.0).store(out, part);
    }
    let mut start = 0;
    for &Pair { i, j, end } in &terms.pairs {
        let mut both = at(simd, part, a, i) * at(simd, part, b, j);
        if i != j {
            both = at(simd, part, a, j).times_plus(at(simd, part, b, i), both);
        }
        for term in &terms.terms[start..usize::from(end)] {
            let sum = both.times_plus(constant(simd, term.value), at(simd, part, out, term.k));
            sum.store(&mut out[usize::from(term.k)], part);
        }
        start = usize::from(end);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    /// Of coefficients of size 1: sums of up to a thousand terms, rounded in another order.
    const ERROR: f32 = 2e-5;

    #[test]
    fn zonal_functions_multiply_as_their_expansions() {
        let mut random = Random::new(4);
        for order in 1..=MAX_GAUNT_ORDER {
            let mut blocks = |count: usize| -> Vec<Lanes> {
                (0..count).map(|_| Lanes(core::array::from_fn(|_| random.signed() as f32))).collect()
            };
            let (zonal, f) = (blocks(2 * order), blocks(2 * coefficient_count(order)));
            for machine in Machine::available() {
                let [mut found, mut expected] = [(); 2].map(|()| vec![Lanes::ZERO; f.len()]);
                multiply_blocks(machine, order, Factors::Zonal(&zonal, &f), &mut found);
                multiply_blocks(machine, order, Factors::Two(&expanded(order, &zonal), &f), &mut expected);
                for (found, expected) in found.iter().zip(&expected) {
                    let near = found.0.iter().zip(expected.0).all(|(x, y)| (x - y).abs() < ERROR);
                    assert!(near, "{}, order {order}: {found:?} for {expected:?}", machine.name());
                }
            }
        }
    }

    #[test]
    fn every_machine_multiplies_as_one_pair_at_a_time() {
        let mut random = Random::new(3);
        for order in 0..=MAX_GAUNT_ORDER {
            let count = coefficient_count(order);
            let mut blocks = || -> Vec<Lanes> {
                (0..2 * count).map(|_| Lanes(core::array::from_fn(|_| random.signed() as f32))).collect()
            };
            let (a, b) = (blocks(), blocks());
            let zonal = &a[..2 * order];
            for (what, factors) in [
                ("product", Factors::Two(&a, &b)),
                ("square", Factors::One(&a)),
                ("zonal product", Factors::Zonal(zonal, &b)),
            ] {
                let mut expected = vec![Lanes::ZERO; 2 * count];
                multiply_blocks(Machine::PLAIN, order, factors, &mut expected);
                for machine in Machine::available() {
                    let mut found = vec![Lanes([f32::NAN; LANES]); 2 * count];
                    multiply_blocks(machine, order, factors, &mut found);
                    for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                        for (lane, (x, y)) in found.0.iter().zip(expected.0).enumerate() {
                            let what = (machine.name(), order, what);
                            assert!((x - y).abs() < ERROR, "{what:?}, block {i}, lane {lane}: {x} against {y}");
                        }
                    }
                }
            }
        }
    }
}
