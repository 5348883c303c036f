//! Pictures of scenes, and how far two pictures are apart.

use std::path::PathBuf;

use lobe::image::{FLIP_PIXELS_PER_DEGREE, ImageError, Picture, compare as compare_pixels, hdr_flip, relative_mse};
use lobe::render::{
    BakedScene, Camera, DistantLight, PathOptions, SampleCount, TruthOptions, ViewOptions, light_baked_scene,
    render_truth,
};
use lobe::scene::{Bvh, Scene, SceneReadOptions};
use lobe::sh::{Coefficient as _, Dir, Rgb, ShVec};
use numpy::{PyArrayDyn, PyReadonlyArray2, PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::prelude::*;

use crate::bakes;
use crate::job::{answered, error_of, watched};
use crate::maps::Map;
use crate::rows::{array_of, contiguous, value_error};

/// An eye, its target and the angle of view from the bottom to the top of the picture, in radians; without an eye all of the scene is in
/// view.
type View = (Option<[f64; 3]>, Option<[f64; 3]>, f64);

fn camera_of(scene: &Scene, (eye, target, angle): View) -> PyResult<Camera> {
    let [min, max] = scene.world_bounds();
    let Some(eye) = eye else { return Ok(Camera::in_front_of(min, max, 0.5 * angle)) };
    let target = target.unwrap_or_else(|| std::array::from_fn(|k| 0.5 * (min[k] + max[k])));
    Camera::look_at(eye, target, 0.5 * angle)
        .ok_or_else(|| value_error("eye: expected another point than the target, found the same"))
}

fn expansion(c: &PyReadonlyArray2<'_, f64>) -> PyResult<ShVec<Rgb<f64>>> {
    let colors = contiguous(c)?.as_chunks::<3>().0.iter().map(|c| Rgb::from(*c)).collect();
    ShVec::from_vec(colors).ok_or_else(|| value_error("expected n² coefficients"))
}

/// A picture, `(height, width, 3)`.
type Pixels<'py> = Bound<'py, PyArrayDyn<f32>>;

fn pixels<'py>(py: Python<'py>, picture: &Picture) -> PyResult<Pixels<'py>> {
    let numbers = picture.pixels().as_flattened().to_vec();
    array_of(py, numbers, &[picture.height(), picture.width(), 3])
}

/// A baked scene under light, before a map or, without one, before the light itself: `(height, width, 3)`.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "a picture takes its scene, its light, its view and its size")]
pub(crate) fn render_baked<'py>(
    py: Python<'py>,
    scene: PathBuf,
    light: PyReadonlyArray2<'py, f64>,
    background: Option<&Map>,
    view: View,
    width: usize,
    height: usize,
    rays: usize,
) -> PyResult<Pixels<'py>> {
    let light = expansion(&light)?;
    let baked = answered(py, usize::MAX, move || BakedScene::read(&scene, &SceneReadOptions::default()))?;
    let baked = baked.map_err(|error| error_of(&error))?;
    let camera = camera_of(baked.scene(), view)?;
    let options = ViewOptions::default().width(width).height(height).rays(rays);
    let shown = |s: Dir| background.map_or_else(|| light_towards(&light, s), |map| map.0.radiance(s).widen());
    let lit = watched(py, None, None, |job| light_baked_scene(&baked, &light, &camera, &options, shown, job))?;
    pixels(py, &lit.picture)
}

fn light_towards(light: &ShVec<Rgb<f64>>, s: Dir) -> Rgb<f64> {
    lobe::sh::Expansion::eval(light, s)
}

/// A scene path traced under a lat-long map or an expansion: the picture and the variance of its means, `(height, width, 3)` each.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "a picture takes its scene, its light, its view, its size and its paths")]
pub(crate) fn render_traced<'py>(
    py: Python<'py>,
    scene: PathBuf,
    light: Option<PyReadonlyArray2<'py, f64>>,
    map: Option<&Map>,
    view: View,
    width: usize,
    height: usize,
    paths: (usize, usize, u64),
    progress: Option<Py<PyAny>>,
) -> PyResult<(Pixels<'py>, Pixels<'py>)> {
    let distant = match (light, map) {
        (Some(light), _) => DistantLight::from_expansion(expansion(&light)?),
        (None, Some(map)) => DistantLight::from_map(map.to_lat_long(py)?),
        (None, None) => return Err(value_error("expected light, found none")),
    };
    let read = answered(py, usize::MAX, move || bakes::read(&scene).map(|(scene, _)| (Bvh::new(&scene), scene)))?;
    let (bvh, scene) = read.map_err(|error| error_of(&error))?;
    let camera = camera_of(&scene, view)?;
    let (samples, bounces, seed) = paths;
    let paths = PathOptions::default().bounces(bounces).seed(seed);
    let options = TruthOptions::default().width(width).height(height).count(SampleCount::of(samples)).paths(paths);
    let truth =
        watched(py, progress.as_ref(), None, |job| render_truth(&scene, &bvh, &camera, &distant, &options, job))?;
    Ok((pixels(py, &truth.mean)?, pixels(py, &truth.variance)?))
}

/// RMSE, relative MSE, PSNR and FLIP of two pictures `(height, width, 3)` of linear light.
#[pyfunction]
pub(crate) fn compare(
    py: Python<'_>,
    image: PyReadonlyArrayDyn<'_, f32>,
    reference: PyReadonlyArrayDyn<'_, f32>,
) -> PyResult<(f64, f64, f64, f64)> {
    let picture = |array: &PyReadonlyArrayDyn<'_, f32>| {
        let [height, width, 3] = *array.shape() else { return Err(value_error("expected (height, width, 3)")) };
        let colors: Vec<[f32; 3]> = contiguous(array)?.as_chunks::<3>().0.to_vec();
        Picture::new(width, height, colors).map_err(|error| error_of(&error))
    };
    let (image, reference) = (picture(&image)?, picture(&reference)?);
    let compared = answered(py, 3 * image.pixels().len(), move || {
        let report = compare_pixels(image.pixels(), reference.pixels());
        let flip = hdr_flip(&image, &reference, FLIP_PIXELS_PER_DEGREE)?;
        Ok((report.rmse, relative_mse(image.pixels(), reference.pixels()), report.psnr, flip.mean()))
    })?;
    compared.map_err(|error: ImageError| error_of(&error))
}
