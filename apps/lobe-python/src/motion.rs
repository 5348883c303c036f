//! Scenes that move: their moments under distant light, by transfer of their parts, and path traced.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::{self, ThreadId};
use std::time::Duration;

use lobe::io::{JobFiles, JobOptions as _, MemoryLimit};
use lobe::motion::{MovingJob, MovingScene, MovingShading, OneBake, light_moving_scene};
use lobe::prt::BakeOptions;
use lobe::render::RenderError;
use lobe::scene::Bvh;
use lobe::sh::Dir;
use numpy::PyReadonlyArray2;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::forked::with_threads;
use crate::job::{error_of, heard, watched, watched_and_heard};
use crate::maps::Map;
use crate::options::{refusal, values_of};
use crate::pictures::{
    Behind, Lighting, Paths, Pixels, Traced, View, camera_around, distant_light, trace, traced, view_options,
};
use crate::scenes::SceneInput;
use crate::sharing::Share;

/// The job of a dictionary of options.
fn job_of(asked: &Bound<'_, PyDict>) -> PyResult<MovingJob> {
    MovingJob::from_values(values_of(asked)?).map_err(|error| refusal(&error))
}

/// Refuses options that are out of range, or cannot be had together.
#[pyfunction]
pub(crate) fn check_moving(asked: &Bound<'_, PyDict>) -> PyResult<()> {
    job_of(asked).map(drop)
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
    name: String,
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
    /// Reads a scene; transfer in the file is kept as far as it suits the order.
    #[staticmethod]
    fn load(
        py: Python<'_>,
        mut input: SceneInput,
        animation: Option<String>,
        asked: &Bound<'_, PyDict>,
        order: Option<usize>,
        is_looped: bool,
    ) -> PyResult<Self> {
        let job = job_of(asked)?;
        input.source.animation = animation;
        let (name, memory) = (input.source.name(), input.memory);
        let read = heard(py, move |work| job.read(input.open()?, (order, true), memory, work))?;
        let scene = read.moving.looped(is_looped);
        let span = scene.span();
        Ok(Self::new(span, Inner { name, scene, shading: None, tree: None }))
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

    /// Bakes what the parts lack, for lights with suns, too, kept in files whose names begin with `checkpoint` if
    /// there is one; the order.
    fn bake(
        &self,
        py: Python<'_>,
        asked: &Bound<'_, PyDict>,
        order: Option<usize>,
        checkpoint: Option<PathBuf>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<usize> {
        let job = job_of(asked)?;
        MovingJob::check_order(order).map_err(|error| refusal(&error))?;
        let mut held = self.hold(py)?;
        let Inner { scene, shading, tree, name } = &mut *held.inner;
        let light = job.light(scene, order);
        let files = checkpoint.map(|path| JobFiles::kept_in(path.clone(), path));
        watched_and_heard(py, progress.as_ref(), |mut work| {
            job.split(scene, &light, name, work.reborrow())?;
            *tree = None;
            let mut bake_one = |_: &str, own: Option<&JobFiles>, bake: &mut OneBake<'_>| {
                let one = work.reborrow();
                bake(if let Some(own) = own { one.kept_in(own.checkpoint()) } else { one })
            };
            let unlimited = MemoryLimit::of(f64::MAX);
            let (made, _) =
                job.prepare::<RenderError>(scene, &light, true, (unlimited, files.as_ref()), &mut bake_one)?;
            *shading = Some((made, light.clone()));
            Ok::<_, RenderError>(())
        })?;
        Ok(light.order)
    }

    /// A moment under light, before a background as of `render_still`: `(height, width, 3)`, or 4 before nothing.
    #[expect(clippy::too_many_arguments, reason = "a picture takes its time, its light, its view and its size")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        time: f64,
        lighting: Lighting<'py>,
        background: &str,
        view: View,
        size: (usize, usize),
        rays: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Pixels<'py>> {
        let (light, options) = (lighting.split()?, view_options(size, rays));
        let camera = camera_around(self.bounds(py, time)?, view)?;
        let behind = Behind::new(background, lighting.1.as_deref())?;
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
