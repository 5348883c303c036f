//! Discrete Fourier transform along the rows of a lat-long picture, and its inverse.

use lobe_sh::Coefficient;
use lobe_sh::simd::{Kernel, Machine};
use pulp::Simd;

use crate::mapping::lat_long::sin_cos_pi;
use crate::projection::row_fold::{BLOCK, COS_EVEN, COS_ODD, FoldedBlock, SIN_EVEN, SIN_ODD};
use crate::projection::table_sums::{PlainSums, TableSums, WideSums};

/// Waves that share a pass over the planes: their sums, with three or four lines each, fit the registers of every machine.
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
pub(crate) type RowSums<W> = [[W; 2]];

/// Lines that share the passes over the tables: the channels of a color, or as many rows of numbers.
const LINES: [usize; 2] = [3, 4];

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
    pub(crate) fn add_sums<C: Coefficient>(&self, rows: &[&[C]], sums: &mut RowSums<C::Wide>) {
        let machine = Machine::detect();
        if C::CHANNELS == 1 {
            machine.run(AddSums::<C, { LINES[1] }> { dft: self, rows, sums });
        } else {
            machine.run(AddSums::<C, { LINES[0] }> { dft: self, rows, sums });
        }
    }

    /// Writes `Σ_m A_m cos mφ_x + B_m sin mφ_x` into every texel of some rows; `waves` are the `[A_m, B_m]` of each row.
    pub(crate) fn synthesise_into<C: Coefficient>(&self, waves: &[&RowSums<C::Wide>], rows: &mut [&mut [C]]) {
        let machine = Machine::detect();
        if C::CHANNELS == 1 {
            machine.run(Synthesise::<C, { LINES[1] }> { dft: self, waves, rows });
        } else {
            machine.run(Synthesise::<C, { LINES[0] }> { dft: self, waves, rows });
        }
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

struct AddSums<'a, C: Coefficient, const N: usize> {
    dft: &'a RowDft,
    rows: &'a [&'a [C]],
    sums: &'a mut RowSums<C::Wide>,
}

impl<C: Coefficient, const N: usize> AddSums<'_, C, N> {
    #[inline(always)]
    fn by<F: TableSums>(self, arithmetic: F) {
        let Self { dft, rows, sums } = self;
        let mut block = FoldedBlock::<C::Scalar, N>::new(dft.folded);
        let together = N / C::CHANNELS;
        for start in (0..dft.columns).step_by(BLOCK) {
            let count = BLOCK.min(dft.columns - start);
            for (rows, sums) in rows.chunks(together).zip(sums.chunks_mut(together * dft.order)) {
                block.fold(rows, start, count);
                for (plane, table, first, part) in dft.parts() {
                    let plane = block.plane(plane);
                    let table = |m: usize| &table[m * dft.columns + start..][..count];
                    for m in (first..dft.order).step_by(2 * TOGETHER) {
                        let mut found = [[0.0; N]; TOGETHER];
                        let count = (dft.order - m).div_ceil(2).min(TOGETHER);
                        match count {
                            1 => [found[0]] = arithmetic.sums([table(m)], plane),
                            2 => [found[0], found[1]] = arithmetic.sums([table(m), table(m + 2)], plane),
                            _ => found = arithmetic.sums([table(m), table(m + 2), table(m + 4)], plane),
                        }
                        for (k, found) in found[..count].iter().enumerate() {
                            add_to_rows::<C>(sums, dft.order, m + 2 * k, part, found);
                        }
                    }
                }
            }
        }
    }
}

/// Adds the sums of lines to those of their rows.
#[inline(always)]
fn add_to_rows<C: Coefficient>(sums: &mut RowSums<C::Wide>, order: usize, m: usize, part: usize, found: &[f64]) {
    for (row, found) in sums.chunks_exact_mut(order).zip(found.chunks_exact(C::CHANNELS)) {
        row[m][part] += C::Wide::from_channels(|c| found[c]);
    }
}

impl<C: Coefficient, const N: usize> Kernel for AddSums<'_, C, N> {
    type Output = ();

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        self.by(WideSums(simd));
    }

    fn plain(self) {
        self.by(PlainSums);
    }
}

/// The amplitudes of every second wave from `m` on, for each line; of lines that have no row, zero.
#[inline(always)]
fn amplitudes<C: Coefficient, const N: usize, const WAVES: usize>(
    waves: &[&RowSums<C::Wide>],
    m: usize,
    part: usize,
) -> [[f64; WAVES]; N] {
    let mut all = [[0.0; WAVES]; N];
    for (row, lines) in waves.iter().zip(all.chunks_exact_mut(C::CHANNELS)) {
        for (c, line) in lines.iter_mut().enumerate() {
            for (k, amplitude) in line.iter_mut().enumerate() {
                *amplitude = row[m + 2 * k][part].channel(c);
            }
        }
    }
    all
}

