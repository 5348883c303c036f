//! The basis towards a tile of directions, in rows.

use alloc::vec::Vec;

use pulp::{Simd, WithSimd};

use crate::basis::index::{coefficient_count, coefficient_index};
use crate::basis::lane_basis::{TILE, Tile, TilePlaces, tile_basis};
use crate::basis::lane_recurrence::PlacesTogether;
use crate::basis::places::Places;
use crate::basis::recurrence::Constants;
use crate::simd::{Lane, Wide};

/// The functions of the basis in the order in which the recurrence has them: column by column of equal `|m|`.
pub(crate) fn column_order(order: usize) -> Vec<usize> {
    let mut all = Vec::with_capacity(coefficient_count(order));
    for m in 0..order {
        for l in m..order {
            all.push(coefficient_index(l, m as isize));
            if m > 0 {
                all.push(coefficient_index(l, -(m as isize)));
            }
        }
    }
    all
}

/// The values towards a tile of directions, a row for each function, in [`column_order`]: they are written one after the other, as
/// the recurrence has them, to every `step`th row of `y`.
///
/// Compiled once for each kind of register, and not in each kernel that has rows.
#[inline(always)]
pub(crate) fn tile_rows<S: Simd, T: Lane>(
    simd: S,
    constants: &Constants<T>,
    order: usize,
    tile: &Tile<T>,
    y: &mut [[T; TILE]],
    step: usize,
) {
    simd.vectorize(TileRows { constants, order, tile, y, step });
}

struct TileRows<'a, T> {
    constants: &'a Constants<T>,
    order: usize,
    tile: &'a Tile<T>,
    y: &'a mut [[T; TILE]],
    step: usize,
}

impl<T: Lane> WithSimd for TileRows<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { constants, order, tile, y, step } = self;
        tile_basis(simd, constants, order, tile, &mut Rows { y, step, at: 0, first: 0, together: 0 });
    }
}

/// Rows of a tile that are filled in the order in which values come.
struct Rows<'a, T> {
    y: &'a mut [[T; TILE]],
    step: usize,
    at: usize,
    first: usize,
    together: usize,
}

impl<S: Simd, T: Lane> Places<S, T> for Rows<'_, T> {
    #[inline(always)]
    fn put(&mut self, _: usize, value: Wide<S, T>) {
        value.store_array(&mut self.y[self.at], self.first);
        self.at += self.step;
    }
}

impl<S: Simd, T: Lane> PlacesTogether<S, T> for Rows<'_, T> {
    #[inline(always)]
    fn put_register(&mut self, _: usize, r: usize, value: Wide<S, T>) {
        // The registers of one function one after the other, beginning with the first.
        self.at += if r == 0 { self.together } else { 0 };
        self.together = self.step;
        value.store_array(&mut self.y[self.at], self.first + r);
    }
}

impl<S: Simd, T: Lane> TilePlaces<S, T> for Rows<'_, T> {
    #[inline(always)]
    fn begin(&mut self, first: usize) {
        (self.first, self.at, self.together) = (first, 0, 0);
    }

    #[inline(always)]
    fn end(&mut self, _: usize) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rows_are_those_of_every_function_once() {
        for order in [1, 4, 10, 11, 40] {
            let mut all = column_order(order);
            all.sort_unstable();
            assert!(all.into_iter().eq(0..coefficient_count(order)), "order {order}");
        }
    }
}
