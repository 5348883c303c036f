//! Pictures of scenes, and how far two pictures are apart.

use lobe::env::{MappedMap, SceneLight, SunChoice, SunRecord};
use lobe::image::{
    Curve, HalvesReport, ImageError, Measured, Picture, ZTest, compare as compare_pixels, flip, hdr_flip, relative_mse,
};
use lobe::io::{Job, JobOptions as _, Shard, either};
use lobe::render::{
    Background, Camera, CameraOptions, DistantLight, Emitter, EnvironmentMapOptions, LitPicture, MatteSurfaces,
    PathOptions, Reflections, RenderError, SampleCount, SurfaceModel, Surfaces, ToneOptions, TransferSource, Truth,
    TruthOptions, ViewOptions, light_baked_surfaces, light_by_irradiance, render_truth_shard,
    render_truth_with_emitters,
};
use lobe::scene::{Bvh, Scene};
use lobe::sh::{Coefficient as _, Dir, Expansion as _, Rgb, Rotation, ShVec};
use numpy::{PyArrayDyn, PyReadonlyArray2, PyReadonlyArrayDyn, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::job::{answered, error_of, heard, watched, watched_and_heard};
use crate::maps::Map;
use crate::options::{refusal, values_of};
use crate::rows::{array_of, contiguous, value_error};
use crate::scenes::SceneInput;
use crate::sharing::Share;

/// An eye and its target, or its azimuth and height around the scene; and the angle of view from the bottom to the top
/// of the picture. Angles are in degrees.
pub(crate) type View = (Option<[f64; 3]>, Option<[f64; 3]>, Option<[f64; 2]>, f64);

fn camera_of(scene: &Scene, view: View) -> PyResult<Camera> {
    camera_around(scene.world_bounds(), view)
}

/// The camera for a box in the world.
pub(crate) fn camera_around(bounds: [[f64; 3]; 2], (eye, target, orbit, fov): View) -> PyResult<Camera> {
    let options = CameraOptions::default().eye(eye).target(target).orbit(orbit).fov(fov);
    options.camera(bounds).map_err(|error| error_of(&error))
}

/// A light of colors, `(n², 3)`.
pub(crate) fn expansion(c: &PyReadonlyArray2<'_, f64>) -> PyResult<ShVec<Rgb<f64>>> {
    let colors = contiguous(c)?.as_chunks::<3>().0.iter().map(|c| Rgb::from(*c)).collect();
    ShVec::from_vec(colors).ok_or_else(|| value_error("expected n² coefficients"))
}

/// A sun: towards it, its irradiance, and its angular diameter in radians.
type SunNumbers = ([f64; 3], [f64; 3], f64);

/// Light for pictures by expansions: that expansion, or a map and the bands of which it is made, and suns, by a choice
/// or given.
#[derive(FromPyObject)]
pub(crate) struct Lighting<'py>(
    Option<PyReadonlyArray2<'py, f64>>,
    pub(crate) Option<PyRef<'py, Map>>,
    usize,
    String,
    Vec<SunNumbers>,
);

impl Lighting<'_> {
    /// The suns, and the expansion of the rest.
    pub(crate) fn split(&self) -> PyResult<SceneLight> {
        let Self(light, map, order, suns, given) = self;
        let choice: SunChoice = suns.parse().map_err(|error| value_error(format!("suns: {error}")))?;
        let split = match (light, map) {
            (Some(light), _) => SceneLight::of_expansion(expansion(light)?, &choice),
            (None, Some(map)) => SceneLight::of_map(&map.0, *order, &choice),
            (None, None) => return Err(value_error("expected light, found none")),
        };
        let split = split.map_err(|error| value_error(format!("suns: {error}")))?;
        let sun = |&(direction, irradiance, angular_diameter): &SunNumbers| {
            let record = SunRecord::new(direction, irradiance, angular_diameter.to_degrees());
            record.sun().map_err(|error| value_error(format!("suns: {error}")))
        };
        let given = given.iter().map(sun).collect::<PyResult<Vec<_>>>()?;
        Ok(SceneLight::new(split.rest().clone(), [split.suns(), &given].concat()))
    }
}

