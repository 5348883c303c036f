//! Progress of a resampling: rows of the target, counted in each pass over them.

use lobe_io::{Job, Progress};
use web_time::Instant;

use crate::error::EnvError;

/// The passes that every map takes: one for samples, one for energies, one for the texels.
const LEAST_PASSES: usize = 3;

/// The rows that are done in all passes, and who watches them.
pub(crate) struct Passes<'a> {
    job: Job<'a>,
    start: Instant,
    /// The rows of a pass.
    rows: usize,
    done: usize,
    total: usize,
}

impl<'a> Passes<'a> {
    /// Before the first pass.
    ///
    /// # Errors
    /// [`EnvError::Options`] for a job with a checkpoint, [`EnvError::Cancelled`] if it was told to stop.
    pub(crate) fn new(job: Job<'a>, rows: usize) -> Result<Self, EnvError> {
        job.expect_no_checkpoint().map_err(EnvError::Options)?;
        let mut passes = Self { job, start: Instant::now(), rows, done: 0, total: LEAST_PASSES * rows };
        passes.did(0)?;
        Ok(passes)
    }

    /// Another pass begins, beyond those that every map takes.
    pub(crate) fn another(&mut self) {
        self.total += self.rows;
    }

    /// Further rows are done.
    ///
    /// # Errors
    /// [`EnvError::Cancelled`] if the job was told to stop.
    pub(crate) fn did(&mut self, rows: usize) -> Result<(), EnvError> {
        self.done += rows;
        let (done, total, elapsed) = (self.done, self.total, self.start.elapsed());
        let go_on = self.job.report(&Progress { done, total, elapsed, ..Progress::default() });
        if go_on.is_break() { Err(EnvError::Cancelled) } else { Ok(()) }
    }

    /// All is done.
    pub(crate) fn finish(mut self) -> Result<(), EnvError> {
        self.did(self.total - self.done)
    }
}
