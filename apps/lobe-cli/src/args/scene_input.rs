//! Scenes as inputs: files and built-in scenes.

use std::path::Path;

use anyhow::bail;
use clap::{ArgMatches, Args, Command, FromArgMatches};
use lobe::io::JobArgs;
use lobe::scene::SceneSource;
use serde_json::Value;

use crate::args::scene_pose::PoseInput;

/// Where a scene is, and how it is read.
pub(crate) struct SceneInput {
    asked: JobArgs<SceneSource>,
    source: SceneSource,
    pub(crate) pose: PoseInput,
}

impl FromArgMatches for SceneInput {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let asked = JobArgs::<SceneSource>::from_arg_matches(matches)?;
        // Options that exclude each other are refused when the scene is opened.
        let mut source: SceneSource = serde_json::from_value(Value::Object(asked.values.clone())).unwrap_or_default();
        source.scene = asked.path("scene").unwrap_or_default();
        let pose = PoseInput { time: source.time, animation: source.animation.clone() };
        Ok(Self { asked, source, pose })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for SceneInput {
    fn augment_args(command: Command) -> Command {
        JobArgs::<SceneSource>::augment_args(command)
            .mut_arg("scene", |scene| scene.required(true))
            .mut_arg("time", |time| time.hide_short_help(false))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl SceneInput {
    pub(crate) fn name(&self) -> String {
        self.source.name()
    }

    /// The file, or the name of a built-in scene with its prefix.
    pub(crate) fn path(&self) -> &Path {
        &self.source.scene
    }

    /// Whether the scene is one of the program that moves.
    pub(crate) fn is_built_in_motion(&self) -> bool {
        self.source.is_built_in_motion()
    }

    /// Whether the scene is read from a glTF file.
    pub(crate) fn is_gltf(&self) -> bool {
        self.source.is_gltf()
    }

    /// The scene and how it is read, without options that would be ignored.
    pub(crate) fn source(&self) -> anyhow::Result<SceneSource> {
        let mut source = self.asked.job()?;
        source.scene.clone_from(&self.source.scene);
        Ok(source)
    }

    /// Refuses times of scenes that stand still.
    pub(crate) fn expect_no_time_unless_gltf(&self) -> anyhow::Result<()> {
        match self.pose.asked().filter(|_| !self.is_gltf()) {
            Some(option) => bail!("{option}: only what a glTF file moves stands elsewhere then; leave the option out"),
            None => Ok(()),
        }
    }

    pub(crate) fn has_extension(&self, extensions: &[&str]) -> bool {
        self.source.has_extension(extensions)
    }
}
