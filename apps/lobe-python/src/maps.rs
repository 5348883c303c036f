//! Environment maps.

use std::path::PathBuf;

use lobe::env::{
    EnvMap, Ground, MappedMap, Mapping, PictureWriteOptions, PreethamSky, PrefilterOptions, Resample, SunOptions,
    bundled as bundled_maps, cube_source, extract_sun, irradiance_map, prefilter_ggx, project_map, resample, sky_map,
    write_env,
};
use lobe::image::{Picture, Tone};
use lobe::sh::{Dir, Expansion as _, Rgb, Rotation, ShVec};
use numpy::{PyArrayDyn, PyReadonlyArray2, PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::job::{error_of, watched};
use crate::rows::{array_of, contiguous, value_error};

/// Texels from which on all threads share in copying them: fewer are copied before another thread is awake.
const MANY: usize = 1 << 17;

/// An environment map in one of the mappings.
#[pyclass(frozen, module = "lobe")]
pub(crate) struct Map(pub(crate) MappedMap);

impl Map {
    /// The map as a lat-long one, about as fine.
    pub(crate) fn to_lat_long(&self, py: Python<'_>) -> PyResult<EnvMap> {
        if self.0.mapping() == Mapping::LatLong {
            return self.0.clone().into_env_map().map_err(|error| error_of(&error));
        }
        // A face of a cube is a quarter of the horizon; other mappings are about as wide as half of it.
        let width = 4 * self.0.width();
        let to = Resample::to(Mapping::LatLong, width, Mapping::LatLong.height_for(width));
        watched(py, None, None, |job| resample(&self.0, &to, job)?.into_env_map())
    }
}

fn mapping_of(name: &str) -> PyResult<Mapping> {
    Mapping::from_name(name)
        .ok_or_else(|| value_error(format!("expected a mapping such as lat-long or cube, found {name:?}")))
}

/// A map from a file.
#[pyfunction]
pub(crate) fn load(py: Python<'_>, path: PathBuf) -> PyResult<Map> {
    py.detach(|| MappedMap::load(path)).map(Map).map_err(|error| error_of(&error))
}

/// A map that comes with Lobe.
#[pyfunction]
pub(crate) fn bundled(name: &str) -> PyResult<Map> {
    let map = match name {
        "sunset" => bundled_maps::sunset().map(),
        "studio" => bundled_maps::studio().map(),
        _ => return Err(value_error(format!("expected sunset or studio, found {name:?}"))),
    };
    Ok(Map(map.into()))
}

/// The clear sky of Preetham, in kcd/m², over a ground of an albedo.
#[pyfunction]
pub(crate) fn sky(py: Python<'_>, sun: [f64; 3], turbidity: f64, albedo: [f64; 3], height: usize) -> PyResult<Map> {
    let sun = Dir::new(sun).ok_or_else(|| value_error("expected a direction, found a vector without one"))?;
    let sky = PreethamSky::new(turbidity, sun).map_err(|error| error_of(&error))?;
    if height == 0 || height > 8192 {
        return Err(value_error(format!("expected a height of 1 to 8192 texels, found {height}")));
    }
    let ground = Ground { albedo: Rgb::from(albedo), ..Ground::default() };
    Ok(Map(py.detach(|| sky_map(&sky, &ground, 2 * height, height)).into()))
}

/// The map of an expansion `(n², 3)`.
#[pyfunction]
pub(crate) fn reconstruct(py: Python<'_>, c: PyReadonlyArray2<'_, f64>, width: usize, height: usize) -> PyResult<Map> {
    let colors: Vec<Rgb<f64>> = contiguous(&c)?.as_chunks::<3>().0.iter().map(|c| Rgb::from(*c)).collect();
    let f = ShVec::from_vec(colors).ok_or_else(|| value_error("expected n² coefficients"))?;
    if width == 0 || height == 0 {
        return Err(value_error(format!("expected a picture with texels, found {width} x {height}")));
    }
    Ok(Map(py.detach(|| lobe::env::reconstruct(&f, width, height)).into()))
}

#[pymethods]
impl Map {
    /// From texels `(height, width, 3)`.
    #[new]
    fn new(py: Python<'_>, texels: PyReadonlyArrayDyn<'_, f32>, mapping: &str) -> PyResult<Self> {
        let [height, width, 3] = *texels.shape() else {
            return Err(PyValueError::new_err(format!(
                "expected an array of shape (height, width, 3), found {:?}",
                texels.shape()
            )));
        };
        let colors: &[Rgb<f32>] = bytemuck::cast_slice(contiguous(&texels)?);
        let colors =
            if colors.len() < MANY { colors.to_vec() } else { py.detach(|| colors.par_iter().copied().collect()) };
        MappedMap::new(mapping_of(mapping)?, width, height, colors).map(Self).map_err(|error| error_of(&error))
    }

    /// The name of the mapping.
    #[getter]
    fn mapping(&self) -> &'static str {
        self.0.mapping().name()
    }

    /// Texels along the height and the width.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.0.height(), self.0.width())
    }

    /// The texels, `(height, width, 3)`.
    fn texels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let texels: &[f32] = bytemuck::cast_slice(self.0.texels());
        array_of(py, texels.to_vec(), &[self.0.height(), self.0.width(), 3])
    }

    /// Radiance towards unit vectors `(m, 3)`, interpolated: `(m, 3)`.
    fn radiance<'py>(
        &self,
        py: Python<'py>,
        directions: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let directions = contiguous(&directions)?.as_chunks::<3>().0;
        let light = |s: &[f64; 3]| Dir::new(*s).map_or([f32::NAN; 3], |s| self.0.radiance(s).to_array());
        let values: Vec<[f32; 3]> = py.detach(|| directions.par_iter().map(light).collect());
        array_of(py, bytemuck::cast_vec(values), &[directions.len(), 3])
    }

    /// The expansion, `(n², 3)`.
    fn project<'py>(&self, py: Python<'py>, order: usize) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let f = py.detach(|| project_map(&self.0, order));
        let numbers: Vec<f64> = f.coefficients().iter().flat_map(|c| c.to_array()).collect();
        array_of(py, numbers, &[order * order, 3])
    }

    /// The map in another mapping and size, turned by a rotation if there is one.
    fn convert(
        &self,
        py: Python<'_>,
        mapping: &str,
        width: usize,
        height: usize,
        rotation: Option<[[f64; 3]; 3]>,
    ) -> PyResult<Self> {
        let mut to = Resample::to(mapping_of(mapping)?, width, height);
        if let Some(matrix) = rotation {
            to = to.rotated(Rotation::from_matrix(matrix).map_err(value_error)?);
        }
        watched(py, None, None, |job| resample(&self.0, &to, job)).map(Self)
    }

    /// Prefiltered for GGX: cubes of falling size.
    fn prefilter(&self, py: Python<'_>, size: usize, last_size: usize) -> PyResult<Vec<Self>> {
        let options = PrefilterOptions::default().size(size).last_size(last_size);
        let cube = watched(py, None, None, |job| cube_source(&self.0, size, job))?;
        let chain = watched(py, None, None, |job| prefilter_ggx(&cube, &options, job))?;
        Ok(chain.levels().iter().map(|level| Self((**level).clone())).collect())
    }

    /// Irradiance by an expansion, as a lat-long map.
    fn irradiance(&self, py: Python<'_>, order: usize, width: usize, height: usize) -> PyResult<Self> {
        if width == 0 || height == 0 {
            return Err(value_error(format!("expected a picture with texels, found {width} x {height}")));
        }
        Ok(Self(py.detach(|| irradiance_map(&self.0, order, width, height)).into()))
    }

    /// The sun's direction, irradiance and angular diameter, and the map without it; none if there is none.
    fn sun(&self, py: Python<'_>) -> Option<([f64; 3], [f64; 3], f64, Self)> {
        let report = py.detach(|| extract_sun(&self.0, &SunOptions::default()))?;
        let sun = report.sun;
        Some((sun.direction.to_array(), sun.irradiance.to_array(), sun.angular_diameter, Self(report.rest)))
    }

    /// The map as a tone-mapped PNG of at most `width` columns.
    fn png(&self, py: Python<'_>, width: usize) -> PyResult<Vec<u8>> {
        let shown = py.detach(|| {
            let picture = Picture::new(self.0.width(), self.0.height(), self.0.texels().to_vec())?;
            let width = width.clamp(1, picture.width());
            let height = (picture.height() * width).div_ceil(picture.width());
            picture.resized(width, height).to_png(&Tone::PHOTOGRAPH)
        });
        shown.map_err(|error| error_of(&error))
    }

    /// Writes a picture; its ending says the format.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let written = py.detach(|| write_env(path, &self.0, &PictureWriteOptions::default()));
        written.map(drop).map_err(|error| error_of(&error))
    }
}
