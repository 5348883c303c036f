//! Dot products of many rows with one light, in explicit SIMD lanes.
//!
//! Rationale
//! - One vector for all colors: eight rows are turned into columns, so that a lane sums a row, a coefficient of the light is multiplied with
//!   eight numbers, and no sum is spread over lanes. With a color in the lanes instead, one of four of which is idle, a receiver of order
//!   4 takes 32 operations; so it takes 12, and 6 to turn it.
//! - A vector for each color: three times as many numbers would have to be turned for the same sums, and turning takes longer than
//!   summing. The lanes sum every eighth place of a row.
//! - Every sum has an order that neither the width of the machine's registers nor the number of threads changes, and nothing is fused, so
//!   the bytes are the same everywhere. Wider instructions are taken where the machine has them.

use lobe_io::parallel;
use lobe_sh::Rgb;

use crate::transfer::number::Number;
use crate::transfer::simd::{EIGHT, FOUR, Lanes, Machine, Work};

/// Receivers that a thread takes at a time: their rows fit the second-level cache, and handing them out costs nothing.
pub(crate) const CHUNK: usize = 4096;

/// The light's coefficients of the first `len` places, black beyond its own.
pub(crate) fn light_of_len(light: &[Rgb<f64>], len: usize) -> Vec<Rgb<f32>> {
    let narrow = |l: &Rgb<f64>| Rgb::new(l.r as f32, l.g as f32, l.b as f32);
    let mut light: Vec<_> = light.iter().take(len).map(narrow).collect();
    light.resize(len, Rgb::new(0.0, 0.0, 0.0));
    light
}

/// The exit radiance of rows of `channels · order²` numbers; see
/// [`Transfer::exit_radiance`](crate::Transfer::exit_radiance).
///
/// # Panics
/// If the order is not 1 to 8, or `out` has not one place for each row.
pub(crate) fn exit_radiance<T: Number>(
    rows: &[T],
    order: usize,
    channels: usize,
    light: &[Rgb<f64>],
    out: &mut [Rgb<f32>],
) {
    let width = order * order * channels;
    assert_eq!(rows.len(), width * out.len(), "one place for each receiver");
    let light = light_of_len(light, order * order);
    let machine = Machine::detect();
    parallel::rows(out, CHUNK, &|chunk, out| {
        let rows = &rows[chunk * CHUNK * width..][..out.len() * width];
        machine.run(RowsOfChunk { rows, order, channels, light: &light, out });
    });
}

/// The light that arrives at points by matrices of `channels · order⁴` numbers; see
/// [`TransferMatrices::incident_into`](crate::TransferMatrices::incident_into).
///
/// # Panics
/// If the order is not 1 to 8, or `out` has not `order²` places for each matrix.
pub(crate) fn incident(matrices: &[f32], order: usize, channels: usize, light: &[Rgb<f64>], out: &mut [Rgb<f32>]) {
    if channels == 1 {
        // Each row is one vector for all colors.
        return exit_radiance(matrices, order, 1, light, out);
    }
    let bands = order * order;
    assert_eq!(matrices.len(), channels * bands * out.len(), "n² places for each point");
    let light = light_of_len(light, bands);
    let machine = Machine::detect();
    let points = (CHUNK / bands).max(1);
    parallel::rows(out, points * bands, &|chunk, out| {
        let matrices = &matrices[chunk * points * channels * bands * bands..][..out.len() * channels * bands];
        machine.run(MatricesOfChunk { matrices, order, light: &light, out });
    });
}

struct MatricesOfChunk<'a> {
    matrices: &'a [f32],
    order: usize,
    light: &'a [Rgb<f32>],
    out: &'a mut [Rgb<f32>],
}

impl Work for MatricesOfChunk<'_> {
    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) {
        let Self { matrices, order, light, out } = self;
        macro_rules! by_order {
            ($($order:literal)*) => {
                match order {
                    $($order => rgb_matrices::<L, { $order * $order }>(lanes, matrices, light, out),)*
                    _ => unreachable!("matrices of order {order}"),
                }
            };
        }
        by_order!(1 2 3 4 5 6 7 8);
    }
}

