//! Least squares in few unknowns, none of them negative.

use nalgebra::{DMatrix, DVector};

/// A problem `min |A x - b|²` as the active set method sees it.
pub(crate) trait LeastSquares {
    /// The number of unknowns.
    fn count(&self) -> usize;

    /// For every unknown how fast the residual falls when it grows from `x`: `Aᵀ(b - A x)`, each in a scale of its own.
    fn gains(&self, x: &[f64]) -> Vec<f64>;

    /// The gain below which an unknown at zero stays there, a few rounding errors.
    fn enough(&self) -> f64;

    /// The solution in the unknowns `within` alone; `None` if the problem refuses them, because the last one depends on
    /// the others.
    fn solve(&self, within: &[usize]) -> Option<Vec<f64>>;
}

/// The solution of least residual with `x >= 0`.
///
/// The active set method: unknowns at zero are let in one by one where the gain is largest, and leave again when the
/// solution of those within would make them negative, at the point of the way where the first one reaches zero. Source:
/// [Lawson 1974], chapter 23.
pub(crate) fn nnls(problem: &impl LeastSquares) -> Vec<f64> {
    let mut x = vec![0.0; problem.count()];
    let mut within: Vec<usize> = Vec::new();
    let mut refused: Vec<usize> = Vec::new();
    // Every round lowers the residual, so that no set comes twice; the limit guards against rounding.
    for _ in 0..10 * (x.len() + 1) {
        let gains = problem.gains(&x);
        let outside = (0..x.len()).filter(|k| !within.contains(k) && !refused.contains(k));
        let best = outside.max_by(|&a, &b| gains[a].total_cmp(&gains[b]));
        let Some(next) = best.filter(|&k| gains[k] > problem.enough()) else { break };
        within.push(next);
        // By rounding alone the one let in may come out negative.
        let Some(mut solution) = problem.solve(&within).filter(|s| s[within.len() - 1] > 0.0) else {
            within.pop();
            refused.push(next);
            continue;
        };
        while let Some(way) = blocking_way(&within, &x, &solution) {
            go(&mut x, &within, &solution, way);
            // The one that blocks is zero but for rounding.
            let least = within.iter().copied().min_by(|&a, &b| x[a].total_cmp(&x[b]));
            within.retain(|&k| {
                let stays = x[k] > 0.0 && Some(k) != least;
                if !stays {
                    x[k] = 0.0;
                }
                stays
            });
            solution = problem.solve(&within).unwrap_or_else(|| within.iter().map(|&k| x[k]).collect());
        }
        go(&mut x, &within, &solution, 1.0);
        refused.clear();
    }
    x
}

/// Moves `x` that part of the way to the solution.
fn go(x: &mut [f64], within: &[usize], solution: &[f64], way: f64) {
    for (&k, s) in within.iter().zip(solution) {
        x[k] = if way == 1.0 { *s } else { x[k] + way * (s - x[k]) };
    }
}

/// What part of the way to the solution one may go before an unknown becomes negative; `None` for all of it.
fn blocking_way(within: &[usize], x: &[f64], solution: &[f64]) -> Option<f64> {
    let blocked = within.iter().zip(solution).filter(|(_, s)| **s <= 0.0);
    blocked.map(|(&k, s)| if x[k] > *s { x[k] / (x[k] - s) } else { 0.0 }).reduce(f64::min)
}

/// A problem known by `AᵀA` and `Aᵀb`. Unknowns that mean the same, such as two lights in one direction, share what
/// they stand for.
pub(crate) struct Normal<'a> {
    pub(crate) gram: &'a DMatrix<f64>,
    pub(crate) right: &'a DVector<f64>,
}

impl LeastSquares for Normal<'_> {
    fn count(&self) -> usize {
        self.right.len()
    }

    fn gains(&self, x: &[f64]) -> Vec<f64> {
        (self.right - self.gram * DVector::from_column_slice(x)).as_slice().to_vec()
    }

    fn enough(&self) -> f64 {
        /// In parts of the right-hand side.
        const ENOUGH: f64 = 1e-13;

        ENOUGH * self.right.amax()
    }

    fn solve(&self, within: &[usize]) -> Option<Vec<f64>> {
        let gram = DMatrix::from_fn(within.len(), within.len(), |i, j| self.gram[(within[i], within[j])]);
        let right = DVector::from_fn(within.len(), |i, _| self.right[within[i]]);
        Some(least_squares_solution(&gram, &right).as_slice().to_vec())
    }
}

/// The minimum of `xᵀGx - 2bᵀx`, of least norm where it is not unique.
pub(crate) fn least_squares_solution(gram: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    /// Above this ratio of the smallest to the largest pivot the system is solved directly: it costs no more than four
    /// digits.
    const WELL_CONDITIONED: f64 = 1e-4;
    /// A singular value below this part of the largest is zero.
    const RANK: f64 = 1e-13;

    if gram.nrows() == 0 {
        return DVector::zeros(0);
    }
    if let Some(cholesky) = gram.clone().cholesky() {
        let diagonal = cholesky.l_dirty().diagonal();
        if diagonal.min().powi(2) > WELL_CONDITIONED * diagonal.max().powi(2) {
            return cholesky.solve(right);
        }
    }
    let svd = gram.clone().svd(true, true);
    let threshold = RANK * svd.singular_values.max();
    svd.solve(right, threshold).unwrap_or_else(|_| DVector::zeros(gram.nrows()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    #[test]
    fn the_solution_is_the_best_of_all_subsets() {
        let mut random = Random::new(4);
        for count in 1..=6 {
            for _ in 0..40 {
                let a = DMatrix::from_fn(count + 2, count, |_, _| random.signed());
                let gram = a.transpose() * &a;
                let right = a.transpose() * DVector::from_fn(count + 2, |_, _| random.signed());
                let problem = Normal { gram: &gram, right: &right };
                let cost = |x: &[f64]| {
                    let x = DVector::from_column_slice(x);
                    (x.transpose() * &gram * &x)[0] - 2.0 * right.dot(&x)
                };
                let x = nnls(&problem);
                assert!(x.iter().all(|x| *x >= 0.0), "{x:?}");
                for subset in 0..1_usize << count {
                    let within: Vec<usize> = (0..count).filter(|k| subset >> k & 1 == 1).collect();
                    let mut other = vec![0.0; count];
                    go(&mut other, &within, &problem.solve(&within).unwrap(), 1.0);
                    let allowed = other.iter().all(|x| *x >= 0.0);
                    assert!(!allowed || cost(&x) <= cost(&other) + 1e-12, "{x:?} is worse than {other:?}");
                }
            }
        }
    }

    #[test]
    fn equal_columns_share_and_nothing_is_nothing() {
        let (gram, right) = (DMatrix::from_element(2, 2, 1.0), DVector::from_element(2, 1.0));
        let x = least_squares_solution(&gram, &right);
        assert!((x[0] - 0.5).abs() < 1e-14 && (x[1] - 0.5).abs() < 1e-14, "{x}");
        let (gram, right) = (DMatrix::zeros(0, 0), DVector::zeros(0));
        assert!(nnls(&Normal { gram: &gram, right: &right }).is_empty(), "no unknowns");
    }
}
