//! Scenes that move: their moments under distant light, by transfer of their parts, and path traced.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::{self, ThreadId};
use std::time::Duration;

use lobe::prt::{AdaptiveOptions, AlbedoMode, BakeOptions, BakedTransfer};
use lobe::render::{
    MovingBakeOptions, MovingMethod, MovingOptions, MovingScene, MovingShading, MovingSplitOptions, RenderError,
    VisibilityGridOptions, light_moving_scene,
};
use lobe::scene::{Bvh, SceneReadReport};
use lobe::sh::Dir;
use lobe::shadow::{FieldOptions, LogTable, LogTableOptions, RadialInterpolation, ShadowFieldOptions, ShadowOptions};
use numpy::PyReadonlyArray2;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::forked::with_threads;
use crate::job::{answered, error_of, watched};
use crate::maps::Map;
use crate::pictures::{
    Behind, Paths, Pixels, Traced, View, camera_around, distant_light, expansion, trace, traced, view_options,
};
use crate::rows::value_error;
use crate::scenes::{Read, SceneInput, remark};
use crate::sharing::Share;

/// What bakes parts and shades them, whose ranges the package has checked.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Shading {
    method: String,
    /// That of what is baked already, or 4.
    order: Option<usize>,
    samples: Option<u32>,
    bounces: Option<usize>,
    exponential: String,
    spheres: Option<usize>,
    sphere_bounce: bool,
    sphere_window: Option<f64>,
    interpolation: String,
    group: usize,
    still_points: usize,
    /// Whether what stands still is split first.
    split: bool,
    max_vertices: Option<usize>,
}

impl Shading {
    fn method(&self) -> PyResult<MovingMethod> {
        match &*self.method {
            "fields" => Ok(MovingMethod::Fields),
            "exponentials" => Ok(MovingMethod::Exponentials),
            other => Err(value_error(format!("method: expected fields or exponentials, found {other:?}"))),
        }
    }

    /// Of the transfer of each part.
    fn transfer(&self, moving: &MovingScene) -> BakeOptions {
        let defaults = BakeOptions::default();
        let (order, bounces) = (self.order.or_else(|| moving.order()), self.bounces.unwrap_or(defaults.bounces));
        let mut options = defaults.clone().order(order.unwrap_or(defaults.order)).bounces(bounces);
        options.samples = self.samples;
        options
    }

    fn bakes(&self, transfer: &BakeOptions) -> MovingBakeOptions {
        let bake = MovingBakeOptions::default();
        let (spheres, visibility) = (bake.spheres.clone(), VisibilityGridOptions::default());
        let (count, deformed) = (self.spheres.unwrap_or(spheres.count), self.spheres.or(bake.deformed_spheres));
        bake.transfer(transfer.clone().albedo(AlbedoMode::None))
            .field(FieldOptions::default().order(transfer.order))
            .spheres(spheres.count(count))
            .deformed_spheres(deformed)
            .visibility(visibility.order(transfer.order).points(self.still_points))
            .still_hides(self.still_points > 0)
    }

    fn shading(&self, order: usize) -> PyResult<MovingShading> {
        let interpolation = match &*self.interpolation {
            "linear" => RadialInterpolation::Linear,
            "cubic" => RadialInterpolation::Cubic,
            other => return Err(value_error(format!("interpolation: expected linear or cubic, found {other:?}"))),
        };
        let exponential = self.exponential.parse().map_err(value_error)?;
        let options = MovingOptions::default()
            .method(self.method()?)
            .order(order)
            .fields(ShadowFieldOptions::default().interpolation(interpolation))
            .spheres(ShadowOptions::default().method(exponential).group(self.group))
            .bounce(self.sphere_bounce);
        let mut table = LogTableOptions::default().order(order);
        table.window = self.sphere_window;
        let table = LogTable::new(&table).map_err(|error| error_of(&error))?;
        MovingShading::with_table(options, table).map_err(|error| error_of(&error))
    }
}

