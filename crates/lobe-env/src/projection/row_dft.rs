//! Discrete Fourier transform along the rows of a lat-long picture, and its inverse.

use lobe_sh::Rgb;
use lobe_sh::simd::{Kernel, Machine};
use pulp::Simd;

use crate::mapping::lat_long::sin_cos_pi;
use crate::projection::row_fold::{BLOCK, COS_EVEN, COS_ODD, FoldedBlock, SIN_EVEN, SIN_ODD};
use crate::projection::table_sums::{PlainSums, TableSums, WideSums};

/// Waves that share a pass over the planes: their sums, with three channels each, fit the registers of every machine.
const TOGETHER: usize = 3;

/// `cos mφ_x` and `sin mφ_x` for `m < order` over the columns of a picture, one quarter of them where the rest follows
/// by symmetry.
pub(crate) struct RowDft {
    order: usize,
    folded: bool,
    /// Columns with an entry of their own.
    columns: usize,
    cos: Vec<f64>,
    sin: Vec<f64>,
}

/// The sums of one or several rows: `[cos, sin]` for every `m < order`.
pub(crate) type RowSums = [[Rgb<f64>; 2]];

impl RowDft {
    /// The tables for `m < order` and `width` columns.
    pub(crate) fn new(width: usize, order: usize) -> Self {
        let folded = width.is_multiple_of(4);
        let columns = if folded { width / 4 } else { width };
        let mut cos = vec![0.0; order * columns];
        let mut sin = vec![0.0; order * columns];
        for m in 0..order {
            for x in 0..columns {
                // mφ_x/π = m (w - 2x - 1)/w, reduced to a turn in integers: no digit is lost for any m.
                let step = (m as i128 * (width as i128 - 2 * x as i128 - 1)).rem_euclid(2 * width as i128);
                (sin[m * columns + x], cos[m * columns + x]) = sin_cos_pi(step as f64 / width as f64);
            }
        }
        Self { order, folded, columns, cos, sin }
    }

    /// Adds `Σ_x L(x) cos mφ_x` and `Σ_x L(x) sin mφ_x` of each row to its `order` sums in `sums`.
    ///
    /// The tables pass once through the cache for all `rows`, so pass several at a time.
    pub(crate) fn add_sums(&self, rows: &[&[Rgb<f32>]], sums: &mut RowSums) {
        Machine::detect().run(AddSums { dft: self, rows, sums });
    }

    /// Writes `Σ_m A_m cos mφ_x + B_m sin mφ_x` into every texel of a row; `waves` are `[A_m, B_m]`.
    pub(crate) fn synthesise_into(&self, waves: &RowSums, row: &mut [Rgb<f32>]) {
        Machine::detect().run(Synthesise { dft: self, waves, row });
    }

    /// Each plane with its table, the first `m` that it has, and its place in [`RowSums`]; from there every second `m`.
    fn parts(&self) -> [(usize, &[f64], usize, usize); 4] {
        [
            (COS_EVEN, &self.cos, 0, 0),
            (COS_ODD, &self.cos, 1, 0),
            (SIN_EVEN, &self.sin, 2, 1),
            (SIN_ODD, &self.sin, 1, 1),
        ]
    }
}

struct AddSums<'a> {
    dft: &'a RowDft,
    rows: &'a [&'a [Rgb<f32>]],
    sums: &'a mut RowSums,
}

impl AddSums<'_> {
    #[inline(always)]
    fn by<F: TableSums>(self, arithmetic: F) {
        let Self { dft, rows, sums } = self;
        let mut block = FoldedBlock::new(dft.folded);
        for start in (0..dft.columns).step_by(BLOCK) {
            let count = BLOCK.min(dft.columns - start);
            for (row, sums) in rows.iter().zip(sums.chunks_exact_mut(dft.order)) {
                block.fold(row, start, count);
                for (plane, table, first, part) in dft.parts() {
                    let plane = block.plane(plane);
                    let table = |m: usize| &table[m * dft.columns + start..][..count];
                    let mut m = first;
                    while m + 2 * (TOGETHER - 1) < dft.order {
                        let found = arithmetic.sums([table(m), table(m + 2), table(m + 4)], plane);
                        for (k, found) in found.into_iter().enumerate() {
                            sums[m + 2 * k][part] += Rgb::from(found);
                        }
                        m += 2 * TOGETHER;
                    }
                    while m < dft.order {
                        sums[m][part] += Rgb::from(arithmetic.sums([table(m)], plane)[0]);
                        m += 2;
                    }
                }
            }
        }
    }
}

impl Kernel for AddSums<'_> {
    type Output = ();

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        self.by(WideSums(simd));
    }

    fn plain(self) {
        self.by(PlainSums);
    }
}