/// A matrix for each color: `out[p][i].c = Σ_j matrices[p][c][i][j] light[j].c`.
#[inline(always)]
fn rgb_matrices<L: Lanes, const N: usize>(lanes: L, matrices: &[f32], light: &[Rgb<f32>], out: &mut [Rgb<f32>]) {
    let planes = planes_of::<N>(light);
    let points = matrices.as_chunks::<N>().0.chunks_exact(3 * N).zip(out.as_chunks_mut::<N>().0);
    for (rows, out) in points {
        for (i, out) in out.iter_mut().enumerate() {
            *out = dot(lanes, std::array::from_fn(|c| &rows[c * N + i]), &planes);
        }
    }
}

/// The light, color by color.
#[inline(always)]
fn planes_of<const N: usize>(light: &[Rgb<f32>]) -> [[f32; N]; 3] {
    std::array::from_fn(|c| std::array::from_fn(|i| [light[i].r, light[i].g, light[i].b][c]))
}

/// Rows of a thread.
struct RowsOfChunk<'a, T> {
    rows: &'a [T],
    order: usize,
    channels: usize,
    light: &'a [Rgb<f32>],
    out: &'a mut [Rgb<f32>],
}

impl<T: Number> Work for RowsOfChunk<'_, T> {
    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) {
        let Self { rows, order, channels, light, out } = self;
        macro_rules! by_order {
            ($($order:literal)*) => {
                match (order, channels) {
                    $(($order, 1) => gray_rows::<L, T, { $order * $order }>(lanes, rows, light, out),
                    ($order, 3) => rgb_rows::<L, T, { $order * $order }>(lanes, rows, light, out),)*
                    _ => unreachable!("transfer of order {order} in {channels} channels"),
                }
            };
        }
        by_order!(1 2 3 4 5 6 7 8);
    }
}

/// One vector for all colors: `out[r].c = Σ_i rows[r][i] light[i].c`, summed in the order of `i`.
#[inline(always)]
fn gray_rows<L: Lanes, T: Number, const N: usize>(lanes: L, rows: &[T], light: &[Rgb<f32>], out: &mut [Rgb<f32>]) {
    let planes = planes_of::<N>(light);
    let (eights, last_rows) = rows.as_chunks::<N>().0.as_chunks::<EIGHT>();
    let (outs, last_outs) = out.as_chunks_mut::<EIGHT>();
    for (rows, out) in eights.iter().zip(outs) {
        store_colors(lanes, eight_colors(lanes, rows, &planes), out);
    }
    for (row, out) in last_rows.iter().zip(last_outs) {
        let sum = |plane: &[f32; N]| row.iter().zip(plane).fold(0.0, |sum, (t, l)| sum + t.single() * l);
        let [r, g, b] = planes.each_ref().map(sum);
        *out = Rgb::new(r, g, b);
    }
}

/// Eight colors from the lanes of their channels.
#[inline(always)]
pub(crate) fn store_colors<L: Lanes>(lanes: L, channels: [L::Wide; 3], out: &mut [Rgb<f32>; EIGHT]) {
    let numbers = lanes.store_colors(channels);
    for (out, [r, g, b]) in out.iter_mut().zip(numbers.as_chunks::<3>().0) {
        *out = Rgb::new(*r, *g, *b);
    }
}

/// The sums of eight rows, a row in each lane, for each color of the light.
#[inline(always)]
fn eight_colors<L: Lanes, T: Number, const N: usize>(
    lanes: L,
    rows: &[[T; N]; EIGHT],
    planes: &[[f32; N]; 3],
) -> [L::Wide; 3] {
    let mut sums = [lanes.splat_wide(0.0); 3];
    for block in 0..N / EIGHT {
        let mut square = [&rows[0].as_chunks::<EIGHT>().0[block]; EIGHT];
        for k in 1..EIGHT {
            square[k] = &rows[k].as_chunks::<EIGHT>().0[block];
        }
        let columns = T::columns(lanes, square);
        for i in 0..EIGHT {
            add_column(lanes, &mut sums, planes, EIGHT * block + i, columns[i]);
        }
    }
    if N % EIGHT >= FOUR {
        let mut half = [&rows[0].as_chunks::<FOUR>().0[N / EIGHT * 2]; EIGHT];
        for k in 1..EIGHT {
            half[k] = &rows[k].as_chunks::<FOUR>().0[N / EIGHT * 2];
        }
        let columns = T::four_columns(lanes, half);
        for i in 0..FOUR {
            add_column(lanes, &mut sums, planes, N / EIGHT * EIGHT + i, columns[i]);
        }
    }
    for i in N - N % FOUR..N {
        let mut column = [0.0; EIGHT];
        for k in 0..EIGHT {
            column[k] = rows[k][i].single();
        }
        add_column(lanes, &mut sums, planes, i, lanes.load_wide(&column));
    }
    sums
}

