//! Measurement of each pass.

use std::f64::consts::TAU;
use std::fmt;

use lobe_env::SceneLight;
use lobe_sh::{Dir, Rotation};
use web_time::Instant;

use crate::context::context::Context;
use crate::error::GpuError;
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::pieces::VALUE;
use crate::renderer::renderer::{PassTime, Renderer};
use crate::renderer::shader::Shader;
use crate::scene_view::scene_view::SceneView;

/// Bytes of a copy that measures how fast the device moves them: more than caches hold, and no more than the 128 MiB of a storage
/// binding that WebGPU warrants.
const COPIED: u64 = 128 << 20;

/// Copies one after the other for which the device is waited once, so that the wait, some tenths of a millisecond, is a small part: one where
/// it takes `SLOW_SECONDS` by itself, more of them where a few take less than that together.
const COPIES: usize = 8;
const MORE_COPIES: usize = 64;
const SLOW_SECONDS: f64 = 0.02;

/// What the passes of a renderer take: printed, a table.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct BenchReport {
    /// The device.
    pub device: String,
    /// Runs over which the least time was taken.
    pub runs: usize,
    /// For each pass the least time of all runs.
    pub passes: Vec<PassTime>,
}

impl BenchReport {
    /// Runs the passes `runs` times, after once to get warm, and keeps the least time of each.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn measure(renderer: &Renderer, runs: usize) -> Result<Self, GpuError> {
        let mut passes = renderer.run_timed()?;
        for _ in 0..runs {
            for (best, time) in passes.iter_mut().zip(renderer.run_timed()?) {
                best.milliseconds = match (best.milliseconds, time.milliseconds) {
                    (Some(a), Some(b)) => Some(a.min(b)),
                    (a, b) => a.or(b),
                };
            }
        }
        Ok(Self { device: renderer.context().describe(), runs, passes })
    }

    /// [`BenchReport::measure`] of the passes of a scene.
    ///
    /// # Errors
    /// As there.
    pub fn of_view(view: &SceneView, runs: usize) -> Result<Self, GpuError> {
        Self::measure(view.renderer(), runs)
    }

    /// Frames a second of a scene while its sky turns: for each, the light is rotated on the processor, uploaded, all passes run,
    /// and the device is waited for. The mean over `frames` frames, after one to get warm.
    ///
    /// # Errors
    /// [`GpuError::Options`] if there are no frames; [`GpuError::Device`] if the device fails.
    pub fn frames_per_second(view: &SceneView, light: &SceneLight, frames: usize) -> Result<f64, GpuError> {
        if frames == 0 {
            return Err(GpuError::Options("expected at least one frame, found none".into()));
        }
        let frame = |number: usize| {
            let turn = Rotation::from_axis_angle(Dir::Z, TAU * number as f64 / frames as f64);
            view.set_scene_light(&light.rotated(&turn))?;
            view.turn_backdrop(&turn)?;
            view.render()?;
            view.renderer().context().wait()
        };
        frame(0)?;
        let begin = Instant::now();
        (1..=frames).try_for_each(frame)?;
        Ok(frames as f64 / begin.elapsed().as_secs_f64())
    }

    /// Milliseconds of a run of all passes by the clock, with the wait for the device: the least of `runs`, after one to get warm. Where
    /// a device measures no times, or those of pixels alone as programs that emulate one do, this says what compute takes.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn milliseconds_a_run(renderer: &Renderer, runs: usize) -> Result<f64, GpuError> {
        let run = || {
            let begin = Instant::now();
            renderer.run()?;
            renderer.context().wait()?;
            Ok::<_, GpuError>(1e3 * begin.elapsed().as_secs_f64())
        };
        run()?;
        (0..runs.max(1)).try_fold(f64::INFINITY, |least, _| Ok(least.min(run()?)))
    }

    /// Bytes a second that the device copies from one buffer to another, by its own command or by a shader, as is quicker, each
    /// counted twice, read and written: what passes that only move bytes would take is `bytes` over this. By the command alone on a
    /// device without storage buffers.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn copied_bytes_a_second(context: &Context) -> Result<f64, GpuError> {
        let limits = context.device().limits();
        let bytes = COPIED.min(limits.max_buffer_size);
        let by_command = bytes as f64 / seconds_a_copy(context, &command_copy(context, bytes)?)?;
        if !context.has_storage() {
            return Ok(2.0 * by_command);
        }
        let bytes = bytes.min(context.max_storage_binding()) / VALUE * VALUE;
        let by_shader = bytes as f64 / seconds_a_copy(context, &shader_copy(context, bytes)?)?;
        Ok(2.0 * by_command.max(by_shader))
    }

    /// Milliseconds of all passes; `None` if the device measures no times.
    fn total(&self) -> Option<f64> {
        self.passes.iter().map(|pass| pass.milliseconds).sum()
    }
}

/// So many copies, one after the other.
type Copies<'a> = dyn Fn(usize) -> Result<(), GpuError> + 'a;

/// The least time of a copy over three runs, after one to get warm.
fn seconds_a_copy(context: &Context, copy: &Copies<'_>) -> Result<f64, GpuError> {
    let run = |copies: usize| {
        let begin = Instant::now();
        copy(copies)?;
        context.wait()?;
        Ok::<_, GpuError>(begin.elapsed().as_secs_f64() / copies as f64)
    };
    run(1)?;
    let copies = if run(1)? >= SLOW_SECONDS {
        1
    } else if COPIES as f64 * run(COPIES)? < SLOW_SECONDS {
        MORE_COPIES
    } else {
        COPIES
    };
    (0..3).try_fold(f64::INFINITY, |least, _| Ok(least.min(run(copies)?)))
}

fn shader_copy(context: &Context, bytes: u64) -> Result<impl Fn(usize) -> Result<(), GpuError>, GpuError> {
    let mut renderer = Renderer::new(context);
    renderer.upload("from", &vec![0_u8; bytes as usize])?;
    renderer.allocate("to", bytes)?;
    let kernel = Kernel::new(context, "copy", &Shader::new(&["copy"]), &[Slot::Read, Slot::Write])?;
    renderer.add(Pass::compute("copy", &kernel, (bytes / VALUE) as u32).read("from").write("to"))?;
    Ok(move |copies| (0..copies).try_for_each(|_| renderer.run()))
}

fn command_copy(context: &Context, bytes: u64) -> Result<impl Fn(usize) -> Result<(), GpuError>, GpuError> {
    let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let (from, to) = (context.empty("copied from", bytes, usage)?, context.empty("copied to", bytes, usage)?);
    Ok(move |copies| {
        let mut encoder = context.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for _ in 0..copies {
            encoder.copy_buffer_to_buffer(&from, 0, &to, 0, bytes);
        }
        context.queue().submit([encoder.finish()]);
        Ok(())
    })
}

impl fmt::Display for BenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}, least of {} runs", self.device, self.runs)?;
        let width = self.passes.iter().map(|pass| pass.name.len()).max().unwrap_or(0).max(5);
        writeln!(f, "{:width$} | {:>10} | {:>10}", "pass", "ms", "MB bound")?;
        let ms = |time: Option<f64>| time.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.3}"));
        for PassTime { name, milliseconds, bytes } in &self.passes {
            writeln!(f, "{name:width$} | {:>10} | {:>10.3}", ms(*milliseconds), *bytes as f64 * 1e-6)?;
        }
        let bytes: u64 = self.passes.iter().map(|pass| pass.bytes).sum();
        writeln!(f, "{:width$} | {:>10} | {:>10.3}", "all", ms(self.total()), bytes as f64 * 1e-6)
    }
}
