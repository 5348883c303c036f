//! Least-squares fit of an expansion to scattered samples.

use crate::basis::basis::Basis;
use crate::basis::index::coefficient_count;
use crate::expansion::ShVec;
use crate::prelude::*;
use crate::scalar::{Coefficient, Real};
use crate::solver::householder::triangular_factor;
use crate::solver::matrix::{Matrix, norm};
use crate::solver::singular_values::SingularValues;
use crate::sphere::Dir;

/// Rows gathered before they are folded into the triangular factor. More rows cost memory, fewer cost time: each
/// fold also factors the triangle again.
const ROWS_PER_FOLD: usize = 1024;

/// The condition number from which a fit counts as ill-conditioned: `1/√ε`, where half of the digits of `f64` are
/// gone.
const ILL_CONDITION: f64 = 67_108_864.0;

/// The conditioning of a [`least_squares`] problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Conditioning {
    /// The samples determine every coefficient.
    Well,
    /// They do, but errors of the samples may be amplified by more than 7e7 in the coefficients.
    Ill,
    /// They do not; of all best fits the result is the one of least norm.
    RankDeficient,
}

/// The result of [`least_squares`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LeastSquaresFit<T> {
    /// The expansion.
    pub sh: ShVec<T>,
    /// The numerical rank: the number of combinations of coefficients that the samples determine, at most `n²`.
    pub rank: usize,
    /// The condition number: the ratio of the largest singular value to the smallest one above the threshold. Infinite
    /// without samples.
    pub condition: f64,
    /// `rank` and `condition`, classified.
    pub conditioning: Conditioning,
    /// `√(Σ_k w_k (f(s_k) - v_k)² / Σ_k w_k)`, the worst channel; zero without samples, NaN if a channel is.
    pub residual: f64,
}

/// The expansion of order `n` that fits weighted samples of a function with the least squared error.
///
/// ```text
///   minimize Σ_k w_k (Σ_i f_i y_i(s_k) - v_k)²
/// ```
///
/// Unlike a projection this needs no even distribution of the directions. Each item is `(s_k, v_k, w_k)` with a
/// finite weight `w_k >= 0`; the solid angle around the sample compensates an uneven distribution. The system is
/// factored by Householder QR, blocks of rows at a time so that any number of samples needs only `O(n⁴)` memory, then
/// by singular values, all in `f64`. Singular values below `ε max(samples, n²)` times the largest count as zero.
///
/// A sample of weight zero is left out, whatever its value. A value that is not finite makes its channel NaN, in the
/// expansion and in [`LeastSquaresFit::residual`]; the other channels keep theirs.
///
/// # Panics
/// If `order` is 0, or a weight is negative or not finite.
#[must_use]
pub fn least_squares<T: Coefficient>(
    order: usize,
    samples: impl IntoIterator<Item = (Dir, T, f64)>,
) -> LeastSquaresFit<T> {
    assert!(order > 0, "a fit needs order 1 at least");
    let columns = coefficient_count(order);
    let mut triangle = TriangularFactor::new(columns, T::CHANNELS);
    let (mut count, mut total_weight) = (0, 0.0);
    let mut is_finite = vec![true; T::CHANNELS];
    for (s, value, weight) in samples {
        assert!(weight >= 0.0 && weight.is_finite(), "a weight is finite and not negative, not {weight}");
        if weight == 0.0 {
            continue;
        }
        let root = weight.sqrt();
        triangle.push(|row| {
            Basis::<f64>::with_shared(order, |basis| {
                basis.eval_into(s.to_array(), &mut row[..columns]);
            });
            for (c, place) in row[columns..].iter_mut().enumerate() {
                // What is not a number would become part of the other channels when rows are folded.
                let number = value.widen().channel(c);
                is_finite[c] &= number.is_finite();
                *place = if number.is_finite() { number } else { 0.0 };
            }
            row.iter_mut().for_each(|x| *x *= root);
        });
        count += 1;
        total_weight += weight;
    }
    let Solution { channels, rank, condition, conditioning, residual } =
        triangle.solve(count, total_weight, &is_finite);
    let coefficient = |i: usize| T::from_channels(|c| T::Scalar::from_f64(channels[c][i]));
    LeastSquaresFit { sh: ShVec::of((0..columns).map(coefficient).collect()), rank, condition, conditioning, residual }
}

/// A [`LeastSquaresFit`] channel by channel. Not generic, so that the solver is compiled in this crate alone.
struct Solution {
    channels: Vec<Vec<f64>>,
    rank: usize,
    condition: f64,
    conditioning: Conditioning,
    residual: f64,
}