impl Lighting<'_> {
    /// What shiny surfaces reflect of it, beside the suns that stand apart; none if they are matte.
    fn reflections(
        &self,
        py: Python<'_>,
        surfaces: Surfaces,
        progress: Option<&Py<PyAny>>,
    ) -> PyResult<Option<Reflections>> {
        if surfaces == Surfaces::Matte {
            return Ok(None);
        }
        let options = EnvironmentMapOptions::default().surfaces(surfaces);
        let Self(light, map, _, suns, _) = self;
        let (light, map) = match (light, map) {
            (Some(light), _) => (Some(expansion(light)?), None),
            (None, map) => (None, map.as_ref().map(|map| map.to_lat_long(py)).transpose()?),
        };
        let choice: SunChoice = suns.parse().map_err(|error| value_error(format!("suns: {error}")))?;
        watched(py, progress, None, |job| match (&light, map) {
            (Some(light), _) => Reflections::of_expansion(light, &options, job),
            (None, Some(map)) => {
                let rest = SceneLight::of_map_with_rest(map.into(), 1, &choice)?.1;
                Reflections::new(rest.into_env_map()?, &options, job)
            }
            (None, None) => Err(RenderError::Options("expected light, found none".to_owned())),
        })
        .map(Some)
    }
}

/// A picture, `(height, width, 3)`, or 4 with an alpha.
pub(crate) type Pixels<'py> = Bound<'py, PyArrayDyn<f32>>;

pub(crate) fn pixels<'py>(py: Python<'py>, picture: &Picture) -> PyResult<Pixels<'py>> {
    let (height, width) = (picture.height(), picture.width());
    let Some(alpha) = picture.alpha() else {
        return array_of(py, picture.pixels().as_flattened().to_vec(), &[height, width, 3]);
    };
    let numbers = picture.pixels().iter().zip(alpha).flat_map(|([r, g, b], alpha)| [*r, *g, *b, *alpha]).collect();
    array_of(py, numbers, &[height, width, 4])
}

/// A scene under light, before a background, such as the map or, without one, the light itself: `(height, width, 3)`,
/// or 4 before nothing.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "a picture takes its scene, its light, its view and its size")]
pub(crate) fn render_still<'py>(
    py: Python<'py>,
    scene: SceneInput,
    asked: Option<Bound<'py, PyDict>>,
    order: Option<usize>,
    lighting: Lighting<'py>,
    background: &str,
    view: View,
    size: (usize, usize),
    rays: usize,
    surfaces: &str,
    progress: Option<Py<PyAny>>,
) -> PyResult<Pixels<'py>> {
    let (light, options, surfaces) = (lighting.split()?, view_options(size, rays), surfaces_of(surfaces)?);
    let behind = Behind::new(background, lighting.1.as_deref())?;
    let progress = progress.as_ref();
    let Some(asked) = asked else {
        // By irradiance, without transfer.
        let (scene, bvh) = scene.read(py)?;
        let camera = camera_of(&scene, view)?;
        let shown = |s: Dir| behind.seen([&light, &light], s);
        let lit = watched(py, progress, None, |job| {
            light_by_irradiance(&scene, &bvh, &light, &camera, &options, shown, job)
        })?;
        return behind.pixels(py, lit);
    };
    let asked = TransferSource::from_values(values_of(&asked)?).map_err(|error| refusal(&error))?;
    let (memory, mut scene) = (scene.memory, scene);
    scene.source = scene.source.finish(surfaces != Surfaces::Matte);
    let open = heard(py, move |_| scene.open())?;
    let found = watched_and_heard(py, progress, |job| asked.prepare(open, order, memory, job))?;
    let camera = camera_of(found.baked.scene(), view)?;
    let reflections = lighting.reflections(py, surfaces, progress)?;
    let wants = (!light.suns().is_empty(), reflections.is_some());
    // Files hold the fronts of surfaces; backs are baked as far as the view shows them.
    let baked = watched(py, progress, None, |job| found.completed((&camera, &options), wants, job))?;
    let rest = light.rest().resized(baked.order().min(light.rest().order()));
    let lights = SceneLight::new(rest, light.suns().to_vec());
    let shown = |s: Dir| behind.seen([&light, &lights], s);
    let model = reflections.as_ref().map(|reflections| reflections.turned(&Rotation::IDENTITY));
    let model: &dyn SurfaceModel = model.as_ref().map_or(&MatteSurfaces, |model| model);
    let lit = watched(py, progress, None, |job| {
        light_baked_surfaces(&baked, (&light, model), &camera, &options, shown, job)
    })?;
    behind.pixels(py, lit)
}

