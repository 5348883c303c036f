//! Writing of results from a checkpoint to their file, with progress and Ctrl-C.

use std::cell::RefCell;
use std::error::Error;
use std::time::Instant;
use std::{fmt, io};

use anyhow::bail;
use lobe::io::{Job, Progress};
use lobe::prt::{Channels, MatrixRows, PrtError, TransferRows};

use crate::run::bake_watch::{GO_ON, watched};
use crate::run::ctrl_c;
use crate::run::talk::Talk;

/// Transfer or matrices that are watched while they are read: Ctrl-C ends the writing.
pub(crate) struct WatchedRows<'a, T: ?Sized> {
    rows: &'a T,
    state: RefCell<State<'a>>,
}

struct State<'a> {
    read: usize,
    begin: Instant,
    job: Job<'a>,
}

/// The refusal of rows after Ctrl-C.
#[derive(Debug)]
struct Stopped;

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("stopped")
    }
}

impl Error for Stopped {}

impl<T: ?Sized> WatchedRows<'_, T> {
    fn count(&self, read: usize, total: usize) -> io::Result<()> {
        let mut state = self.state.borrow_mut();
        // Some outputs take more than one look at a row.
        state.read = (state.read + read).min(total);
        let progress = Progress { done: state.read, total, elapsed: state.begin.elapsed(), ..Progress::default() };
        if state.job.report(&progress).is_break() { Err(io::Error::other(Stopped)) } else { Ok(()) }
    }
}

macro_rules! watched_rows {
    ($rows:ident, $count:ident) => {
        impl<T: $rows + ?Sized> $rows for WatchedRows<'_, T> {
            fn order(&self) -> usize {
                self.rows.order()
            }

            fn channels(&self) -> Channels {
                self.rows.channels()
            }

            fn $count(&self) -> usize {
                self.rows.$count()
            }

            fn read_rows(&self, first: usize, rows: &mut [f32]) -> io::Result<()> {
                self.count(rows.len() / self.row_len(), self.$count())?;
                self.rows.read_rows(first, rows)
            }
        }
    };
}

watched_rows!(TransferRows, receivers);
watched_rows!(MatrixRows, points);

/// Writes rows with a line of progress. Ctrl-C ends it, and leaves the checkpoint and no output.
pub(crate) fn write_watched<T: ?Sized>(
    rows: &T,
    talk: Talk,
    write: impl FnOnce(&WatchedRows<'_, T>) -> Result<(), PrtError>,
) -> anyhow::Result<()> {
    watched(talk, "write", |job| write_rows(rows, job, write))?.or_else(|_| stopped())
}

fn write_rows<T: ?Sized>(
    rows: &T,
    mut job: Job<'_>,
    write: impl FnOnce(&WatchedRows<'_, T>) -> Result<(), PrtError>,
) -> Result<(), PrtError> {
    let state = State { read: 0, begin: Instant::now(), job: job.reborrow() };
    match write(&WatchedRows { rows, state: RefCell::new(state) }) {
        Err(PrtError::Io { source, .. }) if matches!(source.get_ref(), Some(inner) if inner.is::<Stopped>()) => {
            Err(PrtError::Cancelled)
        }
        other => other,
    }
}

/// The error when the bake is done, but the work after it was stopped.
pub(crate) fn stopped<T>() -> anyhow::Result<T> {
    bail!("stopped after the bake, before its output was written; {GO_ON}")
}

/// Ends a command whose bake is done if the user has pressed Ctrl-C, before an output that takes no time to write.
pub(crate) fn stop_before_writing() -> anyhow::Result<()> {
    if ctrl_c::go_on().is_break() { stopped() } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::ops::ControlFlow;

    use lobe::prt::{Recipe, Transfer, TransferMatrices, write_matrices, write_transfer};

    use super::*;

    #[test]
    fn whoever_stops_while_rows_are_written_gets_no_file_and_nobody_else_loses_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.safetensors");
        // Several times what is read at once.
        let numbers: Vec<f32> = (0..3 << 20).map(|i| i as f32).collect();
        let transfer = Transfer::new(1, Channels::Gray, numbers.clone()).unwrap();
        let matrices = TransferMatrices::new(1, Channels::Gray, numbers).unwrap();
        for stop_at in [1, 2, 3, 4] {
            for is_transfer in [true, false] {
                let mut calls = Vec::new();
                let watch = &mut |progress: &Progress| {
                    calls.push(progress.done);
                    if calls.len() == stop_at { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
                };
                let job = Job::default().watched_by(watch);
                let written = match is_transfer {
                    true => write_rows(&transfer, job, |rows| write_transfer(&path, rows, &Recipe::default())),
                    false => write_rows(&matrices, job, |rows| write_matrices(&path, rows, &Recipe::default())),
                };
                let is_stopped = matches!(written, Err(PrtError::Cancelled));
                assert_eq!(is_stopped, stop_at < 4, "{written:?}, stopped at call {stop_at}");
                assert_eq!(calls, [1 << 20, 2 << 20, 3 << 20][..stop_at.min(3)], "rows read at each call");
                assert_eq!(fs::read_dir(folder.path()).unwrap().count(), usize::from(!is_stopped), "files");
                let _ = fs::remove_file(&path);
            }
        }
    }
}
