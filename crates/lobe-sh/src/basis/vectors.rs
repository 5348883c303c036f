//! Vectors of any length, taken for their directions.

use core::ops::Range;

use pulp::Simd;

use crate::basis::lane_basis::{TILE, Tile};
use crate::scalar::Real;
use crate::simd::{Lane, Wide, rounded};

/// Vectors of single or double precision.
#[derive(Clone, Copy, Debug)]
pub enum Vectors<'a> {
    /// Of `f32`.
    Single(&'a [[f32; 3]]),
    /// Of `f64`.
    Double(&'a [[f64; 3]]),
}

/// Squared lengths between which the lengths of vectors have all digits, in `f32` and `f64`: far enough from the smallest normal number
/// and from the largest for the squares of small components too.
const SQUARES: [[f64; 2]; 2] = [[1e-24, 1e36], [1e-240, 1e300]];

impl<'a> Vectors<'a> {
    /// How many.
    #[must_use]
    pub fn len(self) -> usize {
        match self {
            Self::Single(vectors) => vectors.len(),
            Self::Double(vectors) => vectors.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// Some of them.
    ///
    /// # Panics
    /// If there are not as many.
    #[must_use]
    pub fn range(self, range: Range<usize>) -> Self {
        match self {
            Self::Single(vectors) => Self::Single(&vectors[range]),
            Self::Double(vectors) => Self::Double(&vectors[range]),
        }
    }

    /// Those of a tile.
    #[inline(always)]
    pub(crate) fn tile(self, t: usize) -> Self {
        self.range(t * TILE..self.len().min((t + 1) * TILE))
    }

    /// [`Vectors::unit_into`] in plain code.
    pub(crate) fn unit_into_plain<T: Real>(self, tile: &mut Tile<T>) -> bool {
        match self {
            Self::Single(vectors) => {
                split(vectors, tile);
                normalize_each(vectors, tile)
            }
            Self::Double(vectors) => {
                split(vectors, tile);
                normalize_each(vectors, tile)
            }
        }
    }

    /// The unit vectors of the first [`TILE`] vectors, +z where there are fewer. Whether all of them have a direction; what has none is NaN.
    ///
    /// In the precision of the vectors or, if that is higher, of the result.
    #[inline(always)]
    pub(crate) fn unit_into<S: Simd, T: Lane>(self, simd: S, tile: &mut Tile<T>) -> bool {
        match self {
            Self::Single(vectors) => {
                split(vectors, tile);
                let squares = if is_single::<T>() { SQUARES[0] } else { SQUARES[1] };
                normalize(simd, tile, squares) || normalize_each(vectors, tile)
            }
            Self::Double(vectors) => {
                let mut exact = [[0.0; TILE]; 3];
                split(vectors, &mut exact);
                let is_done = normalize(simd, &mut exact, SQUARES[1]) || normalize_each(vectors, &mut exact);
                for axis in 0..3 {
                    for k in 0..TILE {
                        tile[axis][k] = T::from_f64(exact[axis][k]);
                    }
                }
                is_done
            }
        }
    }
}

/// Whether a number is `f32`.
#[inline(always)]
fn is_single<T: Real>() -> bool {
    size_of::<T>() == size_of::<f32>()
}

/// The components of vectors, and +z where there are too few.
#[inline(always)]
fn split<V: Real, T: Real>(vectors: &[[V; 3]], tile: &mut Tile<T>) {
    if let Some(vectors) = vectors.first_chunk::<TILE>() {
        // Of a known length, so that the compiler takes them apart by registers.
        for k in 0..TILE {
            for axis in 0..3 {
                tile[axis][k] = T::from_f64(vectors[k][axis].to_f64());
            }
        }
        return;
    }
    *tile = [[T::ZERO; TILE], [T::ZERO; TILE], [T::ONE; TILE]];
    for (k, vector) in vectors.iter().enumerate() {
        for axis in 0..3 {
            tile[axis][k] = T::from_f64(vector[axis].to_f64());
        }
    }
}

/// Divides vectors by their lengths; none, and false, if the square of any of them is not within bounds.
#[inline(always)]
fn normalize<S: Simd, T: Lane>(simd: S, [x, y, z]: &mut Tile<T>, [least, most]: [f64; 2]) -> bool {
    let mut inverse = [T::ZERO; TILE];
    let (zero, one) = (rounded(simd, 0.0), rounded(simd, 1.0));
    let (least, most) = (rounded(simd, least), rounded(simd, most));
    let mut faults: Wide<S, T> = zero;
    for r in 0..TILE / T::count::<S>() {
        let [x, y, z] = [Wide::load_array(simd, x, r), Wide::load_array(simd, y, r), Wide::load_array(simd, z, r)];
        let square = x.times_plus(x, y.times_plus(y, z * z));
        // NaN is neither above one bound nor below the other.
        let is_fine = least.if_less(square, square.if_less(most, one, zero), zero);
        faults = faults + (one - is_fine);
        square.sqrt().recip().store_array(&mut inverse, r);
    }
    if faults.any_above(zero) {
        return false;
    }
    for component in [x, y, z] {
        for r in 0..TILE / T::count::<S>() {
            let length = Wide::load_array(simd, &inverse, r);
            (Wide::load_array(simd, component, r) * length).store_array(component, r);
        }
    }
    true
}

/// One by one, whatever their lengths; false if one has no direction.
#[inline(never)]
fn normalize_each<V: Real, T: Real>(vectors: &[[V; 3]], tile: &mut Tile<T>) -> bool {
    let mut all = true;
    for (k, vector) in vectors.iter().take(TILE).enumerate() {
        let v = vector.map(V::to_f64);
        // Relative to the largest component no square is too large or too small.
        let largest = v.iter().fold(0.0, |most: f64, c| most.max(c.abs()));
        let [x, y, z] = v.map(|c| c / largest);
        let length = (x * x + y * y + z * z).sqrt();
        let unit = [x / length, y / length, z / length];
        all &= unit.iter().all(|c| c.is_finite());
        for axis in 0..3 {
            tile[axis][k] = T::from_f64(unit[axis]);
        }
    }
    all
}
