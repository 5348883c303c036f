//! Irradiance in a few numbers, and their errors.

use lobe::sh::{
    Coefficient, Dir, EncodedIrradiance, EncodingError, Expansion as _, IrradianceEncoding, Rgb, ShVec, encoding_error,
    even_directions, tangent_frame,
};
use numpy::{PyArrayDyn, PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::prelude::*;

use crate::job::answered;
use crate::rows::{array_of, contiguous, do_rows, shape_error, value_error};
use crate::search::search;

/// Irradiances of one encoding, numbers or colors.
#[pyclass(frozen)]
pub(crate) struct Encoded(Kind);

enum Kind {
    Numbers(Vec<EncodedIrradiance<f64>>),
    Colors(Vec<EncodedIrradiance<Rgb<f64>>>),
}

/// An array with its name.
type Named<'py> = (String, Bound<'py, PyArrayDyn<f64>>);

#[pymethods]
impl Encoded {
    /// What is kept, by name: arrays of shape (rows, channels), of a direction (rows, 3).
    fn numbers<'py>(&self, py: Python<'py>) -> PyResult<Vec<Named<'py>>> {
        match &self.0 {
            Kind::Numbers(all) => columns(py, all),
            Kind::Colors(all) => columns(py, all),
        }
    }

    /// Irradiance for unit normals (m, 3): (rows, m), of colors (rows, m, 3).
    fn eval<'py>(
        &self,
        py: Python<'py>,
        normals: PyReadonlyArrayDyn<'py, f64>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let normals: Vec<Dir> = contiguous(&normals)?.as_chunks().0.iter().map(|n| Dir::from_unit(*n)).collect();
        match &self.0 {
            Kind::Numbers(all) => array_of(py, values(py, all, &normals)?, &[all.len(), normals.len()]),
            Kind::Colors(all) => {
                let values = values(py, all, &normals)?;
                array_of(py, bytemuck::cast_vec(values), &[all.len(), normals.len(), 3])
            }
        }
    }
}

fn columns<'py, C: Coefficient<Scalar = f64>>(
    py: Python<'py>,
    all: &[EncodedIrradiance<C>],
) -> PyResult<Vec<Named<'py>>> {
    let rows: Vec<_> = all.iter().map(EncodedIrradiance::numbers).collect();
    let Some(first) = rows.first() else { return Ok(Vec::new()) };
    let column = |(k, (name, values)): (usize, &(String, Vec<f64>))| {
        let column = rows.iter().flat_map(|row| row[k].1.iter().copied()).collect();
        Ok((name.clone(), array_of(py, column, &[rows.len(), values.len()])?))
    };
    first.iter().enumerate().map(column).collect()
}

fn values<C: Coefficient<Scalar = f64>>(
    py: Python<'_>,
    all: &[EncodedIrradiance<C>],
    normals: &[Dir],
) -> PyResult<Vec<C>> {
    do_rows(py, all.len(), normals.len(), 1 << 12, |k, out| {
        for (out, n) in out.iter_mut().zip(normals) {
            *out = all[k].eval(*n);
        }
        Ok(())
    })
}

/// Irradiances `(rows, n²)` or `(rows, n², 3)` in an encoding; `normal` is the geometric one of those of a hemisphere.
#[pyfunction]
pub(crate) fn encode<'py>(
    py: Python<'py>,
    c: PyReadonlyArrayDyn<'py, f64>,
    order: usize,
    name: &str,
    normal: [f64; 3],
) -> PyResult<Encoded> {
    let encoding: IrradianceEncoding = name.parse().map_err(value_error)?;
    let frame = tangent_frame(Dir::from_unit(normal));
    let values = contiguous(&c)?;
    match c.shape() {
        [_, _] => {
            let encoded = search(py, values, order, |f| Ok(encoding.encode(&expansion::<f64>(f)?, frame)))?;
            Ok(Encoded(Kind::Numbers(encoded)))
        }
        [_, _, 3] => {
            let colors: &[Rgb<f64>] = bytemuck::cast_slice(values);
            let encoded = search(py, colors, order, |f| Ok(encoding.encode(&expansion(f)?, frame)))?;
            Ok(Encoded(Kind::Colors(encoded)))
        }
        other => Err(shape_error(other)),
    }
}

/// Name, floats, whether it is of a hemisphere, then mean, RMS and largest error, and the lowest value.
type Row = (&'static str, usize, bool, f64, f64, f64, f64);

/// The errors of all encodings of one irradiance, `(1, n²)` or `(1, n², 3)`, against its own values for as many normals.
#[pyfunction]
pub(crate) fn encoding_errors<'py>(
    py: Python<'py>,
    c: PyReadonlyArrayDyn<'py, f64>,
    normals: usize,
) -> PyResult<Vec<Row>> {
    let values = contiguous(&c)?.to_vec();
    match c.shape() {
        [1, _] => answered(py, normals, move || errors::<f64>(&values, normals))?,
        [1, _, 3] => answered(py, normals, move || errors::<Rgb<f64>>(bytemuck::cast_slice(&values), normals))?,
        other => return Err(shape_error(other)),
    }
    .map_err(value_error)
}

fn errors<C: Coefficient<Scalar = f64>>(f: &[C], normals: usize) -> Result<Vec<Row>, String> {
    let irradiance = expansion(f)?;
    let truth: Vec<(Dir, C)> = even_directions(normals).map(|n| (n, irradiance.eval(n))).collect();
    let row = |encoding: IrradianceEncoding| {
        let EncodingError { mean, rms, max, lowest } = encoding_error(encoding, &irradiance, &truth);
        (encoding.name(), encoding.floats(C::CHANNELS), encoding.is_hemispherical(), mean, rms, max, lowest)
    };
    Ok(IrradianceEncoding::ALL.into_iter().map(row).collect())
}

fn expansion<C: Coefficient>(f: &[C]) -> Result<ShVec<C>, String> {
    ShVec::from_vec(f.to_vec()).ok_or_else(|| "expected n² coefficients".to_owned())
}
