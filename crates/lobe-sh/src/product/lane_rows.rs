//! One product of two expansions of order 5 to 10 in `f32`, the rows of a quadrature rule side by side.

use alloc::vec::Vec;
use core::f64::consts::PI;

use crate::basis::eval_basis;
use crate::basis::index::coefficient_index;
use crate::once::Once;
use crate::product::gaunt::GauntTensor;
use crate::simd::{Kernel, LANES, Lanes, Machine, Wide, constant};
use crate::sphere::quadrature::gauss_legendre;

/// The orders that are multiplied by rows: below straight-line code is quicker, and above the rows outnumber the lanes.
pub(crate) const ORDERS: core::ops::RangeInclusive<usize> = 5..=10;

const HIGHEST: usize = *ORDERS.end();

/// The fewest coefficients that are multiplied by rows.
pub(crate) const LEAST_COUNT: usize = ORDERS.start().pow(2);

/// What depends on the order alone.
///
/// ```text
///   f(z, φ) = Σ_m c_m e^{imφ}        c_-m = conj c_m        c_m = ½ (A_m - i B_m), m > 0        c_0 = A_0
///   A_m = Σ_l f_lm Θ_lm(z)           B_m = Σ_l f_l,-m Θ_lm(z)           Θ_lm(z) = y_lm(z, φ = 0)
///
///   h = f g:   h_m = Σ_k c_k d_{m-k}
///   h_lm = Σ_j 2π w_j Θ_lm(z_j) Re h_m(z_j)        h_l,-m = -Σ_j 2π w_j Θ_lm(z_j) Im h_m(z_j)
/// ```
///
/// over the rows `z_j` of the Gauss-Legendre rule that is exact for three functions of the order, `⌊3(n-1)/2⌋ + 1` of them,
/// each in a lane. Multiplied as series in `φ` the rows need no points: about `6n² + 2nJ` operations on all lanes, where the
/// tensor of order 8 has 9000 on single numbers. Errors are those of sums of some ten terms in `f32`.
struct Rows {
    order: usize,
    count: usize,
    /// `Θ_lm`, halved for `m > 0`, with the rows in the lanes: column after column of equal `m`.
    evaluate: Vec<Lanes>,
    /// `2π w_j Θ_lm`, with `l - m` in the lanes: for every `m` row after row.
    project: Vec<Lanes>,
}

impl Rows {
    fn of_order(order: usize) -> &'static Self {
        static ALL: [Once<Rows>; HIGHEST + 1] = [const { Once::new() }; HIGHEST + 1];
        ALL[order].get_or_init(|| Self::new(order))
    }

    fn new(order: usize) -> Self {
        let rule = gauss_legendre(3 * (order - 1) / 2 + 1);
        let theta = |z: f64| eval_basis(crate::Dir::from_unit([((1.0 - z) * (1.0 + z)).sqrt(), 0.0, z]), order);
        let thetas: Vec<Vec<f64>> = rule.iter().map(|(z, _)| theta(*z)).collect();
        let mut rows = Self { order, count: rule.len(), evaluate: Vec::new(), project: Vec::new() };
        for m in 0..order {
            let half = if m == 0 { 1.0 } else { 0.5 };
            for l in m..order {
                let mut lanes = Lanes::ZERO;
                for (lane, theta) in lanes.0.iter_mut().zip(&thetas) {
                    *lane = (half * theta[coefficient_index(l, m as isize)]) as f32;
                }
                rows.evaluate.push(lanes);
            }
            for ((_, weight), theta) in rule.iter().zip(&thetas) {
                let mut lanes = Lanes::ZERO;
                for (lane, l) in lanes.0.iter_mut().zip(m..order) {
                    *lane = (2.0 * PI * weight * theta[coefficient_index(l, m as isize)]) as f32;
                }
                rows.project.push(lanes);
            }
        }
        rows
    }
}

/// The product of two expansions of one order, to that order, if the machine has wide instructions; whether it has.
pub(crate) fn multiply_by_rows(machine: Machine, a: &[f32], b: &[f32], out: &mut [f32]) -> bool {
    let order = a.len().isqrt();
    let fits = ORDERS.contains(&order) && b.len() == a.len() && out.len() == a.len();
    if machine.is_plain() || !fits {
        return false;
    }
    machine.run(MultiplyByRows { rows: Rows::of_order(order), a, b, out });
    true
}

struct MultiplyByRows<'a> {
    rows: &'a Rows,
    a: &'a [f32],
    b: &'a [f32],
    out: &'a mut [f32],
}

/// `Re c_m` and `-Im c_m` of all rows.
type Series = [[Lanes; HIGHEST]; 2];

