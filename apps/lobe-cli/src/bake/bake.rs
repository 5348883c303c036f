//! `lobe bake`: the transfer of a scene at its vertices, its texels, or points in space.

use std::fs;
use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use lobe::io::JobOptions as _;
use lobe::prt::{BakeFiles, BakeJob, Recipe};

use crate::args::job_args::{JobArgs, text_of, values_in};
use crate::args::output;
use crate::bake::report;
use crate::run::bake_watch::tell_if_too_late;
use crate::run::job_watch::watched_job;
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

/// Options that ask for what `--no-split` refuses.
const OF_SPLITTING: [&str; 3] = ["adaptive", "min_edge", "max_vertices"];

#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Args)]
#[command(after_help = NOTES)]
pub(crate) struct Bake {
    #[command(flatten)]
    options: JobArgs<BakeJob>,
    /// Take options from this file, TOML with the names of options and _ for -; those given beside it count more
    #[arg(long, value_name = "FILE", conflicts_with = "like", help_heading = "Jobs in files")]
    job: Option<PathBuf>,
    /// Take options from the recipe of a baked file; those given beside it count more. The scene is looked for in its
    /// folder unless SCENE says where it is
    #[arg(long, value_name = "BAKED", help_heading = "Jobs in files")]
    like: Option<PathBuf>,
    /// Print the job on stdout, as --job reads it, and do nothing else
    #[arg(long, help_heading = "Jobs in files")]
    print_job: bool,
    /// Print {"vertices", "triangles", "rays", "seconds", "stderr_dc", "points", "samples", "bounces",
    /// "energy_per_bounce", "energy_left"} on stdout, of compressed transfer also "compression": {"clusters",
    /// "components", "bytes", "ratio", "relative_error"}; with --shard {"shard", "points", "points_in_all", "seconds"}
    #[arg(long)]
    json: bool,
}

impl Bake {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let job = self.job()?;
        if self.print_job {
            return output::print(&text_of(&job)?);
        }
        let files = BakeFiles::of(&job)?;
        // A user knows nothing of what is made of shards on the way.
        let kept = job.merge.is_none().then(|| files.checkpoint());
        let done = watched_job(talk, kept, |work| job.run(work))?;
        tell_if_too_late(files.output(), talk);
        self.tell_of_another_scene(&files, talk)?;
        report::tell(&job, &done, self.json, talk)
    }

    /// Says that what was baked like another file is of another scene.
    fn tell_of_another_scene(&self, files: &BakeFiles, talk: Talk) -> anyhow::Result<()> {
        let Some(like) = self.like.as_ref().filter(|_| self.options.values.get("shard").is_none()) else {
            return Ok(());
        };
        if Recipe::of_file(like)?.scene_hash != Recipe::of_file(files.output())?.scene_hash {
            let text = format!("is of another scene than {}, or of other vertices of it", like.display());
            talk.note(&files.output().display().to_string(), &text);
        }
        Ok(())
    }

    /// What is asked for: by a file, by the recipe of another bake, and by options.
    fn job(&self) -> anyhow::Result<BakeJob> {
        let begun = match (&self.job, &self.like) {
            (Some(path), _) => {
                let text = fs::read_to_string(path).map_err(|source| lobe::io::IoError::io(path, source))?;
                values_in(&text, &path.display().to_string())?
            }
            (None, Some(path)) => BakeJob::like(path)?.values(),
            (None, None) => return Ok(self.with_paths(self.options.job()?)),
        };
        let mut begun = begun;
        // What is asked for here takes the place of its contrary there.
        if OF_SPLITTING.iter().any(|name| self.options.values.contains_key(*name)) {
            begun.remove("no_split");
        }
        let from = self.job.as_ref().or(self.like.as_ref());
        let place = from.map_or_else(String::new, |path| path.display().to_string());
        let job =
            self.options.job_over(begun).map_err(|error| match self.options.values.contains_key(&error.option) {
                true => error.into(),
                false => anyhow!("{place}: {error}"),
            })?;
        Ok(self.with_paths(job))
    }

    /// A job with the paths that were given, which need not be text.
    fn with_paths(&self, mut job: BakeJob) -> BakeJob {
        job.source.scene = self.options.path("scene").unwrap_or(job.source.scene);
        job.output = self.options.path("output").or(job.output);
        job.merge = self.options.paths("merge").or(job.merge);
        job
    }
}