/// The triangular factor `R` of the matrix `[A | b]`, one column of `b` per channel.
///
/// ```text
///   [A | b] = Q [ R_A  Qᵀb ]        min |Ax - b| is solved by R_A x = Qᵀb and leaves the residual |ρ|
///               [  0    ρ  ]
/// ```
///
/// Stacking new rows under an old `R` and factoring again gives the `R` of all rows.
struct TriangularFactor {
    columns: usize,
    channels: usize,
    factor: Matrix,
    /// Row after row, not yet folded.
    pending: Vec<f64>,
}

impl TriangularFactor {
    fn new(columns: usize, channels: usize) -> Self {
        Self { columns, channels, factor: Matrix::zeros(columns + channels, columns + channels), pending: Vec::new() }
    }

    fn width(&self) -> usize {
        self.columns + self.channels
    }

    fn push(&mut self, fill: impl FnOnce(&mut [f64])) {
        let start = self.pending.len();
        self.pending.resize(start + self.width(), 0.0);
        fill(&mut self.pending[start..]);
        if self.pending.len() >= ROWS_PER_FOLD.max(self.width()) * self.width() {
            self.fold();
        }
    }

    fn fold(&mut self) {
        let width = self.width();
        let rows = width + self.pending.len() / width;
        self.factor = triangular_factor(Matrix::from_fn(rows, width, |i, j| {
            if i < width { self.factor[(i, j)] } else { self.pending[(i - width) * width + j] }
        }));
        self.pending.clear();
    }

    fn solve(mut self, count: usize, total_weight: f64, is_finite: &[bool]) -> Solution {
        self.fold();
        let svd = SingularValues::new(Matrix::from_fn(self.columns, self.columns, |i, j| self.factor[(i, j)]));
        let largest = svd.largest();
        let threshold = f64::EPSILON * count.max(self.columns) as f64 * largest;
        let counting = || svd.values.iter().copied().filter(|s| *s > threshold);
        let rank = counting().count();
        let condition = largest / counting().fold(f64::INFINITY, f64::min);
        let mut channels = Vec::with_capacity(self.channels);
        for c in 0..self.channels {
            let solution = svd.solve(&self.factor.column(self.columns + c)[..self.columns], threshold);
            channels.push(if is_finite[c] { solution } else { vec![f64::NAN; self.columns] });
        }
        Solution {
            residual: self.residual(&channels, total_weight),
            channels,
            rank,
            condition: if rank == 0 { f64::INFINITY } else { condition },
            conditioning: match rank {
                _ if rank < self.columns => Conditioning::RankDeficient,
                _ if condition > ILL_CONDITION => Conditioning::Ill,
                _ => Conditioning::Well,
            },
        }
    }