/// So many times as many rays of a pixel where surfaces end, as of the command.
const EDGE_RAYS: usize = 4;

/// The options of a picture with `rays` squared rays for each pixel.
pub(crate) fn view_options((width, height): (usize, usize), rays: usize) -> ViewOptions {
    ViewOptions::default().width(width).height(height).rays(rays).edge_rays(EDGE_RAYS * rays * rays)
}

/// What is behind a scene: one of the names or a color of the command, for `env` a map or, without one, the light.
pub(crate) struct Behind<'a> {
    background: Background,
    map: Option<&'a MappedMap>,
}

impl<'a> Behind<'a> {
    pub(crate) fn new(background: &str, map: Option<&'a Map>) -> PyResult<Self> {
        Ok(Self { background: background_of(background)?, map: map.map(|map| &*map.0) })
    }

    /// What is seen towards `s` under the light as it was given, and as it lights the scene.
    pub(crate) fn seen(&self, [given, lights]: [&SceneLight; 2], s: Dir) -> Rgb<f64> {
        match (self.background, self.map) {
            (Background::Env, Some(map)) => map.radiance(s).widen(),
            (Background::Env, None) => given.rest().eval(s),
            (Background::Color(color), _) => color,
            (Background::None, _) => Rgb::ZERO,
            _ => lights.radiance(s),
        }
    }

    /// A picture, of four channels before nothing.
    pub(crate) fn pixels<'py>(&self, py: Python<'py>, lit: LitPicture) -> PyResult<Pixels<'py>> {
        pixels(py, &if self.background == Background::None { lit.before_nothing().picture } else { lit.picture })
    }
}

fn surfaces_of(text: &str) -> PyResult<Surfaces> {
    text.parse().map_err(|error| value_error(format!("surfaces: {error}")))
}

/// Samples of each pixel, bounces before the visible surface, a seed, and the model of surfaces.
#[derive(FromPyObject)]
pub(crate) struct Paths(usize, usize, u64, String);

impl Paths {
    pub(crate) fn options(&self, (width, height): (usize, usize)) -> PyResult<TruthOptions> {
        let Self(samples, bounces, seed, surfaces) = self;
        let surfaces = surfaces_of(surfaces)?;
        let paths = PathOptions::default().bounces(*bounces).seed(*seed).surfaces(surfaces);
        Ok(TruthOptions::default().width(width).height(height).count(SampleCount::of(*samples)).paths(paths))
    }
}

/// The light of a map or, without one, of an expansion, in front of a background.
pub(crate) fn distant_light(
    py: Python<'_>,
    light: Option<PyReadonlyArray2<'_, f64>>,
    map: Option<&Map>,
    background: &str,
) -> PyResult<DistantLight> {
    let distant = match (light, map) {
        (Some(light), _) => DistantLight::from_expansion(expansion(&light)?),
        (None, Some(map)) => DistantLight::from_map(map.to_lat_long(py)?),
        (None, None) => return Err(value_error("expected light, found none")),
    };
    // What was given is what lights the scene.
    Ok(distant.before(background_of(background)?.backdrop(None, None)))
}

