//! The real spherical-harmonic basis of any order.

use core::any::{Any, TypeId};

use crate::basis::index::MAX_ORDER;
use crate::basis::index::{coefficient_count, order_of_slice};
use crate::basis::recurrence::{Constants, Step};
use crate::by_type::of_each_type;
use crate::once::Once;
use crate::prelude::*;
use crate::scalar::Real;
use crate::scalar::{TypedSlice as Slice, TypedSliceMut as SliceMut};
use crate::sphere::Dir;

/// The order up to which most functions go: their constants lie close together.
const USUAL_ORDER: usize = 64;

/// The real orthonormal basis `y_i`, orders 1 to `order`, ready to be evaluated.
///
/// ```text
///   y_l^m(s) = P̄_l^m(z) C_m(x, y)         m >= 0        C_m + i S_m = (x + i y)^m
///   y_l^-m(s) = P̄_l^m(z) S_m(x, y)        m > 0
///
///   P̄_0^0 = 1/√(4π)      P̄_1^1 = -√3 P̄_0^0      P̄_m^m = -√((2m+1)/(2m)) P̄_{m-1}^{m-1}
///   P̄_l^m = a z P̄_{l-1}^m - b P̄_{l-2}^m,      a = √((4l² - 1)/(l² - m²)),      b = a_l^m / a_{l-1}^m
///
///   computed for z >= 0 as      D_l = b D_{l-1} + (g + a w) P̄_{l-1},      P̄_l = P̄_{l-1} + D_l
///                               w = z - 1,      g = a - 1 - b
///   for z < 0 by                P̄_l^m(-z) = (-1)^{l+m} P̄_l^m(z)
/// ```
///
/// `P̄` is the associated Legendre function with its normalization and the `√2` of the real basis folded in and
/// `sin^m θ` taken out; `(x + iy)^m` puts it back, so nothing divides by `sin θ` and the poles need no special
/// case. The Condon-Shortley phase is kept: `y_1 = √(3/4π) (-y, z, -x)`.
///
/// The structure is that of [Sloan 2013]; unnormalized, the recurrences are those of [Sloan 2008] A1, where
/// `C(m) = x C(m-1) - y S(m-1)` is misprinted with a plus. The step by differences `D` is Reinsch's modification of
/// three-term recurrences (Stoer and Bulirsch, Introduction to Numerical Analysis, on trigonometric sums): near the
/// poles, where neighboring `P̄` differ little, `w` is exact and the small difference is not lost in the rounding of `a
/// z` and `b`: at order 20 in `f32` the plain recurrence has errors up to 1.1e-5 there.
///
/// Errors measured by the tests `the_basis_is_orthonormal_to_order_64` (1e-12 in `f64`),
/// `the_columns_of_the_basis_are_orthonormal_to_the_highest_order` (1e-11), `high_bands_have_their_exact_values` (against
/// 400 digits) and `f32_stays_close_to_f64` (1.5e-6 at order 20).
///
/// `(x + iy)^m` is tiny where `P̄` is large. The largest `P̄` grows as `(1 + √2)^{n/2}`; the smallest `(x + iy)^m` that
/// counts is about `e^{-n/e}`, where `m = n/e` and `sin θ = 1/e`. With `2⁵⁶` moved from the first to the second, both stay
/// in range to order 256 in `f32` and 1400 in `f64` (test `the_factors_stay_in_range_at_high_orders`); beyond, values near
/// the poles become NaN.
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
/// [Sloan 2013]: https://jcgt.org/published/0002/02/06/
#[derive(Clone, Debug)]
pub struct Basis<S>(Constants<S>);

impl<S: Real> Basis<S> {
    /// The constants of the recurrence for bands `0..order`. Computed in `f64` and rounded once.
    #[must_use]
    pub fn new(order: usize) -> Self {
        Self(Constants::new(order))
    }

