//! The times of the pictures of `lobe render`, of a scene that moves.

use anyhow::bail;
use clap::Args;
use lobe::image::AnimatedPng;
use lobe::motion::MovingScene;

use crate::args::scene_pose::PoseInput;
use crate::args::values;
use crate::render::pictures::Pictures;
use crate::run::talk::Talk;

/// Pictures for each second of `--frames A..B`, as films have.
const FRAMES_PER_SECOND: f64 = 24.0;

/// The fewest pictures for each second: the time of every picture is then a number.
const LEAST_FRAMES_PER_SECOND: f64 = 1e-300;

/// When pictures of a scene that moves are taken.
#[derive(Args, Default)]
pub(crate) struct TimeInput {
    /// With --frames A..B: pictures for each second, 1/65 to 1000 in an animated .png; at others, .exr pictures are
    /// written without it [default: 24]
    #[arg(long, value_name = "N", value_parser = frames_per_second, hide_short_help = true)]
    fps: Option<f64>,
    /// Begin anew when the animation or all tracks have ended; without this they rest there
    #[arg(long = "loop", hide_short_help = true)]
    pub(crate) is_looped: bool,
}

fn frames_per_second(text: &str) -> Result<f64, String> {
    match values::positive(text)? {
        few if few < LEAST_FRAMES_PER_SECOND => {
            Err(format!("expected {LEAST_FRAMES_PER_SECOND:e} pictures for each second at least, found {few:e}"))
        }
        fps => Ok(fps),
    }
}

impl TimeInput {
    /// Whether an option asks for a scene that moves; its name for messages.
    pub(crate) fn asked(&self) -> Option<&'static str> {
        self.fps.map(|_| "--fps").or(self.is_looped.then_some("--loop"))
    }

    /// Refuses options that contradict each other.
    pub(crate) fn check(&self, pose: &PoseInput, pictures: &Pictures) -> anyhow::Result<()> {
        let has_range = pictures.is_range();
        if has_range && pose.time.is_some() {
            bail!("--time: --frames A..B says the times; leave one of them out");
        }
        if self.fps.is_some() && !has_range {
            bail!("--fps: only of --frames A..B; leave the option out");
        }
        if let Some(fps) = self.fps
            && pictures.is_png()
            && self.seconds_in_animation().is_none()
        {
            let shown = AnimatedPng::<Vec<u8>>::SECONDS;
            bail!(
                "--fps: an animated .png shows each picture for {} to {} seconds, found {fps:?} pictures for each second; \
                 give another number, or -o FILE.exr",
                shown.start(),
                shown.end()
            );
        }
        Ok(())
    }

    /// The time of a picture, in seconds: of frame `frame` of a range, else the one that was asked for.
    pub(crate) fn time_of(&self, pose: &PoseInput, frame: Option<usize>) -> f64 {
        match frame {
            Some(frame) => frame as f64 * self.seconds_per_frame(),
            None => pose.seconds(),
        }
    }

    /// The time from one picture of a range to the next.
    fn seconds_per_frame(&self) -> f64 {
        self.fps.unwrap_or(FRAMES_PER_SECOND).recip()
    }

    /// The same in an animation; none if that cannot show pictures for so short or so long.
    pub(crate) fn seconds_in_animation(&self) -> Option<f64> {
        Some(self.seconds_per_frame()).filter(|seconds| AnimatedPng::<Vec<u8>>::SECONDS.contains(seconds))
    }

    /// Notes which pictures show what has come to its end.
    pub(crate) fn note_end(&self, moving: &MovingScene, times: &[f64], name: &str, talk: Talk) {
        let [begin, end] = moving.span();
        if self.is_looped || begin >= end {
            return;
        }
        match times.iter().position(|time| *time >= end) {
            Some(first) if times.len() == 1 => {
                if times[first] == end {
                    return;
                }
                talk.note(name, &format!("has come to its end at {end:.3} s and rests there; --loop begins anew"));
            }
            Some(first) if first + 1 < times.len() => {
                let alike = times.len() - first;
                let text =
                    format!("comes to its end at {end:.3} s: the last {alike} pictures are alike; --loop begins anew");
                talk.note(name, &text);
            }
            _ => {}
        }
    }
}
