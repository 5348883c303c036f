//! Gaunt coefficients: the integrals of three basis functions, in exact arithmetic.

use core::f64::consts::PI;

use crate::basis::index::band_and_m;
use crate::basis::index::{band_range, coefficient_count};
use crate::by_type::{by_type, of_each_type};
use crate::once::Once;
use crate::prelude::*;
use crate::scalar::{Coefficient, Real};

/// The highest order for which Lobe computes Gaunt coefficients. Products of higher orders go over a grid: its cost
/// grows with the third power of the order, that of the tensor with the fifth.
pub const MAX_GAUNT_ORDER: usize = 10;

/// The primes that divide factorials up to `(l1 + l2 + l3 + 1)!` for bands below [`MAX_GAUNT_ORDER`].
const PRIMES: [u32; 9] = [2, 3, 5, 7, 11, 13, 17, 19, 23];

/// The exact value of a Gaunt coefficient, `numerator / denominator · √(radicand / π)`.
///
/// In lowest terms and with a square-free radicand, so that equal values have equal fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct ExactGaunt {
    /// Never zero; carries the sign.
    numerator: i64,
    /// Positive.
    denominator: i64,
    /// Positive, without a square factor.
    radicand: i64,
}

impl ExactGaunt {
    /// The nearest number in `f64`, to within two units in the last place: the integers are exact, then come a
    /// quotient, a root and a product.
    fn to_f64(self) -> f64 {
        self.numerator as f64 / self.denominator as f64 * (self.radicand as f64 / PI).sqrt()
    }
}

/// One entry of a [`GauntTensor`], `Γ_ijk = value`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GauntCoefficient {
    /// Flat index of the first function.
    pub i: usize,
    /// Flat index of the second function.
    pub j: usize,
    /// Flat index of the third function.
    pub k: usize,
    /// `∫ y_i y_j y_k ds`.
    pub value: f64,
}

// With y = n_μ Θ_lμ(θ) trig(μφ), μ = |m|, n_0 = 1 and n_μ = √2, the three functions ordered so that μ3 is the
// largest, and m1 + m2 + m3 = 0 for the integral of three complex functions:
//
//   ∫ Y_l1^m1 Y_l2^m2 Y_l3^m3 ds = √((2l1+1)(2l2+1)(2l3+1) / 4π) (l1 l2 l3; 0 0 0) (l1 l2 l3; m1 m2 m3)
//
// The azimuthal part is the mean of trig(μ1 φ) trig(μ2 φ) trig(μ3 φ), which is zero unless μ3 = μ1 + μ2 and the
// number of sines is even: 1 when all μ are zero, 1/2 when one is, else 1/4, or -1/4 for sin sin cos. With the n_μ
// that makes the factor 1, 1 or ±1/√2. The Θ are those of Y_l1^μ1, Y_l2^μ2 and (-1)^μ3 Y_l3^-μ3.
//
// The 3j symbols by Racah's sum, its factorials gathered into binomials so that the sum N is an integer
// (J = l1 + l2 + l3):
//
//   (l1 l2 l3; m1 m2 m3) = (-1)^(l1-l2-m3) N √( Π (l+m)! (l-m)! / (Π (J-2l)! (J+1)!) )
//   N = Σ_t (-1)^t C(J-2l3, t) C(J-2l2, l1-m1-t) C(J-2l1, l2+m2-t)
//
// The three powers of -1 cancel, so the sign is that of both sums and of the azimuthal part.

