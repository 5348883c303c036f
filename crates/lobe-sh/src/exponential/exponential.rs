//! The exponential of a function on the sphere, by five methods.

use core::str::FromStr;

use crate::basis::basis::Basis;
use crate::basis::index::coefficient_count;
use crate::error::ShError;
use crate::expansion::{Expansion, ShVec};
use crate::exponential::optimal_linear::{OptimalLinear, exponential_by_eigenvectors, isolate_mean};
use crate::prelude::*;
use crate::product::product::{product_into, square_into};
use crate::sphere::quadrature::SphereQuadrature;

/// The limit of `hybrid` in text that names none: at 1 it is nearest to the truth among those of the example `exponential_errors`.
const HYBRID_LIMIT: f64 = 1.0;

/// The most terms of a series of products in text; `e^x` to rounding needs fewer for any sum of logarithms that leaves light.
const MOST_TERMS: usize = 100;

/// Methods of [`Exponential`]. All isolate the mean, `exp(f) = exp(f_0/√4π) exp(f̂)` with `f̂_0 = 0`, which is exact.
///
/// In text a method is `grid`, `optimal-linear`, `hybrid` (of limit 1), `hybrid:LIMIT`, `series:TERMS` or `eigen`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum ExpMethod {
    /// By the eigenvectors of the product matrix of `f̂`, `1 + R (e^D - 1)/D Rᵀ f̂`: what an endless series of
    /// truncated products comes to. The reference: `n⁶` operations.
    Eigen,
    /// The first terms of that series, `Σ f̂^k/k!` for `k` up to this.
    ProductSeries(usize),
    /// `a 1 + b f̂`, where `a` and `b` depend on `‖f̂‖` and are best for one sphere.
    OptimalLinear,
    /// Halves `f̂` until its norm is at most `limit`, takes the optimal linear exponential, and squares as often: the
    /// HYB of [Ren et al. 2006]. The smaller the limit, the nearer to [`Eigen`](Self::Eigen).
    ///
    /// [Ren et al. 2006]: https://doi.org/10.1145/1141911.1141982
    Hybrid {
        /// The largest norm that is not halved.
        limit: f64,
    },
    /// The values of `f̂` on a grid that is exact for products of three factors of its order, each raised, and projected.
    /// No table and no truncated product; linear in the points of the grid.
    Grid,
}

impl Default for ExpMethod {
    /// [`Grid`](Self::Grid).
    ///
    /// Against what 16 random spheres of 5° to 25° leave visible, its mean error at orders 3 to 6 is 0.061 to 0.071, that of
    /// [`Eigen`](Self::Eigen) 0.062 to 0.071, of [`Hybrid`](Self::Hybrid) with limit 1 0.070 to 0.116, of
    /// [`OptimalLinear`](Self::OptimalLinear) 0.074 to 0.219 (test
    /// `the_grid_is_nearer_to_the_truth_than_the_optimal_linear_and_the_hybrid_methods`); and what it costs does not depend
    /// on the function. One more sphere may brighten its mean by up to 4e-3 of what it was, in one of a hundred cases at orders 5 and 6; so it may
    /// with [`Eigen`](Self::Eigen) (test `an_occluder_more_never_brightens_the_mean_beyond_its_ringing`). Two remedies were measured and are not offered.
    /// Cutting the sum off at zero on the grid darkens, to errors of 0.083 to 0.113, and one sphere more still brightens at times. Logarithms of
    /// single spheres that are nowhere above zero, by [`ShVec::deringed`](crate::ShVec::deringed), never let it, as all weights of the grid are positive, but have errors
    /// of 0.19 to 0.26 (test `logarithms_that_are_nowhere_above_zero_never_brighten_the_mean_and_are_less_exact`; table in the README of `lobe-shadow`).
    ///
    /// That is so of spheres seen small. The logarithm of a large one rings high above zero: of two of 40° to 80°, orders 3 to 6, the root mean square
    /// error is 0.047 to 0.027, by [`Eigen`](Self::Eigen) 0.026 to 0.017 (test
    /// `of_large_occluders_eigenvectors_are_the_nearer_ones_as_stated`), and one behind another brightens the mean by 6 to 30 % (test
    /// `large_occluders_behind_one_another_brighten_the_mean_by_what_is_stated`).
    fn default() -> Self {
        Self::Grid
    }
}

