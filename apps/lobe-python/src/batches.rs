//! Work on many functions side by side, for which a processor has wide instructions.

use bytemuck::cast_slice;
use lobe::sh::basis::coefficient_count;
use lobe::sh::batch::ShBatch;
use lobe::sh::rotation::RotationMatrices;
use lobe::sh::simd::LANES;
use lobe::sh::{Coefficient, Rgb, Rotation};
use numpy::{PyArrayDyn, PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::prelude::*;

use crate::rows::{QUICK_ROWS_TOGETHER, array_of, contiguous, do_blocks, shape_error};

/// Rows side by side: whole blocks of sixteen functions, one to four as their coefficients stay in the first cache.
fn block(width: usize) -> usize {
    const COEFFICIENTS: usize = 1024;
    LANES * (COEFFICIENTS / (LANES * width.max(1))).clamp(1, 4)
}

/// Fills arrays of rows with what `work` makes of batches from as many rows of each source, all of one shape.
fn map_batches<'py, const N: usize>(
    py: Python<'py>,
    sources: [&PyReadonlyArrayDyn<'py, f32>; N],
    order: usize,
    work: impl Fn([ShBatch; N], &mut ShBatch) + Sync,
) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
    let mut values = [&[][..]; N];
    for (values, source) in values.iter_mut().zip(sources) {
        *values = contiguous(source)?;
    }
    let width = coefficient_count(order);
    match *sources[0].shape() {
        [rows, n] if n == width => array_of(py, fill(py, rows, order, values, work)?, sources[0].shape()),
        [rows, n, 3] if n == width => {
            let out: Vec<Rgb<f32>> = fill(py, rows, order, values.map(cast_slice), work)?;
            array_of(py, bytemuck::cast_vec(out), sources[0].shape())
        }
        ref other => Err(shape_error(other)),
    }
}

/// The results of the work, row after row.
fn fill<C: Coefficient<Scalar = f32>, const N: usize>(
    py: Python<'_>,
    rows: usize,
    order: usize,
    sources: [&[C]; N],
    work: impl Fn([ShBatch; N], &mut ShBatch) + Sync,
) -> PyResult<Vec<C>> {
    let width = coefficient_count(order);
    do_blocks(py, rows, width, (block(width), QUICK_ROWS_TOGETHER), |first, out| {
        let from = sources.map(|source| ShBatch::from_rows(order, &source[first * width..][..out.len()]));
        let mut to = ShBatch::zero(order, C::CHANNELS * out.len() / width);
        work(from, &mut to);
        to.rows_into(out);
        Ok(())
    })
}

/// Functions turned by one rotation.
pub(crate) fn rotate<'py>(
    py: Python<'py>,
    array: &PyReadonlyArrayDyn<'py, f32>,
    order: usize,
    rotation: &Rotation,
) -> PyResult<Bound<'py, PyAny>> {
    let matrices = RotationMatrices::new(rotation, order);
    Ok(map_batches(py, [array], order, |[f], turned| f.rotated_into(&matrices, turned))?.into_any())
}

/// Products of functions of one order, cut off at it.
pub(crate) fn product<'py>(
    py: Python<'py>,
    a: &PyReadonlyArrayDyn<'py, f32>,
    b: &PyReadonlyArrayDyn<'py, f32>,
    order: usize,
) -> PyResult<Bound<'py, PyAny>> {
    Ok(map_batches(py, [a, b], order, |[a, b], product| a.product_into(&b, product))?.into_any())
}
