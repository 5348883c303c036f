//! Certified extreme values of a function on the sphere by branch and bound.

use alloc::collections::BinaryHeap;

use crate::basis::basis::Basis;
use crate::basis::index::{coefficient_count, order_of_slice};
use crate::basis::second_order::{LocalQuadratic, second_order};
use crate::extrema::Extremum;
use crate::extrema::cap_bound::{SmoothFunction, quadratic_lower_bound};
use crate::extrema::quadratic_form::{QuadraticForm, to_unit_size};
use crate::extrema::taylor::{PoleDerivatives, Taylor};
use crate::prelude::*;
use crate::scalar::Real;
use crate::sphere::Dir;
use crate::sphere::triangulation::{Triangle, triangulation};

/// The most Newton steps towards a local minimum: from a good start four suffice, leaving a saddle takes a few more.
const DESCENT_STEPS: usize = 12;

/// The narrowest interval that subdivision can reach, in rounding errors of a value.
const RESOLUTION: f64 = 16.0;

/// The bound of fourth order is tried where its remainder is below this fraction of the gap that the second order
/// leaves.
const FOURTH_ORDER_GAP: f64 = 0.05;

/// The minimum over the sphere of a function of one channel, as an interval of width `tolerance` times its root mean
/// square `√(Σ f_i²/4π)`.
///
/// `lo <= min f <= hi` is proven (the source has the derivation) but for rounding, for which the interval allows four
/// times the largest measured error (tests `rounding_errors_stay_within_their_bound` and
/// `forms_are_evaluated_within_their_bound`); and `hi - lo <= tolerance · rms` unless the tolerance is below rounding,
/// `4e-12` at order 10. 1e-6 is a good choice. Functions of up to three bands are quadratic forms and solved exactly;
/// more bands are searched by branch and bound, which ends for every function and is slowest for functions that are
/// almost constant along circles or over areas (benchmarks `minimum-f64` and `minimum-ring-f64`).
///
/// Order 0 and the zero function have the minimum 0 at +z. A coefficient that is not finite gives the interval
/// from -∞ to ∞.
///
/// See [`certified_maximum`] for the maximum.
///
/// ```
/// use lobe_sh::extrema::certified_minimum;
/// use lobe_sh::{Dir, Expansion as _, ShVec};
///
/// // The order 3 truncation of an impulse rings to a minimum of -1/(4π) · 9/5 all around its axis.
/// let f = ShVec::impulse(3, Dir::X, 1.0);
/// let min = certified_minimum(f.coefficients(), 1e-9);
/// assert!(min.lo <= f.eval(min.dir) && min.hi - min.lo < 1e-7);
/// # assert!((min.hi * 4.0 * std::f64::consts::PI + 1.8).abs() < 1e-6, "{min:?}");
/// ```
///
/// # Panics
/// If `coefficients` are not `n²`.
#[must_use]
pub fn certified_minimum<T: Real>(coefficients: &[T], tolerance: f64) -> Extremum {
    let wide: Vec<f64> = coefficients.iter().map(|c| c.to_f64()).collect();
    minimum_of(&wide, tolerance, None)
}

/// The maximum over the sphere, as an interval: `lo <= f(dir) <= max f <= hi`.
///
/// Otherwise as [`certified_minimum`].
///
/// # Panics
/// If `coefficients` are not `n²`.
#[must_use]
pub fn certified_maximum<T: Real>(coefficients: &[T], tolerance: f64) -> Extremum {
    let negative: Vec<f64> = coefficients.iter().map(|c| -c.to_f64()).collect();
    let Extremum { lo, hi, dir } = minimum_of(&negative, tolerance, None);
    Extremum { lo: -hi, hi: -lo, dir }
}

/// [`certified_minimum`]; with a `level`, the search ends as soon as the minimum is known to lie above or below it.
pub(crate) fn minimum_of(coefficients: &[f64], tolerance: f64, level: Option<f64>) -> Extremum {
    let order = order_of_slice(coefficients);
    let largest = coefficients.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    if !coefficients.iter().all(|c| c.is_finite()) {
        return Extremum::UNKNOWN;
    }
    let scale = to_unit_size(largest);
    let scaled: Vec<f64> = coefficients.iter().map(|c| c * scale).collect();
    let found = if order <= 3 {
        QuadraticForm::new(&scaled, 0).minimum([1.0, 1.0])
    } else {
        // Drop the highest bands if they are zero.
        let order = (4..=order)
            .rev()
            .find(|&n| scaled[coefficient_count(n - 1)..coefficient_count(n)].iter().any(|c| *c != 0.0))
            .unwrap_or(3);
        let scaled = &scaled[..coefficient_count(order)];
        if order <= 3 {
            QuadraticForm::new(scaled, 0).minimum([1.0, 1.0])
        } else {
            branch_and_bound(scaled, tolerance, level.map(|level| level * scale))
        }
    };
    Extremum { lo: found.lo / scale, hi: found.hi / scale, dir: found.dir }
}

