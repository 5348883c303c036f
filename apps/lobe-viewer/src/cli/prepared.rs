//! A scene, its light and its transfer on a device.

use anyhow::bail;
use lobe::env::SceneLight;
use lobe_gpu::{AdapterChoice, Context, ContextOptions, GpuError, SceneView, SceneViewOptions, SunsApart};

use crate::cli::args::{Arguments, camera_around};
use crate::cli::shown::Shown;
use crate::loading::backdrop::{Alpha, Behind};
use crate::loading::bake::SceneData;
use crate::loading::scene_source::OpenedScene;
use crate::loading::sky_source::open_sky_with;

/// A scene on a device under a light.
pub(crate) struct Prepared {
    pub(crate) context: Context,
    pub(crate) view: SceneView,
    /// Of pictures before nothing.
    pub(crate) alpha: Option<Alpha>,
    pub(crate) light: SceneLight,
    /// Suns that are shown beside the expansion.
    pub(crate) suns: usize,
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
    let sky = open_sky_with(&arguments.env, &arguments.limits, &arguments.suns)?;
    let data = SceneData::new(opened.name, opened.scene);
    let count = sky.split.suns().len().min(SunsApart::MOST);
    let shown = Shown::new(arguments, &data, opened.baked, &sky, count > 0)?;
    let context = device(arguments)?;
    let meshes = shown.meshes();
    let shading = shown.shading(&meshes, arguments.storage.into());
    let order = arguments.order.map_or(shown.order(), usize::from);
    let light = sky.split_to(order);
    let behind = Behind::new(arguments.background, || light.whole());
    let environment = behind.on_device(&context, Some(&sky.map));
    let apart = shown.suns(count);
    let suns = if matches!(apart, SunsApart::No) { 0 } else { count };
    let view = SceneView::with_suns(&context, &data.scene, (&shading, apart), environment.as_ref(), options)?;
    let camera = camera_around(&arguments.camera, data.scene.world_bounds())?;
    view.set_camera(&camera)?;
    let alpha = behind.alpha(&context, &data.scene, options, &camera)?;
    let vertices = data.scene.vertex_count();
    Ok(Prepared { context, view, alpha, light, suns, order, vertices, name: data.name })
}

/// The device that is asked for.
pub(crate) fn device(arguments: &Arguments) -> Result<Context, GpuError> {
    let adapter = if arguments.software { AdapterChoice::Software } else { AdapterChoice::Fastest };
    Context::new(&ContextOptions::default().adapter(adapter))
}
