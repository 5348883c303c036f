//! One rotation of many expansions, sixteen side by side in `f32`.

use crate::basis::index::{band_range, coefficient_count};
use crate::rotation::band_matrices::band_columns;
use crate::simd::{Kernel, LANES, Lanes, Machine};
#[cfg(feature = "simd")]
use crate::simd::{Wide, constant};

/// Turns `order²` blocks for each sixteen functions by one rotation, band by band:
///
/// ```text
///   g_lm = Σ_n M^l_mn f_ln
/// ```
///
/// The sums of all rows of a band stay in registers up to band 7, and each entry of the matrix goes to all lanes at once.
/// `columns` are the matrices of all bands from 0 on, column after column.
pub(crate) fn rotate_blocks(machine: Machine, columns: &[f32], order: usize, src: &[Lanes], dst: &mut [Lanes]) {
    assert_eq!(src.len(), dst.len(), "blocks of the rotated functions against those of the given ones");
    if order > 0 {
        machine.run(Rotate { columns, order, src, dst });
    }
}

struct Rotate<'a> {
    columns: &'a [f32],
    order: usize,
    src: &'a [Lanes],
    dst: &'a mut [Lanes],
}

impl Kernel for Rotate<'_> {
    type Output = ();

    #[cfg(feature = "simd")]
    #[inline(always)]
    fn wide<S: pulp::Simd>(self, simd: S) {
        let count = coefficient_count(self.order);
        for (src, dst) in self.src.chunks_exact(count).zip(self.dst.chunks_exact_mut(count)) {
            rotate_group(simd, self.columns, self.order, src, dst);
        }
    }

    fn plain(self) {
        let count = coefficient_count(self.order);
        for (src, dst) in self.src.chunks_exact(count).zip(self.dst.chunks_exact_mut(count)) {
            dst.fill(Lanes::ZERO);
            for l in 0..self.order {
                let columns = band_columns(self.columns, l).chunks_exact(2 * l + 1);
                for (column, f) in columns.zip(&src[band_range(l)]) {
                    for (g, entry) in dst[band_range(l)].iter_mut().zip(column) {
                        (0..LANES).for_each(|lane| g.0[lane] += entry * f.0[lane]);
                    }
                }
            }
        }
    }
}

/// Turns the blocks of sixteen functions. Bands up to 7, whose lengths the compiler then knows, are straight-line code.
#[cfg(feature = "simd")]
#[inline(always)]
fn rotate_group<S: pulp::Simd>(simd: S, columns: &[f32], order: usize, src: &[Lanes], dst: &mut [Lanes]) {
    dst[0] = src[0];
    band::<S, 3>(simd, columns, order, src, dst);
    band::<S, 5>(simd, columns, order, src, dst);
    band::<S, 7>(simd, columns, order, src, dst);
    band::<S, 9>(simd, columns, order, src, dst);
    band::<S, 11>(simd, columns, order, src, dst);
    band::<S, 13>(simd, columns, order, src, dst);
    band::<S, 15>(simd, columns, order, src, dst);
    for l in 8..order {
        for part in 0..Wide::<S>::PARTS {
            high_band(simd, part, band_columns(columns, l), &src[band_range(l)], &mut dst[band_range(l)]);
        }
    }
}

/// Groups of sixteen that are taken from all planes before the next: planes may be pages apart, and a page that is found once
/// should be read for more than one line.
#[cfg(feature = "simd")]
const TILE: usize = 8;

/// Turns as many of `count` functions, given in planes, as are whole blocks, if the machine has code for it; their number.
#[cfg(feature = "simd")]
pub(crate) fn rotate_planes(
    machine: Machine,
    columns: &[f32],
    order: usize,
    count: usize,
    src: &[f32],
    dst: &mut [f32],
) -> usize {
    if machine.is_plain() || order == 0 {
        return 0;
    }
    machine.run(RotatePlanes { columns, order, count, src, dst })
}

#[cfg(feature = "simd")]
struct RotatePlanes<'a> {
    columns: &'a [f32],
    order: usize,
    count: usize,
    src: &'a [f32],
    dst: &'a mut [f32],
}