struct Synthesise<'a, 'b, C: Coefficient, const N: usize> {
    dft: &'a RowDft,
    waves: &'a [&'a RowSums<C::Wide>],
    rows: &'a mut [&'b mut [C]],
}

impl<C: Coefficient, const N: usize> Synthesise<'_, '_, C, N> {
    #[inline(always)]
    fn by<F: TableSums>(self, arithmetic: F) {
        let Self { dft, waves, rows } = self;
        let mut block = FoldedBlock::<C::Scalar, N>::new(dft.folded);
        let together = N / C::CHANNELS;
        for start in (0..dft.columns).step_by(BLOCK) {
            let count = BLOCK.min(dft.columns - start);
            for (waves, rows) in waves.chunks(together).zip(rows.chunks_mut(together)) {
                block.begin(count);
                for (plane, table, first, part) in dft.parts() {
                    let table = |m: usize| &table[m * dft.columns + start..][..count];
                    let lines = block.plane_mut(plane);
                    if first >= dft.order {
                        lines.iter_mut().for_each(|line| line[..count].fill(0.0));
                    }
                    for m in (first..dft.order).step_by(2 * TOGETHER) {
                        let adds = m > first;
                        match (dft.order - m).div_ceil(2) {
                            1 => arithmetic.set_scaled(lines, [table(m)], amplitudes::<C, N, 1>(waves, m, part), adds),
                            2 => {
                                let tables = [table(m), table(m + 2)];
                                arithmetic.set_scaled(lines, tables, amplitudes::<C, N, 2>(waves, m, part), adds);
                            }
                            _ => {
                                let tables = [table(m), table(m + 2), table(m + 4)];
                                arithmetic.set_scaled(
                                    lines,
                                    tables,
                                    amplitudes::<C, N, TOGETHER>(waves, m, part),
                                    adds,
                                );
                            }
                        }
                    }
                }
                block.unfold(start, rows);
            }
        }
    }
}

impl<C: Coefficient, const N: usize> Kernel for Synthesise<'_, '_, C, N> {
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
    use lobe_sh::Rgb;
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
            let mut row = vec![Rgb::<f32>::ZERO; width];
            RowDft::new(width, order).synthesise_into(&[&waves], &mut [&mut row]);
            for (x, found) in row.iter().enumerate() {
                let phi = std::f64::consts::PI * (1.0 - (2 * x + 1) as f64 / width as f64);
                let expected: f64 = (0..order)
                    .map(|m| waves[m][0].g * (m as f64 * phi).cos() + waves[m][1].g * (m as f64 * phi).sin())
                    .sum();
                assert!((f64::from(found.g) - expected).abs() < 1e-6, "width {width}, x {x}: {found:?}, {expected}");
            }
        }
    }

    #[test]
    fn rows_of_numbers_have_the_sums_and_the_texels_of_a_channel() {
        for (width, order, count) in [(1, 2, 3), (8, 5, 4), (17, 9, 1), (1028, 12, 9)] {
            let colors: Vec<Vec<Rgb<f32>>> =
                (0..count).map(|row| random_row(width + 7 * row)[..width].to_vec()).collect();
            let numbers: Vec<Vec<f64>> =
                colors.iter().map(|row| row.iter().map(|color| f64::from(color.g)).collect()).collect();
            let dft = RowDft::new(width, order);
            let mut of_colors = vec![[Rgb::ZERO; 2]; count * order];
            let mut of_numbers = vec![[0.0; 2]; count * order];
            dft.add_sums(&colors.iter().map(|row| &row[..]).collect::<Vec<_>>(), &mut of_colors);
            dft.add_sums(&numbers.iter().map(|row| &row[..]).collect::<Vec<_>>(), &mut of_numbers);
            for (number, color) in of_numbers.iter().flatten().zip(of_colors.iter().flatten()) {
                assert!((number - color.g).abs() < 1e-14 * width as f64, "width {width}: {number} and {}", color.g);
            }
            let mut texels = vec![Rgb::<f32>::ZERO; count * width];
            let mut values = vec![0.0_f64; count * width];
            let waves: Vec<_> = of_colors.chunks(order).collect();
            dft.synthesise_into(&waves, &mut texels.chunks_mut(width).collect::<Vec<_>>());
            let waves: Vec<_> = of_numbers.chunks(order).collect();
            dft.synthesise_into(&waves, &mut values.chunks_mut(width).collect::<Vec<_>>());
            for (value, texel) in values.iter().zip(&texels) {
                let limit = 1e-6 * (width * order) as f64;
                assert!((value - f64::from(texel.g)).abs() < limit, "width {width}: {value} and {}", texel.g);
            }
        }
    }
}
