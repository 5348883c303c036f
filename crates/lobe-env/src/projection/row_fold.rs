//! Rows of a lat-long picture folded by the symmetries of cosine and sine.

use lobe_sh::{Coefficient, Real};

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
pub(crate) const COS_EVEN: usize = 0;
pub(crate) const COS_ODD: usize = 1;
pub(crate) const SIN_EVEN: usize = 2;
pub(crate) const SIN_ODD: usize = 3;
const PLANES: usize = 4;

/// Columns folded at a time: twelve or sixteen planes of this many `f64` (32 KiB) stay in the first-level cache, or nearly so, while every `m`
/// passes over them.
pub(crate) const BLOCK: usize = 256;

/// Columns of a block that are folded by code of a known length, which alone the compiler turns into wide instructions where
/// some columns come in reverse. Of 16, 32 and 64 the quickest, by a tenth.
const TOGETHER: usize = 32;

/// The four planes of a block of columns of `N` lines, each a channel of a row, and the texels that are folded into them or unfolded from them: the
/// channels of the first row, then those of the second, and so on.
pub(crate) struct FoldedBlock<T, const N: usize> {
    planes: [[[f64; BLOCK]; N]; PLANES],
    quarters: [[[T; BLOCK]; N]; 4],
    /// Columns of the block.
    count: usize,
    /// Whether the planes differ; if not, all of them are the row itself.
    folded: bool,
}

impl<T: Real, const N: usize> FoldedBlock<T, N> {
    /// A block of zeros, of rows that are folded or not.
    pub(crate) fn new(folded: bool) -> Self {
        Self { planes: [[[0.0; BLOCK]; N]; PLANES], quarters: [[[T::ZERO; BLOCK]; N]; 4], count: 0, folded }
    }

    /// The lines of a plane.
    #[inline(always)]
    pub(crate) fn plane(&self, plane: usize) -> [&[f64]; N] {
        self.planes[if self.folded { plane } else { 0 }].each_ref().map(|line| &line[..self.count])
    }

    /// The lines of a plane to be written, of which as many columns count as the block has.
    #[inline(always)]
    pub(crate) fn plane_mut(&mut self, plane: usize) -> &mut [[f64; BLOCK]; N] {
        &mut self.planes[plane]
    }

    /// Begins a block of `count` columns, every plane of which is to be written.
    #[inline(always)]
    pub(crate) fn begin(&mut self, count: usize) {
        self.count = count;
    }

