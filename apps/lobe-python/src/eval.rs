//! Values of functions towards many directions.

use lobe::sh::simd::Machine;
use lobe::sh::{Basis, Coefficient, Rgb, coefficient_count};
use numpy::{PyReadonlyArray2, PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::rows::{Number, Numbers, array_of, contiguous, shape_error};

/// Directions whose basis is computed at once: at order 10 in double precision 400 KiB.
const BLOCK: usize = 512;

/// Values of functions, `(rows, n²[, 3])`, towards unit vectors `(m, 3)`: `(rows, m[, 3])`.
#[pyfunction]
pub(crate) fn eval<'py>(
    py: Python<'py>,
    c: Numbers<'py>,
    order: usize,
    directions: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let directions = contiguous(&directions)?.as_chunks::<3>().0.to_vec();
    match c {
        Numbers::Single(array) => eval_typed(py, &array, order, &directions),
        Numbers::Double(array) => eval_typed(py, &array, order, &directions),
    }
}

fn eval_typed<'py, T: Number>(
    py: Python<'py>,
    array: &PyReadonlyArrayDyn<'py, T>,
    order: usize,
    directions: &[[f64; 3]],
) -> PyResult<Bound<'py, PyAny>>
where
    Rgb<T>: Coefficient<Scalar = T> + bytemuck::Pod,
{
    let (values, m) = (contiguous(array)?, directions.len());
    match *array.shape() {
        [rows, _] => Ok(array_of(py, values_of(py, values, order, directions)?, &[rows, m])?.into_any()),
        [rows, _, 3] => {
            let out = values_of::<Rgb<T>>(py, bytemuck::cast_slice(values), order, directions)?;
            Ok(array_of::<T>(py, bytemuck::cast_vec(out), &[rows, m, 3])?.into_any())
        }
        ref other => Err(shape_error(other)),
    }
}

/// The values of one function after the other. Blocks of directions run in parallel for one function, functions for several.
fn values_of<C: Coefficient>(
    py: Python<'_>,
    functions: &[C],
    order: usize,
    directions: &[[f64; 3]],
) -> PyResult<Vec<C>> {
    let (count, m) = (coefficient_count(order), directions.len());
    let rows = functions.len() / count.max(1);
    let mut out = vec![C::ZERO; rows * m];
    if out.is_empty() || count == 0 {
        return Ok(out);
    }
    Basis::<C::Scalar>::with_shared(order, |basis| {
        if rows == 1 {
            return py.detach(|| {
                let blocks = out.par_chunks_mut(BLOCK).zip(directions.par_chunks(BLOCK));
                blocks.for_each(|(out, block)| add_block(functions, &planes(basis, order, block), out));
                Ok(())
            });
        }
        for (k, block) in directions.chunks(BLOCK).enumerate() {
            py.check_signals()?;
            py.detach(|| {
                let planes = planes(basis, order, block);
                let pairs = functions.par_chunks_exact(count).zip(out.par_chunks_exact_mut(m));
                pairs.for_each(|(f, out)| add_block(f, &planes, &mut out[k * BLOCK..][..block.len()]));
            });
        }
        Ok::<_, PyErr>(())
    })?;
    Ok(out)
}

/// The basis towards a block of directions, a plane for each function.
fn planes<T: lobe::sh::Real>(basis: &Basis<T>, order: usize, block: &[[f64; 3]]) -> Vec<T> {
    let component = |k: usize| -> Vec<T> { block.iter().map(|s| T::from_f64(s[k])).collect() };
    let components = [component(0), component(1), component(2)];
    let mut planes = vec![T::ZERO; coefficient_count(order) * block.len()];
    basis.eval_many_into(components.each_ref().map(Vec::as_slice), &mut planes);
    planes
}

/// Adds the values of a function, whose basis is given in planes, by the widest instructions of the machine.
fn add_block<C: Coefficient>(f: &[C], planes: &[C::Scalar], out: &mut [C]) {
    Machine::detect().arch().dispatch(|| add_block_inline(f, planes, out));
}

/// Directions whose sums stay in registers.
const TOGETHER: usize = 32;

#[inline(always)]
fn add_block_inline<C: Coefficient>(f: &[C], planes: &[C::Scalar], out: &mut [C]) {
    let count = out.len();
    let (whole, rest) = out.as_chunks_mut::<TOGETHER>();
    for (k, out) in whole.iter_mut().enumerate() {
        let mut sums = [C::ZERO; TOGETHER];
        for (c, plane) in f.iter().zip(planes.chunks_exact(count)) {
            if let Some(plane) = plane[k * TOGETHER..].first_chunk::<TOGETHER>() {
                for lane in 0..TOGETHER {
                    sums[lane] += c.scale(plane[lane]);
                }
            }
        }
        *out = sums;
    }
    let done = whole.len() * TOGETHER;
    for (c, plane) in f.iter().zip(planes.chunks_exact(count)) {
        for (out, y) in rest.iter_mut().zip(&plane[done..]) {
            *out += c.scale(*y);
        }
    }
}
