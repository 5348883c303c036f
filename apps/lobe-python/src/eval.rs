//! Values of functions towards many directions.

use lobe::sh::basis::{Vectors, coefficient_count};
use lobe::sh::batch::{BasisTiles, Functions, Tiled};
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::forked::with_threads;
use crate::rows::{Number, Numbers, contiguous, empty_array, shape_error, value_error, writable};

/// Directions that a thread has at a time.
const BLOCK: usize = 512;

/// Blocks of directions for each thread from which on threads share directions, and not functions.
const BLOCKS_EACH: usize = 2;

/// Functions that threads have at a time if they share functions: enough that a tile of the basis is read from its cache for most.
const FUNCTIONS: usize = 16;

/// Functions whose values are found before the basis is computed again, if threads share directions: it takes the time of some ten of them.
const FUNCTIONS_TOGETHER: usize = 1024;

/// Products of a coefficient and a value of the basis, for each thread, after which the interpreter may stop the work: some 10 ms.
const PRODUCTS_TOGETHER: usize = 1 << 26;

/// Values of functions, `(rows, n²[, 3])`, towards vectors `(m, 3)` of any length above zero: `(rows, m[, 3])`.
#[pyfunction]
pub(crate) fn eval<'py>(
    py: Python<'py>,
    c: Numbers<'py>,
    order: usize,
    directions: Numbers<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let vectors = match &directions {
        Numbers::Single(array) => Vectors::Single(contiguous(array)?.as_chunks().0),
        Numbers::Double(array) => Vectors::Double(contiguous(array)?.as_chunks().0),
    };
    match c {
        Numbers::Single(array) => eval_typed(py, &array, order, vectors),
        Numbers::Double(array) => eval_typed(py, &array, order, vectors),
    }
}

fn eval_typed<'py, T: Number + Tiled>(
    py: Python<'py>,
    array: &PyReadonlyArrayDyn<'py, T>,
    order: usize,
    vectors: Vectors<'_>,
) -> PyResult<Bound<'py, PyAny>> {
    let (functions, m) = (contiguous(array)?, vectors.len());
    let (shape, channels) = match *array.shape() {
        [rows, _] => (vec![rows, m], 1),
        [rows, _, 3] => (vec![rows, m, 3], 3),
        ref other => return Err(shape_error(other)),
    };
    let out = empty_array::<T>(py, &shape)?;
    if shape.iter().all(|side| *side > 0) {
        let work = Work { functions, order, channels, vectors };
        work.run(py, writable(&out)?.as_slice_mut()?)?;
    }
    Ok(out.into_any())
}

/// Functions one after the other, with one or three numbers a coefficient, and where their values are wanted.
struct Work<'a, T> {
    functions: &'a [T],
    order: usize,
    channels: usize,
    vectors: Vectors<'a>,
}

impl<T: Number + Tiled> Work<'_, T> {
    /// Numbers of a function.
    fn size(&self) -> usize {
        coefficient_count(self.order) * self.channels
    }

    /// Numbers of the values of a function.
    fn row(&self) -> usize {
        self.vectors.len() * self.channels
    }

    fn run(&self, py: Python<'_>, out: &mut [T]) -> PyResult<()> {
        let threads = rayon::current_num_threads();
        if threads == 1 || self.vectors.len() >= BLOCK * BLOCKS_EACH * threads {
            self.share_directions(py, threads, out)
        } else {
            self.share_functions(py, out)
        }
    }

    /// Each thread has some directions, for which it computes the basis and the values of all functions.
    fn share_directions(&self, py: Python<'_>, threads: usize, out: &mut [T]) -> PyResult<()> {
        let groups = self
            .functions
            .chunks(self.size() * FUNCTIONS_TOGETHER)
            .zip(out.chunks_mut(self.row() * FUNCTIONS_TOGETHER));
        for (functions, out) in groups {
            let blocks = self.vectors.len().div_ceil(BLOCK);
            let together = (PRODUCTS_TOGETHER / (BLOCK * functions.len())).max(1) * threads;
            let coefficients = Functions::new(functions, self.order, self.channels);
            // The places of the values of each block, in all rows.
            let mut places: Vec<Vec<&mut [T]>> = Vec::new();
            places.resize_with(blocks, || Vec::with_capacity(functions.len() / self.size()));
            for row in out.chunks_mut(self.row()) {
                let parts = row.chunks_mut(BLOCK * self.channels);
                places.iter_mut().zip(parts).for_each(|(places, part)| places.push(part));
            }
            for (part, places) in places.chunks_mut(together).enumerate() {
                py.check_signals()?;
                let block =
                    |k: usize, rows: &mut [&mut [T]]| coefficients.eval_into(self.block(part * together + k), rows);
                let is_done = py.detach(|| {
                    if threads == 1 {
                        // Not by the one thread of the pool, which first would have to be woken.
                        return places.iter_mut().enumerate().fold(true, |all, (k, rows)| block(k, rows) && all);
                    }
                    let parts = places.par_iter_mut().enumerate();
                    with_threads(|| parts.map(|(k, rows)| block(k, rows)).reduce(|| true, |a, b| a && b))
                });
                is_done.then_some(()).ok_or_else(no_direction)?;
            }
        }
        Ok(())
    }

    /// The directions of a block.
    fn block(&self, k: usize) -> Vectors<'_> {
        self.vectors.range(k * BLOCK..self.vectors.len().min((k + 1) * BLOCK))
    }

    /// Each thread has some functions, for directions whose basis is computed before.
    fn share_functions(&self, py: Python<'_>, out: &mut [T]) -> PyResult<()> {
        let row = self.row();
        let mut tiles = BasisTiles::new(self.order);
        for k in 0..self.vectors.len().div_ceil(BLOCK) {
            py.check_signals()?;
            let is_filled = py.detach(|| {
                let block = self.block(k);
                let part = k * BLOCK * self.channels..(k * BLOCK + block.len()) * self.channels;
                if out.len() == row {
                    return Functions::new(self.functions, self.order, self.channels)
                        .eval_into(block, &mut [&mut out[part]]);
                }
                let is_filled = tiles.fill(block);
                let parts = self.functions.par_chunks(self.size() * FUNCTIONS).zip(out.par_chunks_mut(row * FUNCTIONS));
                let eval = |(functions, out): (&[T], &mut [T])| {
                    let mut rows: Vec<&mut [T]> = out.chunks_mut(row).map(|row| &mut row[part.clone()]).collect();
                    Functions::new(functions, self.order, self.channels).eval_tiles_into(&tiles, &mut rows);
                };
                with_threads(|| parts.for_each(eval));
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
