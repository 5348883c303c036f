//! Area lights of radiance 1: what they send to surfaces, exactly and in the approximations of games.

use lobe::env::{AreaLight as _, DiscLight, ParallelBeam, PointLight, PolygonLight, SphereLight, VectorIrradiance};
use lobe::sh::Dir;
use numpy::{PyArrayDyn, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::job::error_of;
use crate::rows::{array_of, contiguous, do_rows, value_error};

/// Places that are lit before the interpreter may stop the work; each takes a microsecond or a few.
const TOGETHER: usize = 1 << 14;

/// An array of double precision.
type Doubles<'py> = Bound<'py, PyArrayDyn<f64>>;

/// An area light.
#[pyclass(frozen, module = "lobe")]
pub(crate) struct AreaLight(Shape);

enum Shape {
    Sphere(SphereLight),
    Disc(DiscLight),
    Polygon(PolygonLight),
}

impl Shape {
    /// Whether a place lies in a ball, where its light comes from everywhere.
    fn is_inside(&self, place: &[f64; 3]) -> bool {
        let Self::Sphere(SphereLight { center, radius }) = self else { return false };
        let squared: f64 = place.iter().zip(center).map(|(a, b)| (a - b).powi(2)).sum();
        squared.sqrt() <= *radius
    }

    fn irradiance(&self, place: [f64; 3], normal: Dir) -> f64 {
        match self {
            Self::Sphere(light) => light.irradiance(place, normal),
            Self::Disc(light) => light.irradiance(place, normal),
            Self::Polygon(light) => light.irradiance(place, normal),
        }
    }

    fn vector_irradiance(&self, place: [f64; 3]) -> VectorIrradiance<f64> {
        match self {
            Self::Sphere(light) => light.vector_irradiance(place),
            Self::Disc(light) => light.vector_irradiance(place),
            Self::Polygon(light) => light.vector_irradiance(place),
        }
    }

    fn as_point(&self) -> PointLight {
        match self {
            Self::Sphere(light) => light.as_point(),
            Self::Disc(light) => light.as_point(),
            Self::Polygon(light) => light.as_point(),
        }
    }

    fn as_beam(&self, place: [f64; 3]) -> Option<ParallelBeam> {
        match self {
            Self::Sphere(light) => ParallelBeam::of(light, place),
            Self::Disc(light) => ParallelBeam::of(light, place),
            Self::Polygon(light) => ParallelBeam::of(light, place),
        }
    }

    /// Numbers of each place, `width` of them, which have to be finite.
    fn each(
        &self,
        py: Python<'_>,
        places: &[[f64; 3]],
        width: usize,
        work: impl Fn(usize, &mut [f64]) + Sync,
    ) -> PyResult<Vec<f64>> {
        let refused = |place: &[f64; 3]| self.is_inside(place);
        if let Some(k) = places.iter().position(refused) {
            let place = places[k];
            return Err(value_error(format!("places: expected some outside of the ball, found {place:?}, number {k}")));
        }
        let found = do_rows(py, places.len(), width, TOGETHER, |k, out| {
            work(k, out);
            Ok(())
        })?;
        match found.iter().position(|number| !number.is_finite()) {
            None => Ok(found),
            Some(at) => {
                let (k, place) = (at / width, places[at / width]);
                Err(value_error(format!("places: expected some beside the light, found {place:?} on it, number {k}")))
            }
        }
    }

    /// A number for each place and the unit vector that it faces.
    fn facing<'py>(
        &self,
        py: Python<'py>,
        places: &PyReadonlyArray2<'py, f64>,
        normals: &PyReadonlyArray2<'py, f64>,
        of: impl Fn([f64; 3], Dir) -> f64 + Sync,
    ) -> PyResult<Doubles<'py>> {
        let [places, normals] = rows(places, normals)?;
        let found = self.each(py, places, 1, |k, out| out[0] = of(places[k], Dir::from_unit(normals[k])))?;
        array_of(py, found, &[places.len()])
    }
}

#[pymethods]
impl AreaLight {
    /// A luminous ball.
    #[staticmethod]
    fn sphere(center: [f64; 3], radius: f64) -> Self {
        Self(Shape::Sphere(SphereLight { center, radius }))
    }

    /// A disc that shines to the side of a unit vector.
    #[staticmethod]
    fn disc(center: [f64; 3], normal: [f64; 3], radius: f64) -> Self {
        Self(Shape::Disc(DiscLight { center, normal: Dir::from_unit(normal), radius }))
    }

    /// A rectangle or parallelogram, center ± u ± v.
    #[staticmethod]
    fn rectangle(center: [f64; 3], u: [f64; 3], v: [f64; 3]) -> PyResult<Self> {
        let light = PolygonLight::rectangle(center, u, v).map_err(|error| error_of(&error))?;
        Ok(Self(Shape::Polygon(light)))
    }

    /// A plane polygon that shines to the side from which its vertices run counterclockwise.
    #[staticmethod]
    fn polygon(vertices: Vec<[f64; 3]>) -> PyResult<Self> {
        let light = PolygonLight::new(vertices).map_err(|error| error_of(&error))?;
        Ok(Self(Shape::Polygon(light)))
    }

    /// The irradiance at places `(m, 3)` that face unit vectors `(m, 3)`: `(m)`.
    fn irradiance<'py>(
        &self,
        py: Python<'py>,
        places: PyReadonlyArray2<'py, f64>,
        normals: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Doubles<'py>> {
        self.0.facing(py, &places, &normals, |place, normal| self.0.irradiance(place, normal))
    }

    /// The vector irradiance at places `(m, 3)`: `(m, 3)`.
    fn vector_irradiance<'py>(&self, py: Python<'py>, places: PyReadonlyArray2<'py, f64>) -> PyResult<Doubles<'py>> {
        let places = contiguous(&places)?.as_chunks::<3>().0;
        let found = self
            .0
            .each(py, places, 3, |k, out| out.copy_from_slice(&self.0.vector_irradiance(places[k]).to_array()))?;
        array_of(py, found, &[places.len(), 3])
    }

    /// The irradiance of the point light that the light tends to with distance: `(m)`.
    fn as_point<'py>(
        &self,
        py: Python<'py>,
        places: PyReadonlyArray2<'py, f64>,
        normals: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Doubles<'py>> {
        let point = self.0.as_point();
        self.0.facing(py, &places, &normals, |place, normal| point.irradiance(place, normal))
    }

    /// The irradiance, of surfaces that face unit vectors, of the parallel beam that agrees at a place of reference: `(m)`.
    fn as_beam<'py>(
        &self,
        py: Python<'py>,
        references: PyReadonlyArray2<'py, f64>,
        normals: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Doubles<'py>> {
        self.0.facing(py, &references, &normals, |place, normal| {
            self.0.as_beam(place).map_or(0.0, |beam| beam.irradiance(normal))
        })
    }
}

/// Places and normals, as many of both.
fn rows<'a>(
    places: &'a PyReadonlyArray2<'_, f64>,
    normals: &'a PyReadonlyArray2<'_, f64>,
) -> PyResult<[&'a [[f64; 3]]; 2]> {
    let [places, normals] = [contiguous(places)?.as_chunks::<3>().0, contiguous(normals)?.as_chunks::<3>().0];
    if places.len() == normals.len() {
        Ok([places, normals])
    } else {
        Err(value_error(format!("expected as many normals as places, found {} and {}", normals.len(), places.len())))
    }
}
