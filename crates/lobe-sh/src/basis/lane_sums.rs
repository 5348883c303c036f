//! Values of one function towards many directions, of which the basis is nowhere written.

use pulp::Simd;

use crate::basis::lane_basis::{TILE, Tile, TilePlaces, tile_basis};
use crate::basis::lane_recurrence::PlacesTogether;
use crate::basis::places::Places;
use crate::basis::recurrence::Constants;
use crate::basis::vectors::Vectors;
use crate::simd::{Kernel, Lane, Wide};

/// The sums of the values of a tile times coefficients of one function, whose channels are numbers of their own.
struct TileSums<'a, S: Simd, T: Lane, const CHANNELS: usize> {
    coefficients: &'a [[T; CHANNELS]],
    simd: S,
    first: usize,
    sums: [[Wide<S, T>; CHANNELS]; MOST_TOGETHER],
    /// The sums, channel after channel.
    out: [[T; TILE]; CHANNELS],
}

/// Registers of a tile at most at a time.
const MOST_TOGETHER: usize = 4;

impl<'a, S: Simd, T: Lane, const CHANNELS: usize> TileSums<'a, S, T, CHANNELS> {
    /// Of the coefficients of a function.
    #[inline(always)]
    fn new(simd: S, coefficients: &'a [[T; CHANNELS]]) -> Self {
        let sums = [[Wide::splat(simd, T::ZERO); CHANNELS]; MOST_TOGETHER];
        Self { coefficients, simd, first: 0, sums, out: [[T::ZERO; TILE]; CHANNELS] }
    }
}

impl<S: Simd, T: Lane, const CHANNELS: usize> Places<S, T> for TileSums<'_, S, T, CHANNELS> {
    #[inline(always)]
    fn put(&mut self, i: usize, value: Wide<S, T>) {
        self.put_register(i, 0, value);
    }
}

impl<S: Simd, T: Lane, const CHANNELS: usize> PlacesTogether<S, T> for TileSums<'_, S, T, CHANNELS> {
    #[inline(always)]
    fn put_register(&mut self, i: usize, r: usize, value: Wide<S, T>) {
        for c in 0..CHANNELS {
            let factor = Wide::splat(self.simd, self.coefficients[i][c]);
            self.sums[r][c] = value.times_plus(factor, self.sums[r][c]);
        }
    }
}

impl<S: Simd, T: Lane, const CHANNELS: usize> TilePlaces<S, T> for TileSums<'_, S, T, CHANNELS> {
    #[inline(always)]
    fn begin(&mut self, first: usize) {
        self.first = first;
        self.sums = [[Wide::splat(self.simd, T::ZERO); CHANNELS]; MOST_TOGETHER];
    }

    #[inline(always)]
    fn end(&mut self, count: usize) {
        for r in 0..count {
            for c in 0..CHANNELS {
                self.sums[r][c].store_array(&mut self.out[c], self.first + r);
            }
        }
    }
}

/// Directions as they come.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Directions<'a, T> {
    /// The components of unit vectors; those behind the last whole tile are left out.
    Planes([&'a [T]; 3]),
    /// Vectors of any length.
    Vectors(Vectors<'a>),
}

/// The values of a function, a coefficient of which has some channels, into places for each direction, one for each channel. False if a vector has no
/// direction.
#[derive(Debug)]
pub struct EvalSums<'a, T, const CHANNELS: usize> {
    pub(crate) constants: &'a Constants<T>,
    pub(crate) coefficients: &'a [T],
    pub(crate) order: usize,
    pub(crate) directions: Directions<'a, T>,
    pub(crate) out: &'a mut [T],
}

impl<T: Lane, const CHANNELS: usize> Kernel for EvalSums<'_, T, CHANNELS> {
    type Output = bool;

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) -> bool {
        let mut sums = TileSums::new(simd, self.coefficients.as_chunks::<CHANNELS>().0);
        let mut tile: Tile<T> = [[T::ZERO; TILE]; 3];
        let mut all = true;
        for (t, out) in self.out.chunks_mut(TILE * CHANNELS).enumerate() {
            match self.directions {
                Directions::Planes(planes) => {
                    for axis in 0..3 {
                        if let Some(plane) = planes[axis][t * TILE..].first_chunk() {
                            tile[axis] = *plane;
                        }
                    }
                }
                Directions::Vectors(vectors) => all &= vectors.tile(t).unit_into(simd, &mut tile),
            }
            tile_basis(simd, self.constants, self.order, &tile, &mut sums);
            if CHANNELS == 1 && out.len() == TILE {
                out.copy_from_slice(&sums.out[0]);
            } else {
                for (k, out) in out.as_chunks_mut::<CHANNELS>().0.iter_mut().enumerate() {
                    for c in 0..CHANNELS {
                        out[c] = sums.out[c][k];
                    }
                }
            }
        }
        all
    }

    /// Not of planes, which have plain code of their own.
    fn plain(self) -> bool {
        let Directions::Vectors(vectors) = self.directions else { return true };
        let mut tile: Tile<T> = [[T::ZERO; TILE]; 3];
        let mut all = true;
        for (t, out) in self.out.chunks_mut(TILE * CHANNELS).enumerate() {
            all &= vectors.tile(t).unit_into_plain(&mut tile);
            let mut sums = [[T::ZERO; TILE]; CHANNELS];
            self.constants.for_each_in_block(tile, self.order, |i, y| {
                for (sums, c) in sums.iter_mut().zip(&self.coefficients[i * CHANNELS..]) {
                    for (sum, y) in sums.iter_mut().zip(y) {
                        *sum += *c * *y;
                    }
                }
            });
            for (k, out) in out.chunks_exact_mut(CHANNELS).enumerate() {
                out.iter_mut().zip(&sums).for_each(|(out, sums)| *out = sums[k]);
            }
        }
        all
    }
}
