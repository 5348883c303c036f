//! Arrays as rows of coefficients.

use std::time::{Duration, Instant};

use lobe::io::one_line;
use lobe::sh::{Coefficient, Real, Rgb};
use numpy::ndarray::Dimension;
use numpy::{
    Element, PyArray1, PyArrayDyn, PyArrayMethods as _, PyReadonlyArray, PyReadonlyArrayDyn, PyReadwriteArrayDyn,
    PyUntypedArrayMethods as _,
};
use pyo3::exceptions::{PyMemoryError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyTuple;
use rayon::prelude::*;

use crate::forked::with_threads;

/// Rows that are done before the interpreter may stop the work, at most.
pub(crate) const ROWS_TOGETHER: usize = 1 << 12;

/// The first of them, from which on they double as long as they are quick: a function of order 16 without ringing takes 30 ms.
const FIRST_ROWS: usize = 16;

/// How long work may go on before the interpreter may stop it: less than anyone waits for.
pub(crate) const UNSTOPPED: Duration = Duration::from_millis(50);

/// Numbers of the first rows of quick work: some milliseconds of products of order 10, which take longest.
const FIRST_NUMBERS: usize = 1 << 18;

/// [`ROWS_TOGETHER`] of quick work, in which threads would else wait for each other too often.
pub(crate) const QUICK_ROWS_TOGETHER: usize = 1 << 16;

/// An array of single or double precision; anything else is a `TypeError`.
pub(crate) enum Numbers<'py> {
    Single(PyReadonlyArrayDyn<'py, f32>),
    Double(PyReadonlyArrayDyn<'py, f64>),
}

impl<'a, 'py> FromPyObject<'a, 'py> for Numbers<'py> {
    type Error = PyErr;

    // Derived, this makes an exception for what is not of the first kind, which takes longer than to turn a function.
    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(array) = given.cast::<PyArrayDyn<f64>>() {
            Ok(Self::Double(array.try_readonly()?))
        } else if let Ok(array) = given.cast::<PyArrayDyn<f32>>() {
            Ok(Self::Single(array.try_readonly()?))
        } else {
            Err(PyTypeError::new_err("expected an array of float32 or float64"))
        }
    }
}

impl Numbers<'_> {
    /// The length of the first axis.
    pub(crate) fn rows(&self) -> usize {
        let shape = match self {
            Self::Single(array) => array.shape(),
            Self::Double(array) => array.shape(),
        };
        shape.first().copied().unwrap_or(0)
    }
}

/// `f32` or `f64`.
pub(crate) trait Number: Real + Element + bytemuck::Pod {}

impl Number for f32 {}

impl Number for f64 {}

/// Work on one row of coefficients of precision `T`, numbers or colors.
pub(crate) trait RowWork<T>: Sync {
    /// Rows that are done before the interpreter may stop the work.
    const TOGETHER: usize = ROWS_TOGETHER;

    /// Fills `out`, which is zero before, from a row; an error says what is wrong with the row.
    fn run<C: Coefficient<Scalar = T>>(&self, row: &[C], out: &mut [C]) -> Result<(), String>;
}

/// Does work on each row of an array of shape `(rows, n)` or `(rows, n, 3)`; the result has `width` instead of n. The work is given
/// for both precisions.
pub(crate) fn map_rows<'py>(
    py: Python<'py>,
    numbers: &Numbers<'py>,
    width: usize,
    (single, double): (&impl RowWork<f32>, &impl RowWork<f64>),
) -> PyResult<Bound<'py, PyAny>> {
    match numbers {
        Numbers::Single(array) => Ok(map_typed(py, array, width, single)?.into_any()),
        Numbers::Double(array) => Ok(map_typed(py, array, width, double)?.into_any()),
    }
}

/// The same for one precision.
pub(crate) fn map_typed<'py, T: Number, W: RowWork<T>>(
    py: Python<'py>,
    array: &PyReadonlyArrayDyn<'py, T>,
    width: usize,
    work: &W,
) -> PyResult<Bound<'py, PyArrayDyn<T>>>
where
    Rgb<T>: Coefficient<Scalar = T> + bytemuck::Pod,
{
    let shape = array.shape().to_vec();
    let values = contiguous(array)?;
    let mut out_shape = shape.clone();
    match shape[..] {
        [rows, n] => {
            out_shape[1] = width;
            let out = do_rows(py, rows, width, W::TOGETHER, |k, out| work.run(&values[k * n..][..n], out))?;
            array_of(py, out, &out_shape)
        }
        [rows, n, 3] => {
            out_shape[1] = width;
            let values: &[Rgb<T>] = bytemuck::cast_slice(values);
            let out = do_rows(py, rows, width, W::TOGETHER, |k, out| work.run(&values[k * n..][..n], out))?;
            array_of(py, bytemuck::cast_vec(out), &out_shape)
        }
        _ => Err(shape_error(&shape)),
    }
}

