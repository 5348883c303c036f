//! Discrete Fourier transform along the rows of a lat-long picture, and its inverse.

use lobe_sh::{Coefficient, Rgb};

use crate::mapping::lat_long::sin_cos_pi;

// The columns of a picture of width w lie at φ_x = π (w - 2x - 1)/w. If w is a multiple of four they come in
// quadruples that share their cosines and sines up to the sign. With a = φ_x of a column x < w/4 in the left quarter:
//
//     column        φ         cos mφ            sin mφ
//     x             a         cos ma            sin ma             A
//     w/2 - 1 - x   π - a     (-1)^m cos ma    -(-1)^m sin ma      B
//     w/2 + x       a - π     (-1)^m cos ma     (-1)^m sin ma      C
//     w - 1 - x     -a        cos ma           -sin ma             D
//
// So a row is first folded into four planes of w/4 numbers,
//
//     cos, m even: (A+D) + (B+C)      cos, m odd: (A+D) - (B+C)
//     sin, m even: (A-D) - (B-C)      sin, m odd: (A-D) + (B-C)
//
// and each of the 2n - 1 sums runs over a quarter of the columns. Symmetric terms cancel before they are multiplied, so
// the sines of a constant row are exactly 0. Other widths use the whole row as every plane.

/// The planes of a folded row, in this order.
const COS_EVEN: usize = 0;
const COS_ODD: usize = 1;
const SIN_EVEN: usize = 2;
const SIN_ODD: usize = 3;
const PLANES: usize = 4;

/// Columns folded at a time: twelve planes of this many `f64` (24 KiB) stay in the first-level cache while every `m`
/// passes over them.
const BLOCK: usize = 256;

/// Partial sums kept side by side: four 128-bit registers of `f64`, whose additions hide each other's latency. The
/// tables are padded to multiples of it.
const LANES: usize = 8;

/// One channel of one plane of one block.
type Plane = [f64; BLOCK];