/// A triangle of the sphere with a lower bound of the function on it; ordered so that the heap yields the lowest first.
#[derive(Clone, Copy, Debug)]
struct Cell {
    lower: f64,
    triangle: Triangle,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<core::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> core::cmp::Ordering {
        other.lower.total_cmp(&self.lower)
    }
}

/// The state of branch and bound.
struct Search {
    f: SmoothFunction,
    /// The width of the interval to reach.
    width: f64,
    level: Option<f64>,
    heap: BinaryHeap<Cell>,
    /// The lowest bound of all pruned cells.
    lowest_pruned: f64,
    /// The lowest value found, the incumbent, and its direction.
    hi: f64,
    dir: [f64; 3],
}

/// Branch and bound over spherical triangles, the lowest bound first.
///
/// Every triangle lies in the cap of [`Triangle`]; [`SmoothFunction::lower_bound`] bounds the function there from
/// below, with an error that falls with the third power of the radius. A cell whose bound is within the width of the
/// incumbent is pruned, all others are divided into four. The bound converges to the values in the cell, so that cells
/// below a certain size are always pruned and the search ends.
pub(crate) fn branch_and_bound(coefficients: &[f64], tolerance: f64, level: Option<f64>) -> Extremum {
    let order = order_of_slice(coefficients);
    Basis::<f64>::with_shared(order, |basis| {
        let f = SmoothFunction::new(coefficients);
        let square: f64 = coefficients.iter().map(|c| c * c).sum();
        let rms = (square / (4.0 * core::f64::consts::PI)).sqrt();
        // Both ends move by the rounding of a value besides.
        let width = (tolerance.max(0.0) * rms - 2.0 * f.rounding()).max(RESOLUTION * f.rounding());
        let mut search = Search {
            f,
            width,
            level,
            heap: BinaryHeap::new(),
            lowest_pruned: f64::INFINITY,
            hi: f64::INFINITY,
            dir: [0.0, 0.0, 1.0],
        };
        let evaluate = |directions: &[[f64; 3]; 4]| second_order(basis, coefficients, directions);
        let descend =
            |local: LocalQuadratic| newton_descent(local, order, |s| second_order(basis, coefficients, &[s])[0]);
        PoleDerivatives::with_shared(order, |table| {
            let mut work = vec![0.0; coefficients.len()];
            let expand = |s: [f64; 3]| Taylor::new(table, coefficients, s, &mut work);
            search.run(triangulation(order), evaluate, descend, expand);
        });
        let rounding = search.f.rounding();
        let hi = search.hi + rounding;
        Extremum { lo: search.lowest_pruned.min(search.hi) - rounding, hi, dir: Dir::from_unit(search.dir) }
    })
}

impl Search {
    fn run(
        &mut self,
        start: &[Triangle],
        evaluate: impl Fn(&[[f64; 3]; 4]) -> [LocalQuadratic; 4],
        descend: impl Fn(LocalQuadratic) -> LocalQuadratic,
        mut expand: impl FnMut([f64; 3]) -> Taylor,
    ) {
        // Evaluate all centers; descend from the lowest for a first incumbent, which prunes most cells at once.
        let centers: Vec<LocalQuadratic> =
            start.as_chunks::<4>().0.iter().flat_map(|four| evaluate(&four.map(|t| t.center))).collect();
        if let Some(best) = centers.iter().min_by(|a, b| a.value.total_cmp(&b.value)) {
            self.improve(descend(*best));
        }
        // Bound every cell.
        for (triangle, local) in start.iter().zip(&centers) {
            self.add(*triangle, local, &descend);
        }
        // Take the cell of the lowest bound; when that can be pruned, so can all others.
        while let Some(cell) = self.heap.pop() {
            if cell.lower >= self.pruning_bound() || self.is_below_level() {
                self.lowest_pruned = self.lowest_pruned.min(cell.lower);
                break;
            }
            // Try the bound of fourth order where it may prune.
            let Triangle { center, radius, .. } = cell.triangle;
            if self.f.remainder(radius) < FOURTH_ORDER_GAP * (self.hi - cell.lower) {
                let lower = self.f.lower_bound_of_fourth_order(&expand(center), radius);
                if lower >= self.pruning_bound() {
                    self.lowest_pruned = self.lowest_pruned.min(lower);
                    continue;
                }
            }
            // Divide the cell into four.
            let quarters = cell.triangle.quarters();
            for (triangle, local) in quarters.into_iter().zip(evaluate(&quarters.map(|t| t.center))) {
                self.add(triangle, &local, &descend);
            }
        }
    }

