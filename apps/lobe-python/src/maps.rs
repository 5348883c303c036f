//! Environment maps.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lobe::env;
use lobe::env::{
    CieSky, CubeHandedness, EnvMap, FaceOrder, FisheyeOptions, FisheyeProjection, Ground, MapReadOptions, MappedMap,
    Mapping, Nonfinite, Padding, PictureWriteOptions, PreethamSky, Resample, bundled as bundled_maps, encode_env,
    project_map, read_map, reconstruct_into, resample, sky_map,
};
use lobe::image::{ImageError, Picture, PictureReadOptions, PictureReadReport, Tone};
use lobe::sh::{Coefficient, Dir, Expansion as _, Real as _, Rgb, Rotation, ShVec};
use numpy::{PyArrayDyn, PyReadonlyArray2, PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::forked::with_threads;
use crate::job::{answered, error_of, watched};
use crate::outputs::{has_ending, write_whole};
use crate::rows::{
    Number, Numbers, QUICK_ROWS_TOGETHER, array_of, contiguous, do_rows, empty_array, shape_error, value_error,
    writable,
};

/// Texels from which on all threads share in copying them: fewer are copied before another thread is awake.
const MANY: usize = 1 << 17;

/// An environment map in one of the mappings.
#[pyclass(frozen, module = "lobe")]
pub(crate) struct Map(pub(crate) Arc<MappedMap>);

impl From<MappedMap> for Map {
    fn from(map: MappedMap) -> Self {
        Self(Arc::new(map))
    }
}

impl From<EnvMap> for Map {
    fn from(map: EnvMap) -> Self {
        MappedMap::from(map).into()
    }
}

impl Map {
    /// Numbers of the texels.
    pub(crate) fn size(&self) -> usize {
        3 * self.0.texels().len()
    }

    /// The map as a lat-long one, about as fine.
    pub(crate) fn to_lat_long(&self, py: Python<'_>) -> PyResult<EnvMap> {
        if self.0.mapping() == Mapping::LatLong {
            return MappedMap::clone(&self.0).into_env_map().map_err(|error| error_of(&error));
        }
        // A face of a cube is a quarter of the horizon; other mappings are about as wide as half of it.
        let width = 4 * self.0.width();
        let to = Resample::to(Mapping::LatLong, width, Mapping::LatLong.height_for(width));
        watched(py, None, None, |job| resample(&*self.0, &to, job)?.into_env_map())
    }
}

/// The names of all mappings, and what the pictures of each show.
#[pyfunction]
pub(crate) fn mappings() -> Vec<(&'static str, &'static str)> {
    Mapping::ALL.map(|mapping| (mapping.name(), mapping.description())).into()
}

fn mapping_of(name: &str) -> PyResult<Mapping> {
    Mapping::from_name(name)
        .ok_or_else(|| value_error(format!("expected a mapping such as lat-long or cube, found {name:?}")))
}

fn face_order(text: &str) -> PyResult<FaceOrder> {
    text.parse().map_err(|error| value_error(format!("faces: {error}")))
}

/// Projection, field of view in radians, axis, and the circle in pixels.
type Fisheye = (String, f64, [f64; 3], Option<[f64; 3]>);

/// How a file is read, as by the options of the command.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Reading {
    mapping: Option<String>,
    left_handed: bool,
    faces: Option<String>,
    /// In radians.
    elevations: Option<[f64; 2]>,
    fisheye: Option<Fisheye>,
    padding: String,
    nonfinite: String,
    to_rec709: bool,
    max_texels: Option<usize>,
    max_bytes: Option<u64>,
}

impl Reading {
    fn options(&self) -> PyResult<MapReadOptions> {
        let mut picture = PictureReadOptions::default().to_rec_709(self.to_rec709);
        picture.nonfinite = match &*self.nonfinite {
            "error" => Nonfinite::Error,
            "zero" => Nonfinite::Zero,
            other => return Err(value_error(format!("nonfinite: expected error or zero, found {other:?}"))),
        };
        let padding = match &*self.padding {
            "black" => Padding::Black,
            "edge" => Padding::Edge,
            other => return Err(value_error(format!("padding: expected black or edge, found {other:?}"))),
        };
        picture.max_texels = self.max_texels.unwrap_or(picture.max_texels);
        picture.max_bytes = self.max_bytes.unwrap_or(picture.max_bytes);
        Ok(MapReadOptions::default()
            .picture(picture)
            .mapping(self.mapping.as_deref().map(mapping_of).transpose()?)
            .elevations(self.elevations)
            .fisheye(self.lens()?)
            .padding(padding)
            .faces(self.faces.as_deref().map(face_order).transpose()?)
            .handedness(self.left_handed.then_some(CubeHandedness::Left)))
    }

