//! Projection and reconstruction of lat-long maps at high orders.

use lobe_sh::simd::Machine;
use lobe_sh::{Basis, Coefficient as _, Rgb, ShVec, coefficient_index};
use rayon::prelude::*;

use crate::MappedMap;
use crate::projection::block_sums::{BLOCK, Blocks, LegendreSums, LegendreValues, ROW, WAVE};
use crate::projection::polar_grid::{Latitudes, PolarGrid};
use crate::projection::row_dft::RowDft;
use crate::projection::row_fft::{FftWork, RowFft};

/// The first order that is projected and reconstructed here.
pub(crate) const FIRST_HIGH_ORDER: usize = 17;

/// Pairs of mirrored rows that are transformed together: few enough for their sums of order 256 to stay in the second-level cache and
/// for the system not to be asked for pages anew for each of them.
const PAIRS_TOGETHER: usize = 4;

/// Pairs of columns that share the passes over the tables.
const COLUMNS_TOGETHER: usize = 4;

/// The highest orders at which rows of a width that is a multiple of four are summed term by term, which takes a time
/// proportional to them, in projection and reconstruction; above, FFT is quicker (2048 columns, one AVX-512 core).
const DIRECT_ORDERS: [usize; 2] = [60, 24];

/// The transform along rows, one or the other.
enum RowTransform {
    Direct(RowDft),
    Fft(RowFft),
}

impl RowTransform {
    fn new(width: usize, order: usize, highest_direct: usize) -> Self {
        // Other widths have no quarters to be folded: four times the work.
        let direct = if width.is_multiple_of(4) { highest_direct } else { highest_direct / 4 };
        if order <= direct { Self::Direct(RowDft::new(width, order)) } else { Self::Fft(RowFft::new(width, order)) }
    }

    fn work(&self) -> Option<FftWork> {
        match self {
            Self::Direct(_) => None,
            Self::Fft(fft) => Some(fft.work()),
        }
    }

    /// The sums of each row, `[cos, sin]` for every `m < order`.
    fn sums_into(&self, rows: &[&[Rgb<f32>]], order: usize, work: &mut RowWork) {
        work.sums.clear();
        work.sums.resize(rows.len() * order, [Rgb::ZERO; 2]);
        match (self, &mut work.fft) {
            (Self::Fft(fft), Some(work_of_fft)) => {
                for (rows, sums) in rows.chunks_exact(2).zip(work.sums.chunks_exact_mut(2 * order)) {
                    let (upper, lower) = sums.split_at_mut(order);
                    fft.sums_into([rows[0], rows[1]], [upper, lower], work_of_fft);
                }
            }
            (Self::Direct(dft), _) => dft.add_sums(rows, &mut work.sums),
            (Self::Fft(_), None) => {}
        }
    }
}

/// The scratch space of one thread.
struct RowWork {
    fft: Option<FftWork>,
    sums: Vec<[Rgb<f64>; 2]>,
}

/// The constants of column `m` of the basis.
fn column_constants(order: usize, m: usize) -> (f64, Vec<[f64; 3]>) {
    Basis::<f64>::with_shared(order, |basis| (basis.diagonal(m), (m + 1..order).map(|l| basis.step(m, l)).collect()))
}

/// Numbers `[cos r, g, b, sin r, g, b]`.
fn flat([cos, sin]: [Rgb<f64>; 2]) -> [f64; WAVE] {
    [cos.r, cos.g, cos.b, sin.r, sin.g, sin.b]
}

/// The coefficients of the map, `columns` being the integrals of `cos mφ` over a column relative to its middle.
pub(crate) fn project_high(map: &MappedMap, columns: &[f64]) -> ShVec<Rgb<f64>> {
    let order = columns.len();
    let chunks = row_sums(map, columns);
    let grid = PolarGrid::new(order, map.height());
    // Two m of the same parity share the registers, several such pairs a block of a table in the cache.
    let groups: Vec<Vec<usize>> = [0, 1]
        .into_iter()
        .flat_map(|parity| {
            let firsts: Vec<usize> = (parity..order).step_by(4).collect();
            firsts.chunks(COLUMNS_TOGETHER).map(<[usize]>::to_vec).collect::<Vec<_>>()
        })
        .collect();
    let found: Vec<Vec<[Vec<[f64; WAVE]>; 2]>> =
        groups.par_iter().map(|firsts| column_pairs(&grid, &chunks, map.height().div_ceil(2), order, firsts)).collect();
    let mut f = ShVec::zero(order);
    for (first, pair) in groups.into_iter().flatten().zip(found.into_iter().flatten()) {
        for (m, column) in [first, first + 2].into_iter().zip(pair) {
            for (l, [r, g, b, sin @ ..]) in (m..).zip(column) {
                f[coefficient_index(l, -(m as isize))] = Rgb::from(sin);
                f[coefficient_index(l, m as isize)] = Rgb::new(r, g, b);
            }
        }
    }
    f
}

