//! Values of functions towards many directions: the basis of some directions after the other, times the coefficients.

use lobe::sh::{Basis, coefficient_count};
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::directions::Directions;
use crate::rows::{Numbers, array_of, contiguous, shape_error, value_error};
use crate::value_product::{Coefficients, Sums, Tiles, multiply};

/// Directions that a thread has at a time: their basis, at order 10 in double precision 200 KiB, stays in its cache.
const BLOCK: usize = 256;

/// Blocks of directions for each thread from which on threads share directions, and not functions.
const BLOCKS_EACH: usize = 4;

/// Functions that threads have at a time if they share functions: enough that a tile of the basis is read from its cache for most.
const FUNCTIONS: usize = 16;

/// Functions whose values are found before the basis is computed again, if threads share directions: it takes the time of some ten of them.
const FUNCTIONS_TOGETHER: usize = 1024;

/// Blocks of directions after which the interpreter may stop the work: milliseconds for each thousand of functions.
const BLOCKS_TOGETHER: usize = 64;

/// Values of functions, `(rows, n²[, 3])`, towards vectors `(m, 3)` of any length above zero: `(rows, m[, 3])`.
#[pyfunction]
pub(crate) fn eval<'py>(
    py: Python<'py>,
    c: Numbers<'py>,
    order: usize,
    directions: Numbers<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let directions = match &directions {
        Numbers::Single(array) => Directions::Single(contiguous(array)?.as_chunks().0),
        Numbers::Double(array) => Directions::Double(contiguous(array)?.as_chunks().0),
    };
    match c {
        Numbers::Single(array) => eval_typed(py, &array, order, directions),
        Numbers::Double(array) => eval_typed(py, &array, order, directions),
    }
}

fn eval_typed<'py, T: Sums>(
    py: Python<'py>,
    array: &PyReadonlyArrayDyn<'py, T>,
    order: usize,
    directions: Directions<'_>,
) -> PyResult<Bound<'py, PyAny>> {
    let (values, m) = (contiguous(array)?, directions.len());
    let (shape, channels) = match *array.shape() {
        [rows, _] => (vec![rows, m], 1),
        [rows, _, 3] => (vec![rows, m, 3], 3),
        ref other => return Err(shape_error(other)),
    };
    let mut out = vec![T::ZERO; shape.iter().product()];
    if !out.is_empty() {
        let work = Work { functions: values, order, channels, directions };
        Basis::<T>::with_shared(order, |basis| work.run(py, basis, &mut out))?;
    }
    Ok(array_of(py, out, &shape)?.into_any())
}

/// Functions one after the other, with one or three numbers a coefficient, and where their values are wanted.
struct Work<'a, T> {
    functions: &'a [T],
    order: usize,
    channels: usize,
    directions: Directions<'a>,
}

impl<T: Sums> Work<'_, T> {
    /// Numbers of a function.
    fn size(&self) -> usize {
        coefficient_count(self.order) * self.channels
    }

    fn run(&self, py: Python<'_>, basis: &Basis<T>, out: &mut [T]) -> PyResult<()> {
        if self.directions.len() >= BLOCK * BLOCKS_EACH * rayon::current_num_threads() {
            self.share_directions(py, basis, out)
        } else {
            self.share_functions(py, basis, out)
        }
    }

    /// Each thread has some directions, for which it computes the basis and the values of all functions.
    fn share_directions(&self, py: Python<'_>, basis: &Basis<T>, out: &mut [T]) -> PyResult<()> {
        let row = self.directions.len() * self.channels;
        let groups =
            self.functions.chunks(self.size() * FUNCTIONS_TOGETHER).zip(out.chunks_mut(row * FUNCTIONS_TOGETHER));
        for (functions, out) in groups {
            let coefficients = Coefficients::new(functions, self.order, self.channels);
            // The places of the values of each block, in all rows.
            let mut places: Vec<Vec<&mut [T]>> = Vec::new();
            places.resize_with(self.directions.len().div_ceil(BLOCK), Vec::new);
            for row in out.chunks_mut(row) {
                let parts = row.chunks_mut(BLOCK * self.channels);
                places.iter_mut().zip(parts).for_each(|(places, part)| places.push(part));
            }
            for (part, places) in places.chunks_mut(BLOCKS_TOGETHER).enumerate() {
                py.check_signals()?;
                let is_done = py.detach(|| {
                    let blocks = places.par_iter_mut().enumerate();
                    blocks
                        .map_init(
                            || Tiles::new(self.order),
                            |tiles, (k, rows)| {
                                let is_filled = tiles.fill(basis, self.block(part * BLOCKS_TOGETHER + k));
                                multiply(&coefficients, tiles, rows);
                                is_filled
                            },
                        )
                        .reduce(|| true, |a, b| a && b)
                });
                is_done.then_some(()).ok_or_else(no_direction)?;
            }
        }
        Ok(())
    }

    /// The directions of a block.
    fn block(&self, k: usize) -> Directions<'_> {
        self.directions.range(k * BLOCK..self.directions.len().min((k + 1) * BLOCK))
    }

    /// Each thread has some functions, for directions whose basis is computed before.
    fn share_functions(&self, py: Python<'_>, basis: &Basis<T>, out: &mut [T]) -> PyResult<()> {
        let row = self.directions.len() * self.channels;
        let mut tiles = Tiles::new(self.order);
        for k in 0..self.directions.len().div_ceil(BLOCK) {
            py.check_signals()?;
            let is_filled = py.detach(|| {
                let block = self.block(k);
                let is_filled = tiles.fill(basis, block);
                let functions = self.functions.par_chunks(self.size() * FUNCTIONS);
                functions.zip(out.par_chunks_mut(row * FUNCTIONS)).for_each(|(functions, out)| {
                    let coefficients = Coefficients::new(functions, self.order, self.channels);
                    let part = k * BLOCK * self.channels..(k * BLOCK + block.len()) * self.channels;
                    let mut rows: Vec<&mut [T]> = out.chunks_mut(row).map(|row| &mut row[part.clone()]).collect();
                    multiply(&coefficients, &tiles, &mut rows);
                });
                is_filled
            });
            is_filled.then_some(()).ok_or_else(no_direction)?;
        }
        Ok(())
    }
}

fn no_direction() -> PyErr {
    value_error("directions: expected vectors with a length, found one that is zero or not finite")
}