    /// Calls `f` with a basis of at least `order`: one of two shared by the whole process up to [`MAX_ORDER`] (48 KiB
    /// of `f64` to order 64, 768 KiB above), a new one beyond.
    pub fn with_shared<R>(order: usize, f: impl FnOnce(&Self) -> R) -> R {
        if order > MAX_ORDER {
            return f(&Self::new(order));
        }
        let shared: &dyn Any =
            if TypeId::of::<S>() == TypeId::of::<f32>() { single::shared(order) } else { double::shared(order) };
        let Some(basis) = shared.downcast_ref() else { unreachable!("numbers are f32 or f64") };
        f(basis)
    }

    /// As one of its type, for code that is compiled in this crate alone.
    pub(crate) fn typed(&self) -> TypedBasis<'_> {
        let any: &dyn Any = self;
        if let Some(basis) = any.downcast_ref::<Basis<f32>>() {
            TypedBasis::Single(basis)
        } else if let Some(basis) = any.downcast_ref::<Basis<f64>>() {
            TypedBasis::Double(basis)
        } else {
            unreachable!("numbers are f32 or f64")
        }
    }

    /// The number of bands the constants reach.
    #[must_use]
    pub fn order(&self) -> usize {
        self.0.order()
    }

    /// The constants `[a, b, g]` of the step to band `l > m` in column `m`, for code that is generated from them.
    ///
    /// # Panics
    /// If `l <= m` or `l` is no band of this basis.
    #[must_use]
    pub fn step(&self, m: usize, l: usize) -> [S; 3] {
        assert!(m < l && l < self.order(), "no step to band {l} in column {m} of a basis of order {}", self.order());
        let Step { a, b, g } = self.recurrence(m, l);
        [a, b, g]
    }

    /// `P̄_m^m`.
    ///
    /// # Panics
    /// If `m` is no band of this basis.
    #[must_use]
    pub fn diagonal(&self, m: usize) -> S {
        self.0.diagonal(m)
    }

    /// The step to band `l > m` in column `m`.
    pub(crate) fn recurrence(&self, m: usize, l: usize) -> Step<S> {
        self.0.steps(m, l + 1)[l - m - 1]
    }

    /// The constants, for kernels.
    #[cfg(feature = "simd")]
    pub(crate) fn constants(&self) -> &Constants<S> {
        &self.0
    }

    /// The values of all basis functions towards the unit vector `s`, in index order. `out` has `n²` places.
    ///
    /// # Panics
    /// If `out.len()` is no perfect square or its order is above that of the basis.
    pub fn eval_into(&self, s: [S; 3], out: &mut [S]) {
        match (self.typed(), S::typed(&s), S::typed_mut(out)) {
            (TypedBasis::Single(basis), Slice::Single(s), SliceMut::Single(out)) => single::eval_into(basis, s, out),
            (TypedBasis::Double(basis), Slice::Double(s), SliceMut::Double(out)) => double::eval_into(basis, s, out),
            _ => unreachable!("numbers of one type"),
        }
    }

    /// Calls `emit(i, y_i(s))` once for every basis function of `order`, column by column of equal `|m|`.
    #[inline(always)]
    pub(crate) fn for_each(&self, s: [S; 3], order: usize, mut emit: impl FnMut(usize, S)) {
        self.for_each_in_block(s.map(|c| [c]), order, |i, [y]| emit(i, *y));
    }

    /// [`Constants::for_each_in_block`].
    #[inline(always)]
    pub(crate) fn for_each_in_block<const W: usize>(
        &self,
        s: [[S; W]; 3],
        order: usize,
        emit: impl FnMut(usize, &[S; W]),
    ) {
        self.0.for_each_in_block(s, order, emit);
    }
}

