//! The basis towards many directions by the registers of the machine: orders 1 to 10 by straight-line code, any other by the
//! recurrence.

use pulp::Simd;

use crate::basis::lane_recurrence::{PlacesTogether, recurrence};
use crate::basis::lanes;
use crate::basis::places::Places;
use crate::basis::recurrence::Constants;
use crate::simd::{Lane, Wide};

/// The highest order that has straight-line code.
pub(crate) const HIGHEST_ORDER: usize = 10;

/// The highest order whose tiles take that code. Above, the recurrence of some registers at a time
/// takes 0.6 of the time to planes and up to 1.08 of it in sums (order 10), and is compiled sooner.
pub(crate) const STRAIGHT_TILES: usize = 6;

/// Directions of a tile, whole registers of every machine.
pub(crate) const TILE: usize = 32;

/// The components of as many unit vectors.
pub(crate) type Tile<T> = [[T; TILE]; 3];

/// Where the values of a tile go, some registers at a time.
pub(crate) trait TilePlaces<S: Simd, T: Lane>: Places<S, T> + PlacesTogether<S, T> {
    /// The values of registers from `first` on follow.
    fn begin(&mut self, first: usize);

    /// The values of `count` registers have been put.
    fn end(&mut self, count: usize);
}

/// Straight-line code of one order.
#[inline(always)]
pub(crate) fn basis<S: Simd, T: Lane>(simd: S, order: usize, s: [Wide<S, T>; 3], out: &mut impl Places<S, T>) {
    match order {
        7 => lanes::order_7::basis(simd, s, out),
        8 => lanes::order_8::basis(simd, s, out),
        9 => lanes::order_9::basis(simd, s, out),
        HIGHEST_ORDER => lanes::order_10::basis(simd, s, out),
        _ => basis_of_tiles(simd, order, s, out),
    }
}

/// The same of the orders to [`STRAIGHT_TILES`].
#[inline(always)]
fn basis_of_tiles<S: Simd, T: Lane>(simd: S, order: usize, s: [Wide<S, T>; 3], out: &mut impl Places<S, T>) {
    match order {
        1 => lanes::order_1::basis(simd, s, out),
        2 => lanes::order_2::basis(simd, s, out),
        3 => lanes::order_3::basis(simd, s, out),
        4 => lanes::order_4::basis(simd, s, out),
        5 => lanes::order_5::basis(simd, s, out),
        STRAIGHT_TILES => lanes::order_6::basis(simd, s, out),
        _ => {}
    }
}

/// The values of all functions towards a tile of directions, column by column of equal `|m|`.
#[inline(always)]
pub(crate) fn tile_basis<S: Simd, T: Lane>(
    simd: S,
    constants: &Constants<T>,
    order: usize,
    tile: &Tile<T>,
    out: &mut impl TilePlaces<S, T>,
) {
    if order <= STRAIGHT_TILES {
        for r in 0..TILE / T::count::<S>() {
            out.begin(r);
            let [x, y, z] = tile;
            let s = [Wide::load_array(simd, x, r), Wide::load_array(simd, y, r), Wide::load_array(simd, z, r)];
            basis_of_tiles(simd, order, s, out);
            out.end(1);
        }
    } else {
        tile_by_recurrence(simd, constants, order, tile, out);
    }
}

/// The same of orders above [`STRAIGHT_TILES`].
#[inline(always)]
pub(crate) fn tile_by_recurrence<S: Simd, T: Lane>(
    simd: S,
    constants: &Constants<T>,
    order: usize,
    tile: &Tile<T>,
    out: &mut impl TilePlaces<S, T>,
) {
    if TILE / T::count::<S>() >= 4 {
        tile_recurrence::<S, T, 4>(simd, constants, order, tile, out);
    } else {
        tile_recurrence::<S, T, 2>(simd, constants, order, tile, out);
    }
}

/// By `R` registers at a time.
#[inline(always)]
fn tile_recurrence<S: Simd, T: Lane, const R: usize>(
    simd: S,
    constants: &Constants<T>,
    order: usize,
    tile: &Tile<T>,
    out: &mut impl TilePlaces<S, T>,
) {
    for first in (0..TILE / T::count::<S>()).step_by(R) {
        let mut s = [[Wide::splat(simd, T::ZERO); R]; 3];
        for axis in 0..3 {
            for r in 0..R {
                s[axis][r] = Wide::load_array(simd, &tile[axis], first + r);
            }
        }
        out.begin(first);
        recurrence::<S, T, R>(simd, constants, order, &s, out);
        out.end(R);
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use alloc::vec::Vec;

    use super::*;
    use crate::basis::basis::eval_basis_into;
    use crate::basis::index::coefficient_count;

    /// The error that single directions are tested for at order 20.
    const ERROR: f64 = 1.5e-6;

    /// Directions in general, and next to the poles, where errors are largest.
    pub(crate) fn directions() -> Vec<[f32; 3]> {
        let mut random = lobe_testkit::Random::new(20);
        let near_poles = (0..200).map(|_| {
            let [x, y, z] = random.direction();
            crate::Dir::new([0.05 * x, 0.05 * y, z.signum()]).unwrap().to_array()
        });
        let mut all: Vec<[f64; 3]> = lobe_testkit::directions().into_iter().chain(near_poles).collect();
        all.truncate(all.len() / TILE * TILE);
        all.into_iter().map(|s| s.map(|c| c as f32)).collect()
    }

    pub(crate) fn assert_close(found: f32, order: usize, i: usize, s: [f32; 3], what: &str) {
        let mut y = vec![0.0; coefficient_count(order)];
        eval_basis_into(s.map(f64::from), &mut y);
        let off = (f64::from(found) - y[i]).abs();
        assert!(off < ERROR, "{what}, order {order}, y_{i} towards {s:?}: {found} against {}", y[i]);
    }
}
