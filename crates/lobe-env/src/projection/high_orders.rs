//! Projection and reconstruction of lat-long maps at high orders.

use lobe_io::parallel;
use lobe_sh::simd::Machine;
use lobe_sh::{Basis, Coefficient, Expansion, ShVec, coefficient_index};

use crate::projection::block_sums::{BLOCK, LegendreSums, LegendreValues, ROW, WAVE, WaveBlocks};
use crate::projection::lat_long_rows::LatLongRows;
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

    fn work(&self, channels: usize) -> Option<FftWork> {
        match self {
            Self::Direct(_) => None,
            Self::Fft(fft) => Some(fft.work(channels)),
        }
    }

    /// The sums of each row, `[cos, sin]` for every `m < order`.
    fn sums_into<C: Coefficient>(&self, rows: &[&[C]], order: usize, work: &mut RowWork<C::Wide>) {
        work.sums.clear();
        work.sums.resize(rows.len() * order, [C::Wide::ZERO; 2]);
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
struct RowWork<W> {
    fft: Option<FftWork>,
    sums: Vec<[W; 2]>,
}

/// The constants of column `m` of the basis.
fn column_constants(order: usize, m: usize) -> (f64, Vec<[f64; 3]>) {
    Basis::<f64>::with_shared(order, |basis| (basis.diagonal(m), (m + 1..order).map(|l| basis.step(m, l)).collect()))
}

/// Numbers `[cos, sin]`, of colors `[cos r, g, b, sin r, g, b]`.
fn flat<W: Coefficient<Scalar = f64>, const WAVE: usize>([cos, sin]: [W; 2]) -> [f64; WAVE] {
    std::array::from_fn(|i| if i < W::CHANNELS { cos.channel(i) } else { sin.channel(i - W::CHANNELS) })
}

/// The coefficients of the map, `columns` being the integrals of `cos mφ` over a column relative to its middle.
pub(crate) fn project_high<C: Coefficient>(rows: LatLongRows<'_, C>, columns: &[f64]) -> ShVec<C::Wide> {
    if C::CHANNELS == 1 {
        project_waves::<C, { WAVE[0] }>(rows, columns)
    } else {
        project_waves::<C, { WAVE[1] }>(rows, columns)
    }
}

/// The same with as many numbers a wave.
fn project_waves<C: Coefficient, const WAVE: usize>(rows: LatLongRows<'_, C>, columns: &[f64]) -> ShVec<C::Wide> {
    let order = columns.len();
    let chunks = row_sums::<C, WAVE>(rows, columns);
    let grid = PolarGrid::new(order, rows.height());
    // Some m of the same parity share the registers, several such sets a block of a table in the cache.
    let groups: Vec<Vec<usize>> = [0, 1]
        .into_iter()
        .flat_map(|parity| {
            let firsts: Vec<usize> = (parity..order).step_by(2 * ROW / WAVE).collect();
            firsts.chunks(COLUMNS_TOGETHER).map(<[usize]>::to_vec).collect::<Vec<_>>()
        })
        .collect();
    let pairs = rows.height().div_ceil(2);
    let found: Vec<Vec<Vec<[f64; WAVE]>>> =
        parallel::map(groups.len(), &|k| column_sets(&grid, &chunks, pairs, order, &groups[k]));
    let mut f = ShVec::zero(order);
    let columns = groups.iter().flatten().flat_map(|first| columns_from::<WAVE>(*first, order));
    for (m, column) in columns.zip(found.into_iter().flatten()) {
        for (l, wave) in (m..).zip(column) {
            f[coefficient_index(l, -(m as isize))] = C::Wide::from_channels(|c| wave[C::CHANNELS + c]);
            f[coefficient_index(l, m as isize)] = C::Wide::from_channels(|c| wave[c]);
        }
    }
    f
}

/// The `m` that share the registers with the first of them.
fn columns_from<const WAVE: usize>(first: usize, order: usize) -> impl Iterator<Item = usize> {
    (first..order).step_by(2).take(ROW / WAVE)
}

/// For a pair of mirrored rows the sums and the differences.
type SumsAndDifferences<const WAVE: usize> = [[f64; WAVE]; 2];

/// Sums and differences of mirrored rows: for each chunk of pairs, for each `m`, for each pair.
fn row_sums<C: Coefficient, const WAVE: usize>(
    rows: LatLongRows<'_, C>,
    columns: &[f64],
) -> Vec<Vec<SumsAndDifferences<WAVE>>> {
    let (order, pairs) = (columns.len(), rows.height().div_ceil(2));
    let transform = RowTransform::new(rows.width(), order, DIRECT_ORDERS[0]);
    let chunk = |work: &mut RowWork<C::Wide>, c: usize| {
        let pairs = c * PAIRS_TOGETHER..pairs.min((c + 1) * PAIRS_TOGETHER);
        let mirrored = |y: usize| rows.height() - 1 - y;
        let both: Vec<_> = pairs.clone().flat_map(|y| [rows.row(y), rows.row(mirrored(y))]).collect();
        transform.sums_into(&both, order, work);
        let mut chunk = Vec::with_capacity(order * pairs.len());
        for (m, scale) in columns.iter().enumerate() {
            for (y, sums) in pairs.clone().zip(work.sums.chunks_exact(2 * order)) {
                let (upper, lower): ([f64; WAVE], [f64; WAVE]) = (flat(sums[m]), flat(sums[order + m]));
                // The middle row of an odd number is its own mirror image: count it once.
                let twice = if y == mirrored(y) { 0.0 } else { 1.0 };
                chunk.push([
                    std::array::from_fn(|i| scale * (upper[i] + twice * lower[i])),
                    std::array::from_fn(|i| scale * twice * (upper[i] - lower[i])),
                ]);
            }
        }
        chunk
    };
    let work = || RowWork { fft: transform.work(C::CHANNELS), sums: Vec::new() };
    parallel::map_with(pairs.div_ceil(PAIRS_TOGETHER), &work, &chunk)
}

/// The coefficients of the `m` of each set, all of one parity.
fn column_sets<const WAVE: usize>(
    grid: &PolarGrid,
    chunks: &[Vec<SumsAndDifferences<WAVE>>],
    pairs: usize,
    order: usize,
    firsts: &[usize],
) -> Vec<Vec<[f64; WAVE]>> {
    let machine = Machine::detect();
    let parity = firsts.first().map_or(0, |first| first % 2);
    let [sums, differences] = [0, 1].map(|odd| {
        let rows: Vec<_> = firsts.iter().map(|first| rows_of(chunks, [pairs, order], *first, odd)).collect();
        grid.resample(machine, [parity, odd], &rows)
    });
    let mut work = vec![[[0.0; BLOCK]; 2]; grid.latitudes.blocks()];
    let mut columns = Vec::new();
    for (first, (mut even, mut odd)) in firsts.iter().zip(sums.into_iter().zip(differences)) {
        for (i, m) in columns_from::<WAVE>(*first, order).enumerate() {
            let offset = i * WAVE;
            for x in [&mut even, &mut odd] {
                grid.latitudes.scale_by_power(m, x.iter_mut().map(|block| &mut block[offset..][..WAVE]));
            }
            let (diagonal, steps) = column_constants(order, m);
            let mut sums = vec![[0.0; WAVE]; order - m];
            let column = grid.latitudes.column(diagonal, &steps);
            machine.run(LegendreSums { column, x: [&even, &odd], offset, work: &mut work, sums: &mut sums });
            columns.push(sums);
        }
    }
    columns
}

/// The sums (0) or differences (1) of all pairs of rows, for the `m` of a set.
fn rows_of<const WAVE: usize>(
    chunks: &[Vec<SumsAndDifferences<WAVE>>],
    [pairs, order]: [usize; 2],
    first: usize,
    odd: usize,
) -> Vec<[f64; ROW]> {
    let mut rows = vec![[0.0; ROW]; pairs];
    for (i, m) in columns_from::<WAVE>(first, order).enumerate() {
        for (chunk, rows) in chunks.iter().zip(rows.chunks_mut(PAIRS_TOGETHER)) {
            for (from, row) in chunk[m * rows.len()..].iter().zip(rows) {
                row[i * WAVE..][..WAVE].copy_from_slice(&from[odd]);
            }
        }
    }
    rows
}

/// The values of the expansion towards the centers of the texels of a map of as many columns as `width`, row after row.
pub(crate) fn reconstruct_high<C: Coefficient>(f: &ShVec<C::Wide>, width: usize, texels: &mut [C]) {
    if C::CHANNELS == 1 {
        reconstruct_waves::<C, { WAVE[0] }>(f, width, texels);
    } else {
        reconstruct_waves::<C, { WAVE[1] }>(f, width, texels);
    }
}

/// The same with as many numbers a wave.
fn reconstruct_waves<C: Coefficient, const WAVE: usize>(f: &ShVec<C::Wide>, width: usize, texels: &mut [C]) {
    let (order, height) = (Expansion::order(f), texels.len() / width);
    let latitudes = Latitudes::new(height);
    let waves: Vec<Vec<WaveBlocks<WAVE>>> = parallel::map(order, &|m| waves_of(f, order, &latitudes, m));
    let transform = RowTransform::new(width, order, DIRECT_ORDERS[1]);
    let (top, bottom) = texels.split_at_mut(height.div_ceil(2) * width);
    let mut lower: Vec<_> = bottom.chunks_exact_mut(width).rev().map(Some).collect();
    lower.resize_with(height.div_ceil(2), || None);
    let mut pairs: Vec<_> = top.chunks_exact_mut(width).zip(lower).collect();
    let work = || RowWork { fft: transform.work(C::CHANNELS), sums: vec![[C::Wide::ZERO; 2]; 2 * BLOCK * (order + 1)] };
    parallel::rows_with(&mut pairs, BLOCK, &work, &|work: &mut RowWork<C::Wide>, b, pairs| {
        rows_of_block(&waves, &transform, b, pairs, work);
    });
}

/// `Σ_l f_lm P̃_l^m` at all latitudes: cosines and sines of even `l - m`, then of odd.
fn waves_of<W: Coefficient<Scalar = f64>, const WAVE: usize>(
    f: &ShVec<W>,
    order: usize,
    latitudes: &Latitudes,
    m: usize,
) -> Vec<WaveBlocks<WAVE>> {
    let (diagonal, steps) = column_constants(order, m);
    let of_band = |l: usize| {
        let sin = if m > 0 { f[coefficient_index(l, -(m as isize))] } else { W::ZERO };
        flat([f[coefficient_index(l, m as isize)], sin])
    };
    let f: Vec<[f64; WAVE]> = (m..order).map(of_band).collect();
    let mut values = vec![[[[0.0; BLOCK]; WAVE]; 2]; latitudes.blocks()];
    let column = latitudes.column(diagonal, &steps);
    Machine::detect().run(LegendreValues { column, f: &f, values: &mut values });
    latitudes.scale_by_power(m, values.iter_mut().map(|block| block.as_flattened_mut()));
    values
}

/// A row and its mirror image, which the middle row of an odd number does not have.
type RowPair<'a, C> = (&'a mut [C], Option<&'a mut [C]>);

fn rows_of_block<C: Coefficient, const WAVE: usize>(
    waves: &[Vec<WaveBlocks<WAVE>>],
    transform: &RowTransform,
    b: usize,
    pairs: &mut [RowPair<'_, C>],
    work: &mut RowWork<C::Wide>,
) {
    let order = waves.len();
    // One place more for each row: lines of the cache that are written together must not lie a power of two apart.
    let stride = order + 1;
    let (upper, lower) = work.sums.split_at_mut(BLOCK * stride);
    for (m, blocks) in waves.iter().enumerate() {
        let [even, odd] = &blocks[b];
        for k in 0..pairs.len() {
            let wave = |sign: f64| {
                let value = |c: usize| even[c][k] + sign * odd[c][k];
                [C::Wide::from_channels(value), C::Wide::from_channels(|c| value(C::CHANNELS + c))]
            };
            (upper[k * stride + m], lower[k * stride + m]) = (wave(1.0), wave(-1.0));
        }
    }
    match (transform, &mut work.fft) {
        (RowTransform::Fft(fft), Some(work)) => {
            let mut unused = vec![C::ZERO; pairs.first().map_or(0, |(row, _)| row.len())];
            for (k, (top, bottom)) in pairs.iter_mut().enumerate() {
                let waves = [&upper[k * stride..][..order], &lower[k * stride..][..order]];
                fft.synthesize_into(waves, [top, bottom.as_deref_mut().unwrap_or(&mut unused)], work);
            }
        }
        (RowTransform::Direct(dft), _) => {
            let mut rows = Vec::with_capacity(2 * BLOCK);
            let mut waves = Vec::with_capacity(2 * BLOCK);
            for (k, (top, bottom)) in pairs.iter_mut().enumerate() {
                rows.push(&mut **top);
                waves.push(&upper[k * stride..][..order]);
                if let Some(bottom) = bottom {
                    rows.push(&mut **bottom);
                    waves.push(&lower[k * stride..][..order]);
                }
            }
            dft.synthesise_into(&waves, &mut rows);
        }
        (RowTransform::Fft(_), None) => {}
    }
}