/// The rows in parallel, without the interpreter's lock; Ctrl-C stops between some of them. `work(k, out)` fills row `k`, which is
/// zero before, or says what is wrong with it.
pub(crate) fn do_rows<C: Coefficient>(
    py: Python<'_>,
    rows: usize,
    width: usize,
    together: usize,
    work: impl Fn(usize, &mut [C]) -> Result<(), String> + Sync,
) -> PyResult<Vec<C>> {
    do_blocks(py, rows, width, (1, together), work)
}

/// The same for `block` rows at a time, the last time fewer: `work(k, out)` fills the rows from `k` on that `out` has room for. What is wrong
/// with one of them is told of the first of its block.
pub(crate) fn do_blocks<C: Coefficient>(
    py: Python<'_>,
    rows: usize,
    width: usize,
    (block, together): (usize, usize),
    work: impl Fn(usize, &mut [C]) -> Result<(), String> + Sync,
) -> PyResult<Vec<C>> {
    let mut out = zeros(py, rows, width)?;
    if out.is_empty() {
        return Ok(out);
    }
    if rows <= block {
        // To wake another thread takes longer than most functions.
        py.detach(|| with_threads(|| work(0, &mut out))).map_err(PyValueError::new_err)?;
        return Ok(out);
    }
    // Quick work begins with enough for all threads.
    let is_quick = together > ROWS_TOGETHER;
    let mut pace = Pace::new(if is_quick { FIRST_NUMBERS.div_ceil(width) } else { FIRST_ROWS }, together);
    let (mut first, mut rest) = (0, &mut out[..]);
    while !rest.is_empty() {
        py.check_signals()?;
        let (part, behind) = rest.split_at_mut((width * pace.rows.next_multiple_of(block)).min(rest.len()));
        let (count, begun) = (part.len() / width, Instant::now());
        let done = py.detach(|| {
            let blocks = part.par_chunks_mut(width * block).enumerate();
            let work = |(k, out): (usize, &mut [C])| {
                let row = first + k * block;
                work(row, out).err().map(|fault| (row, fault))
            };
            // The first row at fault, for any number of threads.
            with_threads(|| blocks.filter_map(work).min_by_key(|(row, _)| *row))
        });
        if let Some((row, fault)) = done {
            return Err(PyValueError::new_err(format!("function {row}: {fault}")));
        }
        pace.took(begun.elapsed());
        (first, rest) = (first + count, behind);
    }
    Ok(out)
}

/// `rows` times `width` zeros; where there is no memory for them `MemoryError`.
pub(crate) fn zeros<C: Coefficient>(py: Python<'_>, rows: usize, width: usize) -> PyResult<Vec<C>> {
    let mut out = Vec::new();
    let room = rows.checked_mul(width).filter(|count| out.try_reserve_exact(*count).is_ok());
    let Some(count) = room else {
        let text = format!("expected room for {rows} rows of {width} numbers, found none; give fewer at a time");
        return Err(PyMemoryError::new_err(text));
    };
    py.detach(|| out.resize(count, C::ZERO));
    Ok(out)
}

/// How many rows are done before the interpreter is asked again. What comes out does not depend on it.
pub(crate) struct Pace {
    pub(crate) rows: usize,
    most: usize,
}

impl Pace {
    pub(crate) fn new(first: usize, most: usize) -> Self {
        Self { rows: first.min(most), most }
    }

    /// Twice as many if they were quick, half as many if they were slow.
    pub(crate) fn took(&mut self, time: Duration) {
        if time < UNSTOPPED / 2 {
            self.rows = (2 * self.rows).min(self.most);
        } else if time > 2 * UNSTOPPED {
            self.rows = (self.rows / 2).max(1);
        }
    }
}

/// A new array of a shape, whose numbers are to be written: by `numpy.empty`, which, unlike a vector of zeros, costs no pass over memory.
pub(crate) fn empty_array<'py, T: Element>(py: Python<'py>, shape: &[usize]) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    static EMPTY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let empty = EMPTY.import(py, "numpy", "empty")?;
    let shape = PyTuple::new(py, shape)?;
    Ok(empty.call1((shape, T::get_dtype(py)))?.cast_into()?)
}

/// The array, to be written; it is ours alone.
pub(crate) fn writable<'py, T: Element>(array: &Bound<'py, PyArrayDyn<T>>) -> PyResult<PyReadwriteArrayDyn<'py, T>> {
    Ok(array.try_readwrite()?)
}

/// A numpy array of numbers and a shape.
pub(crate) fn array_of<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    PyArray1::from_vec(py, values).reshape(shape)
}

/// The numbers of an array in the order of its shape.
pub(crate) fn contiguous<'a, T: Element, D: Dimension>(array: &'a PyReadonlyArray<'_, T, D>) -> PyResult<&'a [T]> {
    array.as_slice().map_err(|_| PyValueError::new_err("expected a contiguous array"))
}

pub(crate) fn shape_error(found: &[usize]) -> PyErr {
    PyValueError::new_err(format!("expected an array of shape (rows, n) or (rows, n, 3), found {found:?}"))
}

/// An error of the library as a `ValueError`.
pub(crate) fn value_error(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(one_line(&error.to_string()))
}
