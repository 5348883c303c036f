//! NNLS: least squares in few unknowns, none of them negative.

use crate::prelude::*;
use crate::solver::cholesky::Cholesky;
use crate::solver::matrix::{Matrix, largest};
use crate::solver::singular_values::SingularValues;

/// A problem `min |A x - b|²`, `x >= 0`, as the active-set method needs it.
pub(crate) trait NnlsProblem {
    /// The number of unknowns.
    fn count(&self) -> usize;

    /// The negative gradient `Aᵀ(b - A x)` at `x`; every component may have its own positive scale.
    fn negative_gradient(&self, x: &[f64]) -> Vec<f64>;

    /// The component of the negative gradient up to which an unknown stays at zero: a few rounding errors.
    fn tolerance(&self) -> f64;

    /// The least-squares solution in the unknowns `passive` alone, all others zero; `None` if the column of the last
    /// one depends on those of the others.
    fn solve(&self, passive: &[usize]) -> Option<Vec<f64>>;
}

/// The solution of least residual with `x >= 0` (Lawson and Hanson's algorithm NNLS).
///
/// The active-set method: unknowns leave zero one by one, the one of the largest gradient first, and return to zero
/// when the solution in the passive set, that of the free unknowns, would make them negative. Source: [Lawson 1974],
/// chapter 23.
pub(crate) fn nnls(problem: &dyn NnlsProblem) -> Vec<f64> {
    let mut x = vec![0.0; problem.count()];
    let mut passive: Vec<usize> = Vec::new();
    let mut rejected: Vec<usize> = Vec::new();
    // Every round lowers the residual, so that no passive set comes twice; the limit guards against rounding.
    for _ in 0..10 * (x.len() + 1) {
        // Free the unknown at zero that has the largest gradient.
        let negative_gradient = problem.negative_gradient(&x);
        let outside = (0..x.len()).filter(|k| !passive.contains(k) && !rejected.contains(k));
        let best = outside.max_by(|&a, &b| negative_gradient[a].total_cmp(&negative_gradient[b]));
        let Some(next) = best.filter(|&k| negative_gradient[k] > problem.tolerance()) else { break };
        passive.push(next);
        // Solve in the passive set; reject an unknown that rounding alone makes negative.
        let Some(mut solution) = problem.solve(&passive).filter(|s| s[passive.len() - 1] > 0.0) else {
            passive.pop();
            rejected.push(next);
            continue;
        };
        // While the solution has a negative component, move as far towards it as possible and fix that one at
        // zero.
        while let Some(fraction) = step_to_boundary(&passive, &x, &solution) {
            step_towards(&mut x, &passive, &solution, fraction);
            // The component that stops the step is zero but for rounding.
            let least = passive.iter().copied().min_by(|&a, &b| x[a].total_cmp(&x[b]));
            passive.retain(|&k| {
                let stays = x[k] > 0.0 && Some(k) != least;
                if !stays {
                    x[k] = 0.0;
                }
                stays
            });
            solution = problem.solve(&passive).unwrap_or_else(|| passive.iter().map(|&k| x[k]).collect());
        }
        step_towards(&mut x, &passive, &solution, 1.0);
        rejected.clear();
    }
    x
}

/// Moves `x` towards the solution by a fraction of the difference.
fn step_towards(x: &mut [f64], passive: &[usize], solution: &[f64], fraction: f64) {
    for (&k, s) in passive.iter().zip(solution) {
        x[k] = if fraction == 1.0 { *s } else { x[k] + fraction * (s - x[k]) };
    }
}

/// The fraction of the step to the solution at which the first unknown becomes zero; `None` if none does.
fn step_to_boundary(passive: &[usize], x: &[f64], solution: &[f64]) -> Option<f64> {
    let blocked = passive.iter().zip(solution).filter(|(_, s)| **s <= 0.0);
    blocked.map(|(&k, s)| if x[k] > *s { x[k] / (x[k] - s) } else { 0.0 }).reduce(f64::min)
}

