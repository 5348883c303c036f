//! Sums of products of the basis at two directions.

use lobe_sh::basis::Basis;

use crate::bake::basis_sum::{BATCH, dot};

/// `Σ_k w_k y_i(a_k) y_j(b_k)` over pairs of directions that come one by one, for one or three weights each.
///
/// Sums are formed as those of [`crate::bake::basis_sum::BasisSum`].
#[derive(Clone, Debug)]
pub(crate) struct OuterSum {
    basis: Basis<f32>,
    channels: usize,
    count: usize,
    first: [[f32; BATCH]; 3],
    last: [[f32; BATCH]; 3],
    weights: [[f32; BATCH]; 3],
    values: [Vec<f32>; 2],
    sums: Vec<f64>,
}

impl OuterSum {
    /// Sums over the first `order` bands at both directions, for the first `channels` weights.
    pub(crate) fn new(order: usize, channels: usize) -> Self {
        let bands = order * order;
        Self {
            basis: Basis::new(order),
            channels,
            count: 0,
            first: [[0.0; BATCH]; 3],
            last: [[0.0; BATCH]; 3],
            weights: [[0.0; BATCH]; 3],
            values: [vec![0.0; bands * BATCH], vec![0.0; bands * BATCH]],
            sums: vec![0.0; bands * bands * channels],
        }
    }

    /// Adds one pair.
    pub(crate) fn push(&mut self, first: [f32; 3], last: [f32; 3], weight: [f32; 3]) {
        for axis in 0..3 {
            self.first[axis][self.count] = first[axis];
            self.last[axis][self.count] = last[axis];
            self.weights[axis][self.count] = weight[axis];
        }
        self.count += 1;
        if self.count == BATCH {
            self.flush();
        }
    }

    /// The sums since the last call times a factor: channel by channel, row by row of equal `i`.
    pub(crate) fn take_into(&mut self, factor: f64, out: &mut [f32]) {
        self.flush();
        for (sum, out) in self.sums.iter_mut().zip(out) {
            *out = (std::mem::take(sum) * factor) as f32;
        }
    }

    fn flush(&mut self) {
        if self.count == 0 {
            return;
        }
        // Clear the weights that are left of an earlier batch.
        (0..3).for_each(|c| self.weights[c][self.count..].fill(0.0));
        self.count = 0;
        for (values, [x, y, z]) in self.values.iter_mut().zip([&self.first, &self.last]) {
            self.basis.eval_many_into([x, y, z], values);
        }
        let [first, last] = self.values.each_ref().map(|values| values.as_chunks::<BATCH>().0);
        let square = first.len() * first.len();
        for (sums, weights) in self.sums.chunks_exact_mut(square).zip(&self.weights).take(self.channels) {
            for (sums, first) in sums.chunks_exact_mut(first.len()).zip(first) {
                let weighted: [f32; BATCH] = std::array::from_fn(|k| first[k] * weights[k]);
                sums.iter_mut().zip(last).for_each(|(sum, last)| *sum += dot(&weighted, last));
            }
        }
    }
}