    fn lens(&self) -> PyResult<Option<FisheyeOptions>> {
        let Some((name, field_of_view, axis, circle)) = &self.fisheye else { return Ok(None) };
        let projection = FisheyeProjection::from_name(name).ok_or_else(|| {
            let names = FisheyeProjection::ALL.map(FisheyeProjection::name).join(", ");
            value_error(format!("fisheye: expected one of {names}, found {name:?}"))
        })?;
        let axis = Dir::new(*axis)
            .ok_or_else(|| value_error("fisheye_axis: expected a direction, found a vector without one"))?;
        let lens = FisheyeOptions::default().projection(projection).field_of_view(*field_of_view);
        Ok(Some(lens.axis(axis).circle(*circle)))
    }
}

/// A map from a file, and what reading it found that may not be what was meant.
#[pyfunction]
pub(crate) fn load(py: Python<'_>, path: PathBuf, reading: Reading) -> PyResult<(Map, Vec<String>)> {
    let options = reading.options()?;
    // A file that is not there says so by itself.
    let size = std::fs::metadata(&path).map_or(0, |file| file.len() as usize);
    let read = answered(py, size, move || read_map(&path, &options))?;
    let (map, report) = read.map_err(|error| error_of(&error))?;
    let mut findings: Vec<String> = match &*report.faces {
        [] => report.picture.findings(),
        faces => faces.iter().flat_map(PictureReadReport::findings).collect(),
    };
    findings.extend(report.assumed.map(|assumed| format!("{assumed}; left_handed and faces say otherwise")));
    if !report.picture.panorama.is_empty() {
        findings.extend(report.told);
    }
    Ok((map.into_base().into(), findings))
}

/// The sky of a type of the CIE with this radiance at the zenith, over a ground of an albedo.
#[pyfunction]
pub(crate) fn cie_sky(
    py: Python<'_>,
    kind: usize,
    sun: [f64; 3],
    zenith: [f64; 3],
    albedo: [f64; 3],
    height: usize,
) -> PyResult<Map> {
    let sun = Dir::new(sun).ok_or_else(|| value_error("expected a direction, found a vector without one"))?;
    let sky = CieSky::new(kind, sun, Rgb::from(zenith)).map_err(|error| error_of(&error))?;
    let ground = Ground { albedo: Rgb::from(albedo), ..Ground::default() };
    Ok(answered(py, 6 * height * height, move || sky_map(&sky, &ground, 2 * height, height))?.into())
}

/// A map that comes with Lobe.
#[pyfunction]
pub(crate) fn bundled(name: &str) -> PyResult<Map> {
    let map = match name {
        "sunset" => bundled_maps::sunset().map(),
        "studio" => bundled_maps::studio().map(),
        _ => return Err(value_error(format!("expected sunset or studio, found {name:?}"))),
    };
    Ok(map.into())
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
    Ok(answered(py, 6 * height * height, move || sky_map(&sky, &ground, 2 * height, height))?.into())
}

/// The map of an expansion, `(n²,)` or `(n², 3)`.
#[pyfunction]
pub(crate) fn reconstruct(
    py: Python<'_>,
    c: PyReadonlyArrayDyn<'_, f64>,
    width: usize,
    height: usize,
) -> PyResult<Map> {
    let is_color = c.shape().len() == 2;
    let texels = if is_color {
        of_size(py, expansion_of::<Rgb<f32>>(bytemuck::cast_slice::<f64, Rgb<f64>>(contiguous(&c)?))?, width, height)?
    } else {
        let values: Vec<f32> = of_size(py, expansion_of::<f32>(contiguous(&c)?)?, width, height)?;
        values.into_iter().map(Rgb::splat).collect()
    };
    MappedMap::new(Mapping::LatLong, width, height, texels).map(Map::from).map_err(|error| error_of(&error))
}

fn expansion_of<C: Coefficient>(c: &[C::Wide]) -> PyResult<ShVec<C::Wide>> {
    ShVec::from_vec(c.to_vec()).ok_or_else(|| value_error("expected n² coefficients"))
}

/// The texels of an expansion; Ctrl-C is answered.
fn of_size<C: Coefficient>(py: Python<'_>, f: ShVec<C::Wide>, width: usize, height: usize) -> PyResult<Vec<C>> {
    if width == 0 || height == 0 {
        return Err(value_error(format!("expected a picture with texels, found {width} x {height}")));
    }
    answered(py, C::CHANNELS * width * height, move || {
        let mut texels = vec![C::ZERO; width * height];
        reconstruct_into(&f, width, &mut texels);
        texels
    })
}

