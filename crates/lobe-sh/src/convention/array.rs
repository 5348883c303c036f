//! The numbers of a library, in the shape of its array.

use crate::prelude::*;

/// Coefficients as an array of a library: numbers in C order, the last axis fastest.
///
/// Colors have a leading axis of three, one array of the library after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct CoefficientArray {
    /// The length of each axis.
    pub shape: Vec<usize>,
    /// The numbers, as many as the product of the shape.
    pub numbers: ArrayNumbers,
}

/// The numbers of a [`CoefficientArray`].
#[derive(Clone, Debug, PartialEq)]
pub enum ArrayNumbers {
    /// Numbers of a real basis.
    Real(Vec<f64>),
    /// Numbers of a complex basis: real and imaginary part.
    Complex(Vec<[f64; 2]>),
}

impl ArrayNumbers {
    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Real(numbers) => numbers.len(),
            Self::Complex(numbers) => numbers.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number `i`, real and imaginary part.
    ///
    /// # Panics
    /// If there are not so many.
    #[must_use]
    pub fn complex(&self, i: usize) -> [f64; 2] {
        match self {
            Self::Real(numbers) => [numbers[i], 0.0],
            Self::Complex(numbers) => numbers[i],
        }
    }
}
