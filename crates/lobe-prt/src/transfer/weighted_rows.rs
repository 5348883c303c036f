//! Weighted sums out of a table of each cluster, in explicit SIMD lanes.
//!
//! Each sum is in the order of the components, whatever the width of registers and the number of threads, and nothing is fused.

use lobe_io::parallel;
use lobe_sh::Rgb;

use crate::transfer::dot_rows::{CHUNK, store_colors};
use crate::transfer::number::Number as _;
use crate::transfer::simd::{EIGHT, FOUR, Lanes, Machine, Work};

/// Receivers shaded together: as many additions as a machine has under way at a time, so that those of one need not wait for another's.
const TOGETHER: usize = EIGHT;

/// Receivers whose weights are made `f32` at a time, by whole registers; those of eight components take 2 KB.
const WIDENED: usize = 64;

/// Weighted sums out of a small table of colors: `out[r] = table[k][0] + Σ_j weights[r n' + j] table[k][j+1]`, with
/// `k = clusters[r]`, summed in the order of `j`.
///
/// `table` has `n' + 1` entries for each cluster.
pub(crate) fn weighted<W: Copy + Into<f32> + Sync>(
    clusters: &[u16],
    weights: &[W],
    components: usize,
    table: &[[f32; 4]],
    out: &mut [Rgb<f32>],
) {
    assert_eq!(clusters.len(), out.len(), "one place for each receiver");
    assert_eq!(weights.len(), components * out.len(), "the weights of every receiver");
    let machine = Machine::detect();
    parallel::rows(out, CHUNK, &|at, out| {
        let clusters = &clusters[at * CHUNK..at * CHUNK + out.len()];
        let weights = &weights[at * CHUNK * components..(at * CHUNK + out.len()) * components];
        machine.run(WeightsOfChunk { clusters, weights, components, table, out });
    });
}

struct WeightsOfChunk<'a, W> {
    clusters: &'a [u16],
    weights: &'a [W],
    components: usize,
    table: &'a [[f32; 4]],
    out: &'a mut [Rgb<f32>],
}

impl<W: Copy + Into<f32>> Work for WeightsOfChunk<'_, W> {
    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) {
        let Self { clusters, weights, components, table, out } = self;
        let mut numbers = vec![0.0; WIDENED * components];
        for (at, (clusters, out)) in clusters.chunks(WIDENED).zip(out.chunks_mut(WIDENED)).enumerate() {
            let weights = &weights[at * WIDENED * components..][..out.len() * components];
            for (number, w) in numbers.iter_mut().zip(weights) {
                *number = (*w).into();
            }
            let (clusters_together, last_clusters) = clusters.as_chunks::<TOGETHER>();
            let (outs_together, last_outs) = out.as_chunks_mut::<TOGETHER>();
            let (numbers_together, last_numbers) = numbers.split_at(TOGETHER * clusters_together.len() * components);
            for (k, (clusters, out)) in clusters_together.iter().zip(outs_together).enumerate() {
                let numbers = &numbers_together[k * TOGETHER * components..][..TOGETHER * components];
                if clusters.iter().all(|cluster| *cluster == clusters[0]) {
                    let table = &table[usize::from(clusters[0]) * (components + 1)..][..=components];
                    weighted_of_one(lanes, numbers, table, out);
                    continue;
                }
                weighted_together(lanes, clusters, numbers, components, table, out);
            }
            for (k, (cluster, out)) in last_clusters.iter().zip(last_outs).enumerate() {
                let out = std::array::from_mut(out);
                weighted_together(lanes, &[*cluster], &last_numbers[k * components..], components, table, out);
            }
        }
    }
}