/// [`gaunt_coefficient`] without rounding; `None` if it is zero.
///
/// Where the selection rules hold, the integer sum of the 3j symbol shows whether the coefficient vanishes by accident.
/// The test `gaunt_coefficients_equal_quadrature` bounds the error of the value in `f64` by 1e-13.
///
/// # Panics
/// If an index belongs to band [`MAX_GAUNT_ORDER`] or higher.
pub(crate) fn exact_gaunt_coefficient(i: usize, j: usize, k: usize) -> Option<ExactGaunt> {
    let limit = coefficient_count(MAX_GAUNT_ORDER);
    assert!(i < limit && j < limit && k < limit, "Gaunt coefficients reach index {}, not {i}, {j}, {k}", limit - 1);
    let mut f = [i, j, k].map(band_and_m);
    f.sort_by_key(|&(_, m)| m.unsigned_abs());
    let [(l1, m1), (l2, m2), (l3, m3)] = f;
    let mu = f.map(|(_, m)| m.unsigned_abs());
    let sines = f.iter().filter(|(_, m)| *m < 0).count();
    let sum = l1 + l2 + l3;
    if sum % 2 == 1 || l1.max(l2).max(l3) * 2 > sum || mu[2] != mu[0] + mu[1] || sines % 2 == 1 {
        return None;
    }
    let l = [l1, l2, l3];
    let racah = racah_sum(l, [mu[0], mu[1]]) * racah_sum(l, [0, 0]);
    let sign = if m1 < 0 && m2 < 0 && m3 > 0 { -1 } else { 1 };
    (racah != 0).then(|| reduce(sign * racah, l, mu))
}

/// The Gaunt coefficient of three real basis functions, `Γ_ijk = ∫ y_i y_j y_k ds`, computed exactly and rounded once.
///
/// Zero unless `l1 + l2 + l3` is even, no band is greater than the sum of the other two, the greatest `|m|` is the sum
/// of the other two and an even number of the `m` is negative; in a few further cases it vanishes by accident.
///
/// ```
/// // A product with the constant y_00 = 1/√(4π) only scales.
/// let y_00 = lobe_sh::eval_basis(lobe_sh::Dir::Z, 1)[0];
/// assert!((lobe_sh::product::gaunt_coefficient(0, 5, 5) - y_00).abs() < 1e-16);
/// assert_eq!(lobe_sh::product::gaunt_coefficient(0, 5, 6), 0.0);
/// ```
///
/// # Panics
/// If an index belongs to band [`MAX_GAUNT_ORDER`] or higher.
#[must_use]
pub fn gaunt_coefficient(i: usize, j: usize, k: usize) -> f64 {
    exact_gaunt_coefficient(i, j, k).map_or(0.0, ExactGaunt::to_f64)
}

/// The integer sum `N` for `m = (μ1, μ2, -μ1-μ2)`.
fn racah_sum([l1, l2, l3]: [usize; 3], [m1, m2]: [usize; 2]) -> i128 {
    let (a, b, c) = (l1 + l2 - l3, l1 + l3 - l2, l2 + l3 - l1);
    (0..=a.min(l1 - m1).min(l2 + m2))
        .map(|t| {
            let term = binomial(a, t) * binomial(b, l1 - m1 - t) * binomial(c, l2 + m2 - t);
            if t % 2 == 0 { term } else { -term }
        })
        .sum()
}

/// `n! / (k! (n-k)!)`, zero for `k > n`.
fn binomial(n: usize, k: usize) -> i128 {
    if k > n {
        return 0;
    }
    (0..k).fold(1, |c, t| c * (n - t) as i128 / (t as i128 + 1))
}

/// `racah · Π l! / (2 Π (J-2l)! (J+1)!) · √(c² Π (2l+1) (l+m)! (l-m)! / π)` in lowest terms, `c² = 1/2` where all
/// `μ` are positive, else 1.
fn reduce(racah: i128, l: [usize; 3], mu: [usize; 3]) -> ExactGaunt {
    let sum: usize = l.iter().sum();
    let (mut numerator, mut denominator, mut radicand) = (racah, 1, 1);
    for prime in PRIMES {
        let p = i128::from(prime);
        let mut outside = -factorial_exponent(prime, sum + 1) - i32::from(prime == 2);
        let mut inside = -i32::from(prime == 2 && mu.iter().all(|&mu| mu > 0));
        for (l, mu) in l.into_iter().zip(mu) {
            outside += factorial_exponent(prime, l) - factorial_exponent(prime, sum - 2 * l);
            inside += factorial_exponent(prime, l + mu) + factorial_exponent(prime, l - mu);
            inside += exponent(prime, 2 * l + 1);
        }
        outside += inside.div_euclid(2);
        if inside.rem_euclid(2) == 1 {
            radicand *= p;
        }
        while outside < 0 && numerator % p == 0 {
            numerator /= p;
            outside += 1;
        }
        let power = p.pow(outside.unsigned_abs());
        if outside < 0 { denominator *= power } else { numerator *= power }
    }
    let fits = |n: i128| i64::try_from(n).unwrap_or_else(|_| unreachable!("bands below {MAX_GAUNT_ORDER} fit: {n}"));
    ExactGaunt { numerator: fits(numerator), denominator: fits(denominator), radicand: fits(radicand) }
}

