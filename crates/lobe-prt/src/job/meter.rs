//! Progress meter of a search that may end before its last step, or of a file while it is written.

use std::io;

use lobe_io::{IoError, Job, Progress};
use web_time::Instant;

use crate::error::PrtError;

/// Reports the progress of a search and remembers whether it is to stop. A search that was stopped comes to its end
/// without further work; what it has found is of no use.
pub(crate) struct Meter<'a> {
    job: Job<'a>,
    done: usize,
    total: usize,
    begin: Instant,
    is_stopped: bool,
}

impl<'a> Meter<'a> {
    /// The meter of a search of at most `total` steps.
    ///
    /// # Errors
    /// [`PrtError::Options`] if the job has a checkpoint: a search cannot be resumed.
    pub(crate) fn new(total: usize, job: Job<'a>) -> Result<Self, PrtError> {
        job.expect_no_checkpoint().map_err(PrtError::Options)?;
        let mut meter = Self { job, done: 0, total, begin: Instant::now(), is_stopped: false };
        meter.reach(0);
        Ok(meter)
    }

    /// The number of steps that are done or were left out.
    pub(crate) fn done(&self) -> usize {
        self.done
    }

    /// Counts further steps as done.
    pub(crate) fn step(&mut self, steps: usize) {
        self.reach(self.done + steps);
    }

    /// Counts all steps up to `done` as done: they are, or need not be done any more.
    pub(crate) fn reach(&mut self, done: usize) {
        self.done = done.clamp(self.done, self.total);
        let progress =
            Progress { done: self.done, total: self.total, elapsed: self.begin.elapsed(), ..Progress::default() };
        self.is_stopped |= self.job.report(&progress).is_break();
    }

    pub(crate) fn is_stopped(&self) -> bool {
        self.is_stopped
    }

    /// # Errors
    /// [`PrtError::Cancelled`] if the search is to stop.
    pub(crate) fn go_on(&self) -> Result<(), PrtError> {
        if self.is_stopped { Err(PrtError::Cancelled) } else { Ok(()) }
    }

    /// [`Meter::go_on`] while a file is written, which is given up by an error of the system.
    pub(crate) fn go_on_writing(&self) -> io::Result<()> {
        self.go_on().map_err(io::Error::other)
    }

    /// The outcome of a file that was written: one that was complete before it was to stop is there.
    pub(crate) fn written(&self, written: Result<(), IoError>) -> Result<(), PrtError> {
        written.map_err(|error| if self.is_stopped { PrtError::Cancelled } else { error.into() })
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;

    #[test]
    fn steps_never_go_back_nor_past_the_end_and_a_stop_is_remembered() {
        let mut seen = Vec::new();
        let mut watch = |progress: &Progress| {
            seen.push(progress.done);
            if progress.done == 7 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let mut meter = Meter::new(10, Job::default().watched_by(&mut watch)).unwrap();
        meter.step(7);
        meter.reach(3);
        meter.step(2);
        assert_eq!((meter.done(), meter.is_stopped()), (9, true), "stopped at 7");
        meter.step(5);
        assert_eq!(seen, [0, 7, 7, 9, 10], "steps told");
    }
}
