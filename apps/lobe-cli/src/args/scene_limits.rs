//! Limits of what a scene's file may hold.

use clap::{ArgMatches, Args, Command, FromArgMatches};
use lobe::io::option;
use lobe::scene::{SceneReadOptions, SceneSource};
use serde_json::Value;

use crate::args::memory::MemoryLimit;

/// `--max-triangles` and `--max-texels`, as of a scene.
pub(crate) struct SceneLimits {
    max_triangles: Option<usize>,
    max_texels: Option<usize>,
}

impl FromArgMatches for SceneLimits {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = |name: &str| matches.get_one::<Value>(name).and_then(Value::as_u64).map(|most| most as usize);
        Ok(Self { max_triangles: given("max_triangles"), max_texels: given("max_texels") })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for SceneLimits {
    fn augment_args(command: Command) -> Command {
        command.args(["max_triangles", "max_texels"].into_iter().filter_map(option::<SceneSource>))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl SceneLimits {
    /// The first option that is given: for what is no scene's file.
    pub(crate) fn given(&self) -> Option<&'static str> {
        let triangles = self.max_triangles.map(|_| "--max-triangles");
        triangles.or(self.max_texels.map(|_| "--max-texels"))
    }

    /// The options of reading within these limits.
    pub(crate) fn options(&self, memory: &MemoryLimit) -> SceneReadOptions {
        let options = SceneReadOptions::default().max_bytes(memory.bytes());
        let (triangles, texels) = (options.max_triangles, options.max_texels);
        options.max_triangles(self.max_triangles.unwrap_or(triangles)).max_texels(self.max_texels.unwrap_or(texels))
    }
}