#[cfg(feature = "simd")]
impl Kernel for RotatePlanes<'_> {
    type Output = usize;

    #[cfg(feature = "simd")]
    #[inline(always)]
    fn wide<S: pulp::Simd>(self, simd: S) -> usize {
        let Self { columns, order, count, src, dst } = self;
        let side = coefficient_count(order);
        let (mut from, mut to) = (vec![Lanes::ZERO; TILE * side], vec![Lanes::ZERO; TILE * side]);
        let whole = count - count % LANES;
        for start in (0..whole).step_by(TILE * LANES) {
            let groups = TILE.min((whole - start) / LANES);
            for (i, plane) in src.chunks_exact(count).enumerate() {
                let lines = plane[start..][..groups * LANES].as_chunks::<LANES>().0;
                for (blocks, line) in from.chunks_exact_mut(side).zip(lines) {
                    blocks[i].0 = *line;
                }
            }
            for (from, to) in from.chunks_exact(side).zip(to.chunks_exact_mut(side)).take(groups) {
                rotate_group(simd, columns, order, from, to);
            }
            for (i, plane) in dst.chunks_exact_mut(count).enumerate() {
                let lines = plane[start..][..groups * LANES].as_chunks_mut::<LANES>().0;
                for (blocks, line) in to.chunks_exact(side).zip(lines) {
                    *line = blocks[i].0;
                }
            }
        }
        whole
    }

    fn plain(self) -> usize {
        0
    }
}

/// The band of `SIDE` functions, if there is one below `order`.
#[cfg(feature = "simd")]
#[inline(always)]
fn band<S: pulp::Simd, const SIDE: usize>(simd: S, columns: &[f32], order: usize, src: &[Lanes], dst: &mut [Lanes]) {
    let l = SIDE / 2;
    if l >= order {
        return;
    }
    let columns = band_columns(columns, l).as_chunks::<SIDE>().0.as_array::<SIDE>();
    let (Some(columns), Some(src), Some(dst)) =
        (columns, src[band_range(l)].as_array::<SIDE>(), dst[band_range(l)].as_mut_array::<SIDE>())
    else {
        unreachable!("band {l} has {SIDE} functions")
    };
    for part in 0..Wide::<S>::PARTS {
        let mut sums = [constant(simd, 0.0); SIDE];
        for (column, f) in columns.iter().zip(src) {
            let f = Wide::load(simd, f, part);
            for row in 0..SIDE {
                sums[row] = f.times_plus(constant(simd, column[row]), sums[row]);
            }
        }
        for (sum, g) in sums.into_iter().zip(&mut *dst) {
            sum.store(g, part);
        }
    }
}

/// Rows of a high band that are summed together.
#[cfg(feature = "simd")]
const ROWS: usize = 8;

#[cfg(feature = "simd")]
#[inline(always)]
fn high_band<S: pulp::Simd>(simd: S, part: usize, columns: &[f32], src: &[Lanes], dst: &mut [Lanes]) {
    let side = src.len();
    for (first, dst) in (0..side).step_by(ROWS).zip(dst.chunks_mut(ROWS)) {
        let mut sums = [constant(simd, 0.0); ROWS];
        for (column, f) in columns.chunks_exact(side).zip(src) {
            let f = Wide::load(simd, f, part);
            for (sum, entry) in sums.iter_mut().zip(&column[first..side.min(first + ROWS)]) {
                *sum = f.times_plus(constant(simd, *entry), *sum);
            }
        }
        for (sum, g) in sums.into_iter().zip(dst) {
            sum.store(g, part);
        }
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;
    use crate::rotation::Rotation;
    use crate::rotation::ivanic::RotationMatrices;
    use lobe_testkit::Random;

    #[test]
    fn every_machine_turns_as_one_function_at_a_time() {
        let rotation = Rotation::from_euler_zyz(0.3, 1.1, -2.0);
        let mut random = Random::new(5);
        for order in [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 12] {
            let matrices = RotationMatrices::<f32>::new(&rotation, order + 1);
            let count = coefficient_count(order);
            let src: Vec<Lanes> =
                (0..2 * count).map(|_| Lanes(core::array::from_fn(|_| random.signed() as f32))).collect();
            for machine in Machine::available() {
                let mut dst = vec![Lanes([f32::NAN; LANES]); 2 * count];
                rotate_blocks(machine, matrices.columns(), order, &src, &mut dst);
                for group in 0..2 {
                    for lane in 0..LANES {
                        let of = |blocks: &[Lanes]| -> Vec<f32> {
                            blocks[group * count..][..count].iter().map(|block| block.0[lane]).collect()
                        };
                        let mut expected = vec![0.0; count];
                        matrices.apply_into(&of(&src), &mut expected);
                        for (i, (x, y)) in of(&dst).into_iter().zip(expected).enumerate() {
                            let what = (machine.name(), order, lane);
                            assert!((x - y).abs() < 3e-6, "{what:?}, coefficient {i}: {x} against {y}");
                        }
                    }
                }
            }
        }
    }
}
