//! Columns of the basis on rows of a grid: between coefficients and the Fourier series along rows at `z` and `-z`.

use alloc::vec::Vec;

use pulp::Simd;

use crate::basis::index::{coefficient_index, order_of_slice};
use crate::basis::recurrence::Constants;
use crate::simd::{Kernel, MOST_PARTS, sum_of_parts, sum_parts};

/// Rows side by side: two registers of AVX-512, four of AVX2.
pub(crate) const BLOCK: usize = 16;

/// Registers of rows whose sums have room beside the recurrence in 16 registers.
const REGISTERS: usize = 2;

/// For a block of rows the part of one `m` in their Fourier series: of bands whose `l - m` is even and odd, the cosine and the sine.
pub(crate) type Wave = [[[f64; BLOCK]; 2]; 2];

/// No wave.
pub(crate) const NO_WAVE: Wave = [[[0.0; BLOCK]; 2]; 2];

/// Rows with `z >= 0`, in blocks of which the last is filled up with the equator.
pub(crate) struct Rows {
    /// `sin θ`.
    sin: Vec<[f64; BLOCK]>,
    /// `z - 1`.
    w: Vec<[f64; BLOCK]>,
}

impl Rows {
    /// Of some `z`.
    pub(crate) fn new(z: &[f64]) -> Self {
        let at = |b: usize, k: usize| z.get(b * BLOCK + k).copied().unwrap_or(0.0);
        let blocks = 0..z.len().div_ceil(BLOCK);
        let sin = |b| core::array::from_fn(|k| ((1.0 - at(b, k)) * (1.0 + at(b, k))).sqrt());
        let w = |b| core::array::from_fn(|k| at(b, k) - 1.0);
        Self { sin: blocks.clone().map(sin).collect(), w: blocks.map(w).collect() }
    }

    pub(crate) fn blocks(&self) -> usize {
        self.w.len()
    }
}

/// Multiplies `sin^m θ` by another `sin θ`: 0 where that is no normal number, and no function of `m` is seen.
#[inline(always)]
fn next_power(power: &mut [f64; BLOCK], sin: &[f64; BLOCK]) {
    for k in 0..BLOCK {
        let next = power[k] * sin[k];
        power[k] = if next < f64::MIN_POSITIVE { 0.0 } else { next };
    }
}

/// Two registers of a column of the basis and, after each step, of the next band.
#[derive(Clone, Copy)]
struct Column<S: Simd> {
    simd: S,
    w: [S::f64s; REGISTERS],
    p: [S::f64s; REGISTERS],
    difference: [S::f64s; REGISTERS],
}

impl<S: Simd> Column<S> {
    #[inline(always)]
    fn step(&mut self, a: f64, b: f64, g: f64) {
        let simd = self.simd;
        let (a, b, g) = (simd.splat_f64s(a), simd.splat_f64s(b), simd.splat_f64s(g));
        for r in 0..REGISTERS {
            let factor = simd.mul_add_e_f64s(a, self.w[r], g);
            self.difference[r] = simd.mul_add_e_f64s(factor, self.p[r], simd.mul_f64s(b, self.difference[r]));
            self.p[r] = simd.add_f64s(self.p[r], self.difference[r]);
        }
    }
}

/// `Σ_l f_lm P̃_l^m(z)` on all rows: `waves[m * blocks + b]`.
pub(crate) struct Series<'a> {
    pub(crate) constants: &'a Constants<f64>,
    pub(crate) rows: &'a Rows,
    /// Of `n²` coefficients.
    pub(crate) f: &'a [f64],
    /// For each `m < n`.
    pub(crate) waves: &'a mut [Wave],
}

impl Kernel for Series<'_> {
    type Output = ();

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        let Self { constants, rows, f, waves } = self;
        let (order, blocks) = (order_of_slice(f), rows.blocks());
        for (b, (w, sin)) in rows.w.iter().zip(&rows.sin).enumerate() {
            let mut power = [1.0; BLOCK];
            for m in 0..order {
                let wave = &mut waves[m * blocks + b];
                column_series(simd, constants, [order, m], f, w, wave);
                for part in wave.as_flattened_mut() {
                    for k in 0..BLOCK {
                        part[k] *= power[k];
                    }
                }
                next_power(&mut power, sin);
            }
        }
    }

    fn plain(self) {
        self.wide(pulp::Scalar::new());
    }
}

#[inline(always)]
fn column_series<S: Simd>(
    simd: S,
    constants: &Constants<f64>,
    [order, m]: [usize; 2],
    f: &[f64],
    w: &[f64; BLOCK],
    wave: &mut Wave,
) {
    let steps = constants.steps(m, order);
    let zero = simd.splat_f64s(0.0);
    for first in (0..BLOCK / S::F64_LANES).step_by(REGISTERS) {
        let mut own = [zero; REGISTERS];
        own.copy_from_slice(&S::as_simd_f64s(w).0[first..][..REGISTERS]);
        let p = [simd.splat_f64s(constants.diagonal(m)); REGISTERS];
        let mut column = Column { simd, w: own, p, difference: [zero; REGISTERS] };
        let mut sums = [[[zero; REGISTERS]; 2]; 2];
        let mut l = m;
        while l < order {
            for half in 0..2 {
                if l + half < order {
                    let l = l + half;
                    let cos = simd.splat_f64s(f[coefficient_index(l, m as isize)]);
                    let sin = simd.splat_f64s(f[coefficient_index(l, -(m as isize))]);
                    for r in 0..REGISTERS {
                        sums[half][0][r] = simd.mul_add_e_f64s(cos, column.p[r], sums[half][0][r]);
                        sums[half][1][r] = simd.mul_add_e_f64s(sin, column.p[r], sums[half][1][r]);
                    }
                    if let Some(step) = steps.get(l - m) {
                        column.step(step.a, step.b, step.g);
                    }
                }
            }
            l += 2;
        }
        for half in 0..2 {
            for part in 0..2 {
                for r in 0..REGISTERS {
                    S::as_mut_simd_f64s(&mut wave[half][part]).0[first + r] = sums[half][part][r];
                }
            }
        }
    }
}

