//! Rows of a picture on the few latitudes that determine Legendre functions, and back.

use std::f64::consts::PI;

use crate::mapping::lat_long::sin_cos_pi;
use crate::projection::block_sums::{BLOCK, Blocks, Column, Product, ROW};
use lobe_sh::simd::Machine;

// P̃_l^m(cos θ) sin θ is a trigonometric polynomial of degree l + 1 <= n: of sines for even m, of cosines for odd m. On M >= n + 1
// latitudes θ_j = π (j + ½)/M the waves are orthogonal, so that with t_k(θ) = sin kθ or cos kθ
//
//     P̃ sin θ = Σ_k a_k t_k(θ)        a_k = N_k Σ_j P̃(cos θ_j) sin θ_j t_k(θ_j)        N_k = 2/M, 1/M for k = 0
//
// and with the integrals of the waves over a row, ∫_row t_k dθ = s_k t_k(θ_y), s_k = (2/k) sin(kπ/2h), π/h for k = 0,
//
//     Σ_y F(y) ∫_row P̃ sin θ dθ = Σ_j P̃(cos θ_j) sin θ_j Σ_k t_k(θ_j) N_k s_k Σ_y t_k(θ_y) F(y)
//
// This is exact: the integrals are those of the piecewise constant picture, however many rows it has, but only M latitudes need
// Legendre functions. Functions with even and odd l + m are even and odd about the equator, as are the waves with odd and even
// k (sines; cosines the other way round), so that F(y) ± F(h - 1 - y) of half of the rows go to half of the latitudes, twice.

/// Latitudes of the upper half of the sphere, in blocks.
pub(crate) struct Latitudes {
    /// `sin θ`.
    sin: Vec<f64>,
    /// `cos θ - 1`.
    w: Vec<[f64; BLOCK]>,
}

impl Latitudes {
    /// `θ = π (j + ½)/count` for `j` below `count/2`, rounded up; the last block is filled up with the equator.
    pub(crate) fn new(count: usize) -> Self {
        let half = count.div_ceil(2);
        let angle = |j: usize| if j < half { (j as f64 + 0.5) / count as f64 } else { 0.5 };
        let padded = half.next_multiple_of(BLOCK);
        let sin = (0..padded).map(|j| sin_cos_pi(angle(j)).0).collect();
        let all: Vec<f64> = (0..padded).map(|j| -2.0 * sin_cos_pi(0.5 * angle(j)).0.powi(2)).collect();
        Self { sin, w: all.as_chunks().0.to_vec() }
    }

    pub(crate) fn blocks(&self) -> usize {
        self.w.len()
    }

    /// The column `m` on them, whose constants are `first` and `steps`.
    pub(crate) fn column<'a>(&'a self, first: f64, steps: &'a [[f64; 3]]) -> Column<'a> {
        Column { first, steps, w: &self.w }
    }

    /// Multiplies the numbers of each block by `sin^m θ`; by 0 where that is no normal number and no function of `m` is seen.
    pub(crate) fn scale_by_power<'a>(&self, m: usize, blocks: impl Iterator<Item = &'a mut [[f64; BLOCK]]>) {
        for (sin, block) in self.sin.as_chunks::<BLOCK>().0.iter().zip(blocks) {
            let power = sin.map(|sin| {
                let power = sin.powi(m as i32);
                if power < f64::MIN_POSITIVE { 0.0 } else { power }
            });
            for number in block {
                number.iter_mut().zip(power).for_each(|(number, power)| *number *= power);
            }
        }
    }
}

/// From the rows of a picture to latitudes that determine all functions of an order.
pub(crate) struct PolarGrid {
    pub(crate) latitudes: Latitudes,
    /// From rows to waves and from waves to latitudes, for even and odd `m`, each for functions even and odd about the equator.
    steps: [[[Table; 2]; 2]; 2],
}

/// Block after block of columns, each with all lines.
struct Table {
    lines: usize,
    blocks: Vec<[f64; BLOCK]>,
}