/// The exponent of `prime` in `n`.
fn exponent(prime: u32, mut n: usize) -> i32 {
    let mut e = 0;
    while n.is_multiple_of(prime as usize) {
        n /= prime as usize;
        e += 1;
    }
    e
}

/// The exponent of `prime` in `n!`.
fn factorial_exponent(prime: u32, n: usize) -> i32 {
    (1..=n).map(|n| exponent(prime, n)).sum()
}

/// The non-zero `Γ_ijk` with `i <= j <= k` and `k` in band `l`, computed once.
fn unique_of_band(l: usize) -> &'static [GauntCoefficient] {
    static BANDS: [Once<Vec<GauntCoefficient>>; MAX_GAUNT_ORDER] = [const { Once::new() }; MAX_GAUNT_ORDER];
    BANDS[l].get_or_init(|| {
        let mut coefficients = Vec::new();
        for k in band_range(l) {
            for j in 0..=k {
                let all = (0..=j).filter_map(|i| {
                    exact_gaunt_coefficient(i, j, k).map(|value| GauntCoefficient { i, j, k, value: value.to_f64() })
                });
                coefficients.extend(all);
            }
        }
        coefficients
    })
}

/// The non-zero `Γ_ijk` with `i <= j <= k` of an order, each of which stands for all its permutations.
///
/// # Panics
/// If `order` is above [`MAX_GAUNT_ORDER`].
fn unique_coefficients(order: usize) -> impl Iterator<Item = GauntCoefficient> {
    assert!(order <= MAX_GAUNT_ORDER, "Gaunt coefficients reach order {MAX_GAUNT_ORDER}, not {order}");
    (0..order).flat_map(unique_of_band).copied()
}

/// The Gaunt coefficients `Γ_ijk = ∫ y_i y_j y_k ds` for two factors and a product of given orders, zeros left out.
///
/// ```text
///   c_k = Σ_ij Γ_ijk a_i b_j        c = a b        i < n_a²   j < n_b²   k < n_c²
/// ```
///
/// Symmetric in its three indices. For equal orders it has 1, 10, 83, 353, 1158, 2907, 6460, 12868, 23621 and 40418
/// entries at orders 1 to 10, of which 1, 4, 25, 77, 238, 549, 1196, 2300, 4185 and 7042 are different ones; the test
/// `the_numbers_of_non_zeros_are_those_known` checks them.
#[derive(Clone, Debug)]
pub struct GauntTensor {
    orders: [usize; 3],
    coefficients: Vec<GauntCoefficient>,
    /// The pairs `(i, j)` that have entries; `i <= j` alone for equal orders.
    pairs: Vec<[u16; 2]>,
    /// Sorted by `k`: the place of the pair in `pairs`, and the value.
    terms: Vec<(u16, f64)>,
    /// For each `k` the end of its part of `terms`.
    ends: Vec<u32>,
}

impl GauntTensor {
    /// The tensor for factors of orders `order_a` and `order_b` and a product of order `order_out`.
    ///
    /// # Panics
    /// If an order is above [`MAX_GAUNT_ORDER`].
    #[must_use]
    pub fn new(order_a: usize, order_b: usize, order_out: usize) -> Self {
        let orders = [order_a, order_b, order_out];
        let inside = |t: &GauntCoefficient| {
            t.i < coefficient_count(order_a) && t.j < coefficient_count(order_b) && t.k < coefficient_count(order_out)
        };
        let mut coefficients: Vec<GauntCoefficient> =
            unique_coefficients(order_a.max(order_b).max(order_out)).flat_map(permutations).filter(inside).collect();
        coefficients.sort_by_key(|t| (t.i, t.j, t.k));
        let (mut pairs, mut of_pairs) = (Vec::new(), Vec::new());
        for pair in coefficients.chunk_by(|s, t| (s.i, s.j) == (t.i, t.j)) {
            if order_a != order_b || pair[0].i <= pair[0].j {
                of_pairs.extend(pair.iter().map(|t| (t.k, pairs.len() as u16, t.value)));
                pairs.push([pair[0].i as u16, pair[0].j as u16]);
            }
        }
        of_pairs.sort_by_key(|(k, ..)| *k);
        let terms = of_pairs.iter().map(|(_, pair, value)| (*pair, *value)).collect();
        let end = |k: usize| of_pairs.partition_point(|(of, ..)| *of <= k) as u32;
        let ends = (0..coefficient_count(order_out)).map(end).collect();
        Self { orders, coefficients, pairs, terms, ends }
    }