struct Synthesise<'a> {
    dft: &'a RowDft,
    waves: &'a RowSums,
    row: &'a mut [Rgb<f32>],
}

impl Synthesise<'_> {
    #[inline(always)]
    fn by<F: TableSums>(self, arithmetic: F) {
        let Self { dft, waves, row } = self;
        let mut block = FoldedBlock::new(dft.folded);
        for start in (0..dft.columns).step_by(BLOCK) {
            let count = BLOCK.min(dft.columns - start);
            block.clear(count);
            for (plane, table, first, part) in dft.parts() {
                let table = |m: usize| &table[m * dft.columns + start..][..count];
                for (c, channel) in block.plane_mut(plane).into_iter().enumerate() {
                    let wave = |m: usize| waves[m][part].to_array()[c];
                    let mut m = first;
                    while m + 2 * (TOGETHER - 1) < dft.order {
                        let tables = [table(m), table(m + 2), table(m + 4)];
                        arithmetic.add_scaled(channel, tables, [wave(m), wave(m + 2), wave(m + 4)]);
                        m += 2 * TOGETHER;
                    }
                    while m < dft.order {
                        arithmetic.add_scaled(channel, [table(m)], [wave(m)]);
                        m += 2;
                    }
                }
            }
            block.unfold(start, row);
        }
    }
}

impl Kernel for Synthesise<'_> {
    type Output = ();

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        self.by(WideSums(simd));
    }

    fn plain(self) {
        self.by(PlainSums);
    }
}

#[cfg(test)]
mod tests {
    use lobe_sh::Coefficient as _;
    use lobe_testkit::Random;

    use super::*;

    /// The double loop, one libm call for every term.
    fn slow_sums(row: &[Rgb<f32>], order: usize) -> Vec<[Rgb<f64>; 2]> {
        let mut sums = vec![[Rgb::ZERO; 2]; order];
        for (x, texel) in row.iter().enumerate() {
            let phi = std::f64::consts::PI * (1.0 - (2 * x + 1) as f64 / row.len() as f64);
            for (m, [cos, sin]) in sums.iter_mut().enumerate() {
                *cos += texel.widen().scale((m as f64 * phi).cos());
                *sin += texel.widen().scale((m as f64 * phi).sin());
            }
        }
        sums
    }

    fn random_row(width: usize) -> Vec<Rgb<f32>> {
        let mut random = Random::new(width as u64);
        (0..width).map(|_| Rgb::from([(); 3].map(|()| random.signed() as f32))).collect()
    }

    #[test]
    fn sums_of_rows_of_any_width_equal_the_double_loop() {
        for width in [1, 2, 3, 4, 6, 8, 17, 60, 1028, 1200] {
            for order in [1, 2, 3, 4, 7, 65] {
                let row = random_row(width);
                let mut sums = vec![[Rgb::ZERO; 2]; order];
                RowDft::new(width, order).add_sums(&[&row], &mut sums);
                for (m, (found, expected)) in sums.iter().zip(slow_sums(&row, order)).enumerate() {
                    for part in 0..2 {
                        let error = (found[part] - expected[part]).to_array().map(f64::abs);
                        let limit = 1e-15 * (width * (m + 1)) as f64;
                        assert!(error.iter().all(|e| *e <= limit), "width {width}, m {m}, part {part}: {error:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_sines_of_a_constant_row_are_exactly_zero() {
        let mut sums = vec![[Rgb::ZERO; 2]; 9];
        RowDft::new(64, 9).add_sums(&[&[Rgb::new(0.3, 1.7, 9.1); 64]], &mut sums);
        assert!(sums.iter().all(|[_, sin]| *sin == Rgb::ZERO), "{sums:?}");
    }

    #[test]
    fn synthesis_equals_the_sum_of_waves() {
        for width in [1, 2, 5, 8, 30, 1044] {
            let order = 6;
            let mut random = Random::new(3);
            let waves: Vec<[Rgb<f64>; 2]> =
                (0..order).map(|_| [(); 2].map(|()| Rgb::from([(); 3].map(|()| random.signed())))).collect();
            let mut row = vec![Rgb::ZERO; width];
            RowDft::new(width, order).synthesise_into(&waves, &mut row);
            for (x, found) in row.iter().enumerate() {
                let phi = std::f64::consts::PI * (1.0 - (2 * x + 1) as f64 / width as f64);
                let expected: f64 = (0..order)
                    .map(|m| waves[m][0].g * (m as f64 * phi).cos() + waves[m][1].g * (m as f64 * phi).sin())
                    .sum();
                assert!((f64::from(found.g) - expected).abs() < 1e-6, "width {width}, x {x}: {found:?}, {expected}");
            }
        }
    }
}
