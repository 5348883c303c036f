//! Pictures to files, without a window.

use std::f64::consts::TAU;
use std::path::Path;

use lobe::image::FrameSequence;
use lobe::io::Job;
use lobe_gpu::{SceneViewOptions, TurntableOptions};

use crate::cli::args::Arguments;
use crate::cli::moving;
use crate::cli::prepared::{Prepared, prepare};
use crate::loading::backdrop::write_frames;
use crate::loading::scene_source::open_scene_for;

/// The size of a picture without another choice.
const SIZE: [u32; 2] = [512, 384];

/// Samples of a pixel along each axis without another choice.
const RAYS: u8 = 2;

/// Renders a scene under its sky, which turns once around in `--frames` frames, or one that moves.
pub(crate) fn run(arguments: &Arguments, scene: &Path, output: &Path) -> anyhow::Result<()> {
    arguments.check_output()?;
    let (size, rays) = (arguments.size.unwrap_or(SIZE), arguments.rays.unwrap_or(RAYS));
    let options = SceneViewOptions::default().width(size[0]).height(size[1]).rays(u32::from(rays));
    let options = options.shadow_side(arguments.shadow_side);
    let frames = usize::from(arguments.frames);
    let (width, height) = (size[0] as usize, size[1] as usize);
    FrameSequence { width, height, frames, seconds_per_frame: TurntableOptions::default().seconds }.check(output)?;
    if let Some(method) = arguments.mode.of_moving() {
        return moving::run(arguments, (scene, method), &options, output);
    }
    let opened = open_scene_for(scene, &arguments.limits, arguments.surfaces())?;
    let Prepared { view, alpha, light, .. } = prepare(arguments, opened, &options)?;
    let options = TurntableOptions::default().frames(frames).step(TAU / frames as f64).tone(arguments.tone()?);
    write_frames((&view, alpha.as_ref()), &light, &options, output, Job::default())?;
    Ok(())
}
