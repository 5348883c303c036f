//! A scene, its light and its transfer on a device.

use anyhow::bail;
use lobe::sh::{Rgb, ShVec};
use lobe_gpu::{AdapterChoice, Context, ContextOptions, GpuError, SceneView, SceneViewOptions};

use crate::cli::args::{Arguments, camera_around};
use crate::cli::shown::Shown;
use crate::loading::backdrop::{Alpha, Behind};
use crate::loading::bake::SceneData;
use crate::loading::scene_source::OpenedScene;
use crate::loading::sky_source::open_sky;

/// A scene on a device under a light.
pub(crate) struct Prepared {
    pub(crate) context: Context,
    pub(crate) view: SceneView,
    /// Of pictures before nothing.
    pub(crate) alpha: Option<Alpha>,
    pub(crate) light: ShVec<Rgb<f64>>,
    /// The bands of the light that are asked for or shown.
    pub(crate) order: usize,
    pub(crate) vertices: usize,
    pub(crate) name: String,
}

/// Reads the sky, bakes where that is needed, and uploads.
pub(crate) fn prepare(
    arguments: &Arguments,
    opened: OpenedScene,
    options: &SceneViewOptions,
) -> anyhow::Result<Prepared> {
    if let Some(file) = arguments.parts.first() {
        bail!("--part {}: of scenes that move; ask for --mode fields or exponentials too", file.display());
    }
    let sky = open_sky(&arguments.env, &arguments.limits)?;
    let data = SceneData::new(opened.name, opened.scene);
    let shown = Shown::new(arguments, &data, opened.baked, &sky.map)?;
    let context = device(arguments)?;
    let meshes = shown.meshes();
    let shading = shown.shading(&meshes, arguments.storage.into());
    let order = arguments.order.map_or(shown.order(), usize::from);
    let light = sky.light.resized(order);
    let behind = Behind::new(arguments.background, || light.clone());
    let environment = behind.on_device(&context, Some(&sky.map));
    let view = SceneView::new(&context, &data.scene, &shading, environment.as_ref(), options)?;
    let camera = camera_around(&arguments.camera, data.scene.world_bounds())?;
    view.set_camera(&camera)?;
    let alpha = behind.alpha(&context, &data.scene, options, &camera)?;
    Ok(Prepared { context, view, alpha, light, order, vertices: data.scene.vertex_count(), name: data.name })
}

/// The device that is asked for.
pub(crate) fn device(arguments: &Arguments) -> Result<Context, GpuError> {
    let adapter = if arguments.software { AdapterChoice::Software } else { AdapterChoice::Fastest };
    Context::new(&ContextOptions::default().adapter(adapter))
}