/// The sums of eight receivers of one cluster, a receiver in each lane: each number of the cluster is loaded once for
/// all.
#[inline(always)]
fn weighted_of_one<L: Lanes>(lanes: L, weights: &[f32], table: &[[f32; 4]], out: &mut [Rgb<f32>; TOGETHER]) {
    let [first, bases @ ..] = table else { return };
    let mut sums = [lanes.splat_wide(first[0]), lanes.splat_wide(first[1]), lanes.splat_wide(first[2])];
    let mut rows: [&[f32]; TOGETHER] = [&[]; TOGETHER];
    for k in 0..TOGETHER {
        rows[k] = &weights[k * bases.len()..][..bases.len()];
    }
    let (fours, rest) = bases.as_chunks::<FOUR>();
    for (block, bases) in fours.iter().enumerate() {
        let mut square = [&[0.0; FOUR]; TOGETHER];
        for k in 0..TOGETHER {
            square[k] = &rows[k].as_chunks::<FOUR>().0[block];
        }
        let columns = f32::four_columns(lanes, square);
        for i in 0..FOUR {
            for c in 0..3 {
                sums[c] = lanes.add_product_wide(sums[c], columns[i], lanes.splat_wide(bases[i][c]));
            }
        }
    }
    for (i, base) in rest.iter().enumerate() {
        let mut column = [0.0; TOGETHER];
        for k in 0..TOGETHER {
            column[k] = rows[k][FOUR * fours.len() + i];
        }
        let column = lanes.load_wide(&column);
        for c in 0..3 {
            sums[c] = lanes.add_product_wide(sums[c], column, lanes.splat_wide(base[c]));
        }
    }
    store_colors(lanes, sums, out);
}

/// The sums of `K` receivers side by side.
#[inline(always)]
fn weighted_together<L: Lanes, const K: usize>(
    lanes: L,
    clusters: &[u16; K],
    weights: &[f32],
    components: usize,
    table: &[[f32; 4]],
    out: &mut [Rgb<f32>; K],
) {
    let mut sums = [lanes.splat(0.0); K];
    let mut bases: [&[[f32; 4]]; K] = [&[]; K];
    let mut rows: [&[f32]; K] = [&[]; K];
    for k in 0..K {
        let entries = &table[usize::from(clusters[k]) * (components + 1)..];
        sums[k] = lanes.load(entries[0]);
        bases[k] = &entries[1..][..components];
        rows[k] = &weights[k * components..][..components];
    }
    for j in 0..components {
        for k in 0..K {
            sums[k] = lanes.add_product(sums[k], lanes.splat(rows[k][j]), lanes.load(bases[k][j]));
        }
    }
    for (out, sum) in out.iter_mut().zip(sums) {
        let [r, g, b, _] = lanes.store(sum);
        *out = Rgb::new(r, g, b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    #[test]
    fn weighted_sums_are_those_of_their_formula() {
        let mut random = Random::new(3);
        let receivers = 2 * WIDENED + 7;
        for components in [0, 1, 4, 9, 16, 17] {
            let table: Vec<[f32; 4]> =
                (0..3 * (components + 1)).map(|_| std::array::from_fn(|_| random.signed() as f32)).collect();
            let clusters: Vec<u16> = (0..receivers as u16).map(|r| r % 3).collect();
            let weights: Vec<u8> = (0..receivers * components).map(|_| random.next_u64() as u8).collect();
            let mut out = vec![Rgb::new(0.0, 0.0, 0.0); receivers];
            weighted(&clusters, &weights, components, &table, &mut out);
            for (r, found) in out.iter().enumerate() {
                let start = usize::from(clusters[r]) * (components + 1);
                let term = |j: usize| f64::from(weights[r * components + j]) * f64::from(table[start + 1 + j][1]);
                let expected = f64::from(table[start][1]) + (0..components).map(term).sum::<f64>();
                let error = (f64::from(found.g) - expected).abs();
                assert!(error < 1e-3, "{components} components, receiver {r}: {} against {expected}", found.g);
            }
        }
    }
    #[test]
    fn receivers_of_one_cluster_have_the_bits_that_each_has_alone() {
        let mut random = Random::new(4);
        for components in [0, 1, 4, 7, 8] {
            let table: Vec<[f32; 4]> =
                (0..2 * (components + 1)).map(|_| std::array::from_fn(|_| random.signed() as f32)).collect();
            let clusters = [1_u16; TOGETHER];
            let weights: Vec<f32> = random.signed_vec(TOGETHER * components).iter().map(|x| *x as f32).collect();
            let black = Rgb::new(0.0, 0.0, 0.0);
            let (mut together, mut alone) = ([black; TOGETHER], [black; TOGETHER]);
            weighted(&clusters, &weights, components, &table, &mut together);
            for (r, alone) in alone.iter_mut().enumerate() {
                let weights = &weights[r * components..][..components];
                weighted(&clusters[..1], weights, components, &table, std::array::from_mut(alone));
            }
            assert_eq!(together, alone, "{components} components");
        }
    }
}