    /// The orders of the factors and of the product.
    #[must_use]
    pub fn orders(&self) -> [usize; 3] {
        self.orders
    }

    /// The entries, ascending in `(i, j, k)`.
    #[must_use]
    pub fn coefficients(&self) -> &[GauntCoefficient] {
        &self.coefficients
    }

    /// The product of two expansions, `out` overwritten.
    ///
    /// # Panics
    /// If a length does not fit the orders of the tensor.
    pub fn product_into<T: Coefficient>(&self, a: &[T], b: &[T], out: &mut [T]) {
        by_type!(T: a, b; mut out => product_into(self, a, b, out));
    }
}

of_each_type! {
    pub(super) fn product_into(tensor: &GauntTensor, a: &[T], b: &[T], out: &mut [T]) {
        let lengths = [a.len(), b.len(), out.len()];
        let expected = tensor.orders.map(coefficient_count);
        assert_eq!(lengths, expected, "numbers of coefficients against those of the tensor");
        let symmetric = a.len() == b.len();
        let product = |&[i, j]: &[u16; 2]| {
            let (i, j) = (usize::from(i), usize::from(j));
            if symmetric && i != j { a[i] * b[j] + a[j] * b[i] } else { a[i] * b[j] }
        };
        let products: Vec<T> = tensor.pairs.iter().map(product).collect();
        let mut start = 0;
        for (out, end) in out.iter_mut().zip(&tensor.ends) {
            // Several sums, so that none waits for the one before.
            let mut sums = [T::ZERO; SUMS];
            let (groups, rest) = tensor.terms[start..*end as usize].as_chunks::<SUMS>();
            for group in groups {
                for (sum, (pair, value)) in sums.iter_mut().zip(group) {
                    *sum += products[usize::from(*pair)].scale(<T as Coefficient>::Scalar::from_f64(*value));
                }
            }
            for (sum, (pair, value)) in sums.iter_mut().zip(rest) {
                *sum += products[usize::from(*pair)].scale(<T as Coefficient>::Scalar::from_f64(*value));
            }
            *out = (sums[0] + sums[1]) + (sums[2] + sums[3]);
            start = *end as usize;
        }
    }
}

/// Sums of one coefficient of a product that are kept side by side.
const SUMS: usize = 4;

