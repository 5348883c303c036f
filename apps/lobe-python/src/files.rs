//! Files of expansions.

use std::path::PathBuf;

use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::{FileCoefficients, ShFile, read_sh_json, write_sh_json};
use lobe::sh::{Expansion as _, Rgb, ShError, ShVec};
use numpy::{PyArrayDyn, PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

use crate::rows::{array_of, contiguous, shape_error, value_error};

/// An error of the library: of the system an `OSError`, else a `ValueError`.
fn error_of(error: ShError) -> PyErr {
    match error {
        ShError::Io { .. } => PyOSError::new_err(error.to_string()),
        other => value_error(other),
    }
}

/// The coefficients of a .sh.json file, `(n²)` or `(n², 3)`, and the name of its quantity.
#[pyfunction]
pub(crate) fn load_sh<'py>(py: Python<'py>, path: PathBuf) -> PyResult<(Bound<'py, PyArrayDyn<f64>>, &'static str)> {
    let ShFile { quantity, coefficients } = py.detach(|| read_sh_json(path)).map_err(error_of)?;
    let array = match coefficients {
        FileCoefficients::Scalar(f) => array_of(py, f.coefficients().to_vec(), &[f.coefficients().len()])?,
        FileCoefficients::Rgb(f) => {
            let numbers = f.coefficients().iter().flat_map(|c| c.to_array()).collect();
            array_of(py, numbers, &[f.coefficients().len(), 3])?
        }
    };
    Ok((array, quantity.name()))
}

/// Writes the bytes of the command.
#[pyfunction]
pub(crate) fn save_sh(py: Python<'_>, c: PyReadonlyArrayDyn<'_, f64>, quantity: &str, path: PathBuf) -> PyResult<()> {
    let quantity: Quantity = quantity.parse().map_err(value_error)?;
    let numbers = contiguous(&c)?;
    let none = || value_error("expected n² coefficients");
    let coefficients = match *c.shape() {
        [_] => FileCoefficients::Scalar(ShVec::from_vec(numbers.to_vec()).ok_or_else(none)?),
        [_, 3] => {
            let colors = numbers.as_chunks::<3>().0.iter().map(|c| Rgb::from(*c)).collect();
            FileCoefficients::Rgb(ShVec::from_vec(colors).ok_or_else(none)?)
        }
        _ => return Err(shape_error(c.shape())),
    };
    let file = ShFile { quantity, coefficients };
    py.detach(|| write_sh_json(path, &file)).map_err(error_of)
}
