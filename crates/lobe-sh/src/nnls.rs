//! Small least squares problems with inequalities.

/// A column counts as dependent on others when less than this part of it is left beside them.
const DEPENDENT: f64 = 1e-11;

/// A multiplier enters only where it lowers the residual by more than rounding.
const ENTERS: f64 = 1e-12;

/// The shortest vector `u` of `count` numbers with `g·u >= h` for every row `(g, h)`; it must exist.
///
/// Least distance programming: with the columns `(g, h)` and the target `(0, .., 0, 1)`, let `r` be the residual of the
/// least squares solution with multipliers that are not negative. Then `u = -r_k / r_last`. Source:
/// [Lawson 1974], chapter 23.
pub(crate) fn least_norm(rows: &[(Vec<f64>, f64)], count: usize) -> Vec<f64> {
    let columns: Vec<Vec<f64>> = rows.iter().map(|(g, h)| g.iter().copied().chain([*h]).collect()).collect();
    let mut target = vec![0.0; count + 1];
    target[count] = 1.0;
    let r = residual_of_nnls(&columns, &target);
    // r_last = -|r|² is negative unless the rows contradict each other.
    let last = r[count].abs().max(f64::MIN_POSITIVE);
    r[..count].iter().map(|r| r / last).collect()
}

/// `Σ z_k column_k - target` for the `z_k >= 0` that make it shortest: the active set method of Lawson and Hanson.
fn residual_of_nnls(columns: &[Vec<f64>], target: &[f64]) -> Vec<f64> {
    let norms: Vec<f64> = columns.iter().map(|c| dot(c, c).sqrt()).collect();
    let mut z = vec![0.0; columns.len()];
    let mut active: Vec<usize> = Vec::new();
    let mut refused: Vec<usize> = Vec::new();
    let mut residual: Vec<f64> = target.iter().map(|t| -t).collect();
    // Every round lowers the residual, so that no set comes twice; the cap guards against rounding.
    for _ in 0..10 * (columns.len() + target.len()) {
        let gain = |k: usize| -dot(&columns[k], &residual) / norms[k];
        let candidates = (0..columns.len()).filter(|k| norms[*k] > 0.0 && !active.contains(k) && !refused.contains(k));
        let Some(next) = candidates.max_by(|&a, &b| gain(a).total_cmp(&gain(b))).filter(|&k| gain(k) > ENTERS) else {
            break;
        };
        active.push(next);
        let Some(mut solution) = solve(columns, &active, target).filter(|s| s[active.len() - 1] > 0.0) else {
            active.pop();
            refused.push(next);
            continue;
        };
        while let Some(step) = blocking_step(&active, &z, &solution) {
            for (&k, s) in active.iter().zip(&solution) {
                z[k] += step * (s - z[k]);
            }
            // The one that blocks is zero but for rounding.
            let least = active.iter().copied().min_by(|&a, &b| z[a].total_cmp(&z[b]));
            active.retain(|&k| {
                let stays = z[k] > 0.0 && Some(k) != least;
                if !stays {
                    z[k] = 0.0;
                }
                stays
            });
            solution = solve(columns, &active, target).unwrap_or_else(|| active.iter().map(|&k| z[k]).collect());
        }
        for (&k, s) in active.iter().zip(&solution) {
            z[k] = *s;
        }
        refused.clear();
        residual = target.iter().map(|t| -t).collect();
        for &k in &active {
            residual.iter_mut().zip(&columns[k]).for_each(|(r, c)| *r += z[k] * c);
        }
    }
    residual
}

/// How far from `z` to the solution one may go before a multiplier becomes negative; `None` for all the way.
fn blocking_step(active: &[usize], z: &[f64], solution: &[f64]) -> Option<f64> {
    let blocked = active.iter().zip(solution).filter(|(_, s)| **s <= 0.0);
    blocked.map(|(&k, s)| if z[k] > *s { z[k] / (z[k] - s) } else { 0.0 }).reduce(f64::min)
}

/// The least squares solution over some columns by modified Gram-Schmidt orthogonalisation, each column twice; `None` if
/// they are dependent.
fn solve(columns: &[Vec<f64>], active: &[usize], target: &[f64]) -> Option<Vec<f64>> {
    let count = active.len();
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(count);
    let mut r = vec![vec![0.0; count]; count];
    for (j, &k) in active.iter().enumerate() {
        let mut v = columns[k].clone();
        let length = dot(&v, &v).sqrt();
        for _ in 0..2 {
            for (i, q) in basis.iter().enumerate() {
                let part = dot(q, &v);
                r[i][j] += part;
                v.iter_mut().zip(q).for_each(|(v, q)| *v -= part * q);
            }
        }
        let rest = dot(&v, &v).sqrt();
        if rest <= DEPENDENT * length || rest.is_nan() {
            return None;
        }
        r[j][j] = rest;
        v.iter_mut().for_each(|v| *v /= rest);
        basis.push(v);
    }
    let mut x: Vec<f64> = basis.iter().map(|q| dot(q, target)).collect();
    for j in (0..count).rev() {
        for k in j + 1..count {
            x[j] -= r[j][k] * x[k];
        }
        x[j] /= r[j][j];
    }
    Some(x)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    #[test]
    fn the_shortest_vector_satisfies_the_conditions_of_optimality() {
        let mut random = Random::new(1);
        for case in 0..300 {
            let count = 1 + case % 6;
            // Planes that the vector 3·(1, .., 1) satisfies.
            let rows: Vec<(Vec<f64>, f64)> = (0..2 + case % 9)
                .map(|_| {
                    let g = random.signed_vec(count);
                    let h = 3.0 * g.iter().sum::<f64>() - random.unit();
                    (g, h)
                })
                .collect();
            let u = least_norm(&rows, count);
            let mut tight = Vec::new();
            for (g, h) in &rows {
                let slack = dot(g, &u) - h;
                assert!(slack > -1e-9, "case {case}: a row is missed by {slack}");
                if slack < 1e-9 {
                    tight.push(g.clone());
                }
            }
            // u is a sum of tight rows with multipliers that are not negative.
            let rest = residual_of_nnls(&tight, &u);
            assert!(dot(&rest, &rest).sqrt() < 1e-8, "case {case}: {u:?} is no cone sum, {rest:?} is left");
        }
    }

    #[test]
    fn without_need_the_shortest_vector_is_zero() {
        assert_eq!(least_norm(&[(vec![1.0, 0.0], -1.0)], 2), [0.0, 0.0], "a slack row");
        assert_eq!(least_norm(&[], 3), [0.0; 3], "no row");
    }

    #[test]
    fn equal_rows_do_no_harm() {
        let row = (vec![1.0, 1.0], 2.0);
        let u = least_norm(&[row.clone(), row.clone(), row], 2);
        assert!(u.iter().all(|u| (u - 1.0).abs() < 1e-12), "{u:?}");
    }
}