    /// Folds `count` columns from `start` on, of as many rows as there are lines for, or fewer.
    #[inline(always)]
    pub(crate) fn fold<C: Coefficient<Scalar = T>>(&mut self, rows: &[&[C]], start: usize, count: usize) {
        self.count = count;
        for (i, row) in rows.iter().enumerate() {
            let first = i * C::CHANNELS;
            if self.folded {
                let (left, right) = row.split_at(row.len() / 2);
                let end = left.len() - start;
                let columns = [&left[start..], &left[end - count..], &right[start..], &right[end - count..]];
                for (quarter, columns) in self.quarters.iter_mut().zip(columns) {
                    split(&columns[..count], &mut quarter[first..]);
                }
                for line in first..first + C::CHANNELS {
                    self.fold_channel(line);
                }
            } else {
                for (k, texel) in row[start..][..count].iter().enumerate() {
                    for c in 0..C::CHANNELS {
                        self.planes[0][first + c][k] = texel.channel(c).to_f64();
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn fold_channel(&mut self, channel: usize) {
        let count = self.count;
        let [a, b, c, d] = &self.quarters;
        let (a, b, c, d) = (&a[channel], &b[channel], &c[channel], &d[channel]);
        let whole = count - count % TOGETHER;
        for k in (0..whole).step_by(TOGETHER) {
            let mut folded = [[0.0; TOGETHER]; PLANES];
            if let (Some(a), Some(b), Some(c), Some(d)) = (
                a[k..].first_chunk::<TOGETHER>(),
                b[..count - k].last_chunk::<TOGETHER>(),
                c[k..].first_chunk::<TOGETHER>(),
                d[..count - k].last_chunk::<TOGETHER>(),
            ) {
                for i in 0..TOGETHER {
                    let mirrored = TOGETHER - 1 - i;
                    let values = fold([a[i], b[mirrored], c[i], d[mirrored]]);
                    for plane in 0..PLANES {
                        folded[plane][i] = values[plane];
                    }
                }
            }
            for plane in 0..PLANES {
                self.planes[plane][channel][k..][..TOGETHER].copy_from_slice(&folded[plane]);
            }
        }
        for k in whole..count {
            let values = fold([a[k], b[count - 1 - k], c[k], d[count - 1 - k]]);
            for plane in 0..PLANES {
                self.planes[plane][channel][k] = values[plane];
            }
        }
    }

    /// Writes the columns from `start` on, of rows as they are folded: the inverse of [`FoldedBlock::fold`], up to a factor of four.
    #[inline(always)]
    pub(crate) fn unfold<C: Coefficient<Scalar = T>>(&mut self, start: usize, rows: &mut [&mut [C]]) {
        let count = self.count;
        for (i, row) in rows.iter_mut().enumerate() {
            let first = i * C::CHANNELS;
            for line in first..first + C::CHANNELS {
                self.unfold_channel(line);
            }
            if self.folded {
                let (left, right) = row.split_at_mut(row.len() / 2);
                let end = left.len() - start;
                merge(&self.quarters[0][first..], &mut left[start..][..count]);
                merge(&self.quarters[1][first..], &mut left[end - count..][..count]);
                merge(&self.quarters[2][first..], &mut right[start..][..count]);
                merge(&self.quarters[3][first..], &mut right[end - count..][..count]);
            } else {
                merge(&self.quarters[0][first..], &mut row[start..][..count]);
            }
        }
    }

    #[inline(always)]
    fn unfold_channel(&mut self, channel: usize) {
        let count = self.count;
        let planes = &self.planes;
        let [a, b, c, d] = &mut self.quarters;
        let (a, b, c, d) = (&mut a[channel], &mut b[channel], &mut c[channel], &mut d[channel]);
        let whole = count - count % TOGETHER;
        for k in (0..whole).step_by(TOGETHER) {
            let mut folded = [[0.0; TOGETHER]; PLANES];
            for plane in 0..PLANES {
                folded[plane].copy_from_slice(&planes[plane][channel][k..][..TOGETHER]);
            }
            let mut quarters = [[T::ZERO; TOGETHER]; 4];
            for i in 0..TOGETHER {
                let mirrored = TOGETHER - 1 - i;
                [quarters[0][i], quarters[1][mirrored], quarters[2][i], quarters[3][mirrored]] =
                    unfold([folded[0][i], folded[1][i], folded[2][i], folded[3][i]]);
            }
            a[k..][..TOGETHER].copy_from_slice(&quarters[0]);
            b[..count - k][count - k - TOGETHER..].copy_from_slice(&quarters[1]);
            c[k..][..TOGETHER].copy_from_slice(&quarters[2]);
            d[..count - k][count - k - TOGETHER..].copy_from_slice(&quarters[3]);
        }
        for k in whole..count {
            let mirrored = count - 1 - k;
            let values = [planes[0][channel][k], planes[1][channel][k], planes[2][channel][k], planes[3][channel][k]];
            [a[k], b[mirrored], c[k], d[mirrored]] = unfold(values);
        }
    }
}

/// The four planes at the columns A, B, C, D.
#[inline(always)]
fn fold<T: Real>([a, b, c, d]: [T; 4]) -> [f64; PLANES] {
    let (a, b, c, d) = (a.to_f64(), b.to_f64(), c.to_f64(), d.to_f64());
    [(a + d) + (b + c), (a + d) - (b + c), (a - d) - (b - c), (a - d) + (b - c)]
}

/// The columns A, B, C, D of four planes.
#[inline(always)]
fn unfold<T: Real>([cos_even, cos_odd, sin_even, sin_odd]: [f64; PLANES]) -> [T; 4] {
    let (outer, inner) = (cos_even + cos_odd, cos_even - cos_odd);
    let (outer_sin, inner_sin) = (sin_even + sin_odd, sin_odd - sin_even);
    let columns = [outer + outer_sin, inner + inner_sin, inner - inner_sin, outer - outer_sin];
    columns.map(T::from_f64)
}

/// Texels as lines, one for each channel.
#[inline(always)]
fn split<C: Coefficient>(texels: &[C], lines: &mut [[C::Scalar; BLOCK]]) {
    // That no slice is longer than a block has to be seen here for wide instructions.
    let count = texels.len().min(BLOCK);
    if let [r, g, b, ..] = lines
        && C::CHANNELS == 3
    {
        let (texels, r, g, b) = (&texels[..count], &mut r[..count], &mut g[..count], &mut b[..count]);
        for k in 0..count {
            r[k] = texels[k].channel(0);
            g[k] = texels[k].channel(1);
            b[k] = texels[k].channel(2);
        }
    } else if let [line, ..] = lines {
        let (texels, line) = (&texels[..count], &mut line[..count]);
        for k in 0..count {
            line[k] = texels[k].channel(0);
        }
    }
}

/// Lines, one for each channel, as texels.
#[inline(always)]
fn merge<C: Coefficient>(lines: &[[C::Scalar; BLOCK]], texels: &mut [C]) {
    let count = texels.len().min(BLOCK);
    if let [r, g, b, ..] = lines
        && C::CHANNELS == 3
    {
        let (texels, r, g, b) = (&mut texels[..count], &r[..count], &g[..count], &b[..count]);
        for k in 0..count {
            let color = [r[k], g[k], b[k]];
            texels[k] = C::from_channels(|c| color[c]);
        }
    } else if let [line, ..] = lines {
        let (texels, line) = (&mut texels[..count], &line[..count]);
        for k in 0..count {
            texels[k] = C::splat(line[k]);
        }
    }
}
