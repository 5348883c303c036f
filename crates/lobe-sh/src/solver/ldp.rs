//! LDP, least distance programming: the shortest vector in an intersection of half spaces.

use crate::prelude::*;
use crate::solver::nnls::{NnlsProblem, nnls};
use crate::sphere::vector::dot_slices as dot;

/// The shortest vector `u` of `count` components with `g·u >= h` for every row `(g, h)`; one must exist.
///
/// Lawson and Hanson's algorithm LDP: let `r` be the residual of the NNLS problem with the columns `(g, h)` and the
/// target `(0, .., 0, 1)`. Then `u_k = -r_k / r_last`. Source: [Lawson 1974], chapter 23.
pub(crate) fn least_distance(rows: &[(Vec<f64>, f64)], count: usize) -> Vec<f64> {
    let columns: Vec<Vec<f64>> = rows.iter().map(|(g, h)| g.iter().copied().chain([*h]).collect()).collect();
    let mut target = vec![0.0; count + 1];
    target[count] = 1.0;
    let problem = Columns::new(&columns, &target);
    let r = problem.residual(&nnls(&problem));
    // r_last = -|r|² is negative unless the constraints contradict each other.
    let last = r[count].abs().max(f64::MIN_POSITIVE);
    r[..count].iter().map(|r| r / last).collect()
}

/// `min |Σ x_k column_k - target|²`. Columns that depend on the passive ones are rejected: of planes that almost
/// coincide one suffices. Solved by orthogonalization, because normal equations would lose the difference of nearly
/// parallel planes.
struct Columns<'a> {
    columns: &'a [Vec<f64>],
    lengths: Vec<f64>,
    target: &'a [f64],
}

impl<'a> Columns<'a> {
    fn new(columns: &'a [Vec<f64>], target: &'a [f64]) -> Self {
        Self { columns, lengths: columns.iter().map(|c| dot(c, c).sqrt()).collect(), target }
    }

    /// `Σ x_k column_k - target`.
    fn residual(&self, x: &[f64]) -> Vec<f64> {
        let mut residual: Vec<f64> = self.target.iter().map(|t| -t).collect();
        for (x, column) in x.iter().zip(self.columns).filter(|(x, _)| **x != 0.0) {
            residual.iter_mut().zip(column).for_each(|(r, c)| *r += x * c);
        }
        residual
    }
}

impl NnlsProblem for Columns<'_> {
    fn count(&self) -> usize {
        self.columns.len()
    }

    fn negative_gradient(&self, x: &[f64]) -> Vec<f64> {
        let residual = self.residual(x);
        let component =
            |(column, length): (&Vec<f64>, &f64)| if *length > 0.0 { -dot(column, &residual) / length } else { 0.0 };
        self.columns.iter().zip(&self.lengths).map(component).collect()
    }

    /// As a fraction of the target, which has length 1.
    fn tolerance(&self) -> f64 {
        1e-12
    }

    fn solve(&self, passive: &[usize]) -> Option<Vec<f64>> {
        orthogonal_solution(self.columns, passive, self.target)
    }
}

/// The least-squares solution over some columns by modified Gram-Schmidt orthogonalization, each column twice; `None`
/// if they are dependent.
fn orthogonal_solution(columns: &[Vec<f64>], passive: &[usize], target: &[f64]) -> Option<Vec<f64>> {
    /// A column counts as dependent on others when less than this fraction of its length is orthogonal to them.
    const DEPENDENT: f64 = 1e-11;

    let count = passive.len();
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(count);
    let mut r = vec![vec![0.0; count]; count];
    for (j, &k) in passive.iter().enumerate() {
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
            let u = least_distance(&rows, count);
            let mut tight = Vec::new();
            for (g, h) in &rows {
                let slack = dot(g, &u) - h;
                assert!(slack > -1e-9, "case {case}: a row is missed by {slack}");
                if slack < 1e-9 {
                    tight.push(g.clone());
                }
            }
            // u is a sum of tight rows with multipliers that are not negative.
            let sum = Columns::new(&tight, &u);
            let rest = sum.residual(&nnls(&sum));
            assert!(dot(&rest, &rest).sqrt() < 1e-8, "case {case}: {u:?} is no cone sum, {rest:?} is left");
        }
    }

    #[test]
    fn without_need_the_shortest_vector_is_zero() {
        assert_eq!(least_distance(&[(vec![1.0, 0.0], -1.0)], 2), [0.0, 0.0], "a slack row");
        assert_eq!(least_distance(&[], 3), [0.0; 3], "no row");
    }

    #[test]
    fn equal_rows_do_no_harm() {
        let row = (vec![1.0, 1.0], 2.0);
        let u = least_distance(&[row.clone(), row.clone(), row], 2);
        assert!(u.iter().all(|u| (u - 1.0).abs() < 1e-12), "{u:?}");
    }
}
