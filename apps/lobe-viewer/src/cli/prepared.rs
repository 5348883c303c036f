//! A scene, its light and its transfer on a device.

use std::io::{IsTerminal as _, Write as _, stderr};
use std::ops::ControlFlow;

use anyhow::{Context as _, bail};
use lobe::io::Progress;
use lobe::prt::{BakeMode, Transfer};
use lobe::sh::{Rgb, ShVec};
use lobe_gpu::{
    AdapterChoice, Context, ContextOptions, Environment, GlossyMesh, SceneView, SceneViewOptions, SurfaceShading,
};

use crate::cli::args::Arguments;
use crate::loading::bake::{self, GlossyBake, SceneData, bake_glossy, bake_options, bake_scene};
use crate::loading::mode::Mode;
use crate::loading::scene_source::OpenedScene;
use crate::loading::sky_source::open_sky;
use crate::widgets::orbit::Orbit;

/// A scene on a device under a light.
pub(crate) struct Prepared {
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
    let sky = open_sky(&arguments.env, &arguments.limits)?;
    let data = SceneData::new(opened.name, opened.scene);
    let mut order = usize::from(arguments.order);
    let mut baked = Vec::new();
    let mut is_demodulated = false;
    let is_baked = opened.baked.is_some();
    if let Some(file) = opened.baked {
        let found = file.recipe.mode.unwrap_or(BakeMode::Interreflected);
        if !arguments.mode.bakes().iter().all(|needed| *needed == found) {
            let wanted = arguments.mode.title().to_lowercase();
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
        is_demodulated = bake::is_demodulated(&file.recipe);
        baked.push((found, file.transfer));
    } else {
        for &mode in arguments.mode.bakes() {
            let options = bake_options(mode, order, arguments.samples);
            let (transfer, _) = bake_scene(&data, &options, progress(mode.name()))?;
            baked.push((mode, transfer));
        }
    }
    let is_shining = !is_baked && arguments.mode == Mode::Interreflected;
    let glossy =
        if is_shining { bake_glossy(&data, order, arguments.samples, progress("metals"))? } else { Vec::new() };
    let of = |mode: BakeMode| baked.iter().find(|(found, _)| *found == mode).map(|(_, transfer)| transfer);
    let transfer: Option<Transfer> = arguments.mode.transfer(of)?;
    let adapter = if arguments.software { AdapterChoice::Software } else { AdapterChoice::Fastest };
    let context = Context::new(&ContextOptions::default().adapter(adapter))?;
    let meshes: Vec<GlossyMesh<'_>> = glossy.iter().map(GlossyBake::on_device).collect();
    let shading = match &transfer {
        Some(transfer) if is_demodulated => SurfaceShading::Demodulated(transfer, arguments.storage.into()),
        Some(transfer) => SurfaceShading::Mixed(transfer, &meshes, arguments.storage.into()),
        None => SurfaceShading::Irradiance(order),
    };
    let view = SceneView::new(&context, &data.scene, &shading, Some(&Environment::from(&*sky.map)), options)?;
    let [azimuth, height] = arguments.eye.map(f64::to_radians);
    let orbit = Orbit { azimuth, height, ..Orbit::default() }.framing(data.scene.world_bounds());
    view.set_camera(&orbit.on_device().context("the scene has no extent")?)?;
    let light = sky.light.resized(usize::from(arguments.order));
    Ok(Prepared { view, light, vertices: data.scene.vertex_count(), name: data.name })
}

/// A line on the terminal that says how far a bake is.
fn progress(what: &'static str) -> impl FnMut(&Progress) -> ControlFlow<()> {
    let is_shown = stderr().is_terminal();
    move |progress| {
        if is_shown {
            let percent = 100 * progress.done / progress.total.max(1);
            let end = if progress.done == progress.total { "\r\x1b[K" } else { "" };
            // A terminal that has gone away is told nothing.
            drop(write!(stderr(), "\r{what} transfer: {percent} %{end}"));
        }
        ControlFlow::Continue(())
    }
}
