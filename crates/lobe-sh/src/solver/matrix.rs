//! A small dense matrix.

use core::ops::{Index, IndexMut};

use crate::prelude::*;

/// Numbers that [`dot`] adds side by side: one after the other, each sum would wait for the one before.
const SUMS: usize = 4;

/// A matrix, its columns one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Matrix {
    rows: usize,
    columns: usize,
    entries: Vec<f64>,
}

impl Matrix {
    pub(crate) fn zeros(rows: usize, columns: usize) -> Self {
        Self { rows, columns, entries: vec![0.0; rows * columns] }
    }

    pub(crate) fn identity(size: usize) -> Self {
        Self::from_fn(size, size, |i, j| f64::from(u8::from(i == j)))
    }

    pub(crate) fn from_fn(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let entry = &entry;
        let entries = (0..columns).flat_map(|j| (0..rows).map(move |i| entry(i, j))).collect();
        Self { rows, columns, entries }
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn columns(&self) -> usize {
        self.columns
    }

    pub(crate) fn column(&self, j: usize) -> &[f64] {
        &self.entries[j * self.rows..(j + 1) * self.rows]
    }

    pub(crate) fn column_mut(&mut self, j: usize) -> &mut [f64] {
        &mut self.entries[j * self.rows..(j + 1) * self.rows]
    }

    /// `A x`.
    pub(crate) fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.rows];
        for (j, x) in x.iter().enumerate() {
            add_scaled(&mut sum, self.column(j), *x);
        }
        sum
    }

    /// `Aᵀ x`.
    pub(crate) fn transposed_times(&self, x: &[f64]) -> Vec<f64> {
        (0..self.columns).map(|j| dot(self.column(j), x)).collect()
    }

    /// Replaces the columns `a_p` and `a_q`, `p < q`, by `c a_p + s a_q` and `c a_q - s a_p`.
    pub(crate) fn rotate_columns(&mut self, p: usize, q: usize, [c, s]: [f64; 2]) {
        let (left, right) = self.entries.split_at_mut(q * self.rows);
        for (a, b) in left[p * self.rows..].iter_mut().zip(&mut right[..self.rows]) {
            (*a, *b) = (c * *a + s * *b, c * *b - s * *a);
        }
    }
}

impl Index<(usize, usize)> for Matrix {
    type Output = f64;

    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        &self.column(j)[i]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut f64 {
        &mut self.column_mut(j)[i]
    }
}

/// `Σ_i a_i b_i` of slices of one length.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (blocks, rest) = a.as_chunks::<SUMS>();
    let (others, other_rest) = b.as_chunks::<SUMS>();
    let mut sums = [0.0; SUMS];
    for (a, b) in blocks.iter().zip(others) {
        for k in 0..SUMS {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = rest.iter().zip(other_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// `|a|`.
pub(crate) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// `a += t b`.
pub(crate) fn add_scaled(a: &mut [f64], b: &[f64], t: f64) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += t * b);
}

/// The largest `|a_i|`; 0 of none.
pub(crate) fn largest(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |largest, a| a.abs().max(largest))
}
