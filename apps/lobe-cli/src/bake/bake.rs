//! `lobe bake`: the transfer of a scene at its vertices, its texels, or points in space.

use std::path::PathBuf;

use clap::Args;
use lobe::io::{JobFiles, JobOptions as _};
use lobe::prt::{BakeJob, Recipe};

use crate::args::asked_job::AskedJob;
use crate::bake::report;
use crate::run::bake_watch::tell_if_too_late;
use crate::run::job_watch::{Kept, watched_job};
use crate::run::talk::Talk;

const NOTES: &str = "\
Stopping: results are kept in OUT.checkpoint, those of splitting in OUT.checkpoint.split-0, -1 and so on. Ctrl-C (or \
SIGTERM, SIGHUP) ends the bake with exit code 2 and leaves these files, and so does whatever kills it, at a cost of at \
most 10 s of rays. The same command reads the scene, splits it where that is known already, and goes on from there, to \
the same bytes; at the end the files are removed. Compression begins anew.

Disk: 12 n² bytes for each triangle and channel, taken from the start, and 4 n² for each vertex and channel of the \
output; n⁴ instead of n² of --mode glossy; of --texels and --grid twice the output.

Memory: 20 MB, and at vertices 2200 bytes for each of the scene once split, or, if that is more, 1250 and 20 n² for \
each channel; of --mode glossy 4 n⁴ for each channel, and up to 0.8 GB beside. Compression takes twice 4 n² bytes for \
each vertex and channel. --texels takes 820 bytes for each vertex and 105 for each texel, and 12 n² for each channel, \
as .exr 20 n²; unwrapping takes 1000 bytes for each triangle.";

#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Args)]
#[command(after_help = NOTES)]
pub(crate) struct Bake {
    #[command(flatten)]
    asked: AskedJob<BakeJob>,
    /// Take options from the recipe of a baked file; those given beside it count more. The scene is looked for in its
    /// folder unless SCENE says where it is
    #[arg(long, value_name = "BAKED", conflicts_with = "job", help_heading = "Jobs in files")]
    like: Option<PathBuf>,
    /// Print {"vertices", "triangles", "rays", "seconds", "stderr_dc", "points", "samples", "bounces",
    /// "energy_per_bounce", "energy_left"} on stdout, of compressed transfer also "compression": {"clusters",
    /// "components", "bytes", "ratio", "relative_error"}; with --shard {"shard", "points", "points_in_all", "seconds"}
    #[arg(long)]
    json: bool,
}

impl Bake {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let asked = match &self.like {
            Some(path) => self.asked.job_over(&BakeJob::like(path)?.values(), &path.display().to_string())?,
            None => self.asked.job()?,
        };
        let Some(job) = asked else { return Ok(()) };
        let files = job.files()?;
        // A user knows nothing of what is made of shards on the way.
        let kept = if job.sharing.merge.is_some() { Kept::Untold } else { Kept::In(files.checkpoint()) };
        let done = watched_job(talk, kept, |work| job.run(work))?;
        tell_if_too_late(files.output(), talk);
        self.tell_of_another_scene(&files, talk)?;
        report::tell(&job, &done, self.json, talk)
    }

    /// Says that what was baked like another file is of another scene.
    fn tell_of_another_scene(&self, files: &JobFiles, talk: Talk) -> anyhow::Result<()> {
        let Some(like) = self.like.as_ref().filter(|_| self.asked.options.values.get("shard").is_none()) else {
            return Ok(());
        };
        if Recipe::of_file(like)?.scene_hash != Recipe::of_file(files.output())?.scene_hash {
            let text = format!("is of another scene than {}, or of other vertices of it", like.display());
            talk.note(&files.output().display().to_string(), &text);
        }
        Ok(())
    }
}