fn background_of(text: &str) -> PyResult<Background> {
    text.parse().map_err(|error| value_error(format!("background: {error}")))
}

/// The picture and the variance of its means, `(height, width, 3)` each, the degrees of freedom of the latter, and the
/// part of each pixel that shows a surface; none of a shard. Before nothing the picture has four channels.
pub(crate) type Traced<'py> = Option<(Pixels<'py>, Pixels<'py>, usize, Pixels<'py>)>;

/// A scene path traced under a lat-long map or an expansion, before a background.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "a picture takes its scene, its light, its view, its size and its paths")]
pub(crate) fn render_traced<'py>(
    py: Python<'py>,
    scene: SceneInput,
    light: Option<PyReadonlyArray2<'py, f64>>,
    map: Option<&Map>,
    background: &str,
    view: View,
    size: (usize, usize),
    paths: Paths,
    share: Option<Share>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Traced<'py>> {
    let (distant, options) = (distant_light(py, light, map, background)?, paths.options(size)?);
    if let Some(share) = &share {
        share.begin(py, &[&*scene.source.scene], progress.as_ref())?;
    }
    let mut scene = scene;
    scene.source = scene.source.finish(options.paths.surfaces != Surfaces::Matte);
    let (scene, bvh) = scene.read(py)?;
    let camera = camera_of(&scene, view)?;
    traced(py, share.as_ref(), progress.as_ref(), |shard, job| {
        trace(&scene, &bvh, &camera, (&distant, &[]), &options, shard, job)
    })
}

/// Traces a picture, or a shard of it, in the file of what is shared if it is.
pub(crate) fn traced<'py>(
    py: Python<'py>,
    share: Option<&Share>,
    progress: Option<&Py<PyAny>>,
    trace: impl FnOnce(Option<Shard>, Job<'_>) -> Result<Option<Truth>, RenderError> + Send,
) -> PyResult<Traced<'py>> {
    let shard = share.map_or(Ok(None), Share::shard)?;
    let truth = watched(py, progress, share.map(Share::file), |job| trace(shard, job));
    let truth = match share {
        Some(share) => share.outcome(py, truth)?,
        None => truth?,
    };
    let of = |truth: Truth| {
        let size = [truth.mean.height(), truth.mean.width()];
        let (mean, variance) = (pixels(py, &truth.mean)?, pixels(py, &truth.variance)?);
        Ok((mean, variance, truth.degrees_of_freedom, array_of(py, truth.coverage, &size)?))
    };
    truth.map(of).transpose()
}

/// A picture, or a shard of it, which stays in the file of the job.
pub(crate) fn trace(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    (light, emitters): (&DistantLight, &[Emitter]),
    options: &TruthOptions,
    shard: Option<Shard>,
    job: Job<'_>,
) -> Result<Option<Truth>, RenderError> {
    match shard {
        Some(shard) => render_truth_shard(scene, bvh, camera, (light, emitters), options, shard, job).map(|()| None),
        None => render_truth_with_emitters(scene, bvh, camera, light, emitters, options, job).map(Some),
    }
}

/// RMSE, relative MSE, PSNR and FLIP of two pictures `(height, width, 3)` of linear light, of those for a display by FLIP for these.
#[pyfunction]
pub(crate) fn compare(
    py: Python<'_>,
    image: PyReadonlyArrayDyn<'_, f32>,
    reference: PyReadonlyArrayDyn<'_, f32>,
    pixels_per_degree: f64,
    for_display: bool,
) -> PyResult<(f64, f64, f64, f64)> {
    let (image, reference) = (picture_of(&image)?, picture_of(&reference)?);
    let compared = answered(py, 3 * image.pixels().len(), move || {
        let report = compare_pixels(image.pixels(), reference.pixels());
        let flip = if for_display { flip } else { hdr_flip }(&image, &reference, pixels_per_degree)?;
        Ok((report.rmse, relative_mse(image.pixels(), reference.pixels()), report.psnr, flip.mean()))
    })?;
    compared.map_err(|error: ImageError| error_of(&error))
}