/// The values of functions, `(rows, n²[, 3])`, at the centers of the texels of a lat-long map: `(rows, height, width[, 3])`.
#[pyfunction]
pub(crate) fn texels<'py>(
    py: Python<'py>,
    c: Numbers<'py>,
    width: usize,
    height: usize,
) -> PyResult<Bound<'py, PyAny>> {
    match c {
        Numbers::Single(array) => texels_typed(py, &array, width, height),
        Numbers::Double(array) => texels_typed(py, &array, width, height),
    }
}

fn texels_typed<'py, T: Number>(
    py: Python<'py>,
    array: &PyReadonlyArrayDyn<'py, T>,
    width: usize,
    height: usize,
) -> PyResult<Bound<'py, PyAny>>
where
    Rgb<T>: Coefficient<Scalar = T> + bytemuck::Pod,
{
    let values = contiguous(array)?;
    let out = match *array.shape() {
        [rows, _] => {
            let out = empty_array::<T>(py, &[rows, height, width])?;
            texels_of::<T>(py, values, [rows, width], writable(&out)?.as_slice_mut()?)?;
            out
        }
        [rows, _, 3] => {
            let out = empty_array::<T>(py, &[rows, height, width, 3])?;
            let mut texels = writable(&out)?;
            let texels = bytemuck::cast_slice_mut(texels.as_slice_mut()?);
            texels_of::<Rgb<T>>(py, bytemuck::cast_slice(values), [rows, width], texels)?;
            out
        }
        ref other => return Err(shape_error(other)),
    };
    Ok(out.into_any())
}

/// Of each function the texels, one function after the other.
fn texels_of<C: Coefficient>(
    py: Python<'_>,
    functions: &[C],
    [rows, width]: [usize; 2],
    out: &mut [C],
) -> PyResult<()> {
    if out.is_empty() {
        return Ok(());
    }
    let (size, texels) = (functions.len() / rows, out.len() / rows);
    for (function, out) in functions.chunks_exact(size).zip(out.chunks_exact_mut(texels)) {
        py.check_signals()?;
        let f = expansion_of::<C>(&function.iter().map(|c| c.widen()).collect::<Vec<_>>())?;
        if texels * C::CHANNELS <= WHERE_THEY_LIE {
            py.detach(|| with_threads(|| reconstruct_into(&f, width, out)));
        } else {
            out.copy_from_slice(&of_size::<C>(py, f, width, texels / width)?);
        }
    }
    Ok(())
}

/// Numbers of a picture up to which it is read and written where it lies, without an answer to Ctrl-C: a tenth of a second at most.
const WHERE_THEY_LIE: usize = 1 << 25;

/// The expansion of a lat-long picture, `(height, width[, 3])`: `(n²[, 3])`.
#[pyfunction]
pub(crate) fn project_lat_long<'py>(
    py: Python<'py>,
    image: Numbers<'py>,
    order: usize,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    match image {
        Numbers::Single(array) => project_typed(py, &array, order),
        Numbers::Double(array) => project_typed(py, &array, order),
    }
}

fn project_typed<'py, T: Number>(
    py: Python<'py>,
    image: &PyReadonlyArrayDyn<'py, T>,
    order: usize,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>>
where
    Rgb<T>: Coefficient<Scalar = T, Wide = Rgb<f64>> + bytemuck::Pod,
{
    let texels = contiguous(image)?;
    match *image.shape() {
        [height, width] => {
            let f = project_texels::<T>(py, texels, [width, height], order)?;
            array_of(py, f.coefficients().iter().map(|c| c.channel(0)).collect(), &[order * order])
        }
        [height, width, 3] => {
            let f = project_texels::<Rgb<T>>(py, bytemuck::cast_slice(texels), [width, height], order)?;
            array_of(py, f.coefficients().iter().flat_map(|c| c.to_array()).collect(), &[order * order, 3])
        }
        ref other => Err(shape_error(other)),
    }
}

fn project_texels<C: Coefficient>(
    py: Python<'_>,
    texels: &[C],
    [width, height]: [usize; 2],
    order: usize,
) -> PyResult<ShVec<C::Wide>> {
    if texels.is_empty() {
        return Err(value_error(format!("an environment map needs texels, but {width} x {height} has none")));
    }
    let size = C::CHANNELS * texels.len();
    let f = if size <= WHERE_THEY_LIE {
        py.detach(|| with_threads(|| env::project_lat_long(texels, width, order)))
    } else {
        let own = texels.to_vec();
        answered(py, size, move || env::project_lat_long(&own, width, order))?
    };
    // A texel that is not finite is in every sum: only then it is looked for.
    let is_off = |c: &C| !(0..C::CHANNELS).all(|k| c.channel(k).to_f64().is_finite());
    let is_finite = (0..C::CHANNELS).all(|k| f.coefficients()[0].channel(k).is_finite());
    match if is_finite { None } else { texels.iter().position(is_off) } {
        None => Ok(f),
        Some(at) => {
            let found: Vec<f64> = (0..C::CHANNELS).map(|k| texels[at].channel(k).to_f64()).collect();
            Err(not_finite(&found, at, width))
        }
    }
}

