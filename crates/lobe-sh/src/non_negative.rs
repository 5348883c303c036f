//! Least squares in few unknowns, none of them negative.

use nalgebra::{DMatrix, DVector};

/// A singular value below this part of the largest is zero: unknowns that mean the same, such as two lights in one
/// direction, then share what they stand for.
const RANK: f64 = 1e-13;

/// Above this ratio of the smallest to the largest pivot the system is solved directly: it costs no more than four digits.
const WELL_CONDITIONED: f64 = 1e-4;

/// A gradient below this part of the right-hand side does not call an unknown back.
const GRADIENT: f64 = 1e-13;

/// The minimum of `xᵀGx - 2bᵀx`, of least norm where it is not unique.
pub(crate) fn least_squares_solution(gram: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
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

/// The minimum of `xᵀGx - 2bᵀx` over `x >= 0`.
///
/// An active set: unknowns at zero are let in one by one where the gradient asks for it, and leave again when the solution
/// of those within would make them negative, at the point of the way where the first one reaches zero (Lawson and
/// Hanson, Solving Least Squares Problems, 1974, chapter 23).
pub(crate) fn non_negative_solution(gram: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let count = right.len();
    let mut x = DVector::zeros(count);
    let mut within = vec![false; count];
    let enough = GRADIENT * right.amax();
    // Every round lowers the minimum, so no set returns; the limit is for rounding.
    for _ in 0..3 * count + 3 {
        let gradient = right - gram * &x;
        let best = (0..count).filter(|k| !within[*k]).max_by(|a, b| gradient[*a].total_cmp(&gradient[*b]));
        let Some(best) = best.filter(|k| gradient[*k] > enough) else { break };
        within[best] = true;
        loop {
            let solution = solve_within(gram, right, &within);
            let negative: Vec<usize> = (0..count).filter(|k| within[*k] && solution[*k] <= 0.0).collect();
            if negative.is_empty() {
                x = solution;
                break;
            }
            // How far each may go before it is negative.
            let part = |k: &usize| if x[*k] > 0.0 { x[*k] / (x[*k] - solution[*k]) } else { 0.0 };
            let way = negative.iter().map(part).fold(1.0, f64::min);
            let leaving: Vec<usize> = negative.iter().copied().filter(|k| part(k) <= way).collect();
            x += (&solution - &x) * way;
            for k in leaving {
                within[k] = false;
                x[k] = 0.0;
            }
        }
    }
    x
}

/// The solution in the unknowns that are `within`, the others zero.
fn solve_within(gram: &DMatrix<f64>, right: &DVector<f64>, within: &[bool]) -> DVector<f64> {
    let chosen: Vec<usize> = (0..within.len()).filter(|k| within[*k]).collect();
    let part = DMatrix::from_fn(chosen.len(), chosen.len(), |i, j| gram[(chosen[i], chosen[j])]);
    let solution = least_squares_solution(&part, &DVector::from_fn(chosen.len(), |i, _| right[chosen[i]]));
    let mut x = DVector::zeros(within.len());
    for (value, k) in solution.iter().zip(chosen) {
        x[k] = *value;
    }
    x
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
                let cost = |x: &DVector<f64>| (x.transpose() * &gram * x)[0] - 2.0 * right.dot(x);
                let x = non_negative_solution(&gram, &right);
                assert!(x.iter().all(|x| *x >= 0.0), "{x}");
                for subset in 0..1_usize << count {
                    let within: Vec<bool> = (0..count).map(|k| subset >> k & 1 == 1).collect();
                    let other = solve_within(&gram, &right, &within);
                    let allowed = other.iter().all(|x| *x >= 0.0);
                    assert!(!allowed || cost(&x) <= cost(&other) + 1e-12, "{x} is worse than {other}");
                }
            }
        }
    }

    #[test]
    fn equal_columns_share_and_nothing_is_nothing() {
        let gram = DMatrix::from_element(2, 2, 1.0);
        let x = least_squares_solution(&gram, &DVector::from_element(2, 1.0));
        assert!((x[0] - 0.5).abs() < 1e-14 && (x[1] - 0.5).abs() < 1e-14, "{x}");
        let none = non_negative_solution(&DMatrix::zeros(0, 0), &DVector::zeros(0));
        assert_eq!(none.len(), 0, "no unknowns");
    }
}