impl ExpMethod {
    /// The points of [`Grid`](Self::Grid) for an order: a rule of odd degree, `3 (n - 1)` or one more, so that its points are
    /// opposite in pairs.
    #[must_use]
    pub fn grid(order: usize) -> SphereQuadrature {
        SphereQuadrature::of_degree((3 * order.saturating_sub(1)) | 1)
    }

    /// Whether it is fast enough for one function of every receiver.
    #[must_use]
    pub fn is_fast(self) -> bool {
        matches!(self, Self::Grid | Self::OptimalLinear | Self::Hybrid { .. })
    }

    fn parse(text: &str) -> Result<Self, &'static str> {
        let (name, number) = text.split_once(':').map_or((text, None), |(name, number)| (name, Some(number)));
        match (name, number) {
            ("grid", None) => Ok(Self::Grid),
            ("optimal-linear", None) => Ok(Self::OptimalLinear),
            ("eigen", None) => Ok(Self::Eigen),
            ("hybrid", None) => Ok(Self::Hybrid { limit: HYBRID_LIMIT }),
            ("hybrid", Some(limit)) => match limit.parse::<f64>() {
                Ok(limit) if limit > 0.0 && limit.is_finite() => Ok(Self::Hybrid { limit }),
                _ => Err("expected a norm above 0"),
            },
            ("series", Some(terms)) => match terms.parse() {
                Ok(terms) if (1..=MOST_TERMS).contains(&terms) => Ok(Self::ProductSeries(terms)),
                _ => Err("expected a number of terms from 1 to 100"),
            },
            _ => Err("expected grid, optimal-linear, hybrid[:NORM], series:P or eigen"),
        }
    }
}

impl FromStr for ExpMethod {
    type Err = ShError;

    fn from_str(text: &str) -> Result<Self, ShError> {
        Self::parse(text)
            .map_err(|expected| ShError::Options(alloc::format!("exponential: {expected}, found '{text}'")))
    }
}

/// The exponential of functions of one order, by one method, with what that method prepares.
///
/// ```
/// use lobe_sh::exponential::{ExpMethod, Exponential, LOG_CLAMP};
/// use lobe_sh::{Dir, Expansion as _, ShVec, Zonal};
///
/// // Two spheres in the sky: their logarithms add up, and the exponential is what both leave of it.
/// let sphere = Zonal::sphere_logarithm(4, 0.4, LOG_CLAMP);
/// let both = &sphere.towards(Dir::Z, 1.0) + &sphere.towards(Dir::X, 1.0);
/// let visibility = Exponential::new(4, ExpMethod::default()).of(&both);
/// assert!(visibility.mean() < 1.0 && visibility.mean() > 0.9, "{}", visibility.mean());
/// ```
#[derive(Clone, Debug)]
pub struct Exponential {
    order: usize,
    method: Prepared,
}

#[derive(Clone, Debug)]
enum Prepared {
    Eigen,
    ProductSeries(usize),
    OptimalLinear(OptimalLinear, f64),
    Grid {
        /// The basis at each point, one after the other.
        basis: Vec<f64>,
        weights: Vec<f64>,
    },
}

impl Exponential {
    /// Prepares a method for functions of an order; [`ExpMethod::OptimalLinear`] and [`ExpMethod::Hybrid`] compute their
    /// table here.
    ///
    /// # Panics
    /// If the limit of [`ExpMethod::Hybrid`] is not positive.
    #[must_use]
    pub fn new(order: usize, method: ExpMethod) -> Self {
        let method = match method {
            ExpMethod::Eigen => Prepared::Eigen,
            ExpMethod::ProductSeries(terms) => Prepared::ProductSeries(terms),
            ExpMethod::OptimalLinear => Prepared::OptimalLinear(OptimalLinear::new(order), f64::INFINITY),
            ExpMethod::Hybrid { limit } => {
                assert!(limit > 0.0, "the limit of the hybrid method is positive, it is not {limit}");
                Prepared::OptimalLinear(OptimalLinear::new(order), limit)
            }
            ExpMethod::Grid => {
                let rule = ExpMethod::grid(order);
                let mut basis = vec![0.0; rule.len() * coefficient_count(order)];
                Basis::<f64>::with_shared(order, |evaluate| {
                    for ((s, _), row) in rule.points().zip(basis.chunks_exact_mut(coefficient_count(order).max(1))) {
                        evaluate.eval_into(s.to_array(), row);
                    }
                });
                Prepared::Grid { basis, weights: rule.points().map(|(_, weight)| weight).collect() }
            }
        };
        Self { order, method }
    }

