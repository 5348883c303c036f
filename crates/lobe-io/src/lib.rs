//! Long work and its results on disk: what several crates of Lobe need for running, stopping and keeping it.
//!
//! | to | use |
//! |---|---|
//! | write a file all or nothing | [`write_atomically`]; piece by piece [`StagedWriter`]; several at once [`StagedFile`] |
//! | watch, stop and continue long work | [`Job`], [`Progress`] |
//! | learn before long work whether its result can be written | [`check_writable`] |

mod job;
mod staged;

pub use job::{Job, Progress, Watch};
pub use staged::{StagedFile, StagedWriter, check_writable, write_atomically};
