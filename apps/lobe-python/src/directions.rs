//! Vectors of any length, taken for their directions.

use std::ops::Range;

/// Vectors of single or double precision.
#[derive(Clone, Copy)]
pub(crate) enum Directions<'a> {
    Single(&'a [[f32; 3]]),
    Double(&'a [[f64; 3]]),
}

impl<'a> Directions<'a> {
    pub(crate) fn len(self) -> usize {
        match self {
            Self::Single(vectors) => vectors.len(),
            Self::Double(vectors) => vectors.len(),
        }
    }

    /// Some of them.
    pub(crate) fn range(self, range: Range<usize>) -> Self {
        match self {
            Self::Single(vectors) => Self::Single(&vectors[range]),
            Self::Double(vectors) => Self::Double(&vectors[range]),
        }
    }

    /// The unit vector of vector `k`; not finite if it has no direction.
    pub(crate) fn unit(self, k: usize) -> [f64; 3] {
        let [x, y, z] = match self {
            Self::Single(vectors) => vectors[k].map(f64::from),
            Self::Double(vectors) => vectors[k],
        };
        let length = (x * x + y * y + z * z).sqrt();
        // Of an infinite length nothing would be left; of none there is no number already.
        let length = if length.is_finite() { length } else { f64::NAN };
        [x / length, y / length, z / length]
    }
}