/// A [`Basis`] of one of the two types of numbers.
#[derive(Debug)]
pub(crate) enum TypedBasis<'a> {
    Single(&'a Basis<f32>),
    Double(&'a Basis<f64>),
}

of_each_type! { numbers:
    /// The basis that the process shares, for `order` up to [`MAX_ORDER`].
    pub(super) fn shared(order: usize) -> &'static Basis<T> {
        static SHARED: [Once<Basis<T>>; 2] = [const { Once::new() }; 2];
        let (place, reach) = if order > USUAL_ORDER { (1, MAX_ORDER) } else { (0, USUAL_ORDER) };
        SHARED[place].get_or_init(|| Basis::new(reach))
    }

    pub(super) fn eval_into(basis: &Basis<T>, s: &[T], out: &mut [T]) {
        basis.for_each([s[0], s[1], s[2]], order_of_slice(out), |i, y| out[i] = y);
    }
}

/// The values of the basis functions of bands `0..order` towards `s`, in index order.
///
/// ```
/// use lobe_sh::{Dir, eval_basis};
///
/// let y = eval_basis(Dir::Z, 2);
/// assert!((y[0] - 0.282094791773878).abs() < 1e-15);
/// assert!((y[2] - 0.488602511902920).abs() < 1e-15);
/// ```
#[must_use]
pub fn eval_basis(s: Dir, order: usize) -> Vec<f64> {
    let mut out = vec![0.0; coefficient_count(order)];
    eval_basis_into(s.to_array(), &mut out);
    out
}

