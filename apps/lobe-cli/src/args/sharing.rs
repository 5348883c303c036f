//! Report of a shard of long work.

use std::path::Path;

use serde::Serialize;

use crate::args::output;
use crate::run::talk::Talk;

/// A shard that is done, and its JSON.
#[derive(Serialize)]
pub(crate) struct Done {
    pub(crate) shard: String,
    /// Receivers, sample points or pixels.
    pub(crate) points: usize,
    pub(crate) points_in_all: usize,
    pub(crate) seconds: f64,
}

impl Done {
    /// Says what a shard has, as JSON or in words.
    pub(crate) fn tell(&self, output: &Path, as_json: bool, talk: Talk) -> anyhow::Result<()> {
        if as_json {
            return output::print_json(self);
        }
        let Self { shard, points, points_in_all, seconds } = self;
        talk.note(
            &output.display().to_string(),
            &format!(
                "shard {shard}: {points} of {points_in_all} points in {seconds:.1} s; --merge puts all shards together"
            ),
        );
        Ok(())
    }
}