    /// The method.
    #[must_use]
    pub fn method(&self) -> ExpMethod {
        match &self.method {
            Prepared::Eigen => ExpMethod::Eigen,
            Prepared::ProductSeries(terms) => ExpMethod::ProductSeries(*terms),
            Prepared::OptimalLinear(_, limit) if limit.is_infinite() => ExpMethod::OptimalLinear,
            Prepared::OptimalLinear(_, limit) => ExpMethod::Hybrid { limit: *limit },
            Prepared::Grid { .. } => ExpMethod::Grid,
        }
    }

    /// The order of functions and of their exponentials.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// `exp(f)`.
    ///
    /// # Panics
    /// If `f` has another order.
    #[must_use]
    pub fn of(&self, f: &impl Expansion<f64>) -> ShVec<f64> {
        assert_eq!(f.order(), self.order, "the order of the function against that of the exponential");
        if self.order == 0 {
            return ShVec::zero(0);
        }
        let mut f_hat = ShVec::zero(self.order);
        f_hat.coefficients_mut().copy_from_slice(f.coefficients());
        let mean = isolate_mean(f_hat.coefficients_mut());
        let mut result = match &self.method {
            Prepared::Eigen => exponential_by_eigenvectors(&f_hat),
            Prepared::ProductSeries(terms) => product_series(&f_hat, *terms),
            Prepared::OptimalLinear(table, limit) => hybrid(&f_hat, table, *limit),
            Prepared::Grid { basis, weights } => on_grid(&f_hat, basis, weights),
        };
        result *= mean.exp();
        result
    }
}

/// `Σ f^k/k!`, by truncated products.
fn product_series(f: &ShVec<f64>, terms: usize) -> ShVec<f64> {
    let mut sum = ShVec::constant(f.order(), 1.0);
    let (mut term, mut next) = (sum.clone(), ShVec::zero(f.order()));
    for k in 1..=terms {
        product_into(term.coefficients(), f.coefficients(), next.coefficients_mut());
        core::mem::swap(&mut term, &mut next);
        term *= 1.0 / k as f64;
        sum += &term;
        if term.coefficients().iter().all(|c| *c == 0.0 || !c.is_finite()) {
            break;
        }
    }
    sum
}

/// Halvings at most: then the norm is below the rounding of 1, and only its first order is left.
const MOST_HALVINGS: f64 = 64.0;

/// `(a 1 + b f/2^p)^(2^p)` with the least `p` that brings `‖f‖/2^p` to the limit.
///
/// What is squared is `1 + e`, kept as `e`, which becomes `2e + e²`: next to 1 its digits would be lost, and every squaring doubles what is
/// lost.
fn hybrid(f: &ShVec<f64>, table: &OptimalLinear, limit: f64) -> ShVec<f64> {
    let norm = f.dot(f).sqrt();
    let halvings = (norm / limit).log2().ceil().clamp(0.0, MOST_HALVINGS) as i32;
    let scale = 0.5_f64.powi(halvings);
    let (a_less_one, b) = table.factors(norm * scale);
    let mut e = f.clone();
    e *= b * scale;
    e += &ShVec::constant(f.order(), a_less_one);
    let mut squared = ShVec::zero(f.order());
    for _ in 0..halvings {
        square_into(e.coefficients(), squared.coefficients_mut());
        e *= 2.0;
        e += &squared;
    }
    e += &ShVec::constant(f.order(), 1.0);
    e
}

/// `Σ_points w e^f(s) y_i(s)`.
fn on_grid(f: &ShVec<f64>, basis: &[f64], weights: &[f64]) -> ShVec<f64> {
    let mut result = ShVec::zero(f.order());
    for (y, weight) in basis.chunks_exact(f.coefficients().len().max(1)).zip(weights) {
        let value: f64 = y.iter().zip(f.coefficients()).map(|(y, f)| y * f).sum();
        let value = weight * value.exp();
        for (out, y) in result.coefficients_mut().iter_mut().zip(y) {
            *out += value * y;
        }
    }
    result
}