/// A problem given by its normal equations, `AᵀA` and `Aᵀb`. Equal columns, such as two lights in one direction, get
/// equal solutions.
pub(crate) struct NormalEquations<'a> {
    pub(crate) gram: &'a Matrix,
    pub(crate) right: &'a [f64],
}

impl NnlsProblem for NormalEquations<'_> {
    fn count(&self) -> usize {
        self.right.len()
    }

    fn negative_gradient(&self, x: &[f64]) -> Vec<f64> {
        self.right.iter().zip(self.gram.times(x)).map(|(right, part)| right - part).collect()
    }

    fn tolerance(&self) -> f64 {
        /// As a fraction of the right-hand side.
        const TOLERANCE: f64 = 1e-13;

        TOLERANCE * largest(self.right)
    }

    fn solve(&self, passive: &[usize]) -> Option<Vec<f64>> {
        let gram = Matrix::from_fn(passive.len(), passive.len(), |i, j| self.gram[(passive[i], passive[j])]);
        let right: Vec<f64> = passive.iter().map(|k| self.right[*k]).collect();
        Some(least_squares_solution(&gram, &right))
    }
}

/// The minimum of `xᵀGx - 2bᵀx`, of least norm where it is not unique.
pub(crate) fn least_squares_solution(gram: &Matrix, right: &[f64]) -> Vec<f64> {
    /// Above this ratio of the smallest to the largest pivot the system is solved by Cholesky factorization, which
    /// loses no more than four digits.
    const WELL_CONDITIONED: f64 = 1e-4;
    /// A singular value below this fraction of the largest counts as zero.
    const RANK: f64 = 1e-13;

    if let Some(cholesky) = Cholesky::new(gram.clone()).filter(|c| c.pivot_ratio() > WELL_CONDITIONED) {
        return cholesky.solve(right);
    }
    let svd = SingularValues::new(gram.clone());
    svd.solve(right, RANK * svd.largest())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::matrix::dot;
    use lobe_testkit::Random;

    #[test]
    fn the_solution_is_the_best_of_all_subsets() {
        let mut random = Random::new(4);
        for count in 1..=6 {
            for _ in 0..40 {
                let columns: Vec<Vec<f64>> = (0..count).map(|_| random.signed_vec(count + 2)).collect();
                let target = random.signed_vec(count + 2);
                let gram = Matrix::from_fn(count, count, |i, j| dot(&columns[i], &columns[j]));
                let right: Vec<f64> = columns.iter().map(|column| dot(column, &target)).collect();
                let problem = NormalEquations { gram: &gram, right: &right };
                let cost = |x: &[f64]| dot(x, &gram.times(x)) - 2.0 * dot(&right, x);
                let x = nnls(&problem);
                assert!(x.iter().all(|x| *x >= 0.0), "{x:?}");
                for subset in 0..1_usize << count {
                    let passive: Vec<usize> = (0..count).filter(|k| subset >> k & 1 == 1).collect();
                    let mut other = vec![0.0; count];
                    step_towards(&mut other, &passive, &problem.solve(&passive).unwrap(), 1.0);
                    let allowed = other.iter().all(|x| *x >= 0.0);
                    assert!(!allowed || cost(&x) <= cost(&other) + 1e-12, "{x:?} is worse than {other:?}");
                }
            }
        }
    }

    #[test]
    fn equal_columns_share_and_nothing_is_nothing() {
        let x = least_squares_solution(&Matrix::from_fn(2, 2, |_, _| 1.0), &[1.0; 2]);
        assert!((x[0] - 0.5).abs() < 1e-14 && (x[1] - 0.5).abs() < 1e-14, "{x:?}");
        let gram = Matrix::zeros(0, 0);
        assert!(nnls(&NormalEquations { gram: &gram, right: &[] }).is_empty(), "no unknowns");
    }
}
