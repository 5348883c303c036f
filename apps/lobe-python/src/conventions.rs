//! Coefficients as other libraries and engines keep them.

use std::path::PathBuf;

use lobe::env::import_coefficients as import_bytes;
use lobe::io::read_file;
use lobe::sh::convention::{ArrayNumbers, CoefficientArray, NamedConvention};
use lobe::sh::encoding::EngineForm;
use lobe::sh::{Coefficient, Expansion as _, Rgb, ShVec};
use numpy::{Complex64, PyArrayDyn, PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::prelude::*;

use crate::job::error_of;
use crate::rows::{array_of, contiguous, shape_error, value_error};

fn named(name: &str) -> PyResult<&'static NamedConvention> {
    NamedConvention::find(name).map_err(|error| value_error(format!("convention: {error}")))
}

/// The name of each convention, what it is, and what it was tried with.
#[pyfunction]
pub(crate) fn conventions() -> Vec<(&'static str, &'static str, &'static str)> {
    NamedConvention::ALL.iter().map(|named| (named.name(), named.description(), named.tried())).collect()
}

/// The number of axes of one function in a convention.
#[pyfunction]
pub(crate) fn convention_axes(name: &str) -> PyResult<usize> {
    Ok(named(name)?.convention().layout.shape(1).len())
}

/// Functions `(rows, n²)` or `(rows, n², 3)` as the library keeps them: `(rows, ..)` or `(rows, 3, ..)`, real or
/// complex.
#[pyfunction]
pub(crate) fn to_convention<'py>(
    py: Python<'py>,
    c: PyReadonlyArrayDyn<'py, f64>,
    name: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let (values, named) = (contiguous(&c)?, named(name)?);
    match *c.shape() {
        [rows, n] => encoded::<f64>(py, values, [rows, n], named),
        [rows, n, 3] => encoded::<Rgb<f64>>(py, bytemuck::cast_slice(values), [rows, n], named),
        _ => Err(shape_error(c.shape())),
    }
}

fn encoded<'py, C: Coefficient<Scalar = f64>>(
    py: Python<'py>,
    functions: &[C],
    [rows, n]: [usize; 2],
    named: &NamedConvention,
) -> PyResult<Bound<'py, PyAny>> {
    let encode = |f: Vec<C>| {
        let f = ShVec::from_vec(f).ok_or_else(|| value_error("expected n² coefficients"))?;
        named.convention().encode(&f).map_err(|error| value_error(format!("{named}: {error}")))
    };
    // An empty batch has the shape of the function that is zero.
    let mut shape = encode(vec![C::ZERO; n])?.shape;
    shape.insert(0, rows);
    let (mut real, mut complex) = (Vec::new(), Vec::new());
    for row in functions.chunks_exact(n) {
        match encode(row.to_vec())?.numbers {
            ArrayNumbers::Real(numbers) => real.extend(numbers),
            ArrayNumbers::Complex(numbers) => complex.extend(numbers.iter().map(|c| Complex64::new(c[0], c[1]))),
        }
        py.check_signals()?;
    }
    if named.convention().harmonics == lobe::sh::convention::Harmonics::Complex {
        return Ok(array_of(py, complex, &shape)?.into_any());
    }
    Ok(array_of(py, real, &shape)?.into_any())
}

/// Functions `(rows, n²)` or `(rows, n², 3)` of arrays of the library, `(rows, ..)` or, if they are colors, `(rows,
/// 3, ..)`.
#[pyfunction]
pub(crate) fn from_convention<'py>(
    py: Python<'py>,
    array: PyReadonlyArrayDyn<'py, Complex64>,
    name: &str,
    are_colors: bool,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let named = named(name)?;
    let &[rows, ref shape @ ..] = array.shape() else { return Err(shape_error(array.shape())) };
    let numbers = contiguous(&array)?;
    let own = if are_colors { shape.get(1..).unwrap_or_default() } else { shape };
    let (_, order) = named.convention().channels_and_order(own, named.name()).map_err(value_error)?;
    let mut out = Vec::new();
    for row in 0..rows {
        let count = numbers.len() / rows;
        let row = numbers[row * count..][..count].iter().map(|c| [c.re, c.im]).collect();
        let array = CoefficientArray { shape: shape.to_vec(), numbers: ArrayNumbers::Complex(row) };
        if are_colors {
            let f: ShVec<Rgb<f64>> = named.convention().decode(&array, named.name()).map_err(value_error)?;
            out.extend(f.coefficients().iter().flat_map(|c| c.to_array()));
        } else {
            let f: ShVec<f64> = named.convention().decode(&array, named.name()).map_err(value_error)?;
            out.extend(f.into_vec());
        }
        py.check_signals()?;
    }
    let n = order * order;
    if are_colors { array_of(py, out, &[rows, n, 3]) } else { array_of(py, out, &[rows, n]) }
}

/// The names of the forms of engines.
#[pyfunction]
pub(crate) fn engine_forms() -> Vec<&'static str> {
    EngineForm::ALL.map(EngineForm::name).to_vec()
}

/// The radiance, `(9, 3)`, whose nine colors a file holds in the form of an engine.
#[pyfunction]
pub(crate) fn import_coefficients<'py>(
    py: Python<'py>,
    path: PathBuf,
    form: &str,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let form: EngineForm = form.parse().map_err(|error| value_error(format!("form: {error}")))?;
    let bytes = py.detach(|| read_file(&path)).map_err(|error| error_of(&error))?;
    let light = import_bytes(&bytes, form, &path.display().to_string()).map_err(|error| error_of(&error))?;
    array_of(py, light.coefficients().iter().flat_map(|c| c.to_array()).collect(), &[9, 3])
}