/// The different permutations of the indices of a coefficient.
fn permutations(t: GauntCoefficient) -> impl Iterator<Item = GauntCoefficient> {
    let GauntCoefficient { i, j, k, .. } = t;
    let mut all = [[i, j, k], [i, k, j], [j, i, k], [j, k, i], [k, i, j], [k, j, i]];
    all.sort_unstable();
    let different = move |n: &usize| *n == 0 || all[*n] != all[*n - 1];
    (0..all.len()).filter(different).map(move |n| GauntCoefficient { i: all[n][0], j: all[n][1], k: all[n][2], ..t })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::basis::eval_basis_into;
    use crate::sphere::quadrature::SphereQuadrature;
    use lobe_testkit::golden_f64s;

    /// Sums of some thousand terms of size one.
    const QUADRATURE_ERROR: f64 = 1e-13;

    #[test]
    fn gaunt_coefficients_equal_quadrature() {
        let order = 7;
        let n = coefficient_count(order);
        let rule = SphereQuadrature::of_degree(3 * (order - 1));
        let mut sums = vec![0.0; n * n * n];
        let mut y = vec![0.0; n];
        for (s, weight) in rule.points() {
            eval_basis_into(s.to_array(), &mut y);
            for i in 0..n {
                for j in 0..=i {
                    let yy = weight * y[i] * y[j];
                    for k in 0..=j {
                        sums[(i * n + j) * n + k] += yy * y[k];
                    }
                }
            }
        }
        for i in 0..n {
            for j in 0..=i {
                for k in 0..=j {
                    let (sum, exact) = (sums[(i * n + j) * n + k], gaunt_coefficient(i, j, k));
                    assert!((sum - exact).abs() < QUADRATURE_ERROR, "({i}, {j}, {k}): {sum} against {exact}");
                }
            }
        }
    }

    #[test]
    fn the_highest_bands_equal_quadrature_too() {
        let rule = SphereQuadrature::of_degree(3 * (MAX_GAUNT_ORDER - 1));
        let mut random = lobe_testkit::Random::new(4);
        let points: Vec<_> = rule.points().map(|(s, weight)| (weight, crate::eval_basis(s, MAX_GAUNT_ORDER))).collect();
        let top: Vec<GauntCoefficient> = unique_of_band(MAX_GAUNT_ORDER - 1).to_vec();
        for _ in 0..200 {
            let GauntCoefficient { i, j, k, value } = top[random.next_u64() as usize % top.len()];
            let sum: f64 = points.iter().map(|(weight, y)| weight * y[i] * y[j] * y[k]).sum();
            assert!((sum - value).abs() < QUADRATURE_ERROR, "({i}, {j}, {k}): {sum} against {value}");
        }
    }

    #[test]
    fn the_numbers_of_non_zeros_are_those_known() {
        let counts = [1, 10, 83, 353, 1158, 2907, 6460, 12868, 23621, 40418];
        let unique = [1, 4, 25, 77, 238, 549, 1196, 2300, 4185, 7042];
        for n in 1..=MAX_GAUNT_ORDER {
            assert_eq!(GauntTensor::new(n, n, n).coefficients().len(), counts[n - 1], "order {n}");
            assert_eq!(unique_coefficients(n).count(), unique[n - 1], "order {n}, sorted indices");
        }
        for ([a, b, c], count) in [
            ([6, 3, 3], 162),
            ([6, 3, 6], 703),
            ([6, 6, 3], 703),
            ([3, 3, 5], 162),
            ([4, 4, 7], 708),
            ([3, 2, 3], 37),
            ([4, 3, 4], 215),
            ([2, 2, 3], 21),
        ] {
            assert_eq!(GauntTensor::new(a, b, c).coefficients().len(), count, "orders {a} x {b} -> {c}");
        }
    }

    #[test]
    fn golden_counts_agree() {
        for (key, mine) in [
            ("/triple/nonzeros", (|n| GauntTensor::new(n, n, n).coefficients().len()) as fn(usize) -> usize),
            ("/triple/unique_sorted", |n| unique_coefficients(n).count()),
        ] {
            for (order, golden) in golden_f64s("/triple/order").into_iter().zip(golden_f64s(key)) {
                let mine = mine(order as usize);
                assert_eq!(mine as f64, golden, "{key} at order {order}");
            }
        }
    }

    #[test]
    fn a_zonal_factor_about_z_fills_the_known_places() {
        for (order, count) in [(2, 6), (3, 19), (4, 44), (5, 85), (6, 146), (7, 231), (8, 344)] {
            let tensor = GauntTensor::new(order, order, order);
            let zonal = tensor.coefficients().iter().filter(|t| band_and_m(t.i).1 == 0);
            let mut places: Vec<_> = zonal.map(|t| (t.j, t.k)).collect();
            places.sort_unstable();
            places.dedup();
            assert_eq!(places.len(), count, "order {order}");
        }
    }

    #[test]
    fn exact_values_are_in_lowest_terms() {
        let y_00 = exact_gaunt_coefficient(0, 0, 0).unwrap();
        assert_eq!(y_00, ExactGaunt { numerator: 1, denominator: 2, radicand: 1 }, "1/√(4π)");
        // ∫ y_20³ ds = √(5/π)/7, by expanding (3z² - 1)³.
        let y_20 = exact_gaunt_coefficient(6, 6, 6).unwrap();
        assert_eq!(y_20, ExactGaunt { numerator: 1, denominator: 7, radicand: 5 }, "∫ y_20³");
        for t in unique_coefficients(6) {
            let e = exact_gaunt_coefficient(t.i, t.j, t.k).unwrap();
            let square = (2..9).find(|p| e.radicand % (p * p) == 0);
            assert_eq!(square, None, "radicand of {e:?}");
        }
    }
}
