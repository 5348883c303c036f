//! A scene under a turning sky, frame by frame.

use std::path::Path;

use derive_setters::Setters;
use lobe_image::{FrameSequence, Picture, Tone};
use lobe_io::{Job, Progress};
use lobe_sh::{Dir, Rotation};
use web_time::Instant;

use crate::error::GpuError;
use crate::headless::turning_light::TurningLight;
use crate::scene_view::scene_view::SceneView;

/// Options of [`render_turntable`].
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct TurntableOptions {
    /// Pictures. Default: 1.
    pub frames: usize,
    /// Radians by which light and backdrop turn about +z from one picture to the next. Default: 2π/48.
    pub step: f64,
    /// Seconds for which an animated picture shows each. Default: 0.05.
    pub seconds: f64,
    /// The tone mapping of what is displayed; an exposure that depends on a picture is that of the first one. Default:
    /// [`Tone::PHOTOGRAPH`].
    pub tone: Tone,
}

impl Default for TurntableOptions {
    fn default() -> Self {
        Self { frames: 1, step: std::f64::consts::TAU / 48.0, seconds: 0.05, tone: Tone::PHOTOGRAPH }
    }
}

/// Renders a scene under a sky that turns about +z with the backdrop, and hands each picture, in linear light, to `frame`, with
/// its number and the tone mapping, which is that of the display from the second on.
///
/// The steps of `job` are pictures; it cannot be kept in a file.
///
/// # Errors
/// [`GpuError::Cancelled`] if the watch of the job said to stop, [`GpuError::Options`] if the job has a file,
/// [`GpuError::Device`] if the device fails, and what `frame` returns.
pub fn render_turntable(
    view: &SceneView,
    light: impl Into<TurningLight>,
    options: &TurntableOptions,
    mut frame: impl FnMut(usize, Picture, &Tone) -> Result<(), GpuError>,
    mut job: Job<'_>,
) -> Result<(), GpuError> {
    job.expect_no_checkpoint().map_err(GpuError::Options)?;
    let (light, begin) = (light.into(), Instant::now());
    let mut tone = options.tone;
    for number in 0..options.frames {
        let turn = Rotation::from_axis_angle(Dir::Z, number as f64 * options.step);
        view.set_scene_light(&light.turned(&turn))?;
        view.turn_backdrop(&light.begin.then(turn))?;
        view.render()?;
        let picture = view.picture()?;
        if number == 0 {
            tone = tone.fixed_for(&picture);
            view.set_tone(&tone)?;
        }
        frame(number, picture, &tone)?;
        let (done, total) = (number + 1, options.frames);
        let progress = Progress { done, total, elapsed: begin.elapsed(), ..Progress::default() };
        if job.report(&progress).is_break() && done < total {
            return Err(GpuError::Cancelled);
        }
    }
    Ok(())
}

/// Renders a turntable to files, as [`FrameSequence::write`]: one picture in linear light or for display, as the ending says (.exr,
/// .hdr, .png, ..); of several frames an animated .png, or files with the number of the frame before their ending.
///
/// # Errors
/// [`GpuError::Image`] if a file cannot be written; else as [`render_turntable`].
pub fn write_turntable(
    view: &SceneView,
    light: impl Into<TurningLight>,
    options: &TurntableOptions,
    path: impl AsRef<Path>,
    job: Job<'_>,
) -> Result<(), GpuError> {
    let [width, height] = [view.options().width, view.options().height].map(|side| side as usize);
    let sequence = FrameSequence { width, height, frames: options.frames, seconds_per_frame: options.seconds };
    sequence.write(path, |add| {
        let frame = |_, picture: Picture, tone: &Tone| Ok(add(&picture, tone)?);
        render_turntable(view, light, options, frame, job)
    })
}
