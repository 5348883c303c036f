//! The exponential of many functions at once.

use lobe_sh::basis::{Basis, coefficient_count};
use lobe_sh::batch::ShBatch;
use lobe_sh::exponential::{ExpMethod, OptimalLinear};
use lobe_sh::simd::{LANES, Lanes, Machine, Wide, constant};
use pulp::{Arch, Simd, WithSimd};

use crate::accumulate::log_table::MAX_TABLE_ORDER;
use crate::error::ShadowError;

/// Halvings at most: then the norm is below the rounding of 1.
const MOST_HALVINGS: f32 = 24.0;

/// Pairs of points of the grid that go together, so that a coefficient is loaded once for all of them.
const PAIRS: usize = 4;

/// [`Exponential`](lobe_sh::exponential::Exponential) of sixteen functions at a time, in `f32`, for the methods whose steps are the same
/// for every function: [`ExpMethod::Grid`], [`ExpMethod::OptimalLinear`] and [`ExpMethod::Hybrid`].
///
/// The formulas are those documented there; squares of the hybrid method are taken on the grid, which is exact for them. The points
/// of the grid are opposite in pairs `±s`, so that even and odd bands are summed once for both: `f(±s) = f_even(s) ± f_odd(s)`.
///
/// The result is that of `f64` within 1e-5 of its norm (test `exponentials_of_blocks_are_those_of_the_scalar_path`).
#[derive(Clone, Debug)]
pub struct BatchExponential {
    order: usize,
    method: ExpMethod,
    /// The basis at one point of each of [`PAIRS`] pairs together, coefficient after coefficient.
    basis: Vec<[f32; PAIRS]>,
    weights: Vec<[f32; PAIRS]>,
    table: Option<OptimalLinear>,
    arch: Arch,
}

impl BatchExponential {
    /// Prepares a method for functions of an order from 1 to 8.
    ///
    /// # Errors
    /// [`ShadowError::Options`] for other orders, other methods, and a limit of the hybrid method that is not positive.
    pub fn new(order: usize, method: ExpMethod) -> Result<Self, ShadowError> {
        if !(1..=MAX_TABLE_ORDER).contains(&order) {
            let message = format!("expected an order from 1 to {MAX_TABLE_ORDER}, found {order}");
            return Err(ShadowError::Options(message));
        }
        let table = match method {
            ExpMethod::Grid => None,
            ExpMethod::OptimalLinear => Some(OptimalLinear::new(order)),
            ExpMethod::Hybrid { limit } if limit > 0.0 => Some(OptimalLinear::new(order)),
            other => {
                let message = format!(
                    "expected grid, optimal linear, or hybrid with a limit above 0 for many exponentials, found {other:?}"
                );
                return Err(ShadowError::Options(message));
            }
        };
        let (basis, weights) = grid(order);
        Ok(Self { order, method, basis, weights, table, arch: Machine::detect().arch() })
    }

    /// The same in other registers than the machine's largest.
    #[cfg(test)]
    pub(crate) fn with_arch(self, arch: Arch) -> Self {
        Self { arch, ..self }
    }

    /// The number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The method.
    #[must_use]
    pub fn method(&self) -> ExpMethod {
        self.method
    }

    /// Replaces functions by their exponentials. What is not finite has no defined result.
    ///
    /// # Panics
    /// If the functions have another order.
    pub fn of_batch_in_place(&self, f: &mut ShBatch) {
        assert_eq!(f.order(), self.order, "the order of the functions against that of the exponential");
        let count = coefficient_count(self.order);
        let mut room = vec![Lanes::ZERO; count];
        f.blocks_mut().chunks_exact_mut(count).for_each(|block| self.of_block_with(block, &mut room));
    }

    /// Replaces sixteen functions, `n²` blocks, with room for as many.
    pub(crate) fn of_block_with(&self, f: &mut [Lanes], result: &mut [Lanes]) {
        let mean = f[0];
        f[0] = Lanes::ZERO;
        match (&self.table, self.method) {
            (Some(table), method) => {
                let limit = if let ExpMethod::Hybrid { limit } = method { limit } else { f64::INFINITY };
                self.hybrid(f, result, table, limit as f32);
            }
            (None, _) => self.on_grid(f, result, Value::Exponential),
        }
        self.arch.dispatch(TimesExponential { factor: mean, values: result });
        f.copy_from_slice(result);
    }

    /// `Σ_points w q(f(s)) y_i(s)`.
    fn on_grid(&self, f: &[Lanes], result: &mut [Lanes], value: Value) {
        let (order, basis, weights) = (self.order, &self.basis, &self.weights);
        self.arch.dispatch(OnGrid { order, f, result, value, basis, weights });
    }

    /// `(a 1 + b f/2^p)^(2^p)`, every function with the least `p` that brings its norm to the limit. What is squared is `1 + e`, kept as `e`.
    fn hybrid(&self, f: &mut [Lanes], result: &mut [Lanes], table: &OptimalLinear, limit: f32) {
        // The coefficient of the constant 1.
        let one = (4.0 * std::f64::consts::PI).sqrt();
        let mut halvings = [0; LANES];
        for k in 0..LANES {
            let norm = f.iter().map(|c| c[k] * c[k]).sum::<f32>().sqrt();
            halvings[k] = (norm / limit).log2().ceil().clamp(0.0, MOST_HALVINGS) as i32;
            let scale = 0.5_f32.powi(halvings[k]);
            let (a_less_one, b) = table.factors(f64::from(norm * scale));
            let b = b as f32 * scale;
            f.iter_mut().for_each(|c| c[k] *= b);
            f[0][k] = (a_less_one * one) as f32;
        }
        result.copy_from_slice(f);
        for step in 0..halvings.into_iter().max().unwrap_or(0) {
            f.copy_from_slice(result);
            self.on_grid(f, result, Value::Square);
            for (result, before) in result.iter_mut().zip(f.iter()) {
                for k in 0..LANES {
                    result[k] = if step < halvings[k] { 2.0 * before[k] + result[k] } else { before[k] };
                }
            }
        }
        for constant in &mut result[0].0 {
            *constant += one as f32;
        }
    }
}

