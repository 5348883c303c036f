//! The pictures of `lobe render` one after the other: progress, checkpoints, the animation, and what is left after Ctrl-C.

use std::path::Path;
use std::time::Instant;

use anyhow::bail;
use lobe::image::{FrameSequence, Picture, Tone};
use lobe::io::{Job, JobFiles, Progress};
use lobe::render::RenderError;

use crate::render::pictures::{Pictures, Rendered};
use crate::run::ctrl_c;
use crate::run::talk::Talk;

/// A turn of 36 frames takes three seconds.
pub(crate) const SECONDS_PER_FRAME: f64 = 1.0 / 12.0;

/// Steps of one picture in the line of progress.
const STEPS: usize = 1000;

/// Pictures to be rendered.
pub(crate) struct Frames<'a> {
    pub(crate) pictures: &'a Pictures,
    /// Columns and rows.
    pub(crate) size: (usize, usize),
    /// Whether an unfinished picture is kept in a checkpoint.
    pub(crate) is_kept: bool,
    /// Whether bakes of parts that move are kept until all pictures are done.
    pub(crate) keeps_bakes: bool,
    /// In the animation; without it none is written.
    pub(crate) seconds_per_frame: Option<f64>,
    pub(crate) talk: Talk,
}

/// Renders picture `k` by a job.
type RenderOne<'a> = dyn FnMut(usize, Job<'_>) -> Result<Rendered, RenderError> + 'a;

impl Frames<'_> {
    /// Renders and writes all pictures, and their animation; `fresh` forgets unfinished ones. The shards of a single picture lie
    /// in `merged`.
    pub(crate) fn render(
        &self,
        fresh: bool,
        merged: Option<&JobFiles>,
        render: &mut RenderOne<'_>,
    ) -> anyhow::Result<()> {
        let of_picture = |k| merged.cloned().unwrap_or_else(|| JobFiles::beside(self.pictures.path(k)));
        let checkpoints: Vec<_> = (0..self.pictures.count()).map(of_picture).collect();
        if fresh {
            checkpoints.iter().try_for_each(JobFiles::discard)?;
        }
        ctrl_c::watch();
        match self.pictures.animation_path().zip(self.seconds_per_frame) {
            None => self.render_each(&checkpoints, render, &mut |_, _| Ok(()))?,
            Some((path, seconds)) => self.render_animation(&path, seconds, &checkpoints, render)?,
        }
        checkpoints.iter().for_each(JobFiles::finish);
        Ok(())
    }

    fn render_animation(
        &self,
        path: &Path,
        seconds_per_frame: f64,
        checkpoints: &[JobFiles],
        render: &mut RenderOne<'_>,
    ) -> anyhow::Result<()> {
        let ((width, height), frames) = (self.size, checkpoints.len());
        let sequence = FrameSequence { width, height, frames, seconds_per_frame };
        sequence
            .animate(path, |add| self.render_each(checkpoints, render, &mut |picture, tone| Ok(add(picture, tone)?)))
    }

    /// Renders and writes all pictures, one after the other; each is handed to `animate` and dropped.
    fn render_each(
        &self,
        checkpoints: &[JobFiles],
        render: &mut RenderOne<'_>,
        animate: &mut dyn FnMut(&Picture, &Tone) -> Result<(), RenderError>,
    ) -> anyhow::Result<()> {
        let (talk, total, begin) = (self.talk, checkpoints.len() * STEPS, Instant::now());
        let line = talk.progress("render");
        let mut resumed = 0;
        let mut tone = None;
        for (k, checkpoint) in checkpoints.iter().enumerate() {
            let mut is_told = false;
            let mut watch = |progress: &Progress| {
                let part = progress.done as f64 / progress.total as f64;
                let steps = (part * STEPS as f64) as usize;
                if !is_told && progress.resumed > 0 {
                    let text = format!("found; going on from {:.0} %", 100.0 * part);
                    talk.note(&checkpoint.checkpoint().display().to_string(), &text);
                    resumed += steps;
                }
                is_told = true;
                let elapsed = begin.elapsed();
                let all = Progress { done: k * STEPS + steps, total, resumed, elapsed, ..Progress::default() };
                line.show(all.done, total, None, all.seconds_left());
                ctrl_c::go_on()
            };
            let job = Job::default().watched_by(&mut watch);
            let job = if self.is_kept { job.kept_in(checkpoint.checkpoint()) } else { job };
            let rendered = match render(k, job) {
                Err(RenderError::Cancelled) => bail!(self.stopped(k)),
                other => other?,
            };
            let tone = match tone {
                Some(tone) => tone,
                None => *tone.insert(self.pictures.tone(rendered.picture())?),
            };
            self.pictures.write(&rendered, &tone, k, talk)?;
            if let (0, Rendered::Shaded(shaded)) = (k, &rendered) {
                self.note_ringing(shaded.below_zero);
            }
            animate(rendered.picture(), &tone)?;
        }
        Ok(())
    }

    /// Notes where the picture is below zero because the expansion of the light rings.
    fn note_ringing(&self, below: f64) {
        // Less would be told as 0.00 %.
        if below >= 5e-5 {
            let text = format!(
                "{:.2} % of what is seen of the scene is below zero, because the light rings; --window, or a light from \
                 lobe sh dering, stops that",
                100.0 * below
            );
            self.talk.note(&self.pictures.name(), &text);
        }
    }

    /// The message when picture `k` was not finished: the files that are left.
    fn stopped(&self, k: usize) -> String {
        let frames = self.pictures.count();
        let complete = if frames > 1 { format!("after {k} of {frames} pictures") } else { "before the end".into() };
        match self.is_kept {
            true => format!("stopped {complete}; the same command goes on from there, --fresh starts anew"),
            _ if self.keeps_bakes => {
                format!("stopped {complete}; the same command starts with what is baked, --fresh anew")
            }
            _ if k > 0 => format!("stopped {complete}, which are kept; the same command starts anew"),
            _ => format!("stopped {complete}; nothing is kept, and the same command starts anew"),
        }
    }
}
