//! Running a command: notes and progress, Ctrl-C, checkpoints, and the message when it fails.
//!
//! `batch` makes a line of each of several files. `talk` speaks to the user, `ctrl_c` listens. `bake_watch` watches
//! long work and keeps its checkpoint, `job_watch` does so for work in several steps. `option_names` are those of the
//! command line. `failure` turns errors into one line and an exit code, `system` refused memory and a closed stdout.
//! Uses no other room.

pub(crate) mod bake_watch;
pub(crate) mod batch;
pub(crate) mod ctrl_c;
pub(crate) mod failure;
pub(crate) mod job_watch;
pub(crate) mod option_names;
pub(crate) mod system;
pub(crate) mod talk;

/// The exit code for every error, and for work that was stopped by Ctrl-C.
pub(crate) const ERROR: u8 = 2;