/// Adds `Σ_z P̃_l^m(z) x_m(z)` to each coefficient, of the waves of even `l - m` where it is even and of odd where it is odd.
pub(crate) struct Coefficients<'a> {
    pub(crate) constants: &'a Constants<f64>,
    pub(crate) rows: &'a Rows,
    /// For each `m < n`; they are scaled.
    pub(crate) waves: &'a mut [Wave],
    /// `n²` coefficients.
    pub(crate) sums: &'a mut [f64],
}

impl Kernel for Coefficients<'_> {
    type Output = ();

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        let Self { constants, rows, waves, sums } = self;
        let (order, blocks) = (order_of_slice(sums), rows.blocks());
        let mut powers = vec![[1.0; BLOCK]; blocks];
        let mut state = vec![[[0.0; BLOCK]; 2]; blocks];
        for m in 0..order {
            let waves = &mut waves[m * blocks..][..blocks];
            for ((wave, power), sin) in waves.iter_mut().zip(&mut powers).zip(&rows.sin) {
                for part in wave.as_flattened_mut() {
                    for k in 0..BLOCK {
                        part[k] *= power[k];
                    }
                }
                next_power(power, sin);
            }
            column_sums(simd, constants, [order, m], rows, waves, &mut state, sums);
        }
    }

    fn plain(self) {
        self.wide(pulp::Scalar::new());
    }
}

#[inline(always)]
fn column_sums<S: Simd>(
    simd: S,
    constants: &Constants<f64>,
    [order, m]: [usize; 2],
    rows: &Rows,
    waves: &[Wave],
    state: &mut [[[f64; BLOCK]; 2]],
    out: &mut [f64],
) {
    state.fill([[constants.diagonal(m); BLOCK], [0.0; BLOCK]]);
    let (steps, parts) = (constants.steps(m, order), sum_parts::<S>());
    for l in m..order {
        // Behind the last band the step is of no use.
        let [a, b, g] = steps.get(l - m).map_or([0.0; 3], |step| [step.a, step.b, step.g]);
        let mut sums = [[simd.splat_f64s(0.0); MOST_PARTS]; 2];
        for part in 0..parts {
            [sums[0][part], sums[1][part]] = band_sums(simd, [a, b, g], [(l - m) % 2, part], rows, waves, state);
        }
        out[coefficient_index(l, m as isize)] += sum_of_parts(simd, sums[0]);
        if m > 0 {
            out[coefficient_index(l, -(m as isize))] += sum_of_parts(simd, sums[1]);
        }
    }
}

/// The sums of cosines and of sines of one band over the registers of one part, whose columns go on to the next band.
#[inline(always)]
fn band_sums<S: Simd>(
    simd: S,
    [a, b, g]: [f64; 3],
    [parity, part]: [usize; 2],
    rows: &Rows,
    waves: &[Wave],
    state: &mut [[[f64; BLOCK]; 2]],
) -> [S::f64s; 2] {
    let (parts, zero) = (sum_parts::<S>(), simd.splat_f64s(0.0));
    let mut sums = [[zero; REGISTERS]; 2];
    for ((wave, state), w) in waves.iter().zip(state.iter_mut()).zip(&rows.w) {
        let [cos, sin] = &wave[parity];
        let (cos, sin, w) = (S::as_simd_f64s(cos).0, S::as_simd_f64s(sin).0, S::as_simd_f64s(w).0);
        let [p, d] = state;
        let (p, d) = (S::as_mut_simd_f64s(p).0, S::as_mut_simd_f64s(d).0);
        for first in (part..BLOCK / S::F64_LANES).step_by(REGISTERS * parts) {
            let mut column = Column { simd, w: [zero; REGISTERS], p: [zero; REGISTERS], difference: [zero; REGISTERS] };
            for r in 0..REGISTERS {
                let at = first + r * parts;
                (column.w[r], column.p[r], column.difference[r]) = (w[at], p[at], d[at]);
                sums[0][r] = simd.mul_add_e_f64s(cos[at], column.p[r], sums[0][r]);
                sums[1][r] = simd.mul_add_e_f64s(sin[at], column.p[r], sums[1][r]);
            }
            column.step(a, b, g);
            for r in 0..REGISTERS {
                (p[first + r * parts], d[first + r * parts]) = (column.p[r], column.difference[r]);
            }
        }
    }
    [simd.add_f64s(sums[0][0], sums[0][1]), simd.add_f64s(sums[1][0], sums[1][1])]
}