/// Sums and differences of mirrored rows: for each chunk of pairs, for each `m`, for each pair the [`flat`] sums and then the
/// differences.
fn row_sums(map: &MappedMap, columns: &[f64]) -> Vec<Vec<[f64; ROW]>> {
    let (order, pairs) = (columns.len(), map.height().div_ceil(2));
    let transform = RowTransform::new(map.width(), order, DIRECT_ORDERS[0]);
    let chunk = |work: &mut RowWork, c: usize| {
        let pairs = c * PAIRS_TOGETHER..pairs.min((c + 1) * PAIRS_TOGETHER);
        let mirrored = |y: usize| map.height() - 1 - y;
        let rows: Vec<_> = pairs.clone().flat_map(|y| [map.row(y), map.row(mirrored(y))]).collect();
        transform.sums_into(&rows, order, work);
        let mut chunk = Vec::with_capacity(order * pairs.len());
        for (m, scale) in columns.iter().enumerate() {
            for (y, sums) in pairs.clone().zip(work.sums.chunks_exact(2 * order)) {
                let (upper, lower) = (flat(sums[m]), flat(sums[order + m]));
                // The middle row of an odd number is its own mirror image: count it once.
                let twice = if y == mirrored(y) { 0.0 } else { 1.0 };
                chunk.push(std::array::from_fn(|i| match i.checked_sub(WAVE) {
                    None => scale * (upper[i] + twice * lower[i]),
                    Some(i) => scale * twice * (upper[i] - lower[i]),
                }));
            }
        }
        chunk
    };
    let work = || RowWork { fft: transform.work(), sums: Vec::new() };
    (0..pairs.div_ceil(PAIRS_TOGETHER)).into_par_iter().map_init(work, chunk).collect()
}

/// The coefficients of `m` and `m + 2` for each first of such a pair, all of one parity; empty where the order ends before.
fn column_pairs(
    grid: &PolarGrid,
    chunks: &[Vec<[f64; ROW]>],
    pairs: usize,
    order: usize,
    firsts: &[usize],
) -> Vec<[Vec<[f64; WAVE]>; 2]> {
    let machine = Machine::detect();
    let parity = firsts.first().map_or(0, |first| first % 2);
    let [sums, differences] = [0, 1].map(|odd| {
        let rows: Vec<_> = firsts.iter().map(|first| rows_of(chunks, [pairs, order], *first, odd)).collect();
        grid.resample(machine, [parity, odd], &rows)
    });
    let mut work = vec![[[0.0; BLOCK]; 2]; grid.latitudes.blocks()];
    let mut columns = Vec::with_capacity(firsts.len());
    for (first, (mut even, mut odd)) in firsts.iter().zip(sums.into_iter().zip(differences)) {
        columns.push([*first, first + 2].map(|m| {
            if m >= order {
                return Vec::new();
            }
            let offset = (m - first) / 2 * WAVE;
            for x in [&mut even, &mut odd] {
                grid.latitudes.scale_by_power(m, x, offset..offset + WAVE);
            }
            let (diagonal, steps) = column_constants(order, m);
            let mut sums = vec![[0.0; WAVE]; order - m];
            let column = grid.latitudes.column(diagonal, &steps);
            machine.run(LegendreSums { column, x: [&even, &odd], offset, work: &mut work, sums: &mut sums });
            sums
        }));
    }
    columns
}

/// The sums (0) or differences (1) of all pairs of rows, for `m` and `m + 2`.
fn rows_of(chunks: &[Vec<[f64; ROW]>], [pairs, order]: [usize; 2], first: usize, odd: usize) -> Vec<[f64; ROW]> {
    let mut rows = vec![[0.0; ROW]; pairs];
    for (i, m) in [first, first + 2].into_iter().enumerate().filter(|(_, m)| *m < order) {
        for (chunk, rows) in chunks.iter().zip(rows.chunks_mut(PAIRS_TOGETHER)) {
            for (from, row) in chunk[m * rows.len()..].iter().zip(rows) {
                row[i * WAVE..][..WAVE].copy_from_slice(&from[odd * WAVE..][..WAVE]);
            }
        }
    }
    rows
}