/// Reads or makes a scene.
fn read(
    input: &SceneInput,
    animation: Option<&str>,
    asked: (Option<usize>, Option<usize>),
) -> Result<Read<MovingScene>, RenderError> {
    if input.path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json")) {
        if animation.is_some() {
            let text = "animation: only of glTF files; a scene description says which animations its entities play";
            return Err(RenderError::Options(text.to_owned()));
        }
        let (moving, reports) = MovingScene::read(&input.path, &input.options)?;
        let of_file = |(file, report): &(PathBuf, SceneReadReport)| {
            report.remarks().iter().map(|text| remark(file, text)).collect::<Vec<_>>()
        };
        return Ok(Read { found: moving, remarks: reports.iter().flat_map(of_file).collect() });
    }
    let Read { found: (animated, gltf), mut remarks } = input.animated()?;
    let baked = match gltf.as_ref().filter(|gltf| BakedTransfer::covers(gltf, animated.rest())) {
        Some(gltf) => Some(BakedTransfer::of(gltf, animated.rest())?),
        None => None,
    };
    let chosen = match animation {
        Some(name) => Some(animated.animation(name)?),
        None => (!animated.animations().is_empty()).then_some(0),
    };
    let mut moving = MovingScene::animated(animated, chosen)?;
    let (order, bounces) = asked;
    let dropped = baked.and_then(|baked| moving.keep_baked(&baked, order, bounces));
    remarks.extend(dropped.map(|text| remark(&input.path, &text)));
    Ok(Read { found: moving, remarks })
}

/// A scene that moves, and how it is shaded once its parts are baked.
#[pyclass(frozen, module = "lobe")]
pub(crate) struct Moving {
    span: [f64; 2],
    inner: Mutex<Inner>,
    /// The thread that holds the scene.
    holder: Mutex<Option<ThreadId>>,
}

struct Inner {
    scene: MovingScene,
    /// And the options of bakes of backs.
    shading: Option<(MovingShading, BakeOptions)>,
    /// Of the moment that was shaded before.
    tree: Option<Bvh>,
}

/// How often a thread that waits for a scene asks for it, and answers Ctrl-C.
const WAIT: Duration = Duration::from_millis(10);

/// A scene that no other thread has.
struct Held<'a> {
    inner: MutexGuard<'a, Inner>,
    holder: &'a Mutex<Option<ThreadId>>,
}