/// A function: long closures are compiled by themselves, without the instructions of the lanes, which made order 6 five
/// times as slow as with a vector for each color.
#[inline(always)]
fn add_column<L: Lanes, const N: usize>(
    lanes: L,
    sums: &mut [L::Wide; 3],
    planes: &[[f32; N]; 3],
    i: usize,
    column: L::Wide,
) {
    for c in 0..3 {
        sums[c] = lanes.add_product_wide(sums[c], column, lanes.splat_wide(planes[c][i]));
    }
}

/// A vector for each color: `out[r].c = Σ_i rows[r][c][i] light[i].c`.
#[inline(always)]
fn rgb_rows<L: Lanes, T: Number, const N: usize>(lanes: L, rows: &[T], light: &[Rgb<f32>], out: &mut [Rgb<f32>]) {
    let planes = planes_of::<N>(light);
    let rows = rows.as_chunks::<N>().0.as_chunks::<3>().0;
    for (row, out) in rows.iter().zip(out) {
        *out = dot(lanes, row.each_ref(), &planes);
    }
}

/// The scalar product of each color, in eight partial sums over every eighth place. `N = n²` is a multiple of eight, or one or four
/// more: the more are the first, by themselves.
#[inline(always)]
fn dot<L: Lanes, T: Number, const N: usize>(lanes: L, rows: [&[T; N]; 3], planes: &[[f32; N]; 3]) -> Rgb<f32> {
    let mut sums = [lanes.splat_wide(0.0); 3];
    let mut starts = [0.0; 3];
    for c in 0..3 {
        let (first, rest) = rows[c].split_at(N % EIGHT);
        let (light_first, light_rest) = planes[c].split_at(N % EIGHT);
        for (t, l) in rest.as_chunks::<EIGHT>().0.iter().zip(light_rest.as_chunks::<EIGHT>().0) {
            sums[c] = lanes.add_product_wide(sums[c], T::wide(lanes, t), lanes.load_wide(l));
        }
        starts[c] = first.iter().zip(light_first).fold(0.0, |sum, (t, l)| sum + t.single() * l);
    }
    let [r, g, b] = lanes.sums(sums);
    Rgb::new(starts[0] + r, starts[1] + g, starts[2] + b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    /// The same sums one after the other, in `f64`.
    fn slowly(rows: &[f32], n: usize, channels: usize, light: &[Rgb<f64>]) -> Vec<Rgb<f64>> {
        let one = |row: &[f32]| {
            let channel = |c: usize, of: fn(&Rgb<f64>) -> f64| {
                let vector = &row[c.min(channels - 1) * n..][..n];
                vector.iter().zip(light).map(|(t, l)| f64::from(*t) * of(l)).sum::<f64>()
            };
            Rgb::new(channel(0, |l| l.r), channel(1, |l| l.g), channel(2, |l| l.b))
        };
        rows.chunks(n * channels).map(one).collect()
    }

    #[test]
    fn fast_sums_are_the_slow_ones_for_every_order_and_count() {
        let mut random = Random::new(1);
        for order in 1..=8 {
            for channels in [1, 3] {
                for count in [0, 1, 3, 4, 9, CHUNK + 5] {
                    let n = order * order;
                    let rows: Vec<f32> = random.signed_vec(n * channels * count).iter().map(|x| *x as f32).collect();
                    let light: Vec<_> =
                        (0..n).map(|_| Rgb::new(random.signed(), random.signed(), random.signed())).collect();
                    let mut out = vec![Rgb::new(f32::NAN, f32::NAN, f32::NAN); count];
                    exit_radiance(&rows, order, channels, &light, &mut out);
                    for (k, (found, expected)) in out.iter().zip(slowly(&rows, n, channels, &light)).enumerate() {
                        let pairs = [(found.r, expected.r), (found.g, expected.g), (found.b, expected.b)];
                        let error = pairs.map(|(a, b)| (f64::from(a) - b).abs()).into_iter().fold(0.0, f64::max);
                        // n roundings of sums below n.
                        assert!(error < 1e-7 * n as f64, "order {order}, {channels} channels, receiver {k}: {error}");
                    }
                }
            }
        }
    }

    #[test]
    fn light_by_matrices_is_that_of_their_rows_for_every_order_and_count() {
        let mut random = Random::new(3);
        for order in 1..=8 {
            for channels in [1, 3] {
                for points in [0, 1, 5, CHUNK / (order * order) + 2] {
                    let n = order * order;
                    let matrices: Vec<f32> =
                        random.signed_vec(n * n * channels * points).iter().map(|x| *x as f32).collect();
                    let light: Vec<_> =
                        (0..n).map(|_| Rgb::new(random.signed(), random.signed(), random.signed())).collect();
                    let mut out = vec![Rgb::new(f32::NAN, f32::NAN, f32::NAN); points * n];
                    incident(&matrices, order, channels, &light, &mut out);
                    for (k, found) in out.iter().enumerate() {
                        let row =
                            |c: usize| &matrices[((k / n * channels + c.min(channels - 1)) * n + k % n) * n..][..n];
                        let rows: Vec<f32> = (0..channels).flat_map(|c| row(c).to_vec()).collect();
                        let expected = slowly(&rows, n, channels, &light)[0];
                        let pairs = [(found.r, expected.r), (found.g, expected.g), (found.b, expected.b)];
                        let error = pairs.map(|(a, b)| (f64::from(a) - b).abs()).into_iter().fold(0.0, f64::max);
                        // n roundings of sums below n.
                        assert!(error < 1e-7 * n as f64, "order {order}, {channels} channels, row {k}: {error}");
                    }
                }
            }
        }
    }

    #[test]
    fn one_vector_for_all_colors_is_summed_in_the_order_of_its_places_to_the_bit() {
        let mut random = Random::new(4);
        for order in 1..=8 {
            let (n, count) = (order * order, 19);
            let rows: Vec<f32> = random.signed_vec(n * count).iter().map(|x| *x as f32).collect();
            let light: Vec<_> = (0..n).map(|_| Rgb::new(random.signed(), 1.0, -random.signed())).collect();
            let mut out = vec![Rgb::new(f32::NAN, f32::NAN, f32::NAN); count];
            exit_radiance(&rows, order, 1, &light, &mut out);
            for (k, (found, row)) in out.iter().zip(rows.chunks(n)).enumerate() {
                let blue = row.iter().zip(&light).fold(0.0_f32, |sum, (t, l)| sum + t * l.b as f32);
                assert_eq!(found.b.to_bits(), blue.to_bits(), "order {order}, receiver {k}");
            }
        }
    }

    #[test]
    fn the_bytes_do_not_depend_on_the_instructions() {
        let mut random = Random::new(2);
        for (order, channels) in [(3, 1), (4, 3), (5, 3), (6, 1)] {
            let (n, count) = (order * order, 101);
            let rows: Vec<f32> = random.signed_vec(n * channels * count).iter().map(|x| *x as f32).collect();
            let light: Vec<_> = (0..n).map(|_| Rgb::new(random.signed(), random.signed(), random.signed())).collect();
            let black = vec![Rgb::new(0.0, 0.0, 0.0); count];
            let (mut wide, mut plain) = (black.clone(), black);
            exit_radiance(&rows, order, channels, &light, &mut wide);
            let light = light_of_len(&light, n);
            Machine::Plain.run(RowsOfChunk { rows: &rows, order, channels, light: &light, out: &mut plain });
            assert_eq!(wide, plain, "order {order}, {channels} channels");
        }
    }
}
