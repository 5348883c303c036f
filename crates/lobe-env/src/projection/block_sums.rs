//! The inner loops of projection and reconstruction at high orders: sums of tables times rows, and of Legendre functions, on
//! blocks of sixteen numbers.

use lobe_sh::simd::{Kernel, MOST_PARTS, sum_of_parts, sum_parts};
use pulp::Simd;

/// Numbers of a table side by side: two registers of AVX-512, four of AVX2.
pub(crate) const BLOCK: usize = 16;

/// Numbers that share a pass over a table: the channels of cosines and sines of two `m` for colors, of six for numbers.
pub(crate) const ROW: usize = 12;

/// Channels of cosine and sine of one `m`, for numbers and for colors.
pub(crate) const WAVE: [usize; 2] = [2, 6];

/// A block of each number of a row.
pub(crate) type Blocks = [[f64; BLOCK]; ROW];

/// `Σ_y table(y, ·) rows(y, c)` for every block of the table, `blocks[b](c, ·)`, and for several sets of rows, while the block is
/// in the cache.
pub(crate) struct Product<'a> {
    /// Block after block, each with `lines` lines.
    pub(crate) table: &'a [[f64; BLOCK]],
    pub(crate) lines: usize,
    /// Each with at least as many rows.
    pub(crate) sets: &'a [Vec<[f64; ROW]>],
    /// Of each set.
    pub(crate) blocks: &'a mut [Vec<Blocks>],
}

impl Kernel for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        for b in 0..self.table.len() / self.lines {
            let table = &self.table[b * self.lines..][..self.lines];
            for (rows, blocks) in self.sets.iter().zip(self.blocks.iter_mut()) {
                if S::F64_LANES >= 8 {
                    product_block::<S, 2>(simd, table, rows, &mut blocks[b]);
                } else {
                    product_block::<S, 1>(simd, table, rows, &mut blocks[b]);
                }
            }
        }
    }

    fn plain(self) {
        self.wide(pulp::Scalar::new());
    }
}

#[inline(always)]
fn product_block<S: Simd, const REGISTERS: usize>(
    simd: S,
    table: &[[f64; BLOCK]],
    rows: &[[f64; ROW]],
    out: &mut Blocks,
) {
    for first in (0..BLOCK / S::F64_LANES).step_by(REGISTERS) {
        let mut sums = [[simd.splat_f64s(0.0); REGISTERS]; ROW];
        let mut line = [simd.splat_f64s(0.0); REGISTERS];
        for (table, row) in table.iter().zip(rows) {
            let registers = S::as_simd_f64s(table).0;
            line.copy_from_slice(&registers[first..][..REGISTERS]);
            for c in 0..ROW {
                let x = simd.splat_f64s(row[c]);
                for r in 0..REGISTERS {
                    sums[c][r] = simd.mul_add_e_f64s(line[r], x, sums[c][r]);
                }
            }
        }
        for c in 0..ROW {
            for r in 0..REGISTERS {
                S::as_mut_simd_f64s(&mut out[c]).0[first + r] = sums[c][r];
            }
        }
    }
}

/// A column of Legendre functions on latitudes with `z >= 0`, without the factor `sin^m θ`; see [`lobe_sh::Basis`].
#[derive(Clone, Copy)]
pub(crate) struct Column<'a> {
    /// `P̄_m^m`.
    pub(crate) first: f64,
    /// `[a, b, g]` of the steps to the bands above `m`.
    pub(crate) steps: &'a [[f64; 3]],
    /// `z - 1` of each latitude.
    pub(crate) w: &'a [[f64; BLOCK]],
}

/// `Σ_j P̄_l^m(z_j) x_j(c)` for each `l` from `m` on, of the first numbers `x` where `l - m` is even and the second where it is odd.
pub(crate) struct LegendreSums<'a, const WAVE: usize> {
    pub(crate) column: Column<'a>,
    /// For each block of latitudes the numbers of one wave, from `offset` on.
    pub(crate) x: [&'a [Blocks]; 2],
    pub(crate) offset: usize,
    /// Room for two blocks for each block of latitudes.
    pub(crate) work: &'a mut [[[f64; BLOCK]; 2]],
    pub(crate) sums: &'a mut [[f64; WAVE]],
}