    /// The norm of `R [x; -1]`, which is that of the residual, over the weights.
    fn residual(&self, channels: &[Vec<f64>], total_weight: f64) -> f64 {
        if total_weight == 0.0 {
            return 0.0;
        }
        let worst = channels.iter().enumerate().map(|(c, x)| {
            // Of no multiple of the other channels' columns.
            let others = core::iter::repeat_n(&0.0, self.channels).enumerate();
            let others = others.map(|(k, zero)| if k == c { &-1.0 } else { zero });
            norm(&self.factor.times(&x.iter().chain(others).copied().collect::<Vec<f64>>()))
        });
        worst.fold(0.0, |worst, r| if r > worst || r.is_nan() { r } else { worst }) / total_weight.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::eval_basis;
    use crate::expansion::Expansion as _;
    use crate::scalar::Rgb;
    use lobe_testkit::{Random, directions, fibonacci_sphere};

    fn planted(order: usize) -> ShVec<f64> {
        ShVec::from_vec(Random::new(order as u64).signed_vec(order * order)).unwrap()
    }

    fn assert_close(found: &ShVec<f64>, expected: &ShVec<f64>, tolerance: f64) {
        for (i, (a, b)) in found.coefficients().iter().zip(expected.coefficients()).enumerate() {
            assert!((a - b).abs() < tolerance, "i {i}: {a} against {b}");
        }
    }

    #[test]
    fn scattered_samples_give_back_a_planted_expansion() {
        for order in [1, 2, 4, 6, 10] {
            let f = planted(order);
            let samples = directions().into_iter().map(Dir::from_unit).enumerate();
            let fit = least_squares(order, samples.map(|(k, s)| (s, f.eval(s), 0.1 + k as f64)));
            assert_eq!((fit.rank, fit.conditioning), (order * order, Conditioning::Well), "order {order}");
            assert!(fit.residual < 1e-13, "residual {}", fit.residual);
            assert_close(&fit.sh, &f, 1e-12);
        }
    }

    #[test]
    fn folding_many_rows_equals_the_normal_equations() {
        let mut random = Random::new(11);
        let samples: Vec<(Dir, f64, f64)> = (0..5 * ROWS_PER_FOLD + 3)
            .map(|_| (Dir::from_unit(random.direction()), random.signed(), random.unit()))
            .collect();
        let mut matrix = nalgebra::DMatrix::<f64>::zeros(9, 9);
        let mut right = nalgebra::DVector::<f64>::zeros(9);
        for (s, value, weight) in &samples {
            let y = nalgebra::DVector::from_vec(eval_basis(*s, 3));
            matrix += &y * y.transpose() * *weight;
            right += y * (*weight * *value);
        }
        let expected = ShVec::from_vec(matrix.lu().solve(&right).unwrap().as_slice().to_vec()).unwrap();
        let fit = least_squares(3, samples.iter().copied());
        assert_close(&fit.sh, &expected, 1e-12);
        let weights: f64 = samples.iter().map(|s| s.2).sum();
        let squares: f64 = samples.iter().map(|(s, v, w)| w * (fit.sh.eval(*s) - v).powi(2)).sum();
        let residual = (squares / weights).sqrt();
        assert!((fit.residual - residual).abs() < 1e-12, "{} against {residual}", fit.residual);
    }

    #[test]
    fn a_hemisphere_of_samples_is_ill_conditioned_at_high_order() {
        let upper: Vec<Dir> = fibonacci_sphere(4000).into_iter().map(Dir::from_unit).filter(|s| s.z() > 0.0).collect();
        let condition = |order| least_squares(order, upper.iter().map(|s| (*s, 1.0, 1.0)));
        // The square roots of the condition numbers of the hemisphere's Gram matrix, 254 and 5875.
        for (order, expected) in [(3, 254.0_f64.sqrt()), (4, 5875.0_f64.sqrt())] {
            let found = condition(order).condition;
            assert!((found / expected - 1.0).abs() < 0.02, "order {order}: {found} against {expected}");
        }
        assert_eq!(condition(4).conditioning, Conditioning::Well, "order 4");
        assert_eq!(condition(16).conditioning, Conditioning::Ill, "order 16: {}", condition(16).condition);
    }

    #[test]
    fn too_few_samples_give_the_fit_of_least_energy() {
        let s = Dir::from_angles(1.0, 2.0);
        let fit = least_squares(3, [(s, 2.0, 1.0)]);
        assert_eq!((fit.rank, fit.conditioning), (1, Conditioning::RankDeficient), "one sample");
        // The least norm solution is the impulse scaled to the value: Σ y_i² = 9/4π.
        let scale = 2.0 / (9.0 / (4.0 * core::f64::consts::PI));
        assert_close(&fit.sh, &ShVec::impulse(3, s, scale), 1e-13);
    }

    #[test]
    fn no_samples_and_zero_weights_give_zero() {
        let none = least_squares::<f64>(2, []);
        let weightless = least_squares(2, [(Dir::X, 1.0, 0.0), (Dir::Y, 1.0, 0.0)]);
        for fit in [none, weightless] {
            assert_eq!((fit.rank, fit.conditioning), (0, Conditioning::RankDeficient), "{fit:?}");
            assert!(fit.condition == f64::INFINITY && fit.residual == 0.0, "{fit:?}");
            assert_eq!(fit.sh, ShVec::zero(2), "zero");
        }
    }

    #[test]
    fn a_value_that_is_not_a_number_spoils_its_channel_unless_it_weighs_nothing() {
        let f = planted(2);
        let bad = Dir::from_angles(0.4, -2.0);
        let fit = |weight: f64, value: f64| {
            // More rows than are folded at a time.
            let good = fibonacci_sphere(1100).into_iter().map(Dir::from_unit);
            let good = good.map(|s| (s, Rgb::new(f.eval(s), 1.0, 0.0), 1.0));
            least_squares(2, [(bad, Rgb::new(value, 1.0, 0.0), weight)].into_iter().chain(good))
        };
        for value in [f64::NAN, f64::INFINITY] {
            let spoiled = fit(0.5, value);
            assert!(spoiled.residual.is_nan() && spoiled.sh[0].r.is_nan(), "{value} became {spoiled:?}");
            let worst = spoiled.sh.coefficients().iter().skip(1).fold(0.0_f64, |worst, c| worst.max(c.g.abs()));
            assert!(worst < 1e-13, "the green channel of {value} is off by {worst}");
            assert_close(&fit(0.0, value).sh.map(|c| c.r), &f, 1e-13);
        }
    }

    #[test]
    fn colors_are_fitted_channel_by_channel() {
        let f = planted(3);
        let all = || directions().into_iter().map(Dir::from_unit);
        let fit = least_squares(3, all().map(|s| (s, Rgb::new(f.eval(s), 0.0, -f.eval(s)), 1.0)));
        assert_close(&fit.sh.map(|c| c.r), &f, 1e-12);
        assert_close(&fit.sh.map(|c| -c.b), &f, 1e-12);
        assert!(fit.sh.coefficients().iter().all(|c| c.g.abs() < 1e-14), "green");
    }
}
