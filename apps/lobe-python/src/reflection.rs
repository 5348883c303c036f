//! Reflectance under even light: directional albedos, and the DFG terms of the split sum.

use lobe::env::{Brdf, DfgTable, Ggx, Lambert, Phong, dfg as dfg_terms};
use numpy::{PyArrayDyn, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods as _};
use pyo3::prelude::*;

use crate::job::answered;
use crate::rows::{array_of, contiguous, do_rows, value_error};

/// Integrals, of some ten microseconds each, that are done before the interpreter may stop the work.
const TOGETHER: usize = 1 << 10;

/// An array of double precision.
type Doubles<'py> = Bound<'py, PyArrayDyn<f64>>;

/// The DFG terms A and B for rows of the view's cosine and α: `(rows, 2)`.
#[pyfunction]
pub(crate) fn dfg<'py>(py: Python<'py>, rows: PyReadonlyArray2<'py, f64>) -> PyResult<Doubles<'py>> {
    let arguments = contiguous(&rows)?.as_chunks::<2>().0;
    let terms: Vec<f64> = do_rows(py, arguments.len(), 2, TOGETHER, |k, out| {
        let [cos_v, alpha] = arguments[k];
        let found = dfg_terms(cos_v, alpha);
        out.copy_from_slice(&[found.scale, found.bias]);
        Ok(())
    })?;
    array_of(py, terms, &[arguments.len(), 2])
}

/// The same over a square of cosines by roughnesses, `(size, size, 2)`.
#[pyfunction]
pub(crate) fn dfg_table(py: Python<'_>, size: usize) -> PyResult<Doubles<'_>> {
    let table = answered(py, usize::MAX, move || DfgTable::new(size))?;
    array_of(py, table.texels().iter().flat_map(|dfg| [dfg.scale, dfg.bias]).collect(), &[size, size, 2])
}

/// The directional albedo of a BRDF for the cosine of each view and rows of the BRDF's parameters, `(rows, k)`: `(rows)`.
#[pyfunction]
pub(crate) fn directional_albedo<'py>(
    py: Python<'py>,
    brdf: &str,
    cos_v: PyReadonlyArray1<'py, f64>,
    parameters: PyReadonlyArray2<'py, f64>,
) -> PyResult<Doubles<'py>> {
    let (cosines, all, count) = (contiguous(&cos_v)?, contiguous(&parameters)?, parameters.shape()[1]);
    let of: fn(&[f64], f64) -> f64 = match (brdf, count) {
        ("lambert", 1) => |p, cos_v| Lambert { albedo: p[0] }.directional_albedo(cos_v),
        ("phong", 1) => |p, cos_v| Phong { exponent: p[0] }.directional_albedo(cos_v),
        ("ggx", 2) => |p, cos_v| Ggx { alpha: p[0], f0: p[1] }.directional_albedo(cos_v),
        _ => return Err(value_error(format!("brdf: expected lambert, phong or ggx, found {brdf:?}"))),
    };
    let albedos: Vec<f64> = do_rows(py, cosines.len(), 1, TOGETHER, |k, out| {
        out[0] = of(&all[k * count..][..count], cosines[k]);
        Ok(())
    })?;
    array_of(py, albedos, &[cosines.len()])
}