impl<const WAVE: usize> Kernel for LegendreSums<'_, WAVE> {
    type Output = ();

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        let Self { column, x, offset, work, sums } = self;
        for state in work.iter_mut() {
            *state = [[column.first; BLOCK], [0.0; BLOCK]];
        }
        for (i, out) in sums.iter_mut().enumerate() {
            let [a, b, g] = column.steps.get(i).copied().unwrap_or([0.0; 3]);
            let (a, b, g) = (simd.splat_f64s(a), simd.splat_f64s(b), simd.splat_f64s(g));
            let mut wide = [[simd.splat_f64s(0.0); MOST_PARTS]; WAVE];
            for part in 0..sum_parts::<S>() {
                let mut sums = [simd.splat_f64s(0.0); WAVE];
                for ((state, x), w) in work.iter_mut().zip(x[i % 2]).zip(column.w) {
                    let w = S::as_simd_f64s(w).0;
                    let [p, d] = state;
                    let (p, d) = (S::as_mut_simd_f64s(p).0, S::as_mut_simd_f64s(d).0);
                    for r in (part..BLOCK / S::F64_LANES).step_by(sum_parts::<S>()) {
                        for c in 0..WAVE {
                            sums[c] = simd.mul_add_e_f64s(S::as_simd_f64s(&x[offset + c]).0[r], p[r], sums[c]);
                        }
                        let next = simd.mul_add_e_f64s(simd.mul_add_e_f64s(a, w[r], g), p[r], simd.mul_f64s(b, d[r]));
                        d[r] = next;
                        p[r] = simd.add_f64s(p[r], next);
                    }
                }
                for c in 0..WAVE {
                    wide[c][part] = sums[c];
                }
            }
            for c in 0..WAVE {
                out[c] = sum_of_parts(simd, wide[c]);
            }
        }
    }

    fn plain(self) {
        self.wide(pulp::Scalar::new());
    }
}

/// The values of a wave at a block of latitudes: of even `l - m`, and of odd.
pub(crate) type WaveBlocks<const WAVE: usize> = [[[f64; BLOCK]; WAVE]; 2];

/// `Σ_l P̄_l^m(z_j) f_l(c)` at each latitude: over even `l - m`, and over odd.
pub(crate) struct LegendreValues<'a, const WAVE: usize> {
    pub(crate) column: Column<'a>,
    /// For each `l` from `m` on.
    pub(crate) f: &'a [[f64; WAVE]],
    pub(crate) values: &'a mut [WaveBlocks<WAVE>],
}

impl<const WAVE: usize> Kernel for LegendreValues<'_, WAVE> {
    type Output = ();

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        for (w, out) in self.column.w.iter().zip(self.values) {
            if S::F64_LANES >= 8 {
                values_block::<S, 2, WAVE>(simd, self.column, self.f, w, out);
            } else {
                values_block::<S, 1, WAVE>(simd, self.column, self.f, w, out);
            }
        }
    }

    fn plain(self) {
        self.wide(pulp::Scalar::new());
    }
}

#[inline(always)]
fn values_block<S: Simd, const REGISTERS: usize, const WAVE: usize>(
    simd: S,
    column: Column<'_>,
    f: &[[f64; WAVE]],
    w: &[f64; BLOCK],
    out: &mut WaveBlocks<WAVE>,
) {
    let zero = simd.splat_f64s(0.0);
    for first in (0..BLOCK / S::F64_LANES).step_by(REGISTERS) {
        let mut sums = [[[zero; REGISTERS]; WAVE]; 2];
        let (mut p, mut d, mut own) =
            ([simd.splat_f64s(column.first); REGISTERS], [zero; REGISTERS], [zero; REGISTERS]);
        own.copy_from_slice(&S::as_simd_f64s(w).0[first..][..REGISTERS]);
        let (pairs, last) = f.as_chunks::<2>();
        for (i, pair) in pairs.iter().enumerate() {
            for half in 0..2 {
                for c in 0..WAVE {
                    let f = simd.splat_f64s(pair[half][c]);
                    for r in 0..REGISTERS {
                        sums[half][c][r] = simd.mul_add_e_f64s(f, p[r], sums[half][c][r]);
                    }
                }
                if let Some([a, b, g]) = column.steps.get(2 * i + half) {
                    let (a, b, g) = (simd.splat_f64s(*a), simd.splat_f64s(*b), simd.splat_f64s(*g));
                    for r in 0..REGISTERS {
                        let factor = simd.mul_add_e_f64s(a, own[r], g);
                        d[r] = simd.mul_add_e_f64s(factor, p[r], simd.mul_f64s(b, d[r]));
                        p[r] = simd.add_f64s(p[r], d[r]);
                    }
                }
            }
        }
        for f in last {
            for c in 0..WAVE {
                for r in 0..REGISTERS {
                    sums[0][c][r] = simd.mul_add_e_f64s(simd.splat_f64s(f[c]), p[r], sums[0][c][r]);
                }
            }
        }
        for half in 0..2 {
            for c in 0..WAVE {
                for r in 0..REGISTERS {
                    S::as_mut_simd_f64s(&mut out[half][c]).0[first + r] = sums[half][c][r];
                }
            }
        }
    }
}
