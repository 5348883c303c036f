//! Discrete Fourier transforms of rows of complex numbers, by rustfft.
//!
//! A crate of its own, because rustfft is generic: a crate that plans transforms compiles all of them, for every kind of
//! registers, and compiles them again in each of its tests. Here that happens once.

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

pub use num_complex::Complex;
use rustfft::{Fft, FftPlanner, FftPlannerScalar};

/// The transform of rows of one length.
///
/// ```text
///   Z_k = Σ_j z_j e^{-2πi jk/K}        0 <= k < K
/// ```
#[derive(Clone)]
pub struct Transform(Arc<dyn Fft<f64>>);

/// The registers that a transform may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Registers {
    /// Those of every machine of its kind.
    Plain,
    /// The widest that the machine has.
    Widest,
}

impl Transform {
    /// Of rows of `length` numbers. The plan of a length is made once for the whole process and each kind of registers.
    #[must_use]
    pub fn new(length: usize, registers: Registers) -> Self {
        static PLAIN: Mutex<Option<FftPlannerScalar<f64>>> = Mutex::new(None);
        static WIDEST: Mutex<Option<FftPlanner<f64>>> = Mutex::new(None);
        Self(match registers {
            Registers::Plain => {
                let mut planner = PLAIN.lock().unwrap_or_else(PoisonError::into_inner);
                planner.get_or_insert_with(FftPlannerScalar::new).plan_fft_forward(length)
            }
            Registers::Widest => {
                let mut planner = WIDEST.lock().unwrap_or_else(PoisonError::into_inner);
                planner.get_or_insert_with(FftPlanner::new).plan_fft_forward(length)
            }
        })
    }

    /// The numbers of a row.
    #[must_use]
    pub fn length(&self) -> usize {
        self.0.len()
    }

    /// The scratch space of [`Self::apply`].
    #[must_use]
    pub fn scratch(&self) -> Vec<Complex<f64>> {
        vec![Complex::ZERO; self.0.get_inplace_scratch_len()]
    }

    /// Replaces a row by its transform. What `scratch` holds afterwards has no meaning.
    ///
    /// # Panics
    /// If `row` has another length, or `scratch` is shorter than that of [`Self::scratch`].
    pub fn apply(&self, row: &mut [Complex<f64>], scratch: &mut [Complex<f64>]) {
        assert_eq!(row.len(), self.length(), "numbers of a row, against the length of the transform");
        self.0.process_with_scratch(row, scratch);
    }
}

impl fmt::Debug for Transform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Transform").field(&self.length()).finish()
    }
}