/// `cos mφ_x` and `sin mφ_x` for `m < order` over the columns of a picture, one quarter of them where the rest follows
/// by symmetry.
pub(crate) struct RowDft {
    width: usize,
    order: usize,
    folded: bool,
    /// Columns with an entry of their own.
    columns: usize,
    /// `columns` rounded up to [`LANES`].
    stride: usize,
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
        let stride = columns.next_multiple_of(LANES);
        let mut cos = vec![0.0; order * stride];
        let mut sin = vec![0.0; order * stride];
        for m in 0..order {
            for x in 0..columns {
                // mφ_x/π = m (w - 2x - 1)/w, reduced to a turn in integers: no digit is lost for any m.
                let step = (m as i128 * (width as i128 - 2 * x as i128 - 1)).rem_euclid(2 * width as i128);
                (sin[m * stride + x], cos[m * stride + x]) = sin_cos_pi(step as f64 / width as f64);
            }
        }
        Self { width, order, folded, columns, stride, cos, sin }
    }

    /// Adds `Σ_x L(x) cos mφ_x` and `Σ_x L(x) sin mφ_x` of each row to its `order` sums in `sums`.
    ///
    /// The tables pass once through the cache for all `rows`, so pass several at a time.
    pub(crate) fn add_sums(&self, rows: &[&[Rgb<f32>]], sums: &mut RowSums) {
        let mut planes = [[[0.0; BLOCK]; 3]; PLANES];
        for start in (0..self.columns).step_by(BLOCK) {
            let count = BLOCK.min(self.columns - start);
            for (row, sums) in rows.iter().zip(sums.chunks_exact_mut(self.order)) {
                self.fold(row, start, count, &mut planes);
                self.add_block(&planes, start, count, sums);
            }
        }
    }

    /// Folds `count` columns from `start` on into the planes and pads them with zeros to a multiple of [`LANES`].
    fn fold(&self, row: &[Rgb<f32>], start: usize, count: usize, planes: &mut [[Plane; 3]; PLANES]) {
        if self.folded {
            let (left, right) = row.split_at(self.width / 2);
            let (a, b) = (&left[start..][..count], &left[left.len() - start - count..][..count]);
            let (c, d) = (&right[start..][..count], &right[right.len() - start - count..][..count]);
            let [cos_even, cos_odd, sin_even, sin_odd] = planes;
            for k in 0..count {
                let [a, b, c, d] = [a[k], b[count - 1 - k], c[k], d[count - 1 - k]].map(Coefficient::widen);
                let (outer, inner) = (a + d, b + c);
                store(cos_even, k, outer + inner);
                store(cos_odd, k, outer - inner);
                let (outer, inner) = (a - d, b - c);
                store(sin_even, k, outer - inner);
                store(sin_odd, k, outer + inner);
            }
        } else {
            for (k, texel) in row[start..][..count].iter().enumerate() {
                store(&mut planes[0], k, texel.widen());
            }
        }
        let padded = count.next_multiple_of(LANES);
        for channel in planes.as_flattened_mut() {
            channel[count..padded].fill(0.0);
        }
    }

    /// Adds the sums over one folded block to those of its row.
    fn add_block(&self, planes: &[[Plane; 3]; PLANES], start: usize, count: usize, sums: &mut RowSums) {
        let padded = count.next_multiple_of(LANES);
        for (plane, table, first, part) in [
            (COS_EVEN, &self.cos, 0, 0),
            (COS_ODD, &self.cos, 1, 0),
            (SIN_EVEN, &self.sin, 2, 1),
            (SIN_ODD, &self.sin, 1, 1),
        ] {
            let values = planes[if self.folded { plane } else { 0 }].each_ref().map(|channel| &channel[..padded]);
            let table = |m: usize| &table[m * self.stride + start..][..padded];
            for m in (first..self.order).step_by(2) {
                sums[m][part] += Rgb::from(values.map(|channel| dot(table(m), channel)));
            }
        }
    }

    /// Writes `Σ_m A_m cos mφ_x + B_m sin mφ_x` into every texel of a row; `waves` are `[A_m, B_m]`.
    pub(crate) fn synthesise_into(&self, waves: &RowSums, row: &mut [Rgb<f32>]) {
        let mut planes = [[[0.0; BLOCK]; 3]; PLANES];
        for start in (0..self.columns).step_by(BLOCK) {
            let count = BLOCK.min(self.columns - start);
            for plane in planes.as_flattened_mut() {
                plane[..count].fill(0.0);
            }
            for (m, &[a, b]) in waves.iter().enumerate() {
                let cos = &self.cos[m * self.stride + start..][..count];
                let sin = &self.sin[m * self.stride + start..][..count];
                let odd = m % 2;
                add_scaled(&mut planes[COS_EVEN + odd], a, cos);
                add_scaled(&mut planes[SIN_EVEN + odd], b, sin);
            }
            self.unfold(&planes, start, count, row);
        }
    }

    /// The inverse of [`RowDft::fold`], up to a factor of four.
    fn unfold(&self, planes: &[[Plane; 3]; PLANES], start: usize, count: usize, row: &mut [Rgb<f32>]) {
        let half = self.width / 2;
        for k in 0..count {
            let [cos_even, cos_odd, sin_even, sin_odd] = planes.each_ref().map(|plane| load(plane, k));
            let x = start + k;
            let (outer, inner) = (cos_even + cos_odd, cos_even - cos_odd);
            let (outer_sin, inner_sin) = (sin_even + sin_odd, sin_odd - sin_even);
            row[x] = Rgb::narrow(outer + outer_sin);
            if self.folded {
                row[half - 1 - x] = Rgb::narrow(inner + inner_sin);
                row[half + x] = Rgb::narrow(inner - inner_sin);
                row[self.width - 1 - x] = Rgb::narrow(outer - outer_sin);
            }
        }
    }
}

/// Writes a color to column `k` of a plane.
#[inline(always)]
fn store(plane: &mut [Plane; 3], k: usize, value: Rgb<f64>) {
    for (channel, value) in plane.iter_mut().zip(value.to_array()) {
        channel[k] = value;
    }
}

/// The color in column `k` of a plane.
#[inline(always)]
fn load(plane: &[Plane; 3], k: usize) -> Rgb<f64> {
    Rgb::from(plane.each_ref().map(|channel| channel[k]))
}

/// `plane += value table`, channel by channel.
#[inline(always)]
fn add_scaled(plane: &mut [Plane; 3], value: Rgb<f64>, table: &[f64]) {
    for (channel, value) in plane.iter_mut().zip(value.to_array()) {
        for (sum, t) in channel.iter_mut().zip(table) {
            *sum += value * t;
        }
    }
}

/// The dot product of two slices of one length, a multiple of [`LANES`].
///
/// One table and one channel at a time: with several the compiler mixes lanes of different sums in one register.
#[inline(always)]
fn dot(table: &[f64], channel: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    for (table, channel) in table.as_chunks::<LANES>().0.iter().zip(channel.as_chunks::<LANES>().0) {
        for lane in 0..LANES {
            sums[lane] += table[lane] * channel[lane];
        }
    }
    sums.iter().sum()
}

#[cfg(test)]
mod tests {
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