impl Kernel for MultiplyByRows<'_> {
    type Output = ();

    #[inline(always)]
    fn wide<S: pulp::Simd>(self, simd: S) {
        let Self { rows, a, b, out } = self;
        let zero: Series = [[Lanes::ZERO; HIGHEST]; 2];
        let (mut f, mut g, mut h) = (zero, zero, zero);
        for part in 0..Wide::<S>::PARTS {
            evaluate(simd, part, rows, a, &mut f);
            evaluate(simd, part, rows, b, &mut g);
            multiply(simd, part, rows.order, &f, &g, &mut h);
        }
        for (m, project) in rows.project.chunks_exact(rows.count).enumerate() {
            let mut sums = [Lanes::ZERO; 2];
            for part in 0..Wide::<S>::PARTS {
                let (mut cos, mut sin) = (constant(simd, 0.0), constant(simd, 0.0));
                for (j, theta) in project.iter().enumerate() {
                    let theta = Wide::load(simd, theta, part);
                    cos = theta.times_plus(constant(simd, h[0][m].0[j % LANES]), cos);
                    sin = theta.times_plus(constant(simd, h[1][m].0[j % LANES]), sin);
                }
                cos.store(&mut sums[0], part);
                sin.store(&mut sums[1], part);
            }
            for l in m..rows.order {
                // The cosine last: for m = 0 both have one place.
                out[coefficient_index(l, -(m as isize))] = sums[1].0[l - m];
                out[coefficient_index(l, m as isize)] = sums[0].0[l - m];
            }
        }
    }

    fn plain(self) {
        let order = self.rows.order;
        GauntTensor::new(order, order, order).product_into(self.a, self.b, self.out);
    }
}

/// The series of `f` in every row.
#[inline(always)]
fn evaluate<S: pulp::Simd>(simd: S, part: usize, rows: &Rows, f: &[f32], series: &mut Series) {
    let mut first = 0;
    for m in 0..rows.order {
        let (mut cos, mut sin) = (constant(simd, 0.0), constant(simd, 0.0));
        for (theta, l) in rows.evaluate[first..].iter().zip(m..rows.order) {
            let theta = Wide::load(simd, theta, part);
            cos = theta.times_plus(constant(simd, f[coefficient_index(l, m as isize)]), cos);
            sin = theta.times_plus(constant(simd, f[coefficient_index(l, -(m as isize))]), sin);
        }
        cos.store(&mut series[0][m], part);
        if m > 0 {
            sin.store(&mut series[1][m], part);
        }
        first += rows.order - m;
    }
}

/// `h_m = Σ_k c_k d_{m-k}`, with `c_k = a - i s`.
#[inline(always)]
fn multiply<S: pulp::Simd>(simd: S, part: usize, order: usize, f: &Series, g: &Series, h: &mut Series) {
    for m in 0..order {
        let (mut re, mut im) = (constant(simd, 0.0), constant(simd, 0.0));
        for k in 0..=m {
            let ([a, s], [b, t]) = (at(simd, part, f, k), at(simd, part, g, m - k));
            re = s.times_from(t, a.times_plus(b, re));
            im = a.times_plus(t, s.times_plus(b, im));
        }
        // The conjugates: c_-j d_{m+j} and c_{m+j} d_-j.
        for j in 1..order - m {
            let ([a, s], [b, t]) = (at(simd, part, f, j), at(simd, part, g, m + j));
            re = s.times_plus(t, a.times_plus(b, re));
            im = a.times_plus(t, s.times_from(b, im));
            let ([a, s], [b, t]) = (at(simd, part, f, m + j), at(simd, part, g, j));
            re = s.times_plus(t, a.times_plus(b, re));
            im = s.times_plus(b, a.times_from(t, im));
        }
        re.store(&mut h[0][m], part);
        im.store(&mut h[1][m], part);
    }
}

#[inline(always)]
fn at<S: pulp::Simd>(simd: S, part: usize, series: &Series, m: usize) -> [Wide<S>; 2] {
    [Wide::load(simd, &series[0][m], part), Wide::load(simd, &series[1][m], part)]
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::basis::index::coefficient_count;

    /// Of coefficients of size 1, whose products are up to 10.
    const ERROR: f64 = 2e-5;

    #[test]
    fn rows_multiply_as_the_tensor() {
        let mut random = lobe_testkit::Random::new(8);
        for order in ORDERS {
            let count = coefficient_count(order);
            let (a, b) = (random.signed_vec(count), random.signed_vec(count));
            let mut expected = vec![0.0; count];
            GauntTensor::new(order, order, order).product_into(&a, &b, &mut expected);
            let single = |f: &[f64]| f.iter().map(|c| *c as f32).collect::<Vec<f32>>();
            for machine in Machine::available() {
                let mut found = vec![f32::NAN; count];
                let done = multiply_by_rows(machine, &single(&a), &single(&b), &mut found);
                assert_eq!(done, !machine.is_plain(), "wide instructions alone");
                for (i, (found, expected)) in found.iter().zip(&expected).enumerate().filter(|_| done) {
                    let off = (f64::from(*found) - expected).abs();
                    assert!(off < ERROR, "{}, order {order}, {i}: {found} against {expected}", machine.name());
                }
            }
        }
    }
}