fn not_finite(found: &[f64], at: usize, width: usize) -> PyErr {
    let (y, x) = (at / width, at % width);
    value_error(format!("texels: expected finite numbers, found {found:?} at row {y}, column {x}"))
}

/// The bytes of a picture of a map, whose ending says the format: light, or a PNG to be looked at.
fn encode(path: &Path, map: &MappedMap) -> Result<Vec<u8>, ImageError> {
    // The faces of a cube are right-handed, which readers need not assume then.
    let told =
        if map.mapping() == Mapping::Cube { Some(CubeHandedness::Right.told_name()) } else { map.untold_mapping() };
    if !has_ending(path, "png") {
        let options = told
            .map_or_else(PictureWriteOptions::default, |told| PictureWriteOptions::default().mapping(told.to_owned()));
        return Ok(encode_env(path, map, &options)?.0);
    }
    let picture = Picture::new(map.width(), map.height(), map.texels().to_vec())?;
    picture.to_png_with(&Tone::PHOTOGRAPH, told)
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
        let is_off = |c: &Rgb<f32>| !(c.r + c.g + c.b).is_finite() && !c.to_array().iter().all(|c| c.is_finite());
        let (colors, off) = if colors.len() < MANY {
            (colors.to_vec(), colors.iter().position(is_off))
        } else {
            py.detach(|| {
                with_threads(|| (colors.par_iter().copied().collect(), colors.par_iter().position_first(is_off)))
            })
        };
        if let Some(at) = off {
            return Err(not_finite(&colors[at].to_array().map(f64::from), at, width));
        }
        MappedMap::new(mapping_of(mapping)?, width, height, colors).map(Self::from).map_err(|error| error_of(&error))
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
        let values: Vec<Rgb<f32>> = do_rows(py, directions.len(), 1, QUICK_ROWS_TOGETHER, |k, out| {
            out[0] = Dir::new(directions[k]).map_or(Rgb::from([f32::NAN; 3]), |s| self.0.radiance(s));
            Ok(())
        })?;
        array_of(py, bytemuck::cast_vec(values), &[directions.len(), 3])
    }

    /// The expansion, `(n², 3)`.
    fn project<'py>(&self, py: Python<'py>, order: usize) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let map = Arc::clone(&self.0);
        let f = answered(py, self.size(), move || project_map(&map, order))?;
        let numbers: Vec<f64> = f.coefficients().iter().flat_map(|c| c.to_array()).collect();
        array_of(py, numbers, &[order * order, 3])
    }

    /// The map in another mapping and size, turned by a rotation if there is one.
    fn convert(
        &self,
        py: Python<'_>,
        mapping: &str,
        width: usize,
        height: Option<usize>,
        rotation: Option<[[f64; 3]; 3]>,
    ) -> PyResult<Self> {
        let mapping = mapping_of(mapping)?;
        let mut to = Resample::to(mapping, width, height.unwrap_or_else(|| mapping.height_for(width)));
        if let Some(matrix) = rotation {
            to = to.rotated(Rotation::from_matrix(matrix).map_err(value_error)?);
        }
        watched(py, None, None, |job| resample(&*self.0, &to, job)).map(Self::from)
    }

    /// The map as a tone-mapped PNG of at most `width` columns.
    fn png(&self, py: Python<'_>, width: usize) -> PyResult<Vec<u8>> {
        let map = Arc::clone(&self.0);
        let shown = answered(py, self.size(), move || {
            let picture = Picture::new(map.width(), map.height(), map.texels().to_vec())?;
            let width = width.clamp(1, picture.width());
            let height = (picture.height() * width).div_ceil(picture.width());
            picture.resized(width, height).to_png(&Tone::PHOTOGRAPH)
        })?;
        shown.map_err(|error| error_of(&error))
    }

    /// Writes a picture; its ending says the format.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let (map, name) = (Arc::clone(&self.0), path.clone());
        let encoded = answered(py, self.size(), move || encode(&name, &map))?;
        // Not before it is known that nobody has stopped it: what was encoded then is dropped.
        write_whole(py, path, &encoded.map_err(|error| error_of(&error))?)
    }
}
