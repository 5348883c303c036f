//! Pictures of what moves to files, without a window: the moments of its time one after the other.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use lobe::image::{Exposure, Picture, PictureWriteOptions, Tone, write_animated_png, write_picture};
use lobe::io::Job;
use lobe::render::{MovingMethod, MovingOptions, MovingScene, MovingShading};
use lobe::shadow::SphereFitMethod;
use lobe_gpu::{Environment, SceneView, SceneViewOptions, SurfaceShading};

use crate::cli::args::Arguments;
use crate::cli::prepared::{device, progress};
use crate::loading::moving_bakes::moving_bake_options;
use crate::loading::moving_source::{is_file, open_moving, with_files};
use crate::loading::sky_source::open_sky;
use crate::widgets::orbit::Orbit;

/// Renders a scene that moves at `--frames` moments, from the begin of its time to shortly before its end, where it begins anew.
pub(crate) fn run(
    arguments: &Arguments,
    (source, method): (&Path, MovingMethod),
    options: &SceneViewOptions,
    output: &Path,
) -> anyhow::Result<()> {
    let sky = open_sky(&arguments.env, &arguments.limits)?;
    let mut scene = with_files(open_moving(source, &arguments.limits)?, &arguments.parts)?;
    let order = usize::from(arguments.order);
    let most = scene.order().unwrap_or(order);
    if order > most {
        bail!("--order {order}: parts of {} came baked to order {most}; ask for that", source.display());
    }
    bake(&mut scene, method, arguments, is_file(source))?;
    let shading = MovingShading::new(MovingOptions::default().order(order).method(method))?;
    let light = sky.light.resized(order);
    let [begin, end] = scene.span();
    let frames = usize::from(arguments.frames);
    let time = |frame: usize| begin + (end - begin) * frame as f64 / frames as f64;
    let first = scene.at(begin)?;
    let radiance = shading.exit_radiance(&first, &light)?;
    let environment = Environment::from(&*sky.map);
    let context = device(arguments)?;
    let shown = SurfaceShading::Radiance(&radiance);
    let view = SceneView::new(&context, first.scene(), &shown, Some(&environment), options)?;
    let [azimuth, height] = arguments.eye.map(f64::to_radians);
    let orbit = Orbit { azimuth, height, ..Orbit::default() }.framing(first.scene().world_bounds());
    view.set_camera(&orbit.on_device().context("the scene has no extent")?)?;
    let is_png = output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    let (mut kept, mut tone) = (Vec::new(), Tone::PHOTOGRAPH);
    for frame in 0..frames {
        let moment = scene.at(time(frame))?;
        view.set_vertices(moment.scene())?;
        view.set_radiance(&shading.exit_radiance(&moment, &light)?)?;
        view.render()?;
        let picture = view.picture()?;
        if !matches!(tone.exposure, Exposure::Fixed(_)) {
            tone = tone.fixed_for(&picture);
        }
        if is_png {
            kept.push(picture);
        } else {
            write_picture(numbered(output, frame, frames), &picture, &PictureWriteOptions::default())?;
        }
    }
    write_kept(output, &kept, &tone)
}

fn write_kept(output: &Path, kept: &[Picture], tone: &Tone) -> anyhow::Result<()> {
    /// Seconds for which an animated picture shows each.
    const SECONDS: f64 = 0.05;
    match kept {
        [] => Ok(()),
        [picture] => Ok(picture.write_png(output, tone)?),
        pictures => Ok(write_animated_png(output, pictures, tone, SECONDS)?),
    }
}

fn bake(scene: &mut MovingScene, method: MovingMethod, arguments: &Arguments, still_hides: bool) -> anyhow::Result<()> {
    let (order, count) = (usize::from(arguments.order), usize::from(arguments.spheres));
    let options = moving_bake_options(order, SphereFitMethod::Variational, count, still_hides);
    scene.bake_lamps(order)?;
    for bake in scene.lacking(method, &options) {
        let mut watch = progress(bake.to_string());
        scene.bake_part(&bake, &options, Job::default().watched_by(&mut watch))?;
    }
    Ok(())
}

/// `name.0007.exr` of `name.exr`; the path itself for one frame.
fn numbered(path: &Path, number: usize, frames: usize) -> PathBuf {
    if frames == 1 {
        return path.to_owned();
    }
    let ending = path.extension().map(|ending| ending.to_string_lossy().into_owned()).unwrap_or_default();
    path.with_extension(format!("{number:04}.{ending}"))
}
