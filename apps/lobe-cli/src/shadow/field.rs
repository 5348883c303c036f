//! `lobe field`: the occlusion field of an entity, for shadows that it casts wherever it moves.

use std::time::Instant;

use clap::Args;
use lobe::shadow::{FieldDone, FieldJob, StorageReport};

use crate::args::asked_job::AskedJob;
use crate::args::{output, sharing};
use crate::run::bake_watch::tell_if_too_late;
use crate::run::job_watch::{Kept, watched_job};
use crate::run::talk::Talk;

#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Args)]
pub(crate) struct Field {
    #[command(flatten)]
    asked: AskedJob<FieldJob>,
    /// Print {"points", "inside", "rays", "storage": {"bytes", "bytes_before", "relative_error", "largest_error"}} on
    /// stdout; with --self-visibility "vertices" instead of the first two; with --shard {"shard", "points",
    /// "points_in_all", "seconds"}
    #[arg(long)]
    json: bool,
}

impl Field {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let Some(job) = self.asked.job()? else { return Ok(()) };
        let (files, begin) = (job.sharing.files(job.output.as_deref())?, Instant::now());
        let kept = if job.sharing.merge.is_some() { Kept::Untold } else { Kept::In(files.checkpoint()) };
        let done = watched_job(talk, kept, |work| job.run(work))?;
        if let FieldDone::Shard { shard, points, points_in_all } = done {
            let (shard, seconds) = (shard.to_string(), begin.elapsed().as_secs_f64());
            return sharing::Done { shard, points, points_in_all, seconds }.tell(files.output(), self.json, talk);
        }
        tell_if_too_late(files.output(), talk);
        if self.json { output::print_json(&done) } else { output::print(&text(&done)) }
    }
}

fn text(done: &FieldDone) -> String {
    match done {
        FieldDone::Field { points, inside, rays, storage } => {
            let storage = text_of_storage(storage);
            format!("sample points   {points}, {inside} inside the solid\nrays            {rays}\n{storage}")
        }
        FieldDone::Visibility { vertices, rays, storage } => {
            format!("vertices        {vertices}\nrays            {rays}\n{}", text_of_storage(storage))
        }
        _ => String::new(),
    }
}

fn text_of_storage(storage: &StorageReport) -> String {
    format!("bytes           {}\nrelative error  {:.3e} of storage\n", storage.bytes, storage.relative_error)
}