/// The mean of z, the probability of one that far from 0, the spread of z and the probability of one that large, of each channel; and
/// whether all of them are as chance has them.
type Judged = ([f64; 3], [f64; 3], [f64; 3], [f64; 3], bool);

/// A picture `(height, width, 3)`, the variance of its pixels and the degrees of freedom of that.
type MeasuredPicture<'py> = (PyReadonlyArrayDyn<'py, f32>, PyReadonlyArrayDyn<'py, f32>, f64);

/// Whether chance explains the differences of two pictures, at a level of significance.
#[pyfunction]
pub(crate) fn z_test(a: MeasuredPicture<'_>, b: MeasuredPicture<'_>, level: f64) -> PyResult<Judged> {
    let pictures = |(means, variances, freedom): &MeasuredPicture<'_>| {
        Ok::<_, PyErr>((picture_of(means)?, picture_of(variances)?, *freedom))
    };
    let (a, b) = (pictures(&a)?, pictures(&b)?);
    let [a, b] = [&a, &b].map(|(means, variances, degrees_of_freedom)| Measured {
        means: means.pixels(),
        variances: variances.pixels(),
        degrees_of_freedom: *degrees_of_freedom,
    });
    let test = ZTest::new(&a, &b).map_err(|error| error_of(&error))?;
    Ok((test.mean_z, test.p_bias, test.spread, test.p_spread, test.passes(level)))
}

/// How many pixels count, the error relative to the reference, how uncertain that is, the ratio of the means, the PSNR,
/// the noise of the reference and the part of dark pixels.
type Halved = (usize, f64, f64, f64, f64, f64, f64);

/// How far a picture `(height, width, 3)` is from a reference of which there are two independent halves, where `counts`
/// says so.
#[pyfunction]
pub(crate) fn compare_halves(
    image: PyReadonlyArrayDyn<'_, f32>,
    halves: [PyReadonlyArrayDyn<'_, f32>; 2],
    counts: PyReadonlyArrayDyn<'_, bool>,
) -> PyResult<Halved> {
    let image = picture_of(&image)?;
    let [a, b] = [picture_of(&halves[0])?, picture_of(&halves[1])?];
    let counts = contiguous(&counts)?;
    let counts = |i: usize| counts.get(i) == Some(&true);
    let report = HalvesReport::new(image.pixels(), [a.pixels(), b.pixels()], counts);
    let HalvesReport { pixels, relative_rms, uncertainty, mean_ratio, psnr, noise, dark, .. } =
        report.map_err(|error| error_of(&error))?;
    Ok((pixels, relative_rms, uncertainty, mean_ratio, psnr, noise, dark))
}

/// The bytes that a display shows of a picture `(height, width, 3)`.
#[pyfunction]
pub(crate) fn tone_mapped<'py>(
    py: Python<'py>,
    picture: PyReadonlyArrayDyn<'py, f32>,
    tone: &str,
    exposure: Option<f64>,
) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
    let curve = Curve::from_name(tone).ok_or_else(|| {
        let known = Curve::NAMES.map(|(name, _)| name);
        value_error(format!("tone: expected {}, found {tone:?}", either(&known)))
    })?;
    let options = ToneOptions::default().tone(curve).exposure(exposure);
    options.check().map_err(|error| refusal(&error))?;
    let picture = picture_of(&picture)?;
    let shape = [picture.height(), picture.width(), 3];
    let bytes = answered(py, 3 * picture.pixels().len(), move || options.of_any().to_bytes(&picture))?;
    array_of(py, bytes, &shape)
}

fn picture_of(array: &PyReadonlyArrayDyn<'_, f32>) -> PyResult<Picture> {
    let [height, width, 3] = *array.shape() else { return Err(value_error("expected (height, width, 3)")) };
    let colors: Vec<[f32; 3]> = contiguous(array)?.as_chunks::<3>().0.to_vec();
    Picture::new(width, height, colors).map_err(|error| error_of(&error))
}
