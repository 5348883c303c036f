//! Arrays as rows of coefficients.

use lobe::sh::{Coefficient, Real, Rgb};
use numpy::ndarray::Dimension;
use numpy::{
    Element, PyArray1, PyArrayDyn, PyArrayMethods as _, PyReadonlyArray, PyReadonlyArrayDyn, PyUntypedArrayMethods as _,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

/// Rows that are done before the interpreter may stop the work: some milliseconds even of the slowest kind.
const ROWS_TOGETHER: usize = 4096;

/// An array of single or double precision; anything else is a `TypeError`.
#[derive(FromPyObject)]
pub(crate) enum Numbers<'py> {
    Single(PyReadonlyArrayDyn<'py, f32>),
    Double(PyReadonlyArrayDyn<'py, f64>),
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
pub(crate) trait Number: Real + Element + bytemuck::Pod {
    /// `self * factor + term`, rounded once: an instruction of most machines, slow where there is none.
    fn fused(self, factor: Self, term: Self) -> Self;
}

impl Number for f32 {
    #[inline(always)]
    fn fused(self, factor: Self, term: Self) -> Self {
        self.mul_add(factor, term)
    }
}

impl Number for f64 {
    #[inline(always)]
    fn fused(self, factor: Self, term: Self) -> Self {
        self.mul_add(factor, term)
    }
}

/// Work on one row of coefficients of precision `T`, numbers or colors.
pub(crate) trait RowWork<T>: Sync {
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

fn map_typed<'py, T: Number>(
    py: Python<'py>,
    array: &PyReadonlyArrayDyn<'py, T>,
    width: usize,
    work: &impl RowWork<T>,
) -> PyResult<Bound<'py, PyArrayDyn<T>>>
where
    Rgb<T>: Coefficient<Scalar = T> + bytemuck::Pod,
{
    let shape = array.shape().to_vec();
    let values = contiguous(array)?;
    let mut out_shape = shape.clone();
    match shape[..] {
        [_, n] => {
            out_shape[1] = width;
            let out = do_rows(py, values, n, width, work)?;
            array_of(py, out, &out_shape)
        }
        [_, n, 3] => {
            out_shape[1] = width;
            let out = do_rows::<Rgb<T>>(py, bytemuck::cast_slice(values), n, width, work)?;
            array_of(py, bytemuck::cast_vec(out), &out_shape)
        }
        _ => Err(shape_error(&shape)),
    }
}

/// The rows in parallel, without the interpreter's lock; Ctrl-C stops between some thousands of them.
fn do_rows<C: Coefficient>(
    py: Python<'_>,
    values: &[C],
    n: usize,
    width: usize,
    work: &impl RowWork<C::Scalar>,
) -> PyResult<Vec<C>> {
    let rows = values.len() / n.max(1);
    let mut out = vec![C::ZERO; rows * width];
    if n == 0 || width == 0 {
        return Ok(out);
    }
    let parts = values.chunks(n * ROWS_TOGETHER).zip(out.chunks_mut(width * ROWS_TOGETHER));
    for (part, (values, out)) in parts.enumerate() {
        py.check_signals()?;
        let done = py.detach(|| {
            let rows = values.par_chunks_exact(n).zip(out.par_chunks_exact_mut(width)).enumerate();
            // The first row at fault, for any number of threads.
            let faults = rows.filter_map(|(k, (row, out))| work.run(row, out).err().map(|fault| (k, fault)));
            faults.min_by_key(|(k, _)| *k)
        });
        if let Some((k, fault)) = done {
            let row = part * ROWS_TOGETHER + k;
            return Err(PyValueError::new_err(if rows > 1 { format!("function {row}: {fault}") } else { fault }));
        }
    }
    Ok(out)
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
    PyValueError::new_err(error.to_string())
}