/// The basis and the weights of a grid that is exact for products of three functions of an order, at one point of each pair of
/// opposite ones, with pairs of no weight that fill it up.
fn grid(order: usize) -> (Vec<[f32; PAIRS]>, Vec<[f32; PAIRS]>) {
    let rule = ExpMethod::grid(order);
    let is_first = |s: [f64; 3]| s.iter().rev().find(|c| c.abs() > ON_A_PLANE).is_some_and(|c| *c > 0.0);
    let points: Vec<_> = rule.points().filter(|(s, _)| is_first(s.to_array())).collect();
    let (mut basis, mut weights) = (Vec::new(), Vec::new());
    let mut y = vec![0.0; coefficient_count(order)];
    for points in points.chunks(PAIRS) {
        let mut rows = vec![[0.0; PAIRS]; coefficient_count(order)];
        let mut row_weights = [0.0; PAIRS];
        for (k, (s, weight)) in points.iter().enumerate() {
            Basis::<f64>::with_shared(order, |basis| basis.eval_into(s.to_array(), &mut y));
            rows.iter_mut().zip(&y).for_each(|(row, y)| row[k] = *y as f32);
            row_weights[k] = *weight as f32;
        }
        basis.extend(rows);
        weights.push(row_weights);
    }
    (basis, weights)
}

/// Coordinates of points of a rule that are less are zero but for rounding.
const ON_A_PLANE: f64 = 1e-9;

/// What is taken of the values on the grid.
#[derive(Clone, Copy, PartialEq)]
enum Value {
    Exponential,
    Square,
}

/// To be compiled for the machine's registers: a type, because closures are not inlined there.
struct OnGrid<'a> {
    order: usize,
    f: &'a [Lanes],
    result: &'a mut [Lanes],
    value: Value,
    basis: &'a [[f32; PAIRS]],
    weights: &'a [[f32; PAIRS]],
}

impl WithSimd for OnGrid<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.result.fill(Lanes::ZERO);
        for part in 0..Wide::<S>::PARTS {
            for (rows, weights) in self.basis.chunks_exact(self.f.len()).zip(self.weights) {
                let mut even = self.summed(simd, part, 0, rows);
                let mut odd = self.summed(simd, part, 1, rows);
                for p in 0..PAIRS {
                    let weight = constant(simd, weights[p]);
                    let (at, opposite) = (self.value_of(even[p] + odd[p]), self.value_of(even[p] - odd[p]));
                    (even[p], odd[p]) = ((at + opposite) * weight, (at - opposite) * weight);
                }
                add_projected(simd, part, (self.order, 0), rows, &even, self.result);
                add_projected(simd, part, (self.order, 1), rows, &odd, self.result);
            }
        }
    }
}

impl OnGrid<'_> {
    /// `Σ f_i y_i` over every second band, from `first` on, at one point of each pair.
    #[inline(always)]
    fn summed<S: Simd>(&self, simd: S, part: usize, first: usize, rows: &[[f32; PAIRS]]) -> [Wide<S>; PAIRS] {
        let mut values = [constant(simd, 0.0); PAIRS];
        for l in (first..self.order).step_by(2) {
            let band = l * l..(l + 1) * (l + 1);
            for (f, y) in self.f[band.clone()].iter().zip(&rows[band]) {
                let f = Wide::load(simd, f, part);
                for p in 0..PAIRS {
                    values[p] = f.times_plus(constant(simd, y[p]), values[p]);
                }
            }
        }
        values
    }

    #[inline(always)]
    fn value_of<S: Simd>(&self, f: Wide<S>) -> Wide<S> {
        if self.value == Value::Square { f * f } else { f.exp() }
    }
}

/// Adds `Σ_points values y_i` for every second band, from `first` on.
#[inline(always)]
fn add_projected<S: Simd>(
    simd: S,
    part: usize,
    (order, first): (usize, usize),
    rows: &[[f32; PAIRS]],
    values: &[Wide<S>; PAIRS],
    result: &mut [Lanes],
) {
    for l in (first..order).step_by(2) {
        let band = l * l..(l + 1) * (l + 1);
        for (result, y) in result[band.clone()].iter_mut().zip(&rows[band]) {
            let mut sum = Wide::load(simd, result, part);
            for p in 0..PAIRS {
                sum = values[p].times_plus(constant(simd, y[p]), sum);
            }
            sum.store(result, part);
        }
    }
}

/// Multiplies by the exponential of a mean: `factor` holds its coefficients `√4π` times as large.
struct TimesExponential<'a> {
    factor: Lanes,
    values: &'a mut [Lanes],
}

impl WithSimd for TimesExponential<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let per_coefficient = constant(simd, (4.0 * std::f64::consts::PI).sqrt().recip() as f32);
        for part in 0..Wide::<S>::PARTS {
            let factor = (Wide::load(simd, &self.factor, part) * per_coefficient).exp();
            for values in self.values.iter_mut() {
                (Wide::load(simd, values, part) * factor).store(values, part);
            }
        }
    }
}
