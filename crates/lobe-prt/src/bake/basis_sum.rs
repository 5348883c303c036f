//! Sums of the basis over many directions.

use lobe_sh::basis::Basis;

/// Directions evaluated together.
pub(crate) const BATCH: usize = 64;

/// Directions of a batch that is not full are evaluated in steps of so many, which is what the kernels of the basis
/// take at a time: fewer would be evaluated in plain code, to other last digits.
const STEP: usize = 32;

/// Partial sums of a batch that run side by side.
const LANES: usize = 16;

/// `Σ_k w_k y_i(s_k)` over directions `s_k` that come one by one, for one or three weights each.
///
/// The basis is evaluated in `f32` for 64 directions at once. Their products are added up in `f32`, four to each of 16
/// lanes, and the lanes and batches in `f64`: what rounding adds is below that of the basis itself, 1e-6, however many
/// directions there are. The test `sums_are_those_of_the_basis` measures both together.
#[derive(Clone, Debug)]
pub(crate) struct BasisSum {
    basis: Basis<f32>,
    channels: usize,
    count: usize,
    directions: [[f32; BATCH]; 3],
    weights: [[f32; BATCH]; 3],
    values: Vec<f32>,
    sums: Vec<f64>,
}

impl BasisSum {
    /// Sums over the first `order` bands, for the first `channels` weights.
    pub(crate) fn new(order: usize, channels: usize) -> Self {
        let bands = order * order;
        Self {
            basis: Basis::new(order),
            channels,
            count: 0,
            directions: [[0.0; BATCH]; 3],
            weights: [[0.0; BATCH]; 3],
            values: vec![0.0; bands * BATCH],
            sums: vec![0.0; bands * channels],
        }
    }

    /// Adds one direction.
    pub(crate) fn push(&mut self, direction: [f32; 3], weight: [f32; 3]) {
        for axis in 0..3 {
            self.directions[axis][self.count] = direction[axis];
            self.weights[axis][self.count] = weight[axis];
        }
        self.count += 1;
        if self.count == BATCH {
            self.flush();
        }
    }

    /// The sums since the last call, channel by channel, times a factor of each channel.
    pub(crate) fn take_into(&mut self, factors: [f64; 3], out: &mut [f32]) {
        self.flush();
        let bands = self.sums.len() / self.channels;
        for (k, (sum, out)) in self.sums.iter_mut().zip(out).enumerate() {
            *out = (std::mem::take(sum) * factors[k / bands]) as f32;
        }
    }

    fn flush(&mut self) {
        if self.count == 0 {
            return;
        }
        // Whole steps up to the last direction; those beyond it have no weight.
        let width = self.count.next_multiple_of(STEP);
        for axis in 0..3 {
            self.weights[axis][self.count..width].fill(0.0);
        }
        self.count = 0;
        let directions = self.directions.each_ref().map(|axis| &axis[..width]);
        let bands = self.values.len() / BATCH;
        let values = &mut self.values[..bands * width];
        self.basis.eval_many_into(directions, values);
        for (sums, weights) in self.sums.chunks_exact_mut(bands).zip(&self.weights) {
            for (sum, values) in sums.iter_mut().zip(values.chunks_exact(width)) {
                *sum += dot(values, &weights[..width]);
            }
        }
    }
}

/// The sum of products of as many numbers, whole lanes of them: in 16 lanes of `f32`, and those in `f64`.
pub(crate) fn dot(a: &[f32], b: &[f32]) -> f64 {
    let mut lanes = [0.0_f32; LANES];
    for (a, b) in a.as_chunks::<LANES>().0.iter().zip(b.as_chunks::<LANES>().0) {
        for k in 0..LANES {
            lanes[k] += a[k] * b[k];
        }
    }
    lanes.into_iter().map(f64::from).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_sh::{Dir, eval_basis};
    use lobe_testkit::directions;

    /// Relative to the sum of all weights.
    const TOLERANCE: f64 = 1e-6;

    #[test]
    fn sums_have_the_same_bits_whether_or_not_others_without_weight_fill_the_batch() {
        let all = directions();
        for count in [1, 16, 31, 32, 33, 64, 90] {
            let [mut few, mut filled] = [(); 2].map(|()| BasisSum::new(4, 3));
            let mut push = |k: usize, weight: [f32; 3]| {
                let direction = all[k].map(|c| c as f32);
                if k < count {
                    few.push(direction, weight);
                }
                filled.push(direction, weight);
            };
            (0..count).for_each(|k| push(k, [1.0, 0.1 * k as f32, -0.3]));
            (count..2 * BATCH).for_each(|k| push(k, [0.0; 3]));
            let [mut found, mut expected] = [vec![f32::NAN; 48], vec![f32::NAN; 48]];
            few.take_into([0.7; 3], &mut found);
            filled.take_into([0.7; 3], &mut expected);
            let bits = |row: &[f32]| row.iter().map(|c| c.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&found), bits(&expected), "{count} directions: {found:?} against {expected:?}");
        }
    }

    #[test]
    fn sums_are_those_of_the_basis() {
        let all = directions();
        for count in [1, 64, 65, all.len()] {
            let mut sum = BasisSum::new(8, 3);
            let mut expected = vec![0.0; 3 * 64];
            for (k, &s) in all[..count].iter().enumerate() {
                let weight = [1.0, k as f32, -0.5];
                sum.push(s.map(|c| c as f32), weight);
                for (i, y) in eval_basis(Dir::from_unit(s), 8).into_iter().enumerate() {
                    (0..3).for_each(|c| expected[c * 64 + i] += 2.0 * f64::from(weight[c]) * y);
                }
            }
            let mut found = vec![0.0; 3 * 64];
            sum.take_into([2.0; 3], &mut found);
            let scale = (count * count + 1) as f64;
            for (i, (a, b)) in found.iter().zip(&expected).enumerate() {
                assert!((f64::from(*a) - b).abs() < TOLERANCE * scale, "{count} directions, {i}: {a} against {b}");
            }
            sum.take_into([1.0; 3], &mut found);
            assert_eq!(found, [0.0; 192], "nothing since");
        }
    }
}
