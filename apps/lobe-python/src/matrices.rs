//! Transfer matrices: the light that arrives, at vertices or at points in space.

use std::path::PathBuf;

use lobe::io::Job;
use lobe::prt::{
    Neighborhood, PrtError, Recipe, TransferMatrices, read_matrices, read_neighborhood, write_matrices,
    write_neighborhood,
};
use lobe::sh::{Expansion as _, Rgb};
use numpy::{PyArrayDyn, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::forked::with_threads;
use crate::job::{answered, error_of};
use crate::rows::{array_of, contiguous, do_rows, value_error};

/// Rows of matrices that are looked up before the interpreter may stop the work.
const PLACES_TOGETHER: usize = 1 << 12;

/// Transfer matrices that were baked, by `lobe bake --mode glossy` or `--grid`.
#[pyclass(frozen, module = "lobe")]
pub(crate) struct Matrices(Kind);

enum Kind {
    AtVertices(TransferMatrices),
    InGrid(Neighborhood),
}

/// The matrices of a .safetensors file, of vertices or, if `is_grid`, of a grid.
#[pyfunction]
pub(crate) fn load_matrices(py: Python<'_>, path: PathBuf, is_grid: bool) -> PyResult<Matrices> {
    let read = move || -> Result<Kind, PrtError> {
        Ok(match is_grid {
            false => Kind::AtVertices(read_matrices(&path)?.0),
            true => Kind::InGrid(read_neighborhood(&path)?.0),
        })
    };
    answered(py, usize::MAX, read)?.map(Matrices).map_err(|error| error_of(&error))
}

impl Matrices {
    fn all(&self) -> &TransferMatrices {
        match &self.0 {
            Kind::AtVertices(matrices) => matrices,
            Kind::InGrid(neighborhood) => neighborhood.matrices(),
        }
    }
}

fn colors_of(light: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Rgb<f64>>> {
    Ok(contiguous(light)?.as_chunks::<3>().0.iter().map(|c| Rgb::from(*c)).collect())
}

#[pymethods]
impl Matrices {
    /// The number of bands.
    #[getter]
    fn order(&self) -> usize {
        self.all().order()
    }

    /// The number of points.
    fn __len__(&self) -> usize {
        self.all().points()
    }

    /// Points along x, y and z of a grid, and two corners of its box.
    #[getter]
    fn grid(&self) -> Option<([usize; 3], [[f64; 3]; 2])> {
        match &self.0 {
            Kind::AtVertices(_) => None,
            Kind::InGrid(neighborhood) => Some((neighborhood.grid().counts(), neighborhood.grid().corners())),
        }
    }

    /// The coefficients, `(points, n², n²)` or `(points, 3, n², n²)`.
    fn coefficients<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let (all, bands) = (self.all(), self.order().pow(2));
        let mut shape = vec![all.points(), bands, bands];
        if all.channels().count() == 3 {
            shape.insert(1, 3);
        }
        array_of(py, all.coefficients().to_vec(), &shape)
    }

    /// Writes the matrices as a .safetensors file, of which [`load_matrices`] makes the same. How they were made is not in it.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let recipe = Recipe::default();
        let written = py.detach(|| match &self.0 {
            Kind::AtVertices(matrices) => write_matrices(&path, matrices, &recipe, Job::default()),
            Kind::InGrid(neighborhood) => {
                write_neighborhood(&path, neighborhood.grid(), neighborhood.matrices(), &recipe, Job::default())
            }
        });
        written.map_err(|error| error_of(&error))
    }

    /// The light that arrives at every point under light `(n², 3)`: `(points, n², 3)`.
    fn incident<'py>(
        &self,
        py: Python<'py>,
        light: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let (all, bands, light) = (self.all(), self.order().pow(2), colors_of(&light)?);
        let mut out = vec![Rgb::new(0.0, 0.0, 0.0); all.points() * bands];
        py.detach(|| with_threads(|| all.incident_into(&light, &mut out)));
        array_of(py, bytemuck::cast_vec(out), &[all.points(), bands, 3])
    }

    /// The light that arrives at places `(m, 3)` of the scene's world, between the points of a grid: `(m, n², 3)`.
    fn incident_at<'py>(
        &self,
        py: Python<'py>,
        light: PyReadonlyArray2<'py, f64>,
        places: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let Kind::InGrid(neighborhood) = &self.0 else {
            return Err(value_error(
                "expected matrices of a grid, which are looked up at places; found those of vertices",
            ));
        };
        let (light, bands) = (colors_of(&light)?, self.order().pow(2));
        let places = contiguous(&places)?.as_chunks::<3>().0;
        let found = do_rows(py, places.len(), bands, PLACES_TOGETHER, |k, out: &mut [Rgb<f64>]| {
            out.copy_from_slice(neighborhood.incident(places[k], &light).coefficients());
            Ok(())
        })?;
        array_of(py, bytemuck::cast_vec(found), &[places.len(), bands, 3])
    }
}
