//! Integrals over environment maps: prefiltered maps, irradiance, and the suns in them.

use std::path::PathBuf;
use std::sync::Arc;

use lobe::env::{
    CubeMap, Engine, EnvMap, ExportOptions, PrefilterOptions, RoughnessLevels, SpecularLobe, SunOptions, SunReport,
    cube_source, export_light as write_light, extract_sun, filter_lobe as filter_by_lobe,
    irradiance_at as irradiance_towards, irradiance_map, irradiance_map_brute_force, prefilter_ggx,
    vector_irradiance as vector_of,
};
use lobe::sh::{Coefficient as _, Dir};
use numpy::{PyArrayDyn, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::forked::with_threads;
use crate::job::{answered, error_of, watched};
use crate::maps::Map;
use crate::rows::{array_of, contiguous, value_error};

/// An array of double precision.
type Doubles<'py> = Bound<'py, PyArrayDyn<f64>>;

fn cube_of(py: Python<'_>, map: &Map, size: usize) -> PyResult<CubeMap> {
    watched(py, None, None, |job| cube_source(&*map.0, size, job))
}

/// Prefiltered for GGX: cubes of falling size, and the roughness of each.
#[pyfunction]
pub(crate) fn prefilter(
    py: Python<'_>,
    map: &Map,
    sizes: (usize, Option<usize>),
    roughness: &str,
    tolerance: f64,
) -> PyResult<Vec<Map>> {
    let levels: RoughnessLevels = roughness.parse().map_err(|error| value_error(format!("roughness: {error}")))?;
    let last = sizes.1.unwrap_or(levels.usual_last_size(sizes.0));
    let options = PrefilterOptions::default().size(sizes.0).last_size(last).roughness(levels).tolerance(tolerance);
    let cube = cube_of(py, map, sizes.0)?;
    let chain = watched(py, None, None, |job| prefilter_ggx(&cube, &options, job))?;
    Ok(chain.levels().iter().map(|level| Map::from((**level).clone())).collect())
}

/// Writes a map's light for engines; the files.
#[pyfunction]
pub(crate) fn export_light(
    py: Python<'_>,
    map: &Map,
    engines: Vec<String>,
    folder: PathBuf,
    name: &str,
    size: usize,
    suns: &str,
) -> PyResult<Vec<PathBuf>> {
    let engines = engines.iter().map(|engine| engine.parse()).collect::<Result<Vec<Engine>, _>>();
    let engines = engines.map_err(|error| value_error(format!("engine: {error}")))?;
    let suns = suns.parse().map_err(|error| value_error(format!("suns: {error}")))?;
    let options = ExportOptions::default().size(size).suns(suns);
    options.check().map_err(|error| value_error(format!("size: {error}")))?;
    let report = watched(py, None, None, |job| write_light(&folder, &map.0, &engines, name, &options, job))?;
    Ok(report.files.into_iter().map(|(path, _)| path).collect())
}

/// A cube blurred by a lobe: `phong` or `blinn-phong` of an exponent, or `ggx` of an α.
#[pyfunction]
pub(crate) fn filter_lobe(
    py: Python<'_>,
    map: &Map,
    lobe: &str,
    parameter: f64,
    size: usize,
    tolerance: f64,
) -> PyResult<Map> {
    let lobe = match lobe {
        "phong" => SpecularLobe::Phong { exponent: parameter },
        "blinn-phong" => SpecularLobe::BlinnPhong { exponent: parameter },
        "ggx" => SpecularLobe::Ggx { alpha: parameter },
        other => return Err(value_error(format!("lobe: expected phong, blinn-phong or ggx, found {other:?}"))),
    };
    let cube = cube_of(py, map, size)?;
    let filtered = watched(py, None, None, |job| filter_by_lobe(&cube, lobe, size, tolerance, job))?;
    Ok(Map(Arc::new(filtered.into())))
}

/// Irradiance as a lat-long map: by an expansion of an order, or without one by a sum over all texels.
#[pyfunction]
pub(crate) fn irradiance(
    py: Python<'_>,
    map: &Map,
    order: Option<usize>,
    width: usize,
    height: usize,
) -> PyResult<Map> {
    if width == 0 || height == 0 {
        return Err(value_error(format!("expected a picture with texels, found {width} x {height}")));
    }
    let Some(order) = order else {
        let map = map.to_lat_long(py)?;
        return watched(py, None, None, |job| irradiance_map_brute_force(&map, width, height, job)).map(Map::from);
    };
    let (map, size) = (Arc::clone(&map.0), map.size().max(3 * width * height));
    let found = answered(py, size, move || irradiance_map(&map, order, width, height))?;
    found.map(Map::from).map_err(|error| error_of(&error))
}

/// Normals whose irradiance is summed before the interpreter may stop the work.
const NORMALS_TOGETHER: usize = 64;

/// The irradiance of surfaces that face unit vectors `(m, 3)`, a sum over all texels of the lat-long map: `(m, 3)`.
#[pyfunction]
pub(crate) fn irradiance_at<'py>(
    py: Python<'py>,
    map: &Map,
    normals: PyReadonlyArray2<'py, f64>,
) -> PyResult<Doubles<'py>> {
    let map: EnvMap = map.to_lat_long(py)?;
    let normals: Vec<Dir> = contiguous(&normals)?.as_chunks::<3>().0.iter().map(|n| Dir::from_unit(*n)).collect();
    let mut found = Vec::with_capacity(3 * normals.len());
    for normals in normals.chunks(NORMALS_TOGETHER) {
        py.check_signals()?;
        let part = py.detach(|| with_threads(|| irradiance_towards(&map, normals)));
        found.extend(part.iter().flat_map(|e| e.to_array()));
    }
    array_of(py, found, &[normals.len(), 3])
}

/// The vector irradiance of each channel, `(3, 3)`, a row for each.
#[pyfunction]
pub(crate) fn vector_irradiance<'py>(py: Python<'py>, map: &Map) -> PyResult<Doubles<'py>> {
    let (inner, size) = (Arc::clone(&map.0), map.size());
    let e = answered(py, size, move || vector_of(&inner))?;
    let of_channel = |c: usize| e.to_array().map(|component| component.channel(c));
    array_of(py, (0..3).flat_map(of_channel).collect(), &[3, 3])
}

/// Direction, irradiance, radiance, angular diameter and number of texels of a sun, and the map without it.
type FoundSun = ([f64; 3], [f64; 3], [f64; 3], f64, usize, Map);

/// The sun of a map, at most of a radius in radians and at least that much brighter than its surroundings and than the mean.
#[pyfunction]
pub(crate) fn sun(
    py: Python<'_>,
    map: &Map,
    max_radius: f64,
    min_contrast: f64,
    min_peak: f64,
) -> PyResult<Option<FoundSun>> {
    let (inner, size) = (Arc::clone(&map.0), map.size());
    let options = SunOptions::default().max_radius(max_radius).min_contrast(min_contrast).min_peak(min_peak);
    let found = answered(py, size, move || extract_sun(&inner, &options))?;
    Ok(found.map(|SunReport { sun, rest, .. }| {
        let (direction, irradiance, radiance) =
            (sun.direction.to_array(), sun.irradiance.to_array(), sun.radiance().to_array());
        (direction, irradiance, radiance, sun.angular_diameter, sun.texels, rest.into())
    }))
}
