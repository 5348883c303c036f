//! Stitching: the least change after which both sides of seams show the same.

use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};

use crate::error::PrtError;
use crate::finishing::seams::{Seams, mean_constant};
use crate::transfer::transfer::Transfer;

/// Steps that are no larger, as a part of the mean of the constant coefficient, are left.
const TOLERANCE: f64 = 1e-3;

/// The most iterations. Each takes as long as all rows take to be read twice.
const ITERATIONS: usize = 300;

/// Transfer whose rows agree across seams as far as they can.
///
/// ```text
///   min ‖A (x + d)‖²,  of all such d the one of the least ‖d‖
/// ```
///
/// A has the rows of the seams, x is a coefficient of all receivers, and d the change. Conjugate gradients on the
/// least-squares problem (CGLS [Bjorck 1996]) find it from d = 0, where every step stays among changes that rows ask
/// for; they end where all rows are below a thousandth of the mean, or after 300 steps. Each coefficient is solved by
/// itself, by sums in a fixed order. What is black on both sides stays black.
pub(crate) fn stitched(seams: &Seams, transfer: &Transfer) -> Result<Transfer, PrtError> {
    let matrix = Matrix::new(seams);
    let row = transfer.coefficients().len() / transfer.receivers().max(1);
    let tolerance = TOLERANCE * mean_constant(transfer);
    let change = |k: usize| {
        let x: Vec<f64> =
            matrix.receivers.iter().map(|&r| f64::from(transfer.coefficients()[r as usize * row + k])).collect();
        matrix.least_change(&x, tolerance)
    };
    let changes: Vec<Vec<f64>> = (0..row).into_par_iter().map(change).collect();
    let mut coefficients = transfer.coefficients().to_vec();
    for (k, changes) in changes.iter().enumerate() {
        for (&receiver, change) in matrix.receivers.iter().zip(changes) {
            coefficients[receiver as usize * row + k] += *change as f32;
        }
    }
    Transfer::new(transfer.order(), transfer.channels(), coefficients)
}

/// The rows of seams, whose columns are the receivers that occur.
struct Matrix {
    receivers: Vec<u32>,
    starts: Vec<usize>,
    columns: Vec<u32>,
    weights: Vec<f64>,
}

impl Matrix {
    fn new(seams: &Seams) -> Self {
        let receivers = seams.all_receivers();
        let mut matrix = Self { receivers, starts: vec![0], columns: Vec::new(), weights: Vec::new() };
        for (row, weights) in seams.rows() {
            // Every receiver of a row is one of all.
            let column = |r: &u32| matrix.receivers.binary_search(r).map_or(0, |column| column as u32);
            matrix.columns.extend(row.iter().map(column));
            matrix.weights.extend_from_slice(weights);
            matrix.starts.push(matrix.columns.len());
        }
        matrix
    }

    /// A x.
    fn product(&self, x: &[f64], out: &mut [f64]) {
        for (sum, ends) in out.iter_mut().zip(self.starts.windows(2)) {
            let range = ends[0]..ends[1];
            *sum = self.columns[range.clone()].iter().zip(&self.weights[range]).map(|(&c, w)| w * x[c as usize]).sum();
        }
    }

    /// Aᵀ r.
    fn transposed(&self, r: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (r, ends) in r.iter().zip(self.starts.windows(2)) {
            for k in ends[0]..ends[1] {
                out[self.columns[k] as usize] += self.weights[k] * r;
            }
        }
    }

    /// The change d.
    fn least_change(&self, x: &[f64], tolerance: f64) -> Vec<f64> {
        let (rows, columns) = (self.starts.len() - 1, x.len());
        let [mut r, mut q] = [0; 2].map(|_| vec![0.0; rows]);
        let [mut d, mut s] = [0; 2].map(|_| vec![0.0; columns]);
        self.product(x, &mut r);
        r.iter_mut().for_each(|r| *r = -*r);
        self.transposed(&r, &mut s);
        let mut p = s.clone();
        let mut square = dot(&s, &s);
        for _ in 0..ITERATIONS {
            let largest = r.iter().fold(0.0_f64, |most, r| most.max(r.abs()));
            if largest <= tolerance || square == 0.0 {
                break;
            }
            self.product(&p, &mut q);
            let length = square / dot(&q, &q);
            if !length.is_finite() {
                break;
            }
            d.iter_mut().zip(&p).for_each(|(d, p)| *d += length * p);
            r.iter_mut().zip(&q).for_each(|(r, q)| *r -= length * q);
            self.transposed(&r, &mut s);
            let next = dot(&s, &s);
            p.iter_mut().zip(&s).for_each(|(p, s)| *p = s + next / square * *p);
            square = next;
        }
        d
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    /// Rows of random weights.
    fn matrix(random: &mut Random, rows: usize, columns: usize) -> Matrix {
        let mut matrix =
            Matrix { receivers: (0..columns as u32).collect(), starts: vec![0], columns: vec![], weights: vec![] };
        for _ in 0..rows {
            for _ in 0..6 {
                matrix.columns.push((random.unit() * columns as f64) as u32);
                matrix.weights.push(random.unit() - 0.5);
            }
            matrix.starts.push(matrix.columns.len());
        }
        matrix
    }

    #[test]
    fn the_change_is_the_least_that_makes_all_rows_zero() {
        let mut random = Random::new(3);
        let matrix = matrix(&mut random, 30, 80);
        let x: Vec<f64> = (0..80).map(|_| random.unit()).collect();
        let d = matrix.least_change(&x, 1e-12);
        let changed: Vec<f64> = x.iter().zip(&d).map(|(x, d)| x + d).collect();
        let mut left = vec![0.0; 30];
        matrix.product(&changed, &mut left);
        assert!(left.iter().all(|r| r.abs() < 1e-10), "what rows leave: {left:?}");
        // The least change lies in the space of the rows: a change that no row sees is perpendicular to it.
        let unseen: Vec<f64> = {
            let y: Vec<f64> = (0..80).map(|_| random.unit()).collect();
            let back = matrix.least_change(&y, 1e-13);
            y.iter().zip(&back).map(|(y, d)| y + d).collect()
        };
        assert!(dot(&unseen, &d).abs() < 1e-9 * dot(&unseen, &unseen), "{}", dot(&unseen, &d));
    }
}