/// The values of the expansion towards the centers of the texels of a map of `width` x `height`, row after row.
pub(crate) fn reconstruct_high(f: &ShVec<Rgb<f64>>, order: usize, width: usize, height: usize) -> Vec<Rgb<f32>> {
    let latitudes = Latitudes::new(height);
    let waves: Vec<Vec<Blocks>> = (0..order).into_par_iter().map(|m| waves_of(f, order, &latitudes, m)).collect();
    let transform = RowTransform::new(width, order, DIRECT_ORDERS[1]);
    let mut texels = vec![Rgb::ZERO; width * height];
    let (top, bottom) = texels.split_at_mut(height.div_ceil(2) * width);
    let mut lower: Vec<_> = bottom.chunks_exact_mut(width).rev().map(Some).collect();
    lower.resize_with(height.div_ceil(2), || None);
    let mut pairs: Vec<_> = top.chunks_exact_mut(width).zip(lower).collect();
    let work = || RowWork { fft: transform.work(), sums: vec![[Rgb::ZERO; 2]; 2 * BLOCK * (order + 1)] };
    let rows = |work: &mut RowWork, (b, pairs): (usize, &mut [RowPair<'_>])| {
        rows_of_block(&waves, &transform, b, pairs, work);
    };
    pairs.par_chunks_mut(BLOCK).enumerate().for_each_init(work, rows);
    texels
}

/// `Σ_l f_lm P̃_l^m` at all latitudes: cosines and sines of even `l - m`, then of odd.
fn waves_of(f: &ShVec<Rgb<f64>>, order: usize, latitudes: &Latitudes, m: usize) -> Vec<Blocks> {
    let (diagonal, steps) = column_constants(order, m);
    let of_band = |l: usize| {
        let sin = if m > 0 { f[coefficient_index(l, -(m as isize))] } else { Rgb::ZERO };
        flat([f[coefficient_index(l, m as isize)], sin])
    };
    let f: Vec<[f64; WAVE]> = (m..order).map(of_band).collect();
    let mut values = vec![[[0.0; BLOCK]; ROW]; latitudes.blocks()];
    let column = latitudes.column(diagonal, &steps);
    Machine::detect().run(LegendreValues { column, f: &f, values: &mut values });
    latitudes.scale_by_power(m, &mut values, 0..ROW);
    values
}

/// A row and its mirror image, which the middle row of an odd number does not have.
type RowPair<'a> = (&'a mut [Rgb<f32>], Option<&'a mut [Rgb<f32>]>);

fn rows_of_block(
    waves: &[Vec<Blocks>],
    transform: &RowTransform,
    b: usize,
    pairs: &mut [RowPair<'_>],
    work: &mut RowWork,
) {
    let order = waves.len();
    // One place more for each row: lines of the cache that are written together must not lie a power of two apart.
    let stride = order + 1;
    let (upper, lower) = work.sums.split_at_mut(BLOCK * stride);
    for (m, blocks) in waves.iter().enumerate() {
        let block = &blocks[b];
        for k in 0..pairs.len() {
            let wave = |sign: f64| {
                let value = |c: usize| block[c][k] + sign * block[WAVE + c][k];
                [Rgb::new(value(0), value(1), value(2)), Rgb::new(value(3), value(4), value(5))]
            };
            (upper[k * stride + m], lower[k * stride + m]) = (wave(1.0), wave(-1.0));
        }
    }
    let mut unused = vec![Rgb::ZERO; pairs.first().map_or(0, |(row, _)| row.len())];
    for (k, (top, bottom)) in pairs.iter_mut().enumerate() {
        let waves = [&upper[k * stride..][..order], &lower[k * stride..][..order]];
        match (transform, &mut work.fft) {
            (RowTransform::Fft(fft), Some(work)) => {
                fft.synthesize_into(waves, [top, bottom.as_deref_mut().unwrap_or(&mut unused)], work);
            }
            (RowTransform::Direct(dft), _) => {
                dft.synthesise_into(waves[0], top);
                if let Some(bottom) = bottom {
                    dft.synthesise_into(waves[1], bottom);
                }
            }
            (RowTransform::Fft(_), None) => {}
        }
    }
}
