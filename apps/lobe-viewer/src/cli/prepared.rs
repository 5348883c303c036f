//! A scene, its light and its transfer on a device.

use std::io::{IsTerminal as _, Write as _, stderr};
use std::ops::ControlFlow;

use anyhow::{Context as _, bail};
use lobe::io::Progress;
use lobe::prt::{BakeMode, Transfer};
use lobe::sh::{Rgb, ShVec};
use lobe_gpu::{
    AdapterChoice, Context, ContextOptions, Environment, GlossyMesh, GpuError, SceneView, SceneViewOptions,
    SurfaceShading,
};

use crate::cli::args::Arguments;
use crate::loading::bake::{GlossyBake, SceneData, bake_glossy, bake_options, bake_scene};
use crate::loading::mode::Mode;
use crate::loading::places::Places;
use crate::loading::scene_source::OpenedScene;
use crate::loading::sky_source::open_sky;
use crate::widgets::orbit::Orbit;

/// A scene on a device under a light.
pub(crate) struct Prepared {
    pub(crate) context: Context,
    pub(crate) view: SceneView,
    pub(crate) light: ShVec<Rgb<f64>>,
    pub(crate) vertices: usize,
    pub(crate) name: String,
}

/// Reads the sky, bakes where that is needed, and uploads.
pub(crate) fn prepare(
    arguments: &Arguments,
    opened: OpenedScene,
    options: &SceneViewOptions,
) -> anyhow::Result<Prepared> {
    let Some(mode) = arguments.mode.of_still() else {
        bail!("--mode fields and exponentials: of scenes that move, with --headless; leave the option out");
    };
    if let Some(file) = arguments.parts.first() {
        bail!("--part {}: of scenes that move; ask for --mode fields or exponentials too", file.display());
    }
    let sky = open_sky(&arguments.env, &arguments.limits)?;
    let data = SceneData::new(opened.name, opened.scene);
    let mut order = usize::from(arguments.order);
    let mut baked = Vec::new();
    let mut places = Places::Vertices;
    let is_baked = opened.baked.is_some();
    if let Some(file) = opened.baked {
        let found = file.recipe.mode.unwrap_or(BakeMode::Interreflected);
        if !mode.bakes().iter().all(|needed| *needed == found) {
            let wanted = mode.title().to_lowercase();
            bail!(
                "--mode {wanted}: {} was baked as {}; ask for that, or for the scene it was baked from",
                data.name,
                found.name()
            );
        }
        if order > file.transfer.order() {
            bail!("--order {order}: {} was baked to order {}; ask for that", data.name, file.transfer.order());
        }
        order = file.transfer.order();
        places = Places::vertices(&file.recipe);
        baked.push((found, file.transfer));
    } else {
        for &mode in mode.bakes() {
            let options = bake_options(mode, order, arguments.samples);
            let (transfer, _) = bake_scene(&data, &options, progress(format!("{} transfer", mode.name())))?;
            baked.push((mode, transfer));
        }
    }
    let is_shining = !is_baked && mode == Mode::Interreflected;
    let glossy =
        if is_shining { bake_glossy(&data, order, arguments.samples, progress("metals"))? } else { Vec::new() };
    let of = |mode: BakeMode| baked.iter().find(|(found, _)| *found == mode).map(|(_, transfer)| transfer);
    let transfer: Option<Transfer> = mode.transfer(of)?;
    let context = device(arguments)?;
    let meshes: Vec<GlossyMesh<'_>> = glossy.iter().map(GlossyBake::on_device).collect();
    let shading = match &transfer {
        Some(transfer) => places.shading(transfer, &meshes, arguments.storage.into()),
        None => SurfaceShading::Irradiance(order),
    };
    let view = SceneView::new(&context, &data.scene, &shading, Some(&Environment::from(&*sky.map)), options)?;
    let [azimuth, height] = arguments.eye.map(f64::to_radians);
    let orbit = Orbit { azimuth, height, ..Orbit::default() }.framing(data.scene.world_bounds());
    view.set_camera(&orbit.on_device().context("the scene has no extent")?)?;
    let light = sky.light.resized(usize::from(arguments.order));
    Ok(Prepared { context, view, light, vertices: data.scene.vertex_count(), name: data.name })
}

/// The device that is asked for.
pub(crate) fn device(arguments: &Arguments) -> Result<Context, GpuError> {
    let adapter = if arguments.software { AdapterChoice::Software } else { AdapterChoice::Fastest };
    Context::new(&ContextOptions::default().adapter(adapter))
}

/// A line on the terminal that says how far a bake is.
pub(crate) fn progress(what: impl Into<String>) -> impl FnMut(&Progress) -> ControlFlow<()> {
    let (is_shown, what) = (stderr().is_terminal(), what.into());
    move |progress| {
        if is_shown {
            let percent = 100 * progress.done / progress.total.max(1);
            let end = if progress.done == progress.total { "\r\x1b[K" } else { "" };
            // A terminal that has gone away is told nothing.
            drop(write!(stderr(), "\r{what}: {percent} %{end}"));
        }
        ControlFlow::Continue(())
    }
}
