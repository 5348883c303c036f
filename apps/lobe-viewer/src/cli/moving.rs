//! Pictures of what moves to files, without a window: the moments of its time one after the other.

use std::path::Path;

use anyhow::bail;
use lobe::image::{Exposure, FrameSequence};
use lobe::io::Job;
use lobe::motion::{MovingMethod, MovingOptions, MovingScene, MovingShading};
use lobe::sh::Rgb;
use lobe::shadow::SphereFitMethod;
use lobe_gpu::{SceneView, SceneViewOptions, SunsApart, SurfaceShading, TurntableOptions};

use crate::cli::args::{Arguments, camera_around};
use crate::cli::failure::note;
use crate::cli::prepared::device;
use crate::cli::progress::progress;
use crate::cli::shown::ORDER;
use crate::loading::backdrop::Behind;
use crate::loading::moving_bakes::{leaves_suns, moving_bake_options};
use crate::loading::moving_light::MovingLight;
use crate::loading::moving_source::{is_file, open_moving, split_for_shadows, with_files};
use crate::loading::sky_source::open_sky_with;

/// Renders a scene that moves at `--frames` moments, from the begin of its time to shortly before its end, where it begins anew.
pub(crate) fn run(
    arguments: &Arguments,
    (source, method): (&Path, MovingMethod),
    options: &SceneViewOptions,
    output: &Path,
) -> anyhow::Result<()> {
    arguments.check_surfaces()?;
    let sky = open_sky_with(&arguments.env, &arguments.limits, &arguments.suns)?;
    let mut scene = with_files(open_moving(source, &arguments.limits)?, &arguments.parts)?;
    let parts_suns = leaves_suns(&scene);
    split_for_shadows(&mut scene, source, Job::default().watched_by(&mut progress("split")))?;
    let baked = scene.order();
    let order = arguments.order.map_or(baked.unwrap_or(ORDER), usize::from);
    if let Some(most) = baked.filter(|most| order > *most) {
        bail!("--order {order}: parts of {} came baked to order {most}; ask for that", source.display());
    }
    bake(&mut scene, (method, order), arguments, is_file(source))?;
    let shading = MovingShading::new(MovingOptions::default().order(order).method(method))?;
    let all = sky.split_to(order);
    let suns = if parts_suns { all.suns().len().min(SunsApart::MOST) } else { 0 };
    // More suns than are shown, and those of what came baked, are in the expansion.
    let light = SunsApart::Shadowed(suns).split(&all).into_owned();
    let [begin, end] = scene.span();
    let frames = usize::from(arguments.frames);
    let time = |frame: usize| begin + (end - begin) * frame as f64 / frames as f64;
    let first = scene.at(begin)?;
    let context = device(arguments)?;
    let behind = Behind::new(arguments.background, || all.whole());
    let environment = behind.on_device(&context, Some(&sky.map));
    let mut lit = MovingLight::new(shading, Some(&context), arguments.lit_on);
    let radiance = vec![Rgb::new(0.0, 0.0, 0.0); first.scene().vertex_count()];
    let shown = SurfaceShading::Radiance(&radiance);
    let apart = if suns == 0 { SunsApart::No } else { SunsApart::Shadowed(suns) };
    let view = SceneView::with_suns(&context, first.scene(), (&shown, apart), environment.as_ref(), options)?;
    view.set_scene_light(&light)?;
    let camera = camera_around(&arguments.camera, bounds(&scene, (0..frames).map(time))?)?;
    view.set_camera(&camera)?;
    let alpha = behind.alpha(&context, first.scene(), options, &camera)?;
    let (width, height) = (options.width as usize, options.height as usize);
    let sequence = FrameSequence { width, height, frames, seconds_per_frame: TurntableOptions::default().seconds };
    let mut tone = arguments.tone()?;
    let written: anyhow::Result<()> = sequence.write(output, |add| {
        for frame in 0..frames {
            let moment = scene.at(time(frame))?;
            view.set_vertices(moment.scene())?;
            lit.show(&moment, light.rest(), &view)?;
            view.render()?;
            let mut picture = view.picture()?;
            if let Some(alpha) = &alpha {
                alpha.set_vertices(moment.scene())?;
                picture = alpha.put_into(picture)?;
            }
            if !matches!(tone.exposure, Exposure::Fixed(_)) {
                tone = tone.fixed_for(&picture);
            }
            add(&picture, &tone)?;
        }
        Ok(())
    });
    written?;
    note(&format!("lit {}", lit.place()));
    Ok(())
}

/// The box around the scene at all of these times, so that nothing leaves the pictures.
fn bounds(scene: &MovingScene, times: impl Iterator<Item = f64>) -> anyhow::Result<[[f64; 3]; 2]> {
    let mut all = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for time in times {
        let [min, max] = scene.world_bounds(time)?;
        for k in 0..3 {
            (all[0][k], all[1][k]) = (all[0][k].min(min[k]), all[1][k].max(max[k]));
        }
    }
    Ok(all)
}

fn bake(
    scene: &mut MovingScene,
    (method, order): (MovingMethod, usize),
    arguments: &Arguments,
    still_hides: bool,
) -> anyhow::Result<()> {
    let count = usize::from(arguments.spheres);
    let options = moving_bake_options(order, SphereFitMethod::Variational, count, still_hides);
    scene.bake_lamps(order)?;
    for bake in scene.lacking(method, &options) {
        let mut watch = progress(bake.to_string());
        scene.bake_part(&bake, &options, Job::default().watched_by(&mut watch))?;
    }
    Ok(())
}
