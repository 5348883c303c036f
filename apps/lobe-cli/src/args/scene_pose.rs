//! Pose of a scene whose file moves: `--time` and `--animation`.

use clap::Args;
use lobe::scene::ScenePose;

use crate::args::values;

/// A time of an animation.
#[derive(Args)]
pub(crate) struct PoseInput {
    /// Take a glTF file that moves, by animations, skins or morph targets, as it stands at this time; of lobe render
    /// also a scene description (.json) and the built-in scenes that move [default: 0]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = values::finite)]
    pub(crate) time: Option<f64>,
    /// The animation of a glTF file, by name or number [default: the first]
    #[arg(long, value_name = "NAME")]
    pub(crate) animation: Option<String>,
}

impl PoseInput {
    /// The first option that is given.
    pub(crate) fn asked(&self) -> Option<&'static str> {
        let time = self.time.map(|_| "--time");
        time.or(self.animation.as_ref().map(|_| "--animation"))
    }

    /// The pose that is asked for.
    pub(crate) fn pose(&self) -> ScenePose {
        ScenePose::asked(self.animation.clone(), self.time)
    }

    /// The time that is asked for, or else the beginning.
    pub(crate) fn seconds(&self) -> f64 {
        self.time.unwrap_or(0.0)
    }
}
