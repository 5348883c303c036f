//! The basis towards many directions, a plane of values for each function.

use pulp::Simd;

use crate::basis::index::coefficient_count;
use crate::basis::lane_basis::{STRAIGHT_TILES, TILE, Tile, TilePlaces, tile_by_recurrence};
use crate::basis::lane_recurrence::PlacesTogether;
use crate::basis::lane_rows::{column_order, tile_rows};
use crate::basis::places::Places;
use crate::basis::recurrence::Constants;
use crate::simd::{Kernel, Lane, Wide, past_caches};

/// Bytes of the tiles whose values go past the caches together: they lie in the second-level cache, and the longer the runs, the fewer of them: at
/// orders 6 and 10 a million directions take 0.54 and 0.72 of the time that runs of 1 KiB take.
const ROOM: usize = 512 << 10;

/// Tiles together at least and at most.
const TOGETHER: [usize; 2] = [8, 128];

/// The values towards whole tiles: `out[i count + k]` is `y_i` towards direction `k`. The number of directions that are done.
#[derive(Debug)]
pub struct EvalPlanes<'a, T> {
    pub(crate) constants: &'a Constants<T>,
    pub(crate) order: usize,
    pub(crate) components: [&'a [T]; 3],
    pub(crate) out: &'a mut [T],
    /// Whether they are so many that they go past the caches.
    pub(crate) leaves: bool,
}

impl<T: Lane> Kernel for EvalPlanes<'_, T> {
    type Output = usize;

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) -> usize {
        if self.leaves {
            self.past_caches(simd)
        } else if self.order <= STRAIGHT_TILES {
            self.by_rows(simd)
        } else {
            self.by_registers(simd)
        }
    }

    fn plain(self) -> usize {
        0
    }
}

impl<T: Lane> EvalPlanes<'_, T> {
    /// A tile of low order has its values in the nearest cache, and from there goes to the planes by whole lines.
    #[inline(always)]
    fn by_rows<S: Simd>(self, simd: S) -> usize {
        let stride = self.components[0].len();
        let mut y = vec![[T::ZERO; TILE]; coefficient_count(self.order)];
        let planes = column_order(self.order);
        let mut done = 0;
        while done + TILE <= stride {
            tile_rows(simd, self.constants, self.order, &self.tile(done), &mut y, 1);
            for (row, i) in y.iter().zip(&planes) {
                if let Some(place) = self.out[i * stride + done..].first_chunk_mut() {
                    *place = *row;
                }
            }
            done += TILE;
        }
        done
    }

    /// The tiles of high orders are as large as that cache: every register goes to its plane.
    #[inline(always)]
    fn by_registers<S: Simd>(self, simd: S) -> usize {
        let stride = self.components[0].len();
        let mut done = 0;
        while done + TILE <= stride {
            let tile = self.tile(done);
            let mut places = Planes { values: &mut *self.out, stride, start: done, first: 0 };
            tile_by_recurrence(simd, self.constants, self.order, &tile, &mut places);
            done += TILE;
        }
        done
    }

    /// Of some tiles together, so that runs of lines go past the caches.
    #[inline(always)]
    fn past_caches<S: Simd>(self, simd: S) -> usize {
        let stride = self.components[0].len();
        let rows = coefficient_count(self.order);
        let together = (ROOM / (rows * size_of::<[T; TILE]>())).clamp(TOGETHER[0], TOGETHER[1]);
        // One more, so that rows do not share a few sets of the first-level cache.
        let step = together + 1;
        let mut y = vec![[T::ZERO; TILE]; rows * step];
        let planes = column_order(self.order);
        let mut done = 0;
        while done + TILE <= stride {
            let tiles = together.min((stride - done) / TILE);
            for t in 0..tiles {
                tile_rows(simd, self.constants, self.order, &self.tile(done + t * TILE), &mut y[t..], step);
            }
            for (run, i) in y.chunks_exact(step).zip(&planes) {
                past_caches::copy(run[..tiles].as_flattened(), &mut self.out[i * stride + done..][..tiles * TILE]);
            }
            done += tiles * TILE;
        }
        past_caches::finish();
        done
    }

    /// The directions from `start` on.
    #[inline(always)]
    fn tile(&self, start: usize) -> Tile<T> {
        let mut tile: Tile<T> = [[T::ZERO; TILE]; 3];
        for axis in 0..3 {
            if let Some(components) = self.components[axis][start..].first_chunk() {
                tile[axis] = *components;
            }
        }
        tile
    }
}

/// The values of a tile from `start` on in planes of `stride` values, one for each function.
struct Planes<'a, T> {
    values: &'a mut [T],
    stride: usize,
    start: usize,
    first: usize,
}

impl<S: Simd, T: Lane> Places<S, T> for Planes<'_, T> {
    #[inline(always)]
    fn put(&mut self, i: usize, value: Wide<S, T>) {
        self.put_register(i, 0, value);
    }
}

impl<S: Simd, T: Lane> PlacesTogether<S, T> for Planes<'_, T> {
    #[inline(always)]
    fn put_register(&mut self, i: usize, r: usize, value: Wide<S, T>) {
        // An array, not a slice: its length is known at compile time.
        if let Some(place) = self.values[i * self.stride + self.start..].first_chunk_mut::<TILE>() {
            value.store_array(place, self.first + r);
        }
    }
}

impl<S: Simd, T: Lane> TilePlaces<S, T> for Planes<'_, T> {
    #[inline(always)]
    fn begin(&mut self, first: usize) {
        self.first = first;
    }

    #[inline(always)]
    fn end(&mut self, _: usize) {}
}