impl Table {
    fn new(lines: usize, columns: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let entry = &entry;
        let block = |first: usize| {
            (0..lines).map(move |line| {
                std::array::from_fn(|k| if first + k < columns { entry(line, first + k) } else { 0.0 })
            })
        };
        Self { lines, blocks: (0..columns).step_by(BLOCK).flat_map(block).collect() }
    }

    /// The sums of each column over each set of rows.
    fn times(&self, machine: Machine, sets: &[Vec<[f64; ROW]>]) -> Vec<Vec<Blocks>> {
        let count = self.blocks.len() / self.lines;
        let mut blocks = vec![vec![[[0.0; BLOCK]; ROW]; count]; sets.len()];
        machine.run(Product { table: &self.blocks, lines: self.lines, sets, blocks: &mut blocks });
        blocks
    }
}

impl PolarGrid {
    /// For functions of `order` over pictures of `height` rows.
    pub(crate) fn new(order: usize, height: usize) -> Self {
        let half = (order + 1).div_ceil(2).next_multiple_of(BLOCK);
        let count = 2 * half;
        let (rows, nodes) = (Waves::new(height), Waves::new(count));
        let latitudes = Latitudes::new(count);
        let tables = |parity: usize, odd: usize| {
            // Sines for even m, cosines for odd m; of those k that are even or odd about the equator.
            let first = match (parity, odd) {
                (0, 0) | (1, 1) => 1,
                (0, _) => 2,
                _ => 0,
            };
            let waves: Vec<usize> = (first..=order).step_by(2).collect();
            let weights: Vec<f64> = waves.iter().map(|k| row_integral(*k, height) * norm(*k, count)).collect();
            let to_waves =
                Table::new(height.div_ceil(2), waves.len(), |y, i| weights[i] * rows.value(parity, waves[i], y));
            let to_latitudes =
                Table::new(waves.len(), half, |i, j| 2.0 * latitudes.sin[j] * nodes.value(parity, waves[i], j));
            [to_waves, to_latitudes]
        };
        let steps = [0, 1].map(|parity| [0, 1].map(|odd| tables(parity, odd)));
        Self { latitudes, steps }
    }

    /// Sums (0) or differences (1) of mirrored rows of waves `m` of one parity, on the latitudes.
    pub(crate) fn resample(
        &self,
        machine: Machine,
        [parity, odd]: [usize; 2],
        sets: &[Vec<[f64; ROW]>],
    ) -> Vec<Vec<Blocks>> {
        let [to_waves, to_latitudes] = &self.steps[parity][odd];
        let line = |waves: &[Blocks], i: usize| std::array::from_fn(|c| waves[i / BLOCK][c][i % BLOCK]);
        let lines = |waves: &Vec<Blocks>| (0..to_latitudes.lines).map(|i| line(waves, i)).collect();
        let waves: Vec<Vec<[f64; ROW]>> = to_waves.times(machine, sets).iter().map(lines).collect();
        to_latitudes.times(machine, &waves)
    }
}

/// `s_k`.
fn row_integral(k: usize, height: usize) -> f64 {
    match k {
        0 => PI / height as f64,
        _ => 2.0 / k as f64 * sin_cos_pi((k % (4 * height)) as f64 / (2 * height) as f64).0,
    }
}

/// `N_k`.
fn norm(k: usize, count: usize) -> f64 {
    if k == 0 { 1.0 / count as f64 } else { 2.0 / count as f64 }
}

/// `sin kθ` and `cos kθ` at the middles of equal parts of `[0, π]`.
struct Waves {
    /// `sin` and `cos` of `πi/(2 count)` over a turn.
    turn: Vec<[f64; 2]>,
}

impl Waves {
    fn new(count: usize) -> Self {
        let point = |i: usize| {
            let (sin, cos) = sin_cos_pi(i as f64 / (2 * count) as f64);
            [sin, cos]
        };
        Self { turn: (0..4 * count).map(point).collect() }
    }

    /// The sine (0) or cosine (1) of `k` times the `i`-th angle.
    fn value(&self, part: usize, k: usize, i: usize) -> f64 {
        self.turn[k * (2 * i + 1) % self.turn.len()][part]
    }
}