/// The values of the basis functions towards the unit vector `s`, for the order that `out` has room for.
///
/// Up to [`MAX_ORDER`] the constants are shared by the whole process; above, each call computes them anew: keep a
/// [`Basis`] instead.
///
/// # Panics
/// If `out.len()` is no perfect square.
pub fn eval_basis_into<S: Real>(s: [S; 3], out: &mut [S]) {
    Basis::<S>::with_shared(order_of_slice(out), |basis| basis.eval_into(s, out));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::index::{band_and_m, band_range, coefficient_index};
    use crate::expansion::zonal::zonal_norm;
    use crate::sphere::quadrature::SphereQuadrature;
    use lobe_testkit::{directions, golden_f64s};

    #[test]
    fn the_basis_has_its_golden_values() {
        let dir = golden_f64s("/basis_dir/dir");
        let y = eval_basis(Dir::new([dir[0], dir[1], dir[2]]).unwrap(), 10);
        for (i, (y, golden)) in y.iter().zip(golden_f64s("/basis_dir/order10")).enumerate() {
            assert!((y - golden).abs() < 1e-14, "y_{i}: {y} against {golden}");
        }
    }

    #[test]
    fn low_bands_are_their_polynomials() {
        let c = core::f64::consts::PI.sqrt().recip();
        for v in directions() {
            let [x, y, z] = v;
            let (c1, c2) = (0.75_f64.sqrt() * c, 0.5 * 15.0_f64.sqrt() * c);
            let expected = [
                0.5 * c,
                -c1 * y,
                c1 * z,
                -c1 * x,
                c2 * x * y,
                -c2 * y * z,
                0.25 * 5.0_f64.sqrt() * c * (3.0 * z * z - 1.0),
                -c2 * x * z,
                0.5 * c2 * (x * x - y * y),
            ];
            for (i, (a, b)) in eval_basis(Dir::from_unit(v), 3).iter().zip(expected).enumerate() {
                assert!((a - b).abs() < 1e-15, "y_{i} towards {v:?}: {a} against {b}");
            }
        }
    }

    /// All `64² × 64²` integrals `∫ y_i y_j ds`, by a rule that is exact for them.
    ///
    /// The kernel is evaluated at every point of the rule. First each value is found to be the row's value at
    /// `φ = 0` times `cos mφ` or `sin mφ`; the sum over a row of two functions of different `|m|`, or of a cosine
    /// and a sine, is then zero by the orthogonality of the discrete Fourier basis, which leaves the sums over rows
    /// of equal `m`.
    #[test]
    fn the_basis_is_orthonormal_to_order_64() {
        let order = USUAL_ORDER;
        let rule = SphereQuadrature::of_degree(2 * (order - 1));
        let mut y = vec![0.0; coefficient_count(order)];
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for (k, (s, _)) in rule.points().enumerate() {
            eval_basis_into(s.to_array(), &mut y);
            if k % rule.azimuths() == 0 {
                rows.push(y.clone());
            }
            let row = &rows[rows.len() - 1];
            let phi = 2.0 * core::f64::consts::PI * (k % rule.azimuths()) as f64 / rule.azimuths() as f64;
            for (i, y) in y.iter().enumerate() {
                let (l, m) = band_and_m(i);
                let angle = m.unsigned_abs() as f64 * phi;
                let turned = if m < 0 { angle.sin() } else { angle.cos() };
                let expected = row[coefficient_index(l, m.abs())] * turned;
                assert!((y - expected).abs() < 1e-12, "y_{i} towards {s:?}: {y} against {expected}");
            }
        }
        assert_columns_are_orthonormal(&rule, &rows, order, 1e-12);
    }

    /// The same to the highest order, without the azimuths.
    #[test]
    fn the_columns_of_the_basis_are_orthonormal_to_the_highest_order() {
        let rule = SphereQuadrature::of_degree(2 * (MAX_ORDER - 1));
        let row = |z: f64| eval_basis(Dir::from_unit([((1.0 - z) * (1.0 + z)).sqrt(), 0.0, z]), MAX_ORDER);
        let rows: Vec<Vec<f64>> = rule.rows().iter().map(|(z, _)| row(*z)).collect();
        assert_columns_are_orthonormal(&rule, &rows, MAX_ORDER, 1e-11);
    }

    /// The integrals of the products of functions of equal `m`, whose values at `φ = 0` of each row of the rule are given.
    fn assert_columns_are_orthonormal(rule: &SphereQuadrature, rows: &[Vec<f64>], order: usize, limit: f64) {
        for m in 0..order {
            let circle = if m == 0 { 2.0 } else { 1.0 } * core::f64::consts::PI;
            let column: Vec<Vec<f64>> =
                (m..order).map(|l| rows.iter().map(|row| row[coefficient_index(l, m as isize)]).collect()).collect();
            for (l, a) in column.iter().enumerate() {
                for (k, b) in column[..=l].iter().enumerate() {
                    let sum: f64 =
                        rule.rows().iter().zip(a.iter().zip(b)).map(|((_, w), (a, b))| circle * w * a * b).sum();
                    let expected = f64::from(u8::from(k == l));
                    assert!((sum - expected).abs() < limit, "m {m}, bands {} and {}: {sum}", m + l, m + k);
                }
            }
        }
    }

    #[test]
    fn squares_of_a_band_sum_to_a_constant() {
        for v in directions() {
            let y = eval_basis(Dir::from_unit(v), MAX_ORDER);
            for l in 0..MAX_ORDER {
                let sum: f64 = y[band_range(l)].iter().map(|y| y * y).sum();
                let expected = zonal_norm(l).powi(2);
                let limit = if l < USUAL_ORDER { 1e-12 } else { 1e-11 };
                assert!((sum / expected - 1.0).abs() < limit, "band {l} towards {v:?}: {sum} against {expected}");
            }
        }
    }

    /// Against the hypergeometric series at 400 digits: next to the poles, where values are below 1e-200, too.
    #[test]
    fn high_bands_have_their_exact_values() {
        for entry in golden_f64s("/high_bands").chunks_exact(4) {
            let (l, m, theta, exact) = (entry[0] as usize, entry[1] as isize, entry[2], entry[3]);
            let found = eval_basis(Dir::from_unit([theta.sin(), 0.0, theta.cos()]), MAX_ORDER)[coefficient_index(l, m)];
            let error = (found - exact).abs();
            assert!(error < 1e-11 * exact.abs(), "y_{l}^{m} at θ = {theta}: {found} against {exact}, off by {error:e}");
        }
    }

    #[test]
    fn only_zonal_functions_survive_at_the_poles() {
        for (pole, sign) in [(Dir::Z, 1.0), (-Dir::Z, -1.0_f64)] {
            for (i, y) in eval_basis(pole, MAX_ORDER).iter().enumerate() {
                let (l, m) = band_and_m(i);
                let expected = if m == 0 { sign.powi(l as i32) * zonal_norm(l) } else { 0.0 };
                let limit = if l < USUAL_ORDER { 1e-13 } else { 1e-12 };
                assert!((y - expected).abs() < limit, "y_{i} towards {pole:?}: {y} against {expected}");
            }
        }
    }

    #[test]
    fn f32_stays_close_to_f64() {
        let mut single = vec![0.0_f32; coefficient_count(20)];
        let mut double = vec![0.0_f64; coefficient_count(20)];
        let mut random = lobe_testkit::Random::new(20);
        // The error is largest near the poles: most directions lie there.
        let near_poles = (0..20_000).map(|_| {
            let [x, y, z] = random.direction();
            Dir::new([0.05 * x, 0.05 * y, z.signum()]).unwrap().to_array()
        });
        for v in directions().into_iter().chain(lobe_testkit::fibonacci_sphere(10_000)).chain(near_poles) {
            let s = v.map(|c| c as f32);
            eval_basis_into(s, &mut single);
            eval_basis_into(s.map(f64::from), &mut double);
            for (i, (a, b)) in single.iter().zip(&double).enumerate() {
                assert!((f64::from(*a) - b).abs() < 1.5e-6, "y_{i} towards {v:?}: {a} against {b}");
            }
        }
    }

    /// The worst of `|4π/(2l+1) Σ_m y_lm² - 1|` over all bands, from a pole to the equator.
    fn worst_sum_of_squares<S: Real>(order: usize) -> f64 {
        let basis = Basis::<S>::new(order);
        let mut y = vec![S::ZERO; coefficient_count(order)];
        let mut worst = 0.0_f64;
        for theta in [0.0, 1e-12, 1e-6, 1e-3, 0.03, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.57] {
            basis.eval_into(Dir::from_angles(theta, 2.0 + theta).to_array().map(S::from_f64), &mut y);
            for l in 0..order {
                let sum: f64 = y[band_range(l)].iter().map(|y| y.to_f64().powi(2)).sum();
                let error = (sum / zonal_norm(l).powi(2) - 1.0).abs();
                worst = if error > worst || error.is_nan() { error } else { worst };
            }
        }
        worst
    }

    #[test]
    fn the_factors_stay_in_range_at_high_orders() {
        let (single, double) = (worst_sum_of_squares::<f32>(MAX_ORDER), worst_sum_of_squares::<f64>(1400));
        assert!(single < 2e-3, "f32 at order {MAX_ORDER} is off by {single}");
        let double_to_max = worst_sum_of_squares::<f64>(MAX_ORDER);
        assert!(double_to_max < 1e-11, "f64 at order {MAX_ORDER} is off by {double_to_max}");
        println!("{single:e} {double_to_max:e} {double:e}");
        // Not NaN is the point; a thousand steps of the recurrence next to the pole cost some digits.
        assert!(double < 1e-9, "f64 at order 1400 is off by {double}");
    }

    #[test]
    fn every_shared_basis_has_the_same_lower_bands() {
        let s = Dir::from_angles(0.4, 2.0);
        let y = eval_basis(s, 300);
        let sum: f64 = y[band_range(299)].iter().map(|y| y * y).sum();
        assert!((sum / zonal_norm(299).powi(2) - 1.0).abs() < 1e-11, "band 299: {sum}");
        for order in [64, 65, MAX_ORDER] {
            assert_eq!(y[..order * order], eval_basis(s, order)[..], "order {order}");
        }
    }
}