impl Drop for Held<'_> {
    fn drop(&mut self) {
        *self.holder.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

impl Moving {
    fn new(span: [f64; 2], inner: Inner) -> Self {
        Self { span, inner: Mutex::new(inner), holder: Mutex::new(None) }
    }

    /// The scene, once no other thread works on it. A function that is called by the work, as that of progress is, would wait for ever, and
    /// is refused.
    fn hold(&self, py: Python<'_>) -> PyResult<Held<'_>> {
        let holder = || self.holder.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            let inner = match self.inner.try_lock() {
                Ok(inner) => inner,
                Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
                Err(TryLockError::WouldBlock) => {
                    if *holder() == Some(thread::current().id()) {
                        let text = "the scene is at work: what is called while it bakes or renders cannot ask it";
                        return Err(PyRuntimeError::new_err(text));
                    }
                    py.check_signals()?;
                    py.detach(|| thread::sleep(WAIT));
                    continue;
                }
            };
            *holder() = Some(thread::current().id());
            return Ok(Held { inner, holder: &self.holder });
        }
    }
}

#[pymethods]
impl Moving {
    /// Reads a scene; `asked` is the order and the bounces that transfer in the file is kept for.
    #[staticmethod]
    fn load(
        py: Python<'_>,
        input: SceneInput,
        animation: Option<String>,
        is_looped: bool,
        asked: (Option<usize>, Option<usize>),
    ) -> PyResult<Self> {
        let read = answered(py, usize::MAX, move || read(&input, animation.as_deref(), asked))?;
        let scene = read.map_err(|error| error_of(&error))?.told(py)?.looped(is_looped);
        let span = scene.span();
        Ok(Self::new(span, Inner { scene, shading: None, tree: None }))
    }

    /// The times, in seconds, between which the scene moves.
    #[getter]
    fn span(&self) -> [f64; 2] {
        self.span
    }

    /// The names of its parts.
    fn parts(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.hold(py)?.inner.scene.parts().iter().map(|part| part.name.clone()).collect())
    }

    /// Two corners of the box around the scene at a time.
    fn bounds(&self, py: Python<'_>, time: f64) -> PyResult<[[f64; 3]; 2]> {
        let inner = &mut *self.hold(py)?.inner;
        py.detach(|| with_threads(|| inner.scene.world_bounds(time))).map_err(|error| error_of(&error))
    }

    /// Bakes what the parts lack, kept in files whose names begin with `checkpoint` if there is one; the order.
    fn bake(
        &self,
        py: Python<'_>,
        shading: Shading,
        checkpoint: Option<PathBuf>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<usize> {
        let method = shading.method()?;
        let mut held = self.hold(py)?;
        let inner = &mut *held.inner;
        let transfer = shading.transfer(&inner.scene);
        let made = shading.shading(transfer.order)?;
        let bakes = shading.bakes(&transfer);
        if shading.split {
            let adaptive = AdaptiveOptions::default().max_vertices(shading.max_vertices);
            let split = MovingSplitOptions::default().adaptive(adaptive.bake(bakes.transfer.clone()));
            watched(py, progress.as_ref(), None, |job| inner.scene.split(&split, job))?;
            inner.tree = None;
        }
        watched(py, progress.as_ref(), checkpoint.as_deref(), |job| {
            inner.scene.expect_order(transfer.order)?;
            inner.scene.bake(method, &bakes, job)?;
            inner.shading = Some((made, transfer.clone()));
            Ok::<_, RenderError>(())
        })?;
        Ok(transfer.order)
    }

    /// A moment under light, before a background as of `render_still`: `(height, width, 3)`, or 4 before nothing.
    #[expect(clippy::too_many_arguments, reason = "a picture takes its time, its light, its view and its size")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        time: f64,
        light: PyReadonlyArray2<'py, f64>,
        map: Option<&Map>,
        background: &str,
        view: View,
        size: (usize, usize),
        rays: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Pixels<'py>> {
        let (light, options) = (expansion(&light)?, view_options(size, rays));
        let camera = camera_around(self.bounds(py, time)?, view)?;
        let behind = Behind::new(background, map)?;
        let shown = |s: Dir| behind.seen([&light, &light], s);
        let mut held = self.hold(py)?;
        let inner = &mut *held.inner;
        let lit = watched(py, progress.as_ref(), None, |mut job| {
            let Some((shading, bake)) = &inner.shading else {
                return Err(RenderError::Options("the parts are not baked; bake them first".to_owned()));
            };
            let mut moment = inner.scene.at_with(time, inner.tree.take())?;
            let seen = MovingScene::backs_in_view(&moment, &camera, &options, job.reborrow())?;
            if !seen.is_empty() {
                let bvh = moment.into_bvh();
                inner.scene.bake_backs(&seen, bake, job.reborrow())?;
                moment = inner.scene.at_with(time, Some(bvh))?;
            }
            let lit = light_moving_scene(&moment, shading, &light, &camera, &options, shown, job)?;
            inner.tree = Some(moment.into_bvh());
            Ok(lit)
        })?;
        behind.pixels(py, lit)
    }

    /// A moment path traced under a lat-long map or an expansion, with the scene's lamps.
    #[expect(
        clippy::too_many_arguments,
        reason = "a picture takes its time, its light, its view, its size and its paths"
    )]
    fn trace<'py>(
        &self,
        py: Python<'py>,
        time: f64,
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
        let camera = camera_around(self.bounds(py, time)?, view)?;
        if let Some(share) = &share {
            share.begin(py, &[], progress.as_ref())?;
        }
        let mut held = self.hold(py)?;
        let inner = &mut *held.inner;
        traced(py, share.as_ref(), progress.as_ref(), |shard, job| {
            let moment = inner.scene.at(time)?;
            let emitters = moment.emitters();
            trace(moment.scene(), moment.bvh(), &camera, (&distant, &emitters), &options, shard, job)
        })
    }
}