    /// The bound from which on a cell is pruned.
    fn pruning_bound(&self) -> f64 {
        let pruning_bound = self.hi - self.width;
        self.level.map_or(pruning_bound, |level| pruning_bound.min(level))
    }

    fn is_below_level(&self) -> bool {
        self.level.is_some_and(|level| self.hi < level)
    }

    fn improve(&mut self, local: LocalQuadratic) {
        if local.value < self.hi {
            (self.hi, self.dir) = (local.value, local.s);
        }
    }

    fn add(&mut self, triangle: Triangle, local: &LocalQuadratic, descend: impl Fn(LocalQuadratic) -> LocalQuadratic) {
        if local.value < self.hi {
            self.improve(*local);
            self.improve(descend(*local));
        }
        let lower = self.f.lower_bound(local, triangle.radius, quadratic_lower_bound);
        if lower >= self.pruning_bound() {
            self.lowest_pruned = self.lowest_pruned.min(lower);
        } else {
            self.heap.push(Cell { lower, triangle });
        }
    }
}

/// Newton's method on the sphere, safeguarded: the curvature along each principal axis enters by its absolute value,
/// steps are at most `1/n` long, and only those that lower the value are taken.
pub(crate) fn newton_descent(
    start: LocalQuadratic,
    order: usize,
    evaluate: impl Fn([f64; 3]) -> LocalQuadratic,
) -> LocalQuadratic {
    let longest = 1.0 / order as f64;
    let mut best = start;
    for _ in 0..DESCENT_STEPS {
        let (curvatures, slopes, axes) = best.principal_curvatures();
        let small = 1e-12 * (curvatures[0].abs() + curvatures[1].abs()) + f64::MIN_POSITIVE;
        let steps = [0, 1].map(|k| -slopes[k] / curvatures[k].abs().max(small));
        let length = steps[0].hypot(steps[1]);
        let shrink = if length > longest { longest / length } else { 1.0 };
        let step = [0, 1].map(|k| shrink * (steps[0] * axes[0][k] + steps[1] * axes[1][k]));
        let next = evaluate(best.step(step));
        if next.value >= best.value || next.value.is_nan() {
            break;
        }
        best = next;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::{Expansion as _, ShVec, Zonal};
    use lobe_testkit::Random;

    /// Two routes that share nothing: the quadratic form, and the search.
    #[test]
    fn the_search_finds_the_exact_minimum_of_three_bands() {
        let mut random = Random::new(21);
        for case in 0..300 {
            let f = random.signed_vec(9);
            let exact = QuadraticForm::new(&f, 0).minimum([1.0, 1.0]);
            let found = branch_and_bound(&f, 1e-8, None);
            let close = found.lo <= exact.hi && exact.lo <= found.hi && found.hi - found.lo < 1e-7;
            assert!(close, "case {case}: {found:?} against {exact:?}");
        }
    }

    #[test]
    fn a_level_ends_the_search_on_the_right_side() {
        let f = ShVec::from_vec(Random::new(22).signed_vec(36)).unwrap();
        let min = minimum_of(f.coefficients(), 1e-9, None);
        for distance in [1e-3, 1e-1, 1.0] {
            let above = minimum_of(f.coefficients(), 1e-9, Some(min.hi - distance));
            assert!(above.lo >= min.hi - distance - 1e-12, "{distance} above the level: {above:?}, {min:?}");
            let below = minimum_of(f.coefficients(), 1e-9, Some(min.hi + distance));
            assert!(below.hi < min.hi + distance, "{distance} below the level: {below:?}, {min:?}");
        }
    }

    #[test]
    fn principal_axes_diagonalize() {
        let f = Zonal::new(vec![0.1, -0.4, 0.8, 0.3]).towards(Dir::from_angles(1.0, 1.0), 1.0);
        Basis::<f64>::with_shared(4, |basis| {
            for v in lobe_testkit::directions() {
                let [local] = second_order(basis, f.coefficients(), &[v]);
                let ([low, high], _, [a, b]) = local.principal_curvatures();
                let [xx, xy, yy] = local.hessian;
                let form = |p: [f64; 2], q: [f64; 2]| p[0] * (xx * q[0] + xy * q[1]) + p[1] * (xy * q[0] + yy * q[1]);
                let errors = [form(a, a) - low, form(b, b) - high, form(a, b)].map(f64::abs);
                assert!(low <= high && errors.iter().all(|e| *e < 1e-12), "at {v:?}: {errors:?}");
            }
        });
    }
}
